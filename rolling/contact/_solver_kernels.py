"""Compiled passes of the contact solve: conjugate gradients in the notation of the textbooks.

r is the residual, the gap left open or overlapped on a free node [m]; z the preconditioned residual, d the direction, both [Pa];
alpha and beta are the step length and the factor of the last direction. `violation` and `candidates` look at a whole window; all
others at its candidates, the nodes that may be in contact, as flat arrays.

`iterate`, `lead` and `carry_load` are called from Python and take a System packed as plain tuples: numba unpickles the class of
each named tuple that crosses the boundary, which takes 1 us or more, and plain ones cross as fast as arguments do.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rolling.contact._projection import Limits, Sets, extrapolate, project, step_by_way_of

Array = NDArray[np.float64]
Indices = NDArray[np.uint32]

LEAST_STEP = 1e-3  # after a step length alpha below it the direction is dropped: nodes put on a bound point the wrong way


class Nodes(NamedTuple):
    """The candidates of a descent, flat arrays of equal length; the last two are empty where no node is compliant by itself.

    Parameters
    ----------
    p : pressure, Pa.
    g : gap before the approach is taken off, m.
    compliance : closing of a node's gap by its own pressure beside the deflection, m/Pa.
    softening : square root of the share of a node's stiffness that its compliance leaves.
    """

    p: Array
    g: Array
    compliance: Array
    softening: Array


class Transform(NamedTuple):
    """The array of the transforms: the direction goes in, its deflection comes out.

    Parameters
    ----------
    image : flat array, Pa times `unit` before the convolution, m after it.
    node : index of each candidate in `image`.
    unit : float, m/Pa. Deflection per pressure and coefficient.
    """

    image: NDArray[np.floating]
    node: Indices
    unit: float


class Stencil(NamedTuple):
    """The preconditioner, a short stencil of the inverse half-space, and the grid it acts on.

    Parameters
    ----------
    values : (3, 3) stencil, Pa/m.
    grid : flat array, m. Residual on the block of the candidates with a border of one open node.
    node : index of each candidate in `grid`.
    row_length : int. Nodes in a row of `grid`.
    stiffness : float, Pa/m. Pressure on one node alone that opens its gap by a metre.
    """

    values: Array
    grid: Array
    node: Indices
    row_length: int
    stiffness: float


class Work(NamedTuple):
    """Vectors that the passes overwrite, one entry per candidate.

    Parameters
    ----------
    trial : preconditioned residual, then trial pressure, Pa.
    d : direction, Pa.
    r, r_before : residual of this iteration and of the one before, m.
    active : indices of candidates (see Sets).
    """

    trial: Array
    d: Array
    r: Array
    r_before: Array
    active: Indices


class System(NamedTuple):
    """One descent: its candidates and all that stays where it is in memory."""

    nodes: Nodes
    transform: Transform
    stencil: Stencil
    work: Work
    limits: Limits


def pack(system: System) -> tuple[tuple[Any, ...], ...]:
    """Make a System plain tuples, to be handed to compiled code."""
    return tuple(tuple(part) for part in system)


@njit(cache=True)
def unpack(packed):
    """Make the System again from its plain tuples."""
    nodes, transform, stencil, work, limits = packed
    return System(Nodes(*nodes), Transform(*transform), Stencil(*stencil), Work(*work), Limits(*limits))


class Direction(NamedTuple):
    """The numbers that belong to a direction d.

    Parameters
    ----------
    slope : float, Pa m. Slope of the energy along d; not negative: no direction descends.
    longest : float. Longest step length within the bounds, at least 1.
    zr : float, Pa m. Product z.r, 0 where the next direction forgets this one.
    length : float. Step length that the unprojected direction had so far, for the next beta.
    """

    slope: float
    longest: float
    zr: float
    length: float


class Step(NamedTuple):
    """The state after a step.

    Parameters
    ----------
    approach : float, m.
    worst : float, m. Maximum violation of the contact conditions.
    free, bound : int. Numbers of candidates that may move freely and that are about to be put on a bound.
    restarts, plain_steps : int. Whether the next direction is a restart or a plain gradient, 0 or 1.
    """

    approach: float
    worst: float
    free: int
    bound: int
    restarts: int
    plain_steps: int


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
def line_search(system, direction):
    """Return the step length alpha at which the energy along d is least; 1 where its curvature is not positive."""
    d, image, node, compliance = system.work.d, system.transform.image, system.transform.node, system.nodes.compliance
    curvature = 0.0
    for k in range(d.size):
        curvature += d[k] * image[node[k]]
    for k in range(compliance.size):
        curvature += compliance[k] * d[k] * d[k]
    return -direction.slope / curvature if curvature > 0.0 else 1.0


@njit(cache=True)
def take_step(system, length):
    """Add `length` times the direction to the pressures, within the bounds, and its deflection to the gaps."""
    p, g, compliance, d = system.nodes.p, system.nodes.g, system.nodes.compliance, system.work.d
    image, node, hardness = system.transform.image, system.transform.node, system.limits.hardness
    nearly = hardness * (1.0 - 4e-16)  # a whole step to the hardness may miss it by rounding
    for k in range(p.size):
        v = max(p[k] + length * d[k], 0.0)
        v = v if v < nearly else hardness
        g[k] += length * image[node[k]]
        if compliance.size:
            g[k] += compliance[k] * (v - p[k])
        p[k] = v


@njit(cache=True)
def approach_of(p, g, hardness):
    """Approach [m] of pressures p over deformed gaps g, flat arrays."""
    inside, gap_sum, lowest_open, highest_capped = 0, 0.0, np.inf, -np.inf
    for k in range(p.size):
        if p[k] <= 0.0:
            lowest_open = min(lowest_open, g[k])
        elif p[k] >= hardness:
            highest_capped = max(highest_capped, g[k])
        else:
            gap_sum += g[k]
            inside += 1
    return find_approach(inside, gap_sum, lowest_open, highest_capped)


@njit(cache=True)
def find_residual(nodes, stencil, work, hardness, approach, snap):
    """Find the residual r and the nodes that may move; return the maximum violation [m] and the numbers of free and bound nodes.

    A loaded node that closing its own gap would carry past a bound goes straight there (two-metric projection, Bertsekas, SIAM
    J. Control Optim. 20(2), 1982): mixed into the conjugate direction it would hold all other nodes back. Partial steps leave
    such nodes ever closer to their bound but never on it; within `snap` [Pa], too little to change a deflection, they are put
    there.
    """
    p, g, softening = nodes.p, nodes.g, nodes.softening
    grid, place, stiffness = stencil.grid, stencil.node, stencil.stiffness
    r, active = work.r, work.active
    worst = 0.0
    free = 0
    bound = 0
    for k in range(p.size):
        gap = g[k] - approach
        r[k] = 0.0
        grid[place[k]] = 0.0
        if (p[k] <= 0.0 and gap >= 0.0) or (p[k] >= hardness and gap <= 0.0):
            continue
        own = softening[k] * softening[k] if softening.size else 1.0
        closing = p[k] - own * stiffness * gap
        if closing <= 0.0 and 0.0 < p[k] <= snap:
            p[k] = 0.0
            continue
        if closing >= hardness and hardness - snap <= p[k] < hardness:
            p[k] = hardness
            continue
        worst = max(worst, abs(gap))
        if (p[k] > 0.0 and closing <= 0.0) or (p[k] < hardness and closing >= hardness):
            bound += 1
            active[p.size - bound] = k
        else:
            r[k] = gap
            grid[place[k]] = gap * softening[k] if softening.size else gap
            active[free] = k
            free += 1
    for i in range(bound):
        active[free + i] = active[p.size - bound + i]  # in this order nothing is overwritten before it is read
    return worst, free, bound


@njit(cache=True)
def precondition(stencil, softening, work, free):
    """Set z to the short stencil of the inverse half-space times the residual, on the free nodes."""
    values, grid, place, row_length = stencil.values, stencil.grid, stencil.node, stencil.row_length
    active, z = work.active, work.trial
    for a in range(free):
        k = active[a]
        at = place[k]
        total = 0.0
        for x in range(3):
            row = at + (x - 1) * row_length
            total += values[x, 0] * grid[row - 1] + values[x, 1] * grid[row] + values[x, 2] * grid[row + 1]
        z[k] = total * softening[k] if softening.size else total


@njit(cache=True)
def find_direction(nodes, stencil, work, limits, approach, free, bound, direction, plain):
    """Find the next feasible direction d: preconditioned conjugate gradient (Polak-Ribiere), projected.

    Where it does not descend, d is the projected preconditioned gradient (a restart), and where that does not descend or if
    `plain`, the projected gradient of all nodes. r and d hold the residual and, before, the direction of the last iteration.

    Returns the Direction and the numbers of restarts and of plain gradient steps (0 or 1 each).
    """
    p, g, active, r, r_before, d = nodes.p, nodes.g, work.active, work.r, work.r_before, work.d
    z = trial = work.trial
    sets = Sets(active, free, bound)
    length = direction.length
    precondition(stencil, nodes.softening, work, free)
    zr = 0.0
    change = 0.0
    for a in range(free):
        k = active[a]
        zr += z[k] * r[k]
        change += z[k] * (r[k] - r_before[k])
    beta = max(0.0, change / direction.zr) if direction.zr > 0.0 else 0.0
    restarts = 0
    plain_steps = 0
    if beta == 0.0:
        length = 1.0
    for a in range(free):
        k = active[a]
        trial[k] = p[k] + length * (beta / length * d[k] - z[k])
    slope, longest = project(p, g, approach, trial, sets, limits, d)
    if not slope < 0.0 and beta > 0.0:
        restarts = 1
        length = 1.0
        precondition(stencil, nodes.softening, work, free)
        for a in range(free):
            k = active[a]
            trial[k] = p[k] - z[k]
        slope, longest = project(p, g, approach, trial, sets, limits, d)
    if plain or not slope < 0.0:
        # The projected gradient of all nodes always descends, short of a solution.
        plain_steps = 1
        length = 1.0
        zr = 0.0
        for k in range(p.size):
            active[k] = k
            # The factor is the same for all nodes: only so does the projection descend.
            trial[k] = p[k] - stencil.stiffness * (g[k] - approach)
        slope, longest = project(p, g, approach, trial, Sets(active, p.size, 0), limits, d)
    r_before[:] = r
    return Direction(slope, longest, zr, length), restarts, plain_steps


@njit(cache=True)
def scatter(transform, d):
    """Write the direction into the array of the transforms, in units that make its image a deflection."""
    transform.image[:] = 0.0
    for k in range(d.size):
        transform.image[transform.node[k]] = transform.unit * d[k]


@njit(cache=True)
def iterate(packed, direction, snap, allowed):
    """Step along the direction and, unless the violation is within `allowed` [m], find the next direction.

    The deflection by the direction must be known. Nodes within `snap` [Pa] of a bound that they move to are put there.

    Returns the fields of the Step taken and of the Direction to convolve, which after a converged step is the one given.
    """
    system, direction = unpack(packed), Direction(*direction)
    nodes, limits = system.nodes, system.limits
    alpha = 1.0
    if direction.slope < 0.0:
        alpha = line_search(system, direction)
        # A long step multiplies the rounding of the load.
        take_step(system, min(alpha, direction.longest, 100.0))
    approach = approach_of(nodes.p, nodes.g, limits.hardness)
    worst, free, bound = find_residual(nodes, system.stencil, system.work, limits.hardness, approach, snap)
    restarts = 0
    plain_steps = 0
    if worst > allowed:
        length = direction.length * min(max(alpha, 0.5), 2.0)
        last = Direction(direction.slope, direction.longest, direction.zr, length)
        plain = alpha < LEAST_STEP
        direction, restarts, plain_steps = find_direction(
            nodes, system.stencil, system.work, limits, approach, free, bound, last, plain
        )
        scatter(system.transform, system.work.d)
    following = direction.slope, direction.longest, direction.zr, direction.length
    return (approach, worst, free, bound, restarts, plain_steps), following


@njit(cache=True)
def lead(packed, p_trend, u_trend):
    """Find a first direction by way of the extrapolation q of the last solutions and of the gradient at q.

    The deflection at q is known but for the part that the bounds cut off. The step starts from the exact pressures, with an
    exact line search, so that this does no harm.

    Returns the fields of the Direction; its slope is 0 where none descends.
    """
    system = unpack(packed)
    nodes, limits, work = system.nodes, system.limits, system.work
    q = np.empty_like(nodes.p)
    h = nodes.g + u_trend
    for k in range(nodes.compliance.size):
        h[k] += nodes.compliance[k] * p_trend[k]
    if extrapolate(nodes.p, p_trend, nodes.g, limits, work, q):
        at_q = Nodes(q, h, nodes.compliance, nodes.softening)
        approach = approach_of(q, h, limits.hardness)
        _, free, bound = find_residual(at_q, system.stencil, work, limits.hardness, approach, 0.0)
        first = Direction(0.0, 0.0, 0.0, 1.0)
        direction, _, _ = find_direction(at_q, system.stencil, work, limits, approach, free, bound, first, False)
        if direction.slope < 0.0:
            slope, longest = step_by_way_of(q, nodes.p, nodes.g, limits.hardness, work.d)
            if slope < 0.0:
                scatter(system.transform, work.d)
                return slope, longest, 0.0, 1.0
    work.d[:] = 0.0
    return 0.0, 0.0, 0.0, 1.0


@njit(cache=True)
def carry_load(packed, approach, free):
    """Shift the free nodes so that the pressures carry the load exactly."""
    nodes, _, _, work, limits = unpack(packed)
    work.trial[:] = nodes.p
    project(nodes.p, nodes.g, approach, work.trial, Sets(work.active, free, 0), limits, work.d)
    nodes.p[:] += work.d
