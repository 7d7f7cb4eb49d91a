"""Tones through the chain from step power to level have the levels of their amplitudes."""

import math

import numpy as np
import pytest

from acoustics.bands import BAND_NAMES
from acoustics.level import (
    crest_factor_db,
    is_single_event,
    lae_db,
    laeq_db,
    level_db,
    peak_pressure,
    sound_levels,
)
from acoustics.radiation import I_REF_W_M2, P_REF_PA, RHO_C, intensity, sound_pressure
from acoustics.resampling import band_limit, resample_closed, undo_step_mean
from acoustics.weighting import a_weighting_db

RATE = 48000


def tone(frequency_hz, amplitude=1.0, n=24000, rate=RATE):
    return amplitude * np.sin(2.0 * np.pi * frequency_hz * np.arange(n) / rate + 0.4)


@pytest.mark.law("Sound chain: a sinusoidal power has the level and the band of its closed form.")
@pytest.mark.parametrize(
    ("frequency_hz", "band"), [(40.0, "40"), (1000.0, "1000"), (3200.0, "3150"), (19800.0, "20000")]
)
def test_sine_through_the_whole_chain(frequency_hz, band):
    # The power over a step of 20 us is the mean of 1 mW + 10 uW sin over it, in closed form.
    mean_w = 1e-3
    amplitude_w = 1e-5
    step_rate = 50000.0
    n = 25000
    distance = 2.0
    phase = 2.0 * np.pi * frequency_hz * np.arange(n + 1) / step_rate + 0.4
    means = mean_w - amplitude_w * np.diff(np.cos(phase)) * step_rate / (2.0 * np.pi * frequency_hz)

    radiated = intensity(undo_step_mean(means), distance)
    audible = band_limit(resample_closed(radiated, RATE // 2), RATE)
    pressure, factor = sound_pressure(audible)
    levels = sound_levels(pressure, RATE, highest_hz=step_rate / 2.0)

    fluctuation = amplitude_w / math.sqrt(2.0) / (4.0 * math.pi * distance**2)  # rms of I'
    expected = 10.0 * math.log10(fluctuation * RHO_C / P_REF_PA**2)
    # The contract is 0.01 dB; every operation is exact but for rounding, so ask for far more.
    assert levels.level_db == pytest.approx(expected, abs=1e-6)
    assert levels.laeq_db == pytest.approx(expected + a_weighting_db(frequency_hz), abs=1e-6)
    assert levels.third_octave_db[band] == pytest.approx(expected, abs=1e-6)
    assert levels.third_octave_a_db[band] == pytest.approx(
        expected + a_weighting_db(frequency_hz), abs=1e-6
    )
    assert [name for name, level in levels.third_octave_db.items() if level is not None] == [band]
    assert factor == pytest.approx(math.sqrt(RHO_C / fluctuation), rel=1e-9)
    # The steady level is that of the mean intensity and does not sound.
    steady = level_db(float(np.mean(radiated)), I_REF_W_M2)
    assert steady == pytest.approx(10.0 * math.log10(1e-3 / (16.0 * math.pi) / 1e-12), abs=1e-9)


@pytest.mark.law("Levels: 1 Pa is 94 dB re 20 uPa.")
def test_1_pa_is_94_db():
    # 20 lg(1 / 20e-6) = 93.979 dB, the level of an acoustic calibrator.
    assert laeq_db(tone(1000.0, math.sqrt(2.0)), RATE) == pytest.approx(93.9794, abs=1e-4)


@pytest.mark.law("Levels: the third octaves add up to the whole.")
def test_bands_add_up_to_the_whole():
    noise = np.random.default_rng(2).standard_normal(RATE)
    levels = sound_levels(band_limit(noise, RATE), RATE)

    def total(bands):
        return 10.0 * math.log10(sum(10.0 ** (level / 10.0) for level in bands.values()))

    assert total(levels.third_octave_db) == pytest.approx(levels.level_db, abs=1e-9)  # rounding
    assert total(levels.third_octave_a_db) == pytest.approx(levels.laeq_db, abs=1e-9)
    assert laeq_db(band_limit(noise, RATE), RATE) == levels.laeq_db


def test_silence_is_none_everywhere():
    levels = sound_levels(np.zeros(4800), RATE)
    names = ("laeq_db", "level_db", "laf_max_db", "las_max_db", "lz_peak_db")
    assert {getattr(levels, name) for name in names} == {None}
    assert list(levels.third_octave_db) == list(levels.third_octave_a_db) == list(BAND_NAMES)
    assert {*levels.third_octave_db.values(), *levels.third_octave_a_db.values()} == {None}
    assert level_db(0.0) is None and level_db(-1.0) is None and laeq_db(np.zeros(10), RATE) is None


@pytest.mark.law("Silence: a constant power does not sound.")
def test_a_constant_power_is_silent():
    # Transforms of these lengths (smooth and prime) leave rounding beside 0 Hz; it must not sound
    # at -100 dB.
    for n in (24000, 23993):
        radiated = intensity(undo_step_mean(np.full(n, 1.8e-4)), 1.0)
        pressure, factor = sound_pressure(band_limit(resample_closed(radiated, 24000), RATE))
        assert factor == 0.0 and sound_levels(pressure, RATE).level_db is None


def test_bands_above_what_was_simulated_are_unknown():
    noise = band_limit(np.random.default_rng(4).standard_normal(RATE), RATE)
    known = sound_levels(noise, RATE, highest_hz=12500.0).third_octave_db
    # The 10 kHz band ends at 11.2 kHz, the 12.5 kHz band at 14.1 kHz.
    assert [name for name, level in known.items() if level is None] == ["12500", "16000", "20000"]
    # above the record's own Nyquist, in part
    assert sound_levels(noise, 16000.0).third_octave_a_db["8000"] is None


def test_a_fault_is_not_silence():
    with pytest.raises(ValueError, match=r"mean_square: got .* a finite number"):
        level_db(math.nan)
    with pytest.raises(ValueError, match="finite"):
        sound_levels(np.array([0.0, math.inf]), RATE)
    with pytest.raises(ValueError, match="finite"):
        sound_levels(sound_pressure(band_limit(np.array([0.0, math.nan, 1.0]), RATE))[0], RATE)


def test_maxima_and_peak_of_a_tone():
    # A steady tone reads its level with any weighting; its peak lies 3.01 dB above its rms. The
    # samples of 12 kHz at 45 degrees miss the crest by as much: only what lies between them has it.
    t = np.arange(RATE) / RATE
    levels = sound_levels(np.sin(2.0 * np.pi * 12000.0 * t + np.pi / 4.0), RATE)
    steady = 10.0 * math.log10(0.5 / P_REF_PA**2)
    weighted = steady + a_weighting_db(12000.0)
    # ripple of the folded square, see time_weighting
    assert levels.laf_max_db == pytest.approx(weighted, abs=1e-3)
    assert levels.las_max_db == pytest.approx(weighted, abs=1e-3)
    assert levels.lz_peak_db == pytest.approx(steady + 10.0 * math.log10(2.0), abs=1e-9)


def test_peak_between_the_samples_is_found_to_what_is_said():
    # Worst place of the crest: half way between two of the 8 points per sample, at any frequency.
    # -20 lg cos(pi f / (8 * 48 kHz))
    for frequency, allowed in ((5000, 0.0073), (20000, 0.117), (22380, 0.147)):
        phase = 2.0 * np.pi * frequency / (16.0 * RATE)
        t = np.arange(RATE) / RATE
        missed = -20.0 * math.log10(peak_pressure(np.cos(2.0 * np.pi * frequency * t + phase)))
        assert -1e-9 < missed < allowed + 1e-3
    assert peak_pressure(np.array([0.0, -3.0])) == pytest.approx(3.0)


def test_a_size_whose_square_is_no_number_is_refused():
    with (
        np.errstate(all="ignore"),
        pytest.raises(ValueError, match=r"mean_square: got .* a finite number"),
    ):
        sound_levels(np.array([0.0, 1e200, -1e200, 0.0]), RATE)


@pytest.mark.law("Crest factor: that of a sine is 3.01 dB, also where its peak is between samples.")
def test_the_crest_factor_of_a_sine_is_the_root_of_two():
    shifted = np.sin(2 * np.pi * (10 * np.arange(480) + 0.3) / 48)
    for wave in (tone(1000.0, n=4800), 7.0 * shifted):
        assert crest_factor_db(wave) == pytest.approx(10 * math.log10(2), abs=0.01)
    noise = np.random.default_rng(1).standard_normal(RATE)
    assert 12 < crest_factor_db(noise) < 14
    knock = np.append(noise, 100.0)
    assert crest_factor_db(knock) > 30
    assert crest_factor_db(np.zeros(100)) is None


# ---- single events


@pytest.mark.law("LAE: silence about an event changes nothing, and equal events add their energy.")
def test_the_exposure_of_events_does_not_depend_on_the_record():
    """The record in silence leaves the A-weighting's ringing 0.01 dB."""
    knock = tone(1000.0, n=4800) * np.exp(-np.arange(4800) / 200.0)
    alone = np.append(knock, np.zeros(4800))
    longer = np.concatenate((np.zeros(20_000), alone, np.zeros(30_000)))
    assert lae_db(longer, RATE) == pytest.approx(lae_db(alone, RATE), abs=0.01)
    assert laeq_db(longer, RATE) < laeq_db(alone, RATE) - 7
    twice = np.append(alone, alone)
    assert lae_db(twice, RATE) == pytest.approx(lae_db(alone, RATE) + 10 * math.log10(2), abs=0.01)
    one_second = tone(1000.0, n=RATE)
    assert lae_db(one_second, RATE) == pytest.approx(laeq_db(one_second, RATE), abs=1e-12)
    assert lae_db(np.zeros(100), RATE) is None


def test_a_knock_is_an_event_and_noise_and_three_knocks_are_none():
    random = np.random.default_rng(1)
    knock = tone(1000.0, n=4800) * np.exp(-np.arange(4800) / 200.0)
    assert is_single_event(knock + 1e-3 * random.standard_normal(4800), RATE)
    assert not is_single_event(np.tile(knock, 3), RATE)
    assert not is_single_event(np.zeros(4800), RATE)
    for n in (2, 48, 480, 48_000):
        assert not is_single_event(random.standard_normal(n), RATE)
        assert not is_single_event(tone(1000.0, n=n), RATE)
    growing = np.linspace(0, 1, 4800) ** 2 * random.standard_normal(4800)  # a ball that speeds up
    assert not is_single_event(growing, RATE)
