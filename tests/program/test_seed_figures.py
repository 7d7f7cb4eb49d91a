"""Runs over several seeds are merged into their mean and its spread."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from report_runs import run_results

from acoustics.bands import BAND_NAMES
from rolling.figures import seed_figures
from rolling.figures.order import is_ordered
from rolling.figures.sound_views import CurveScales
from rolling.simulation.run_result import RunResult


@pytest.fixture
def seeded(runs) -> list[RunResult]:
    """Return six runs: two loads with three seeds each, whose levels are 10, 13 and 16 dB up."""
    first = run_results(runs.three())[0]
    made = []
    for load in (1.0, 2.0):
        for seed in (1, 2, 3):
            levels = dict.fromkeys(BAND_NAMES, 7.0 + 3.0 * seed + load)
            sound = replace(first.sound, levels=replace(first.sound.levels, third_octave_db=levels))
            values = {"rolling.load_n": load, "surface.seed": seed}
            label = f"load {load:g} N, seed {seed}"
            made.append(replace(first, sound=sound, values=values, label=label))
    return made


def test_seeds_are_merged_by_power_with_their_spread(seeded) -> None:
    one, other = seed_figures.merged(seeded)
    assert (one.label, other.label) == ("load 1 N, 3 seeds", "load 2 N, 3 seeds")
    powers = 10 ** (np.array([11.0, 14.0, 17.0]) / 10)
    assert one.mean_db["1000"] == pytest.approx(10 * np.log10(powers.mean()))
    assert one.spread_db["1000"] == pytest.approx(3.0)
    assert other.mean_db["1000"] == pytest.approx(10 * np.log10(powers.mean()) + 1.0)


def test_few_seeds_and_none_are_not_merged(seeded, runs) -> None:
    assert seed_figures.merged(seeded[:5]) == []
    assert seed_figures.merged(run_results(runs.three())) == []


def test_the_picture_draws_a_band_for_each_group(seeded) -> None:
    picture = seed_figures.third_octaves_of_seeds(seeded, CurveScales.of(seeded))
    assert picture is not None and picture.name == "third_octaves_of_seeds"
    (ax,) = picture.figure.axes
    assert len([each for each in ax.collections if each.get_alpha() == 0.2]) == 2
    assert b"load 2 N, 3 seeds" in picture.csv()
    assert picture.svg().startswith(b"<?xml")


def test_curves_have_the_order_of_a_swept_number_alone(runs) -> None:
    results = run_results(runs.three())
    assert is_ordered(results)
    assert not is_ordered(results[::-1])
    for values in ({}, {"surface.seed": 1}, {"surface.kind": "a"}, {"rolling.load_n": True}):
        assert not is_ordered([replace(run, values=values) for run in results])
    both = [replace(run, values=run.values | {"surface.seed": k}) for k, run in enumerate(results)]
    assert not is_ordered(both)
