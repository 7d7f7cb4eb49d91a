"""Direct sums over few nodes, against transforms of the whole block.

They run uncompiled as well: NUMBA_DISABLE_JIT=1, -m kernel.
"""

from __future__ import annotations

import numba
import numpy as np
import pytest
from helpers import assert_solved, convolved, make_track, roll, rough

from rolling.contact import _direct_kernels, solver
from rolling.contact.half_space import HalfSpace, love
from rolling.contact.subcells import half_space_of


@pytest.mark.kernel
@pytest.mark.parametrize("count", [1, 2, 63, 64, 65, 200])
def test_few_nodes_deflect_as_the_whole_block_does(count: int) -> None:
    """Counts around a multiple of the rows of a sum; pressures of both signs."""
    rng = np.random.default_rng(count)
    rows, columns = 23, 41
    place = np.sort(rng.choice(rows * columns, count, replace=False))
    pressure = np.zeros(rows * columns)
    pressure[place] = rng.normal(size=count)
    space = HalfSpace(1e-6, 1e11)
    deflection = 2.0 * direct_sums(space, pressure.reshape(rows, columns), place)
    transforms = space.convolution(rows - 1, columns - 1)
    whole = 2.0 * convolved(transforms, pressure.reshape(rows, columns)).reshape(-1)
    assert np.abs(deflection - whole[place]).max() < 5e-7 * np.abs(whole[place]).max()


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="only compiled sums are in parts")
def test_sums_over_many_nodes_keep_their_digits() -> None:
    """In one go 2,000 pressures of one sign would be off by 1e-6."""
    rng = np.random.default_rng(1)
    place = np.sort(rng.choice(200 * 210, 2000, replace=False))
    pressure = np.zeros(200 * 210)
    pressure[place] = rng.uniform(0.5, 1.0, 2000)
    space = HalfSpace(1e-6, 1e11)
    whole = space.deflection(pressure.reshape(200, 210)).reshape(-1) / space.unit
    deflection = direct_sums(space, pressure.reshape(200, 210), place)
    assert np.abs(deflection - whole[place]).max() < 4e-7 * whole.max()


def direct_sums(space: HalfSpace, pressure: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return the deflection of the nodes of a block at flat places, in its unit."""
    rows, columns = pressure.shape
    transforms = space.convolution(rows - 1, columns - 1, single=True)
    along, across = transforms.real.shape[0], transforms.real.shape[1] // 2
    row_length = 2 * across + 1
    coefficients = transforms.influence().reshape(-1, row_length)
    expected = love(np.abs(np.arange(-along, along + 1)), np.abs(np.arange(-across, across + 1)))
    np.testing.assert_allclose(coefficients, expected, rtol=1e-6)
    index = (place // columns * row_length + place % columns).astype(np.uint32)
    triangle = np.full(place.size * (place.size + 1) // 2, np.nan, np.float32)
    _direct_kernels.collect_triangle(coefficients.reshape(-1), index, triangle)
    deflection = np.full(place.size, np.nan)
    _direct_kernels.multiply_triangle(triangle, pressure.reshape(-1)[place], 1.0, deflection)
    return deflection


@pytest.mark.law("Direct sums: without transforms a contact of few candidates is the same.")
@pytest.mark.parametrize("hardness", [np.inf, 2.1e9], ids=["elastic", "capped"])
def test_few_candidates_give_the_contact_of_transforms(
    hardness: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A wrong sum would be healed by the last check, at the cost of further convolutions."""
    track = make_track(rough(120, 120, 5e-7), load=0.5, hardness=hardness, tolerance=1e-4)
    answers: list[bool] = []

    def is_direct(candidates: int, padded_points: int) -> bool:
        answers.append(_direct_kernels.is_direct(candidates, padded_points))
        return answers[-1]

    monkeypatch.setattr(solver, "is_direct", is_direct)
    direct = roll(track, 0, 6)[1:]
    assert sum(answers) >= len(direct)
    monkeypatch.setattr(solver, "is_direct", lambda candidates, padded_points: False)
    transformed = roll(track, 0, 6)[1:]
    for one, other in zip(direct, transformed, strict=True):
        assert_solved(track, one)
        assert one.convolutions == other.convolutions
        assert not np.array_equal(one.pressure, other.pressure)  # other last digits
        np.testing.assert_allclose(one.pressure, other.pressure, rtol=0, atol=1e-5 * 2.1e9)


def test_a_descent_asks_for_direct_sums_in_single_precision_only() -> None:
    """Neither sub-cells nor large transforms have coefficients by distance."""
    single, double = (HalfSpace(1e-6, 1e11).convolution(40, 40, single=s) for s in (True, False))
    assert solver._sums_directly(single, 50) and not solver._sums_directly(double, 50)
    assert not solver._sums_directly(half_space_of(1e-6, 1e11, 2).convolution(40, 40, True), 50)
    assert not solver._sums_directly(HalfSpace(1e-6, 1e11).convolution(800, 800, True), 50)
