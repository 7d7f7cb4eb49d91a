"""Laps of a record repeat without a click, and keep the level of their record."""

from __future__ import annotations

import numpy as np
import pytest

from acoustics import kurtosis, level
from acoustics.laps import Lap, crossfaded_lap
from acoustics.resampling import band_limit, fade
from acoustics.uncertainty import kurtosis_uncertainty

RATE = 48000


def noise(samples: int, low: float = 20, high: float = 20000, seed: int = 1) -> np.ndarray:
    """Return noise of a band that closes on itself."""
    random = np.random.default_rng(seed)
    return band_limit(random.standard_normal(samples), RATE, (low, high))


def bend(record: np.ndarray) -> float:
    """Return the maximum second difference of a record that goes round."""
    return float(np.abs(np.roll(record, 1) - 2 * record + np.roll(record, -1)).max())


@pytest.mark.parametrize("seconds", [0.01, 0.05, 0.9])
@pytest.mark.parametrize("band", [(20, 20000), (100, 500), (300, 350)])
def test_a_faded_record_goes_round_without_a_click(seconds: float, band: tuple) -> None:
    """It bends by sqrt(2) times as much as the record, and as a cosine of one overlap, at most."""
    n = round(seconds * RATE)
    ends = min(480, n // 10)
    record = noise(2 * n, *band)[:n]  # its ends do not fit
    lap = crossfaded_lap(fade(record, ends), ends, RATE)
    closed = lap.samples(record)
    assert len(closed) == len(lap) >= 0.5 * n
    own = np.sqrt(2) * np.abs(np.diff(record, 2)).max()
    assert bend(closed) / lap.factor <= own + np.abs(record).max() * (np.pi / lap.overlap) ** 2 / 2
    if band[1] < 1000 and seconds > 0.01:  # else a cut bends no more than the record
        assert bend(closed) < 0.5 * bend(record)


@pytest.mark.parametrize("seed", range(3))
def test_laps_have_the_level_of_the_record(seed: int) -> None:
    """They have the record's A-weighted level, and no dip where one leads to the next."""
    record = fade(noise(4800, 50, 8000, seed), 480)
    lap = crossfaded_lap(record, 480, RATE)
    tiled = np.tile(lap.samples(record), 50)
    assert level.laeq_db(tiled, RATE) == pytest.approx(level.laeq_db(record, RATE), abs=1e-6)
    power = np.mean([np.square(noisy(seed)[: lap.overlap]) for seed in range(100, 160)])
    assert 10 * np.log10(power) == pytest.approx(0, abs=0.5)  # 60 x 480 samples


def noisy(seed: int) -> np.ndarray:
    """Return the lap of white noise of power 1 without a factor."""
    record = np.random.default_rng(seed).standard_normal(4800)
    lap = crossfaded_lap(record, 480, RATE)
    return Lap(lap.begin, lap.end, lap.overlap, lap.correlation).samples(record)


@pytest.mark.parametrize("samples", [2, 5, 20, 100])
def test_short_and_silent_records_have_laps(samples: int) -> None:
    for record in (np.zeros(samples), np.ones(samples)):
        lap = crossfaded_lap(record, max(1, samples // 10), RATE)
        assert len(lap.samples(record)) == len(lap) > 0
        assert np.isfinite(lap.samples(record)).all()


@pytest.mark.parametrize("band", [(20, 20000), (200, 2000), (500, 1500)])
def test_the_kurtosis_of_noise_scatters_as_stated(band: tuple) -> None:
    """Of 150 records 95 % lie within two uncertainties: 88 % or more but once in 10,000 times."""
    records = [noise(4800, *band, seed) for seed in range(150)]
    z = [(kurtosis(x) - 3) / kurtosis_uncertainty(x) for x in records]
    assert np.mean(np.abs(z) < 2) > 0.88 and 0.8 < np.std(z) < 1.2
