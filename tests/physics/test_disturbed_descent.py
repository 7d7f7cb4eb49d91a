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
    iterate = _solver_kernels.iterate
    carry = _solver_kernels.carry_load
    carried = []

    def without_last(*arguments: Any) -> Any:
        *others, rules = arguments
        return iterate(*others, rules._replace(finishing=False))

    def disturbed(*arguments: Any) -> Any:
        answer = without_last(*arguments)
        arguments[0].work.active[:] = 0
        return answer

    def carrying(*arguments: Any) -> float:
        carried.append(1)
        return carry(*arguments)

    track = replace(track, blended=blended)
    monkeypatch.setattr(_solver_kernels, "iterate", without_last)
    monkeypatch.setattr(_solver_kernels, "carry_load", carrying)
    undisturbed = roll(track, 0, 3)
    assert len(carried) >= len(undisturbed)
    monkeypatch.setattr(_solver_kernels, "iterate", disturbed)
    for state, other in zip(roll(track, 0, 3), undisturbed, strict=True):
        assert_solved(track, state)
        assert np.array_equal(state.pressure, other.pressure)


def test_edges_ahead_of_a_step_are_closer_to_those_of_the_solution(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The gaps of the model tell where edges will be better than the extrapolated gaps do."""
    iterate = _solver_kernels.iterate
    system_of = kernels.system_of
    led = []
    listed = []

    def listing(fields: tuple, node: np.ndarray, *arguments: Any) -> Any:
        listed.append(node.copy())
        return system_of(fields, node, *arguments)

    def recording(system: Any, direction: Any, solutions: Any, *arguments: Any) -> Any:
        before = system.edges.edge.copy()
        answer = iterate(system, direction, solutions, *arguments)
        if solutions.p.size:
            led.append((listed[-1], before, system.edges.edge.copy()))
        return answer

    monkeypatch.setattr(kernels, "system_of", listing)
    monkeypatch.setattr(_solver_kernels, "iterate", recording)
    track = make_track(rough(100, 100, 2e-7), load=0.2, hardness=2.1e9, tolerance=1e-4)
    track, space = replace(track, blended=True), space_of(track)
    states = list(march(track, 0, 5, space))[2:]
    assert len(led) == len(states)
    errors = np.zeros(2)
    for state, (node, *edges) in zip(states, led, strict=True):
        assert state.edge is not None
        solved = state.edge.ravel()[node]
        errors += [np.abs(edge - solved).sum() / solved.sum() for edge in edges]
    print(errors, solved.sum())
    assert errors[1] < 0.6 * errors[0], errors
