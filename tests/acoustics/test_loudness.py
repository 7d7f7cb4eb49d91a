"""Loudness meets the definitions of sone and acum: 1 kHz at 40 and 60 dB.

The program also says what to install where the package is missing.
"""

from __future__ import annotations

import numpy as np
import pytest

from acoustics.loudness import Loudness, VaryingLoudness, loudness, varying_loudness
from acoustics.loudness_steps import decayed, total
from acoustics.radiation import P_REF_PA
from acoustics.resampling import fade

RATE = 48000


def tone(level_db, n=24000, frequency_hz=1000.0):
    amplitude = P_REF_PA * 10.0 ** (level_db / 20.0) * np.sqrt(2.0)
    return amplitude * np.sin(2.0 * np.pi * frequency_hz * np.arange(n) / RATE)


@pytest.mark.parametrize(
    ("level_db", "sone"), [(40.0, 1.0), (50.0, 2.0), (60.0, 4.0), (80.0, 16.0)]
)
def test_1_khz_doubles_every_10_db_from_1_sone_at_40_db(level_db, sone):
    # ISO 532-1:2017 allows 5 %.
    assert loudness(tone(level_db), RATE, closed=True).sone == pytest.approx(sone, rel=0.05)


def test_narrow_noise_at_1_khz_and_60_db_has_1_acum():
    # DIN 45692: a critical band (160 Hz) about 1 kHz at 60 dB; it allows 5 %.
    frequency = np.fft.rfftfreq(2 * RATE, 1.0 / RATE)
    lines = np.fft.rfft(np.random.default_rng(1).standard_normal(2 * RATE)) * (
        np.abs(frequency - 1000.0) < 80.0
    )
    noise = np.fft.irfft(lines, 2 * RATE)
    noise *= P_REF_PA * 1e3 / np.sqrt(np.mean(noise**2))
    assert loudness(noise, RATE, closed=True).acum == pytest.approx(1.0, rel=0.05)


def test_a_loop_has_the_loudness_of_what_is_heard_of_it():
    long, short = (loudness(tone(60.0, n), RATE, closed=True).sone for n in (10 * RATE, 480))
    # Swinging in takes 0.2 s of 4 s at most: 2 %, and mosqito gives three digits.
    assert short == pytest.approx(long, rel=0.02)


def test_silence_and_what_has_no_loudness():
    assert loudness(np.zeros(4800), RATE, closed=True) == Loudness(0.0, None)
    # a steady pressure is not heard
    assert loudness(np.full(4800, 1.0), RATE, closed=True) == Loudness(0.0, None)
    # below the threshold of 2.4 dB
    assert loudness(tone(0.0), RATE, closed=True) == Loudness(0.0, None)
    # Zwicker's tables end at 120 dB in the low third octaves; ten samples that do not close are too
    # few for the filters.
    assert loudness(tone(130.0, frequency_hz=100.0), RATE, closed=True) == Loudness(None, None)
    assert loudness(tone(60.0, 10), RATE, closed=False) == Loudness(None, None)
    with pytest.raises(ValueError, match="got 44100, allowed: a sample rate of 48000 Hz or more"):
        loudness(tone(60.0), 44100.0, closed=True)
    with pytest.raises(ValueError, match="finite"):
        loudness(np.array([0.0, np.nan]), RATE, closed=True)


# ---- sounds that change in time


def burst(level_db, n):
    """Return a tone of 1 kHz that rises and falls in 2 ms, without a click."""
    return fade(tone(level_db, n), 96)


def test_decay_and_slopes_have_the_digits_of_mosqito():
    """Of bands that rise, fall, rest and knock, and of one that is silent."""
    from mosqito.sq_metrics.loudness.loudness_zwst import _calc_slopes
    from mosqito.sq_metrics.loudness.loudness_zwtv import _nonlinear_decay

    rng = np.random.default_rng(0)
    core = 0.05 * np.abs(np.cumsum(rng.standard_normal((21, 400)), axis=1))
    core[4:8] *= 20.0  # up to 20 sone/Bark
    core[5, ::3] = 0.0
    core[6, 50:] = 0.0
    core[7] = 3.0
    core[8] *= 1e-6
    core[9] = np.where(rng.random(400) < 0.05, 5.0 * rng.random(400), 0.0)
    core[20] = 0.0
    np.testing.assert_array_equal(decayed(core), _nonlinear_decay._nl_loudness(core))
    np.testing.assert_array_equal(total(core), _calc_slopes._calc_slopes(core)[0])


@pytest.mark.law("Loudness: the loudness in time of a steady tone is its stationary loudness.")
def test_a_steady_tone_has_its_loudness_at_all_times():
    for closed in (True, False):
        found = varying_loudness(burst(60.0, 24000) if not closed else tone(60.0), RATE, closed)
        # ISO 532-1:2017 allows 5 %.
        assert found.n5_sone == pytest.approx(4.0, rel=0.05)
        assert found.max_sone == pytest.approx(4.0, rel=0.05)


@pytest.mark.law("Loudness: a burst is the louder the longer it is, up to some 200 ms.")
def test_bursts_grow_louder_with_their_length():
    loudest = [
        varying_loudness(burst(70.0, n), RATE, closed=False).max_sone for n in (480, 2400, 9600)
    ]
    # 1 kHz at 70 dB has 8 sone. 10 ms are half as loud as a steady tone (Fastl and Zwicker, 8.6).
    assert loudest == sorted(loudest)
    assert loudest[0] == pytest.approx(4.0, rel=0.2)
    assert loudest[2] == pytest.approx(8.0, rel=0.05)


def test_a_knock_in_silence_is_judged_by_its_loudness_in_time():
    """The stationary method takes the mean square of the silence, too."""
    record = np.zeros(RATE)
    record[4800:7200] = burst(80.0, 2400)
    found = varying_loudness(record, RATE, closed=False)
    # A burst of 50 ms, which is exceeded for a little more than 5 % of one second.
    assert found.max_sone > 10
    assert 1.5 * loudness(record, RATE, closed=False).sone < found.max_sone
    assert 0.3 * found.max_sone < found.n5_sone <= found.max_sone


def test_what_has_no_loudness_in_time():
    silence = VaryingLoudness(0.0, 0.0)
    assert varying_loudness(np.full(4800, 1.0), RATE, closed=False) == silence
    nothing = VaryingLoudness(None, None)
    assert varying_loudness(tone(130.0, frequency_hz=100.0), RATE, closed=True) == nothing
    click = varying_loudness(tone(60.0, 10), RATE, closed=False)  # it is heard after its end
    assert click.max_sone >= click.n5_sone > 0.01
    with pytest.raises(ValueError, match=r"got 96000, .* sample rate of 48000 Hz"):
        varying_loudness(tone(60.0), 96000.0, closed=True)
