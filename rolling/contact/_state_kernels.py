"""Compiled measures of a state: its deformed gaps, approach and violation.

Candidates lie between the bounds or on one of them in no order that a processor could foresee, and
a wrong guess costs as much as ten sums. The passes therefore select values instead of branching.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np

from rolling.contact._compiled import njit


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
def violation(p, gap, hardness):
    """Return the violation of the contact conditions [m] by a pressure at a gap."""
    opening = gap if p > 0.0 else 0.0
    overlap = -gap if p < hardness else 0.0
    return max(opening, overlap)


@njit(cache=True, fused=True)
def worst_and_load(p, g, approach, hardness):
    """Return the maximum violation of the contact conditions [m] and the sum of pressures [Pa]."""
    # Four maxima at a time, because each waits for the one before it.
    worst = second = third = fourth = load = 0.0
    whole = p.size - p.size % 4
    for k in range(0, whole, 4):
        worst = max(worst, violation(p[k], g[k] - approach, hardness))
        second = max(second, violation(p[k + 1], g[k + 1] - approach, hardness))
        third = max(third, violation(p[k + 2], g[k + 2] - approach, hardness))
        fourth = max(fourth, violation(p[k + 3], g[k + 3] - approach, hardness))
        load += (p[k] + p[k + 1]) + (p[k + 2] + p[k + 3])
    for k in range(whole, p.size):
        worst = max(worst, violation(p[k], g[k] - approach, hardness))
        load += p[k]
    return max(max(worst, second), max(third, fourth)), load


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
def state_of(gap, u, p, edge, hardness, g):
    """Return approach [m] and maximum violation [m] of a state.

    The state has undeformed gaps, deflections u and pressures p, as flat arrays. Its deformed gaps
    before the approach is subtracted go into g [m] (see `deform`). The violation of the contact
    conditions is infinite where numbers are not finite.
    """
    strange = deform(gap, u, p, edge, hardness, g)
    approach = approach_of(p, g, hardness)
    worst, _ = worst_and_load(p, g, approach, hardness)
    return approach, (np.inf if strange else worst)
