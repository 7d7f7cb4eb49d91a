"""Compiled passes over solved states: loaded nodes, their measures, release and events."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from rolling.contact.compiling import njit

AT_ONCE = 16  # nodes whose sum tells whether any of them is loaded


@njit(cache=True, fused=True)
def sum_of_sizes(values):
    """Return the sum of absolute values."""
    total = 0.0
    for k in range(values.size):
        total += abs(values[k])
    return total


@njit(cache=True)
def loaded_range(row):
    """Return the first loaded node of a row and the node after the last, or equal numbers."""
    first, end = 0, row.size
    while end - first >= AT_ONCE and sum_of_sizes(row[first : first + AT_ONCE]) == 0.0:
        first += AT_ONCE
    while first < end and row[first] == 0.0:
        first += 1
    while end - first >= AT_ONCE and sum_of_sizes(row[end - AT_ONCE : end]) == 0.0:
        end -= AT_ONCE
    while first < end and row[end - 1] == 0.0:
        end -= 1
    return first, end


@njit(cache=True)
def reach(pressure):
    """Return the maximum distances of a row and a column from a loaded row and column.

    They are at least half the window, which must fit.
    """
    rows, columns = pressure.shape
    first_row, last_row, first_column, end_column = rows, 0, columns, 1
    for i in range(rows):
        first, end = loaded_range(pressure[i])
        if first == end:
            continue
        first_row, last_row = min(first_row, i), i
        first_column, end_column = min(first_column, first), max(end_column, end)
    return (
        max(last_row, rows - 1 - first_row, (rows + 1) // 2),
        max(end_column - 1, columns - 1 - first_column, (columns + 1) // 2),
    )


@njit(cache=True)
def measures(pressure, deflection, hardness, edge, levelled):
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
        first, end = loaded_range(row)
        if first == end:
            continue
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
    a, b = first + column_offset, end + column_offset
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


@njit(cache=True, fused=True)
def row_work(old, new, left_end, cell, work):
    """Set the work of a row of nodes as `node_work` does; return its sums."""
    p_old, u_old = old
    p_new, u_new = new
    release, loading = 0.0, 0.0
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
            a, b = (row + i) % along, (column + j) % across
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
