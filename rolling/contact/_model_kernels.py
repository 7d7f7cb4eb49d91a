"""Compiled model problem of the contact solve, which predicts who bears load next.

The model replaces the inverse of the half-space by a short stencil: a change c of a node's gap
changes the pressures around it by the stencil times c. With it the contact problem is a sparse
obstacle problem, and projected Jacobi sweeps settle it without a convolution. A node ends with the
pressure that closes its gap, or on a bound. The far field, which the stencil leaves out, is added
to the gaps from a coarse grid (see _far_field). Deflection and pressure of the start need
not be those of the model, only their changes are, so an extrapolation of both is a start as well.

All arrays of the grid are changes of pressure since the present state in single precision: `change`
is that of the model, `gap` the one that opens the gap, and `low` and `high` are the bounds.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import numpy as np
from numba import types

from rolling.contact._candidate_kernels import follow_field, lead_edges
from rolling.contact._condition_kernels import approach_of, project, worst_and_load
from rolling.contact._far_field import answer, mark_free, prolong, restrict
from rolling.contact._kinds import (
    DIRECTION,
    FAR_FIELD,
    FLAG,
    LINE,
    MODEL,
    NODES,
    NOTHING,
    NUMBER,
    SOLUTIONS,
    SYSTEM,
    WHOLE,
)
from rolling.contact._linked import linked
from rolling.contact._system import BORDER, Direction, Sets
from rolling.contact._window_kernels import copy_line, shared
from rolling.contact.compiling import inlined

# Sweeps that settle the model after its far field is known, and further sweeps after its edges
# moved.
LAST_SWEEPS = 1
EDGE_SWEEPS = 1
# The gaps of the model move the edges ahead of a step where the step before moved them so that a
# gap changed by more than this share of its violation. Moved ahead of all steps, they save 2 % more
# of the convolutions at Ra 0.1 um, but at Ra 0.01 um, where few edges matter, a step takes 10 %
# longer than without them, and 4 % as it is.
EDGES_LEAD = 0.35
# Nodes that a sweep passes over at a time. Their sums, 12 kB, stay in the first cache.
CHUNK = np.uint64(1024)
# signed numbers would turn indices into floats
ONE = np.uint64(1)
TWO = np.uint64(2)
# Up to so many nodes jump to their bound at once. Each takes a pass over the nodes, and so many
# passes take as long as a convolution.
JUMPS = 48


@inlined()
def fill(model, nodes, hardness, approach):
    """Set the grid to the state of the nodes; return the maximum violation [m] and the load."""
    p = nodes.p
    g = nodes.g
    place = model.node
    stiffness = model.stiffness
    gap = model.gap.reshape(-1)
    low = model.low.reshape(-1)
    high = model.high.reshape(-1)
    model.change[:] = 0.0
    gap[:] = 0.0
    for k in range(p.size):
        at = place[k]
        low[at] = -p[k]
        high[at] = hardness - p[k]
        gap[at] = stiffness * (g[k] - approach)
    return worst_and_load(p, g, approach, hardness)


@inlined(fused=True)
def add_changes(p, u, p_before, u_before, stiffness, changed, opened):
    """Set a line of the grid to the changes of pressure; add those of deflection to the gaps."""
    for k in range(changed.size):
        changed[k] = p[k] - p_before[k]
        opened[k] += stiffness * (u[k] - u_before[k])


@linked(
    NUMBER(MODEL, NODES, NUMBER, NUMBER, SOLUTIONS, LINE, LINE),
    calls=(approach_of,),
)
def extrapolate_model(model, nodes, hardness, present, solutions, pressure, height):
    """Add the changes between two solutions to the grid; return the approach of the sum [m].

    `present` is the approach of the grid. Nodes off the previous window were unloaded, and their
    deflections count as unchanged. `pressure` and `height` are overwritten.
    """
    compliance = nodes.compliance
    place = model.node
    change = model.change
    gap = model.gap
    stiffness = model.stiffness
    p, u, p_before, u_before, row, column, block = solutions
    first = block[1]
    rows = block[2]
    columns = block[3]
    a, b = shared(column, p_before.shape[1], first, first + columns)
    for i in range(rows):
        here = block[0] + i
        changed = change[i + BORDER, BORDER:]
        opened = gap[i + BORDER, BORDER:]
        copy_line(p[here, first : first + columns], changed[:columns])
        if row <= here < row + p_before.shape[0]:
            add_changes(
                p[here, a:b],
                u[here, a:b],
                p_before[here - row, a - column : b - column],
                u_before[here - row, a - column : b - column],
                stiffness,
                changed[a - first : b - first],
                opened[a - first : b - first],
            )
    changes = change.reshape(-1)
    gaps = gap.reshape(-1)
    for k in range(place.size):
        at = place[k]
        pressure[k] = nodes.p[k] + changes[at]
        height[k] = gaps[at] / stiffness
        if compliance.size:
            height[k] += compliance[k] * changes[at]
    return present + approach_of(pressure, height, hardness)


@inlined()
def lead_model(system, present, solutions):
    """Add the changes between two solutions to the model; return the approach of the sum [m].

    Changes of pressure and deflection belong together, so the model settles from their sum with the
    present state, whether that is feasible or not. The far field of the changes is in the gaps.
    """
    model = system.model
    far = system.far
    work = system.work
    gap = model.gap.reshape(-1)
    hardness = system.limits.hardness
    approach = extrapolate_model(
        model, system.nodes, hardness, present, solutions, work.trial, work.r
    )
    closing = np.float32((approach - present) * model.stiffness)
    for k in range(gap.size):
        gap[k] -= closing
    restrict(model.change, far.tile, far.row_length, far.known)
    return approach


@inlined(fused=True)
def first_moves(strips, change, gap, low, high, softening, moved):
    """Begin the sweeps: set the moves of the gaps, and `gap` to the change that would close it."""
    for i in range(strips.shape[0]):
        for k in range(strips[i, 0], strips[i, 1]):
            closing = change[k] - gap[k]
            soft = closing * softening[k] if softening.size else closing
            moved[k] = min(max(soft, low[k]), high[k]) - change[k]
            gap[k] = closing


@inlined(fused=True)
def sum_rows(moved, row, values, strip, begin, end, sums):
    """Sum the moves along each column of the stencil, at the nodes from `begin` to `end`.

    The sums of its middle, its sides and its second sides begin two nodes before, and end two nodes
    after; off the strip they are zero. The centre is left out. `row` is the number of nodes in a
    row of the grid.
    """
    b = values[1]
    c = values[2]
    d = values[3]
    e = values[4]
    f = values[5]
    middle = sums[0]
    side = sums[1]
    second = sums[2]
    before = begin - TWO
    after = end + TWO
    for j in (before, before + ONE, end, end + ONE):
        side[j - before] = 0.0
        second[j - before] = 0.0
    for k in range(max(strip[0], before), min(strip[1], after)):
        j = k - before
        once = moved[k - row] + moved[k + row]
        twice = moved[k - row - row] + moved[k + row + row]
        middle[j] = b * once + d * twice
        side[j] = b * moved[k] + c * once + e * twice
        second[j] = d * moved[k] + e * once + f * twice


@inlined(fused=True)
def next_moves(begin, end, sums, low, high, softening, closing, moved):
    """Set the next moves of the gaps, by the sums along the columns of the stencil.

    `closing` is the change of pressure that would close the gap. A move adds as much to the gap as
    to the node's own pressure, so that only moves of other nodes change it.
    """
    middle = sums[0]
    side = sums[1]
    second = sums[2]
    for k in range(begin, end):
        j = k - begin + TWO
        before = closing[k]
        after = before + (
            middle[j] + (side[j - ONE] + side[j + ONE]) + (second[j - TWO] + second[j + TWO])
        )
        closing[k] = after
        soft_before = before * softening[k] if softening.size else before
        soft_after = after * softening[k] if softening.size else after
        gap_before = min(max(soft_before, low[k]), high[k]) - before
        moved[k] = (min(max(soft_after, low[k]), high[k]) - after) - gap_before


@inlined(fused=True)
def last_moves(begin, end, sums, low, high, softening, gap, change):
    """End the sweeps: set the changes of pressure and the gaps."""
    middle = sums[0]
    side = sums[1]
    second = sums[2]
    for k in range(begin, end):
        j = k - begin + TWO
        closing = gap[k]
        soft = closing * softening[k] if softening.size else closing
        bounded = min(max(soft, low[k]), high[k])
        change[k] = bounded + (
            middle[j] + (side[j - ONE] + side[j + ONE]) + (second[j - TWO] + second[j + TWO])
        )
        gap[k] = bounded - closing


@inlined()
def clear_border(grid):
    """Set to zero the two nodes at both ends of each row, which never move."""
    row = grid.shape[1]
    for i in range(2, grid.shape[0] - 2):
        grid[i, 0] = 0.0
        grid[i, 1] = 0.0
        grid[i, row - 2] = 0.0
        grid[i, row - 1] = 0.0


@linked(NOTHING(MODEL, WHOLE))
def settle_model(model, sweeps):
    """Settle the model problem by Jacobi sweeps.

    A sweep moves each gap so that the node's own pressure closes it or goes to a bound, and adds
    the stencil of the moves to the pressures. It passes over the strips of the grid as one long
    row, which is much faster than row by row, and over CHUNK nodes at a time, whose sums stay in
    the cache. All other nodes rest, and moves reach a node by way of columns of the stencil within
    its strip. The border never moves, so that the end of one row does not act on the beginning of
    the next.
    """
    row = np.uint64(model.gap.shape[1])
    strips = model.strips
    change = model.change.reshape(-1)
    gap = model.gap.reshape(-1)
    low = model.low.reshape(-1)
    high = model.high.reshape(-1)
    softening = model.softening.reshape(-1)
    sums = np.empty((3, np.int64(CHUNK) + 4), np.float32)
    moves = model.moved
    following = model.following
    first_moves(strips, change, gap, low, high, softening, moves.reshape(-1))
    for sweep in range(1, sweeps + 1):
        clear_border(moves)
        moved = moves.reshape(-1)
        moving = following.reshape(-1)
        for i in range(strips.shape[0]):
            for begin in range(strips[i, 0], strips[i, 1], CHUNK):
                end = min(begin + CHUNK, strips[i, 1])
                sum_rows(moved, row, model.values, strips[i], begin, end, sums)
                if sweep < sweeps:
                    next_moves(begin, end, sums, low, high, softening, gap, moving)
                else:
                    last_moves(begin, end, sums, low, high, softening, gap, change)
        moves, following = following, moves
    clear_border(model.change)
    clear_border(model.gap)


@linked(NOTHING(MODEL, FAR_FIELD, NUMBER), calls=(restrict, answer, prolong))
def add_far_field(model, far, unit):
    """Add the far field to the gaps: that of the changes and of the answer of all free nodes.

    `unit` is the deflection per pressure and coefficient [m/Pa].
    """
    change = model.change.reshape(-1)
    gap = model.gap.reshape(-1)
    low = model.low.reshape(-1)
    high = model.high.reshape(-1)
    free = model.moved.reshape(-1)
    mark_free(model.strips, change, gap, low, high, model.softening.reshape(-1), free)
    restrict(model.moved, far.tile, far.row_length, far.stiffness)
    restrict(model.change, far.tile, far.row_length, far.loads)
    answer(far)
    prolong(far.field, np.float32(unit * model.stiffness), far.tile, far.row_length, model.gap)


@inlined()
def settle(system, sweeps, edges_lead):
    """Settle the model by so many sweeps and its far field, and the last sweeps.

    Where `edges_lead`, the edges of the candidates follow the gaps of the model before the last
    sweeps. On sub-cells, without coefficients by distance, nodes on their way to a bound hold a
    step back so far that this gains nothing.
    """
    settle_model(system.model, sweeps)
    add_far_field(system.model, system.far, system.transform.unit)
    last = LAST_SWEEPS
    if edges_lead and system.influence.coefficients.size:
        lead_edges(system)
        last += EDGE_SWEEPS
    settle_model(system.model, last)


@inlined()
def changes_of(model, changes):
    """Set the changes of pressure that close the gaps of the nodes, whatever their bounds."""
    place = model.node
    soft = model.softening.reshape(-1)
    change = model.change.reshape(-1)
    gap = model.gap.reshape(-1)
    for k in range(place.size):
        changes[k] = change[place[k]] - gap[place[k]]
    for k in range(place.size if soft.size else 0):
        changes[k] = np.float32(changes[k]) * soft[place[k]]


@inlined()
def targets_of(p, hardness, changes, trial, r_before):
    """Set the trial pressures to the targets, and `changes` to 1 at free nodes, 2 at bound nodes.

    The bounds of the changes are those of the model, rounded as there. This loop has no branches,
    so that the processor takes several nodes at once.
    """
    for k in range(p.size):
        low = np.float64(np.float32(-p[k]))
        high = np.float64(np.float32(hardness - p[k]))
        is_low = changes[k] <= low
        is_high = changes[k] >= high
        target = min(max(p[k] + changes[k], 0.0), hardness)
        target = 0.0 if is_low else hardness if is_high else target
        inside = not (is_low | is_high)
        trial[k] = target
        r_before[k] = r_before[k] if inside else 0.0
        changes[k] = 1.0 if inside else 2.0 if target != p[k] else 0.0


@inlined()
def sort_nodes(system):
    """List the free nodes and those that go to a bound, as the model says.

    Their targets go into the trial pressures. Returns the numbers of both.
    """
    p = system.nodes.p
    work = system.work
    active = work.active
    kind = work.r
    free = 0
    bound = 0
    changes_of(system.model, kind)
    targets_of(p, system.limits.hardness, kind, work.trial, work.r_before)
    for k in range(p.size):
        # Both lists are written at their ends, and the next node overwrites what does not count.
        active[free] = k
        free += kind[k] == 1.0
        active[p.size - 1 - bound] = k
        bound += kind[k] == 2.0
    for i in range(bound):
        # This order reads each entry before it is overwritten.
        active[free + i] = active[p.size - bound + i]
    return free, bound


@linked(NOTHING(SYSTEM, WHOLE, WHOLE))
def jump(system, free, bound):
    """Put the bound nodes on their bound at once, and add the deflection by each to the gaps.

    Their trial pressures become the pressures before, so that a second jump takes the first back.
    """
    nodes = system.nodes
    work = system.work
    unit = system.transform.unit
    p = nodes.p
    g = nodes.g
    compliance = nodes.compliance
    trial = work.trial
    active = work.active
    coefficients = system.influence.coefficients
    place = system.influence.node
    middle = coefficients.size // 2
    for a in range(free, free + bound):
        b = active[a]
        change = trial[b] - p[b]
        p[b], trial[b] = trial[b], p[b]
        if compliance.size:
            g[b] += compliance[b] * change
        change *= unit
        from_b = middle - np.int64(place[b])
        for k in range(p.size):
            g[k] += change * coefficients[from_b + np.int64(place[k])]


@inlined()
def model_direction(system, approach, last, free, bound):
    """Find the feasible direction to the targets, conjugate to the last direction.

    Where it does not descend, the last direction is forgotten (a restart).

    Returns the Direction and the number of restarts.
    """
    nodes = system.nodes
    work = system.work
    limits = system.limits
    p = nodes.p
    g = nodes.g
    d = work.d
    trial = work.trial
    active = work.active
    r_before = work.r_before
    target = work.r
    zr = 0.0
    change = 0.0
    for a in range(free):
        k = active[a]
        r = g[k] - approach
        z = p[k] - trial[k]
        zr += z * r
        change += z * (r - r_before[k])
        r_before[k] = r
    length = last.length
    beta = max(0.0, change / last.zr) if last.zr > 0.0 else 0.0
    for a in range(free):
        k = active[a]
        target[k] = p[k] + length * (trial[k] - p[k])
        trial[k] = target[k] + beta * d[k]
    sets = Sets(active, free, bound)
    slope, longest = project(p, g, approach, trial, sets, limits, d)
    restarts = 0
    if not slope < 0.0 and beta > 0.0:
        restarts = 1
        for a in range(free):
            trial[active[a]] = target[active[a]]
        slope, longest = project(p, g, approach, trial, sets, limits, d)
    return Direction(slope, longest, max(zr, 0.0), length), restarts


@linked(
    types.Tuple((DIRECTION, WHOLE, WHOLE, WHOLE))(SYSTEM, NUMBER, DIRECTION, WHOLE, FLAG, FLAG),
    calls=(settle_model, add_far_field, follow_field, jump, project),
)
def follow_model(system, approach, last, sweeps, edges_lead, jumps):
    """Find the next direction by the model, whose grid holds the present state.

    The model is settled by so many sweeps, with its edges if `edges_lead`. Few nodes on their way
    to a bound jump there at once if `jumps`.

    Returns the Direction, whose slope is not negative where none of the model descends, and the
    numbers of free nodes, of nodes on their way to a bound and of restarts.
    """
    settle(system, sweeps, edges_lead)
    free, bound = sort_nodes(system)
    jumped = 0
    if jumps and 0 < bound <= min(JUMPS, free) and system.influence.coefficients.size:
        jump(system, free, bound)
        jumped = bound
        bound = 0
    direction, restarts = model_direction(system, approach, last, free, bound)
    if jumped and not direction.slope < 0.0:
        jump(system, free, jumped)
    return direction, free, bound, restarts
