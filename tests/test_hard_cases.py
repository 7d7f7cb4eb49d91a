"""Scenes that break contact solvers: each must solve within its iteration budget and hold the contact conditions, or be refused.

Budgets are twice the iterations measured when the test was written, so a slower solver is seen before it is a hanging one.
"""

from __future__ import annotations

import warnings
from collections import Counter

import numpy as np
import pytest
from conftest import STEEL, assert_solved, make_track, rough, step_energies

from rolling import reference
from rolling.contact import ContactError
from rolling.half_space import HalfSpace
from rolling.march import ContactState, RollingContact, march


def random_scene(seed: int) -> tuple[RollingContact, str]:
    """A scene from far and wide, and what is special about its surface.

    Load over 10 decades, E* over 9, R from 50 um to 1 m; the spacing follows from a Hertz radius of 0.02 to 20 nodes (one in ten
    wider: mostly refused). Hardness: 4 decades below to 2 above the Hertz pressure, or none.
    """
    rng = np.random.default_rng([20250117, seed])
    along, across = (int(n) for n in rng.integers(16, 65, 2))
    load, modulus, radius = 10 ** rng.uniform(-6, 4), 10 ** rng.uniform(3, 12), 10 ** rng.uniform(-4.3, 0)
    nodes = 10 ** rng.uniform(np.log10(0.02), np.log10(20)) * (5 if rng.random() < 0.1 else 1)
    spacing = reference.hertz_radius(load, radius, modulus) / nodes
    peak = reference.hertz_pressure(load, radius, modulus)
    hardness = np.inf if rng.random() < 0.25 else peak * 10 ** rng.uniform(-4, 2)
    heights = np.zeros((along, across))
    if rng.random() < 0.8:
        length = spacing * 10 ** rng.uniform(-0.5, 0.7)
        heights = rough(along, across, spacing * 10 ** rng.uniform(-6, 1), seed, spacing, length)
    feature = str(rng.choice(["plain", "spike", "hole", "cliff", "trench"]))
    size = spacing * 10 ** rng.uniform(-3, 1.5)
    i, j = rng.integers(along), rng.integers(across)
    if feature in ("spike", "hole"):
        heights[i, j] += size if feature == "spike" else -size
    elif feature == "cliff":
        heights[:i] += size
    elif feature == "trench":
        heights[:, j] -= size
    track = make_track(
        heights,
        spacing=spacing,
        radius=radius,
        contact_modulus=modulus,
        load=load,
        hardness=hardness,
        step=spacing * rng.choice([0.5, 1, 1, 2, 5]),
        start=spacing * rng.choice([0, 0.3, along / 2]),
        tolerance=10.0 ** -rng.integers(3, 8),
    )
    return track, feature


def try_scene(track: RollingContact, steps: int = 3) -> tuple[str, int]:
    """What became of a scene (solved, or why it was refused) and its most iterations; raises where an answer is wrong."""
    space = HalfSpace(track.spacing, track.contact_modulus)
    states = []
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for state in march(track, 0, steps, space):
                states.append(state)
    except ContactError as error:
        message = str(error)
        assert sum(c.isdigit() for c in message) >= 3, message
        assert "nan" not in message and "inf " not in message, message
        for reason in ("more than the surface can carry", "um wide", "stopped after"):
            if reason in message:
                return reason, 0
        raise AssertionError(message) from error
    for state in states:
        assert_solved(track, state)
    for old, new, step in zip(states, states[1:], step_energies(track, states), strict=False):
        assert abs(step.defect) <= 1e-12 * max(old.stored_energy, new.stored_energy)
    return "solved", max(state.iterations for state in states)


def solve_hard(track: RollingContact, budget: int, steps: int = 3, first: int = 0) -> list[ContactState]:
    """March, check every state against its own convolution and the ledger, and the iterations of each against the budget."""
    space = HalfSpace(track.spacing, track.contact_modulus)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        states = list(march(track, first, first + steps, space))
    for state in states:
        assert_solved(track, state)
        assert state.iterations <= budget, [s.iterations for s in states]
        assert state.residual <= track.tolerance
    largest = max(state.stored_energy for state in states)
    assert max((abs(step.defect) for step in step_energies(track, states)), default=0.0) <= 1e-12 * largest
    return states


def test_smooth_sphere() -> None:
    """Every node of a ring meets or leaves its bound at once, by symmetry."""
    states = solve_hard(make_track(np.zeros((60, 61)), load=2.0), budget=40)
    assert states[0].contact_area == states[-1].contact_area


def test_roughness_of_a_picometre() -> None:
    """Heights of 1e-12 m under deflections of 4e-7 m: the symmetry is broken by nearly nothing, and must not be by more."""
    smooth = solve_hard(make_track(np.zeros((60, 61)), load=2.0), budget=40)
    rough_ = solve_hard(make_track(rough(60, 61, 1e-12), load=2.0), budget=40)
    for one, other in zip(smooth, rough_, strict=True):
        assert other.approach == pytest.approx(one.approach, abs=5e-12)
        assert other.stored_energy == pytest.approx(one.stored_energy, rel=1e-4)


@pytest.mark.parametrize("nodes", [1, 9, 21, 100])
def test_everything_plastic_with_no_node_left_free(nodes: int) -> None:
    """W / (H dA) is a whole number and H 1e-4 of the Hertz pressure: p is 0 or H everywhere and unique, while the approach is
    free over an interval. It must stay between the highest capped and the lowest open gap."""
    heights = rough(40, 40, 3e-7)
    hardness = 1e6
    track = make_track(heights, hardness=hardness, load=nodes * hardness * 4e-12, radius=5e-4, tolerance=1e-6)
    for state in solve_hard(track, budget=80):
        assert state.contact_area == pytest.approx(nodes * 4e-12, rel=1e-12)
        assert state.plastic_area == state.contact_area
        gap = track.gap(state.position, state.window) + state.deflection
        assert gap[state.pressure > 0].max() <= state.approach <= gap[state.pressure == 0].min()


def test_rigid_plastic_limit_of_the_area() -> None:
    """As E* rises or H falls the contact area tends to W / H: never below it, above it by the nodes that are not yet at H."""
    load, hardness = 0.2, 2e8  # 250 nodes
    excess = []
    for stiffer in (1.0, 10.0, 1000.0):
        track = make_track(
            rough(60, 60, 5e-8), load=load, hardness=hardness, contact_modulus=stiffer * STEEL, tolerance=1e-6
        )
        state = solve_hard(track, budget=80, steps=0)[0]
        excess.append(state.contact_area / (load / hardness) - 1)
    assert excess[0] > excess[1] > excess[2] >= 0
    assert excess[2] < 0.01  # at 1000 times steel's modulus fewer than 3 of 250 nodes are between the bounds


@pytest.mark.parametrize("share", [1.0, 1.001, 1e6])
def test_load_above_capacity_is_refused_with_the_limit(share: float) -> None:
    """No pressure below the hardness carries it: a solver that only iterates would not end."""
    heights, hardness = rough(30, 20, 1e-7), 1e6
    capacity = hardness * heights.size * 4e-12
    track = make_track(heights, hardness=hardness, load=share * capacity)
    with pytest.raises(ContactError, match=r"can carry: hardness 1e\+06 Pa .*2.4e-09 m2 is 0.0024 N.*lower load"):
        next(march(track, 0, 0, HalfSpace(track.spacing, track.contact_modulus)))


def test_load_just_below_capacity_is_refused_as_too_wide_or_solved() -> None:
    """99 % of the capacity fills the period to its corners, more than a window of contact can: refused with the width needed."""
    heights, hardness = rough(30, 20, 1e-9), 1e6
    track = make_track(heights, hardness=hardness, load=0.99 * hardness * heights.size * 4e-12)
    with pytest.raises(ContactError, match=r"contact is [\d.]+ um wide .*one period of the surface"):
        next(march(track, 0, 0, HalfSpace(track.spacing, track.contact_modulus)))


def test_contact_wider_than_the_surface_is_refused_with_the_width() -> None:
    track = make_track(np.zeros((30, 20)), load=5.0)  # Hertz: 86.6 um on 60 by 40
    with pytest.raises(ContactError, match=r"86\.\d+ um wide along the track.*\(60 um\).*rolling\.duration_s"):
        next(march(track, 0, 0, HalfSpace(track.spacing, track.contact_modulus)))


@pytest.mark.parametrize(
    ("height", "hardness"),
    [(1e-9, np.inf), (1e-6, np.inf), (1e-4, np.inf), (-1e-4, np.inf), (1e-6, 2.1e9), (-1e-4, 2.1e9)],
)
def test_single_node_spike(height: float, hardness: float) -> None:
    """One node stands out by up to 50 spacings; an elastic one alone takes pressures far above all others. A hole: gap 1e-4 m."""
    heights = rough(60, 60, 1e-8)
    heights[2, 30] += height
    # The spike's pressure swings through the whole range as the sphere passes over it.
    solve_hard(make_track(heights, load=0.5, hardness=hardness, tolerance=1e-7), budget=80, steps=6)


@pytest.mark.parametrize("hardness", [np.inf, 2.1e9])
@pytest.mark.parametrize("axis", [0, 1])
def test_cliff(axis: int, hardness: float) -> None:
    """Half of the plate lies 20 um lower, through the middle of the contact: pressure is singular along the edge."""
    heights = rough(60, 60, 1e-8)
    np.moveaxis(heights, axis, 0)[:30] += 2e-5
    states = solve_hard(make_track(heights, load=0.3, hardness=hardness, tolerance=1e-7), budget=80, steps=8, first=24)
    assert len({state.contact_area for state in states}) > 1 or axis == 1


@pytest.mark.parametrize("axis", [0, 1])
def test_trench(axis: int) -> None:
    """A groove 3 nodes wide and 100 um deep through the contact: it splits in two halves that only the deflection couples."""
    heights = rough(60, 60, 1e-8)
    np.moveaxis(heights, axis, 0)[29:32] -= 1e-4
    states = solve_hard(make_track(heights, load=0.5, hardness=2.1e9, tolerance=1e-7), budget=80, first=28)
    for state in states:
        rows, columns = np.nonzero(state.pressure)
        nodes = (rows + state.window.row, columns + state.window.column)[axis] % 60
        assert not np.isin(nodes, (29, 30, 31)).any()
        assert (nodes < 29).any() and (nodes > 31).any()


def test_first_touch_on_one_node() -> None:
    """A load so low that one node carries it all: there is nothing to iterate, and its deflection is known in closed form."""
    track = make_track(rough(60, 60, 1e-7), load=1e-9)
    for state in solve_hard(track, budget=10):
        assert state.contact_area == track.spacing**2
        own = 4 * np.log(1 + np.sqrt(2)) * track.load / (np.pi * STEEL * track.spacing)
        assert state.deflection.max() == pytest.approx(own, rel=1e-12)
        assert state.approach == pytest.approx(track.gap(state.position, state.window).min() + own, rel=1e-12)


@pytest.mark.parametrize(
    ("load", "radius", "modulus", "spacing"),
    [
        (1e-6, 5e-3, STEEL, 1e-8),
        (1e4, 1.0, STEEL, 2e-4),
        (1e4, 5e-3, STEEL, 4e-5),
        (5.0, 1.0, STEEL, 2e-5),
        (0.01, 50e-6, STEEL, 1e-7),
        (1e-6, 5e-3, 1e3 / 0.75, 5e-6),
        (5.0, 5e-3, 1.15e12, 2e-6),
    ],
    ids=["1 uN", "10 kN", "10 kN on 5 mm", "R 1 m", "R 50 um", "gel", "diamond"],
)
def test_extremes_of_load_size_and_stiffness(load: float, radius: float, modulus: float, spacing: float) -> None:
    """Numbers of SI from 1e-12 m to 1e12 Pa: any absolute threshold in the solver shows. Roughness a tenth of the approach."""
    approach = reference.hertz_approach(load, radius, modulus)
    heights = rough(100, 90, 0.1 * approach, spacing=spacing, length=5 * spacing)
    changes = {"load": load, "radius": radius, "contact_modulus": modulus, "spacing": spacing, "tolerance": 1e-7}
    states = solve_hard(make_track(heights, **changes), budget=60)
    assert states[0].approach == pytest.approx(approach, rel=0.6)  # of the order of Hertz's, whatever the units
    peak = reference.hertz_pressure(load, radius, modulus)
    solve_hard(make_track(heights, hardness=0.7 * peak, **changes), budget=60)


@pytest.mark.parametrize("shape", [(37, 61), (61, 37), (51, 200), (200, 51)])
def test_odd_and_non_square_windows(shape: tuple[int, int]) -> None:
    """Ridges along one side make the contact long and narrow: windows of different transforms in the two directions."""
    rng = np.random.default_rng(1)
    heights = 2e-7 * (rng.standard_normal((shape[0], 1)) if shape[0] < shape[1] else rng.standard_normal((1, shape[1])))
    states = solve_hard(make_track(np.broadcast_to(heights, shape).copy(), load=0.2, hardness=2.1e9), budget=80)
    assert any(state.window.rows != state.window.columns for state in states)


def test_seam_of_the_periodic_surface() -> None:
    """Contact across the seam along and, by a start half a surface away, not: the same answer at the same heights moved."""
    heights = rough(60, 60, 2e-7)
    across_it = solve_hard(make_track(heights, load=0.3, hardness=2.1e9), budget=80, first=58)
    assert across_it[0].loaded.row < 60 <= across_it[0].loaded.row + across_it[0].loaded.rows - 1
    inside = solve_hard(make_track(np.roll(heights, 30, axis=0), load=0.3, hardness=2.1e9), budget=80, first=28)
    for one, other in zip(across_it, inside, strict=True):
        assert one.approach == pytest.approx(other.approach, abs=1e-7 * one.deflection.max())


@pytest.mark.parametrize("hardness", [np.inf, 2.1e9])
def test_slopes_far_above_one(hardness: float) -> None:
    """White noise of 20 um on a 2 um grid, rms slope 14 each way: a few tips, far apart, 1e4 times their deflection high.
    A small sphere: a large one would touch the images as well."""
    heights = np.random.default_rng(5).standard_normal((60, 60)) * 2e-5
    states = solve_hard(
        make_track(heights, load=0.001, radius=1e-4, hardness=hardness, tolerance=1e-7), budget=80, steps=6
    )
    assert all(state.contact_area < 200 * 4e-12 for state in states)


def test_one_outlier() -> None:
    """A height of 1 mm from a faulty instrument: the overlap is looked for on a disc of 6 mm, and the one node carries it all."""
    heights = rough(60, 60, 1e-7)
    heights[40, 7] = 1e-3
    states = solve_hard(make_track(heights, load=0.05, tolerance=1e-7), budget=20)
    assert states[0].approach < -9e-4
    assert states[0].contact_area == 4e-12


def test_load_that_heights_dwarf_is_still_carried_exactly() -> None:
    """A cliff of 20 um under 1/3 uN: springs stiff enough for the contact turn 20 um into 1e8 times its pressures, and what the
    subtraction leaves of the load must be put right. (1 uN happens to be a round number of Pa.)"""
    heights = np.zeros((60, 60))
    heights[:30] = 2e-5
    heights += rough(60, 60, 1e-8)
    solve_hard(make_track(heights, load=1e-6 / 3, tolerance=1e-6), budget=40, first=10)


@pytest.mark.parametrize(
    ("nodes", "hardness", "radius", "step_nodes"),
    [(50.5, 1e6, 5e-5, 10), (0.5, 1e8, 5e-5, 10), (20.5, 1e6, 2e-5, 5), (5.5, 1e7, 2e-5, 10), (1.5, 1e8, 2e-5, 10)],
)
def test_many_nodes_bound_at_once(nodes: float, hardness: float, radius: float, step_nodes: int) -> None:
    """A step longer than the contact over deep roughness at low hardness: more than half of the window is on the wrong bound, and
    hardly a node is free to take the load up. W / (H dA) is as given: all plastic but one node, or one elastic node."""
    heights = rough(50, 50, 1e-6, length=4e-6)
    load = nodes * hardness * 4e-12
    track = make_track(heights, load=load, hardness=hardness, radius=radius, step=step_nodes * 2e-6, tolerance=1e-4)
    states = solve_hard(track, budget=100, steps=12)
    assert states[0].plastic_area == int(nodes) * 4e-12


def test_window_beyond_all_room_is_a_contact_error() -> None:
    """Capacity allows it, and the contact would be 11 mm wide: refused as a contact, in numbers, not from inside a transform."""
    track = make_track(np.broadcast_to(np.zeros(1), (12000, 12000)), hardness=1e5, load=28.0)
    with pytest.raises(ContactError, match=r"\d"):
        next(march(track, 0, 0, HalfSpace(track.spacing, track.contact_modulus)))


def test_no_drift_over_many_steps() -> None:
    """Ten laps on a tiny surface: a warm-started march must not gather error. The last lap equals the first to its tolerance."""
    track = make_track(rough(30, 36, 5e-8), load=0.03, hardness=2.1e9, tolerance=1e-5)
    states = solve_hard(track, budget=40, steps=300)
    approach = np.array([state.approach for state in states]).reshape(-1)[:300].reshape(10, 30)
    scale = states[0].deflection.max()
    assert np.abs(approach[-1] - approach[0]).max() < 10 * track.tolerance * scale
    released = np.array([step.release for step in step_energies(track, states)]).reshape(10, 30)
    assert np.ptp(released.sum(axis=1)) < 1e-3 * released.sum(axis=1).mean()


def test_random_scenes_are_solved_or_refused() -> None:
    """150 of the 5,000 scenes that were tried by hand, the seeds that ever failed among them; the share solved is on record.

    Every answer is checked by a convolution of its own; a refusal must name numbers; warnings are errors.
    """
    failed_once = [8, 115, 136, 214, 232, 677, 715, 723, 805, 1290, 1548]
    outcomes, iterations = Counter(), []
    for seed in [*failed_once, *range(1000, 1140)]:
        outcome, most = try_scene(random_scene(seed)[0])
        outcomes[outcome] += 1
        if outcome == "solved":
            iterations.append(most)
    assert outcomes["stopped after"] == 0, outcomes
    assert outcomes["solved"] > 90, outcomes
    assert max(iterations) <= 150
    assert np.median(iterations) <= 6


@pytest.mark.parametrize("excess", [1e-6, 1e-10, -1e-10, 1e-12])
def test_all_but_a_trace_of_the_load_on_capped_nodes(excess: float) -> None:
    """Ten capped nodes carry the load but for a trace on one more: too small for any deflection to tell, yet the load's own."""
    cap, cell = 1e6, 4e-12
    track = make_track(rough(64, 64, 1e-6), radius=2e-4, hardness=cap, load=cap * cell * (10 + excess), tolerance=1e-4)
    for state in solve_hard(track, budget=20):
        assert state.plastic_area == pytest.approx(10 * cell, abs=cell)
