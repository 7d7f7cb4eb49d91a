"""Blended edges are closer to a fine grid than sharp edges and have no history.

Every law of sharp edges holds with them.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hard_cases.gaussian_heights import gaussian
from helpers import assert_solved, make_track, releases, roll, rough, space_of, step_energies

from rolling.contact import single_contact
from rolling.contact.state import RollingContact
from rolling.surface.refined import refined
from rolling.surface.subcell_contact import on_subcells

HARDNESS = 2.1e9


@pytest.fixture(scope="module")
def coarse() -> RollingContact:
    return make_track(rough(100, 100, 1e-7), load=2.0, hardness=HARDNESS, tolerance=1e-4)


def blended(track: RollingContact, subcells: int = 1, **changes: object) -> RollingContact:
    return on_subcells(replace(track, blended=True, **changes), subcells)


def error_db(signal: np.ndarray, reference: np.ndarray) -> float:
    return float(20 * np.log10(np.std(signal - reference) / np.std(reference)))


@pytest.mark.slow
@pytest.mark.law("Blended edges: the release is closer to a fine grid than with sharp edges.")
def test_release_is_closer_to_a_fine_grid_for_few_more_convolutions(
    coarse: RollingContact,
) -> None:
    """Against 0.67 um the error and the area of blended edges are well below those of sharp edges.

    docs/accuracy.md has longer tracks, other surfaces and finer references.
    """
    steps = 80
    sharp = roll(coarse, 0, steps)
    soft = roll(blended(coarse), 0, steps)
    fine = replace(coarse, heights=refined(coarse.heights, 3), spacing=coarse.spacing / 3)
    finest = roll(blended(fine), 0, steps)
    reference = releases(fine, finest)
    error_sharp = error_db(releases(coarse, sharp), reference)
    error_blended = error_db(releases(coarse, soft), reference)
    assert error_blended < error_sharp - 5, (error_sharp, error_blended)
    convolutions = [
        np.mean([state.convolutions for state in states[1:]]) for states in (sharp, soft)
    ]
    assert convolutions[1] < 1.2 * convolutions[0]
    area = [np.mean([state.contact_area for state in states]) for states in (sharp, soft, finest)]
    assert abs(area[1] / area[2] - 1) < abs(area[0] / area[2] - 1) / 2, area


@pytest.mark.slow
@pytest.mark.law("Blended edges: the contact conditions and the energy ledger hold.")
@pytest.mark.parametrize("subcells", [1, 2, 4])
def test_every_law_holds(coarse: RollingContact, subcells: int) -> None:
    """Contact conditions of partial cells, bounds, load and energy ledger hold."""
    track = blended(coarse, subcells, tolerance=1e-7)
    states = roll(track, 5, 9)
    for state in states:
        assert_solved(track, state)
        assert state.edge is not None and state.edge.max() > 0
    for (old, new), step in zip(pairwise(states), step_energies(track, states), strict=True):
        assert abs(step.defect) <= 1e-13 * max(old.stored_energy, new.stored_energy)


def test_share_of_a_cell_and_its_gap(coarse: RollingContact) -> None:
    """In a cell that an edge crosses, gap = edge (1 - 2 p / H).

    The cell is open at one end of this line and at the hardness at the other.
    """
    track = blended(coarse, tolerance=1e-8)
    state = roll(track, 0, 0)[0]
    gap = track.gap(0, state.window) + state.deflection - state.approach
    between = (state.pressure > 0) & (state.pressure < HARDNESS)
    expected = state.edge * (1 - 2 * state.pressure / HARDNESS)
    rounding = 2e-8 * state.deflection.max()
    assert np.abs(gap - expected)[between].max() < rounding
    assert (gap >= expected - rounding)[state.pressure == 0].all()
    assert (gap <= expected + rounding)[state.pressure == HARDNESS].all()


@pytest.mark.law("Blended edges: a march that begins anywhere has the same release.")
@pytest.mark.parametrize("subcells", [1, pytest.param(2, marks=pytest.mark.slow)])
@pytest.mark.parametrize("ra", [1e-7, 5e-7])
def test_no_start_of_the_march_is_remembered(ra: float, subcells: int) -> None:
    """Edges belong to the solution: at 1e-7 pieces agree with the whole march to -60 dB."""
    track = make_track(rough(60, 60, ra), load=0.1, hardness=HARDNESS, tolerance=1e-7)
    track = blended(track, subcells)
    whole = releases(track, roll(track, 0, 12))
    pieces = np.concatenate([releases(track, roll(track, k, k + 4)) for k in range(0, 12, 4)])
    assert error_db(pieces, whole) < -60


@pytest.mark.law("Blended edges: the second lap equals the first.")
@pytest.mark.parametrize("subcells", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_second_lap_equals_the_first(subcells: int) -> None:
    track = make_track(rough(50, 60, 1e-7), load=0.1, hardness=HARDNESS, tolerance=1e-7)
    track = blended(track, subcells)
    signal = releases(track, roll(track, 0, 100))
    assert error_db(signal[50:], signal[:50]) < -60


@pytest.mark.parametrize("subcells", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_history_stays_below_the_error_of_the_solver(subcells: int) -> None:
    """Any start agrees better than the solver at 1e-4, and from the fourth step on by 25 dB."""
    exact, track = (
        blended(
            make_track(rough(60, 60, 1e-7), load=0.2, hardness=HARDNESS, tolerance=tolerance),
            subcells,
        )
        for tolerance in (1e-7, 1e-4)
    )
    signal = releases(track, roll(track, 0, 60))
    solver = error_db(signal, releases(exact, roll(exact, 0, 60)))
    for first in (20, 30, 40):
        later = releases(track, roll(track, first, 60))
        assert error_db(later, signal[first:]) < solver
        assert error_db(later[3:], signal[first + 3 :]) < solver - 25
    # The second lap begins with another history than the first.
    lap = releases(track, roll(track, 60, 120))
    assert error_db(lap, signal) < solver
    assert error_db(lap[3:], signal[3:]) < solver - 25


@pytest.mark.law("Blended edges: the mirrored track releases what the track takes up.")
@pytest.mark.parametrize("subcells", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_mirrored_track_swaps_loading_and_release(subcells: int) -> None:
    heights = rough(80, 80, 3e-7)
    mirrored = np.roll(heights[::-1], 1, axis=0)
    there, back = (
        blended(make_track(z, load=0.2, hardness=HARDNESS, tolerance=1e-7), subcells)
        for z in (heights, mirrored)
    )
    forth = step_energies(there, roll(there, 3, 13))
    home = step_energies(back, roll(back, -13, -3))[::-1]
    release = np.array([step.release for step in forth])
    assert error_db(np.array([step.loading for step in home]), release) < -60


@pytest.mark.law("Blended edges: an elastic contact is not changed.")
def test_without_hardness_nothing_is_blended(coarse: RollingContact) -> None:
    elastic = replace(coarse, hardness=np.inf)
    one = roll(elastic, 0, 3)
    other = roll(replace(elastic, blended=True), 0, 3)
    assert all(np.array_equal(a.pressure, b.pressure) for a, b in zip(one, other, strict=True))


@pytest.mark.law("Blended edges: where the hardness is far off, edges are sharp.")
def test_a_hardness_that_is_nowhere_near_changes_nothing() -> None:
    """Pressures below the hardness level all slopes within cells: not a node is partly loaded."""
    track = make_track(rough(60, 60, 1e-8), load=0.3, hardness=1e15, tolerance=1e-8)
    for sharp, soft in zip(roll(track, 0, 3), roll(blended(track), 0, 3), strict=True):
        assert not soft.edge.any()
        pressure = soft.window.moved(soft.pressure, sharp.window)  # its window is wider
        assert np.abs(pressure - sharp.pressure).max() < 1e-6 * sharp.max_pressure
        assert soft.contact_area == sharp.contact_area and soft.plastic_area == 0


def test_no_edge_is_no_change(coarse: RollingContact) -> None:
    """A gap that runs on level within its cells has no edges: the sharp problem is solved."""
    track = replace(coarse, tolerance=1e-9)
    sharp = roll(track, 0, 0)[0]
    gap = track.gap(0, sharp.window)
    start = single_contact.WarmStart(sharp.pressure, close=True)
    level = -sharp.deflection  # with it the deflected gap has no slope at all
    again = single_contact.solve_contact(
        space_of(track), gap, track.load, start, HARDNESS, level, track.tolerance
    )
    assert not again.edge.any()
    assert np.abs(again.pressure - sharp.pressure).max() < 1e-6 * HARDNESS


@pytest.mark.parametrize("is_blended", [False, True])
def test_a_single_contact_has_the_plastic_area_of_the_march(
    coarse: RollingContact, is_blended: bool
) -> None:
    """The same position solved alone has the same plastic area, with partial cells and without."""
    track = blended(coarse) if is_blended else coarse
    state = roll(track, 0, 0)[0]
    shape = None
    if is_blended:
        smooth = replace(track, heights=np.zeros_like(track.heights))
        shape = track.gap(0, state.window) if track.slopes else smooth.gap(0, state.window)
    alone = single_contact.solve_contact(
        space_of(track),
        track.gap(0, state.window),
        track.load,
        hardness=track.hardness,
        shape=shape,
        tolerance=track.tolerance,
    )
    assert state.plastic_area > 0
    # A node at the rim of a patch may differ by the tolerance of the solves.
    assert alone.plastic_area == pytest.approx(state.plastic_area, rel=0.01)
    assert alone.max_pressure == pytest.approx(state.max_pressure, rel=1e-6)


def test_where_nothing_yields_no_area_is_plastic() -> None:
    """A hardness that no pressure reaches leaves the areas of sharp edges."""
    track = make_track(rough(100, 100, 1e-8), load=0.3, hardness=HARDNESS, tolerance=1e-6)
    sharp = roll(track, 0, 5)
    soft = roll(blended(track), 0, 5)
    for state in (*sharp, *soft):
        assert state.max_pressure < HARDNESS and state.plastic_area == 0
    areas = [np.mean([state.contact_area for state in states]) for states in (sharp, soft)]
    assert areas[1] == pytest.approx(areas[0], rel=0.02)


def test_areas_of_blended_edges_are_those_of_a_fine_grid(coarse: RollingContact) -> None:
    """Against 0.67 um, sharp edges leave the plastic area 5 % low and the contact area 7 % high."""
    steps = 30
    fine = replace(coarse, heights=refined(coarse.heights, 3), spacing=coarse.spacing / 3)
    tracks = (coarse, blended(coarse), blended(fine))
    marches = [roll(track, 0, steps) for track in tracks]
    plastic, contacts = (
        [np.mean([getattr(state, name) for state in states]) for states in marches]
        for name in ("plastic_area", "contact_area")
    )
    for sharp, soft, finest in (plastic, contacts):
        assert abs(soft / finest - 1) < 0.04
        assert abs(soft / finest - 1) < 0.6 * abs(sharp / finest - 1)


# A hard ceramic plate whose asperities bear less than its hardness at almost all positions. The
# grid is coarse, so that the gap beside an elastic contact rises by more than pressures level.
HARD = RollingContact(
    heights=gaussian((96, 128), 8e-6, 0.3e-6, (40e-6, 40e-6), "gaussian", 1),
    spacing=8e-6,
    radius=2e-3,
    contact_modulus=400e9 / 0.91,
    hardness=8e9,
    load=2.0,
    step=8e-6,
    start=0.0,
    tolerance=1e-7,
)


@pytest.mark.law("Blended edges: below the hardness no area is plastic and edges are sharp.")
@pytest.mark.parametrize(
    ("hardness", "subcells"),
    [(8e9, 1), pytest.param(8e9, 2, marks=pytest.mark.slow), (5e9, 1), (5e9, 2)],
)
def test_a_position_below_the_hardness_is_elastic(hardness: float, subcells: int) -> None:
    """The pressures of sharp edges are met to ten times the tolerance, and contact area exactly."""
    track = blended(HARD, subcells, hardness=hardness)
    states = roll(track, 0, 40)
    elastic = [state for state in states if state.max_pressure < hardness]
    assert len(elastic) > 5
    for state in states:
        assert_solved(track, state)
        assert (state.plastic_area > 0) == (state.max_pressure >= hardness)
    marched = roll(replace(track, blended=False), 0, 40)
    for state in elastic:
        other = marched[state.position]
        pressure = state.window.moved(state.pressure, other.window)  # its window is wider
        assert np.abs(pressure - other.pressure).max() < 1e-6 * other.max_pressure
        assert state.contact_area == other.contact_area


@pytest.mark.parametrize("subcells", [1, 2])
def test_random_contacts_yield_exactly_where_they_reach_the_hardness(subcells: int) -> None:
    """100 random contacts, of which a good part stays below the hardness: no false yielding."""
    rng = np.random.default_rng(28)
    below = 0
    for seed in range(100):
        spacing = 2e-6
        length = rng.uniform(4e-6, 40e-6)
        heights = gaussian(
            (64, 48), spacing, 10 ** rng.uniform(-8.5, -7), (length, length), "gaussian", seed
        )
        heights[tuple(rng.integers(0, 48, (2, 4)))] -= rng.choice([0.0, 1e-7])  # pits
        elastic = make_track(heights, load=10 ** rng.uniform(-3, -1.5), tolerance=1e-7)
        hardness = roll(elastic, 7, 7)[0].max_pressure * 10 ** rng.uniform(-0.3, 0.5)
        sharp = replace(elastic, hardness=hardness)
        state, other = (roll(track, 7, 7)[0] for track in (blended(sharp, subcells), sharp))
        assert (state.plastic_area > 0) == (state.max_pressure >= hardness), seed
        if state.max_pressure < hardness and subcells == 1:
            assert state.contact_area == other.contact_area, seed
        below += state.max_pressure < hardness
    assert 20 < below < 80


@pytest.mark.law("Blended edges: contact is continuous where it begins to yield.")
def test_edges_blend_in_continuously_with_yield() -> None:
    """The deflection follows a falling hardness without a jump from sharp to blended edges.

    In 100 steps of the hardness no step makes more than a twentieth of the whole change, five times
    the mean.
    """
    first = roll(HARD, 5, 5)[0]
    hardnesses = first.max_pressure * np.linspace(1.01, 0.8, 101)
    states = [roll(replace(HARD, hardness=h, blended=True), 5, 5)[0] for h in hardnesses]
    shares = np.array([state.edge_share for state in states])
    assert shares[0] == 0 and shares[-1] > 0 and ((shares > 0) & (shares < 1)).sum() > 10
    deflections = [state.window.moved(state.deflection, first.window) for state in states]
    changes = np.array([np.abs(after - before).max() for before, after in pairwise(deflections)])
    assert changes.max() < changes.sum() / 20
