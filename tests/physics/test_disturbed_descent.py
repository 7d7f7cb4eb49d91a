"""Descents that are disturbed or watched from within.

That is possible uncompiled only: NUMBA_DISABLE_JIT=1, -m kernel.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numba
import numpy as np
import pytest
from helpers import assert_solved, make_track, roll, rough, space_of

from rolling.contact import _descent_kernels as kernels
from rolling.contact import _solver_kernels
from rolling.contact._transform_kernels import APPLY, apply_at
from rolling.contact.march import march
from rolling.contact.state import RollingContact

pytestmark = [
    pytest.mark.kernel,
    pytest.mark.skipif(
        not numba.config.DISABLE_JIT, reason="kernels that are compiled cannot be replaced"
    ),
]


@pytest.fixture
def track() -> RollingContact:
    return make_track(rough(32, 32, 1e-7), load=0.05, hardness=2.1e9, tolerance=1e-4)


@pytest.mark.parametrize("blended", [False, True])
def test_without_a_last_step_the_load_is_exact(
    track: RollingContact, monkeypatch: pytest.MonkeyPatch, blended: bool
) -> None:
    """The nodes that carry the load are listed anew, whatever a failed step left in the list."""
    step_at = kernels.step_at
    carry = _solver_kernels.carry_load
    carried = []

    def without_last(address: int, arguments: tuple) -> Any:
        return step_at(address, (*arguments[:-1], False))

    def disturbed(address: int, arguments: tuple) -> Any:
        answer = without_last(address, arguments)
        arguments[0].work.active[:] = 0
        return answer

    def carrying(*arguments: Any) -> float:
        carried.append(1)
        return carry(*arguments)

    track = replace(track, blended=blended)
    monkeypatch.setattr(kernels, "step_at", without_last)
    monkeypatch.setattr(_solver_kernels, "carry_load", carrying)
    undisturbed = roll(track, 0, 3)
    assert len(carried) >= len(undisturbed)
    monkeypatch.setattr(kernels, "step_at", disturbed)
    for state, other in zip(roll(track, 0, 3), undisturbed, strict=True):
        assert_solved(track, state)
        assert np.array_equal(state.pressure, other.pressure)


def test_deflection_by_few_nodes_is_that_of_the_transforms(
    track: RollingContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Summed pair by pair or transformed, a direction has the same deflection to 1e-6."""
    errors: list[float] = []
    convolve = kernels.convolve
    directly = _solver_kernels.sum_directly
    summed: list[bool] = []

    def summing(*arguments: Any) -> bool:
        summed.append(directly(*arguments))
        return summed[-1]

    def both(system: Any, entry: np.ndarray, block: tuple, *others: Any) -> None:
        image = system.transform.image
        node = system.transform.node
        direction = image.copy()
        summed.clear()
        convolve(system, entry, block, *others)
        if summed == [True]:
            sums = image[node].copy()
            image[:] = direction
            apply_at(entry[APPLY], (entry, block[2], block[3], np.empty(0, np.int64)))
            errors.append(np.abs(sums - image[node]).max() / np.abs(sums).max())

    monkeypatch.setattr(kernels, "convolve", both)
    monkeypatch.setattr(_solver_kernels, "sum_directly", summing)
    for state in roll(track, 0, 4):
        assert_solved(track, state)
    assert len(errors) > 4
    assert max(errors) < 1e-6


def test_edges_ahead_of_a_step_are_closer_to_those_of_the_solution(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The gaps of the model tell where edges will be better than the extrapolated gaps do."""
    step_at = kernels.step_at
    system_of = kernels.system_of
    led = []
    listed = []

    def listing(fields: tuple, node: np.ndarray, *arguments: Any) -> Any:
        listed.append(node.copy())
        return system_of(fields, node, *arguments)

    def recording(address: int, arguments: tuple) -> Any:
        system, _, solutions = arguments[:3]
        before = system.edges.edge.copy()
        answer = step_at(address, arguments)
        if solutions.p.size:
            led.append((listed[-1], before, system.edges.edge.copy()))
        return answer

    monkeypatch.setattr(kernels, "system_of", listing)
    monkeypatch.setattr(kernels, "step_at", recording)
    track = make_track(rough(100, 100, 2e-7), load=0.2, hardness=2.1e9, tolerance=1e-4)
    space = space_of(track)
    track = replace(track, blended=True)
    list(march(track, 0, 5, space))  # a step begins anew where it lacks transforms
    led.clear()
    states = list(march(track, 0, 5, space))[2:]
    assert len(led) == len(states)
    errors = np.zeros(2)
    for state, (node, *edges) in zip(states, led, strict=True):
        assert state.edge is not None
        solved = state.edge.ravel()[node]
        errors += [np.abs(edge - solved).sum() / solved.sum() for edge in edges]
    print(errors, solved.sum())
    assert errors[1] < 0.6 * errors[0], errors
