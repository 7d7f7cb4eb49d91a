"""One elastic-plastic contact solve: pressures between 0 and the hardness on a window of nodes, under a given load.

min over p of  1/2 p.Cp + e.p   subject to 0 <= p <= H, sum(p) dA = W, by conjugate gradients projected on both bounds, after
Polonsky & Keer, Wear 231 (1999), with three changes: the inverse half-space operator as a short stencil preconditions, nodes
about to reach a bound are put there at once, and each trial pressure is made feasible before its one convolution, after which
the step along it is exact. The energy therefore falls in every iteration, at one convolution each. Iterations see the nodes that
may be in contact, in single precision; what is accepted holds on the whole window, in double.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rolling.contact import _solver_kernels
from rolling.contact.half_space import OWN_COEFFICIENT, HalfSpace, love

Array = NDArray[np.float64]

MAX_ITERATIONS = 1000
NEAR = 0.01  # candidates for contact have a gap below this share of the largest deflection; 0.001 to 0.1 take the same iterations
AIM = 0.98  # of the tolerance: what is left is for the difference between the deflection carried along and one computed afresh
LEAST_STEP = 1e-3  # a step this much shorter than it was meant to be: nodes being put on a bound point the wrong way
SINGLE_TOLERANCE = 1e-6  # single precision, 1e-7 of the largest deflection, serves no tighter one


class ContactError(RuntimeError):
    """A contact that cannot be solved: the limit in numbers, or what was tried and how far it came."""


@dataclass(frozen=True)
class Contact:
    """A solved contact on its window: pressure [Pa] and deflection [m], shape (m, n); approach [m]; what it took.

    `residual` is the largest violation of the contact conditions over the largest deflection, from u = Cp computed afresh.
    """

    pressure: Array
    deflection: Array
    approach: float
    residual: float
    iterations: int


@lru_cache(maxsize=1)
def _inverse_stencil() -> Array:
    """The 3 x 3 middle of the inverse of Love's coefficients on a large periodic grid, for unit spacing and pi E* = 1."""
    distance = np.minimum(np.arange(256), 256 - np.arange(256))
    inverse = np.fft.irfft2(1.0 / np.fft.rfft2(love(distance, distance)).real)
    return np.ascontiguousarray(np.roll(inverse, (1, 1), axis=(0, 1))[:3, :3])


def foundation(shape: Array, load: float, spacing: float, stiffness: float, hardness: float = np.inf) -> Array:
    """Pressure of the same bodies on independent springs [Pa], a cold start: min(H, stiffness * overlap) under the load.

    Parameters
    ----------
    shape : (m, n) undeformed gap [m].
    stiffness : [Pa/m]; a Hertz contact of radius a is met by 4 E* / (pi a).

    Raises
    ------
    ContactError : the window cannot carry the load.
    """
    total = load / spacing**2
    if total > hardness * shape.size:
        raise ContactError(
            f"a load of {load:g} N is more than the surface can carry: hardness {hardness:g} Pa times"
            f" {shape.size * spacing**2:.4g} m2 is {hardness * shape.size * spacing**2:.4g} N"
        )
    e = np.ascontiguousarray(shape, dtype=float).ravel()
    nothing, pressure, everywhere = np.zeros_like(e), np.empty_like(e), np.arange(e.size)
    slope, _ = _solver_kernels.project(
        nothing, e, 0.0, e.copy(), -stiffness, hardness, everywhere, e.size, 0, total, pressure
    )
    if slope == np.inf:  # heights so large that springs round the load away: the lowest nodes carry it
        pressure[:] = 0.0
        _solver_kernels.settle_load(pressure, e, hardness, total, 0.0)
    return pressure.reshape(shape.shape)


def solve(
    half_space: HalfSpace,
    shape: Array,
    load: float,
    start: Array,
    tolerance: float,
    hardness: float = np.inf,
    nearby: bool = False,
    deflection: Array | None = None,
    trend: tuple[Array, Array] | None = None,
    edge: Array | None = None,
    single: bool = True,
) -> Contact:
    """Solve one contact.

    Parameters
    ----------
    half_space : pressure to deflection.
    shape : (m, n) undeformed gap [m] on the window, C-contiguous.
    load : normal load [N].
    start : (m, n) pressures to start from [Pa], within 0 and the hardness, carrying the load to rounding.
    tolerance : largest allowed violation of the contact conditions over the largest deflection.
    hardness : pressure cap [Pa].
    nearby : iterate on nodes that are loaded or near to contact only, and look at the others in the end: for a start that is close.
    deflection : (m, n) deflection of `start` [m] where it is known and 0 elsewhere.
    trend : changes of pressure and deflection since the position before, both (m, n), as a guess at their next ones.
    edge : (m, n) half of the range of gaps over the cell of a node [m], where a patch at the hardness may end within the cell:
        a node with the share s of its cell in contact bears s * hardness at a gap of edge * (1 - 2 s). 0: all or nothing.
    single : iterate on deflections of single precision, while the tolerance is far above their error. What is accepted is of
        double precision all the same.

    Raises
    ------
    ContactError : not converged; the message has residual, iterations and what was tried.
    """
    total = load / half_space.spacing**2
    p = np.array(start, dtype=float)
    u = half_space.deflection(p) if deflection is None else deflection
    soft = None
    if edge is not None:
        # gap = edge (1 - 2 p / H) where a cell is shared: a gap lower by the edge on a node that gives 2 edge / H by itself.
        shape, soft = shape - edge, 2 * edge / hardness
    near, fresh, looked_at = NEAR if nearby else np.inf, deflection is None, 0
    tried = _Tried()
    while True:
        v = u if soft is None else u + soft * p
        flat = p.ravel(), shape.ravel(), v.ravel(), hardness
        approach, u_max = _solver_kernels.state_of(*flat)
        u_max = u_max if edge is None else float(u.max())
        worst = _solver_kernels.violation(*flat, approach) if fresh else np.nan
        if not np.isfinite(approach) or not 0 < u_max < np.inf or worst == np.inf:
            raise ContactError(
                "the contact solve met numbers that are not finite: check units of load, modulus and heights"
            )
        if fresh and worst <= tolerance * u_max and abs(p.sum() / total - 1) <= 1e-12:
            return Contact(p, u, float(approach), float(worst / u_max), tried.iterations)
        if tried.stuck > 1 or tried.iterations >= MAX_ITERATIONS or tried.rounds > MAX_ITERATIONS:
            raise ContactError(
                f"the contact solve stopped after {tried.iterations} iterations at a residual of {worst / u_max:.2g},"
                f" {tolerance:.2g} was asked for (tried: preconditioned conjugate gradients, {tried.restarts} restarts,"
                f" {tried.plain_steps} plain gradient steps)"
            )
        listed = np.empty(p.size, dtype=np.int64)
        count, *block = _solver_kernels.candidates(p, shape, v, approach + near * u_max, listed)
        node = listed[:count]
        # Not converged though nothing new came into sight: single precision is not enough.
        precise = not single or tolerance < SINGLE_TOLERANCE or (fresh and count <= looked_at)
        descent = _Descent(half_space, node, block, p, shape + v, soft, total, hardness, tolerance * u_max, precise)
        if trend is not None and not fresh:
            descent.lead(*trend)
        descent.iterate(tried)
        descent.settle(tried)
        p.ravel()[node] = descent.p
        u, fresh = half_space.deflection(p), True
        near, looked_at = NEAR, count


@dataclass
class _Tried:
    """What a solve has done so far."""

    iterations: int = 0
    restarts: int = 0
    plain_steps: int = 0
    stuck: int = 0
    rounds: int = 0
    snapping: bool = True


class _Descent:
    """Conjugate gradients on the candidates for contact, until they hold the conditions to `allowed` [m].

    node : flat indices of the candidates in a window. block : first row, last row, first column, last column of them.
    pressure, gap, soft : on the window, to begin with: pressures [Pa], gaps before the approach is taken off [m], and by what
    nodes give by themselves [m/Pa] (None: none does). total : sum of pressures [Pa]. cap : hardness [Pa]. precise : transforms
    of double precision.

    p, g : pressure [Pa] and gap before the approach is taken off [m] of the candidates; dp the step at hand, `slope` of the
    energy along it, `length` the factor that the step before should have had.
    """

    def __init__(
        self,
        half_space: HalfSpace,
        node: NDArray[np.int64],
        block: list[int],
        pressure: Array,
        gap: Array,
        soft: Array | None,
        total: float,
        cap: float,
        allowed: float,
        precise: bool,
    ) -> None:
        first_row, last_row, first_column, last_column = block
        size, columns = node.size, last_column - first_column + 1
        self.half_space, self.node, self.total, self.cap, self.allowed = half_space, node, total, cap, allowed
        self.rows, self.bordered = last_row - first_row + 1, columns + 2
        self.transforms = half_space.convolution(self.rows - 1, columns - 1, single=not precise)
        self.transformed = self.transforms.real.ravel()
        self.in_padded, self.in_bordered = np.empty(size, np.uint32), np.empty(size, np.uint32)
        padded = self.transforms.real.shape[1]
        _solver_kernels.places(
            node, gap.shape[1], first_row, first_column, padded, self.bordered, self.in_padded, self.in_bordered
        )
        unit = 1.0 / half_space.unit
        self.stencil, self.reach = _inverse_stencil() * unit, unit / OWN_COEFFICIENT
        self.grid = np.zeros((self.rows + 2) * self.bordered)
        self.residual, self.previous, self.dp, self.z = (np.zeros(size) for _ in range(4))
        self.active, self.n_free, self.n_bound = np.empty(size, np.uint32), 0, 0
        self.slope, self.greatest, self.best, self.zr, self.length = 0.0, 0.0, 1.0, 0.0, 1.0
        self.approach = self.worst = np.nan
        self.p, self.g = pressure.ravel()[node], gap.ravel()[node]
        self.soft = np.empty(0) if soft is None else soft.ravel()[node]
        self.give = 1 / np.sqrt(1 + self.soft * self.reach)

    def lead(self, p_trend: Array, u_trend: Array) -> None:
        """A first step by way of the extrapolation of the last solutions and of the gradient there.

        The deflection there is known but for what the bounds cut off; as the step is made from the exact start, with its exact
        line search, that does no harm.
        """
        ahead, q = p_trend.ravel()[self.node], np.empty_like(self.p)
        h = self.g + u_trend.ravel()[self.node]
        if self.soft.size:
            h += self.soft * ahead
        if _solver_kernels.extrapolate(self.p, ahead, self.g, self.cap, self.total, self.active, self.z, self.dp, q):
            self._advance(q, h, snap=0.0)
            self._aim(q, h, plainly=False)
            self.zr, self.length = 0.0, 1.0
            if self.slope < 0:
                self.slope, self.greatest = _solver_kernels.step_by_way_of(
                    q, self.p, self.g, self.cap, self.dp, self.half_space.unit, self.in_padded, self.transformed
                )
        if not self.slope < 0:
            self.slope = 0.0
            self.dp[:] = 0.0

    def iterate(self, tried: _Tried) -> None:
        """Step after step, at one convolution each, until converged, stuck (no negative slope left) or out of iterations."""
        tried.rounds += 1
        snap = 0.01 * self.allowed * self.reach if tried.snapping else 0.0
        share = self.p.size  # of the snap that a node may take, for the sum of them to make no difference
        if self.slope < 0:  # the step of `lead`
            self._convolve(tried)
        while True:
            self._advance(self.p, self.g, snap / share)
            if not self.worst > AIM * self.allowed or tried.iterations >= MAX_ITERATIONS:
                break
            share = max(self.n_bound, 1)
            self.length *= min(max(self.best, 0.5), 2.0)
            restarts, plain = self._aim(self.p, self.g, plainly=self.best < LEAST_STEP)
            tried.restarts += restarts
            tried.plain_steps += plain
            if not self.slope < 0:
                tried.iterations += 1
                break
            tried.stuck = 0
            self._convolve(tried)

    def settle(self, tried: _Tried) -> None:
        """Pressures that carry the load exactly, or, where no step descends, others to go on from."""
        if not self.worst > AIM * self.allowed:
            # What was put on a bound for good took its share of the load along: the free nodes have it, or the nearest to moving.
            if self.n_free:
                _solver_kernels.project(
                    self.p, self.g, self.approach, self.z, 0.0, self.cap, self.active, self.n_free, 0, self.total, self.dp
                )  # fmt: skip
                self.p += self.dp
            elif abs(self.p.sum() / self.total - 1) > 1e-13:
                tried.snapping = False
                _solver_kernels.settle_load(self.p, self.g, self.cap, self.total, 0.0)
        elif not self.slope < 0:
            # Pressures of the order of rounding can pass for free nodes and set the approach: take the projection for the state.
            tried.stuck += 1
            self.p += self.dp
            _solver_kernels.settle_load(self.p, self.g, self.cap, self.total, 1e-9 * self.p.max())
        np.clip(self.p, 0.0, self.cap, out=self.p)

    def _convolve(self, tried: _Tried) -> None:
        self.transforms.apply(self.rows)
        self.half_space.count += 1
        tried.iterations += 1

    def _advance(self, p: Array, g: Array, snap: float) -> None:
        self.residual, self.previous = self.previous, self.residual
        self.best, self.approach, self.worst, self.n_free, self.n_bound = _solver_kernels.advance(
            p, g, self.soft, self.give, self.dp, self.transformed, self.in_padded, self.slope, self.greatest, self.cap,
            self.reach, snap, self.residual, self.grid, self.in_bordered, self.active,
        )  # fmt: skip

    def _aim(self, p: Array, g: Array, plainly: bool) -> tuple[int, int]:
        self.transforms.clear(self.rows)
        self.slope, self.greatest, self.zr, self.length, restarts, plain = _solver_kernels.aim(
            p, g, self.give, self.approach, self.residual, self.previous, self.grid, self.in_bordered, self.bordered,
            self.stencil, self.zr, self.length, self.cap, self.reach, self.active, self.n_free, self.n_bound, self.total,
            plainly, self.z, self.dp, self.half_space.unit, self.in_padded, self.transformed,
        )  # fmt: skip
        return restarts, plain
