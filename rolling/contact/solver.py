"""Contact solve: pressures between 0 and the hardness on a window, under a given load.

It minimizes 1/2 p.Cp + e.p over p subject to 0 <= p <= H and sum(p) dA = W, by conjugate gradients
projected on both bounds, after Polonsky & Keer, Wear 231 (1999). The solver differs from the paper
in four points: a sparse model problem and its far field on a coarse grid precondition and predict
which nodes go to a bound, these nodes are put on it at once, each trial pressure is made feasible
before its single convolution, after which the step along it is exact, and the last step goes into
the final check without a convolution of its own.

The iteration runs in single precision on candidate nodes only. A solution is accepted after a
double-precision check on the full window.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite

import numpy as np

from rolling._typing import Array
from rolling.contact import _march_kernels, _projection, _state_kernels
from rolling.contact._descent import AIM, AIM_FIRST, BlendedEdges, Candidates, Descent, Effort, Goal
from rolling.contact._system import Limits, Sets
from rolling.contact.half_space import OWN_COEFFICIENT, HalfSpace

# Candidates for contact have a gap below this share of the maximum deflection; shares from 0.001 to
# 0.1 take the same number of iterations.
NEAR = 0.01
# Share of the maximum gap that its rounding adds to the violation. Below 32 eps some solves still
# converge, so the limit that is named is four times that.
ROUNDING = 128 * np.finfo(float).eps
# Single precision, with an error of 1e-7 of the maximum deflection, serves no tighter tolerance.
SINGLE_TOLERANCE = 1e-6
# This share of a node's deflection by the hardness on its own cell is the half range of gaps within
# the cell that pressures below the hardness level. At 0.15 to 0.3 scenes that hardly yield keep the
# error of sharp edges (measured on three scenes, by 0.3 dB); at 0 the rims of elastic contact grow
# soft.
LEVELLED = 0.3
_NO_EDGE = np.empty(0)


class ContactError(RuntimeError):
    """Error of a contact that cannot be solved.

    It tells the limit in numbers, or the methods tried and the residual that they reached.
    """


@dataclass(frozen=True)
class Contact:
    """Solved contact on its window.

    Parameters
    ----------
    pressure : (m, n) array, Pa
        Contact pressure.
    deflection : (m, n) array, m
        Deflection of both bodies.
    approach : float, m
        Approach of sphere and plate.
    max_deflection : float, m
        Maximum deflection.
    residual : float
        KKT residual: maximum violation of the contact conditions over the maximum deflection, from
        a recomputed deflection.
    iterations : int
        Number of iterations of the solve.
    edge : (m, n) array, m, or None
        Half the range of gaps over the cell of each node, where edges are blended.
    edge_share : float
        Share of the range of gaps over each cell that its edge takes: 1 where the contact yields in
        full, less where it hardly yields, and 0 where all edges are sharp.
    """

    pressure: Array
    deflection: Array
    approach: float
    max_deflection: float
    residual: float
    iterations: int
    edge: Array | None = None
    edge_share: float = 0.0


@dataclass(frozen=True)
class Previous:
    """Contact at the position before the start, which a solve extrapolates.

    Parameters
    ----------
    pressure : (m, n) array, Pa
        Pressure on the window of that position; other nodes were unloaded.
    deflection : (m, n) array, m
        Deflection there; that of other nodes is unknown, and taken as unchanged.
    row, column : int
        First node of that window in the window of the solve; they may be negative.
    """

    pressure: Array
    deflection: Array
    row: int
    column: int


@dataclass(frozen=True)
class WarmStart:
    """Pressures to start a solve from, with all known data about them.

    Parameters
    ----------
    pressure : (m, n) array, Pa
        Pressure between 0 and the hardness that carries the load to rounding.
    deflection : (m, n) array, m, or None
        Deflection by `pressure`. Default: it is computed.
    previous : Previous or None
        Contact at the position before, used where `deflection` is given. Default: none.
    close : bool
        If true, iterate only on nodes in or near contact and check the others after convergence.
        Use it when the start is close to the solution. Default: false.
    sharp : bool
        If true, try sharp edges before blended edges. Use it when the previous position hardly
        yields. Default: false.
    """

    pressure: Array
    deflection: Array | None = None
    previous: Previous | None = None
    close: bool = False
    sharp: bool = False


@dataclass(frozen=True)
class SolverOptions:
    """Accuracy of a solve.

    Parameters
    ----------
    tolerance : float
        Maximum KKT residual: violation of the contact conditions over the maximum deflection.
        Default: 1e-5.
    single : bool
        If true, iterate on deflections in single precision while the tolerance is far above their
        error. A solution is accepted in double precision in any case. Default: true.
    """

    tolerance: float = 1e-5
    single: bool = True

    @property
    def serves_single(self) -> bool:
        """Whether a solve may iterate in single precision."""
        return self.single and self.tolerance >= SINGLE_TOLERANCE


def own_deflection(half_space: HalfSpace, hardness: float) -> float:
    """Return the deflection of a node [m] by the hardness on its own cell."""
    return float(half_space.unit * OWN_COEFFICIENT * hardness)


def levelled_range(half_space: HalfSpace, hardness: float) -> float:
    """Return half of the range of gaps over a cell [m] that pressures below the hardness level."""
    return LEVELLED * own_deflection(half_space, hardness)


def foundation(
    gap: Array, load: float, spacing: float, stiffness: float, hardness: float = np.inf
) -> Array:
    """Solve the same contact on a Winkler foundation, for a cold start.

    Parameters
    ----------
    gap : (m, n) array, m
        Undeformed gap.
    load : float, N
        Normal load.
    spacing : float, m
        Node spacing.
    stiffness : float, Pa/m
        Stiffness of the foundation; 4 E* / (pi a) fits a Hertz contact of radius a.
    hardness : float, Pa
        Maximum pressure. Default: infinite.

    Returns
    -------
    (m, n) array, Pa
        Minimum of hardness and stiffness times overlap, at the approach that carries the load.

    Raises
    ------
    ContactError
        The window cannot carry the load.
    """
    total = load / spacing**2
    if total > hardness * gap.size:
        raise ContactError(
            f"a load of {load:g} N is more than the surface can carry: hardness {hardness:g} Pa"
            f" times {gap.size * spacing**2:.4g} m2 is {hardness * gap.size * spacing**2:.4g} N"
        )
    e = np.ascontiguousarray(gap, dtype=float).ravel()
    limits, free = (
        Limits(float(hardness), float(total)),
        Sets(np.arange(e.size, dtype=np.uint32), e.size, 0),
    )
    pressure = np.empty_like(e)
    slope, _ = _projection.project(np.zeros_like(e), e, 0.0, -stiffness * e, free, limits, pressure)
    # Heights may be so large that rounding of the springs loses the load. The lowest nodes then
    # carry it.
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
    shape: Array | None = None,
    options: SolverOptions | None = None,
) -> Contact:
    """Solve one contact under a normal load on a window of nodes.

    The window must hold the whole contact, because all nodes outside count as open.

    Parameters
    ----------
    half_space : HalfSpace
        Pressure to deflection.
    gap : (m, n) array, m
        Undeformed gap.
    load : float, N
        Normal load.
    start : WarmStart or None
        Start of the iteration. Default: a Winkler foundation.
    hardness : float, Pa
        Maximum pressure. Default: infinite, purely elastic.
    shape : (m, n) array, m, or None
        Undeformed gap as it continues within cells, for blended edges: a patch at the hardness then
        ends within a cell, where the gap of its own solution says (`cell_ranges`). Default: a cell
        is in contact as a whole or not at all.
    options : SolverOptions or None
        Accuracy. Default: SolverOptions().

    Returns
    -------
    Contact
        Pressure, deflection and approach, with residual and number of iterations.

    Raises
    ------
    ContactError
        The window cannot carry the load, or the solve did not converge; the message has residual,
        iterations and the methods tried.
    ValueError
        The start has another shape than the gap.

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
    gap = np.ascontiguousarray(gap, dtype=float)
    if shape is None:
        return _converge(half_space, gap, limits, start, None, options)
    return _blend(half_space, gap, shape, limits, start, options)


def _blend(
    half_space: HalfSpace,
    gap: Array,
    shape: Array,
    limits: Limits,
    start: WarmStart,
    options: SolverOptions,
) -> Contact:
    """Solve with blended edges where the contact yields, and with sharp edges where it does not.

    Between both the maximum overlap at the hardness, over the half range that pressures level, is
    the share of their range that edges take. It is the overlap of the solution with whole edges,
    so that the contact follows continuously from its surface and load.
    """
    hardness, iterations = limits.hardness, 0
    levelled, sharp = levelled_range(half_space, hardness), None
    if start.sharp:
        # No contact is known to yield with blended edges that does not yield with sharp edges.
        sharp = _sharp(half_space, gap, limits, start, options)
        if sharp.pressure.max() < hardness:
            return sharp
        start, iterations = _continued(sharp), sharp.iterations
    edges = BlendedEdges(gap, shape, levelled)
    solved = _converge(half_space, gap, limits, start, edges, options)
    iterations += solved.iterations
    p, u = solved.pressure.ravel(), solved.deflection.ravel()
    overlap = _state_kernels.yielding_overlap(
        gap.ravel(), u, p, hardness, solved.approach, levelled
    )
    if overlap < levelled and _state_kernels.has_partial_cells(p, edges.edge.ravel(), hardness):
        start = _continued(solved)
        if overlap > 0:
            edges = BlendedEdges(gap, shape, levelled, overlap / levelled)
            solved = _converge(half_space, gap, limits, start, edges, options)
            iterations += solved.iterations
        elif sharp is None:
            solved = _sharp(half_space, gap, limits, start, options)
            iterations += solved.iterations
        else:
            solved = sharp
    return replace(solved, iterations=iterations)


def _continued(contact: Contact) -> WarmStart:
    """Start from the solution of the same contact with other edges."""
    return WarmStart(contact.pressure, contact.deflection, close=True)


def _sharp(
    half_space: HalfSpace, gap: Array, limits: Limits, start: WarmStart, options: SolverOptions
) -> Contact:
    """Solve with sharp edges where edges may be blended: the range over each cell is zero."""
    contact = _converge(half_space, gap, limits, start, None, options)
    return replace(contact, edge=np.zeros_like(gap))


def _converge(
    half_space: HalfSpace,
    gap: Array,
    limits: Limits,
    start: WarmStart,
    edges: BlendedEdges | None,
    options: SolverOptions,
) -> Contact:
    """Iterate from a start until the contact conditions hold."""
    p, u = _begin(half_space, gap, start)
    if edges is not None:
        edges.find(u if start.previous is None else _extrapolated(u, start.previous))
    near, fresh, seen = NEAR if start.close else np.inf, start.deflection is None, 0
    effort, exhausted, carried = Effort(), False, False
    while True:
        g, (approach, u_max, worst) = _state(gap, u, p, edges, limits, fresh)
        share = AIM if effort.rounds else AIM_FIRST
        goal = Goal(options.tolerance, u_max, share)
        accurate = fresh and worst <= goal.allowed
        if accurate and (carried or abs(p.sum() / limits.total - 1) <= 1e-12):
            edge, share = (None, 0.0) if edges is None else (edges.edge, edges.share)
            measures = float(approach), float(u_max), float(worst / u_max)
            return Contact(p, u, *measures, effort.iterations, edge, share)
        if effort.is_spent:
            limit = _rounding_limit(gap, u_max, options)
            raise _not_converged(effort, worst / u_max, options.tolerance, limit)
        highest = approach + near * u_max
        candidates = Candidates.below(p, g, highest, half_space.subcells, edges is not None)
        # Where a descent went as far as it could and left no new candidates, single precision does
        # not suffice.
        single = options.serves_single and not (
            exhausted and candidates.node.size <= seen and (edges is None or effort.rounds > 4)
        )
        descent = Descent(half_space, candidates, p, g, edges, limits, goal, single)
        if start.previous is not None and not fresh:
            before = start.previous
            offset = before.row, before.column
            descent.lead(p, u, before.pressure, before.deflection, offset)
        descent.iterate(effort)
        carried = descent.settle(effort)
        exhausted = descent.is_exhausted
        p.ravel()[candidates.node] = descent.pressure
        u, fresh = half_space.deflection(p), True
        near, seen = NEAR, candidates.node.size
        if edges is not None:
            edges.find(u)


def _begin(half_space: HalfSpace, gap: Array, start: WarmStart) -> tuple[Array, Array]:
    """Return the pressure [Pa] and its deflection [m] that a solve begins with."""
    p = np.array(start.pressure, dtype=float)
    if p.shape != gap.shape:
        raise ValueError(
            f"the start has pressures of shape {p.shape}, the gap has shape {gap.shape}"
        )
    return p, half_space.deflection(p) if start.deflection is None else start.deflection


def _extrapolated(deflection: Array, previous: Previous) -> Array:
    """Return a deflection [m] that changes once more as it did since the previous position."""
    expected = np.empty_like(deflection)
    _march_kernels.extrapolate(
        deflection, previous.deflection, previous.row, previous.column, expected
    )
    return expected


def _state(
    gap: Array, u: Array, p: Array, edges: BlendedEdges | None, limits: Limits, fresh: bool
) -> tuple[Array, tuple[float, float, float]]:
    """Return the deformed gap before the approach is subtracted, and measures of the state.

    The measures are approach [m], maximum deflection [m] and maximum violation [m].

    Parameters
    ----------
    gap : (m, n) array, m
        Undeformed gap.
    u : (m, n) array, m
        Deflection.
    p : (m, n) array, Pa
        Pressure.
    edges : BlendedEdges or None
        Edges within cells.
    limits : Limits
        Hardness and load.
    fresh : bool
        Whether the deflection is computed afresh. If not, the violation means nothing.

    Raises
    ------
    ContactError
        A number is not finite.
    """
    g = np.empty_like(gap)
    edge = _NO_EDGE if edges is None else edges.edge.ravel()
    u_max = float(u.max())
    approach, worst = _state_kernels.state_of(
        gap.ravel(), u.ravel(), p.ravel(), edge, limits.hardness, g.ravel(), fresh
    )
    if not isfinite(approach) or not 0 < u_max < inf or (fresh and worst == inf):
        raise ContactError(
            "the contact solve met numbers that are not finite: check units of load, modulus"
            " and heights"
        )
    return g, (approach, u_max, worst)


def _not_converged(effort: Effort, residual: float, tolerance: float, limit: str) -> ContactError:
    """Make the error of a solve that stopped at a residual above the tolerance."""
    return ContactError(
        f"the contact solve stopped after {effort.iterations} iterations at a residual of"
        f" {residual:.2g}, {tolerance:.2g} was asked for (tried:"
        f" preconditioned conjugate gradients, {effort.restarts} restarts,"
        f" {effort.plain_steps} plain gradient steps){limit}"
    )


def _rounding_limit(gap: Array, deflection: float, options: SolverOptions) -> str:
    """Name the tolerance that the rounding of gaps allows, where a tighter one was asked for.

    `deflection` is the maximum deflection [m].
    """
    highest = float(np.abs(gap).max())
    limit = ROUNDING * highest / deflection
    if options.tolerance > limit:
        return ""
    return (
        f"; gaps of up to {highest:.2g} m, rounded in double precision, need a tolerance of at"
        f" least {limit:.2g} for a deflection of {deflection:.2g} m"
    )
