"""Random rows have the spectra and cross-spectra of the given ones, and do not repeat them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from acoustics import kurtosis
from acoustics.continued_rows import ContinuedRows, RandomRows


def coloured(count: int, seed: int, length: float = 30.0) -> np.ndarray:
    """Return two rows whose correlation is 0.6, with a Gaussian spectrum of 100 dB of range."""
    white = np.random.default_rng(seed).standard_normal((2, count))
    frequency = np.fft.rfftfreq(count)
    rows = np.fft.irfft(
        np.fft.rfft(white) * np.exp(-((frequency * length) ** 2) / 2), count
    ) / np.sqrt(0.5 / length)
    return np.stack((rows[0], 0.6 * rows[0] + 0.8 * rows[1]))


def drawn(rows: np.ndarray, closed: bool, seed: int = 0, count: int = 4) -> np.ndarray:
    stretches = RandomRows(rows, closed).stretches(np.random.default_rng(seed))
    return np.concatenate([next(stretches) for _ in range(count)], axis=1)


def bands(row: np.ndarray) -> np.ndarray:
    """Return the mean squares of a row in five bands of wavelengths from 1000 to 15 positions."""
    parts = row[: len(row) // 2500 * 2500].reshape(-1, 2500) * np.hanning(2500)
    power = np.mean(np.square(np.abs(np.fft.rfft(parts))), axis=0)
    return np.add.reduceat(power, [2, 6, 15, 40, 90, 170])[:-1]


@pytest.mark.parametrize("closed", [True, False])
def test_drawn_rows_have_the_spectra_and_the_correlation_of_the_given_rows(closed: bool) -> None:
    # 20,000 positions hold some 600 independent values: 4 % of the power, 0.03 of a correlation.
    given = coloured(20_000 if closed else 200_000, 1)[:, :20_000]
    rows = drawn(given, closed)
    assert np.allclose(np.mean(rows**2, axis=1), np.mean(given**2, axis=1), rtol=0.12)
    assert np.corrcoef(rows)[0, 1] == pytest.approx(np.corrcoef(given)[0, 1], abs=0.06)
    ratio = 10 * np.log10(bands(rows[0]) / bands(given[0]))
    assert np.all(np.abs(ratio) < 1.5)  # eight pieces of the given row: 1.5 dB
    assert kurtosis(rows[0]) == pytest.approx(3.0, abs=0.1)


def test_drawn_rows_are_unbiased_over_many_given_rows() -> None:
    """The division by a smooth level keeps a steep spectrum from leaking into its higher bands."""
    ratios = [
        10 * np.log10(bands(drawn(rows, True, seed, 1)[0]) / bands(rows[0]))
        for seed, rows in enumerate(coloured(5_000, seed) for seed in range(16))
    ]
    assert np.all(np.abs(np.mean(ratios, axis=0)) < 1.0)  # 16 rows of 2 dB each, twice 0.5


def test_blends_keep_the_variance_and_no_stretch_repeats() -> None:
    process = RandomRows(coloured(2_000, 3), True)
    stretches = process.stretches(np.random.default_rng(1))
    rows = np.stack([next(stretches)[0] for _ in range(24)])
    power = np.mean(rows**2, axis=0)
    blended = power[: process.blend].mean()
    rest = power[process.blend :].mean()
    assert blended == pytest.approx(rest, rel=0.15)  # 500 positions of 24 stretches: 7 %
    assert abs(np.corrcoef(rows[0], rows[1])[0, 1]) < 0.1
    joint = np.abs(np.diff(rows.ravel()))
    seams = joint[rows.shape[1] - 1 :: rows.shape[1]]
    assert seams.max() < 1.5 * joint.max() and seams.mean() < 2 * joint.mean()


def test_rows_are_given_first_and_do_not_depend_on_the_parts_in_which_they_are_read() -> None:
    given = coloured(3_000, 4)
    whole = ContinuedRows(given, True, 7).between(0, 200_000)
    parts = ContinuedRows(given, True, 7)
    ends = [0, 10, 2_990, 3_100, 66_000, 150_000, 200_000]
    read = [parts.between(a, b) for a, b in pairwise(ends)]
    assert np.array_equal(np.concatenate(read, axis=1), whole)
    assert np.array_equal(whole[:, :3_000], given)
    assert not np.array_equal(whole, ContinuedRows(given, True, 8).between(0, 200_000))


def test_pits_are_inserted_as_given_at_the_rate_at_which_they_occur() -> None:
    given = coloured(20_000, 5)
    pit = -20 * np.exp(-np.square(np.arange(-60, 61) / 20))
    for place in (3_000, 9_000, 15_500):
        given[:, place - 60 : place + 61] += pit
    rows = ContinuedRows(given, True, 1)
    later = rows.between(0, 2_000_000)[0, 20_000:]
    deep = np.flatnonzero(np.diff((later < -12).astype(int)) == 1)
    assert rows.inserted == pytest.approx(297, abs=4 * np.sqrt(297))  # 3 in 20,000, Poisson
    assert len(deep) == pytest.approx(rows.inserted, abs=2)
    assert later[deep[0] : deep[0] + 60].min() == pytest.approx(given[0].min(), abs=2)
    calm = later[later > -5]
    assert np.std(calm) == pytest.approx(np.std(given[0][given[0] > -5]), rel=0.1)


@pytest.mark.parametrize(("count", "turns"), [(4_000, 4), (600, 0.6)])
def test_the_turn_of_a_ball_repeats_as_far_as_it_is_solved(count: int, turns: float) -> None:
    """A tick once per turn of 1,000 positions stays; the rest of a short track is random."""
    given = 0.3 * coloured(count, 6)
    given[:, 200::1_000] += 15
    rows = ContinuedRows(given, turns > 1, 2, 1_000).between(0, 60_000)[0]
    ticks = np.flatnonzero(rows > 10)
    assert np.array_equal(ticks, np.arange(200, 60_000, 1_000))
    between = rows.reshape(-1, 1_000)[5:, 700:]
    assert np.std(between.mean(axis=0)) < 0.75 * np.std(between)  # 0.5 of four turns, else less


@pytest.mark.parametrize("turns", [1.0, 1.3, 1.9, 2.5])
def test_a_broken_number_of_turns_keeps_the_power_of_the_rows(turns: float) -> None:
    """Positions met once repeat, and the others vary: within 0.6 dB, the luck of a turn."""
    given = coloured(round(1_000 * turns), 4)
    rows = ContinuedRows(given, False, 3, 1_000)
    later = rows.between(0, 60_000)[0, 4_000:]
    assert 10 * np.log10(later.var() / given[0].var()) == pytest.approx(0, abs=0.6)
    assert rows.inserted == 0  # no part of Gaussian rows is rare


@pytest.mark.parametrize("rows", [np.zeros((2, 500)), np.ones((1, 64)), np.tile(1e-9, (3, 99))])
def test_constant_rows_stay_constant(rows: np.ndarray) -> None:
    later = ContinuedRows(rows, False, 0).between(0, 100_000)
    assert np.array_equal(later, np.tile(rows[:, :1], 100_000))


def test_too_few_positions_are_refused() -> None:
    with pytest.raises(ValueError, match="need 16 positions or more, got 15"):
        RandomRows(np.zeros((1, 15)), True)
