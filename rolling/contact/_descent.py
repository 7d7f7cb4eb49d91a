"""Descent by conjugate gradients on the candidate nodes of a window, and its cost."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rolling._typing import Array
from rolling.contact import _projection, _solver_kernels
from rolling.contact._system import (
    Direction,
    Limits,
    Nodes,
    Stencil,
    Step,
    System,
    Transform,
    Work,
    pack,
)
from rolling.contact.half_space import OWN_COEFFICIENT, HalfSpace, love

MAX_ITERATIONS = 1000
# The descent aims at this share of the tolerance. The rest allows for the difference between the
# updated deflection and a recomputed deflection.
AIM = 0.98


@lru_cache(maxsize=1)
def _inverse_stencil() -> Array:
    """Return the 3 x 3 centre of the inverse of Love's coefficients.

    It holds on a large periodic grid, for unit spacing and pi E* = 1.
    """
    distance = np.minimum(np.arange(256), 256 - np.arange(256))
    inverse = np.fft.irfft2(1.0 / np.fft.rfft2(love(distance, distance)).real)
    return np.ascontiguousarray(np.roll(inverse, (1, 1), axis=(0, 1))[:3, :3])


@dataclass
class Effort:
    """Work that a solve has done so far."""

    iterations: int = 0
    restarts: int = 0
    plain_steps: int = 0
    stuck: int = 0
    rounds: int = 0
    snapping: bool = True

    @property
    def is_spent(self) -> bool:
        """Tell whether the solve is stuck or out of iterations."""
        return self.stuck > 1 or self.iterations >= MAX_ITERATIONS or self.rounds > MAX_ITERATIONS


@dataclass(frozen=True)
class Candidates:
    """Nodes of a window that may be in contact, as flat indices, and their block."""

    node: NDArray[np.int64]
    first_row: int
    first_column: int
    rows: int
    columns: int

    @classmethod
    def below(cls, pressure: Array, gap: Array, deflection: Array, highest: float) -> Candidates:
        """Find the nodes that are loaded or lie lower than `highest` [m].

        Heights count before the approach is subtracted.
        """
        listed = np.empty(pressure.size, dtype=np.int64)
        count, first_row, last_row, first_column, last_column = _solver_kernels.candidates(
            pressure, gap, deflection, highest, listed
        )
        return cls(
            listed[:count],
            first_row,
            first_column,
            last_row - first_row + 1,
            last_column - first_column + 1,
        )


class Descent:
    """Conjugate gradients on the candidates, until they satisfy the contact conditions.

    Parameters
    ----------
    half_space : HalfSpace
        Pressure to deflection.
    candidates : Candidates
        Nodes that may be in contact.
    pressure, gap : (m, n) arrays on the window, Pa and m
        Start, and its gaps before the approach is subtracted.
    compliance : (m, n) array, m/Pa, or None
        Closing of a node's gap by its own pressure in addition to the deflection.
    limits : Limits
        Hardness and sum of pressures.
    allowed : float, m
        Maximum allowed violation of the contact conditions.
    single : bool
        If true, transforms are in single precision.

    Attributes
    ----------
    system, packed : System
        Arrays of the compiled passes, and the same arrays in plain tuples.
    direction : Direction
        Numbers of the current direction.
    step : Step
        State after the last step.
    """

    def __init__(
        self,
        half_space: HalfSpace,
        candidates: Candidates,
        pressure: Array,
        gap: Array,
        compliance: Array | None,
        limits: Limits,
        allowed: float,
        single: bool,
    ) -> None:
        node = candidates.node
        self.half_space, self.node, self.limits = half_space, node, limits
        self.allowed, self.goal = allowed, AIM * allowed
        self.rows = candidates.rows
        self.transforms = half_space.convolution(
            candidates.rows - 1, candidates.columns - 1, single=single
        )
        row_length = candidates.columns + 2
        in_image, in_grid = np.empty(node.size, np.uint32), np.empty(node.size, np.uint32)
        corner = candidates.first_row, candidates.first_column
        row_lengths = self.transforms.real.shape[1], row_length
        _solver_kernels.places(node, gap.shape[1], corner, row_lengths, in_image, in_grid)
        unit = 1.0 / half_space.unit
        stiffness = float(unit / OWN_COEFFICIENT)
        soft = np.empty(0) if compliance is None else compliance.ravel()[node]
        trial, d, r, r_before = (np.zeros(node.size) for _ in range(4))
        grid = np.zeros((candidates.rows + 2) * row_length)
        self.system = System(
            Nodes(
                pressure.ravel()[node], gap.ravel()[node], soft, 1 / np.sqrt(1 + soft * stiffness)
            ),
            Transform(self.transforms.head(self.rows).ravel(), in_image, half_space.unit),
            Stencil(_inverse_stencil() * unit, grid, in_grid, row_length, stiffness),
            Work(trial, d, r, r_before, np.empty(node.size, np.uint32)),
            limits,
        )
        self.packed = pack(self.system)
        self.direction = Direction(0.0, 0.0, 0.0, 1.0)
        self.step = Step(np.nan, np.nan, 0, 0, 0, 0)

    @property
    def pressure(self) -> Array:
        """Pressures of the candidates [Pa]."""
        return self.system.nodes.p

    def lead(self, pressure_trend: Array, deflection_trend: Array) -> None:
        """Take the first direction from the extrapolation of the last solutions.

        Their trends on the window give the extrapolation.
        """
        ahead = pressure_trend.ravel()[self.node], deflection_trend.ravel()[self.node]
        self.direction = Direction(*_solver_kernels.lead(self.packed, *ahead))

    def iterate(self, effort: Effort) -> None:
        """Step until converged, stuck or out of iterations, with one convolution per step."""
        effort.rounds += 1
        snap = 0.01 * self.allowed * self.system.stencil.stiffness if effort.snapping else 0.0
        # The snap is divided by the number of nodes, so that its sum makes no difference.
        share = self.node.size
        if self.direction.slope < 0:  # the direction of `lead`
            self._convolve(effort)
        while True:
            last = effort.iterations >= MAX_ITERATIONS
            step, direction = _solver_kernels.iterate(
                self.packed, tuple(self.direction), snap / share, np.inf if last else self.goal
            )
            self.step, self.direction = Step(*step), Direction(*direction)
            if last or not self.step.worst > self.goal:
                break
            share = max(self.step.bound, 1)
            effort.restarts += self.step.restarts
            effort.plain_steps += self.step.plain_steps
            if not self.direction.slope < 0:
                effort.iterations += 1
                break
            effort.stuck = 0
            self._convolve(effort)

    def settle(self, effort: Effort) -> None:
        """Make the pressures carry the load exactly.

        Where no step descends, a feasible restart replaces them.
        """
        (p, g, *_), work, step = self.system.nodes, self.system.work, self.step
        if not step.worst > self.goal:
            # A node that was put on a bound took its share of the load along. The free nodes make
            # up for it, or else the nodes that are nearest to moving.
            if step.free:
                _solver_kernels.carry_load(self.packed, step.approach, step.free)
            elif abs(p.sum() / self.limits.total - 1) > 1e-13:
                effort.snapping = False
                _projection.settle_load(p, g, self.limits, 0.0)
        elif not self.direction.slope < 0:
            # Pressures of the order of rounding errors can pass for free nodes and set the
            # approach, so the projection becomes the state.
            effort.stuck += 1
            p += work.d
            _projection.settle_load(p, g, self.limits, 1e-9 * p.max())
        np.clip(p, 0.0, self.limits.hardness, out=p)

    def _convolve(self, effort: Effort) -> None:
        self.transforms.apply(self.rows)
        self.half_space.count += 1
        effort.iterations += 1
