"""The search for candidates against plain arrays, and the strips of nodes near them.

The search runs uncompiled as well: NUMBA_DISABLE_JIT=1, -m kernel.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from rolling.contact import _candidate_kernels as kernels
from rolling.contact._system import BORDER

CROSS = ndimage.generate_binary_structure(2, 1)


@pytest.mark.kernel
@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (7, 1), (13, 11)])
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
@pytest.mark.parametrize(("neighbours", "subcells"), [(False, 1), (True, 2)])
def test_candidates_are_those_of_plain_arrays(
    shape: tuple[int, int], share: float, neighbours: bool, subcells: int
) -> None:
    """Loaded and low nodes are listed in order, with the nodes along and across if asked for.

    Nodes at the hardness that lie deep are counted instead, unless they are beside a listed node.
    """
    rng = np.random.default_rng(int(100 * share) + shape[1])
    pressure = np.where(rng.random(shape) < 0.5 * share, rng.random(shape), 0.0)
    hardness = 0.5
    pressure = np.minimum(pressure, hardness)
    gap = np.where(rng.random(shape) < 0.5 * share, -1.0, 1.0) * rng.random(shape)
    free = np.count_nonzero((pressure > 0) & (pressure < hardness))
    resting = (pressure == hardness) & (gap < -0.3)
    resting &= free >= kernels.MIN_FREE * subcells**2
    expected = ((pressure > 0) | (gap < 0)) & ~resting
    if neighbours:
        expected = ndimage.binary_dilation(expected, CROSS)
    node = np.full(pressure.size, -1)
    limits = hardness, -0.3, 0.0
    at_rest, count, *block = kernels.candidates(pressure, gap, *limits, neighbours, subcells, node)
    assert at_rest == np.count_nonzero(resting & ~expected)
    np.testing.assert_array_equal(node[:count], np.flatnonzero(expected))
    rows, columns = np.nonzero(expected)
    if count:
        first = rows.min() // subcells * subcells, columns.min() // subcells * subcells
        ends = rows.max() // subcells + 1, columns.max() // subcells + 1
        sizes = [end * subcells - begin for begin, end in zip(first, ends, strict=True)]
        assert block == [*first, *sizes]


@pytest.mark.parametrize(("rows", "row"), [(4100, 10), (206, 200)])
@pytest.mark.parametrize("share", [0.0001, 0.01, 1.0])
def test_strips_hold_all_nodes_near_candidates(rows: int, row: int, share: float) -> None:
    """Strips are apart, in order and within the rows that move, and hold the reach of a stencil."""
    grid = np.zeros((rows, row), bool)
    inner = grid[BORDER:-BORDER, BORDER:-BORDER]
    inner[:] = np.random.default_rng(row).random(inner.shape) < share
    assert grid.size >= kernels.WIDE
    strips = np.zeros((grid.size // kernels.STRIP + 1, 2), np.uint64)
    place = np.flatnonzero(grid).astype(np.uint32)
    strips = strips[: kernels.list_strips(place, rows, row, strips)].astype(int)
    inside = np.zeros(grid.size, bool)
    for first, last in strips:
        inside[first:last] = True
    near = ndimage.binary_dilation(grid, np.ones((5, 5)))
    near[:2] = near[-2:] = False
    assert inside[near.ravel()].all()
    assert inside.mean() < min(1.1, 300 * share)
    assert (strips[1:, 0] > strips[:-1, 1] + kernels.STRIP_GAP).all()
    assert not ((strips[:-1, 1] - strips[:-1, 0]) % kernels.STRIP).any()
    assert strips[0, 0] >= 2 * row and strips[-1, 1] <= grid.size - 2 * row


def test_a_small_grid_is_a_single_strip() -> None:
    """Strips save nothing where all nodes stay in the cache."""
    strips = np.zeros((400, 2), np.uint64)
    assert kernels.list_strips(np.array([333], np.uint32), 40, 64, strips) == 1
    assert strips[0].tolist() == [2 * 64, 38 * 64]
