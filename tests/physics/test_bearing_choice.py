"""A choice between bearings states differences by band with their ±."""

import math

import numpy as np
import pytest

from rolling.bearing_run.band_difference import band_difference
from rolling.bearing_run.bearing_choice import BearingChoice


def test_a_ratio_that_all_specimens_share_is_sure_and_exact() -> None:
    fine = np.array([1.0, 3.0, 0.5, 2.0])
    apart = band_difference("high", fine, 2 * fine)
    assert apart.db == pytest.approx(20 * math.log10(2))
    assert apart.uncertainty_db == pytest.approx(0, abs=1e-9)
    assert apart.is_sure


def test_one_specimen_has_no_uncertainty() -> None:
    apart = band_difference("low", np.array([1.0]), np.array([1.5]))
    assert apart.uncertainty_db is None and not apart.is_sure


def test_a_bearing_at_rest_has_no_difference_in_decibels() -> None:
    assert math.isinf(band_difference("low", np.zeros(4), np.ones(4)).db)
    assert band_difference("low", np.zeros(4), np.zeros(4)).db == 0


@pytest.mark.law("Choice of bearings: the stated ± covers the scatter of repeated choices.")
def test_the_uncertainty_covers_repeated_choices() -> None:
    chance = np.random.default_rng(3)
    within = 0
    for _ in range(400):
        first = 10 ** (chance.normal(0, 1.5, 6) / 20)
        second = 10 ** (chance.normal(2, 1.5, 6) / 20)
        apart = band_difference("high", first, second)
        within += abs(apart.db - 2) <= apart.uncertainty_db
    assert 0.60 < within / 400 < 0.76


@pytest.mark.law("Choice of bearings: what all specimens share stays uncertain with many of them.")
def test_a_gain_that_all_specimens_share_is_in_the_uncertainty() -> None:
    rms = {"high": np.array([np.full(20, 1.0), np.full(20, 2.0)])}
    certain = np.zeros(10)
    scattered = np.resize([0.4, -0.4], 10)  # without each tenth of the waves
    parts = {
        "equal marches": [scattered, scattered],
        "other marches": [certain, scattered],
    }
    found = {}
    for name, levels in parts.items():
        choice = BearingChoice(["a", "b"], rms, "", 1.0, gain_levels={"high": levels})
        found[name] = choice.differences[0][0].uncertainty_db
        assert ("numerics.window_mm" in str(choice)) == (name == "other marches")
    assert found["equal marches"] == pytest.approx(0.0, abs=1e-9)
    assert found["other marches"] == pytest.approx(0.4 * 3.0)  # the root of 0.9 times 10


def test_sentences_name_each_band_once() -> None:
    values = np.array([[1.0, 1.1, 0.9, 1.0], [2.0, 2.1, 1.9, 2.0], [1.0, 1.2, 0.8, 1.0]])
    rms = {"low": values, "medium": values[::-1], "high": values}
    choice = BearingChoice(["a", "b", "c"], rms, "", 1.0)
    assert len(choice.sentences) == 6
    assert len(choice.table()) == 9
    assert str(choice).count("\n") == 6 + 3


def test_a_silent_housing_is_written() -> None:
    rms = {"high": np.ones((2, 3)), "housing": np.zeros((2, 3))}
    choice = BearingChoice(["a", "b"], rms, "", 1.0)
    assert "silent" in str(choice)
    assert choice.table()["housing_laeq_db"].isna().all()
