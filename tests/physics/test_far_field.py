"""The far field of the model problem: its coefficients, its coarse grid and the answer to it.

They run uncompiled as well: NUMBA_DISABLE_JIT=1, -m kernel.
"""

from __future__ import annotations

import numpy as np
import pytest

from rolling.contact import _far_field as kernels
from rolling.contact._far_field import (
    FORGOTTEN,
    coarse_grid,
    far_field,
    half_space_of_stencil,
    square_stencil,
    stencils,
)
from rolling.contact._system import BORDER, FarField
from rolling.contact.half_space import love

pytestmark = pytest.mark.kernel

SHAPE = (30, 38)  # of a grid of the model, with its border
INNER = (slice(BORDER, -BORDER), slice(BORDER, -BORDER))


def far_grid() -> FarField:
    """Return an empty far field for SHAPE."""
    rows, columns, tile = coarse_grid(*SHAPE)
    row_length = 2 * columns - 1
    grids = np.zeros((7, rows * row_length), np.float32)
    inverse = stencils(1.0)
    table = far_field(rows, columns, tile)
    return FarField(tile, row_length, inverse.own, inverse.common, table, *grids)


def coarse(far: FarField, values: np.ndarray) -> np.ndarray:
    """Return a coarse grid without its padding."""
    rows, columns, _ = coarse_grid(*SHAPE)
    return values.reshape(rows, far.row_length)[:, :columns].astype(float)


def weights(far: FarField) -> np.ndarray:
    """Return the bilinear weights of coarse nodes (columns) at the nodes of SHAPE (rows)."""
    rows, columns, tile = coarse_grid(*SHAPE)

    def tents(nodes: int, count: int) -> np.ndarray:
        away = np.arange(nodes)[:, None] / tile - np.arange(count)
        return np.maximum(1 - np.abs(away), 0)

    return np.kron(tents(SHAPE[0], rows), tents(SHAPE[1], columns))


def table_matrix() -> np.ndarray:
    """Return the far-field coefficients between all pairs of coarse nodes."""
    rows, columns, tile = coarse_grid(*SHAPE)
    i, j = (k.ravel() * float(tile) for k in np.mgrid[:rows, :columns])
    along = np.abs(np.subtract.outer(i, i))
    across = np.abs(np.subtract.outer(j, j))
    near = half_space_of_stencil()
    out = np.empty(along.shape)
    for k in np.ndindex(*out.shape):
        x = along[k]
        y = across[k]
        forgotten = max(x, y) >= FORGOTTEN
        out[k] = love(np.array([x]), np.array([y]))[0, 0] - (
            0 if forgotten else near[int(x), int(y)]
        )
    return out


def test_stencil_inverts_the_near_half_space() -> None:
    """The stencil on its half-space gives a unit pressure; the rest of Love's is smooth."""
    near = half_space_of_stencil()
    whole = np.pad(near[:24, :24], ((23, 0), (23, 0)), mode="reflect")
    stencil = square_stencil()
    pressure = sum(
        stencil[a, b] * whole[a : a + 43, b : b + 43] for a in range(5) for b in range(5)
    )
    unit = np.zeros((43, 43))
    unit[21, 21] = 1
    np.testing.assert_allclose(pressure, unit, atol=1e-9)
    distance = np.arange(24.0)
    rest = love(distance, distance) - near[:24, :24]
    assert (rest > 0).all() and rest.max() < 0.15 < 0.05 * near[0, 0]
    assert np.abs(np.diff(rest, axis=0)).max() < 0.04


def test_restriction_and_interpolation_are_adjoint() -> None:
    """Both have the bilinear weights; the border takes no part."""
    rng = np.random.default_rng(3)
    far = far_grid()
    values = rng.normal(size=SHAPE).astype(np.float32)
    kernels.restrict(values, far.tile, far.row_length, far.loads)
    inner = np.zeros(SHAPE)
    inner[INNER] = values[INNER]
    expected = weights(far).T @ inner.ravel()
    np.testing.assert_allclose(coarse(far, far.loads).ravel(), expected, atol=1e-5)
    far.field[:] = rng.normal(size=far.field.size)
    out = np.zeros(SHAPE, np.float32)
    kernels.prolong(far.field, np.float32(0.5), far.tile, far.row_length, out)
    expected = (0.5 * weights(far) @ coarse(far, far.field).ravel()).reshape(SHAPE)
    np.testing.assert_allclose(out[BORDER:-BORDER], expected[BORDER:-BORDER], atol=1e-5)
    assert not out[:BORDER].any() and not out[-BORDER:].any()


def test_far_field_is_that_of_love() -> None:
    """Loads on nodes a few tiles away deflect a node as Love says, to 3 %."""
    far = far_grid()
    values = np.zeros(SHAPE, np.float32)
    values[8, 9] = 1.0
    values[11, 28] = 0.5
    kernels.restrict(values, far.tile, far.row_length, far.loads)
    kernels.field_of(far.loads, far.table, far.field)
    expected = table_matrix() @ coarse(far, far.loads).ravel()
    np.testing.assert_allclose(coarse(far, far.field).ravel(), expected, rtol=1e-5)
    out = np.zeros(SHAPE, np.float32)
    kernels.prolong(far.field, np.float32(1.0), far.tile, far.row_length, out)
    exact = sum(
        load * love(np.array([24.0 - i]), np.array([20.0 - j]))[0, 0]
        for i, j, load in ((8, 9, 1.0), (11, 28, 0.5))
    )
    assert out[24, 20] == pytest.approx(exact, rel=0.03)


@pytest.mark.parametrize("free", [0.15, 1.0])
def test_answer_solves_the_coarse_system(free: float) -> None:
    """The answers of free nodes close the field of all loads but for a common approach."""
    rng = np.random.default_rng(4)
    far = far_grid()
    marked = np.zeros(SHAPE, np.float32)
    marked[INNER] = rng.random(marked[INNER].shape) < free
    changes = np.where(marked > 0, rng.normal(size=SHAPE), 0.0).astype(np.float32)
    kernels.restrict(marked, far.tile, far.row_length, far.stiffness)
    kernels.restrict(changes, far.tile, far.row_length, far.loads)
    loads = coarse(far, far.loads).ravel()
    count = coarse(far, far.stiffness).ravel()
    kernels.answer(far)
    stiffness = count / (far.own + count / far.tile**2 * (far.common - far.own))
    np.testing.assert_allclose(coarse(far, far.stiffness).ravel(), stiffness, rtol=1e-5)
    # The same system, solved directly: answers x and the approach that keeps their sum.
    bearing = stiffness > 0
    d = table_matrix()
    n = int(bearing.sum())
    system = np.ones((n + 1, n + 1))
    system[:n, :n] = d[np.ix_(bearing, bearing)] + np.diag(1 / stiffness[bearing])
    system[n, n] = 0
    solved = np.linalg.solve(system, np.append(-(d @ loads)[bearing], 0))[:n]
    expected = -solved / stiffness[bearing]
    got = coarse(far, far.field).ravel()[bearing]
    spread = np.sqrt(np.sum(stiffness[bearing] * expected**2))
    assert np.sqrt(np.sum(stiffness[bearing] * (got - expected) ** 2)) < 0.05 * spread


def test_known_loads_have_no_field() -> None:
    """A far field that the gaps have already is not added again."""
    rng = np.random.default_rng(5)
    far = far_grid()
    values = rng.normal(size=SHAPE).astype(np.float32)
    for grid in (far.loads, far.known, far.stiffness):
        kernels.restrict(np.abs(values), far.tile, far.row_length, grid)
    kernels.answer(far)
    assert not far.field.any()


@pytest.mark.parametrize(("rows", "columns"), [(9, 12), (92, 92), (204, 224), (1000, 1000)])
def test_coarse_grid_covers_the_grid(rows: int, columns: int) -> None:
    """Each node lies between coarse nodes, which have at most two pairs per node of a square."""
    along, across, tile = coarse_grid(rows, columns)
    assert (along - 1) * tile >= rows - 1 and (across - 1) * tile >= columns - 1
    assert (along * across) ** 2 <= 2 * max(rows, columns) ** 2
