"""A batch of pieces in lockstep on processors, by the kernels of the program.

Each method of the batch is one compiled call or two, which pass over the pieces without the lock of
Python, so that two batches in two threads take two cores. It takes the steps of `descend`, cut at
its convolutions, on sharp edges.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numba
import numpy as np
from lockstep.batch_transforms import BatchTransforms

from acoustics.arrays import Array
from rolling.contact import _descent_kernels as descents
from rolling.contact import _solver_kernels as kernels
from rolling.contact import _system as parts
from rolling.contact._candidate_kernels import STRIP, candidates, list_strips, take_nodes
from rolling.contact._condition_kernels import project, settle_load, state_of, sum_of
from rolling.contact._far_field import coarse_grid, far_field, stencils
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
from rolling.contact.half_space import GROUP, HalfSpace, padded_length
from rolling.contact.march import ROOM
from rolling.contact.solver import AIM, AIM_FIRST, NEAR, REST
from rolling.contact.state import SURE, ContactState, RollingContact

_LINKED = (kernels.iterate, project, settle_load, list_strips, state_of, loaded_range)
_NOTHING = np.empty(0)
_NO_FIELD = np.empty((0, 0))
# columns of the numbers of pieces
(SLOPE, LONGEST, ZR, LENGTH, NEARLY, MINIMUM, SHARE, GOAL, TOTAL) = range(9)
(APPROACH, APPROACH_BEFORE, APPROACH_ALLOWED, U_MAX, SPREAD, SPREAD_ALLOWED) = range(9, 15)
NUMBERS = 15
# columns of their counts
(NODES, STRIPS, ROW, COLUMN, ITERATIONS, CONVOLUTIONS, DESCENTS, STUCK) = range(8)
(DESCENDS, ACCEPTED, CARRIED, MISSED, END, POSITION, OUTSIDE) = range(8, 15)
COUNTS = 15


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


@inlined()
def grid_of(memory, rows, columns):
    """Return the first numbers of flat memory as an array (rows, columns)."""
    return memory[: rows * columns].reshape(rows, columns)


@inlined()
def system_of_piece(i, memory, tables, block, nodes, limits, strips):
    """Return the System of a piece, as `system_of` of the descent makes it."""
    listed, vectors, image, indices, at, residuals, grids, coarse, all_strips = memory
    (unit, preconditioner, inverse, centre, own, common, coefficients, far_table, far, lift) = tables
    tile, length, coarse_size = far
    rows = block[0] + 2 * BORDER
    columns = block[1] + 2 * BORDER
    v = vectors[i]
    index = indices[i]
    places = rows * columns
    softening = grids[i, 0][:0].reshape(0, columns)
    nothing = v[0][:0]
    c = coarse[i]
    return parts.System(
        parts.Nodes(v[0][:nodes], v[1][:nodes], nothing, nothing),
        parts.Transform(image[i][:nodes], index[1][:nodes], unit),
        parts.Stencil(
            preconditioner,
            residuals[i][:places],
            index[2][:nodes],
            columns,
            1 / (unit * OWN_COEFFICIENT),
        ),
        parts.Work(
            v[2][:nodes], v[3][:nodes], v[4][:nodes], v[5][:nodes], index[0][:nodes]
        ),
        limits,
        parts.Edges(nothing, nothing, nothing, 0.0, 0.0),
        parts.Model(
            inverse,
            grid_of(grids[i, 0], rows, columns),
            grid_of(grids[i, 1], rows, columns),
            grid_of(grids[i, 2], rows, columns),
            grid_of(grids[i, 3], rows, columns),
            grid_of(grids[i, 4], rows, columns),
            grid_of(grids[i, 5], rows, columns),
            softening,
            index[2][:nodes],
            all_strips[i][:strips],
            centre,
            lift[i],
        ),
        parts.FarField(
            tile,
            length,
            own,
            common,
            far_table,
            c[0][:coarse_size],
            c[1][:coarse_size],
            c[2][:coarse_size],
            c[3][:coarse_size],
            c[4][:coarse_size],
            c[5][:coarse_size],
            c[6][:coarse_size],
        ),
        parts.Influence(coefficients, index[3][:nodes]),
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
def move(frames, surface, sphere, corners, hardness, numbers, counts):
    """Move on by a node to new windows, with the pressures left on the plate; judge the states.

    `corners` (3, k, 2) are the first rows and columns of the windows now, and of the two before.
    """
    p, u, gap, deformed, p_last, u_last, _, _ = frames
    heights, _ = surface
    spacing, radius, radius_across, start, step, y = sphere
    for i in range(p.shape[0]):
        counts[i, POSITION] += 1
        row = corners[1, i, 0] - corners[0, i, 0]
        column = corners[1, i, 1] - corners[0, i, 1]
        copy_block(p_last[i], p[i], row, column, False)
        copy_block(u_last[i], u[i], row, column, True)
        place = spacing, radius, radius_across, start + counts[i, POSITION] * step, y
        undeformed_gap(heights, place, corners[0, i, 0], corners[0, i, 1], gap[i])
        line = p[i].reshape(-1)
        numbers[i, APPROACH_BEFORE] = numbers[i, APPROACH]
        approach, u_max, _ = state_of(
            gap[i].reshape(-1),
            u[i].reshape(-1),
            line,
            line[:0],
            hardness,
            deformed[i].reshape(-1),
            False,
        )
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

    `block` is the size that all blocks get and the row length of the coefficients, `blocks` (k, 4)
    those of the candidates, and `limits` hardness and tolerance.
    """
    hardness, tolerance = limits
    p, u, _, deformed, _, _, p_before, u_before = frames
    listed, vectors, image, indices, at, residuals, grids, coarse, strips = memory
    for i in range(p.shape[0]):
        counts[i, DESCENDS] = 0
        if counts[i, ACCEPTED]:
            continue
        rows = block[0] + 2 * BORDER
        columns = block[1] + 2 * BORDER
        row = min(blocks[i, 0], p.shape[1] - block[0])
        column = min(blocks[i, 1], p.shape[2] - block[1])
        counts[i, ROW] = row
        counts[i, COLUMN] = column
        nodes = counts[i, NODES]
        own = listed[i][:nodes]
        width = p.shape[2]
        vectors[i, 2:6, :nodes] = 0.0
        residuals[i, : rows * columns] = 0.0
        grids[i, 2:6, : rows * columns] = 0.0
        coarse[i] = 0.0
        lengths = (columns, 1), columns, block[2]
        state = (p[i].reshape(-1), deformed[i].reshape(-1))
        out = (vectors[i], indices[i], strips[i])
        counts[i, STRIPS] = take_nodes(own, width, (row, column), lengths, rows, state, out)
        for a in range(nodes):
            indices[i, 1, a] = a
            at[0, i, a] = own[a] // width - row
            at[1, i, a] = own[a] % width - column
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
            solutions = Solutions(p[i], u[i], p_before[i], u_before[i], back, aside, here)
            no = not first
            rules = Rules(descents.NEARLY_WHOLE, 0.0, 0.0, np.int64(descents.FIRST_SWEEPS), no, no)
            step, direction = kernels.iterate(system, direction, solutions, rules)
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
    p, u, _, _, _, _, p_before, u_before = frames
    listed, vectors, image, indices, at, residuals, grids, coarse, strips = memory
    for i in range(p.shape[0]):
        if not counts[i, DESCENDS]:
            continue
        nodes = counts[i, NODES]
        limits = Limits(hardness, numbers[i, TOTAL])
        system = reference(
            system_of_piece(i, memory, tables, block, nodes, limits, counts[i, STRIPS])
        )
        nothing = p_before[i][:0]
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
        rules = Rules(
            numbers[i, NEARLY], snap / numbers[i, SHARE], within, sweeps, no, finishing
        )
        step, direction = kernels.iterate(system, direction, none, rules)
        worst = step.worst
        going = not (last or not worst > goal)
        if going:
            stalled = worst > descents.STALLED * numbers[i, MINIMUM]
            numbers[i, NEARLY] = (
                descents.NEARLY_WHOLE_STALLED if stalled else descents.NEARLY_WHOLE
            )
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
        pressures = p[i].reshape(-1)
        for a in range(nodes):
            pressures[listed[i, a]] = system.nodes.p[a]


@numba.njit(nogil=True)
def judge_and_measure(frames, surface, sphere, corners, limits, numbers, counts, windows):
    """Judge fresh deflections, and measure the states that are accepted.

    `limits` are hardness, sum of pressures, tolerance, and minimum deflection times length by the
    load. `windows` (k, 4) are set to the blocks of the loaded nodes. States that a march would
    solve again on a wider window are counted.
    """
    p, u, gap, deformed, _, _, _, _ = frames
    hardness, total, tolerance, load = limits
    _, maxima = surface
    spacing, radius, radius_across, start, step, y = sphere
    for i in range(p.shape[0]):
        if counts[i, ACCEPTED]:
            continue
        line = p[i].reshape(-1)
        approach, u_max, worst = state_of(
            gap[i].reshape(-1),
            u[i].reshape(-1),
            line,
            line[:0],
            hardness,
            deformed[i].reshape(-1),
            True,
        )
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
            (p[i], u[i], p[i][:0]),
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
            own = corners[0, i, 0], corners[0, i, 1], p.shape[1], p.shape[2]
            least = load, spread * spread
            wider = around(own, overlap(maxima, place, approach, least, False))
            counts[i, OUTSIDE] += wider[2] > own[2] or wider[3] > own[3]


@lru_cache(maxsize=None)
def _transforms_of(*size: Any) -> BatchTransforms:
    """Return transforms by the arguments of BatchTransforms and a number; they are made once.

    Batches of the same number share their work arrays, so that they must take turns.
    """
    return BatchTransforms(*size[:-1])


class CompiledBatch:
    """A batch of pieces in lockstep on a processor (see `interface.Batch`).

    All windows of a position have the same size, and so have the blocks of candidates.

    Parameters
    ----------
    contact : RollingContact
        Contact with sharp edges on whole cells, with steps of a node.
    half_space : HalfSpace
        Its half-space.
    states : list of (ContactState, ContactState)
        The first two states of each piece.
    number : int
        Batches of other numbers may march at the same time in other threads.

    Attributes
    ----------
    numbers, counts : (k, ...) arrays
        Numbers and counts of the pieces.
    frames : Frames
        State of the pieces.
    corners : (3, k, 2) array
        First rows and columns of the windows now, and at the two positions before.
    rounds : int
        Rounds of transforms in single precision so far, for all pieces together.
    """

    def __init__(
        self,
        contact: RollingContact,
        half_space: HalfSpace,
        states: list[tuple[ContactState, ContactState]],
        number: int = 0,
    ) -> None:
        self._number = number
        for kernel in _LINKED:
            kernel.link()
        self.contact = contact
        self.half_space = half_space
        pieces = len(states)
        self.numbers = np.zeros((pieces, NUMBERS))
        self.counts = np.zeros((pieces, COUNTS), np.int64)
        self.corners = np.zeros((3, pieces, 2), np.int64)
        self.rounds = 0
        self._windows = np.zeros((pieces, 4), np.int64)
        self._blocks = np.zeros((pieces, 4), np.int64)
        self.block = (0, 0, 0)
        self._tables: tuple[Any, ...] = ()
        self._made: dict[tuple[int, ...], Any] = {}
        befores, lasts = zip(*states, strict=True)
        nothing = np.zeros((pieces, 0, 0))
        self.frames = Frames(
            *self._side_by_side(lasts, 0),
            nothing,
            nothing,
            *self._side_by_side(befores, 1),
            nothing,
            nothing,
        )
        for i, (before, last) in enumerate(states):
            self.counts[i, POSITION] = last.position
            self._windows[i] = last.loaded
            self.numbers[i, APPROACH_BEFORE] = before.approach
            self.numbers[i, APPROACH] = last.approach
            self.numbers[i, U_MAX] = last.max_deflection
            self.numbers[i, SPREAD] = last.spread
        self.memory = self._memory_for(*self.frames.p.shape[1:])
        geometry = contact.geometry
        place = geometry.sphere(0)
        self._sphere = (*place[:4], float(contact.step), place[4])
        self._surface = contact.heights, geometry.maxima
        self._least = SURE * contact.load / geometry.pi_modulus
        self._total = float(contact.load / contact.spacing**2)

    def _side_by_side(self, states: tuple[ContactState, ...], age: int) -> tuple[Array, Array]:
        """Return pressures and deflections on windows of the same size, and set their corners."""
        rows = max(state.window.rows for state in states)
        columns = max(state.window.columns for state in states)
        p = np.zeros((len(states), rows, columns))
        u = np.zeros(p.shape)
        for i, state in enumerate(states):
            window = state.window._replace(rows=rows, columns=columns)
            state.window.move(state.pressure, window, p[i])
            state.window.move(state.deflection, window, u[i], continued=True)
            self.corners[age, i] = window[:2]
        return p, u

    def _memory_for(self, rows: int, columns: int) -> Memory:
        """Return memory for windows of up to so many rows and columns."""
        pieces = len(self.counts)
        nodes = rows * columns
        places = (rows + 2 * BORDER) * (columns + 2 * BORDER)
        coarse_rows, coarse_columns, _ = coarse_grid(rows + 2 * BORDER, columns + 2 * BORDER)
        return Memory(
            listed=np.zeros((pieces, nodes), np.int64),
            vectors=np.zeros((pieces, 6, nodes)),
            image=np.zeros((pieces, nodes)),
            indices=np.zeros((pieces, 4, nodes), np.uint32),
            at=np.zeros((2, pieces, nodes), np.int64),
            residuals=np.zeros((pieces, places)),
            grids=np.zeros((pieces, 6, places), np.float32),
            coarse=np.zeros((pieces, 7, 2 * coarse_rows * coarse_columns), np.float32),
            strips=np.zeros((pieces, places // STRIP + 1, 2), np.uint64),
        )

    def move_on(self) -> None:
        """Move all pieces to their next position."""
        find_windows(
            self._surface, self._sphere, self._least, self.numbers, self.counts, self._windows
        )
        rows, columns = (int(most) for most in self._windows[:, 2:].max(axis=0))
        self.corners[2] = self.corners[1]
        self.corners[1] = self.corners[0]
        self.corners[0] = self._windows[:, :2]
        f = self.frames
        shape = (len(self.counts), rows, columns)
        self.frames = Frames(
            p=np.empty(shape),
            u=np.empty(shape),
            gap=np.empty(shape),
            deformed=np.empty(shape),
            p_last=f.p,
            u_last=f.u,
            p_before=f.p_last,
            u_before=f.u_last,
        )
        if rows * columns > self.memory.listed.shape[1]:
            self.memory = self._memory_for(rows + 8, columns + 8)
        hardness = float(self.contact.hardness)
        move(
            self.frames,
            self._surface,
            self._sphere,
            self.corners,
            hardness,
            self.numbers,
            self.counts,
        )

    def begin(self) -> None:
        """Begin a descent of the pieces that are not accepted, on blocks of the same size."""
        hardness = float(self.contact.hardness)
        list_nodes(
            self.frames,
            self.memory.listed,
            hardness,
            self._total,
            self.numbers,
            self.counts,
            self._blocks,
        )
        rows, columns = (int(most) for most in self._blocks[:, 2:].max(axis=0))
        self._tables, influence_row = self._tables_of(rows, columns)
        self.block = (rows, columns, influence_row)
        lead(
            self.frames,
            self.memory,
            self._tables,
            self.block,
            self.corners,
            self._blocks,
            (hardness, float(self.contact.tolerance)),
            self.numbers,
            self.counts,
        )

    def _tables_of(self, rows: int, columns: int) -> tuple[tuple[Any, ...], int]:
        """Return the tables of a block for `system_of_piece`, and a row of its coefficients."""
        key = (rows, columns)
        if key not in self._made:
            transforms = self.half_space.convolution(rows - 1, columns - 1, single=True)
            across = transforms.real.shape[1]
            coarse_rows, coarse_columns, tile = coarse_grid(rows + 2 * BORDER, columns + 2 * BORDER)
            row_length = 2 * coarse_columns - 1
            self._made[key] = (
                (
                    self.half_space.unit,
                    *stencils(self.half_space.unit),
                    transforms.influence(),
                    far_field(coarse_rows, coarse_columns, tile),
                    (tile, row_length, coarse_rows * row_length),
                ),
                2 * (across // 2) + 1,
            )
        tables, influence_row = self._made[key]
        return (*tables, self.numbers[:, U_MAX] / self._total), influence_row

    def _slots(self, pieces: Array) -> Array:
        """Return the pieces (2 pairs,) that the transforms of some pieces take, -1 none."""
        slots = np.full(2 * (-(-len(pieces) // 2)), -1)
        slots[: len(pieces)] = pieces
        return slots

    def _transforms(
        self, apart: tuple[int, int], rows: int, pairs: int, single: bool
    ) -> BatchTransforms:
        """Return the transforms of so many rows of nodes so far apart, which are made once."""
        m = padded_length(apart[0])
        n = padded_length(apart[1], across=True)
        lines = min(m, rows + -rows % GROUP)
        own = self._number
        return _transforms_of(m, n, lines, pairs, self.half_space.unit, single, own)

    def convolve(self) -> None:
        """Compute the deflection by the directions of all pieces that have one."""
        has_direction = (self.counts[:, DESCENDS] > 0) & (self.numbers[:, SLOPE] < 0)
        pieces = np.flatnonzero(has_direction)
        if not pieces.size:
            return
        slots = self._slots(pieces)
        rows, columns, _ = self.block
        made = self._transforms((rows - 1, columns - 1), rows, slots.size // 2, True)
        d = self.memory.vectors[:, 3]
        made.deflect_nodes(d, self.counts[:, NODES], self.memory.at, slots, self.memory.image)
        self.counts[pieces, CONVOLUTIONS] += 1
        self.rounds += 1

    def iterate(self) -> int:
        """Step along the directions and find the next; return how many pieces still descend."""
        step_and_turn(
            self.frames,
            self.memory,
            self._tables,
            self.block,
            float(self.contact.hardness),
            float(self.contact.tolerance),
            self.numbers,
            self.counts,
        )
        return int(self.counts[:, DESCENDS].sum())

    def check(self) -> int:
        """Judge in double precision; return how many pieces are not accepted."""
        pieces = np.flatnonzero(self.counts[:, ACCEPTED] == 0)
        slots = self._slots(pieces)
        apart = farthest(self.frames.p, self.counts)
        made = self._transforms(apart, self.frames.p.shape[1], slots.size // 2, False)
        made.deflect_frames(self.frames.p, slots, self.frames.u)
        hardness = float(self.contact.hardness)
        judge_and_measure(
            self.frames,
            self._surface,
            self._sphere,
            self.corners,
            (hardness, self._total, float(self.contact.tolerance), self._least),
            self.numbers,
            self.counts,
            self._windows,
        )
        return int((self.counts[:, ACCEPTED] == 0).sum())
