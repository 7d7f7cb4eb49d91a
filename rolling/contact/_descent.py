"""Descent by conjugate gradients on the candidate nodes of a window, and its cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from rolling.contact import _candidate_kernels, _condition_kernels, _solver_kernels
from rolling.contact._far_field import coarse_grid, far_field, stencils
from rolling.contact._system import BORDER, Direction, Limits, Packed, Step
from rolling.contact.half_space import OWN_COEFFICIENT, HalfSpace

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
# Nodes at the hardness rest beyond so many times the reach of the open candidates. With 1 the last
# check refuses more descents, above all on sub-cells; with 8 the candidates are up to 14 % more.
REST = 4
_NO_SOLUTIONS = *[np.empty((0, 0))] * 4, (0, 0), (0, 0, 0, 0)


@dataclass
class Effort:
    """Work that a solve has done so far."""

    iterations: int = 0
    restarts: int = 0
    plain_steps: int = 0
    stuck: int = 0
    rounds: int = 0
    moves: int = 0
    snapping: bool = True

    @property
    def is_spent(self) -> bool:
        """Tell whether the solve is stuck or out of iterations."""
        return self.stuck > 1 or self.iterations >= MAX_ITERATIONS or self.rounds > MAX_ITERATIONS

    def sweeps(self, nodes: int) -> int:
        """Return the sweeps that settle a model of so many nodes, 0 where it does not lead."""
        leads = self.iterations < MODELLED and not self.stuck
        return (WIDE_SWEEPS if nodes > WIDE_BLOCK else SWEEPS) if leads else 0


class Candidates(NamedTuple):
    """Nodes of a window that may move, as flat indices, and their block."""

    node: NDArray[np.int64]
    resting: float  # sum of the pressures of the nodes at rest [Pa]
    first_row: int
    first_column: int
    rows: int
    columns: int

    @classmethod
    def near(
        cls,
        pressure: Array,
        gap: Array,
        hardness: float,
        approach: float,
        reach: float,
        subcells: int = 1,
        neighbours: bool = False,
    ) -> Candidates:
        """Find the nodes that may move, whose gap is within the `reach` [m] of the approach.

        Loaded nodes with a larger gap may move, too. Nodes at the hardness with an overlap of more
        than REST times the reach rest where enough others are between the bounds. With `neighbours`
        the nodes around those that may move are candidates, too. The block is in whole cells.
        """
        listed = np.empty(pressure.size, dtype=np.int64)
        heights = approach - REST * reach, approach + reach
        nodes, count, *block = _candidate_kernels.candidates(
            pressure, gap, hardness, *heights, neighbours, subcells, listed
        )
        return cls(listed[:count], nodes * hardness if nodes else 0.0, *block)


class BlendedEdges:
    """Edges of patches within the cells of a window: half ranges of the gap over each cell [m].

    They follow from a deflection and the undeformed gap as it continues within cells (`shape`). An
    edge takes a share of the half range beyond that which elastic pressures level.
    """

    def __init__(self, gap: Array, shape: Array, levelled: float, share: float = 1.0) -> None:
        self._gap, self._shape, self.levelled, self.share = gap, shape, levelled, share
        self.edge = np.empty_like(gap)

    def find(self, deflection: Array) -> None:
        """Find the edges by a deflection [m]."""
        # The edges that a solution returned must not change.
        self.edge = np.empty_like(self._gap)
        _candidate_kernels.cell_ranges(
            self._shape, deflection, self.levelled, self.share, self.edge
        )

    def between_nodes(self, node: NDArray[np.int64]) -> Array:
        """Return the gap as it continues within cells less the gap of the nodes [m]."""
        if self._shape is self._gap:
            return np.zeros(node.size)
        difference: Array = self._shape.ravel()[node] - self._gap.ravel()[node]
        return difference


class Goal(NamedTuple):
    """Violation of the contact conditions that a descent leaves, a share of the allowed violation.

    The tolerance is the maximum allowed violation over the maximum deflection `u_max` [m].
    """

    tolerance: float
    u_max: float
    share: float = AIM

    @property
    def allowed(self) -> float:
        """Maximum allowed violation [m]."""
        return self.tolerance * self.u_max

    @property
    def violation(self) -> float:
        """Violation at which the descent ends [m]."""
        return self.share * self.allowed


class Descent:
    """Conjugate gradients on the candidates, until they satisfy the contact conditions.

    Pressure and gap before the approach is subtracted are those of the start on the window; the gap
    contains the edges. `packed` holds the arrays of the compiled passes, `stiffness` is the
    pressure on a single node that opens its gap by a metre [Pa/m].
    """

    def __init__(
        self,
        half_space: HalfSpace,
        candidates: Candidates,
        pressure: Array,
        gap: Array,
        edges: BlendedEdges | None,
        limits: Limits,
        goal: Goal,
        single: bool,
    ) -> None:
        self.half_space, self.node = half_space, candidates.node
        self.limits = limits._replace(total=limits.total - candidates.resting)
        self.allowed, self.share = goal.allowed, goal.share
        self.goal = goal.violation
        self.transforms = half_space.convolution(
            candidates.rows - 1, candidates.columns - 1, single=single
        )
        self.block = candidates.rows, candidates.columns
        self._block_at = candidates.first_row, candidates.first_column, *self.block
        self._listed = self.transforms.cells_of(self.node, gap.shape[1], self._block_at)
        self.blended = edges is not None
        self._vectors = np.zeros((10 if edges else 6, self.node.size))
        packed = self._pack(pressure, gap, float(goal.u_max / limits.total), edges)
        if edges is not None:
            _candidate_kernels.take_edges(
                self.node,
                edges.edge.ravel(),
                edges.between_nodes(self.node),
                packed.numbers,
                packed.vectors,
                packed.indices[2],
                packed.model[6].ravel(),
            )
        self.packed = tuple(packed)
        # Coefficients of single precision do not serve transforms of double precision; a negative
        # number of pairs is never reached.
        direct = single and packed.coefficients.size > 0
        self._most_pairs = PAIRS * self.transforms.real.size if direct else -1
        self._moving = 0  # nodes that the direction moves
        self.direction = Direction(0.0, 0.0, 0.0, _solver_kernels.FIRST_LENGTH)
        self.step = Step(np.nan, np.nan, 0, 0, 0, 0, 0.0)

    def _pack(self, pressure: Array, gap: Array, lift: float, edges: BlendedEdges | None) -> Packed:
        """Make the arrays of the compiled passes, with the nodes of the candidates."""
        rows, columns = (length + 2 * BORDER for length in self.block)
        unit = self.half_space.unit
        inverse = stencils(unit)
        self.stiffness = float(1 / (unit * OWN_COEFFICIENT))
        coarse_rows, coarse_columns, tile = coarse_grid(rows, columns)
        row_length = 2 * coarse_columns - 1
        grids = np.zeros((2 if edges else 1, rows * columns))
        if edges:
            grids[1] = np.nan
        # The passes set the other grids of the model before they read them.
        model = np.empty((7 if edges else 6, rows, columns), np.float32)
        model[2:6] = 0.0
        image = self.transforms.block(*self.block)
        indices = np.empty((4, self.node.size), np.uint32)
        strips = np.empty((rows * columns // _candidate_kernels.STRIP + 1, 2), np.uint64)
        count = _candidate_kernels.take_nodes(
            self.node,
            gap.shape[1],
            self._block_at[:2],
            (image.shape[1:], columns, self.transforms.influence_row),
            rows,
            pressure.ravel(),
            gap.ravel(),
            self._vectors,
            indices,
            strips,
        )
        return Packed(
            self._vectors,
            indices,
            image.ravel(),
            grids,
            model,
            strips[:count],
            np.zeros((7, coarse_rows * row_length), np.float32),
            inverse.preconditioner,
            inverse.model,
            far_field(coarse_rows, coarse_columns, tile),
            self.transforms.influence(),
            (
                float(self.limits.hardness),
                float(self.limits.total),
                float(unit),
                self.stiffness,
                edges.levelled if edges else 0.0,
                inverse.stiffness,
                lift,
                inverse.own,
                inverse.common,
                edges.share if edges else 1.0,
            ),
            (tile, row_length),
        )

    @property
    def pressure(self) -> Array:
        """Pressures of the candidates [Pa]."""
        pressure: Array = self._vectors[0]
        return pressure

    @property
    def is_exhausted(self) -> bool:
        """Whether the descent went as far as its precision allows."""
        # Neither the first descent nor a descent that the model led to its last iteration did.
        if self.step.worst > self.goal:
            return not self.direction.slope < 0
        return self.share <= AIM

    def lead(
        self,
        pressure: Array,
        deflection: Array,
        pressure_before: Array,
        deflection_before: Array,
        offset: tuple[int, int],
    ) -> None:
        """Take the first direction from the solution on the window and the solution before.

        The window of the latter begins at the offset (row, column).
        """
        solutions = pressure, deflection, pressure_before, deflection_before, offset, self._block_at
        self._turn(solutions, NEARLY_WHOLE, 0.0, 0.0, FIRST_SWEEPS, False, False)

    def iterate(self, effort: Effort) -> None:
        """Step until converged, stuck or out of iterations, with one convolution per step."""
        effort.rounds += 1
        snap = 0.01 * self.allowed * self.stiffness if effort.snapping else 0.0
        # The snap is divided by the number of nodes, so that its sum makes no difference.
        share = self.node.size
        if self.direction.slope < 0:  # the direction of `lead`
            self._convolve(effort)
        minimum, nearly = np.inf, NEARLY_WHOLE
        while True:
            last = effort.iterations >= MAX_ITERATIONS
            sweeps = effort.sweeps(self.block[0] * self.block[1])
            effort.moves += self.blended
            goal = np.inf if last else self.goal
            # Where the check refused a last step once, the residual has waves too long for the
            # model.
            finishing = effort.rounds == 1 and not last
            self.step_along(nearly, snap / share, goal, sweeps, effort.moves, finishing)
            if last or not self.step.worst > self.goal:
                break
            stalled = self.step.worst > STALLED * minimum
            nearly = NEARLY_WHOLE_STALLED if stalled else NEARLY_WHOLE
            minimum = min(minimum, self.step.worst)
            share = max(self.step.bound, 1)
            effort.restarts += self.step.restarts
            effort.plain_steps += self.step.plain_steps
            if not self.direction.slope < 0 or (sweeps and effort.iterations >= MODELLED - 1):
                effort.iterations += 1
                break
            effort.stuck = 0
            self._convolve(effort)

    def step_along(
        self, nearly: float, snap: float, goal: float, sweeps: int, moves: int, finishing: bool
    ) -> None:
        """Step along the direction, and find the next one unless the violation is within `goal`."""
        edges_move = 0 < moves <= MAX_MOVES
        self._turn(_NO_SOLUTIONS, nearly, snap, goal, sweeps, edges_move, finishing)

    def _turn(self, solutions: tuple[Any, ...], *arguments: float) -> None:
        """Step or extrapolate, and find the next direction: see `iterate` of the kernels."""
        step, direction = _solver_kernels.iterate(
            self.packed, tuple(self.direction), solutions, *arguments
        )
        self.step, self.direction = Step(*step), Direction(*direction)
        self._moving = self.step.free + self.step.bound

    def settle(self, effort: Effort) -> bool:
        """Make the pressures carry the load exactly; return whether it is known that they do.

        Where no step descends, a feasible restart replaces them.
        """
        p, g, step = self._vectors[0], self._vectors[1], self.step
        if not step.worst > self.goal:
            # A node that was put on a bound took its share of the load along. The last step or the
            # free nodes make up for it, or else the nodes that are nearest to moving.
            load = step.load or _solver_kernels.carry_load(self.packed, step.approach)
            if abs(load / self.limits.total - 1) <= 1e-13:
                return True
            effort.snapping = False
            _condition_kernels.settle_load(p, g, self.limits, 0.0)
        elif not self.direction.slope < 0:
            # Pressures of the order of rounding errors can pass for free nodes and set the
            # approach, so the projection becomes the state.
            effort.stuck += 1
            p += self._vectors[3]
            _condition_kernels.settle_load(p, g, self.limits, 1e-9 * p.max())
        else:
            _condition_kernels.settle_load(p, g, self.limits, 0.0)
        return False

    def _convolve(self, effort: Effort) -> None:
        """Replace the direction in the array of the transforms by its deflection."""
        few = self._moving * self.node.size <= self._most_pairs
        if not (few and _solver_kernels.sum_directly(self.packed, self._most_pairs)):
            self.transforms.apply(*self.block, self._listed)
        self.half_space.count += 1
        effort.iterations += 1
