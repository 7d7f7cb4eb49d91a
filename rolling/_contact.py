"""Compiled passes of the contact solve; arrays are flat views of a window, `active` lists the nodes that may move.

The first `n_free` entries of `active` are free nodes, the next `n_bound` are nodes about to be put on a bound.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def update_and_sort(p, u, trial, du, t, e, cap, reach, snap, residual, free, active):
    """Go the share t of the way to `trial`, then find approach, violations and who may move.

    `reach` [Pa/m] turns a gap into the pressure it would take on that node alone to close it. A loaded node that such a step
    would carry past a bound goes straight there (two-metric projection, Bertsekas, SIAM J. Control Optim. 20(2), 1982): mixed
    into the conjugate direction it would hold everything else back. Partial steps leave such nodes ever closer to their bound but
    never on it; within `snap` [Pa] of it, which no deflection can tell, they are put there.

    Returns approach [m], largest violation [m], largest deflection [m], number of free and of bound nodes.
    """
    inside = 0
    gap_sum = 0.0
    lowest_open = np.inf
    highest_capped = -np.inf
    u_max = 0.0
    for k in range(p.size):
        if t == 1.0:
            p[k] = trial[k]
            u[k] += du[k]
        elif t > 0.0:
            p[k] = min(max(p[k] + t * (trial[k] - p[k]), 0.0), cap)
            u[k] += t * du[k]
        g = e[k] + u[k]
        if u[k] > u_max:
            u_max = u[k]
        if p[k] <= 0.0:
            if g < lowest_open:
                lowest_open = g
        elif p[k] >= cap:
            if g > highest_capped:
                highest_capped = g
        else:
            gap_sum += g
            inside += 1
    # With nothing between the bounds the approach is free over an interval: its middle.
    approach = gap_sum / inside if inside else 0.5 * (lowest_open + highest_capped)
    if not np.isfinite(approach):  # every node of the window is capped
        approach = highest_capped
    worst = 0.0
    n_free = 0
    n_bound = 0
    for k in range(p.size):
        g = e[k] + u[k] - approach
        free[k] = False
        residual[k] = 0.0
        if (p[k] <= 0.0 and g >= 0.0) or (p[k] >= cap and g <= 0.0):
            continue
        step = p[k] - reach * g
        if step <= 0.0 and 0.0 < p[k] <= snap:
            p[k] = 0.0
            continue
        if step >= cap and cap - snap <= p[k] < cap:
            p[k] = cap
            continue
        worst = max(worst, abs(g))
        if (p[k] > 0.0 and step <= 0.0) or (p[k] < cap and step >= cap):
            n_bound += 1
            active[p.size - n_bound] = k
        else:
            free[k] = True
            residual[k] = g
            active[n_free] = k
            n_free += 1
    for i in range(n_bound):
        active[n_free + i] = active[p.size - n_bound + i]  # in this order nothing is overwritten before it is read
    return approach, worst, u_max, n_free, n_bound


@njit(cache=True)
def precondition(residual, free, active, n_free, columns, stencil, z):
    """z = short stencil of the inverse half-space on the free nodes; z is by entry of `active`, residual and free by node."""
    half = stencil.shape[0] // 2
    rows = residual.size // columns
    for a in range(n_free):
        i, j = divmod(active[a], columns)
        total = 0.0
        for x in range(max(0, i - half), min(rows, i + half + 1)):
            for y in range(max(0, j - half), min(columns, j + half + 1)):
                if free[x * columns + y]:
                    total += stencil[x - i + half, y - j + half] * residual[x * columns + y]
        z[a] = total


@njit(cache=True)
def conjugate(z, residual, previous_residual, active, n_free):
    """Sums z.r and z.(r - previous r) over the free nodes, for the Polak-Ribiere factor."""
    zr = 0.0
    change = 0.0
    for a in range(n_free):
        k = active[a]
        zr += z[a] * residual[k]
        change += z[a] * (residual[k] - previous_residual[k])
    return zr, change


@njit(cache=True)
def project(p, gap, approach, u, direction, length, cap, active, n_free, n_bound, total, trial, dp):
    """trial = feasible pressure nearest to p + length * direction: free nodes shifted and clipped, bound nodes on their bound.

    `gap` is the undeformed gap. The sum of pressures is restored to `total` exactly by one shift of the free nodes, the root of
    a monotone piecewise linear function. dp = trial - p.

    Returns (slope of the energy along dp [Pa m], greatest share t of dp that stays within the bounds), or (inf, 0) when the
    free nodes cannot take up the load.
    """
    trial[:] = p
    dp[:] = 0.0
    target = total
    for k in range(p.size):
        target -= p[k]
    for a in range(n_free + n_bound):
        k = active[a]
        target += p[k]
    for a in range(n_free, n_free + n_bound):
        k = active[a]
        trial[k] = 0.0 if gap[k] + u[k] > approach else cap
        target -= trial[k]
    if n_free == 0:
        if abs(target) > 1e-13 * total:
            return np.inf, 0.0
    elif target < 0.0 or target > n_free * cap:
        return np.inf, 0.0
    top = min(cap, target)
    low = np.inf
    high = -np.inf
    for a in range(n_free):
        v = p[active[a]] + length * direction[a]
        trial[active[a]] = v
        low = min(low, -v)
        high = max(high, top - v)
    shift = 0.0 if low < 0.0 < high else 0.5 * (low + high)
    for _ in range(200):
        got = 0.0
        moving = 0
        for a in range(n_free):
            v = trial[active[a]] + shift
            if v >= cap:
                got += cap
            elif v > 0.0:
                got += v
                moving += 1
        error = target - got
        if abs(error) <= 1e-15 * total or n_free == 0:
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
    for a in range(n_free):
        k = active[a]
        trial[k] = min(max(trial[k] + shift, 0.0), cap)
    # Where the direction dwarfs the pressures the shift is rounded coarsely; what is left is spread over those between bounds.
    for _ in range(4):
        error = target
        moving = 0
        for a in range(n_free):
            v = trial[active[a]]
            error -= v
            if 0.0 < v < cap:
                moving += 1
        if moving == 0 or abs(error) <= 1e-15 * total:
            break
        for a in range(n_free):
            k = active[a]
            if 0.0 < trial[k] < cap:
                trial[k] = min(max(trial[k] + error / moving, 0.0), cap)
    slope = 0.0
    greatest = np.inf
    for a in range(n_free + n_bound):
        k = active[a]
        dp[k] = trial[k] - p[k]
        slope += (gap[k] + u[k] - approach) * dp[k]
        if dp[k] < 0.0:
            greatest = min(greatest, -p[k] / dp[k])
        elif dp[k] > 0.0:
            greatest = min(greatest, (cap - p[k]) / dp[k])
    return slope, max(greatest, 1.0)


@njit(cache=True)
def dot(a, b):
    total = 0.0
    for k in range(a.size):
        total += a[k] * b[k]
    return total
