"""Compiled solve of a contact: descents by conjugate gradients, each followed by a full check.

`converge` goes from the start to the accepted solution in one call. It returns early where Python
has to provide something: transforms of a size, the far field of a grid, a kernel, or the same code
in the other precision. Its state stays in the arrays of the caller, so that the next call goes on.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from functools import cache as once

import numpy as np
from numba import types

from rolling.contact import _solver_kernels
from rolling.contact._by_address import address_of, array_at, caller
from rolling.contact._candidate_kernels import (
    STRIP,
    candidates,
    cell_ranges,
    take_edges,
    take_nodes,
)
from rolling.contact._condition_kernels import settle_load, state_of, sum_of
from rolling.contact._far_field import _coarse_grid
from rolling.contact._solver_kernels import FIRST_LENGTH, carry_load, sum_directly
from rolling.contact._system import BORDER, Limits, packed_type
from rolling.contact._transform_kernels import (
    APPLY,
    APPLY_TYPES,
    BLOCK,
    INFLUENCE,
    INFLUENCE_SIZE,
    LENGTH,
    USED,
    WIDTH,
    _padded,
    block_of,
    cells_of,
    find,
    has_plans,
    load,
    read,
)
from rolling.contact._window_kernels import extrapolate, reach
from rolling.contact.compiling import njit

MAX_ITERATIONS = 1000
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
PAIRS = 2
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

# Answers of `converge`: the solution, an error, or what Python has to provide.
(SOLVED, SPENT, NOT_FINITE, TRANSFORMS, INFLUENCES, FAR_FIELD, KERNEL, PRECISION) = range(8)
# Entries of the state of a solve, which begins with zeros.
(ITERATIONS, RESTARTS, PLAIN_STEPS, STUCK, ROUNDS, MOVES, LOAD_MISSED, EXHAUSTED, CARRIED) = range(9)
(CANDIDATES, DEFLECTION, STATES) = range(9, 12)
(UNKNOWN, GIVEN, FRESH) = range(3)  # the deflection

STEP = types.Tuple([*[types.float64] * 2, *[types.int64] * 4, types.float64])
STEPPED = types.Tuple([STEP, types.UniTuple(types.float64, 4)])
_FIELD = types.float64[:, ::1]
_SOLUTIONS = types.Tuple(
    [*[_FIELD] * 4, types.UniTuple(types.int64, 2), types.UniTuple(types.int64, 4)]
)


def step_types(real: types.Float) -> tuple[types.Type, ...]:
    """Return the types of the arguments of `iterate` of the solver for transforms of a type."""
    numbers = [types.float64] * 3
    flags = [types.int64, types.boolean, types.boolean]
    direction = types.UniTuple(types.float64, 4)
    return packed_type(real), direction, _SOLUTIONS, *numbers, *flags


step_at = caller(STEPPED, step_types(types.float32), step_types(types.float64))


@once
def step_address(single: bool) -> int:
    """Return the address of `iterate` of the solver, which is compiled if need be."""
    types_of_step = step_types(types.float32 if single else types.float64)
    return address_of(_solver_kernels.iterate, STEPPED, types_of_step)


apply_at = caller(types.none, APPLY_TYPES)


@njit(cache=True, inner=True)
def pack(window, listed, resting, block, numbers, stencils, u_max, entry, far, real):
    """Make the arrays of a descent on listed candidates: see `Packed`.

    `window` has pressures, deformed gaps, edges and the gap as it continues within cells and at the
    nodes. `far` is the entry of the far field.
    """
    p, g, edge, shape, gap = window
    hardness, total, _, unit, stiffness, levelled, share = numbers
    preconditioner, model_stencil, model_stiffness, own, common = stencils
    blended, n = edge.size > 0, listed.size
    rows, columns = block[2] + 2 * BORDER, block[3] + 2 * BORDER
    coarse_rows, coarse_columns, tile = _coarse_grid(rows, columns)
    row_length = 2 * coarse_columns - 1
    vectors = np.zeros((10 if blended else 6, n))
    grids = np.zeros((2 if blended else 1, rows * columns))
    if blended:
        grids[1] = np.nan
    # The passes set the other grids of the model before they read them.
    model = np.empty((7 if blended else 6, rows, columns), np.float32)
    model[2:6] = 0.0
    indices = np.empty((4, n), np.uint32)
    strips = np.empty((rows * columns // STRIP + 1, 2), np.uint64)
    image = block_of(entry, block[2], block[3], real)
    lengths = (image.shape[1], image.shape[2]), columns, 2 * (entry[WIDTH] // 2) + 1
    count = take_nodes(
        listed,
        p.shape[1],
        (block[0], block[1]),
        lengths,
        rows,
        p.reshape(-1),
        g.reshape(-1),
        vectors,
        indices,
        strips,
    )
    values = (
        hardness,
        total - resting,
        unit,
        stiffness,
        levelled,
        model_stiffness,
        u_max / total,
        own,
        common,
        share,
    )
    single = np.empty(0, np.float32)
    packed = (
        vectors,
        indices,
        image.reshape(-1),
        grids,
        model,
        strips[:count],
        np.zeros((7, coarse_rows * row_length), np.float32),
        preconditioner,
        model_stencil,
        array_at(far[BLOCK], ((2 * coarse_rows - 1) * row_length + coarse_columns,), single),
        array_at(entry[INFLUENCE], (entry[INFLUENCE_SIZE],), single),
        values,
        (tile, row_length),
    )
    if blended:
        between, within, nodes = np.empty(n), shape.reshape(-1), gap.reshape(-1)
        for a in range(n):
            between[a] = within[listed[a]] - nodes[listed[a]]
        take_edges(
            listed, edge.reshape(-1), between, values, vectors, indices[2], model[6].reshape(-1)
        )
    return packed


@njit(cache=True, inner=True)
def sweeps_of(state, nodes):
    """Return the sweeps that settle a model of so many nodes, 0 where it does not lead."""
    if state[ITERATIONS] >= MODELLED or state[STUCK]:
        return 0
    return WIDE_SWEEPS if nodes > WIDE_BLOCK else SWEEPS


@njit(cache=True, inner=True)
def convolve(packed, entry, block, moving, most, cells, state, table):
    """Replace the direction in the array of the transforms by its deflection.

    Few nodes that move deflect the candidates pair by pair, up to `most` pairs.
    """
    few = moving * packed[0].shape[1] <= most
    if not (few and sum_directly(packed, most)):
        apply_at(entry[APPLY], (entry, block[2], block[3], cells))
    table[0, 0] += 1
    state[ITERATIONS] += 1


@njit(cache=True, inner=True)
def descend(packed, entry, block, cells, solutions, goal, allowed, single, state, table, kernel):
    """Descend by conjugate gradients until the violation is within `goal` [m], stuck or spent.

    The first direction comes from the last two solutions, unless they are empty.

    Returns whether the pressures of the candidates are known to carry the load exactly, and whether
    the descent went as far as its precision allows. Neither the first descent nor one that the model
    led to its last iteration did.
    """
    vectors = packed[0]
    p, g, nodes, blended = vectors[0], vectors[1], vectors.shape[1], vectors.shape[0] > 6
    limits, stiffness = Limits(packed[11][0], packed[11][1]), packed[11][3]
    most = np.int64(-1)  # pairs, which are of single precision; a negative number is never reached
    if single and packed[10].size:
        most = PAIRS * entry[LENGTH] * entry[WIDTH]
    direction, moving = (0.0, 0.0, 0.0, FIRST_LENGTH), 0
    nothing = np.empty((0, 0))
    none = nothing, nothing, nothing, nothing, (0, 0), (0, 0, 0, 0)
    if solutions[0].size:
        led = packed, direction, solutions, NEARLY_WHOLE, 0.0, 0.0, FIRST_SWEEPS, False, False
        step, direction = step_at(kernel, led)
        moving = step[2] + step[3]
    state[ROUNDS] += 1
    snap = 0.0 if state[LOAD_MISSED] else 0.01 * allowed * stiffness
    # The snap is divided by the number of nodes, so that its sum makes no difference.
    share = nodes
    if direction[0] < 0:
        convolve(packed, entry, block, moving, most, cells, state, table)
    minimum, nearly = np.inf, NEARLY_WHOLE
    while True:
        last = state[ITERATIONS] >= MAX_ITERATIONS
        sweeps = sweeps_of(state, block[2] * block[3])
        state[MOVES] += blended
        within = np.inf if last else goal
        edges_move = 0 < state[MOVES] <= MAX_MOVES
        # Where the check refused a last step once, the residual has waves too long for the model.
        finishing = state[ROUNDS] == 1 and not last
        stepped = packed, direction, none, nearly, snap / share, within, sweeps
        step, direction = step_at(kernel, (*stepped, edges_move, finishing))
        _, worst, free, bound, restarts, plain_steps, _ = step
        moving = free + bound
        if last or not worst > goal:
            break
        nearly = NEARLY_WHOLE_STALLED if worst > STALLED * minimum else NEARLY_WHOLE
        minimum = min(minimum, worst)
        share = max(bound, 1)
        state[RESTARTS] += restarts
        state[PLAIN_STEPS] += plain_steps
        if not direction[0] < 0 or (sweeps and state[ITERATIONS] >= MODELLED - 1):
            state[ITERATIONS] += 1
            break
        state[STUCK] = 0
        convolve(packed, entry, block, moving, most, cells, state, table)
    approach, worst, load_after = step[0], step[1], step[6]
    if not worst > goal:
        # A node that was put on a bound took its share of the load along. The last step or the free
        # nodes make up for it, or else the nodes that are nearest to moving.
        carried = load_after if load_after else carry_load(packed, approach)
        if abs(carried / limits.total - 1) <= 1e-13:
            return True, state[ROUNDS] > 1
        state[LOAD_MISSED] = 1
        settle_load(p, g, limits, 0.0)
        return False, state[ROUNDS] > 1
    descends = direction[0] < 0
    trace = 0.0
    if not descends:
        # No step descends, so a feasible restart replaces the pressures. Pressures of the order of
        # rounding errors can pass for free nodes and set the approach, so the projection becomes
        # the state.
        state[STUCK] += 1
        for k in range(nodes):
            p[k] += vectors[3, k]
            trace = max(trace, p[k])
    settle_load(p, g, limits, 1e-9 * trace)
    return False, not descends


@njit(cache=True, inner=True)
def transforms_for(table, reaches, rows, single):
    """Return the number of the entry of the transforms for nodes so far apart, 0 if none is there.

    `rows` is the number of rows of the block.
    """
    subcells = table[0, 1]
    length, width = _padded(reaches[0], subcells, False), _padded(reaches[1], subcells, True)
    place = find(table, length, width, np.int64(single))
    if place and has_plans(table[place], rows):
        table[place, USED] = table[0, 0]
        return place
    return 0


@njit(cache=True)
def converge(window, start, before, out, state, table, numbers, stencils, kernel, flags, real):
    """Iterate from a start until the contact conditions hold: see the module.

    Parameters
    ----------
    window : arrays
        Undeformed gap, and as it continues within cells.
    start : arrays
        Pressure, which becomes that of the solution, and its deflection where it is known.
    before : arrays and (row, column)
        Pressure and deflection of the previous position, and where its window begins in this one;
        arrays are empty where there is none.
    out : arrays
        Deflection of the solution, and its edges, empty where they are sharp.
    state : array
        State of the solve.
    table : array
        Transforms and far fields of the half-space: see `Kept`.
    numbers, stencils : tuples
        Hardness, sum of the pressures, tolerance, unit, stiffness of a node, levelled range and
        share of the edges, and the fields of Stencils.
    kernel : int
        Address of `iterate` of the solver, or 0.
    flags : tuple of bool
        Whether the start is close to the solution, and whether single precision may serve.
    real : array
        Empty array of the type of the transforms.

    Returns
    -------
    tuple
        Answer, approach, maximum deflection and maximum violation [m], and what is missing.
    """
    gap, shape = window
    p, u_given = start
    u_fresh, edge = out
    hardness, total, tolerance, unit, stiffness, levelled, share = numbers
    close, may_be_single = flags
    blended, subcells = edge.size > 0, table[0, 1]
    one = real.itemsize == 4
    double = np.empty(0)
    g, listed = np.empty(gap.shape), np.empty(gap.size, np.int64)
    nothing = np.empty((0, 0))
    rows, columns = gap.shape
    while True:
        if state[DEFLECTION] == UNKNOWN:
            reaches = reach(p)
            place = transforms_for(table, reaches, rows, False)
            if not place:
                return TRANSFORMS, 0.0, 0.0, 0.0, (reaches[0], reaches[1], np.int64(0), rows)
            values = block_of(table[place], rows, columns, double)
            load(p, values)
            apply_at(table[place, APPLY], (table[place], rows, columns, listed[:0]))
            read(values, unit, u_fresh)
            table[0, 0] += 1
            state[DEFLECTION] = FRESH
        fresh = state[DEFLECTION] == FRESH
        u = u_fresh if fresh else u_given
        leading = not fresh and before[0].size > 0
        if blended:
            if leading:
                extrapolate(u, before[1], before[2][0], before[2][1], g)
                cell_ranges(shape, g, levelled, share, edge)
            else:
                cell_ranges(shape, u, levelled, share, edge)
        approach, u_max, worst = state_of(
            gap.reshape(-1), u.reshape(-1), p.reshape(-1), edge.reshape(-1), hardness,
            g.reshape(-1), fresh,
        )
        none = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
        finite = np.isfinite(approach) and 0 < u_max < np.inf and not (fresh and worst == np.inf)
        if not finite:
            return NOT_FINITE, approach, u_max, worst, none
        allowed = tolerance * u_max
        if fresh and worst <= allowed:
            if state[CARRIED] or abs(sum_of(p.reshape(-1)) / total - 1) <= 1e-12:
                return SOLVED, approach, u_max, worst, none
        rounds = state[ROUNDS]
        if state[STUCK] > 1 or state[ITERATIONS] >= MAX_ITERATIONS or rounds > MAX_ITERATIONS:
            return SPENT, approach, u_max, worst, none
        near = (NEAR if close or rounds else np.inf) * u_max
        heights = approach - REST * near, approach + near
        resting, count, row, column, block_rows, block_columns = candidates(
            p, g, hardness, heights[0], heights[1], blended, subcells, listed
        )
        block = row, column, block_rows, block_columns
        # Where a descent went as far as it could and left no new candidates, single precision does
        # not suffice.
        single = may_be_single and tolerance >= SINGLE_TOLERANCE
        if state[EXHAUSTED] and count <= state[CANDIDATES]:
            single = single and blended and rounds <= 4
        if single != one:
            return PRECISION, approach, u_max, worst, none
        if not kernel:
            return KERNEL, approach, u_max, worst, none
        reaches = block_rows - 1, block_columns - 1
        place = transforms_for(table, reaches, block_rows, single)
        missing = reaches[0], reaches[1], np.int64(single), block_rows
        if not place:
            return TRANSFORMS, approach, u_max, worst, missing
        if table[place, INFLUENCE_SIZE] < 0:
            return INFLUENCES, approach, u_max, worst, missing
        coarse = _coarse_grid(block_rows + 2 * BORDER, block_columns + 2 * BORDER)
        far = find(table, coarse[0], coarse[1], -coarse[2])
        if not far:
            return FAR_FIELD, approach, u_max, worst, (coarse[0], coarse[1], coarse[2], np.int64(0))
        table[far, USED] = table[0, 0]
        node, entry, cells = listed[:count], table[place], listed[:0]
        if subcells > 1:
            across = block_columns // subcells
            seen = np.zeros(block_rows // subcells * across, np.uint8)
            cells = np.empty(count, np.int64)
            count_cells = cells_of(node, columns, (row, column), across, subcells, seen, cells)
            cells = cells[:count_cells]
        fields = p, g, edge, shape, gap
        at_rest = resting * hardness if resting else 0.0
        packed = pack(
            fields, node, at_rest, block, numbers, stencils, u_max, entry, table[far], real
        )
        first = AIM_FIRST_LED if blended and subcells == 1 else AIM_FIRST
        goal = (AIM if rounds else first) * allowed
        solutions = nothing, nothing, nothing, nothing, (0, 0), block
        if leading:
            solutions = p, u, before[0], before[1], before[2], block
        state[CARRIED], state[EXHAUSTED] = descend(
            packed, entry, block, cells, solutions, goal, allowed, single, state, table, kernel
        )
        state[CANDIDATES] = count
        for a in range(count):
            p.reshape(-1)[node[a]] = packed[0][0, a]
        state[DEFLECTION] = UNKNOWN
