"""A batch of pieces in lockstep on a processor, by the kernels of the program."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from acoustics.arrays import Array
from lockstep.batch_transforms import BatchTransforms, frames_by_own_plans, nodes_by_own_plans
from lockstep.compiled_passes import (
    ACCEPTED,
    APPROACH,
    APPROACH_BEFORE,
    CONVOLUTIONS,
    COUNTS,
    DESCENDS,
    LINKED,
    NODES,
    NUMBERS,
    POSITION,
    SLOPE,
    SPREAD,
    U_MAX,
    Frames,
    Memory,
    Tables,
    farthest,
    find_windows,
    judge_and_measure,
    lead,
    list_nodes,
    move,
    step_and_turn,
)
from rolling.contact._candidate_kernels import STRIP
from rolling.contact._far_field import coarse_grid, far_field, stencils
from rolling.contact._system import BORDER
from rolling.contact._transform_kernels import GROUP, nodes_kernel
from rolling.contact.half_space import HalfSpace, padded_length
from rolling.contact.state import SURE, ContactState, RollingContact


@cache
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
    one_plan : bool
        Whether k transforms are in one plan, two pieces side by side; otherwise the transforms of
        the present solver take the pieces one after the other, in a single call.
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
        one_plan: bool,
        number: int = 0,
    ) -> None:
        self._one_plan = one_plan
        self._number = number
        for kernel in LINKED:
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
        self.block = (0, 0, 0, 0, 0)
        self._tables: Any = None
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
            image=np.zeros((pieces, 4 * (rows + 20) * (columns + 20))),
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
        self._tables, *row_lengths = self._tables_of(rows, columns)
        self.block = (rows, columns, *row_lengths)
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

    def _tables_of(self, rows: int, columns: int) -> tuple[Any, ...]:
        """Return the tables of a block for `system_of_piece`, and its row lengths (see `lead`)."""
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
                    tile,
                    row_length,
                    coarse_rows * row_length,
                ),
                2 * (across // 2) + 1,
                0 if self._one_plan else across,
                transforms.real.shape[2],
            )
        tables, *row_lengths = self._made[key]
        lift = self.numbers[:, U_MAX] / self._total
        return Tables(*tables, lift), *row_lengths

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
        self.counts[pieces, CONVOLUTIONS] += 1
        self.rounds += 1
        d = self.memory.vectors[:, 3]
        image = self.memory.image
        rows, columns = self.block[:2]
        if not self._one_plan:
            own = self.half_space.convolution(rows - 1, columns - 1, single=True)
            nodes_by_own_plans(
                d,
                self.counts[:, NODES],
                self.memory.indices[:, 1],
                pieces,
                (rows, columns, self.half_space.unit),
                (nodes_kernel(1, True), own.planned_entry(rows)),
                image,
            )
            return
        slots = self._slots(pieces)
        made = self._transforms((rows - 1, columns - 1), rows, slots.size // 2, True)
        made.deflect_nodes(d, self.counts[:, NODES], self.memory.at, slots, image)

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
        apart = farthest(self.frames.p, self.counts)
        p = self.frames.p
        u = self.frames.u
        if self._one_plan:
            slots = self._slots(pieces)
            made = self._transforms(apart, p.shape[1], slots.size // 2, False)
            made.deflect_frames(p, slots, u)
        else:
            entry = self.half_space.convolution(*apart).planned_entry(p.shape[1])
            frames_by_own_plans(p, pieces, self.half_space.unit, entry, u)
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
