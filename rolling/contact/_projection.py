"""Compiled projection of pressures onto the bounds and the load.

The cache of Numba for `_solver_kernels` misses changes here and in `_system`: delete `__pycache__`
after an edit.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np

from rolling.contact._compiled import njit


@njit(cache=True, fused=True)
def sum_of(values):
    """Return the sum of values."""
    total = 0.0
    for k in range(values.size):
        total += values[k]
    return total


@njit(cache=True)
def project(p, g, approach, trial, sets, limits, d):
    """Set d to the direction from p to the feasible pressures nearest to `trial`.

    Free nodes are shifted and clipped, bound nodes go to their bound, and all others stay. A common
    shift of the free nodes restores the load exactly. `trial` [Pa] holds unbounded pressures of the
    free nodes before, and feasible pressures after; of the bound nodes it holds their bound.

    Returns the slope of the energy along d [Pa m] and the maximum step length within the bounds, or
    (inf, 0) where the free nodes cannot take up the load.
    """
    active, hardness, total = sets.active, limits.hardness, limits.total
    target = total - sum_of(p)
    d[:] = 0.0
    for a in range(sets.free + sets.bound):
        target += p[active[a]]
    for a in range(sets.free, sets.free + sets.bound):
        k = active[a]
        d[k] = trial[k] - p[k]
        target -= d[k] + p[k]
    if sets.free == 0:
        if abs(target) > 1e-13 * total:
            return np.inf, 0.0
    elif target < 0.0 or target > sets.free * hardness * (1.0 + 1e-13):
        return np.inf, 0.0
    shift = find_shift(trial, sets, target, limits)
    for a in range(sets.free):
        k = active[a]
        trial[k] = min(max(trial[k] + shift, 0.0), hardness)
    restore_load(trial, g, sets, target, limits)
    for a in range(sets.free):
        k = active[a]
        d[k] = trial[k] - p[k]
    return slope_and_longest_step(p, g, approach, sets, hardness, d)


@njit(cache=True)
def find_shift(trial, sets, target, limits):
    """Find the shift [Pa] of the free trial pressures that makes them carry `target` [Pa].

    Their sum within the bounds then equals `target`.

    The sum is a monotone, piecewise linear function of the shift. Newton's method finds it within a
    shrinking bracket.
    """
    active, hardness = sets.active, limits.hardness
    top = min(hardness, target)
    low = np.inf
    high = -np.inf
    for a in range(sets.free):
        v = trial[active[a]]
        low = min(low, -v)
        high = max(high, top - v)
    shift = 0.0 if low < 0.0 < high else 0.5 * (low + high)
    for _ in range(200):
        carried = 0.0
        moving = 0
        for a in range(sets.free):
            v = trial[active[a]] + shift
            carried += min(max(v, 0.0), hardness)
            moving += 0.0 < v < hardness
        error = target - carried
        if abs(error) <= 1e-15 * limits.total or sets.free == 0:
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


@njit(cache=True)
def restore_load(trial, g, sets, target, limits):
    """Spread the load that rounding of the shift has lost over the free nodes.

    Only nodes between the bounds take part.

    The shift is rounded coarsely where the direction is much larger than the pressures. Where no
    node lies between the bounds, the lowest open node takes the missing part, or the highest loaded
    node gives the excess up.
    """
    active, hardness = sets.active, limits.hardness
    for turn in range(64):
        error = target
        moving = 0
        nearest = -1
        for a in range(sets.free):
            k = active[a]
            error -= trial[k]
            if 0.0 < trial[k] < hardness:
                moving += 1
        if abs(error) <= (1e-15 if turn < 4 else 1e-13) * limits.total:
            break
        for a in range(sets.free):
            k = active[a]
            if 0.0 < trial[k] < hardness:
                trial[k] = min(max(trial[k] + error / moving, 0.0), hardness)
            elif moving == 0 and (nearest < 0 or (g[k] < g[nearest]) == (error > 0.0)):
                nearest = k if (trial[k] < hardness if error > 0.0 else trial[k] > 0.0) else nearest
        if nearest >= 0:
            trial[nearest] = min(max(trial[nearest] + error, 0.0), hardness)


@njit(cache=True)
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


@njit(cache=True)
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
