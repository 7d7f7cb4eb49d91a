"""The window of the nodes below the approach is that of a search over all nodes."""

from __future__ import annotations

import numpy as np
import pytest

from rolling.contact import _window_kernels
from rolling.contact.state import maxima_of

pytestmark = pytest.mark.kernel

SPACING = 2e-6
RADIUS = 1e-3


@pytest.mark.parametrize("seed", range(12))
def test_the_overlap_is_that_of_a_plain_search(seed: int) -> None:
    """Rough plates, high and low approaches, and spheres near the border of a period."""
    rng = np.random.default_rng(seed)
    along, across = rng.integers(12, 60, 2)
    heights = rng.normal(size=(along, across)) * 10 ** rng.uniform(-8, -6)
    x = rng.uniform(-1, 2) * along * SPACING
    y = rng.uniform(0, 1) * across * SPACING
    approach = rng.uniform(-0.5, 1) * heights.max()
    radius_across = RADIUS * (10 ** rng.uniform(-2, 2) if seed % 2 else 1.0)
    # All nodes that the search may reach: a period to each side.
    rows = np.arange(
        int(np.ceil(x / SPACING - along - 0.5)), int(np.floor(x / SPACING + along + 0.5)) + 1
    )
    columns = np.arange(
        int(np.ceil(y / SPACING - across - 0.5)), int(np.floor(y / SPACING + across + 0.5)) + 1
    )
    rise = (rows * SPACING - x)[:, None] ** 2 / (2 * RADIUS)
    rise = rise + (columns * SPACING - y) ** 2 / (2 * radius_across)
    # Half of the scenes add the minimum deflection by a load.
    load = rng.choice([0.0, 1.0]) * heights.max() * 20 * SPACING
    spread = rng.uniform(0.5, 20) * SPACING
    distance2 = (rows * SPACING - x)[:, None] ** 2 + (columns * SPACING - y) ** 2
    gap = rise - heights[np.ix_(rows % along, columns % across)]
    below = np.argwhere(gap + load / np.sqrt(distance2 + spread**2) < approach)
    maxima = maxima_of(heights, rising=False)
    sphere = SPACING, RADIUS, radius_across, x, y
    least = load, spread**2
    got = _window_kernels.overlap(tuple(maxima), sphere, approach, least, False)
    if below.size == 0:
        assert got[2:] == (0, 0)
        return
    first = rows[below[:, 0].min()], columns[below[:, 1].min()]
    assert got == (*first, *(np.ptp(below, axis=0) + 1))


@pytest.mark.parametrize("continued", [False, True])
@pytest.mark.parametrize("offset", [(0, 0), (3, -4), (-6, 2), (40, 0), (0, 40), (-40, -40)])
def test_blocks_are_copied_where_both_exist(offset: tuple[int, int], continued: bool) -> None:
    """Nodes that a window lacks are 0 or their nearest node; a window far away shares none."""
    source = np.random.default_rng(1).random((9, 11))
    target = np.full((12, 8), np.nan)
    _window_kernels.copy_block(source, target, *offset, continued)
    for i, j in np.ndindex(*target.shape):
        a = i - offset[0]
        b = j - offset[1]
        nearest = np.clip(a, 0, 8), np.clip(b, 0, 10)
        held = continued or (a, b) == nearest
        assert target[i, j] == (source[nearest] if held else 0.0)


@pytest.mark.parametrize("offset", [(0, 0), (3, -4), (-6, 2), (0, 40), (-40, -40)])
def test_deflections_change_once_more_where_both_are_known(offset: tuple[int, int]) -> None:
    """Deflections off the window before are unknown and stay."""
    rng = np.random.default_rng(2)
    u = rng.random((12, 8))
    before = rng.random((9, 11))
    out = np.empty((12, 8))
    _window_kernels.extrapolate_deflection(u, before, *offset, out)
    shared = np.zeros((12, 8))
    _window_kernels.copy_block(before, shared, *offset, False)
    np.testing.assert_array_equal(out, np.where(shared > 0, u + (u - shared), u))
