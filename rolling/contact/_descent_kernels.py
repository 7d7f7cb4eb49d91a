"""Compiled solve of a contact: descents by conjugate gradients, each followed by a full check.

`converge` goes from the start to the accepted solution in one call. It returns early where
something is missing: transforms of a size, the far field of a grid, or the same code in the other
precision. Its state stays in the arrays of the caller, so that the next call goes on.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

from functools import cache as once

import numpy as np
from numba import types

from rolling.contact import _candidate_kernels as search
from rolling.contact import _solver_kernels as solver
from rolling.contact import _system as parts
from rolling.contact import _transform_kernels as transforms
from rolling.contact._by_address import address_of, array_at, caller
from rolling.contact._condition_kernels import settle_load, state_of, sum_of
from rolling.contact._far_field import _coarse_grid
from rolling.contact._system import BORDER, Direction, Limits, Solutions, Step, System, numba_type
from rolling.contact._window_kernels import extrapolate_deflection, reach
from rolling.contact.compiling import njit
from rolling.contact.half_space import OWN_COEFFICIENT

MAX_ITERATIONS = 1000
# A descent and a call of the solve end after so many iterations, so that Python learns of an
# interrupt before the next call goes on.
LONGEST = 100
# Sweeps before the far field of the model, first from the extrapolation, then in each iteration.
# With half as many, steps take 0.1 to 0.7 convolutions more.
FIRST_SWEEPS = 8
SWEEPS = 4
# Sweeps in each iteration on blocks of more than so many nodes. With 4 sweeps the last check
# refuses a third of the descents on contacts 600 nodes wide at Ra 1 um; on smaller blocks 6 save
# less time than they take.
WIDE_SWEEPS, WIDE_BLOCK = 6, 300_000
# After so many iterations the preconditioned residual leads instead of the model, whose steps are
# fewer but need not lower the energy.
MODELLED = 15
# From this step length on a step is taken as a whole, so that nodes on their way to a bound arrive.
# The energy still falls, as it does up to twice the best length.
NEARLY_WHOLE = 0.8
# On wide contacts hundreds of nodes stay on their way while the violation stalls, at more than this
# share of its minimum so far. Shorter steps are then taken as a whole.
STALLED = 0.9
NEARLY_WHOLE_STALLED = 0.55
# Few nodes deflect the candidates pair by pair, where the pairs are at most so many times the nodes
# of the transforms: a pair takes 0.5 ns, and a transform forth and back 1.1 ns per node.
DIRECT_PAIRS = 2
MAX_MOVES = 100  # of the edges in a solve, one in each iteration, before they stay
# The descent aims at this share of the tolerance. The rest allows for the difference between the
# updated deflection and a recomputed deflection.
AIM = 0.98
# The first descent of a solve aims at this multiple, and at the second one where the model moves
# edges. Its last step needs no convolution of its own and leaves a fifth of the violation.
# Multiples of 5 take 0.1 convolutions less, but leave up to 3 dB more error of the release, and so
# does a multiple of 3 where the model moves edges and the window is 190 nodes wide (100 N).
AIM_FIRST, AIM_FIRST_LED = 3.0, 2.5
# Candidates for contact have a gap below this share of the maximum deflection; shares from 0.001 to
# 0.1 take the same number of iterations.
NEAR = 0.01
# Nodes at the hardness rest beyond so many times the reach of the open candidates. With 1 the last
# check refuses more descents, above all on sub-cells; with 8 the candidates are up to 14 % more.
REST = 4
# Single precision, with an error of 1e-7 of the maximum deflection, serves no tighter tolerance.
SINGLE_TOLERANCE = 1e-6

_SINGLE = np.empty(0, np.float32)  # array of single precision

# Answers of a solve: the solution, an error, or what its caller has to provide.
SOLVED, SPENT, NOT_FINITE, TOO_WIDE, UNFINISHED = range(5)
TRANSFORMS, FAR_FIELD, KERNEL, PRECISION, FIELDS = range(5, 10)
# Entries of the state of a solve, which begins with zeros.
(ITERATIONS, RESTARTS, PLAIN_STEPS, STUCK, ROUNDS, MOVES, LOAD_MISSED, EXHAUSTED) = range(8)
(CARRIED, CANDIDATES, DEFLECTION, STATES) = range(8, 12)
(UNKNOWN, GIVEN, FRESH) = range(3)  # the deflection


def step_types(real: types.Float) -> tuple[types.Type, ...]:
    """Return the types of the arguments of `iterate` of the solver for transforms of a type."""
    tuples = (numba_type(kind, real) for kind in (System, Direction, Solutions))
    return *tuples, *[types.float64] * 3, types.int64, types.boolean, types.boolean


STEPPED = types.Tuple([numba_type(Step, types.float64), numba_type(Direction, types.float64)])
step_at = caller(STEPPED, step_types(types.float32), step_types(types.float64))


@once
def step_address(single: bool) -> int:
    """Return the address of `iterate` of the solver, which is compiled if need be."""
    types_of_step = step_types(types.float32 if single else types.float64)
    return address_of(solver.iterate, STEPPED, types_of_step)


@njit(cache=True, inner=True)
def system_of(window, listed, resting, block, numbers, stencils, u_max, entry, far, real):
    """Return the System of a descent on listed candidates.

    `window` has pressures, deformed gaps, edges and the undeformed gap as it continues within cells
    and at the nodes, `resting` is the sum of the pressures of the nodes at rest, and `far` the
    entry of the far field.
    """
    p, g, edge, shape, gap = window
    hardness, total, _, levelled, share = numbers
    unit, preconditioner, inverse, centre, own, common = stencils
    n, blended = listed.size, edge.size > 0
    rows, columns = block[2] + 2 * BORDER, block[3] + 2 * BORDER
    # Vectors and grids that only blended edges have are otherwise empty slices of others.
    v, soft = np.empty((10 if blended else 6, n)), n if blended else 0
    v[2:6] = 0.0
    grids = np.empty((2 if blended else 1, rows * columns))
    field = grids[-1][: grids.shape[1] if blended else 0]
    field[:] = np.nan
    # The passes set the other grids of the model before they read them.
    m = np.empty((7 if blended else 6, rows, columns), np.float32)
    m[2:6] = 0.0
    left = m[-1][: rows if blended else 0]
    index = np.empty((4, n), np.uint32)
    strips = np.empty((rows * columns // search.STRIP + 1, 2), np.uint64)
    image = transforms.block_of(entry, block[2], block[3], real)
    lengths = (image.shape[1], image.shape[2]), columns, 2 * (entry[transforms.WIDTH] // 2) + 1
    pressures, gaps = p.reshape(-1), g.reshape(-1)
    corner = block[0], block[1]
    count = search.take_nodes(
        listed, p.shape[1], corner, lengths, rows, pressures, gaps, v, index, strips
    )
    strips, lift = strips[:count], u_max / total
    coarse_rows, coarse_columns, tile = _coarse_grid(rows, columns)
    length = 2 * coarse_columns - 1
    c = np.zeros((7, coarse_rows * length), np.float32)
    distances = (2 * coarse_rows - 1) * length + coarse_columns
    table = array_at(far[transforms.BLOCK], (distances,), _SINGLE)
    size = entry[transforms.INFLUENCE_SIZE]
    coefficients = array_at(entry[transforms.INFLUENCE], (size,), _SINGLE)
    stiffness = 1 / (unit * OWN_COEFFICIENT)
    system = System(
        parts.Nodes(v[0], v[1], v[-4][:soft], v[-3][:soft]),
        parts.Transform(image.reshape(-1), index[1], unit),
        parts.Stencil(preconditioner, grids[0], index[2], columns, stiffness),
        parts.Work(v[2], v[3], v[4], v[5], index[0]),
        Limits(hardness, total - resting),
        parts.Edges(v[-2][:soft], v[-1][:soft], field, levelled, share),
        parts.Model(
            inverse, m[0], m[1], m[2], m[3], m[4], m[5], left, index[2], strips, centre, lift
        ),
        parts.FarField(tile, length, own, common, table, c[0], c[1], c[2], c[3], c[4], c[5], c[6]),
        parts.Influence(coefficients, index[3]),
    )
    if blended:
        search.take_edges(system, listed, edge.reshape(-1), shape.reshape(-1), gap.reshape(-1))
    return system


@njit(cache=True, inner=True)
def sweeps_of(state, nodes):
    """Return the sweeps that settle a model of so many nodes, 0 where it does not lead."""
    if state[ITERATIONS] >= MODELLED or state[STUCK]:
        return 0
    return WIDE_SWEEPS if nodes > WIDE_BLOCK else SWEEPS


@njit(cache=True, inner=True)
def convolve(system, entry, block, moving, most, cells, state, table):
    """Replace the direction in the array of the transforms by its deflection.

    Few nodes that move deflect the candidates pair by pair, up to `most` pairs.
    """
    work, influence = system.work, system.influence
    few = moving * work.d.size <= most
    if not (few and solver.sum_directly(system.transform, work.d, work.trial, influence, most)):
        transforms.apply_at(entry[transforms.APPLY], (entry, block[2], block[3], cells))
    table[0, 0] += 1
    state[ITERATIONS] += 1


@njit(cache=True, apart=True)
def descend(system, entry, block, cells, solutions, goal, allowed, single, state, table, kernel):
    """Descend by conjugate gradients until the violation is within `goal` [m], stuck or spent.

    The first direction comes from the last two solutions, unless they are empty.

    Returns whether the pressures of the candidates are known to carry the load exactly, and whether
    the descent went as far as its precision allows. The latter is false for the first descent and
    for one that the model led to its last iteration.
    """
    p, g = system.nodes.p, system.nodes.g
    blended = system.nodes.compliance.size > 0
    most = np.int64(-1)  # pairs, which are of single precision; a negative number is never reached
    if single and system.influence.coefficients.size:
        most = DIRECT_PAIRS * entry[transforms.LENGTH] * entry[transforms.WIDTH]
    direction, moving = Direction(0.0, 0.0, 0.0, solver.FIRST_LENGTH), 0
    if solutions.p.size:
        led = system, direction, solutions, NEARLY_WHOLE, 0.0, 0.0, FIRST_SWEEPS, False, False
        step, direction = step_at(kernel, led)
        moving = step.free + step.bound
    nothing = solutions.p[:0]
    none = Solutions(nothing, nothing, nothing, nothing, 0, 0, block)
    state[ROUNDS] += 1
    snap = 0.0 if state[LOAD_MISSED] else 0.01 * allowed * system.stencil.stiffness
    # The snap is divided by the number of nodes, so that its sum makes no difference.
    share = p.size
    if direction.slope < 0:
        convolve(system, entry, block, moving, most, cells, state, table)
    minimum, nearly, end = np.inf, NEARLY_WHOLE, state[ITERATIONS] + LONGEST
    while True:
        last = state[ITERATIONS] >= MAX_ITERATIONS
        sweeps = sweeps_of(state, block[2] * block[3])
        state[MOVES] += blended
        within = np.inf if last else goal
        edges_move = 0 < state[MOVES] <= MAX_MOVES
        # Where the check refused a last step once, the residual has waves too long for the model.
        finishing = state[ROUNDS] == 1 and not last
        stepped = system, direction, none, nearly, snap / share, within, sweeps
        step, direction = step_at(kernel, (*stepped, edges_move, finishing))
        worst, moving = step.worst, step.free + step.bound
        if last or not worst > goal:
            break
        nearly = NEARLY_WHOLE_STALLED if worst > STALLED * minimum else NEARLY_WHOLE
        minimum = min(minimum, worst)
        share = max(step.bound, 1)
        state[RESTARTS] += step.restarts
        state[PLAIN_STEPS] += step.plain_steps
        model_ends = sweeps and state[ITERATIONS] >= MODELLED - 1
        if not direction.slope < 0 or model_ends or state[ITERATIONS] >= end:
            state[ITERATIONS] += 1
            break
        state[STUCK] = 0
        convolve(system, entry, block, moving, most, cells, state, table)
    if not step.worst > goal:
        return carry(system, step, state), state[ROUNDS] > 1
    if not direction.slope < 0:
        restart(system, state)
        return False, True
    settle_load(p, g, system.limits, 0.0)
    return False, False


@njit(cache=True, inner=True)
def carry(system, step, state):
    """Make the pressures carry the load after a descent; tell whether they do so exactly.

    A node that was put on a bound took its share of the load along. The last step or the free nodes
    make up for it, or else the nodes that are nearest to moving.
    """
    nodes, limits, carried = system.nodes, system.limits, step.load
    if carried == 0:
        carried = solver.carry_load(nodes, system.work, limits, step.approach)
    if abs(carried / limits.total - 1) <= 1e-13:
        return True
    state[LOAD_MISSED] = 1
    settle_load(nodes.p, nodes.g, limits, 0.0)
    return False


@njit(cache=True, inner=True)
def restart(system, state):
    """Replace the pressures by a feasible restart where no step descends.

    Pressures of the order of rounding errors can pass for free nodes and set the approach, so the
    projection becomes the state.
    """
    p, trace = system.nodes.p, 0.0
    state[STUCK] += 1
    for k in range(p.size):
        p[k] += system.work.d[k]
        trace = max(trace, p[k])
    settle_load(p, system.nodes.g, system.limits, 1e-9 * trace)


@njit(cache=True, inner=True)
def transforms_for(table, reaches, kind):
    """Return the number of the entry of the transforms for nodes so far apart, 0 if none is there.

    `kind` is 1 in single precision, else 0.
    """
    subcells = table[0, 1]
    length = transforms._padded(reaches[0], subcells, transforms.ALONG)
    width = transforms._padded(reaches[1], subcells, transforms.ACROSS)
    place = transforms.find(table, length, width, kind)
    if place:
        table[place, transforms.USED] = table[0, 0]
    return place


@njit(cache=True, inner=True)
def entries_of(table, block, single):
    """Return the numbers of the entries of transforms and far field for a block of candidates.

    The answer before them is SOLVED, or names the missing entry, whose size follows.
    """
    rows, columns, tile = _coarse_grid(block[2] + 2 * BORDER, block[3] + 2 * BORDER)
    reaches = block[2] - 1, block[3] - 1
    place = transforms_for(table, reaches, single)
    far = transforms.find(table, rows, columns, -tile)
    if not place or table[place, transforms.INFLUENCE_SIZE] < 0:
        return TRANSFORMS, (*reaches, single, 1), place, far
    if not far:
        return FAR_FIELD, (rows, columns, tile, 0), place, far
    table[far, transforms.USED] = table[0, 0]
    return SOLVED, (0, 0, 0, 0), place, far


@njit(cache=True, inner=True)
def judge(window, p, u, before, numbers, fresh, edge, g):
    """Set the edges and the deformed gaps of a state; return its numbers as `state_of` does.

    Edges follow the deflection u, or its extrapolation where there is a position `before`.
    """
    (gap, shape), (hardness, _, _, levelled, share) = window, numbers
    if edge.size:
        field = u
        if before[0].size:
            extrapolate_deflection(u, before[1], before[2], before[3], g)
            field = g
        search.cell_ranges(shape, field, levelled, share, edge)
    flat = gap.reshape(-1), u.reshape(-1), p.reshape(-1), edge.reshape(-1)
    return state_of(flat[0], flat[1], flat[2], flat[3], hardness, g.reshape(-1), fresh)


@njit(cache=True, apart=True)
def converge(window, start, before, out, numbers, stencils, flags, state, table, kernel, real):
    """Iterate from a start until the contact conditions hold: see the module.

    Parameters
    ----------
    window : arrays
        Undeformed gap, and as it continues within cells.
    start : arrays
        Pressure, which becomes that of the solution, and its deflection where it is known.
    before : arrays, row and column
        Pressure and deflection of the previous position, empty where there is none, and the node of
        the window where theirs begins.
    out : arrays
        Deflection of the solution, and its edges, empty where they are sharp.
    numbers : tuple
        Hardness, sum of the pressures, tolerance, levelled range and share of the edges.
    stencils : tuple
        Deflection per pressure and coefficient, and the fields of Stencils.
    flags : tuple of bool
        Whether the start is close to the solution, and whether single precision may serve.
    state : array
        State of the solve.
    table : array
        Entries of the transforms and far fields of the half-space: see `HalfSpace`.
    kernel : int
        Address of `iterate` of the solver.
    real : array
        Empty array of the type of the transforms.

    Returns
    -------
    tuple
        Answer, approach, maximum deflection and maximum violation [m], and what is missing.
    """
    p, u_given = start
    u_fresh, edge = out
    hardness, total, tolerance, _, _ = numbers
    close, may_be_single = flags
    blended, subcells, columns = edge.size > 0, table[0, 1], p.shape[1]
    g, listed, pressures = np.empty(p.shape), np.empty(p.size, np.int64), p.reshape(-1)
    nothing, none = np.empty((0, 0)), (0, 0, 0, 0)
    end = state[ITERATIONS] + LONGEST
    while True:
        if state[DEFLECTION] == UNKNOWN:
            reaches = reach(p)
            place = transforms_for(table, reaches, np.int64(0))
            if not place:
                return TRANSFORMS, 0.0, 0.0, 0.0, (*reaches, 0, 0)
            transforms.deflect(p, stencils[0], table[place], table, u_fresh)
            state[DEFLECTION] = FRESH
        fresh = state[DEFLECTION] == FRESH
        u = u_fresh if fresh else u_given
        last = (nothing, nothing, 0, 0) if fresh else before
        approach, u_max, worst = judge(window, p, u, last, numbers, fresh, edge, g)
        if not (np.isfinite(approach) and 0 < u_max < np.inf) or (fresh and worst == np.inf):
            return NOT_FINITE, approach, u_max, worst, none
        allowed = tolerance * u_max
        accurate = fresh and worst <= allowed
        if accurate and (state[CARRIED] or abs(sum_of(pressures) / total - 1) <= 1e-12):
            return SOLVED, approach, u_max, worst, none
        rounds = state[ROUNDS]
        if state[STUCK] > 1 or state[ITERATIONS] >= MAX_ITERATIONS or rounds > MAX_ITERATIONS:
            return SPENT, approach, u_max, worst, none
        if state[ITERATIONS] >= end:
            return UNFINISHED, approach, u_max, worst, none
        near = (NEAR if close or rounds else np.inf) * u_max
        heights = approach - REST * near, approach + near
        resting, count, row, column, block_rows, block_columns = search.candidates(
            p, g, hardness, heights[0], heights[1], blended, subcells, listed
        )
        block, node = (row, column, block_rows, block_columns), listed[:count]
        # Where a descent went as far as it could and left no new candidates, single precision does
        # not suffice.
        single = may_be_single and tolerance >= SINGLE_TOLERANCE
        if state[EXHAUSTED] and count <= state[CANDIDATES]:
            single = single and blended and rounds <= 4
        if single != (real.itemsize == 4):
            return PRECISION, approach, u_max, worst, none
        answer, missing, place, far = entries_of(table, block, np.int64(single))
        if answer != SOLVED:
            return answer, approach, u_max, worst, missing
        cells, entry = listed[:0], table[place]
        if subcells > 1:
            cells = transforms.cells_of(node, columns, block, subcells)
        fields = p, g, edge, window[1], window[0]
        at_rest = resting * hardness if resting else 0.0
        system = system_of(
            fields, node, at_rest, block, numbers, stencils, u_max, entry, table[far], real
        )
        first = AIM_FIRST_LED if blended and subcells == 1 else AIM_FIRST
        goal = (AIM if rounds else first) * allowed
        solutions = Solutions(nothing, nothing, nothing, nothing, 0, 0, block)
        if last[0].size:
            solutions = Solutions(p, u, last[0], last[1], last[2], last[3], block)
        state[CARRIED], state[EXHAUSTED] = descend(
            system, entry, block, cells, solutions, goal, allowed, single, state, table, kernel
        )
        state[CANDIDATES] = count
        for a in range(count):
            pressures[node[a]] = system.nodes.p[a]
        state[DEFLECTION] = UNKNOWN
