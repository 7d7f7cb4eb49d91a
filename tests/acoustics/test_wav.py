"""A WAV file has the right bytes and gives its record back."""

import io
import math
import struct
import time

import numpy as np
import pytest
import soundfile

from acoustics import wav
from acoustics.level import a_weighted_rms, laeq_db
from acoustics.radiation import P_REF_PA

NOISE = 0.05 * np.random.default_rng(1).standard_normal(24000)  # 68 dB


def samples_of(wav_bytes):
    """Return the samples of a file in parts of full scale, its comment and its title."""
    with soundfile.SoundFile(io.BytesIO(wav_bytes)) as file:
        assert (file.samplerate, file.channels) == (48000, 1)
        return file.read(dtype="float64"), file.comment, file.title


def test_calibrated_file_gives_the_same_level(tmp_path):
    path = tmp_path / "signal.wav"
    path.write_bytes(wav.calibrated(NOISE, "1.0 = 1 Pa; 20 N, 0.1 m/s, µ", "a title"))
    samples, rate, comment = wav.read(path)
    assert (rate, comment) == (48000, "1.0 = 1 Pa; 20 N, 0.1 m/s, µ")
    # asked; float32 rounds by 1e-7
    assert laeq_db(samples, rate) == pytest.approx(laeq_db(NOISE, 48000), abs=1e-4)
    # half a unit in the last place of 24 bits
    np.testing.assert_allclose(samples, NOISE, rtol=6e-8)
    assert samples_of(path.read_bytes())[2] == "a title"


@pytest.mark.parametrize("bits", [16, 24])
def test_listening_file_gives_the_level_less_its_gain(bits):
    gain = wav.listening_gain(NOISE)
    samples, comment, title = samples_of(wav.listening(NOISE, gain, "gain stated", "a title", bits))
    # At -23 dB, rounding noise lies 120 (24 bits) or 78 dB below and cannot move the level by 1e-4
    # dB.
    assert laeq_db(samples / gain, 48000) == pytest.approx(laeq_db(NOISE, 48000), abs=1e-4)
    assert (comment, title) == ("gain stated", "a title")


@pytest.mark.parametrize(("bits", "floor_db"), [(16, -101.1), (24, -149.3)])
def test_rounding_is_to_the_nearest_and_as_noisy_as_said(bits, floor_db):
    record = np.clip(0.2 * np.random.default_rng(2).standard_normal(48000), -1.0, 1.0)
    error = samples_of(wav.listening(record, 1.0, "", "", bits))[0] - record
    assert np.max(np.abs(error)) <= 2.0**-bits  # half a step of 2**(1 - bits)
    # Uniform: LSB/sqrt(12). Of 48000 errors the mean square is known to 0.4 %, the mean to
    # 1/sqrt(48000) of the rms.
    assert 10.0 * np.log10(np.mean(error**2)) == pytest.approx(floor_db, abs=0.1)
    # rounding down: 1.7 rms
    assert abs(np.mean(error)) < 4.0 / math.sqrt(48000.0) * np.sqrt(np.mean(error**2))
    edge = samples_of(wav.listening(np.array([1.0, -1.0, 0.0]), 1.0, "", "", bits))[0]
    assert np.array_equal(edge, [1.0 - 2.0 ** (1 - bits), -1.0, 0.0])


def test_same_record_same_bytes_at_another_second():
    def write():
        return wav.calibrated(NOISE, "same", "title"), wav.listening(NOISE, 1.0, "same", "title")

    first = write()
    second = int(time.time())
    while int(time.time()) == second:  # libsndfile's time stamp counts seconds
        time.sleep(0.02)
    assert write() == first
    # PEAK is followed by its size (16), its version (1) and the second of writing.
    place = first[0].index(b"PEAK")
    assert first[0][place + 4 : place + 16] == bytes([16, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0])


def chunks_of(wav_bytes):
    """Name and content of each chunk, read by the rules of RIFF alone."""
    assert wav_bytes[:4] == b"RIFF" and wav_bytes[8:12] == b"WAVE"
    assert struct.unpack("<I", wav_bytes[4:8])[0] == len(wav_bytes) - 8
    chunks = []
    place = 12
    while place < len(wav_bytes):
        name = wav_bytes[place : place + 4]
        (size,) = struct.unpack("<I", wav_bytes[place + 4 : place + 8])
        chunks.append((name, wav_bytes[place + 8 : place + 8 + size]))
        place += 8 + size + size % 2
    assert place == len(wav_bytes)
    return chunks


@pytest.mark.parametrize("samples", [24000, 24001, 1])
@pytest.mark.parametrize("bits", [16, 24, 32])
def test_a_record_that_loops_has_its_loop_points(bits, samples):
    """The sampler chunk has nine numbers, then a loop from the first to the last sample."""
    record = NOISE[np.arange(samples) % len(NOISE)]

    def write(loops):
        if bits == 32:
            return wav.calibrated(record, "a comment", "a title", loops)
        return wav.listening(record, 1.0, "a comment", "a title", bits, loops)

    *others, (name, content) = chunks_of(write(True))
    assert name == b"smpl" and len(content) == 60
    assert others == chunks_of(write(False)) and b"smpl" not in dict(others)
    sampler = content[:36]
    loop = content[36:]
    expected = {0: 0, 4: 0, 8: 20833, 12: 60, 16: 0, 20: 0, 24: 0, 28: 1, 32: 0}
    assert {at: int.from_bytes(sampler[at : at + 4], "little") for at in expected} == expected
    # Identifier, forward, first and last sample, no fraction, for ever.
    assert loop == struct.pack("<6I", 0, 0, 0, samples - 1, 0, 0)
    again, comment, title = samples_of(write(True))
    assert np.array_equal(again, samples_of(write(False))[0]) and len(again) == samples
    assert (comment, title) == ("a comment", "a title")


def test_clipping_is_refused():
    record = np.array([0.0, 0.5, -0.8])
    with pytest.raises(ValueError) as error:
        wav.listening(record, 2.0, "")
    assert (
        str(error.value)
        == "a gain of 2 per Pa drives the peak to 1.6 of full scale; the largest that fits is 1.25"
    )
    # As it says; one unit of 24 bits.
    np.testing.assert_allclose(
        samples_of(wav.listening(record, 1.25, ""))[0], 1.25 * record, atol=2.0**-23
    )


def test_listening_gain_reaches_its_target():
    weighted = a_weighted_rms(wav.listening_gain(NOISE) * NOISE, 48000)
    assert 20.0 * math.log10(weighted) == pytest.approx(-23.0, abs=1e-9)


def test_peak_wins_over_loudness():
    click = np.zeros(48000)
    click[100] = 1.0  # its rms is 47 dB below its peak
    assert wav.listening_gain(click) == pytest.approx(10.0 ** (-1.0 / 20.0), rel=1e-12)
    # inaudible
    assert wav.listening_gain(np.full(100, 2.0)) == pytest.approx(
        10.0 ** (-1.0 / 20.0) / 2.0, rel=1e-12
    )


def test_a_record_below_hearing_is_not_lifted_to_the_target():
    # -20 dB(A) plays 20 dB below the target, which 0 dB(A) just reaches: rounding of a silent
    # record stays inaudible.
    noise = NOISE / a_weighted_rms(NOISE, 48000)
    for level_db, reached_db in (
        (-300.0, -323.0),
        (-20.0, -43.0),
        (-1.0, -24.0),
        (0.0, -23.0),
        (10.0, -23.0),
    ):
        record = P_REF_PA * 10.0 ** (level_db / 20.0) * noise
        weighted = a_weighted_rms(wav.listening_gain(record) * record, 48000)
        assert 20.0 * math.log10(weighted) == pytest.approx(reached_db, abs=1e-6)
    # inaudible: nothing that A-weighting leaves
    assert wav.listening_gain(1e-12 * np.full(100, 1.0)) == wav.MAX_GAIN


@pytest.mark.parametrize(
    ("record", "comment", "words"),
    [
        (np.zeros(0), "", r"shape \(0,\)"),
        (np.zeros((3, 2, 1)), "", r"shape \(3, 2, 1\)"),
        (np.array([np.nan]), "", "not finite"),
        (np.zeros(3), "µ" * 1001, "comment takes 2002 bytes, at most 2000"),
    ],
)
def test_records_and_texts_that_do_not_fit_are_refused(record, comment, words):
    with pytest.raises(ValueError, match=words):
        wav.calibrated(record, comment)
    with pytest.raises(ValueError, match=words):
        wav.listening(record, 1.0, comment)
