"""Windows leave out nodes that the deflection by the whole load keeps open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers import assert_solved, make_track, measures, roll, rough

from rolling.contact.state import NEAR_CELLS, SURE
from rolling.contact.subcells import half_space_of

SPACING = 1e-6
MODULUS = 1e11


@pytest.mark.parametrize("subcells", [1, 2, 4])
@pytest.mark.parametrize("seed", range(4))
def test_no_deflection_is_below_that_at_the_root_mean_square_distance(
    seed: int, subcells: int
) -> None:
    """Single nodes, and loads far apart, in the middle or beside the centre of the sphere."""
    rng = np.random.default_rng(seed)
    side = 24 * subcells
    pressure = np.zeros((side, side))
    few = int(10 ** rng.uniform(0, 2.5))
    low, high = np.sort(rng.integers(0, side, 2))
    pressure[tuple(rng.integers(low, high + 1, (2, few)))] = 1e9 * rng.random(few)
    mean = np.average(np.argwhere(pressure), axis=0, weights=pressure[pressure > 0])
    centre = mean if seed % 2 else rng.uniform(0, side, 2)
    distance = np.hypot(*(np.mgrid[:side, :side] - np.reshape(centre, (2, 1, 1))))
    u = half_space_of(SPACING, MODULUS, subcells).deflection(pressure)
    edge = np.empty((0, 0))
    load = SURE * pressure.sum() * SPACING / (np.pi * MODULUS)
    for reach in (distance.max(), 0.5 * distance.max()):
        measured = measures(pressure, u, np.inf, edge, 0.0, *centre, reach)
        near = NEAR_CELLS * subcells if subcells > 1 else 0.0
        least = load / np.sqrt(distance**2 + measured[4] ** 2 + near**2)
        assert (u >= least)[distance <= reach].all()


@pytest.mark.parametrize(
    ("hardness", "subcells", "load", "share", "convolutions"),
    # 0.84, 0.86 and 0.97 of the area and 3.1, 3.0 and 5.1 convolutions are measured. Windows have a
    # border and the next overlap beside their own.
    [(np.inf, 1, 20.0, 0.9, 3.5), (2.1e9, 1, 20.0, 0.9, 3.5), (2.1e9, 2, 5.0, 1.0, 5.8)],
)
def test_windows_are_smaller_than_the_overlap_and_hold_all_contact(
    hardness: float, subcells: int, load: float, share: float, convolutions: float
) -> None:
    """Off the window before, deflections continue at its border, so that starts stay as good."""
    track = make_track(rough(256, 256, 1e-7), load=load, hardness=hardness, tolerance=1e-4)
    step = track.spacing * subcells
    track = replace(track, blended=np.isfinite(hardness), subcells=subcells, step=step)
    states = roll(track, 0, 12)[2:]
    shares = []
    for state in states:
        assert_solved(track, state)
        overlap = track.overlap(state.position, state.approach)
        window = state.window
        shares.append(window.rows * window.columns / (overlap.rows * overlap.columns))
    assert np.mean(shares) < share
    assert np.mean([state.convolutions for state in states]) < convolutions
