"""Compiled measures of a state: its deformed gaps, approach and violation.

Candidates lie between the bounds or on one of them in no order that a processor could foresee, and
a wrong guess costs as much as ten sums. The passes therefore select values instead of branching.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np

from rolling.contact._compiled import njit
from rolling.contact._projection import sum_of

MAXIMA = 256  # maxima that are found at a time


@njit(cache=True, fused=True)
def sum_inside(p, values, hardness):
    """Return the number of pressures between the bounds, and the sum of their values."""
    inside, total = 0.0, 0.0
    for k in range(p.size):
        free = 0.0 < p[k] < hardness
        inside += 1.0 if free else 0.0
        total += values[k] if free else 0.0
    return inside, total


@njit(cache=True)
def middle_of_bounds(p, g, hardness):
    """Return the middle of the interval over which the approach is free [m].

    It is free where no pressure is between the bounds: above the highest capped node, and below the
    lowest open node.
    """
    lowest_open, highest_capped = np.inf, -np.inf
    for k in range(p.size):
        if p[k] <= 0.0:
            lowest_open = min(lowest_open, g[k])
        elif p[k] >= hardness:
            highest_capped = max(highest_capped, g[k])
    middle = 0.5 * (lowest_open + highest_capped)
    # An infinite middle means that each node is capped, or that the open nodes are no candidates.
    return middle if np.isfinite(middle) else highest_capped


@njit(cache=True)
def approach_of(p, g, hardness):
    """Return the approach [m] of pressures p over deformed gaps g, flat arrays.

    The mean gap of the nodes between the bounds vanishes there.
    """
    inside, total = sum_inside(p, g, hardness)
    return total / inside if inside else middle_of_bounds(p, g, hardness)


@njit(cache=True, fused=True)
def raise_maxima(p, g, approach, hardness, maxima):
    """Raise maxima to the violations [m] of the contact conditions by as many nodes."""
    for k in range(maxima.size):
        gap = g[k] - approach
        opening = gap if p[k] > 0.0 else 0.0
        overlap = -gap if p[k] < hardness else 0.0
        maxima[k] = max(maxima[k], max(opening, overlap))


@njit(cache=True)
def worst_and_load(p, g, approach, hardness):
    """Return the maximum violation of the contact conditions [m] and the sum of pressures [Pa]."""
    # A single maximum would wait for the one before it.
    maxima = np.zeros(MAXIMA)
    for k in range(0, p.size, MAXIMA):
        last = min(k + MAXIMA, p.size)
        raise_maxima(p[k:last], g[k:last], approach, hardness, maxima[: last - k])
    return maxima.max(), sum_of(p)


@njit(cache=True, fused=True)
def deform(gap, u, p, edge, hardness, g):
    """Set g to the deformed gaps; return how many of them are not a number.

    A cell that the edge of a patch crosses has gap = edge (1 - 2 p / H): a gap lower by the edge on
    a node that gives 2 edge / H by itself. An empty `edge` means sharp edges.
    """
    per_hardness = 2.0 / hardness
    strange = 0.0
    for k in range(g.size):
        v = gap[k] + u[k]
        if edge.size:
            v = (gap[k] - edge[k]) + (u[k] + edge[k] * (p[k] * per_hardness))
        g[k] = v
        strange += 1.0 if v != v else 0.0
    return strange


@njit(cache=True)
def state_of(gap, u, p, edge, hardness, g, fresh):
    """Return approach [m] and maximum violation [m] of a state.

    The state has undeformed gaps, deflections u and pressures p, as flat arrays. Its deformed gaps
    before the approach is subtracted go into g [m] (see `deform`). The violation of the contact
    conditions is infinite where numbers are not finite, and unless the deflections are `fresh`.
    """
    strange = deform(gap, u, p, edge, hardness, g)
    approach = approach_of(p, g, hardness)
    if strange or not fresh:
        return approach, np.inf
    worst, _ = worst_and_load(p, g, approach, hardness)
    return approach, worst


@njit(cache=True)
def yielding_overlap(gap, u, p, hardness, approach, enough):
    """Return the maximum overlap [m] of the nodes at the hardness, or one that is `enough`.

    The overlap is that of the undeformed gap and the deflection u with the approach; it is 0 where
    no node is at the hardness. The search begins in the middle, where the pressures are highest.
    """
    overlap = 0.0
    for k in range(p.size):
        node = (k + p.size // 2) % p.size
        if p[node] >= hardness:
            overlap = max(overlap, approach - gap[node] - u[node])
            if overlap >= enough:
                break
    return overlap


@njit(cache=True)
def has_partial_cells(p, edge, hardness):
    """Tell whether any node between the bounds has an edge."""
    count = 0
    for k in range(p.size):
        count += edge[k] > 0.0 and 0.0 < p[k] < hardness
    return count > 0
