"""Compiled passes over the window of a position, which Python calls one after the other.

A position judges its state, lists its candidates (`candidates`), descends (`descend`), computes the
deflection anew, and measures its loaded nodes.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import numpy as np

from rolling.contact import _window_kernels as windows
from rolling.contact._candidate_kernels import cell_ranges
from rolling.contact._condition_kernels import maximum_of, state_of, sum_of
from rolling.contact._window_kernels import extrapolate_deflection
from rolling.contact.compiling import njit


@njit(cache=True, calls=(extrapolate_deflection, cell_ranges, state_of))
def judge(window, fields, before, numbers, fresh, g):
    """Set the edges and the deformed gaps g of a state; return its numbers as `state_of` does.

    `window` is the undeformed gap at the nodes and as it continues within cells, `fields` are
    pressure, deflection and edges, which are empty where all are sharp, and `numbers` are hardness,
    levelled range and share of the edges. Edges follow the deflection, or its extrapolation where
    there is a position `before`: pressure and deflection, and the node where they begin.
    """
    gap, shape = window
    p, u, edge = fields
    hardness, levelled, share = numbers
    if edge.size:
        field = u
        if before[0].size:
            extrapolate_deflection(u, before[1], before[2], before[3], g)
            field = g
        cell_ranges(shape, field, levelled, share, edge)
    return state_of(
        gap.reshape(-1),
        u.reshape(-1),
        p.reshape(-1),
        edge.reshape(-1),
        hardness,
        g.reshape(-1),
        fresh,
    )


@njit(cache=True)
def carried_by(pressure):
    """Return the sum of the pressures of a window."""
    return sum_of(pressure.reshape(-1))


@njit(cache=True, calls=(windows.loaded_range,))
def measure(fields, numbers, sphere, highest, approach, blended, corner):
    """Return the block of the loaded nodes of a solved window, and their measures.

    `fields` are pressure, deflection and edges, `numbers` hardness and levelled range, `highest` is
    the maximum height, and `corner` the first row and column of the window. The block is first row
    and column, rows and columns. The measures are the numbers of nodes in contact and at the
    hardness, the maximum pressure, the sum of p u, and the spread of the load [m].
    """
    p, u, edge = fields
    hardness, levelled = numbers
    spacing, radius, radius_across, x, y = sphere
    gap = max(windows.farthest_gap(highest, sphere, approach, blended) + highest, 0.0)
    reach = np.sqrt(2 * max(radius, radius_across) * gap) / spacing
    row = x / spacing - corner[0]
    column = y / spacing - corner[1]
    # Below the hardness there is no patch that could end within a cell.
    yields = blended and maximum_of(p.reshape(-1)) >= hardness
    ends = edge if yields else edge[:0]
    (
        count,
        capped,
        maximum,
        work,
        spread,
        first_row,
        last_row,
        first_column,
        last_column,
    ) = windows.measures(p, u, hardness, ends, levelled, row, column, reach)
    rows = last_row - first_row + 1
    columns = last_column - first_column + 1
    block = corner[0] + first_row, corner[1] + first_column, rows, columns
    return block, (count, capped, maximum, work, spacing * spread)


@njit(cache=True)
def share_of_the_sphere(gap, held, onward):
    """Return the share of pressures that move with the sphere, for a minimum of the energy.

    Pressures and deflections that stay with the plate are `held`; those that move are `onward`. As
    both deflections are known, the share needs no convolution.
    """
    (p, u), (onward_p, onward_u) = held, onward
    slope = 0.0
    curvature = 0.0
    for i in range(gap.shape[0]):
        for j in range(gap.shape[1]):
            towards = onward_p[i, j] - p[i, j]
            slope += (gap[i, j] + u[i, j]) * towards
            curvature += (onward_u[i, j] - u[i, j]) * towards
    return min(-slope / curvature, 1.0) if slope < 0 < curvature else 0.0


@njit(cache=True)
def mix(values, others, share, high):
    """Move values towards others by a share of their difference, within rounding up to a bound."""
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            values[i, j] = min(values[i, j] + share * (others[i, j] - values[i, j]), high)
