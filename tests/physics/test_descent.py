"""A descent of the contact solve keeps its precision and survives a last step that fails."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest
from helpers import assert_solved, make_track, roll, rough

from rolling.contact import _solver_kernels
from rolling.contact._candidate_kernels import lead_edges, move_edges
from rolling.contact._descent import Descent, Effort
from rolling.contact._model_kernels import fill
from rolling.contact._system import unpack
from rolling.contact.compiling import njit
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
def test_a_last_step_that_fails_leaves_an_exact_load(
    track: RollingContact, monkeypatch: pytest.MonkeyPatch, blended: bool
) -> None:
    """The nodes that carry the load are listed anew, whatever the failed step left in the list."""

    def failing(packed: tuple, *_: object) -> bool:
        packed[1][0] = 0
        return False

    track = replace(track, blended=blended)
    monkeypatch.setattr(_solver_kernels, "finish", lambda *_: False)
    undisturbed = roll(track, 0, 6)
    monkeypatch.setattr(_solver_kernels, "finish", failing)
    states = roll(track, 0, 6)
    for state, other in zip(states, undisturbed, strict=True):
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


@njit(cache=False)
def moved(packed: tuple, approach: float, ahead: bool) -> None:
    """Move the edges of a descent by its gaps, or ahead of a step by those of a resting model."""
    system = unpack(packed)
    if ahead:
        fill(system.model, system.nodes, system.limits.hardness, approach)
        lead_edges(system)
    else:
        move_edges(system, 0.0)


def test_edges_ahead_of_a_step_are_those_of_its_gaps(
    track: RollingContact, descents: list[Descent]
) -> None:
    """Where the model rests, its gaps are the present ones; the gaps of both follow the edges."""
    roll(replace(track, blended=True), 0, 3)
    descent = descents[-1]
    _, gap, *_, compliance, _, edge, _ = descent.packed[0]
    edge *= 0.5
    compliance *= 0.5
    before, ahead = edge.copy(), deepcopy(descent.packed)
    moved(descent.packed, descent.step.approach, ahead=False)
    moved(ahead, descent.step.approach, ahead=True)
    assert (np.abs(edge - before) > 0.1 * edge.max()).sum() > 10
    np.testing.assert_allclose(ahead[0][8], edge, rtol=1e-4, atol=1e-4 * edge.max())
    np.testing.assert_allclose(ahead[0][1], gap, rtol=0, atol=1e-4 * edge.max())
    model, stiffness = ahead[4][1].ravel()[ahead[1][2]], ahead[11][5]
    followed = stiffness * (ahead[0][1] - descent.step.approach)
    np.testing.assert_allclose(model, followed, rtol=0, atol=1e-5 * np.abs(followed).max())
