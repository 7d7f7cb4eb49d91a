"""Contact solve: pressures between 0 and the hardness on a window of nodes, under a given load.

min over p of  1/2 p.Cp + e.p   subject to 0 <= p <= H, sum(p) dA = W, by conjugate gradients
projected on both bounds, after Polonsky & Keer, Wear 231 (1999). Three things differ from the
paper: a short stencil of the inverse half-space operator preconditions, nodes about to reach a
bound are put there at once, and each trial pressure is made feasible before its one convolution,
after which the step along it is exact. The energy therefore falls in every iteration, at one
convolution each.

The iteration runs in single precision on candidate nodes only. A solution is accepted after a
double-precision check on the full window.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rolling._typing import Array
from rolling.contact import _projection, _solver_kernels
from rolling.contact._descent import Candidates, Descent, Effort
from rolling.contact._system import Limits, Sets
from rolling.contact.half_space import HalfSpace

# candidates for contact have a gap below this share of the largest deflection; 0.001 to 0.1 take
# the same iterations
NEAR = 0.01
# Share of the maximum gap that its rounding adds to the violation: with 32 eps some solves converge.
ROUNDING = 128 * np.finfo(float).eps
SINGLE_TOLERANCE = 1e-6  # single precision, 1e-7 of the largest deflection, serves no tighter one


class ContactError(RuntimeError):
    """A contact that cannot be solved: the limit in numbers, or the methods tried and the residual
    they reached.
    """


@dataclass(frozen=True)
class Contact:
    """A solved contact on its window.

    Parameters
    ----------
    pressure : (m, n) array, Pa.
    deflection : (m, n) array, m.
    approach : float, m.
    residual : float. KKT residual: maximum violation of the contact conditions over the maximum
        deflection, from a deflection computed afresh.
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
    close : bool. Whether to iterate only on nodes in or near contact, and check the others after
        convergence. Use it when the start is close to the solution. Default: False.
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
    tolerance : float. Largest KKT residual: violation of the contact conditions over the maximum
        deflection. Default: 1e-5.
    single : bool. Whether to iterate on deflections of single precision while the tolerance is far
        above their error. A solution is accepted in double precision all the same. Default: True.
    """

    tolerance: float = 1e-5
    single: bool = True


def foundation(
    gap: Array, load: float, spacing: float, stiffness: float, hardness: float = np.inf
) -> Array:
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
    (m, n) array, Pa. The smaller of hardness and stiffness times overlap, at the approach that
    carries the load.

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
    limits, free = (
        Limits(float(hardness), float(total)),
        Sets(np.arange(e.size, dtype=np.uint32), e.size, 0),
    )
    pressure = np.empty_like(e)
    slope, _ = _projection.project(np.zeros_like(e), e, 0.0, -stiffness * e, free, limits, pressure)
    # heights so large that springs round the load away: the lowest nodes carry it
    if slope == np.inf:
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
    gap : (m, n) array, m. Undeformed gap.
    load : float, N. Normal load.
    start : WarmStart or None. Default: a Winkler foundation.
    hardness : float, Pa. Largest pressure. Default: infinite, purely elastic.
    edge : (m, n) array, m, or None. Half of the range of gaps over the cell of a node, where a
        patch at the hardness may end within the cell: a node with the share s of its cell in
        contact bears s * hardness at a gap of edge * (1 - 2 s). Default: a cell is in contact as a
        whole or not at all.
    options : SolverOptions or None. Default: SolverOptions().

    Returns
    -------
    Contact. Pressure, deflection and approach, with residual and number of iterations.

    Raises
    ------
    ContactError : the window cannot carry the load, or the solve did not converge; the message has
        residual, iterations and the methods tried.
    ValueError : the start has another shape than the gap.

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
    gap, p = np.ascontiguousarray(gap, dtype=float), np.array(start.pressure, dtype=float)
    if p.shape != gap.shape:
        raise ValueError(
            f"the start has pressures of shape {p.shape}, the gap has shape {gap.shape}"
        )
    u = half_space.deflection(p) if start.deflection is None else start.deflection
    compliance = None
    if edge is not None:
        # A shared cell has gap = edge (1 - 2 p / H): a gap lower by the edge on a node that gives 2
        # edge / H by itself.
        gap, compliance = gap - edge, 2 * edge / hardness
    near, fresh, seen = NEAR if start.close else np.inf, start.deflection is None, 0
    effort = Effort()
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
        if (
            fresh
            and worst <= options.tolerance * u_max
            and abs(p.sum() / limits.total - 1) <= 1e-12
        ):
            return Contact(p, u, float(approach), float(worst / u_max), effort.iterations)
        if effort.is_spent:
            raise ContactError(
                f"the contact solve stopped after {effort.iterations} iterations at a residual of {worst / u_max:.2g},"
                f" {options.tolerance:.2g} was asked for (tried: preconditioned conjugate gradients, {effort.restarts} restarts,"
                f" {effort.plain_steps} plain gradient steps){_rounding_limit(gap, u_max, options)}"
            )
        candidates = Candidates.below(p, gap, v, approach + near * u_max)
        # Not converged though no new node came into sight: single precision is not enough.
        precise = (
            not options.single
            or options.tolerance < SINGLE_TOLERANCE
            or (fresh and candidates.node.size <= seen)
        )
        descent = Descent(
            half_space,
            candidates,
            p,
            gap + v,
            compliance,
            limits,
            options.tolerance * u_max,
            not precise,
        )
        if start.trend is not None and not fresh:
            descent.lead(start.trend.pressure, start.trend.deflection)
        descent.iterate(effort)
        descent.settle(effort)
        p.ravel()[candidates.node] = descent.pressure
        u, fresh = half_space.deflection(p), True
        near, seen = NEAR, candidates.node.size


def _rounding_limit(gap: Array, deflection: float, options: SolverOptions) -> str:
    """Name the tolerance that the rounding of gaps allows, where a tighter one was asked for.

    `deflection` is the maximum deflection [m].
    """
    largest = float(np.abs(gap).max())
    limit = ROUNDING * largest / deflection
    if options.tolerance > limit:
        return ""
    return (
        f"; gaps of up to {largest:.2g} m, rounded in double precision, need a tolerance of at"
        f" least {limit:.2g} for a deflection of {deflection:.2g} m"
    )
