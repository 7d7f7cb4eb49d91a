"""Compiled passes over windows: gap, overlap, extrapolation, loaded nodes, release and events.

Rows and columns of gap and overlap count on the unrolled plate; heights repeat with their period.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import types

from rolling.contact._kinds import FIELD, LINE, NOTHING, NUMBER, WHOLE
from rolling.contact._linked import linked
from rolling.contact.compiling import inlined, njit

STRETCH = 16  # nodes of a row whose maximum height is known
_PAIR = types.UniTuple(WHOLE, 2)
_PLATE = types.Tuple((FIELD, FIELD, LINE))  # of `overlap_of_row`, as is the sphere
_SPHERE = types.Tuple((*(NUMBER,) * 6, types.UniTuple(NUMBER, 2)))


@inlined()
def copy_line(source, target):
    """Copy values; an assignment to a slice would take seconds to compile."""
    for k in range(target.size):
        target[k] = source[k]


@njit(cache=True)
def undeformed_gap(heights, sphere, row, column, out):
    """Set `out` to the undeformed gap on the window that begins at node (row, column).

    The gap is (x_i - x)^2 / (2 R) + (y_j - y)^2 / (2 R across) - z. `sphere` has spacing, radii
    and place.
    """
    spacing, radius, radius_across, x, y = sphere
    along, across = heights.shape
    curvature = 0.5 / radius
    curvature_across = 0.5 / radius_across
    rises = np.empty(out.shape[1])
    for j in range(rises.size):
        dy = (column + j) * spacing - y
        rises[j] = dy * dy * curvature_across
    for i in range(out.shape[0]):
        dx = (row + i) * spacing - x
        rise = dx * dx * curvature
        z = heights[(row + i) % along]
        line = out[i]
        node = column % across
        j = 0
        while j < line.size:  # each turn handles a stretch within one period
            stretch = min(line.size - j, across - node)
            above(rise, rises[j : j + stretch], z[node : node + stretch], line[j : j + stretch])
            j += stretch
            node = 0


@inlined()
def above(rise, rises, z, out):
    """Set `out` to the height of a row of the sphere above the plate."""
    for k in range(out.size):
        out[k] = (rise + rises[k]) - z[k]


@njit(cache=True)
def cell_tops(heights, out):
    """Set `out` to the maximum height within the cell of each node, by the slope at the node."""
    along, across = heights.shape
    for i in range(along):
        before = heights[i - 1]
        after = heights[(i + 1) % along]
        for j in range(across):
            rise = after[j] - before[j]
            tilt = heights[i, (j + 1) % across] - heights[i, j - 1]
            out[i, j] = heights[i, j] + 0.25 * np.sqrt(rise * rise + tilt * tilt)


@inlined()
def farthest_gap(highest, sphere, approach, blended):
    """Return the maximum gap [m] at a node whose cell touches at an approach.

    With blended edges the sphere may touch the near side of a cell. It is lower there than over the
    node by half a side times its slope, (2 d / R)^(1/2) at a distance d above the highest node.
    """
    if not blended:
        return approach
    half = 0.5 * sphere[0]
    radius = min(sphere[1], sphere[2])
    touching = max(approach + highest, 0.0)
    return approach + half * (half + np.sqrt(half * half + 2 * radius * touching)) / radius


@inlined()
def least_deflection(load, distance2):
    """Return the minimum deflection [m] at a node by the whole load.

    `load` holds the load over pi E* and a square [m2]: the mean square distance of the load from
    the node is at most the sum of that and `distance2`, the squared distance of the node from the
    centre. Deflections fall as 1/r, which is convex in r^2: their mean is no less than that at the
    mean square distance (Jensen's inequality).
    """
    return load[0] / np.sqrt(distance2 + load[1])


@linked(_PAIR(_PLATE, _SPHERE, WHOLE, _PAIR))
def overlap_of_row(plate, sphere, i, columns):
    """Widen columns (first, last) to those of the nodes of row i whose gap is below the approach.

    Columns are empty where the first is beyond the last. `plate` and `sphere` are arguments of
    `overlap`.
    """
    heights, stretches, row_highest = plate
    spacing, radius, radius_across, x, y, approach, load = sphere
    along, across = heights.shape
    dx = i * spacing - x
    width2 = 2 * radius * (approach + row_highest[i % along]) - dx * dx
    if width2 <= 0.0:
        return columns
    width2 -= 2 * radius * least_deflection(load, dx * dx + width2 * (radius_across / radius))
    if width2 <= 0.0:
        return columns
    width = min(np.sqrt(width2 * (radius_across / radius)), (across + 0.5) * spacing)
    left = int(np.ceil((y - width) / spacing))
    right = int(np.floor((y + width) / spacing))
    row = heights[i % along], stretches[i % along]
    rise = dx * dx / (2 * radius) - approach
    sphere = spacing, radius_across, y, (load[0], load[1] + dx * dx)
    if columns[0] > columns[1]:
        first = search_row(row, rise, sphere, left, right, 1)
        if first > right:
            return columns
        columns = first, first
    else:
        first = search_row(row, rise, sphere, left, columns[0] - 1, 1)
        columns = min(first, columns[0]), columns[1]
    end = max(columns[1] + 1, left)
    last = search_row(row, rise, sphere, right, end, -1)
    return columns[0], max(last, columns[1])


@inlined()
def search_row(row, rise, sphere, begin, end, step):
    """Return the first node of a row from `begin` to `end` whose gap is below the approach.

    Return the node after `end` if there is none. `row` has the heights and the maximum heights of
    stretches, `rise` is the height of the sphere above the approach in the middle of the row,
    `sphere` the spacing, the radius and the place across, and `load` in the row, and `step` is 1 or
    -1.
    """
    (z, tops), (spacing, radius_across, y, load) = row, sphere
    j = begin
    node = begin % z.size
    while (end - j) * step >= 0:
        stretch = node // STRETCH
        if step > 0:
            last = min(end, j + min((stretch + 1) * STRETCH, z.size) - 1 - node)
        else:
            last = max(end, j + stretch * STRETCH - node)
        # Where the highest node nearest to the sphere is not below, none of the stretch is.
        here = j * spacing - y
        there = last * spacing - y
        nearest = min(abs(here), abs(there)) if here * there > 0.0 else 0.0
        farthest = max(abs(here), abs(there))
        gap = rise + nearest * nearest / (2 * radius_across) - tops[stretch]
        if gap < 0.0 and gap + least_deflection(load, farthest * farthest) < 0.0:
            for k in range(j, last + step, step):
                apart = k * spacing - y
                apart2 = apart * apart
                gap = rise + apart2 / (2 * radius_across) - z[node + k - j]
                if gap < 0.0 and gap + least_deflection(load, apart2) < 0.0:
                    return k
        node += last + step - j
        node = 0 if node == z.size else z.size - 1 if node < 0 else node
        j = last + step
    return j


@njit(cache=True, calls=(overlap_of_row,))
def overlap(maxima, sphere, approach, load, blended):
    """Find the window (row, column, rows, columns) where contact at an approach [m] can be.

    The gap, with the minimum deflection, is below the approach there. Contact at a smaller approach
    lies inside. With blended edges the gap is that of the top of each cell, and there is a border
    of one node, because the edge of a cell needs nodes on both sides. A window without contact has
    no rows.

    `maxima` are the fields of `Maxima`, `sphere` its spacing, radii and place, and `load` the
    numbers of the minimum deflection (see `least_deflection`).

    The search covers the whole ellipse that the highest node allows, at most one period to each
    side, because an island may lie outside any earlier window.
    """
    heights, stretches, row_highest, highest = maxima
    spacing, radius, radius_across, x, y = sphere
    approach = farthest_gap(highest, sphere, approach, blended)
    nowhere = (0, 0, 0, 0)
    reach2 = 2 * radius * (approach + highest)
    if reach2 <= 0.0:
        return nowhere
    # The reach is half a node more than a period, so that rounding does not hide the image of a
    # node right below the sphere.
    reach = min(np.sqrt(reach2), (heights.shape[0] + 0.5) * spacing)
    low = int(np.ceil((x - reach) / spacing))
    high = int(np.floor((x + reach) / spacing))
    plate = heights, stretches, row_highest
    sphere = spacing, radius, radius_across, x, y, approach, load
    # The first and the last row give the first columns. In the rows between them, only the nodes
    # beyond the columns so far can widen the block.
    empty = 1, 0
    first_row = low
    columns = empty
    while first_row <= high:
        columns = overlap_of_row(plate, sphere, first_row, empty)
        if columns[0] <= columns[1]:
            break
        first_row += 1
    if first_row > high:
        return nowhere
    last_row = high
    while last_row > first_row:
        left, right = overlap_of_row(plate, sphere, last_row, empty)
        if left <= right:
            columns = min(columns[0], left), max(columns[1], right)
            break
        last_row -= 1
    # Middle rows are the widest. They come first and leave little to search in the others.
    middle = min(max(round(x / spacing), first_row + 1), last_row)
    for i in range(middle, last_row):
        columns = overlap_of_row(plate, sphere, i, columns)
    for i in range(middle - 1, first_row, -1):
        columns = overlap_of_row(plate, sphere, i, columns)
    border = 1 if blended else 0
    rows = last_row - first_row + 1
    width = columns[1] - columns[0] + 1
    return first_row - border, columns[0] - border, rows + 2 * border, width + 2 * border


@inlined()
def shared(first, length, begin, end):
    """Return the part of a window from `first` on, so many nodes long, within `begin` to `end`."""
    low = min(max(first, begin), end)
    return low, max(low, min(first + length, end))


@linked(NOTHING(FIELD, FIELD, WHOLE, WHOLE, FIELD))
def extrapolate_deflection(u, u_before, row, column, out):
    """Set `out` to the deflections u with their change since the previous position once more.

    The previous window begins at (row, column) in the window of u. Off it, where deflections are
    unknown, `out` is u.
    """
    a, b = shared(column, u_before.shape[1], 0, u.shape[1])
    for i in range(u.shape[0]):
        copy_line(u[i], out[i])
    first, last = shared(row, u_before.shape[0], 0, u.shape[0])
    for i in range(first, last):
        extrapolate_line(u[i, a:b], u_before[i - row, a - column : b - column], out[i, a:b])


@inlined()
def extrapolate_line(values, before, out):
    """Set `out` to values and their change."""
    for k in range(out.size):
        out[k] = values[k] + (values[k] - before[k])


@njit(cache=True)
def copy_block(source, target, row_offset, column_offset, continued):
    """Set target[i + row_offset, j + column_offset] to source[i, j] where both exist.

    The target is 0 elsewhere, or that of the nearest node if `continued`.
    """
    target[:] = 0.0
    last_row = source.shape[0] - 1
    last_column = source.shape[1] - 1
    first, end = shared(column_offset, source.shape[1], 0, target.shape[1])
    for i in range(target.shape[0]):
        row = source[min(max(i - row_offset, 0), last_row)]
        line = target[i]
        if continued or 0 <= i - row_offset <= last_row:
            copy_line(row[first - column_offset : end - column_offset], line[first:end])
        if continued:
            line[:first] = row[min(max(first - column_offset, 0), last_column)]
            line[end:] = row[min(max(end - 1 - column_offset, 0), last_column)]


AT_ONCE = 16  # nodes whose sum tells whether any of them is loaded


@inlined(fused=True)
def sum_of_sizes(values):
    """Return the sum of absolute values."""
    total = 0.0
    for k in range(values.size):
        total += abs(values[k])
    return total


@linked(_PAIR(LINE))
def loaded_range(row):
    """Return the first loaded node of a row and the node after the last, or equal numbers."""
    first = 0
    end = row.size
    while end - first >= AT_ONCE and sum_of_sizes(row[first : first + AT_ONCE]) == 0.0:
        first += AT_ONCE
    while first < end and row[first] == 0.0:
        first += 1
    while end - first >= AT_ONCE and sum_of_sizes(row[end - AT_ONCE : end]) == 0.0:
        end -= AT_ONCE
    while first < end and row[end - 1] == 0.0:
        end -= 1
    return first, end


@njit(cache=True, calls=(loaded_range,))
def reach(pressure):
    """Return the maximum distances of a row and a column from a loaded row and column.

    They are at least half the window, which must fit.
    """
    rows, columns = pressure.shape
    first_row = rows
    last_row = 0
    first_column = columns
    end_column = 1
    for i in range(rows):
        first, end = loaded_range(pressure[i])
        if first == end:
            continue
        first_row = min(first_row, i)
        last_row = i
        first_column = min(first_column, first)
        end_column = max(end_column, end)
    return (
        max(last_row, rows - 1 - first_row, (rows + 1) // 2),
        max(end_column - 1, columns - 1 - first_column, (columns + 1) // 2),
    )


@inlined()
def measures(pressure, deflection, hardness, edge, levelled, row, column, reach):
    """Measure the loaded nodes of a window.

    Returns the numbers of nodes in contact and at the hardness, the maximum pressure, the sum of p
    u, the spread of the load [nodes], and the block of the loaded nodes.

    A cell that the edge of a patch crosses is in contact and at the hardness on its share of the
    hardness. It counts so as far as its range of gaps counts (see `cell_ranges`), and as an elastic
    node for the rest. An empty `edge` means sharp edges.

    The mean square distance of the load from a node within `reach` [nodes] of a row and a column,
    the centre, is at most the square of the node's distance from it plus that of the spread, less
    1: with it even a node's own deflection is no less than `least_deflection`.
    """
    count = 0.0
    capped = 0.0
    maximum = 0.0
    work = 0.0
    load = 0.0
    along = 0.0
    across = 0.0
    square = 0.0
    first_row = pressure.shape[0]
    last_row = -1
    first_column = pressure.shape[1]
    last_column = -1
    apart = np.empty(pressure.shape[1])
    for j in range(apart.size):
        apart[j] = j - column
    for i in range(pressure.shape[0]):
        first, end = loaded_range(pressure[i])
        if first == end:
            continue
        p = pressure[i, first:end]
        u = deflection[i, first:end]
        touching, full, highest, pu, moments = measure_row(p, u, hardness, apart[first:end])
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
        load += moments[0]
        along += moments[0] * (i - row)
        across += moments[1]
        square += moments[2] + moments[0] * ((i - row) * (i - row))
        first_row = min(first_row, i)
        last_row = i
        first_column = min(first_column, first)
        last_column = max(last_column, end - 1)
    spread = np.sqrt(1.0 + (square + 2.0 * reach * np.hypot(along, across)) / load)
    return count, capped, maximum, work, spread, first_row, last_row, first_column, last_column


@inlined(fused=True)
def measure_row(p, u, hardness, apart):
    """Return the numbers of nodes in contact and at the hardness, max p, and the sum of p u.

    The sum of pressures and those of their first and second moments follow.
    """
    count = 0.0
    capped = 0.0
    highest = 0.0
    work = 0.0
    load = 0.0
    moment = 0.0
    square = 0.0
    for k in range(p.size):
        count += 1.0 if p[k] > 0.0 else 0.0
        capped += 1.0 if p[k] >= hardness else 0.0
        highest = max(highest, p[k])
        work += p[k] * u[k]
        load += p[k]
        moment += p[k] * apart[k]
        square += p[k] * apart[k] * apart[k]
    return count, capped, highest, work, (load, moment, square)


@inlined(fused=True)
def shares_of_row(p, edge, hardness, levelled):
    """Return the number of cells that edges cross, and of them in contact and at the hardness."""
    crossing = 0.0
    in_contact = 0.0
    capped = 0.0
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
def node_work(old, offset, new, left_end, cell, work):
    """Set `work` to pressure times fall of the deflection [J] of each node.

    Returns the sums of release and loading.

    Positive work is release, and negative work is loading. `old` and `new` are pressure and
    deflection on their windows; the old window begins at `offset` (row, column) in the new window.
    A node outside the old window was unloaded before and is unloaded now.
    """
    p_old, u_old = old
    p_new, u_new = new
    row_offset, column_offset = offset
    release = 0.0
    loading = 0.0
    work[:] = 0.0
    first = max(0, -column_offset)
    end = max(first, min(p_old.shape[1], work.shape[1] - column_offset))
    a = first + column_offset
    b = end + column_offset
    for i in range(max(0, -row_offset), min(p_old.shape[0], work.shape[0] - row_offset)):
        k = i + row_offset
        released, loaded = row_work(
            (p_old[i, first:end], u_old[i, first:end]),
            (p_new[k, a:b], u_new[k, a:b]),
            left_end,
            cell,
            work[k, a:b],
        )
        release += released
        loading += loaded
    return release, loading


@inlined(fused=True)
def row_work(old, new, left_end, cell, work):
    """Set the work of a row of nodes as `node_work` does; return its sums."""
    p_old, u_old = old
    p_new, u_new = new
    release = 0.0
    loading = 0.0
    for k in range(work.size):
        p = p_old[k] if left_end else 0.5 * (p_old[k] + p_new[k])
        w = p * (u_old[k] - u_new[k]) * cell
        work[k] = w
        release += max(w, 0.0)
        loading -= min(w, 0.0)
    return release, loading


@njit(cache=True)
def extend_events(work, origin, step, open_event, table, count):
    """Add the releases of a step to the table of events.

    A node that released in the previous step continues its event.

    `work` [J] begins at node `origin` (row, column); `open_event` holds one more than the last
    event of each node of the surface, or 0, and `table` the columns node, first, last, energy and
    peak.

    Returns the new count, or -1 - (rows needed), without a change, when the table is too short.
    """
    row, column = origin
    node, first, last, energy, peak = table
    along, across = open_event.shape
    needed = count
    for i in range(work.shape[0]):
        for j in range(work.shape[1]):
            if work[i, j] > 0.0:
                needed += 1
    if needed > energy.size:
        return -1 - needed
    for i in range(work.shape[0]):
        for j in range(work.shape[1]):
            w = work[i, j]
            if not w > 0.0:
                continue
            a = (row + i) % along
            b = (column + j) % across
            event = open_event[a, b] - 1
            if event < 0 or last[event] != step:
                event = count
                count += 1
                open_event[a, b] = count
                first[event] = step
                energy[event] = 0.0
                peak[event] = 0.0
                node[event, 0] = a
                node[event, 1] = b
            last[event] = step + 1
            energy[event] += w
            peak[event] = max(peak[event], w)
    return count
