"""Compiled passes over two successive states: release of each node, and its events."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from rolling.contact._compiled import njit


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
