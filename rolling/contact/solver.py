"""Contact solve: pressures between 0 and the hardness on a window of nodes, under a given load.

min over p of  1/2 p.Cp + e.p   subject to 0 <= p <= H, sum(p) dA = W, by conjugate gradients projected on both bounds, after
Polonsky & Keer, Wear 231 (1999). Three things differ from the paper: a short stencil of the inverse half-space operator
preconditions, nodes about to reach a bound are put there at once, and each trial pressure is made feasible before its one
convolution, after which the step along it is exact. The energy therefore falls in every iteration, at one convolution each.

The iteration runs in single precision on candidate nodes only. A solution is accepted after a double-precision check on the full
window.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rolling.contact import _projection, _solver_kernels
from rolling.contact._projection import Limits
from rolling.contact.half_space import OWN_COEFFICIENT, HalfSpace, love

Array = NDArray[np.float64]

MAX_ITERATIONS = 1000
NEAR = 0.01  # candidates for contact have a gap below this share of the largest deflection; 0.001 to 0.1 take the same iterations
AIM = 0.98  # of the tolerance: the rest is for the difference between the deflection carried along and one computed afresh
SINGLE_TOLERANCE = 1e-6  # single precision, 1e-7 of the largest deflection, serves no tighter one


class ContactError(RuntimeError):
    """A contact that cannot be solved: the limit in numbers, or the methods tried and the residual they reached."""


@dataclass(frozen=True)
class Contact:
    """A solved contact on its window.

    Parameters
    ----------
    pressure : (m, n) array, Pa.
    deflection : (m, n) array, m.
    approach : float, m.
    residual : float. KKT residual: maximum violation of the contact conditions over the maximum deflection, from a deflection
        computed afresh.
    iterations : int. Iterations that the solve took.
    """

    pressure: Array
    deflection: Array
    approach: float
    residual: float
    iterations: int


@dataclass(frozen=True)
class Trend:
    """Changes of a contact from the position before to this one, a guess at the next changes.

    Parameters
    ----------
    pressure : (m, n) array, Pa.
    deflection : (m, n) array, m.
    """

    pressure: Array
    deflection: Array


@dataclass(frozen=True)
class WarmStart:
    """Pressures to start a solve from, with all that is known about them.

    Parameters
    ----------
    pressure : (m, n) array, Pa. Between 0 and the hardness, carrying the load to rounding.
    deflection : (m, n) array, m, or None. Deflection by `pressure`. Default: it is computed.
    trend : Trend or None. Expected changes, used where `deflection` is given. Default: none.
    close : bool. Whether to iterate only on nodes in or near contact, and check the others after convergence. Use it when the
        start is close to the solution. Default: False.
    """

    pressure: Array
    deflection: Array | None = None
    trend: Trend | None = None
    close: bool = False


@dataclass(frozen=True)
class SolverOptions:
    """Accuracy of a solve.

    Parameters
    ----------
    tolerance : float. Largest KKT residual: violation of the contact conditions over the maximum deflection. Default: 1e-5.
    single : bool. Whether to iterate on deflections of single precision while the tolerance is far above their error. A solution
        is accepted in double precision all the same. Default: True.
    """

    tolerance: float = 1e-5
    single: bool = True


@lru_cache(maxsize=1)
def _inverse_stencil() -> Array:
    """Return the 3 x 3 middle of the inverse of Love's coefficients on a large periodic grid, for unit spacing and pi E* = 1."""
    distance = np.minimum(np.arange(256), 256 - np.arange(256))
    inverse = np.fft.irfft2(1.0 / np.fft.rfft2(love(distance, distance)).real)
    return np.ascontiguousarray(np.roll(inverse, (1, 1), axis=(0, 1))[:3, :3])


def foundation(gap: Array, load: float, spacing: float, stiffness: float, hardness: float = np.inf) -> Array:
    """Solve the same contact on a Winkler foundation, for a cold start.

    Parameters
    ----------
    gap : (m, n) array, m. Undeformed gap.
    load : float, N.
    spacing : float, m. Node spacing.
    stiffness : float, Pa/m. A Hertz contact of radius a is met by 4 E* / (pi a).
    hardness : float, Pa. Largest pressure. Default: infinite.

    Returns
    -------
    (m, n) array, Pa. The smaller of hardness and stiffness times overlap, at the approach that carries the load.

    Raises
    ------
    ContactError : the window cannot carry the load.
    """
    total = load / spacing**2
    if total > hardness * gap.size:
        raise ContactError(
            f"a load of {load:g} N is more than the surface can carry: hardness {hardness:g} Pa times"
            f" {gap.size * spacing**2:.4g} m2 is {hardness * gap.size * spacing**2:.4g} N"
        )
    e = np.ascontiguousarray(gap, dtype=float).ravel()
    limits, free = Limits(float(hardness), float(total)), _projection.Sets(np.arange(e.size, dtype=np.uint32), e.size, 0)
    pressure = np.empty_like(e)
    slope, _ = _projection.project(np.zeros_like(e), e, 0.0, -stiffness * e, free, limits, pressure)
    if slope == np.inf:  # heights so large that springs round the load away: the lowest nodes carry it
        pressure[:] = 0.0
        _projection.settle_load(pressure, e, limits, 0.0)
    return pressure.reshape(gap.shape)


def _cold_start(half_space: HalfSpace, gap: Array, load: float, hardness: float) -> WarmStart:
    """Start from a Winkler foundation that fits a contact of half the window's width."""
    radius = 0.25 * max(gap.shape) * half_space.spacing
    stiffness = 4 * half_space.contact_modulus / (np.pi * radius)
    return WarmStart(foundation(gap, load, half_space.spacing, stiffness, hardness))


def solve_contact(
    half_space: HalfSpace,
    gap: Array,
    load: float,
    start: WarmStart | None = None,
    hardness: float = np.inf,
    edge: Array | None = None,
    options: SolverOptions | None = None,
) -> Contact:
    """Solve one contact under a normal load on a window of nodes.

    The window must hold the whole contact: all outside it is taken to be open.

    Parameters
    ----------
    half_space : HalfSpace. Pressure to deflection.
    gap : (m, n) array, m, C-contiguous. Undeformed gap.
    load : float, N. Normal load.
    start : WarmStart or None. Default: a Winkler foundation.
    hardness : float, Pa. Largest pressure. Default: infinite, purely elastic.
    edge : (m, n) array, m, or None. Half of the range of gaps over the cell of a node, where a patch at the hardness may end
        within the cell: a node with the share s of its cell in contact bears s * hardness at a gap of edge * (1 - 2 s).
        Default: a cell is in contact as a whole or not at all.
    options : SolverOptions or None. Default: SolverOptions().

    Returns
    -------
    Contact. Pressure, deflection and approach, with residual and number of iterations.

    Raises
    ------
    ContactError : the window cannot carry the load, or the solve did not converge; the message has residual, iterations and the
        methods tried.

    Examples
    --------
    A steel sphere of 5 mm radius under 5 N, against Hertz:

    >>> import numpy as np
    >>> from rolling.contact.closed_forms import hertz_approach
    >>> from rolling.contact.half_space import HalfSpace
    >>> from rolling.contact.solver import solve_contact
    >>> steel = HalfSpace(spacing=2e-6, contact_modulus=230e9)
    >>> x = np.arange(-40, 41) * steel.spacing
    >>> contact = solve_contact(steel, (x[:, None] ** 2 + x**2) / (2 * 5e-3), load=5.0)
    >>> bool(abs(contact.approach / hertz_approach(5.0, 5e-3, 230e9) - 1) < 1e-3)
    True
    """
    options = options or SolverOptions()
    start = start or _cold_start(half_space, gap, load, hardness)
    limits = Limits(float(hardness), float(load / half_space.spacing**2))
    p = np.array(start.pressure, dtype=float)
    u = half_space.deflection(p) if start.deflection is None else start.deflection
    compliance = None
    if edge is not None:
        # A shared cell has gap = edge (1 - 2 p / H): a gap lower by the edge on a node that gives 2 edge / H by itself.
        gap, compliance = gap - edge, 2 * edge / hardness
    near, fresh, seen = NEAR if start.close else np.inf, start.deflection is None, 0
    tried = _Tried()
    while True:
        v = u if compliance is None else u + compliance * p
        flat = p.ravel(), gap.ravel(), v.ravel(), limits.hardness
        approach, u_max = _solver_kernels.state_of(*flat)
        u_max = u_max if edge is None else float(u.max())
        worst = _solver_kernels.violation(*flat, approach) if fresh else np.nan
        if not np.isfinite(approach) or not 0 < u_max < np.inf or worst == np.inf:
            raise ContactError(
                "the contact solve met numbers that are not finite: check units of load, modulus and heights"
            )
        if fresh and worst <= options.tolerance * u_max and abs(p.sum() / limits.total - 1) <= 1e-12:
            return Contact(p, u, float(approach), float(worst / u_max), tried.iterations)
        tried.refuse_more(worst / u_max, options.tolerance)
        candidates = _candidates(p, gap, v, approach + near * u_max)
        # Not converged though no new node came into sight: single precision is not enough.
        precise = (
            not options.single
            or options.tolerance < SINGLE_TOLERANCE
            or (fresh and candidates.node.size <= seen)
        )
        descent = _Descent(
            half_space, candidates, p, gap + v, compliance, limits, options.tolerance * u_max, not precise
        )
        if start.trend is not None and not fresh:
            descent.lead(start.trend)
        descent.iterate(tried)
        descent.settle(tried)
        p.ravel()[candidates.node] = descent.pressure
        u, fresh = half_space.deflection(p), True
        near, seen = NEAR, candidates.node.size


@dataclass
class _Tried:
    """Work that a solve has done so far."""

    iterations: int = 0
    restarts: int = 0
    plain_steps: int = 0
    stuck: int = 0
    rounds: int = 0
    snapping: bool = True

    def refuse_more(self, residual: float, tolerance: float) -> None:
        """Raise ContactError once the solve is stuck or out of iterations."""
        if self.stuck > 1 or self.iterations >= MAX_ITERATIONS or self.rounds > MAX_ITERATIONS:
            raise ContactError(
                f"the contact solve stopped after {self.iterations} iterations at a residual of {residual:.2g},"
                f" {tolerance:.2g} was asked for (tried: preconditioned conjugate gradients, {self.restarts} restarts,"
                f" {self.plain_steps} plain gradient steps)"
            )


@dataclass(frozen=True)
class _Candidates:
    """The nodes of a window that may be in contact, as flat indices, and the block of rows and columns that holds them."""

    node: NDArray[np.int64]
    first_row: int
    first_column: int
    rows: int
    columns: int


def _candidates(pressure: Array, gap: Array, deflection: Array, highest: float) -> _Candidates:
    """Find the nodes that are loaded or lie lower than `highest` [m] before the approach is taken off."""
    listed = np.empty(pressure.size, dtype=np.int64)
    count, first_row, last_row, first_column, last_column = _solver_kernels.candidates(
        pressure, gap, deflection, highest, listed
    )
    return _Candidates(
        listed[:count], first_row, first_column, last_row - first_row + 1, last_column - first_column + 1
    )


class _Descent:
    """Conjugate gradients on the candidates for contact, until these hold the conditions to `allowed`.

    Parameters
    ----------
    half_space : HalfSpace. Pressure to deflection.
    candidates : _Candidates. Nodes that may be in contact.
    pressure, gap : (m, n) arrays on the window, Pa and m. Start, and its gaps before the approach is taken off.
    compliance : (m, n) array, m/Pa, or None. Closing of a node's gap by its own pressure beside the deflection.
    limits : Limits. Hardness and sum of pressures.
    allowed : float, m. Largest violation of the contact conditions.
    single : bool. Whether transforms are of single precision.

    Attributes
    ----------
    system : System. Arrays of the compiled passes. packed : plain tuples of the same. direction : Direction. Numbers of the direction at hand.
    step : Step. State after the last step.
    """

    def __init__(
        self,
        half_space: HalfSpace,
        candidates: _Candidates,
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
        self.transforms = half_space.convolution(candidates.rows - 1, candidates.columns - 1, single=single)
        row_length = candidates.columns + 2
        in_image, in_grid = np.empty(node.size, np.uint32), np.empty(node.size, np.uint32)
        _solver_kernels.places(
            node,
            gap.shape[1],
            candidates.first_row,
            candidates.first_column,
            self.transforms.real.shape[1],
            row_length,
            in_image,
            in_grid,
        )
        unit = 1.0 / half_space.unit
        stiffness = float(unit / OWN_COEFFICIENT)
        soft = np.empty(0) if compliance is None else compliance.ravel()[node]
        vectors = (np.zeros(node.size) for _ in range(4))
        grid = np.zeros((candidates.rows + 2) * row_length)
        self.system = _solver_kernels.System(
            _solver_kernels.Nodes(pressure.ravel()[node], gap.ravel()[node], soft, 1 / np.sqrt(1 + soft * stiffness)),
            _solver_kernels.Transform(self.transforms.head(self.rows).ravel(), in_image, half_space.unit),
            _solver_kernels.Stencil(_inverse_stencil() * unit, grid, in_grid, row_length, stiffness),
            _solver_kernels.Work(*vectors, np.empty(node.size, np.uint32)),
            limits,
        )
        self.packed = _solver_kernels.pack(self.system)
        self.direction = _solver_kernels.Direction(0.0, 0.0, 0.0, 1.0)
        self.step = _solver_kernels.Step(np.nan, np.nan, 0, 0, 0, 0)

    @property
    def pressure(self) -> Array:
        """Pressures of the candidates [Pa]."""
        return self.system.nodes.p

    def lead(self, trend: Trend) -> None:
        """Take the first direction from the extrapolation of the last solutions."""
        ahead = trend.pressure.ravel()[self.node], trend.deflection.ravel()[self.node]
        self.direction = _solver_kernels.Direction(*_solver_kernels.lead(self.packed, *ahead))

    def iterate(self, tried: _Tried) -> None:
        """Step until converged, stuck or out of iterations, at one convolution per step."""
        tried.rounds += 1
        snap = 0.01 * self.allowed * self.system.stencil.stiffness if tried.snapping else 0.0
        share = self.node.size  # of the snap that a node may take, so that the sum of them makes no difference
        if self.direction.slope < 0:  # the direction of `lead`
            self._convolve(tried)
        while True:
            last = tried.iterations >= MAX_ITERATIONS
            step, direction = _solver_kernels.iterate(
                self.packed, tuple(self.direction), snap / share, np.inf if last else self.goal
            )
            self.step, self.direction = _solver_kernels.Step(*step), _solver_kernels.Direction(*direction)
            if last or not self.step.worst > self.goal:
                break
            share = max(self.step.bound, 1)
            tried.restarts += self.step.restarts
            tried.plain_steps += self.step.plain_steps
            if not self.direction.slope < 0:
                tried.iterations += 1
                break
            tried.stuck = 0
            self._convolve(tried)

    def settle(self, tried: _Tried) -> None:
        """Make the pressures carry the load exactly, or, where no step descends, find others to go on from."""
        (p, g, *_), work, step = self.system.nodes, self.system.work, self.step
        if not step.worst > self.goal:
            # A node put on a bound took its share of the load along: the free nodes have it, or those nearest to moving.
            if step.free:
                _solver_kernels.carry_load(self.packed, step.approach, step.free)
            elif abs(p.sum() / self.limits.total - 1) > 1e-13:
                tried.snapping = False
                _projection.settle_load(p, g, self.limits, 0.0)
        elif not self.direction.slope < 0:
            # Pressures of the order of rounding can pass for free nodes and set the approach: take the projection for the state.
            tried.stuck += 1
            p += work.d
            _projection.settle_load(p, g, self.limits, 1e-9 * p.max())
        np.clip(p, 0.0, self.limits.hardness, out=p)

    def _convolve(self, tried: _Tried) -> None:
        self.transforms.apply(self.rows)
        self.half_space.count += 1
        tried.iterations += 1
