"""Differences of bearings by band, with their ±."""

import math

import numpy as np
import pytest

from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing_kind.bearing_audition import BearingAudition
from rolling.bearing_kind.bearing_heard import UM_S, HeardRing, StoredRoughBand
from rolling.choice.difference import Difference

CERTAIN = np.zeros(10)
SCATTERED = np.resize([0.4, -0.4], 10)  # without each tenth of the waves, dB


def heard(values: np.ndarray, levels_db: np.ndarray = CERTAIN) -> list[HeardRing]:
    """Make what is heard of specimens, equal in all bands, with levels without groups of waves."""
    whole = float(np.mean(np.square(values / UM_S)))
    without = tuple(whole * 10 ** (levels_db / 10))
    rough = dict.fromkeys(VELOCITY_BANDS_HZ, StoredRoughBand(whole=whole, without_groups=without))
    return [
        HeardRing(low=value, medium=value, high=value, housing=value, rough=rough)
        for value in values.tolist()
    ]


def difference(first: list[HeardRing], second: list[HeardRing], band: str = "high") -> Difference:
    return BearingAudition().difference(band, first, second)


def test_a_ratio_that_all_specimens_share_is_sure_and_exact() -> None:
    fine = np.array([1.0, 3.0, 0.5, 2.0])
    for quantity in ("low", "medium", "high", "housing"):
        apart = difference(heard(2 * fine), heard(fine), quantity)
        assert apart.db == pytest.approx(20 * math.log10(2))
        assert apart.uncertainty_db == pytest.approx(0, abs=1e-9)
        assert apart.is_sure


def test_one_specimen_has_no_uncertainty() -> None:
    apart = difference(heard(np.array([1.5])), heard(np.array([1.0])))
    assert apart.uncertainty_db is None and not apart.is_sure


def test_a_bearing_at_rest_has_no_difference_in_decibels() -> None:
    assert difference(heard(np.ones(4)), heard(np.zeros(4))).db is None
    assert difference(heard(np.zeros(4)), heard(np.zeros(4))).db is None


@pytest.mark.law("Choice of bearings: the stated ± covers the scatter of repeated choices.")
def test_the_uncertainty_covers_repeated_choices() -> None:
    chance = np.random.default_rng(3)
    within = 0
    for _ in range(400):
        first = 10 ** (chance.normal(0, 1.5, 6) / 20)
        second = 10 ** (chance.normal(2, 1.5, 6) / 20)
        apart = difference(heard(second), heard(first))
        within += abs(apart.db - 2) <= apart.uncertainty_db
    assert 0.60 < within / 400 < 0.76


@pytest.mark.law("Choice of bearings: what all specimens share stays uncertain with many of them.")
def test_a_gain_that_all_specimens_share_is_in_the_uncertainty() -> None:
    fine = np.full(20, 1.0)
    equal = difference(heard(2 * fine, SCATTERED), heard(fine, SCATTERED))
    other = difference(heard(2 * fine, SCATTERED), heard(fine))
    assert equal.uncertainty_db == pytest.approx(0.0, abs=1e-9)
    assert other.uncertainty_db == pytest.approx(0.4 * 3.0)  # the root of 0.9 times 10
    assert other.parts_db["gains"] == pytest.approx(0.4 * 3.0)
    assert "numerics.window_mm" in BearingAudition.advice["gains"]
