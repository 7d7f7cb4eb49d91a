"""Products with the coefficients between few nodes, against transforms of the whole block.

They run uncompiled as well: NUMBA_DISABLE_JIT=1, -m kernel.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from helpers import assert_solved, convolved, make_track, roll, rough

from rolling.contact import _direct_kernels, solver
from rolling.contact.half_space import HalfSpace


@pytest.mark.kernel
@pytest.mark.parametrize("count", [1, 2, 63, 64, 65, 200])
def test_few_nodes_deflect_as_the_whole_block_does(count: int) -> None:
    """Counts around a multiple of the rows whose sums are single; pressures of both signs."""
    rng = np.random.default_rng(count)
    rows, columns = 23, 31
    place = np.sort(rng.choice(rows * columns, count, replace=False))
    pressure = np.zeros(rows * columns)
    pressure[place] = rng.normal(size=count)
    space = HalfSpace(1e-6, 1e11)
    whole = convolved(
        space.convolution(rows - 1, columns - 1), pressure.reshape(rows, columns)
    ).reshape(-1)
    single = space.convolution(rows - 1, columns - 1, single=True)
    row_length = single.real.shape[1] + 1
    distance = (place // columns * row_length + place % columns).astype(np.uint32)
    between = np.empty(count * (count + 1) // 2, np.float32)
    _direct_kernels.collect_between(single.influence(), distance, between)
    deflection = np.full(count, np.nan)
    _direct_kernels.multiply_between(between, pressure[place], 2.0, deflection)
    error = np.abs(deflection - 2.0 * whole[place]).max()
    assert error < 5e-7 * 2.0 * np.abs(whole[place]).max()


@pytest.mark.law("Direct products: without transforms a contact of few nodes is the same.")
@pytest.mark.parametrize("hardness", [np.inf, 2.1e9], ids=["elastic", "capped"])
def test_few_candidates_give_the_contact_of_transforms(
    hardness: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    track = make_track(rough(120, 120, 5e-7), load=0.5, hardness=hardness, tolerance=1e-6)
    asked: list[bool] = []

    def answering(answer: Callable[[int, int], bool]) -> Callable[[int, int], bool]:
        def is_direct(nodes: int, transformed: int) -> bool:
            asked.append(answer(nodes, transformed))
            return asked[-1]

        return is_direct

    monkeypatch.setattr(solver, "is_direct", answering(_direct_kernels.is_direct))
    direct = roll(track, 0, 6)
    assert all(asked)
    monkeypatch.setattr(solver, "is_direct", answering(lambda nodes, transformed: False))
    transformed = roll(track, 0, 6)
    for one, other in zip(direct, transformed, strict=True):
        assert_solved(track, one)
        allowed = 2 * track.tolerance * other.max_deflection
        assert one.approach == pytest.approx(other.approach, abs=allowed)
        assert one.stored_energy == pytest.approx(other.stored_energy, rel=4 * track.tolerance)
