"""Compiled passes over two successive states: what each node releases, and the events it belongs to."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from numba import njit


@njit(cache=True)
def node_work(p_old, u_old, row_offset, column_offset, p_new, u_new, left_end, cell, work):
    """work = pressure times fall of the deflection [J] per node: positive is release, negative is loading. Returns both sums.

    The old window begins at the offsets in the new one; outside it nothing was loaded, nor is, where its deflection counts.
    """
    release = 0.0
    loading = 0.0
    work[:] = 0.0
    for i in range(max(0, -row_offset), min(p_old.shape[0], work.shape[0] - row_offset)):
        for j in range(max(0, -column_offset), min(p_old.shape[1], work.shape[1] - column_offset)):
            a, b = i + row_offset, j + column_offset
            p = p_old[i, j] if left_end else 0.5 * (p_old[i, j] + p_new[a, b])
            w = p * (u_old[i, j] - u_new[a, b]) * cell
            work[a, b] = w
            release += max(w, 0.0)
            loading -= min(w, 0.0)
    return release, loading


@njit(cache=True)
def extend_events(work, row, column, step, open_event, first, last, energy, peak, node, count):
    """Add the releases of one step to the table of events; a node that released in the step before goes on with its event.

    Returns the new count, or -1 - (rows needed) with nothing done when the table is too short.
    """
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
            event = open_event[a, b]
            if event < 0 or last[event] != step:
                event = count
                count += 1
                open_event[a, b] = event
                first[event] = step
                energy[event] = 0.0
                peak[event] = 0.0
                node[event, 0] = a
                node[event, 1] = b
            last[event] = step + 1
            energy[event] += w
            peak[event] = max(peak[event], w)
    return count
