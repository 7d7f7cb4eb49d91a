"""Compiled passes of the contact solve: conjugate gradients in the notation of textbooks.

r is the residual, the remaining gap or overlap on a free node [m]; z is the preconditioned residual
and d the direction, both [Pa]; alpha and beta are the step length and the factor of the last
direction. All passes read the candidates of a window, the nodes that may be in contact, as flat
arrays.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import types

from rolling.contact._candidate_kernels import follow_field, move_edges
from rolling.contact._condition_kernels import approach_of, project, sum_of, worst_and_load
from rolling.contact._far_field import restrict
from rolling.contact._kinds import (
    DIRECTION,
    FLAG,
    NUMBER,
    RULES,
    SOLUTIONS,
    STEP,
    SYSTEM,
    WHOLE,
)
from rolling.contact._linked import linked
from rolling.contact._model_kernels import (
    EDGES_LEAD,
    extrapolate_model,
    fill,
    follow_model,
    lead_model,
)
from rolling.contact._system import Direction, Sets, Step
from rolling.contact._window_kernels import copy_line
from rolling.contact.compiling import inlined, njit

# After a step length alpha below it the direction is dropped, because nodes that were put on a
# bound point the wrong way.
MIN_STEP = 1e-3
# Edges that would move by less than this share of the allowed violation stay.
EDGE_SLACK = 0.01
# Share of the model's change that the second direction takes, and the minimum share. Each step
# corrects the share by its own length. A first share of 1 takes up to a convolution more.
FIRST_LENGTH = 0.5
SHORTEST = 0.2
# Limits of the share of the preconditioned residual that a direction takes without the model. The
# share follows the step lengths, across restarts too: where compliances differ by orders of
# magnitude, or many nodes go to a bound, whole directions overshoot again and again.
SHARES = 0.1, 1.0


@inlined(fused=True)
def curvature_along(d, image, node, compliance):
    """Return the curvature of the energy along d, whose deflection is in the image [Pa m]."""
    curvature = 0.0
    for k in range(d.size):
        curvature += d[k] * image[node[k]]
    for k in range(compliance.size):
        curvature += compliance[k] * d[k] * d[k]
    return curvature


@inlined()
def line_search(system, direction):
    """Return the step length alpha that minimizes the energy along d.

    It is 1 where the curvature is not positive.
    """
    transform = system.transform
    curvature = curvature_along(
        system.work.d, transform.image, transform.node, system.nodes.compliance
    )
    return -direction.slope / curvature if curvature > 0.0 else 1.0


@inlined()
def take_step(system, length):
    """Add `length` times the direction to the pressures, and its deflection to the gaps.

    The pressures stay within the bounds.
    """
    p = system.nodes.p
    g = system.nodes.g
    compliance = system.nodes.compliance
    d = system.work.d
    image = system.transform.image
    node = system.transform.node
    hardness = system.limits.hardness
    nearly = hardness * (1.0 - 4e-16)  # a whole step to the hardness may miss it by rounding
    for k in range(p.size):
        v = max(p[k] + length * d[k], 0.0)
        v = v if v < nearly else hardness
        g[k] += length * image[node[k]]
        if compliance.size:
            g[k] += compliance[k] * (v - p[k])
        p[k] = v


@inlined()
def find_residual(nodes, stencil, work, hardness, approach, snap):
    """Find the residual r and the nodes that may move.

    Returns the maximum violation [m] and the numbers of free and of bound nodes.

    A loaded node goes straight to a bound if closing its own gap would carry it past that bound
    (two-metric projection, Bertsekas, SIAM J. Control Optim. 20(2), 1982). In the conjugate
    direction it would hold all other nodes back. Partial steps bring such nodes ever closer to
    their bound but never onto it; within `snap` [Pa], too little to change a deflection, they are
    put there.
    """
    p = nodes.p
    g = nodes.g
    compliance = nodes.compliance
    softening = nodes.softening
    grid = stencil.grid
    place = stencil.node
    stiffness = stencil.stiffness
    r = work.r
    active = work.active
    grid[:] = 0.0
    worst = 0.0
    free = 0
    bound = 0
    for k in range(p.size):
        gap = g[k] - approach
        r[k] = 0.0
        if (p[k] <= 0.0 and gap >= 0.0) or (p[k] >= hardness and gap <= 0.0):
            continue
        own = 1.0
        if compliance.size:
            own = 1.0 / (1.0 + compliance[k] * stiffness)
            softening[k] = np.sqrt(own)
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
        # This order reads each entry before it is overwritten.
        active[free + i] = active[p.size - bound + i]
    return worst, free, bound


@inlined()
def precondition(stencil, softening, work, free):
    """Set z to the inverse stencil of the half-space times the residual on the free nodes."""
    values = stencil.values
    grid = stencil.grid
    place = stencil.node
    row_length = stencil.row_length
    active = work.active
    z = work.trial
    for a in range(free):
        k = active[a]
        at = np.int64(place[k])  # unsigned numbers refuse the minus of the row before
        total = 0.0
        for x in range(3):
            row = at + (x - 1) * row_length
            total += (
                values[x, 0] * grid[row - 1]
                + values[x, 1] * grid[row]
                + values[x, 2] * grid[row + 1]
            )
        z[k] = total * softening[k] if softening.size else total


@linked(
    types.Tuple((DIRECTION, WHOLE, WHOLE))(SYSTEM, NUMBER, WHOLE, WHOLE, DIRECTION, FLAG),
    calls=(project,),
)
def find_direction(system, approach, free, bound, direction, plain):
    """Find the next feasible direction d by preconditioned, projected conjugate gradients.

    The factor beta follows Polak and Ribiere.

    Where it does not descend, d is the projected preconditioned gradient (a restart). Where that
    does not descend either, or if `plain`, d is the projected gradient of all nodes. On entry r and
    d hold the residual and the direction of the last iteration.

    Returns the Direction and the numbers of restarts and of plain gradient steps (0 or 1 each).
    """
    nodes = system.nodes
    stencil = system.stencil
    work = system.work
    limits = system.limits
    p = nodes.p
    g = nodes.g
    d = work.d
    active = work.active
    r = work.r
    r_before = work.r_before
    trial = work.trial
    z = trial  # until the trial pressures replace it, node by node
    sets = Sets(active, free, bound)
    length = direction.length
    precondition(stencil, nodes.softening, work, free)
    zr = 0.0
    change = 0.0
    for a in range(free, free + bound):
        k = active[a]
        trial[k] = 0.0 if g[k] > approach else limits.hardness
    for a in range(free):
        k = active[a]
        zr += z[k] * r[k]
        change += z[k] * (r[k] - r_before[k])
    beta = max(0.0, change / direction.zr) if direction.zr > 0.0 else 0.0
    restarts = 0
    plain_steps = 0
    for a in range(free):
        k = active[a]
        trial[k] = p[k] + beta * d[k] - length * z[k]
    slope, longest = project(p, g, approach, trial, sets, limits, d)
    if not slope < 0.0 and beta > 0.0:
        restarts = 1
        precondition(stencil, nodes.softening, work, free)
        for a in range(free):
            k = active[a]
            trial[k] = p[k] - length * z[k]
        slope, longest = project(p, g, approach, trial, sets, limits, d)
    if plain or not slope < 0.0:
        # The projected gradient of all nodes always descends, short of a solution.
        plain_steps = 1
        zr = 0.0
        for k in range(p.size):
            active[k] = k
            # The projection descends only if the factor is the same for all nodes.
            trial[k] = p[k] - length * stencil.stiffness * (g[k] - approach)
        slope, longest = project(p, g, approach, trial, Sets(active, p.size, 0), limits, d)
    copy_line(r, r_before)
    return Direction(slope, longest, zr, length), restarts, plain_steps


@njit(cache=True)
def step_along(system, direction, nearly):
    """Step along the direction as far as the energy falls; return the step length alpha.

    A step longer than `nearly` becomes whole, so that nodes on their way to a bound arrive.
    """
    alpha = line_search(system, direction)
    if nearly < alpha < 1.0:
        alpha = 1.0
    # A long step multiplies the rounding of the load.
    take_step(system, min(alpha, direction.longest, 100.0))
    return alpha


@inlined()
def take_whole_step(p, d, hardness):
    """Add the direction to the pressures within the bounds; return their sum."""
    for k in range(d.size):
        p[k] = min(max(p[k] + d[k], 0.0), hardness)
    return sum_of(p)


@linked(
    types.Tuple((STEP, DIRECTION))(SYSTEM, DIRECTION, SOLUTIONS, RULES),
    calls=(
        follow_field,
        approach_of,
        worst_and_load,
        extrapolate_model,
        restrict,
        follow_model,
        find_direction,
    ),
)
def iterate(system, direction, solutions, rules):
    """Step along the direction, and find the next direction unless converged.

    The step has converged if the violation is within the allowed one of the Rules.

    The deflection by the direction must be known. The model, settled by so many sweeps, gives the
    next direction. Without sweeps, or where the model has none that descends, the preconditioned
    residual gives it. A last step by the model, after a converged step, needs no convolution
    before the final check; the Direction is then unchanged.

    The first direction of a solve comes from the extrapolation of the last two `solutions`, whose
    arrays are otherwise empty. No step leads to it, and its slope is not negative where it does not
    descend.

    Returns the Step that was taken and the Direction to convolve. The load of the
    Step is the sum of the pressures after a last step by the model, or 0.
    """
    nodes = system.nodes
    limits = system.limits
    work = system.work
    model = system.model
    allowed = rules.allowed
    sweeps = rules.sweeps
    leading = solutions.p.size > 0
    alpha = step_along(system, direction, rules.nearly_whole) if direction.slope < 0.0 else 1.0
    lift = move_edges(system, EDGE_SLACK * allowed) if rules.edges_move else 0.0
    approach = approach_of(nodes.p, nodes.g, limits.hardness)
    length = direction.length * min(max(alpha, 0.5), 2.0)
    plain = alpha < MIN_STEP
    if sweeps and not plain:
        worst, load = fill(model, nodes, limits.hardness, approach)
        # Nodes that jumped to a bound left their load to the direction.
        worst += model.lift * abs(limits.total - load)
        length = min(max(length, SHORTEST), 1.0)
        edges_lead = lift > EDGES_LEAD * worst
        ends = worst <= allowed and not leading
        if ends and not rules.finishing:
            return Step(approach, worst, 0, 0, 0, 0.0), direction
        if leading:
            approach = lead_model(system, approach, solutions)
            length = 1.0
            edges_lead = nodes.compliance.size > 0
        else:
            system.far.known[:] = 0.0
        last = Direction(direction.slope, direction.longest, direction.zr, length)
        following, free, bound, restarts = follow_model(
            system, approach, last, sweeps, edges_lead, not (ends or leading)
        )
        descends = following.slope < 0.0
        if ends:
            load = take_whole_step(nodes.p, work.d, limits.hardness) if descends else 0.0
            return Step(approach, worst, bound, restarts, 0, load), last
        if leading:
            following = Direction(following.slope, following.longest, 0.0, direction.length)
        if descends or leading:
            return Step(approach, worst, bound, restarts, 0, 0.0), following
        length = 1.0
        direction = Direction(0.0, 0.0, 0.0, length)
    worst, free, bound = find_residual(
        nodes, system.stencil, work, limits.hardness, approach, rules.snap
    )
    restarts = 0
    plain_steps = 0
    if worst > allowed:
        length = min(max(length, SHARES[0]), SHARES[1])
        last = Direction(direction.slope, direction.longest, direction.zr, length)
        direction, restarts, plain_steps = find_direction(
            system, approach, free, bound, last, plain
        )
    return Step(approach, worst, bound, restarts, plain_steps, 0.0), direction


@inlined()
def list_inside(p, hardness, active):
    """List the nodes between the bounds in `active`; return their number."""
    free = 0
    for k in range(p.size):
        if 0.0 < p[k] < hardness:
            active[free] = k
            free += 1
    return free


@inlined()
def carry_load(nodes, work, limits, approach):
    """Shift the nodes between the bounds so that the load is exact, where they can carry it.

    Returns the sum of the pressures.
    """
    free = list_inside(nodes.p, limits.hardness, work.active)
    if free == 0:
        return sum_of(nodes.p)
    copy_line(nodes.p, work.trial)
    sets = Sets(work.active, free, 0)
    slope, _ = project(nodes.p, nodes.g, approach, work.trial, sets, limits, work.d)
    if slope < np.inf:
        return take_whole_step(nodes.p, work.d, limits.hardness)
    return sum_of(nodes.p)
