"""Oracles: the record read back, and the bytes on disk."""

import math
import os
import time

import numpy as np
import pytest

from acoustics import wav
from acoustics.level import a_weighted_rms, laeq_db

NOISE = 0.05 * np.random.default_rng(1).standard_normal(24000)  # 68 dB


def test_calibrated_file_gives_the_same_level(tmp_path):
    path = tmp_path / "signal.wav"
    wav.write_calibrated(path, NOISE, "1.0 = 1 Pa; 20 N, 0.1 m/s, µ")
    samples, rate, comment = wav.read(path)
    assert (rate, comment) == (48000, "1.0 = 1 Pa; 20 N, 0.1 m/s, µ")
    assert laeq_db(samples, rate) == pytest.approx(laeq_db(NOISE, 48000), abs=1e-4)  # asked; float32 rounds by 1e-7
    np.testing.assert_allclose(samples, NOISE, rtol=6e-8)  # half a unit in the last place of 24 bits


def test_calibrated_file_may_exceed_full_scale(tmp_path):
    wav.write_calibrated(tmp_path / "loud.wav", np.array([40.0, -40.0]), "")
    assert np.array_equal(wav.read(tmp_path / "loud.wav")[0], [40.0, -40.0])


def test_listening_file_gives_the_level_less_its_gain(tmp_path):
    gain = wav.listening_gain(NOISE)
    wav.write_listening(tmp_path / "listen.wav", NOISE, gain, "gain stated")
    samples, rate, comment = wav.read(tmp_path / "listen.wav")
    # 24 bits at -23 dB: rounding noise lies 120 dB below and cannot move the level by 1e-4 dB.
    assert laeq_db(samples / gain, rate) == pytest.approx(laeq_db(NOISE, 48000), abs=1e-4)
    assert comment == "gain stated"


def test_same_record_same_bytes_at_another_second(tmp_path):
    def write():
        wav.write_calibrated(tmp_path / "signal.wav", NOISE, "same")
        wav.write_listening(tmp_path / "listen.wav", NOISE, 1.0, "same")
        return (tmp_path / "signal.wav").read_bytes(), (tmp_path / "listen.wav").read_bytes()

    first, second = write(), int(time.time())
    while int(time.time()) == second:  # libsndfile's time stamp counts seconds
        time.sleep(0.02)
    assert write() == first
    # PEAK is followed by its size (16), its version (1) and the second of writing.
    place = first[0].index(b"PEAK")
    assert first[0][place + 4 : place + 16] == bytes([16, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0])


def test_a_comment_that_spells_peak_is_left_alone(tmp_path):
    wav.write_calibrated(tmp_path / "a.wav", NOISE, "PEAK 12345678 PEAK")
    samples, _, comment = wav.read(tmp_path / "a.wav")
    assert comment == "PEAK 12345678 PEAK" and len(samples) == len(NOISE)


def test_clipping_is_refused(tmp_path):
    record = np.array([0.0, 0.5, -0.8])
    with pytest.raises(ValueError) as error:
        wav.write_listening(tmp_path / "clip.wav", record, 2.0, "")
    assert str(error.value) == "a gain of 2 per Pa drives the peak to 1.6 of full scale; the largest that fits is 1.25"
    assert list(tmp_path.iterdir()) == []
    wav.write_listening(tmp_path / "clip.wav", record, 1.25, "")  # as it says
    # One unit of 24 bits.
    np.testing.assert_allclose(wav.read(tmp_path / "clip.wav")[0], 1.25 * record, atol=2.0**-23)


def test_listening_gain_reaches_its_target():
    weighted = a_weighted_rms(wav.listening_gain(NOISE) * NOISE, 48000)
    assert 20.0 * math.log10(weighted) == pytest.approx(-23.0, abs=1e-9)


def test_peak_wins_over_loudness():
    click = np.zeros(48000)
    click[100] = 1.0  # its rms is 47 dB below its peak
    assert wav.listening_gain(click) == pytest.approx(10.0 ** (-1.0 / 20.0), rel=1e-12)
    assert wav.listening_gain(np.full(100, 2.0)) == pytest.approx(10.0 ** (-1.0 / 20.0) / 2.0, rel=1e-12)  # inaudible


def test_silence_is_written(tmp_path):
    assert wav.listening_gain(np.zeros(100)) == 1.0
    wav.write_listening(tmp_path / "silence.wav", np.zeros(100), 1.0, "")
    assert np.array_equal(wav.read(tmp_path / "silence.wav")[0], np.zeros(100))


def test_no_half_file_is_left_by_a_full_disk(tmp_path):
    resource = pytest.importorskip("resource")  # not on Windows
    path = tmp_path / "signal.wav"
    wav.write_calibrated(path, NOISE[:100], "the old one")
    before = path.read_bytes()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))  # the file needs 96 kB
    try:
        with pytest.raises(OSError):
            wav.write_calibrated(path, NOISE, "the new one")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert list(tmp_path.iterdir()) == [path] and path.read_bytes() == before


def test_no_half_file_is_left_by_an_interrupt(tmp_path, monkeypatch):
    def interrupted(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        wav.write_calibrated(tmp_path / "signal.wav", NOISE, "")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("record", "comment", "message"),
    [
        (np.zeros(0), "", "signal.wav: a record is a series of at least one sample, got shape (0,)"),
        (np.zeros((3, 2)), "", "signal.wav: a record is a series of at least one sample, got shape (3, 2)"),
        (np.array([np.nan]), "", "signal.wav: the record holds values that are not finite"),
        (np.zeros(3), "µ" * 1001, "signal.wav: the comment takes 2002 bytes, at most 2000 fit"),
    ],
)
def test_messages(tmp_path, record, comment, message):
    for write in (wav.write_calibrated, lambda *given: wav.write_listening(*given[:2], 1.0, given[2])):
        with pytest.raises(ValueError) as error:
            write(tmp_path / "signal.wav", record, comment)
        assert str(error.value) == message
    assert list(tmp_path.iterdir()) == []


def test_the_longest_comment_comes_back(tmp_path):
    wav.write_calibrated(tmp_path / "signal.wav", NOISE, "µ" * 1000)
    assert wav.read(tmp_path / "signal.wav")[2] == "µ" * 1000
