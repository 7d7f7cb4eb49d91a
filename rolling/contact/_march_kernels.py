"""Compiled passes of the march: gap, overlap, trends and measures.

Rows and columns count on the unrolled plate; heights repeat with their period.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np

from rolling.contact._compiled import njit


@njit(cache=True)
def undeformed_gap(heights, spacing, radius, x, y, row, column, out):
    """Set `out` to the undeformed gap on the window that begins at node (row, column).

    The gap is ((x_i - x)^2 + (y_j - y)^2) / (2 R) - z.
    """
    along, across = heights.shape
    curvature = 0.5 / radius
    rises = np.empty(out.shape[1])
    for j in range(rises.size):
        dy = (column + j) * spacing - y
        rises[j] = dy * dy * curvature
    for i in range(out.shape[0]):
        dx = (row + i) * spacing - x
        rise = dx * dx * curvature
        z, line = heights[(row + i) % along], out[i]
        node = column % across
        j = 0
        while j < line.size:  # each turn handles a stretch within one period
            stretch = min(line.size - j, across - node)
            above(rise, rises[j : j + stretch], z[node : node + stretch], line[j : j + stretch])
            j += stretch
            node = 0


@njit(cache=True)
def above(rise, rises, z, out):
    """Set `out` to the height of a row of the sphere above the plate."""
    for k in range(out.size):
        out[k] = (rise + rises[k]) - z[k]


@njit(cache=True)
def cell_tops(heights, out):
    """Set `out` to the maximum height within the cell of each node, by the slope at the node."""
    along, across = heights.shape
    for i in range(along):
        before, after = heights[i - 1], heights[(i + 1) % along]
        for j in range(across):
            rise = after[j] - before[j]
            tilt = heights[i, (j + 1) % across] - heights[i, j - 1]
            out[i, j] = heights[i, j] + 0.25 * np.sqrt(rise * rise + tilt * tilt)


@njit(cache=True)
def overlap_block(heights, row_highest, highest, spacing, radius, x, y, approach):
    """Find the bounding block of the nodes whose gap is below the approach.

    The block is (first row, last row, first column, last column).

    The search covers the whole disc that the highest node allows, at most one period to each side,
    because an island may lie outside any earlier window. An empty block has its last row before its
    first.
    """
    reach2 = 2 * radius * (approach + highest)
    if reach2 <= 0.0:
        return 1, 0, 1, 0
    # The reach is half a node more than a period, so that rounding does not hide the image of a
    # node right below the sphere.
    reach = min(np.sqrt(reach2), (heights.shape[0] + 0.5) * spacing)
    low = int(np.ceil((x - reach) / spacing))
    high = int(np.floor((x + reach) / spacing))
    # The first and the last row give the first columns. Of all rows between them only the nodes
    # beyond the columns so far can widen the block.
    first_row = low
    while first_row <= high:
        first_column, last_column = overlap_of_row(
            heights, row_highest, spacing, radius, x, y, approach, first_row, 1, 0
        )
        if first_column <= last_column:
            break
        first_row += 1
    if first_row > high:
        return 1, 0, 1, 0
    last_row = high
    while last_row > first_row:
        left, right = overlap_of_row(
            heights, row_highest, spacing, radius, x, y, approach, last_row, 1, 0
        )
        if left <= right:
            first_column, last_column = min(first_column, left), max(last_column, right)
            break
        last_row -= 1
    # Middle rows are the widest. They come first and leave little to search in the others.
    middle = min(max(round(x / spacing), first_row + 1), last_row)
    for i in range(middle, last_row):
        first_column, last_column = overlap_of_row(
            heights, row_highest, spacing, radius, x, y, approach, i, first_column, last_column
        )
    for i in range(middle - 1, first_row, -1):
        first_column, last_column = overlap_of_row(
            heights, row_highest, spacing, radius, x, y, approach, i, first_column, last_column
        )
    return first_row, last_row, first_column, last_column


@njit(cache=True)
def overlap_of_row(
    heights, row_highest, spacing, radius, x, y, approach, i, first_column, last_column
):
    """Widen columns (first, last) to those of the nodes of row i whose gap is below the approach.

    Columns are empty where the first is beyond the last.
    """
    along, across = heights.shape
    dx = i * spacing - x
    width2 = 2 * radius * (approach + row_highest[i % along]) - dx * dx
    if width2 <= 0.0:
        return first_column, last_column
    width = min(np.sqrt(width2), (across + 0.5) * spacing)
    left = int(np.ceil((y - width) / spacing))
    right = int(np.floor((y + width) / spacing))
    z = heights[i % along]
    rise = dx * dx / (2 * radius) - approach
    empty = first_column > last_column
    end = right + 1 if empty else min(right + 1, first_column)
    node = left % across
    for j in range(left, end):
        if rise + (j * spacing - y) ** 2 / (2 * radius) - z[node] < 0.0:
            first_column = j
            if empty:
                last_column = j
            break
        node = node + 1 if node < across - 1 else 0
    if first_column > last_column:
        return first_column, last_column
    node = right % across
    for j in range(right, max(last_column, left - 1), -1):
        if rise + (j * spacing - y) ** 2 / (2 * radius) - z[node] < 0.0:
            last_column = j
            break
        node = node - 1 if node > 0 else across - 1
    return first_column, last_column


@njit(cache=True)
def towards_the_sphere(p, u, gap, row_offset, column_offset, nodes):
    """Return slope and curvature of the energy from plate-fixed towards sphere-fixed pressures.

    Sphere-fixed pressures are the plate-fixed pressures moved `nodes` rows on.

    `gap` is the new undeformed gap on its window; the window of the pressures p and deflections u
    begins at the offsets in it.
    """
    slope = 0.0
    curvature = 0.0
    for i in range(nodes, p.shape[0]):
        a = i + row_offset
        if a < 0 or a >= gap.shape[0]:
            continue
        for j in range(max(0, -column_offset), min(p.shape[1], gap.shape[1] - column_offset)):
            towards = p[i - nodes, j] - p[i, j]
            if towards != 0.0:
                slope += (gap[a, j + column_offset] + u[i, j]) * towards
                curvature += towards * (u[i - nodes, j] - u[i, j])
    return slope, curvature


@njit(cache=True)
def trends(p, u, p_before, u_before, row_offset, column_offset, p_trend, u_trend):
    """Compute the changes of p and u since the previous position.

    The previous window begins at the offsets in the window of p and u.

    All nodes outside the previous window were unloaded. Their deflections are unknown, and the
    changes are set to zero.
    """
    first = max(0, -column_offset)
    end = max(first, min(p_before.shape[1], p.shape[1] - column_offset))
    a, b = first + column_offset, end + column_offset
    for k in range(p.shape[0]):
        i = k - row_offset
        if i < 0 or i >= p_before.shape[0] or end == first:
            p_trend[k] = p[k]
            u_trend[k] = 0.0
            continue
        p_trend[k, :a], p_trend[k, b:] = p[k, :a], p[k, b:]
        u_trend[k, :a] = u_trend[k, b:] = 0.0
        subtract(p[k, a:b], p_before[i, first:end], p_trend[k, a:b])
        subtract(u[k, a:b], u_before[i, first:end], u_trend[k, a:b])


@njit(cache=True)
def subtract(values, others, out):
    """Set `out` to the difference of two lines."""
    for k in range(out.size):
        out[k] = values[k] - others[k]


@njit(cache=True)
def loaded(pressure, deflection, hardness, edge, levelled):
    """Measure the loaded nodes of a window.

    Returns the numbers of nodes in contact and at the hardness, the maximum pressure, the sum of p
    u, and the block of the loaded nodes.

    A cell that the edge of a patch crosses is in contact and at the hardness on its share of the
    hardness. It counts so as far as its range of gaps counts (see `cell_ranges`), and as an elastic
    node for the rest. An empty `edge` means sharp edges.
    """
    count, capped, maximum, work = 0.0, 0.0, 0.0, 0.0
    first_row, last_row, first_column, last_column = pressure.shape[0], -1, pressure.shape[1], -1
    for i in range(pressure.shape[0]):
        row = pressure[i]
        first, end = 0, row.size
        while first < end and row[first] == 0.0:
            first += 1
        if first == end:
            continue
        while row[end - 1] == 0.0:
            end -= 1
        p = row[first:end]
        touching, full, highest, pu = measure_row(p, deflection[i, first:end], hardness)
        if edge.size:
            crossing, in_contact, at_hardness = shares_of_row(
                p, edge[i, first:end], hardness, levelled
            )
            touching = (touching - crossing) + in_contact
            full += at_hardness
        count += touching
        capped += full
        maximum = max(maximum, highest)
        work += pu
        first_row, last_row = min(first_row, i), i
        first_column, last_column = min(first_column, first), max(last_column, end - 1)
    return count, capped, maximum, work, first_row, last_row, first_column, last_column


@njit(cache=True, fused=True)
def measure_row(p, u, hardness):
    """Return the numbers of nodes in contact and at the hardness, max p, and the sum of p u."""
    count, capped, highest, work = 0.0, 0.0, 0.0, 0.0
    for k in range(p.size):
        count += 1.0 if p[k] > 0.0 else 0.0
        capped += 1.0 if p[k] >= hardness else 0.0
        highest = max(highest, p[k])
        work += p[k] * u[k]
    return count, capped, highest, work


@njit(cache=True, fused=True)
def shares_of_row(p, edge, hardness, levelled):
    """Return the number of cells that edges cross, and of them in contact and at the hardness."""
    crossing, in_contact, capped = 0.0, 0.0, 0.0
    for k in range(p.size):
        crosses = (0.0 < p[k] < hardness) and edge[k] > 0.0
        half = edge[k] if crosses else 1.0
        crossed = half / max(half, 0.5 * half + levelled)
        full = crossed * (p[k] / hardness)
        crossing += 1.0 if crosses else 0.0
        in_contact += (1.0 - crossed) + full if crosses else 0.0
        capped += full if crosses else 0.0
    return crossing, in_contact, capped


@njit(cache=True)
def copy_block(source, target, row_offset, column_offset):
    """Set target[i + row_offset, j + column_offset] to source[i, j] where both exist.

    The target is 0 elsewhere.
    """
    target[:] = 0.0
    first = max(0, -column_offset)
    end = max(first, min(source.shape[1], target.shape[1] - column_offset))
    for i in range(max(0, -row_offset), min(source.shape[0], target.shape[0] - row_offset)):
        line = target[i + row_offset, first + column_offset : end + column_offset]
        line[:] = source[i, first:end]
