"""Compiled passes on the contact conditions: bounds and load, deformed gaps, approach, violation.

Candidates lie between the bounds or on one of them in no order that a processor could foresee, and
a wrong guess costs as much as ten sums. The passes therefore select values instead of branching.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import types

from rolling.contact._kinds import FLAG, LIMITS, LINE, NOTHING, NUMBER, SETS
from rolling.contact._linked import linked
from rolling.contact.compiling import inlined, njit

# Share of the load that rounding may lose in a direction; each direction makes up for the last. At
# 1e-15, near the rounding of a sum of thousands of pressures, 5 of 8 trials took a further pass.
LOAD_ROUNDING = 1e-14


@inlined(fused=True)
def sum_of(values):
    """Return the sum of values."""
    total = 0.0
    for k in range(values.size):
        total += values[k]
    return total


@linked(types.UniTuple(NUMBER, 2)(LINE, LINE, NUMBER, LINE, SETS, LIMITS, LINE))
def project(p, g, approach, trial, sets, limits, d):
    """Set d to the direction from p to the feasible pressures nearest to `trial`.

    Free nodes are shifted and clipped, bound nodes go to their bound, and all others stay. A common
    shift of the free nodes restores the load exactly. `trial` [Pa] holds unbounded pressures of the
    free nodes before, and feasible pressures after; of the bound nodes it holds their bound.

    Returns the slope of the energy along d [Pa m] and the maximum step length within the bounds, or
    (inf, 0) where the free nodes cannot take up the load.
    """
    active = sets.active
    hardness = limits.hardness
    total = limits.total
    bound = active[sets.free : sets.free + sets.bound]
    target = total - sum_of(p) + sum_listed(p, active[: sets.free]) + sum_listed(p, bound)
    target -= sum_listed(trial, bound)
    if sets.free == 0:
        if abs(target) > 1e-13 * total:
            return np.inf, 0.0
    elif target < 0.0 or target > sets.free * hardness * (1.0 + 1e-13):
        return np.inf, 0.0
    free = d[: sets.free]  # trial pressures of the free nodes side by side, until d is set
    for a in range(free.size):
        free[a] = trial[active[a]]
    shift = find_shift(free, target, limits)
    for a in range(free.size):
        free[a] = min(max(free[a] + shift, 0.0), hardness)
    restore_load(free, g, active, target, limits)
    for a in range(free.size):
        trial[active[a]] = free[a]
    d[:] = 0.0
    for a in range(sets.free + sets.bound):
        k = active[a]
        d[k] = trial[k] - p[k]
    return slope_and_longest_step(p, g, approach, sets, hardness, d)


@inlined(fused=True)
def sum_listed(values, listed):
    """Return the sum of listed values."""
    total = 0.0
    for a in range(listed.size):
        total += values[listed[a]]
    return total


@inlined(fused=True)
def carried_by(values, shift, hardness):
    """Return the sum of shifted pressures within the bounds, and how many are between them."""
    carried = 0.0
    moving = 0.0
    for a in range(values.size):
        v = values[a] + shift
        carried += min(max(v, 0.0), hardness)
        moving += 1.0 if 0.0 < v < hardness else 0.0
    return carried, moving


@inlined()
def find_shift(free, target, limits):
    """Find the shift [Pa] of the trial pressures of free nodes that makes them carry `target` [Pa].

    Their sum within the bounds then equals `target`.

    The sum is a monotone, piecewise linear function of the shift. Newton's method finds it within a
    shrinking bracket.
    """
    hardness = limits.hardness
    top = min(hardness, target)
    low = np.inf
    high = -np.inf
    for a in range(free.size):
        low = min(low, -free[a])
        high = max(high, top - free[a])
    shift = 0.0 if low < 0.0 < high else 0.5 * (low + high)
    for _ in range(200):
        carried, moving = carried_by(free, shift, hardness)
        error = target - carried
        if abs(error) <= LOAD_ROUNDING * limits.total or free.size == 0:
            break
        if error > 0.0:
            low = shift
        else:
            high = shift
        following = shift + error / moving if moving else np.inf
        if not low < following < high:
            following = 0.5 * (low + high)
        if following == shift:
            break
        shift = following
    return shift


@inlined()
def restore_load(free, g, active, target, limits):
    """Spread the load that rounding of the shift has lost over the free nodes.

    Only nodes between the bounds take part. `free` has the trial pressures of the first nodes in
    `active`.

    The shift is rounded coarsely where the direction is much larger than the pressures. Where no
    node lies between the bounds, the lowest open node takes the missing part, or the highest loaded
    node gives the excess up.
    """
    hardness = limits.hardness
    for turn in range(64):
        carried, moving = carried_by(free, 0.0, hardness)
        error = target - carried
        if abs(error) <= (LOAD_ROUNDING if turn < 4 else 10 * LOAD_ROUNDING) * limits.total:
            break
        nearest = -1
        for a in range(free.size):
            if 0.0 < free[a] < hardness:
                free[a] = min(max(free[a] + error / moving, 0.0), hardness)
            elif moving == 0 and (
                nearest < 0 or (g[active[a]] < g[active[nearest]]) == (error > 0.0)
            ):
                nearest = a if (free[a] < hardness if error > 0.0 else free[a] > 0.0) else nearest
        if nearest >= 0:
            free[nearest] = min(max(free[nearest] + error, 0.0), hardness)


@inlined()
def slope_and_longest_step(p, g, approach, sets, hardness, d):
    """Return the slope of the energy along d [Pa m] and the maximum step length.

    The step length within the bounds is at least 1.
    """
    slope = 0.0
    longest = np.inf
    for a in range(sets.free + sets.bound):
        k = sets.active[a]
        slope += (g[k] - approach) * d[k]
        if d[k] < 0.0:
            longest = min(longest, -p[k] / d[k])
        elif d[k] > 0.0:
            longest = min(longest, (hardness - p[k]) / d[k])
    return slope, max(longest, 1.0)


@linked(NOTHING(LINE, LINE, LIMITS, NUMBER))
def settle_load(p, g, limits, trace):
    """Give the missing load to the lowest open nodes, or take the excess from loaded nodes.

    The excess comes from the highest loaded nodes.

    Nodes within `trace` [Pa] of a bound are put on it first, because their load may be an artefact.
    """
    hardness = limits.hardness
    missing = limits.total
    for k in range(p.size):
        if p[k] <= trace:
            p[k] = 0.0
        elif p[k] >= hardness - trace:
            p[k] = hardness
        missing -= p[k]
    for _ in range(p.size):
        if abs(missing) <= 1e-16 * limits.total:
            return
        best = -1
        for k in range(p.size):
            may = p[k] < hardness if missing > 0.0 else p[k] > 0.0
            if may and (best < 0 or (g[k] < g[best]) == (missing > 0.0)):
                best = k
        if best < 0:
            return
        change = min(max(p[best] + missing, 0.0), hardness) - p[best]
        p[best] += change
        missing -= change


MAXIMA = 256  # maxima that are found at a time


@inlined(fused=True)
def sum_inside(p, values, hardness):
    """Return the number of pressures between the bounds, and the sum of their values."""
    inside = 0.0
    total = 0.0
    for k in range(p.size):
        free = 0.0 < p[k] < hardness
        inside += 1.0 if free else 0.0
        total += values[k] if free else 0.0
    return inside, total


@inlined()
def middle_of_bounds(p, g, hardness):
    """Return the middle of the interval over which the approach is free [m].

    It is free where no pressure is between the bounds: above the highest capped node, and below the
    lowest open node.
    """
    lowest_open = np.inf
    highest_capped = -np.inf
    for k in range(p.size):
        if p[k] <= 0.0:
            lowest_open = min(lowest_open, g[k])
        elif p[k] >= hardness:
            highest_capped = max(highest_capped, g[k])
    middle = 0.5 * (lowest_open + highest_capped)
    # An infinite middle means that each node is capped, or that the open nodes are no candidates.
    return middle if np.isfinite(middle) else highest_capped


@linked(NUMBER(LINE, LINE, NUMBER))
def approach_of(p, g, hardness):
    """Return the approach [m] of pressures p over deformed gaps g, flat arrays.

    The mean gap of the nodes between the bounds vanishes there.
    """
    inside, total = sum_inside(p, g, hardness)
    return total / inside if inside else middle_of_bounds(p, g, hardness)


@inlined()
def highest_of(values):
    """Return the maximum of values, at least 0; numba takes a second to compile `values.max()`."""
    highest = 0.0
    for k in range(values.size):
        highest = max(highest, values[k])
    return highest


@inlined(fused=True)
def raise_maxima(p, g, approach, hardness, maxima):
    """Raise maxima to the violations [m] of the contact conditions by as many nodes."""
    for k in range(maxima.size):
        gap = g[k] - approach
        opening = gap if p[k] > 0.0 else 0.0
        overlap = -gap if p[k] < hardness else 0.0
        maxima[k] = max(maxima[k], max(opening, overlap))


@linked(types.UniTuple(NUMBER, 2)(LINE, LINE, NUMBER, NUMBER))
def worst_and_load(p, g, approach, hardness):
    """Return the maximum violation of the contact conditions [m] and the sum of pressures [Pa]."""
    # A single maximum would wait for the one before it.
    maxima = np.zeros(MAXIMA)
    for k in range(0, p.size, MAXIMA):
        last = min(k + MAXIMA, p.size)
        raise_maxima(p[k:last], g[k:last], approach, hardness, maxima[: last - k])
    return highest_of(maxima), sum_of(p)


@inlined(fused=True)
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


@inlined(fused=True)
def raise_to(values, maxima):
    """Raise maxima to as many values."""
    for k in range(maxima.size):
        maxima[k] = max(maxima[k], values[k])


@inlined()
def maximum_of(values):
    """Return the maximum of values, at least 0."""
    maxima = np.zeros(MAXIMA)
    for k in range(0, values.size, MAXIMA):
        last = min(k + MAXIMA, values.size)
        raise_to(values[k:last], maxima[: last - k])
    return highest_of(maxima)


@linked(
    types.UniTuple(NUMBER, 3)(LINE, LINE, LINE, LINE, NUMBER, LINE, FLAG),
    calls=(approach_of, worst_and_load),
)
def state_of(gap, u, p, edge, hardness, g, fresh):
    """Return approach, maximum deflection and maximum violation [m] of a state.

    The state has undeformed gaps, deflections u and pressures p, as flat arrays. Its deformed gaps
    before the approach is subtracted go into g [m] (see `deform`). The violation of the contact
    conditions is infinite where numbers are not finite, and unless the deflections are `fresh`;
    the maximum deflection is not a number where the gaps are none.
    """
    strange = deform(gap, u, p, edge, hardness, g)
    approach = approach_of(p, g, hardness)
    if strange:
        return approach, np.nan, np.inf
    worst, _ = worst_and_load(p, g, approach, hardness) if fresh else (np.inf, 0.0)
    return approach, maximum_of(u), worst


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
