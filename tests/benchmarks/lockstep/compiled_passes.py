"""Compiled passes over the pieces of a batch in lockstep, by the kernels of the program.

They take the steps of a march and of `descend`, cut at its convolutions, on sharp edges. Each call
passes over all pieces without the lock of Python, so that two batches in two threads take two
cores.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np

from acoustics.arrays import Array
from rolling.contact import _descent_kernels as descents
from rolling.contact import _solver_kernels as kernels
from rolling.contact import _system as parts
from rolling.contact._candidate_kernels import candidates, list_strips, take_nodes
from rolling.contact._condition_kernels import project, settle_load, state_of, sum_of
from rolling.contact._linked import reference
from rolling.contact._position_kernels import measure
from rolling.contact._system import BORDER, OWN_COEFFICIENT, Direction, Limits, Rules, Solutions
from rolling.contact._window_kernels import (
    copy_block,
    loaded_range,
    overlap,
    reach,
    undeformed_gap,
)
from rolling.contact.compiling import inlined
from rolling.contact.march import ROOM
from rolling.contact.solver import AIM, AIM_FIRST, NEAR, REST

# kernels that the passes call by their symbols, which must be known first
LINKED = (kernels.iterate, project, settle_load, list_strips, state_of, loaded_range)
# columns of the numbers of pieces
(SLOPE, LONGEST, ZR, LENGTH, NEARLY, MINIMUM, SHARE, GOAL, TOTAL) = range(9)
(APPROACH, APPROACH_BEFORE, APPROACH_ALLOWED, U_MAX, SPREAD, SPREAD_ALLOWED) = range(9, 15)
NUMBERS = 15
# columns of their counts
(NODES, STRIPS, ITERATIONS, CONVOLUTIONS, DESCENTS, STUCK) = range(6)
(DESCENDS, ACCEPTED, CARRIED, MISSED, END, POSITION, OUTSIDE) = range(6, 13)
COUNTS = 13


class Frames(NamedTuple):
    """State of the pieces on their frames (k, rows, columns), and the two states before."""

    p: Array
    u: Array
    gap: Array
    deformed: Array
    p_last: Array
    u_last: Array
    p_before: Array
    u_before: Array


class Memory(NamedTuple):
    """Vectors of candidates and grids of the pieces; see `system_of` of the descent."""

    listed: Array  # (k, nodes)
    vectors: Array  # (k, 6, nodes)
    image: Array  # (k, nodes)
    indices: Array  # (k, 4, nodes)
    at: Array  # (2, k, nodes) row and column in the block
    residuals: Array  # (k, places)
    grids: Array  # (k, 6, places)
    coarse: Array  # (k, 7, coarse places)
    strips: Array  # (k, strips, 2)


class Tables(NamedTuple):
    """What the descents on a block of some size have in common, and the lift of each piece."""

    unit: float  # deflection per pressure and coefficient [m/Pa], then fields of Stencils
    preconditioner: Array
    inverse: Array
    centre: float
    own: float
    common: float
    coefficients: Array  # by distance
    far_table: Array
    tile: int  # nodes from a coarse node to the next
    length: int  # of a row of the coarse grid
    coarse_size: int
    lift: Array  # (k,) violation that counts for a missing sum of pressures [m/Pa]


@inlined()
def grid_of(memory, rows, columns):
    """Return the first numbers of flat memory as an array (rows, columns)."""
    return memory[: rows * columns].reshape(rows, columns)


@inlined()
def system_of_piece(i, memory, tables, block, nodes, limits, strip_count):
    """Return the System of a piece, as `system_of` of the descent makes it."""
    rows = block[0] + 2 * BORDER
    columns = block[1] + 2 * BORDER
    v = memory.vectors[i]
    index = memory.indices[i]
    places = rows * columns
    softening = memory.grids[i, 0][:0].reshape(0, columns)
    nothing = v[0][:0]
    c = memory.coarse[i]
    return parts.System(
        parts.Nodes(v[0][:nodes], v[1][:nodes], nothing, nothing),
        parts.Transform(memory.image[i], index[1][:nodes], tables.unit),
        parts.Stencil(
            tables.preconditioner,
            memory.residuals[i][:places],
            index[2][:nodes],
            columns,
            1 / (tables.unit * OWN_COEFFICIENT),
        ),
        parts.Work(v[2][:nodes], v[3][:nodes], v[4][:nodes], v[5][:nodes], index[0][:nodes]),
        limits,
        parts.Edges(nothing, nothing, nothing, 0.0, 0.0),
        parts.Model(
            tables.inverse,
            grid_of(memory.grids[i, 0], rows, columns),
            grid_of(memory.grids[i, 1], rows, columns),
            grid_of(memory.grids[i, 2], rows, columns),
            grid_of(memory.grids[i, 3], rows, columns),
            grid_of(memory.grids[i, 4], rows, columns),
            grid_of(memory.grids[i, 5], rows, columns),
            softening,
            index[2][:nodes],
            memory.strips[i][:strip_count],
            tables.centre,
            tables.lift[i],
        ),
        parts.FarField(
            tables.tile,
            tables.length,
            tables.own,
            tables.common,
            tables.far_table,
            c[0][: tables.coarse_size],
            c[1][: tables.coarse_size],
            c[2][: tables.coarse_size],
            c[3][: tables.coarse_size],
            c[4][: tables.coarse_size],
            c[5][: tables.coarse_size],
            c[6][: tables.coarse_size],
        ),
        # no direct sums: contacts as light as these have too many candidates for their block
        parts.Influence(tables.coefficients, index[3][:nodes], tables.coefficients[:0]),
    )


@inlined()
def around(window, other):
    """Return the minimum window around two windows; one without rows is no window."""
    if other[2] == 0:
        return window
    row = min(window[0], other[0])
    column = min(window[1], other[1])
    end = max(window[0] + window[2], other[0] + other[2])
    right = max(window[1] + window[3], other[1] + other[3])
    return row, column, end - row, right - column


@numba.njit(nogil=True)
def find_windows(surface, sphere, load, numbers, counts, windows):
    """Find the windows (k, 4) of the next position, as a march does.

    `surface` are the heights and their maxima, `sphere` has spacing, radii, start, step and place
    across, and `load` the minimum deflection times length by the load [m2].
    """
    _, maxima = surface
    spacing, radius, radius_across, start, step, y = sphere
    for i in range(counts.shape[0]):
        k = counts[i, POSITION] + 1
        rise = abs(numbers[i, APPROACH] - numbers[i, APPROACH_BEFORE])
        approach = numbers[i, APPROACH] + min(4 * rise, 0.1 * numbers[i, U_MAX])
        spread = ROOM * numbers[i, SPREAD]
        least = load, spread * spread
        window = (windows[i, 0], windows[i, 1], windows[i, 2], windows[i, 3])
        for position in (k, k + 1):
            place = spacing, radius, radius_across, start + position * step, y
            window = around(window, overlap(maxima, place, approach, least, False))
        windows[i, 0] = window[0] - 1
        windows[i, 1] = window[1] - 1
        windows[i, 2] = window[2] + 2
        windows[i, 3] = window[3] + 2
        numbers[i, APPROACH_ALLOWED] = approach
        numbers[i, SPREAD_ALLOWED] = spread


@numba.njit(nogil=True)
def sharp_state(frames, i, hardness, fresh):
    """Return approach, maximum deflection and violation of a piece with sharp edges."""
    pressure = frames.p[i].reshape(-1)
    gap = frames.gap[i].reshape(-1)
    deflection = frames.u[i].reshape(-1)
    deformed = frames.deformed[i].reshape(-1)
    no_edge = pressure[:0]
    return state_of(gap, deflection, pressure, no_edge, hardness, deformed, fresh)


@numba.njit(nogil=True)
def move(frames, surface, sphere, corners, hardness, numbers, counts):
    """Move on by a node to new windows, with the pressures left on the plate; judge the states.

    `corners` (3, k, 2) are the first rows and columns of the windows now, and of the two before.
    """
    heights, _ = surface
    spacing, radius, radius_across, start, step, y = sphere
    for i in range(frames.p.shape[0]):
        counts[i, POSITION] += 1
        row = corners[1, i, 0] - corners[0, i, 0]
        column = corners[1, i, 1] - corners[0, i, 1]
        copy_block(frames.p_last[i], frames.p[i], row, column, False)
        copy_block(frames.u_last[i], frames.u[i], row, column, True)
        place = spacing, radius, radius_across, start + counts[i, POSITION] * step, y
        undeformed_gap(heights, place, corners[0, i, 0], corners[0, i, 1], frames.gap[i])
        numbers[i, APPROACH_BEFORE] = numbers[i, APPROACH]
        approach, u_max, _ = sharp_state(frames, i, hardness, False)
        numbers[i, APPROACH] = approach
        numbers[i, U_MAX] = u_max
        for column in (ACCEPTED, DESCENTS, STUCK, MISSED, CARRIED):
            counts[i, column] = 0


@numba.njit(nogil=True)
def farthest(pressure, counts):
    """Return the farthest distances of a loaded node from a node of its window, of all pieces."""
    rows = 0
    columns = 0
    for i in range(pressure.shape[0]):
        if not counts[i, ACCEPTED]:
            along, across = reach(pressure[i])
            rows = max(rows, along)
            columns = max(columns, across)
    return rows, columns


@numba.njit(nogil=True)
def list_nodes(frames, listed, hardness, total, numbers, counts, block):
    """List the candidates of the pieces that are not accepted, and the `block` (k, 4) of each."""
    p = frames[0]
    deformed = frames[3]
    for i in range(p.shape[0]):
        block[i] = 0
        if counts[i, ACCEPTED]:
            continue
        near = NEAR * numbers[i, U_MAX]
        approach = numbers[i, APPROACH]
        low = approach - REST * near
        high = approach + near
        rest, nodes, row, column, rows, columns = candidates(
            p[i], deformed[i], hardness, low, high, False, 1, listed[i]
        )
        numbers[i, TOTAL] = total - rest * hardness
        counts[i, NODES] = nodes
        block[i, 0] = row
        block[i, 1] = column
        block[i, 2] = rows
        block[i, 3] = columns


@numba.njit(nogil=True)
def lead(frames, memory, tables, block, corners, blocks, limits, numbers, counts):
    """Take the candidates of the pieces, and find their first directions.

    `block` has the rows and columns that all blocks get, the row length of the coefficients, and
    that of the present solver's transforms with their rows side by side, or 0 where k transforms
    are in one plan. `blocks` (k, 4) are those of the candidates, and `limits` hardness and
    tolerance.
    """
    hardness, tolerance = limits
    for i in range(frames.p.shape[0]):
        counts[i, DESCENDS] = 0
        if counts[i, ACCEPTED]:
            continue
        rows = block[0] + 2 * BORDER
        columns = block[1] + 2 * BORDER
        row = min(blocks[i, 0], frames.p.shape[1] - block[0])
        column = min(blocks[i, 1], frames.p.shape[2] - block[1])
        nodes = counts[i, NODES]
        own = memory.listed[i][:nodes]
        width = frames.p.shape[2]
        for line in range(2, 6):
            memory.vectors[i, line][:nodes] = 0.0
        memory.residuals[i][: rows * columns] = 0.0
        for grid in range(2, 6):
            memory.grids[i, grid][: rows * columns] = 0.0
        memory.coarse[i].reshape(-1)[:] = 0.0
        lengths = (block[3], block[4]), columns, block[2]
        state = (frames.p[i].reshape(-1), frames.deformed[i].reshape(-1))
        out = (memory.vectors[i], memory.indices[i], memory.strips[i])
        counts[i, STRIPS] = take_nodes(own, width, (row, column), lengths, rows, state, out)
        for a in range(nodes if block[3] == 0 else 0):
            memory.indices[i, 1, a] = a
            memory.at[0, i, a] = own[a] // width - row
            memory.at[1, i, a] = own[a] % width - column
        first = counts[i, DESCENTS] == 0
        allowed = tolerance * numbers[i, U_MAX]
        numbers[i, GOAL] = (AIM_FIRST if first else AIM) * allowed
        numbers[i, NEARLY] = descents.NEARLY_WHOLE
        numbers[i, MINIMUM] = np.inf
        numbers[i, SHARE] = nodes
        direction = Direction(0.0, 0.0, 0.0, kernels.FIRST_LENGTH)
        if first:
            counts[i, ITERATIONS] = 0
            limits = Limits(hardness, numbers[i, TOTAL])
            system = reference(
                system_of_piece(i, memory, tables, block, nodes, limits, counts[i, STRIPS])
            )
            here = (row, column, block[0], block[1])
            back = corners[2, i, 0] - corners[0, i, 0]
            aside = corners[2, i, 1] - corners[0, i, 1]
            solutions = Solutions(
                frames.p[i], frames.u[i], frames.p_before[i], frames.u_before[i], back, aside, here
            )
            no = not first
            rules = Rules(descents.NEARLY_WHOLE, 0.0, 0.0, np.int64(descents.FIRST_SWEEPS), no, no)
            _, direction = kernels.iterate(system, direction, solutions, rules)
        counts[i, DESCENTS] += 1
        counts[i, DESCENDS] = 1
        counts[i, END] = counts[i, ITERATIONS] + descents.LONGEST
        if direction.slope < 0.0:
            counts[i, ITERATIONS] += 1
        numbers[i, SLOPE] = direction.slope
        numbers[i, LONGEST] = direction.longest
        numbers[i, ZR] = direction.zr
        numbers[i, LENGTH] = direction.length


@numba.njit(nogil=True)
def step_and_turn(frames, memory, tables, block, hardness, tolerance, numbers, counts):
    """Step along the directions and find the next, as an iteration of `descend` does.

    The pressures of a piece whose descent ends go back to its frame.
    """
    for i in range(frames.p.shape[0]):
        if not counts[i, DESCENDS]:
            continue
        nodes = counts[i, NODES]
        limits = Limits(hardness, numbers[i, TOTAL])
        system = reference(
            system_of_piece(i, memory, tables, block, nodes, limits, counts[i, STRIPS])
        )
        nothing = frames.p_before[i][:0]
        none = Solutions(nothing, nothing, nothing, nothing, 0, 0, (0, 0, block[0], block[1]))
        direction = Direction(
            numbers[i, SLOPE], numbers[i, LONGEST], numbers[i, ZR], numbers[i, LENGTH]
        )
        iterations = counts[i, ITERATIONS]
        last = iterations >= descents.MAX_ITERATIONS
        sweeps = descents.sweeps_of(iterations, counts[i, STUCK], block[0] * block[1])
        goal = numbers[i, GOAL]
        within = np.inf if last else goal
        finishing = counts[i, DESCENTS] == 1 and not last
        allowed = tolerance * numbers[i, U_MAX]
        snap = 0.0 if counts[i, MISSED] else 0.01 * allowed * system.stencil.stiffness
        no = nodes < 0
        rules = Rules(numbers[i, NEARLY], snap / numbers[i, SHARE], within, sweeps, no, finishing)
        step, direction = kernels.iterate(system, direction, none, rules)
        worst = step.worst
        going = not (last or not worst > goal)
        if going:
            stalled = worst > descents.STALLED * numbers[i, MINIMUM]
            numbers[i, NEARLY] = descents.NEARLY_WHOLE_STALLED if stalled else descents.NEARLY_WHOLE
            numbers[i, MINIMUM] = min(numbers[i, MINIMUM], worst)
            numbers[i, SHARE] = max(step.bound, 1)
            model_ends = sweeps and iterations >= descents.MODELLED - 1
            going = not (not direction.slope < 0 or model_ends or iterations >= counts[i, END])
            counts[i, ITERATIONS] += 1
        numbers[i, SLOPE] = direction.slope
        numbers[i, LONGEST] = direction.longest
        numbers[i, ZR] = direction.zr
        numbers[i, LENGTH] = direction.length
        if going:
            counts[i, STUCK] = 0
            continue
        counts[i, DESCENDS] = 0
        carried = False
        if not worst > goal:
            carried = descents.carry(system, step)
            counts[i, MISSED] = counts[i, MISSED] or not carried
        elif not direction.slope < 0:
            counts[i, STUCK] += 1
            descents.restart(system)
        else:
            settle_load(system.nodes.p, system.nodes.g, system.limits, 0.0)
        counts[i, CARRIED] = carried
        pressures = frames.p[i].reshape(-1)
        for a in range(nodes):
            pressures[memory.listed[i, a]] = system.nodes.p[a]


@numba.njit(nogil=True)
def judge_and_measure(frames, surface, sphere, corners, limits, numbers, counts, windows):
    """Judge fresh deflections, and measure the states that are accepted.

    `limits` are hardness, sum of pressures, tolerance, and minimum deflection times length by the
    load. `windows` (k, 4) are set to the blocks of the loaded nodes. States that a march would
    solve again on a wider window are counted.
    """
    hardness, total, tolerance, load = limits
    _, maxima = surface
    spacing, radius, radius_across, start, step, y = sphere
    for i in range(frames.p.shape[0]):
        if counts[i, ACCEPTED]:
            continue
        line = frames.p[i].reshape(-1)
        approach, u_max, worst = sharp_state(frames, i, hardness, True)
        numbers[i, APPROACH] = approach
        numbers[i, U_MAX] = u_max
        counts[i, CONVOLUTIONS] += 1
        carries = counts[i, CARRIED] or abs(sum_of(line) / total - 1) <= 1e-12
        if not (worst <= tolerance * u_max and carries):
            continue
        counts[i, ACCEPTED] = 1
        k = counts[i, POSITION]
        place = spacing, radius, radius_across, start + k * step, y
        loaded, (_, _, _, _, spread) = measure(
            (frames.p[i], frames.u[i], frames.p[i][:0]),
            (hardness, 0.0),
            place,
            maxima[3],
            approach,
            False,
            (corners[0, i, 0], corners[0, i, 1]),
        )
        for column in range(4):
            windows[i, column] = loaded[column]
        numbers[i, SPREAD] = spread
        beyond = spread > numbers[i, SPREAD_ALLOWED] or approach > numbers[i, APPROACH_ALLOWED]
        if beyond:
            own = corners[0, i, 0], corners[0, i, 1], frames.p.shape[1], frames.p.shape[2]
            least = load, spread * spread
            wider = around(own, overlap(maxima, place, approach, least, False))
            counts[i, OUTSIDE] += wider[2] > own[2] or wider[3] > own[3]
