"""Levels of simulated Gaussian noise spread as each of them states."""

import math

import numpy as np
import pytest
from scipy.special import polygamma

from acoustics.bands import (
    BAND_NAMES,
    BANDWIDTH_HZ,
    band_uncertainty_db,
    third_octave_mean_square,
)
from acoustics.level import level_db, sound_levels
from acoustics.radiation import sound_pressure
from acoustics.spectrum import line_spectrum
from acoustics.uncertainty import (
    excess_variance,
    level_uncertainty,
    steady_uncertainty_db,
    with_excess,
)

RATE = 48000
NAMES = ("laeq_db", "level_db", "laf_max_db", "las_max_db", "lz_peak_db")


def noise(seed, n, slope, low, high):
    """Return closed Gaussian noise (n,) whose density falls with f**-slope in a band [Hz]."""
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    inside = (frequency >= low) & (frequency < high)
    gain = np.where(inside, np.maximum(frequency, 1.0) ** (-slope / 2.0), 0.0)
    return np.fft.irfft(np.fft.rfft(np.random.default_rng(seed).standard_normal(n)) * gain, n)


def spread(records, duration, slope, low, high, own_factor, band):
    """Return the observed over the stated standard deviation of every level."""
    observed = []
    stated = []
    for seed in range(records):
        fluctuation = 1e-6 * noise(seed, round(duration * RATE), slope, low, high)
        pressure, _ = sound_pressure(fluctuation, None if own_factor else 1e3)
        levels = sound_levels(pressure, RATE)
        one = level_uncertainty(pressure, RATE, levels, own_factor)
        observed.append([*(getattr(levels, name) for name in NAMES), levels.third_octave_db[band]])
        stated.append([*(getattr(one, name) for name in NAMES), one.third_octave_db[band]])
    ratio = np.std(observed, axis=0, ddof=1) / np.sqrt(np.mean(np.square(stated), axis=0))
    return dict(zip((*NAMES, "band"), ratio, strict=True))


CASES = [  # duration [s], slope, low and high [Hz], a band in it
    (0.5, 0.0, 17.8, 22387.0, "1000"),  # white
    (0.5, 1.0, 17.8, 22387.0, "1000"),  # pink
    (0.5, 2.0, 50.0, 22387.0, "500"),  # red: some 50 lines carry it
    (0.5, 0.0, 900.0, 1100.0, "1000"),  # 100 lines
    (0.1, 1.0, 100.0, 5000.0, "2000"),
]


@pytest.mark.slow
@pytest.mark.law("Uncertainty: levels of noise spread as they state.")
@pytest.mark.parametrize("own_factor", [False, True])
@pytest.mark.parametrize(("duration", "slope", "low", "high", "band"), CASES)
def test_levels_spread_as_they_state(duration, slope, low, high, band, own_factor):
    found = spread(300, duration, slope, low, high, own_factor, band)
    # A standard deviation from 300 records is itself uncertain by 1/sqrt(600) = 4 %: three of
    # these. Above, first order in 4.34 sqrt(1/N) leaves out another 1/(4 N), 2 % for the 10 or more
    # lines here.
    for name in ("level_db", "laeq_db", "band"):
        assert 0.88 < found[name] < 1.14, (name, found)
    # Groups of extremes in a narrow band: up to a fifth more than of extremes that stand alone.
    assert 0.8 < found["lz_peak_db"] < 1.25, found
    # Upper bounds: not exceeded, and not more than twice what is there.
    for name in ("laf_max_db", "las_max_db"):
        assert 0.45 < found[name] < 1.14, (name, found)


def test_equal_lines_are_counted():
    # M equal lines have a gamma distribution, whose logarithm has the variance psi'(M): in the
    # mean of many records for M = 5 (without the 1 taken off: 6) as for 500. The number that five
    # observed lines give scatters, which makes the mean of psi' 6 % larger.
    for lines, tolerance in ((5, 0.1), (500, 0.007)):
        variance = []
        for seed in range(400):
            record = noise(seed, 4800, 0.0, 995.0, 995.0 + 10.0 * lines)
            levels = sound_levels(record, RATE)
            variance.append((level_uncertainty(record, RATE, levels, False).level_db / 4.3429) ** 2)
        assert np.mean(variance) == pytest.approx(polygamma(1, lines), rel=tolerance)


def test_a_single_line_is_known_to_no_better_than_itself():
    # The logarithm of an exponentially distributed mean square has the standard deviation
    # pi/sqrt(6); half with its own factor.
    tone = np.sin(2.0 * np.pi * 1000.0 * np.arange(24000) / RATE)
    levels = sound_levels(tone, RATE)
    assert level_uncertainty(tone, RATE, levels, False).level_db == pytest.approx(
        10.0 / math.log(10.0) * math.pi / math.sqrt(6.0), rel=1e-6
    )
    assert level_uncertainty(tone, RATE, levels, True).laeq_db == pytest.approx(
        5.0 / math.log(10.0) * math.pi / math.sqrt(6.0), rel=1e-6
    )


def test_bands_of_an_even_spectrum_state_bt_and_with_an_own_factor_what_it_takes_off():
    record = noise(1, 24000, 0.0, 17.8, 22387.0)
    levels = sound_levels(record, RATE, highest_hz=12500.0)
    fixed = level_uncertainty(record, RATE, levels, False).third_octave_db
    # The number of lines that M observed lines give scatters by 2/sqrt(M), and its root by half of
    # that; three of these. From 1 kHz on, M is 115 and more.
    stated = list(fixed.values())[17:28]
    even = band_uncertainty_db(0.5)[17:28]
    tolerance = 3.0 / np.sqrt(BANDWIDTH_HZ[17:28] * 0.5)
    assert np.all(np.abs(stated / even - 1.0) < tolerance)
    assert fixed["12500"] is None and fixed["20000"] is None  # as the levels
    own = level_uncertainty(record, RATE, levels, True).third_octave_db
    # The 10 kHz band has a tenth of the lines of the whole: its share goes out with the factor.
    assert own["10000"] < fixed["10000"] and own["20"] == pytest.approx(fixed["20"], rel=1e-3)


RESONANCES = [  # duration [s], frequency [Hz], loss factor, its band
    (0.22, 980.0, 0.02, "1000"),
    (0.69, 125.0, 0.01, "125"),  # some five lines within the resonance
    (0.69, 1000.0, 0.02, "1000"),
    (0.5, 1000.0, 0.2, "1000"),  # as wide as the band
]


@pytest.mark.law("Uncertainty: a third octave that holds a resonance scatters as it states.")
@pytest.mark.parametrize(("duration", "resonance", "loss", "band"), RESONANCES)
def test_a_band_of_a_resonance_scatters_as_it_states(duration, resonance, loss, band):
    n = round(duration * RATE)
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    response = 1.0 / (resonance**2 - frequency**2 + 1j * loss * resonance * frequency) + 2e-9
    response *= (frequency > 17.8) & (frequency < 22387.0)
    observed = []
    stated = []
    levels = None
    for seed in range(200):
        lines = np.fft.rfft(np.random.default_rng(seed).standard_normal(n))
        record = 1e4 * np.fft.irfft(lines * response, n)
        # The uncertainty takes from the levels only which of them there are.
        levels = levels or sound_levels(record, RATE)
        squares = third_octave_mean_square(*line_spectrum(record, RATE))
        observed.append(10.0 * math.log10(squares[BAND_NAMES.index(band)]))
        stated.append(level_uncertainty(record, RATE, levels, False).third_octave_db[band])
    # A standard deviation from 200 records is uncertain by 5 %, and three of these are allowed. The
    # number of five lines is known poorly, which takes up to 10 % off the mean.
    assert 0.82 < np.mean(stated) / np.std(observed, ddof=1) < 1.15


def test_part_of_a_lap_adds_no_lines():
    """Two laps and a half have the uncertainty of one, within the scatter of its estimate."""
    lap = noise(3, 12000, 1.0, 100.0, 5000.0)
    once = level_uncertainty(lap, RATE, sound_levels(lap, RATE), False)
    record = np.tile(lap, 3)[:30000]
    more = level_uncertainty(record, RATE, sound_levels(record, RATE), False, laps=2.5)
    assert more.laeq_db == pytest.approx(once.laeq_db, rel=0.15)
    assert more.third_octave_db["1000"] == pytest.approx(once.third_octave_db["1000"], rel=0.3)


def test_laps_are_one_sample_of_noise():
    lap = noise(3, 12000, 1.0, 17.8, 22387.0)
    once = level_uncertainty(lap, RATE, sound_levels(lap, RATE), True)
    thrice_record = np.tile(lap, 3)
    thrice = level_uncertainty(
        thrice_record, RATE, sound_levels(thrice_record, RATE), True, laps=3.0
    )
    for name in (*NAMES, "third_octave_db"):
        assert getattr(thrice, name) == pytest.approx(getattr(once, name), rel=1e-9)  # rounding


@pytest.mark.law("Uncertainty: the steady level spreads as it states.")
@pytest.mark.parametrize(("duration", "cut"), [(0.5, None), (0.5, 1000.0), (0.1, 200.0)])
def test_steady_level_spreads_as_it_states(duration, cut):
    # A mean with noise on it, white or through a low-pass; the mean of 400 records spreads as each
    # states, within 3/sqrt(800) = 11 %. Behind a low-pass of 200 Hz the lines up to 50 Hz hold 2 %
    # less, as a mean square, than 0 Hz.
    n = round(duration * RATE)
    frequency = np.fft.rfftfreq(n, 1.0 / RATE)
    gain = 1.0 if cut is None else 1.0 / np.sqrt(1.0 + (frequency / cut) ** 2)
    observed = []
    stated = []
    for seed in range(400):
        power = 1.0 + 0.5 * np.fft.irfft(
            np.fft.rfft(np.random.default_rng(seed).standard_normal(n)) * gain, n
        )
        observed.append(level_db(float(power.mean()), 1e-12))
        stated.append(steady_uncertainty_db(power, RATE))
    assert np.std(observed, ddof=1) == pytest.approx(np.sqrt(np.mean(np.square(stated))), rel=0.12)


def test_steady_uncertainty_of_what_does_not_vary():
    assert steady_uncertainty_db(np.full(100, 2.0), RATE) == pytest.approx(0.0, abs=1e-12)
    assert steady_uncertainty_db(np.zeros(100), RATE) is None
    assert steady_uncertainty_db(np.ones(1), RATE) is None


def test_gaussian_noise_has_hardly_an_excess():
    """The excess is 1 or more, and known to 40 %, so its mean over Gaussian records is 1.15."""
    excess = [excess_variance(noise(seed, 4800, 1.0, 100.0, 22000.0), RATE) for seed in range(200)]
    for value in ("laeq", "level", "third_octave"):
        means = np.mean([getattr(one, value) for one in excess], axis=0)
        assert np.all(means < 1.3)
    assert np.mean([one.laeq for one in excess]) < 1.2
    assert np.all(excess[0].third_octave[: BAND_NAMES.index("500")] == 1.0)  # few lines


@pytest.mark.law("Uncertainty: levels of noise that comes in bursts spread as they state.")
def test_levels_of_bursts_spread_as_they_state():
    """The strength of the noise changes along the record, by 4 dB rms over some milliseconds.

    A standard deviation of 150 records is good to 6 %, and that of a few lines to 40 %, so the mean
    of the stated ones to some 4 %; 20 % are allowed.
    """
    highest_hz = 200.0
    observed = []
    gaussian = []
    stated = []
    for seed in range(150):
        # White noise of variance 1 up to this frequency; its mean differs from record to record.
        strength = noise(1000 + seed, 4800, 0.0, 0.0, highest_hz) / math.sqrt(2 * highest_hz / RATE)
        record = 10.0 ** (4.0 / 20.0 * strength) * noise(seed, 4800, 0.0, 1e3, 1e4)
        levels = sound_levels(record, RATE)
        spreads = level_uncertainty(record, RATE, levels, False)
        whole = with_excess(spreads, excess_variance(record, RATE))
        observed.append([levels.laeq_db, levels.level_db, levels.third_octave_db["4000"]])
        for found, rows in ((spreads, gaussian), (whole, stated)):
            rows.append([found.laeq_db, found.level_db, found.third_octave_db["4000"]])
    scatter = np.std(observed, axis=0, ddof=1)
    assert np.all(scatter[:2] > 2.0 * np.sqrt(np.mean(np.square(gaussian), axis=0))[:2])
    ratio = scatter / np.sqrt(np.mean(np.square(stated), axis=0))
    assert ratio == pytest.approx(1.0, abs=0.2)
