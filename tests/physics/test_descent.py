"""A descent of the contact solve keeps its precision and survives a last step that fails."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from helpers import assert_solved, make_track, roll, rough, space_of

from rolling.contact import _candidate_kernels as kernels
from rolling.contact import _descent, _solver_kernels, solver
from rolling.contact._descent import Descent, Effort
from rolling.contact.state import RollingContact


@pytest.fixture(scope="module")
def track() -> RollingContact:
    return make_track(rough(100, 100, 3e-7), load=0.5, hardness=2.1e9, tolerance=1e-4)


@pytest.fixture
def descents(monkeypatch: pytest.MonkeyPatch) -> list[Descent]:
    """Descents of all solves, in the order in which they iterate."""
    listed: list[Descent] = []
    iterate = Descent.iterate

    def listing(self: Descent, effort: Effort) -> None:
        listed.append(self)
        iterate(self, effort)

    monkeypatch.setattr(Descent, "iterate", listing)
    return listed


def test_a_second_descent_stays_in_single_precision(
    track: RollingContact, descents: list[Descent]
) -> None:
    """A first descent that the final check refuses tells nothing about precision."""
    states = roll(replace(track, tolerance=1e-5), 0, 30)
    assert len(descents) > len(states)
    assert all(descent.transforms.single for descent in descents)


def test_a_tight_tolerance_ends_in_double_precision(
    track: RollingContact, descents: list[Descent]
) -> None:
    """Near the error of single precision, descents that end there leave too much to the check."""
    states = roll(replace(track, tolerance=1.2e-6), 0, 5)
    assert not all(descent.transforms.single for descent in descents)
    assert max(state.residual for state in states) <= 1.2e-6


@pytest.mark.parametrize("blended", [False, True])
def test_without_a_last_step_the_load_is_exact(
    track: RollingContact, monkeypatch: pytest.MonkeyPatch, blended: bool
) -> None:
    """The nodes that carry the load are listed anew, whatever a failed step left in the list."""
    iterate, carry, carried = _solver_kernels.iterate, _solver_kernels.carry_load, []

    def without_last(packed: tuple, *arguments: object) -> tuple:
        return iterate(packed, *arguments[:-1], False)

    def disturbed(packed: tuple, *arguments: object) -> tuple:
        answer = without_last(packed, *arguments)
        packed[1][0] = 0
        return answer

    def carrying(packed: tuple, approach: float) -> float:
        carried.append(approach)
        return carry(packed, approach)

    track = replace(track, blended=blended)
    monkeypatch.setattr(_solver_kernels, "iterate", without_last)
    monkeypatch.setattr(_solver_kernels, "carry_load", carrying)
    undisturbed = roll(track, 0, 6)
    assert len(carried) >= len(undisturbed)
    monkeypatch.setattr(_solver_kernels, "iterate", disturbed)
    for state, other in zip(roll(track, 0, 6), undisturbed, strict=True):
        assert_solved(track, state)
        assert np.array_equal(state.pressure, other.pressure)


def test_deflection_by_few_nodes_is_that_of_the_transforms(
    descents: list[Descent], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Summed pair by pair or transformed, a direction has the same deflection to 1e-6."""
    sums: list[float] = []
    directly = _solver_kernels.sum_directly

    def both(packed: tuple, most: int) -> bool:
        image, node = packed[2], packed[1][1]
        pressures = image.copy()
        if not directly(packed, most):
            return False
        summed, descent = image[node].copy(), descents[-1]
        image[:] = pressures
        descent.transforms.apply(*descent.block, None)
        sums.append(np.abs(summed - image[node]).max() / np.abs(summed).max())
        return True

    monkeypatch.setattr(_solver_kernels, "sum_directly", both)
    peaks = make_track(rough(100, 100, 2e-6), load=0.3, hardness=2.1e9, tolerance=1e-4)
    states = roll(peaks, 0, 6)
    assert len(sums) > 6
    assert max(sums) < 1e-6
    for state in states:
        assert_solved(peaks, state)


def test_edges_ahead_of_a_step_are_closer_to_those_of_the_solution(
    track: RollingContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The gaps of the model tell where edges will be better than the extrapolated gaps do."""
    lead, led = Descent.lead, []

    def recording(self: Descent, *arguments: Any) -> None:
        before = self.packed[0][8].copy()
        lead(self, *arguments)
        led.append((self.node, before, self.packed[0][8].copy()))

    monkeypatch.setattr(Descent, "lead", recording)
    states = roll(replace(track, blended=True), 0, 20)[2:]
    assert len(led) == len(states)
    errors = np.zeros(2)
    for state, (node, *edges) in zip(states, led, strict=True):
        assert state.edge is not None
        solved = state.edge.ravel()[node]
        errors += [np.abs(edge - solved).sum() / solved.sum() for edge in edges]
    assert errors[1] < 0.6 * errors[0], errors


@pytest.mark.parametrize(("blended", "most"), [(False, 0.4), (True, 0.8)])
def test_nodes_deep_at_the_hardness_rest(
    descents: list[Descent], monkeypatch: pytest.MonkeyPatch, blended: bool, most: float
) -> None:
    """At most this share of the candidates is left, and the march is that of all of them."""
    track = make_track(rough(160, 160, 1e-7), load=10.0, hardness=1.5e9, tolerance=1e-4)
    track = replace(track, blended=blended)
    states = roll(track, 0, 12)
    candidates = [descent.node.size for descent in descents][-len(states) // 2 :]
    descents.clear()
    monkeypatch.setattr(_descent, "REST", np.inf)
    all_move = roll(track, 0, 12)
    all_nodes = [descent.node.size for descent in descents][-len(states) // 2 :]
    assert np.mean(candidates) < most * np.mean(all_nodes), (candidates, all_nodes)
    got = sum(state.convolutions for state in states)
    assert got <= 1.1 * sum(state.convolutions for state in all_move)
    for state, other in zip(states, all_move, strict=True):
        assert_solved(track, state)
        assert abs(state.approach - other.approach) < track.tolerance * state.max_deflection


def test_no_node_rests_where_few_others_take_up_the_load(
    descents: list[Descent], monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a soft plate the approach moves so far that nodes at rest would leave the hardness."""
    track = make_track(rough(160, 160, 1e-6), load=0.5, hardness=0.25e9, tolerance=1e-4)
    states = roll(track, 0, 20)
    inside = [np.count_nonzero((s.pressure > 0) & (s.pressure < 0.25e9)) for s in states]
    assert max(inside) < kernels.LEAST_FREE
    got, candidates = [state.convolutions for state in states], [d.node.size for d in descents]
    descents.clear()
    monkeypatch.setattr(_descent, "REST", np.inf)
    assert got == [state.convolutions for state in roll(track, 0, 20)]
    assert candidates == [descent.node.size for descent in descents]


def test_nodes_that_rest_by_mistake_are_released(descents: list[Descent]) -> None:
    """Pressures of another place put nodes to rest that the final check lets move again."""
    track = make_track(rough(160, 160, 1e-7), load=10.0, hardness=1.5e9, tolerance=1e-4)
    state = roll(track, 0, 0)[0]
    rng = np.random.default_rng(5)
    gap = track.gap(0, state.window) + 1e-7 * rng.standard_normal(state.pressure.shape)
    cold = solver.solve_contact(space_of(track), gap, 10.0, hardness=1.5e9)
    descents.clear()
    # Deflections that are too small by half claim a deeper overlap.
    wrong = solver.WarmStart(state.pressure, 0.5 * state.deflection, close=True)
    warm = solver.solve_contact(space_of(track), gap, 10.0, wrong, hardness=1.5e9)
    moving = np.isin(np.arange(gap.size), descents[0].node)
    at_rest = (state.pressure.ravel() == 1.5e9) & ~moving
    assert np.count_nonzero(at_rest & (warm.pressure.ravel() < 1.5e9)) > 10
    assert len(descents) > 1
    assert max(warm.residual, cold.residual) <= 1e-5
    assert abs(warm.approach - cold.approach) < 1e-5 * cold.max_deflection
    assert abs(warm.area / cold.area - 1) < 0.01
