"""The robust Gaussian filter against the linear one, against sums, and past pits."""

from __future__ import annotations

import numpy as np
import pytest

from rolling.surface.gaussian_filter import FAR, robust_smoothed, smoothed
from rolling.surface.stylus import ALPHA

UM = 1e-6


def summed(z: np.ndarray, index: float) -> np.ndarray:
    """Return the robust long waves of a profile of spacing 1 by the sums of ISO 16610-31."""
    place = np.arange(len(z))
    kernel = np.exp(-np.pi * (np.subtract.outer(place, place) / (ALPHA * index)) ** 2)
    line = np.polyval(np.polyfit(place, z, 1), place)
    level = z - line
    long = kernel @ level / kernel.sum(axis=1)
    for _ in range(60):
        distance = np.abs(level - long)
        far = 4.4478 * np.median(distance)
        weight = np.where(distance < far, (1 - (distance / far) ** 2) ** 2, 0.0)
        long = kernel @ (weight * level) / (kernel @ weight)
    return line + long


def test_a_profile_is_filtered_as_by_the_sums_of_the_standard() -> None:
    """Edges too; the iteration ends before the last 1e-4 of the limit, 5e-3 of the heights."""
    random = np.random.default_rng(1)
    z = np.cumsum(random.normal(size=200)) + 0.3 * np.arange(200)
    z[50:54] -= 80.0
    got = robust_smoothed(z[:, None], (1.0, 1.0), 40.0, wraps=False)[:, 0]
    assert np.abs(got - summed(z, 40.0)).max() < 5e-3 * np.median(np.abs(z - got))


@pytest.mark.law("Preparation: the robust filter halves a wave at its index, past pits.")
@pytest.mark.parametrize("wraps", [True, False])
def test_pits_pull_the_linear_filter_and_not_the_robust_one(wraps: bool) -> None:
    """Pits of 5 % of the area and 20 Sq pull the linear waves by 1 Sq, the robust ones by 0.1."""
    random = np.random.default_rng(2)
    z = random.normal(size=(128, 96))
    pitted = z.copy()
    for row, column in random.integers(6, 90, (25, 2)):
        pitted[row : row + 5, column : column + 5] -= 20.0
    steps = (UM, UM)
    plain = smoothed(z, steps, 30 * UM, wraps)
    pulled = np.abs(smoothed(pitted, steps, 30 * UM, wraps) - plain)
    robust = np.abs(robust_smoothed(pitted, steps, 30 * UM, wraps) - plain)
    assert pulled.max() > 3.0 and np.sqrt(np.mean(robust**2)) < 0.15


def test_gaussian_heights_are_filtered_nearly_as_by_the_linear_filter() -> None:
    """Weights of Tukey keep 91 % of the efficiency, so that the difference is small to Sq."""
    z = np.random.default_rng(3).normal(size=(128, 96))
    difference = robust_smoothed(z, (1.0, 1.0), 20.0, True) - smoothed(z, (1.0, 1.0), 20.0, True)
    assert np.std(difference) < 0.05
    assert pytest.approx(3 / 0.6745, rel=1e-4) == FAR


@pytest.mark.parametrize("z", [np.zeros((9, 9)), np.eye(30), 1e-30 * np.eye(30) - 5.0])
@pytest.mark.filterwarnings("error")
def test_flat_heights_and_single_spikes_stay_finite(z: np.ndarray) -> None:
    """A spike on a flat has a median distance of nothing, and the linear filter is the answer."""
    for wraps in (True, False):
        assert np.isfinite(robust_smoothed(z, (1.0, 2.0), 4.0, wraps)).all()
