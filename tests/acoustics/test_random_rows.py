"""An extended record has the band levels of its record, and does not repeat it."""

from __future__ import annotations

import numpy as np
import pytest
from acoustics.extension import extend, kurtosis

from acoustics import level
from acoustics.bands import third_octave_mean_square
from acoustics.resampling import band_limit
from acoustics.spectrum import line_spectrum

RATE = 48000


def bursts(samples: int, seed: int = 1) -> np.ndarray:
    """Return a record of single clicks with a spectrum that is not flat."""
    random = np.random.default_rng(seed)
    clicks = np.where(random.random(samples) < 0.002, random.standard_normal(samples), 0.0)
    ringing = np.exp(-np.arange(200) / 20.0) * np.sin(np.arange(200))
    return band_limit(np.fft.irfft(np.fft.rfft(clicks) * np.fft.rfft(ringing, samples)), RATE)


def bands(record: np.ndarray) -> np.ndarray:
    return third_octave_mean_square(*line_spectrum(record, RATE))


def largest_difference_db(record: np.ndarray, longer: np.ndarray) -> float:
    before, after = bands(record), bands(longer)
    there = before > 1e-20 * before.max()  # rounding leaves something in the other bands
    assert there.sum() > 10 and after[~there].sum() < 1e-20 * after.sum()
    return float(np.abs(10 * np.log10(after[there] / before[there])).max())


def autocorrelation(record: np.ndarray) -> np.ndarray:
    lines = np.abs(np.fft.rfft(record)) ** 2
    values = np.fft.irfft(lines, len(record))
    return values / values[0]


@pytest.mark.parametrize(("samples", "longer"), [(24000, 480000), (21601, 1 << 18), (4801, 240001)])
def test_bands_agree_within_a_tenth_of_a_decibel(samples: int, longer: int) -> None:
    record = bursts(samples)
    assert largest_difference_db(record, extend(record, longer, RATE)) < 0.1


def test_level_of_the_whole_record_is_kept() -> None:
    record = bursts(24000)
    longer = extend(record, 10 * RATE, RATE)
    assert level.laeq_db(longer, RATE) == pytest.approx(level.laeq_db(record, RATE), abs=0.1)


def test_no_repetition_shows_in_the_autocorrelation() -> None:
    """The repeated record has a correlation of 1 at every multiple of its length.

    The extended one has that of independent noise there, 1/sqrt(number of lines) at most a few
    times.
    """
    record = bursts(4800)
    longer = extend(record, 100 * 4800, RATE)
    around = np.concatenate([np.arange(-480, 481) + k * 4800 for k in range(1, 50)])
    assert autocorrelation(np.tile(record, 100))[4800] == pytest.approx(1.0)
    assert np.abs(autocorrelation(longer)[around]).max() < 0.05


def test_laps_within_the_record_do_not_show_either() -> None:
    lap = band_limit(np.random.default_rng(2).standard_normal(480), RATE)
    longer = extend(np.tile(lap, 50), 10 * RATE, RATE, laps=50.0)
    assert autocorrelation(extend(np.tile(lap, 50), 10 * RATE, RATE))[480] > 0.8
    around = np.concatenate([np.arange(-24, 25) + k * 480 for k in range(1, 50)])
    assert np.abs(autocorrelation(longer)[around]).max() < 0.12
    assert largest_difference_db(np.tile(lap, 50), longer) < 0.1


def test_it_is_gaussian_whatever_the_record_is() -> None:
    record = bursts(24000)
    assert kurtosis(record) > 6
    assert kurtosis(extend(record, 10 * RATE, RATE)) == pytest.approx(3.0, abs=0.1)


def test_equal_records_give_equal_samples_and_seeds_other_ones() -> None:
    record = bursts(2400)
    first, again = extend(record, 48000, RATE), extend(record.copy(), 48000, RATE)
    other = extend(record, 48000, RATE, seed=1)
    assert np.array_equal(first, again)
    assert abs(np.corrcoef(first, other)[0, 1]) < 0.05


def test_silence_stays_silent_and_shorter_records_are_refused() -> None:
    assert not extend(np.zeros(480), 4800, RATE).any()
    assert np.isnan(kurtosis(np.zeros(480)))
    with pytest.raises(ValueError, match="extended to more than that"):
        extend(np.ones(480), 480, RATE)
