"""The block of the nodes below the approach is that of a search over all nodes."""

from __future__ import annotations

import numpy as np
import pytest

from rolling.contact import _march_kernels

pytestmark = pytest.mark.kernel

SPACING, RADIUS = 2e-6, 1e-3


@pytest.mark.parametrize("seed", range(12))
def test_overlap_block_is_that_of_a_plain_search(seed: int) -> None:
    """Rough plates, high and low approaches, and spheres near the border of a period."""
    rng = np.random.default_rng(seed)
    along, across = rng.integers(20, 60, 2)
    heights = rng.normal(size=(along, across)) * 10 ** rng.uniform(-8, -6)
    x, y = rng.uniform(-1, 2) * along * SPACING, rng.uniform(0, 1) * across * SPACING
    approach = rng.uniform(-0.5, 1) * heights.max()
    # All nodes that the search may reach: a period to each side.
    rows = np.arange(
        int(np.ceil(x / SPACING - along - 0.5)), int(np.floor(x / SPACING + along + 0.5)) + 1
    )
    columns = np.arange(
        int(np.ceil(y / SPACING - across - 0.5)), int(np.floor(y / SPACING + across + 0.5)) + 1
    )
    rise = (rows * SPACING - x)[:, None] ** 2 + (columns * SPACING - y) ** 2
    gap = rise / (2 * RADIUS) - heights[np.ix_(rows % along, columns % across)]
    below = np.argwhere(gap < approach)
    got = _march_kernels.overlap_block(
        heights, heights.max(axis=1), heights.max(), SPACING, RADIUS, x, y, approach
    )
    if below.size == 0:
        assert got[1] < got[0]
        return
    expected = (rows[below[:, 0].min()], rows[below[:, 0].max()])
    expected += (columns[below[:, 1].min()], columns[below[:, 1].max()])
    assert got == expected


@pytest.mark.parametrize("offset", [(0, 0), (3, -4), (-6, 2), (40, 0), (0, 40), (-40, -40)])
def test_blocks_are_copied_where_both_exist(offset: tuple[int, int]) -> None:
    """Nodes that a window lacks are 0; a window far away shares none."""
    source, target = np.random.default_rng(1).random((9, 11)), np.full((12, 8), np.nan)
    _march_kernels.copy_block(source, target, *offset)
    expected = np.zeros_like(target)
    for i, j in np.ndindex(*source.shape):
        a, b = i + offset[0], j + offset[1]
        if 0 <= a < 12 and 0 <= b < 8:
            expected[a, b] = source[i, j]
    np.testing.assert_array_equal(target, expected)


@pytest.mark.parametrize("offset", [(0, 0), (3, -4), (-6, 2), (0, 40), (-40, -40)])
def test_trends_are_differences_where_both_exist(offset: tuple[int, int]) -> None:
    """Pressures began at 0 off the window before; unknown deflections have no trend."""
    rng = np.random.default_rng(2)
    p, u, p_trend, u_trend = rng.random((4, 12, 8))
    p_before, u_before = rng.random((2, 9, 11))
    _march_kernels.trends(p, u, p_before, u_before, *offset, p_trend, u_trend)
    shared = np.zeros((2, 12, 8))
    _march_kernels.copy_block(p_before, shared[0], *offset)
    _march_kernels.copy_block(u_before, shared[1], *offset)
    np.testing.assert_array_equal(p_trend, p - shared[0])
    np.testing.assert_array_equal(u_trend, np.where(shared[1] > 0, u - shared[1], 0.0))
