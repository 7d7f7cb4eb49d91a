"""Parameters of surfaces beside other programs, spheres that collide, and ball bearings."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from rolling.studies import bearing_truths, printed_truths, slope_truths


@pytest.mark.law("Surface parameters: surfalize and SurfaceTopography give the same ones.")
def test_parameters_are_those_of_other_programs() -> None:
    rows = printed_truths.surface_rows()
    assert len(rows) == 32
    for rule, item, published, ours in rows:
        near = 0.02 if rule in ("Sk", "Spk", "Svk", "Smr1", "Smr2") else 1e-5
        assert ours == pytest.approx(published, rel=near), (rule, item)


@pytest.mark.law("Colliding spheres: the sound is that of two dipoles, by a closed form in time.")
def test_colliding_spheres_sound_as_two_dipoles() -> None:
    for rule, item, published, ours in printed_truths.collision_rows():
        assert ours == pytest.approx(published, rel=1e-3, abs=1e-4), (rule, item)


@pytest.mark.law(
    "Bearings: lines, loads and waves are those that are printed, or of linear theory."
)
def test_bearings_turn_bear_and_move_as_printed() -> None:
    rows = list(bearing_truths.bearing_rows())
    assert len(rows) == 23
    near = {
        "line over turns": 1e-3,
        "largest load": 0.01,
        "displacement": 1e-4,
        "motion over wave": 0.03,
    }
    for rule, item, published, ours in rows:
        assert ours == pytest.approx(published, rel=near[rule]), (rule, item)


def test_the_closed_form_solves_its_equation() -> None:
    """The pressure of the nearer sphere starts at rest, and its area over time vanishes."""
    times = 2e-7 * (np.arange(2**15) - 2000)
    pressure = printed_truths.colliding_spheres(times, 0.005)
    assert np.all(pressure[times < -0.01 / 343.2] == 0)
    assert abs(pressure.sum()) < 1e-3 * np.abs(pressure).sum()


def test_a_slope_is_in_decibels_per_decade() -> None:
    """A pressure that follows the power 1.5 rises by 30 dB a decade, on each surface."""
    speeds = np.array([0.3, 1.0, 3.0])
    levels = pd.DataFrame({seed: seed + 30 * np.log10(speeds) for seed in (1, 2)}, index=speeds)
    assert slope_truths.db_per_decade(levels) == pytest.approx([30.0, 30.0])
