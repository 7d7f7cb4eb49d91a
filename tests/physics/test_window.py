"""The window is the geometric overlap, which contact cannot leave.

A window twice as large, or an island, changes nothing.
"""

from __future__ import annotations

import numpy as np
import pytest
from helpers import STEEL, assert_solved, make_track, releases, roll, rough, space_of

from rolling.contact import solver
from rolling.contact.state import Window


@pytest.mark.law("Window: a window twice as large gives the same answer.")
@pytest.mark.parametrize("hardness", [np.inf, 2.1e9], ids=["elastic", "capped"])
def test_window_twice_as_large_gives_the_same_answer(hardness: float) -> None:
    """Two windows agree to the solver's tolerance of 1e-9.

    Zero padding makes the convolution exact on any window.
    """
    track = make_track(rough(60, 60, 2e-7), load=0.5, hardness=hardness, tolerance=1e-9)
    for state in roll(track, 3, 5):
        w = state.window
        large = Window(w.row - w.rows // 2, w.column - w.columns // 2, 2 * w.rows, 2 * w.columns)
        e = track.gap(state.position, large)
        start = solver.foundation(
            e, track.load, track.spacing, 4 * STEEL / (np.pi * 20e-6), hardness
        )
        solved = solver.solve_contact(
            space_of(track),
            e,
            track.load,
            solver.WarmStart(start),
            hardness,
            tolerance=track.tolerance,
        )
        inner = large.moved(solved.pressure, w)
        assert np.abs(inner - state.pressure).max() < 1e-7 * state.max_pressure
        assert solved.pressure.sum() == pytest.approx(inner.sum(), rel=1e-14)  # nothing outside
        assert solved.approach == pytest.approx(state.approach, abs=1e-8 * state.deflection.max())


@pytest.mark.law("Window: the geometric overlap holds every node that can be in contact.")
def test_overlap_holds_every_node_below_the_approach() -> None:
    """The overlap has every node below the approach, over a period and half a node each way.

    The surface is rough enough for a ragged overlap.
    """
    track = make_track(rough(33, 41, 1e-6), load=0.5, start=1.3e-6)
    big = Window(-33, -41, 3 * 33, 3 * 41)
    for k, approach in ((0, -1e-6), (4, 0.0), (9, 3e-7), (17, 1e-6)):
        i, j = np.nonzero(track.gap(k, big) < approach)
        x = (i + big.row) * track.spacing - track.position(k)
        y = (j + big.column) * track.spacing - track.mid_width
        near = (abs(x) <= 33.5 * track.spacing) & (abs(y) <= 41.5 * track.spacing)
        i, j = i[near] + big.row, j[near] + big.column
        found = track.overlap(k, approach)
        if not near.any():
            assert found is None
        else:
            rows, columns = np.ptp(i) + 1, np.ptp(j) + 1
            assert found == Window(i.min(), j.min(), rows, columns)


@pytest.mark.law("Window: a detached island of contact is found.")
def test_detached_island_is_found() -> None:
    """A hill of 1 um, 90 um ahead of a contact 20 um wide, carries its own load.

    It lies far outside any window that a margin would give.
    """
    heights = np.zeros((160, 80))
    heights[44:47, 38:42] = 1e-6  # the paraboloid is 0.8 um above the plate at 90 um
    track = make_track(heights, load=0.5, tolerance=1e-7)
    state = roll(track, 0, 0)[0]
    assert_solved(track, state)
    island = state.pressure[44 - state.window.row : 47 - state.window.row].sum() * track.spacing**2
    centre = state.pressure[: 30 - state.window.row].sum() * track.spacing**2
    assert island > 0.05 * track.load
    assert centre > 0.05 * track.load
    assert island + centre == pytest.approx(track.load, rel=1e-12)


@pytest.mark.law("Window: an island of contact that rises during the march is found.")
def test_island_that_rises_during_the_march_is_found() -> None:
    """Each position of a march to the same hill agrees with a cold solve."""
    heights = np.zeros((160, 80))
    heights[60:63, 38:42] = 1e-6
    track = make_track(heights, load=0.5, tolerance=1e-7)
    states = roll(track, 0, 24)
    rows = [state.loaded.row + state.loaded.rows - 1 for state in states]
    assert rows[0] < 30 and rows[-1] >= 60
    for state in states[::6]:
        assert_solved(track, state)
        cold = roll(track, state.position, state.position)[0]
        assert state.approach == pytest.approx(cold.approach, abs=1e-6 * state.deflection.max())


@pytest.mark.law("Window: the release counts nodes that have lost contact.")
def test_release_counts_nodes_that_lost_contact() -> None:
    """Energies on the union of both windows equal those on a window over everything."""
    track = make_track(rough(60, 60, 1e-6), load=0.01, tolerance=1e-8)
    states = roll(track, 0, 12)
    everything = Window(-60, -30, 150, 120)
    space, whole = space_of(track), []
    for state in states:
        p = state.window.moved(state.pressure, everything)
        whole.append((p, space.deflection(p)))
    for k, released in enumerate(releases(track, states)):
        (p, u), (q, v) = whole[k], whole[k + 1]
        work = (p + q) / 2 * (u - v) * track.spacing**2
        assert released == pytest.approx(work[work > 0].sum(), rel=1e-9)
