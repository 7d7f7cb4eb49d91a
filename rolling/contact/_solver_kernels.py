"""Compiled passes of the contact solve.

`violation` and `candidates` look at a whole window; the others at its candidates, the nodes that may be in contact, as flat
arrays in the order of `node`. The first `n_free` entries of `active` are free candidates, the next `n_bound` are about to be put
on a bound.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True)
def find_approach(inside, gap_sum, lowest_open, highest_capped):
    """Approach [m] that closes the gaps between the bounds in the mean; with none there it is free over an interval: its middle."""
    if inside:
        return gap_sum / inside
    middle = 0.5 * (lowest_open + highest_capped)
    # Every node is capped, or open ones are not among those looked at.
    return middle if np.isfinite(middle) else highest_capped


@njit(cache=True)
def state_of(p, e, u, cap):
    """Approach [m] and largest deflection [m] of pressures p and deflections u over undeformed gaps e, flat arrays."""
    inside, gap_sum, lowest_open, highest_capped, u_max = 0, 0.0, np.inf, -np.inf, 0.0
    for k in range(p.size):
        g = e[k] + u[k]
        u_max = max(u_max, u[k])
        if p[k] <= 0.0:
            lowest_open = min(lowest_open, g)
        elif p[k] >= cap:
            highest_capped = max(highest_capped, g)
        else:
            gap_sum += g
            inside += 1
    return find_approach(inside, gap_sum, lowest_open, highest_capped), u_max


@njit(cache=True)
def violation(p, e, u, cap, approach):
    """Largest violation of the contact conditions [m]."""
    worst = 0.0
    for k in range(p.size):
        g = e[k] + u[k] - approach
        if p[k] <= 0.0:
            g = -g
        elif p[k] < cap:
            g = abs(g)
        worst = max(worst, g) if g == g else np.inf
    return worst


@njit(cache=True)
def candidates(p, e, u, highest, node):
    """Nodes of a window that are loaded or lie lower than `highest` [m] before the approach is taken off: flat index into `node`.

    Returns their number and their block (first row, last row, first column, last column).
    """
    rows, columns = p.shape
    count = 0
    first_row, last_row, first_column, last_column = rows, -1, columns, -1
    for i in range(rows):
        before = count
        for j in range(columns):
            if p[i, j] > 0.0 or e[i, j] + u[i, j] < highest:
                node[count] = i * columns + j
                count += 1
        if count > before:
            first_row = min(first_row, i)
            last_row = i
            first_column = min(first_column, node[before] - i * columns)
            last_column = max(last_column, node[count - 1] - i * columns)
    return count, first_row, last_row, first_column, last_column


@njit(cache=True)
def places(node, columns, first_row, first_column, padded, bordered, in_padded, in_bordered):
    """Where each candidate stands in the padded array of the transforms and in the residual's grid with its border of one."""
    for a in range(node.size):
        i, j = divmod(node[a], columns)
        i -= first_row
        j -= first_column
        in_padded[a] = i * padded + j
        in_bordered[a] = (i + 1) * bordered + j + 1


@njit(cache=True)
def advance(
    p, g, soft, give, dp, deflection, in_padded, slope, greatest, cap, reach, snap, residual, grid, in_bordered, active
):  # fmt: skip
    """Go along dp as far as the energy falls and the bounds allow, then find approach, violations and who may move.

    g is the gap before the approach is taken off, with soft * p [m] of nodes that give by themselves (empty: none does);
    `deflection` that of dp, in the array of the transforms; `slope` of the energy along dp, 0 for no step at all. `reach` [Pa/m]
    turns a gap into the pressure that closes it on that node alone, `give` is the root of what is left of that on a soft one.
    A loaded node that such a step would carry past a bound goes straight there (two-metric projection, Bertsekas, SIAM J.
    Control Optim. 20(2), 1982): mixed into the conjugate direction it would hold everything else back. Partial steps leave such
    nodes ever closer to their bound but never on it; within `snap` [Pa] of it, which no deflection can tell, they are put there.

    Returns best step length, approach [m], largest violation [m], number of free and of bound nodes.
    """
    best = 1.0
    t = 0.0
    if slope < 0.0:
        curvature = 0.0
        for k in range(p.size):
            curvature += dp[k] * deflection[in_padded[k]]
        for k in range(soft.size):
            curvature += soft[k] * dp[k] * dp[k]
        best = -slope / curvature if curvature > 0.0 else 1.0
        # A long step multiplies the rounding of the load.
        t = min(best, greatest, 100.0)
    nearly = cap * (1.0 - 4e-16)  # a whole step to the cap may miss it by rounding
    inside, gap_sum, lowest_open, highest_capped = 0, 0.0, np.inf, -np.inf
    for k in range(p.size):
        if t > 0.0:
            v = max(p[k] + t * dp[k], 0.0)
            v = v if v < nearly else cap
            g[k] += t * deflection[in_padded[k]]
            if soft.size:
                g[k] += soft[k] * (v - p[k])
            p[k] = v
        if p[k] <= 0.0:
            lowest_open = min(lowest_open, g[k])
        elif p[k] >= cap:
            highest_capped = max(highest_capped, g[k])
        else:
            gap_sum += g[k]
            inside += 1
    approach = find_approach(inside, gap_sum, lowest_open, highest_capped)
    worst = 0.0
    n_free = 0
    n_bound = 0
    for k in range(p.size):
        gap = g[k] - approach
        residual[k] = 0.0
        grid[in_bordered[k]] = 0.0
        if (p[k] <= 0.0 and gap >= 0.0) or (p[k] >= cap and gap <= 0.0):
            continue
        own = give[k] * give[k] if soft.size else 1.0
        step = p[k] - own * reach * gap
        if step <= 0.0 and 0.0 < p[k] <= snap:
            p[k] = 0.0
            continue
        if step >= cap and cap - snap <= p[k] < cap:
            p[k] = cap
            continue
        worst = max(worst, abs(gap))
        if (p[k] > 0.0 and step <= 0.0) or (p[k] < cap and step >= cap):
            n_bound += 1
            active[p.size - n_bound] = k
        else:
            residual[k] = gap
            grid[in_bordered[k]] = gap * give[k] if soft.size else gap
            active[n_free] = k
            n_free += 1
    for i in range(n_bound):
        active[n_free + i] = active[p.size - n_bound + i]  # in this order nothing is overwritten before it is read
    return best, approach, worst, n_free, n_bound


@njit(cache=True)
def precondition(grid, in_bordered, bordered, stencil, give, active, n_free, z):
    """z = short stencil of the inverse half-space times the residual, on the free nodes, less where they give by themselves."""
    for a in range(n_free):
        k = active[a]
        at = in_bordered[k]
        total = 0.0
        for x in range(3):
            row = at + (x - 1) * bordered
            total += stencil[x, 0] * grid[row - 1] + stencil[x, 1] * grid[row] + stencil[x, 2] * grid[row + 1]
        z[k] = total * give[k] if give.size else total


@njit(cache=True)
def aim(
    p, g, give, approach, residual, previous, grid, in_bordered, bordered, stencil, zr_before, length, cap, reach, active,
    n_free, n_bound, total, plainly, z, dp, scale, in_padded, transformed,
):  # fmt: skip
    """The next feasible step dp: preconditioned conjugate gradient (Polak-Ribiere), projected; or, where that does not descend,
    the gradient alone, or (at once if `plainly`) the plain gradient of all nodes. Leaves scale * dp in the array of the transforms.

    `previous` is the residual of the iteration before, dp the step it took, `length` the factor that step should have had.

    Returns slope of the energy along dp (not negative: stuck), greatest step length, z.r, the length left, restarts and plain
    steps (0 or 1 each).
    """
    precondition(grid, in_bordered, bordered, stencil, give, active, n_free, z)
    zr = 0.0
    change = 0.0
    for a in range(n_free):
        k = active[a]
        zr += z[k] * residual[k]
        change += z[k] * (residual[k] - previous[k])
    beta = max(0.0, change / zr_before) if zr_before > 0.0 else 0.0
    restarts = 0
    plain = 0
    if beta == 0.0:
        length = 1.0
    for a in range(n_free):
        k = active[a]
        z[k] = beta / length * dp[k] - z[k]
    slope, greatest = project(p, g, approach, z, length, cap, active, n_free, n_bound, total, dp)
    if not slope < 0.0 and beta > 0.0:
        restarts = 1
        length = 1.0
        precondition(grid, in_bordered, bordered, stencil, give, active, n_free, z)
        slope, greatest = project(p, g, approach, z, -1.0, cap, active, n_free, n_bound, total, dp)
    if plainly or not slope < 0.0:
        # The plain projected gradient, of all nodes, always descends, short of a solution.
        plain = 1
        length = 1.0
        zr = 0.0
        for k in range(p.size):
            active[k] = k
            z[k] = -reach * (g[k] - approach)  # the same factor for all: only so does the projection descend
        slope, greatest = project(p, g, approach, z, 1.0, cap, active, p.size, 0, total, dp)
    for k in range(p.size):
        transformed[in_padded[k]] = scale * dp[k]
    return slope, greatest, zr, length, restarts, plain


@njit(cache=True)
def extrapolate(p, trend, g, cap, total, active, z, dp, q):
    """q = p + trend, put within the bounds; what is then between them is shifted to carry the load. Whether it can."""
    n_free = 0
    for k in range(p.size):
        q[k] = min(max(p[k] + trend[k], 0.0), cap)
        z[k] = 0.0
        if 0.0 < q[k] < cap:
            active[n_free] = k
            n_free += 1
    slope, _ = project(q, g, 0.0, z, 0.0, cap, active, n_free, 0, total, dp)
    for k in range(p.size):
        q[k] += dp[k]
    return slope < np.inf


@njit(cache=True)
def step_by_way_of(q, p, g, cap, dp, scale, in_padded, transformed):
    """The step dp from q made one from p: its slope there, its greatest share within the bounds; scale * dp to be transformed."""
    slope = 0.0
    greatest = np.inf
    for k in range(p.size):
        dp[k] = min(max(q[k] + dp[k], 0.0), cap) - p[k]
        transformed[in_padded[k]] = scale * dp[k]
        slope += g[k] * dp[k]  # the approach has no part in it: dp carries no load
        if dp[k] < 0.0:
            greatest = min(greatest, -p[k] / dp[k])
        elif dp[k] > 0.0:
            greatest = min(greatest, (cap - p[k]) / dp[k])
    return slope, max(greatest, 1.0)


@njit(cache=True)
def settle_load(p, g, cap, total, trace):
    """Give what is missing of the load to the lowest open nodes, or take what is too much from the highest loaded ones.

    Nodes within `trace` [Pa] of a bound are put on it first: they may stand on the wrong node.
    """
    missing = total
    for k in range(p.size):
        if p[k] <= trace:
            p[k] = 0.0
        elif p[k] >= cap - trace:
            p[k] = cap
        missing -= p[k]
    for _ in range(p.size):
        if abs(missing) <= 1e-16 * total:
            return
        best = -1
        for k in range(p.size):
            may = p[k] < cap if missing > 0.0 else p[k] > 0.0
            if may and (best < 0 or (g[k] < g[best]) == (missing > 0.0)):
                best = k
        if best < 0:
            return
        change = min(max(p[best] + missing, 0.0), cap) - p[best]
        p[best] += change
        missing -= change


@njit(cache=True)
def project(p, g, approach, direction, length, cap, active, n_free, n_bound, total, dp):
    """dp to the feasible pressure nearest to p + length * direction: free nodes shifted and clipped, bound nodes on their bound.

    The sum of pressures is restored to `total` exactly by one shift of the free nodes, the root of a monotone piecewise linear
    function. `direction` becomes the trial pressure, on the free nodes.

    Returns (slope of the energy along dp [Pa m], greatest share t of dp that stays within the bounds), or (inf, 0) when the
    free nodes cannot take up the load.
    """
    trial = direction
    target = total
    for k in range(p.size):
        target -= p[k]
        dp[k] = 0.0
    for a in range(n_free + n_bound):
        target += p[active[a]]
    for a in range(n_free, n_free + n_bound):
        k = active[a]
        dp[k] = (0.0 if g[k] > approach else cap) - p[k]
        target -= dp[k] + p[k]
    if n_free == 0:
        if abs(target) > 1e-13 * total:
            return np.inf, 0.0
    elif target < 0.0 or target > n_free * cap * (1.0 + 1e-13):
        return np.inf, 0.0
    top = min(cap, target)
    low = np.inf
    high = -np.inf
    for a in range(n_free):
        k = active[a]
        v = p[k] + length * direction[k]
        trial[k] = v
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
    # Where the direction dwarfs the pressures the shift is rounded coarsely; what is left is spread over those between bounds, or,
    # where there are none, goes to the lowest open node or from the highest loaded one.
    for turn in range(64):
        error = target
        moving = 0
        nearest = -1
        for a in range(n_free):
            k = active[a]
            error -= trial[k]
            if 0.0 < trial[k] < cap:
                moving += 1
        if abs(error) <= (1e-15 if turn < 4 else 1e-13) * total:
            break
        for a in range(n_free):
            k = active[a]
            if 0.0 < trial[k] < cap:
                trial[k] = min(max(trial[k] + error / moving, 0.0), cap)
            elif moving == 0 and (nearest < 0 or (g[k] < g[nearest]) == (error > 0.0)):
                nearest = k if (trial[k] < cap if error > 0.0 else trial[k] > 0.0) else nearest
        if nearest >= 0:
            trial[nearest] = min(max(trial[nearest] + error, 0.0), cap)
    for a in range(n_free):
        k = active[a]
        dp[k] = trial[k] - p[k]
    slope = 0.0
    greatest = np.inf
    for a in range(n_free + n_bound):
        k = active[a]
        slope += (g[k] - approach) * dp[k]
        if dp[k] < 0.0:
            greatest = min(greatest, -p[k] / dp[k])
        elif dp[k] > 0.0:
            greatest = min(greatest, (cap - p[k]) / dp[k])
    return slope, max(greatest, 1.0)
