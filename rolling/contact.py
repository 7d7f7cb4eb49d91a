"""One elastic-plastic contact solve: pressures between 0 and the hardness on a window of nodes, under a given load.

min over p of  1/2 p.Cp + e.p   subject to 0 <= p <= H, sum(p) dA = W, by conjugate gradients projected on both bounds, after
Polonsky & Keer, Wear 231 (1999), with three changes: the inverse half-space operator as a short stencil preconditions, nodes
about to reach a bound are put there at once, and each trial pressure is made feasible before its one convolution, after which
the step along it is exact. The energy therefore falls in every iteration, at one convolution each.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rolling import _contact
from rolling.half_space import OWN_COEFFICIENT, HalfSpace, love

Array = NDArray[np.float64]

MAX_ITERATIONS = 1000
NEAR = 0.01  # candidates for contact have a gap below this share of the largest deflection
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
    convolutions: int


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
    slope, _ = _contact.project(nothing, e, 0.0, e.copy(), -stiffness, hardness, everywhere, e.size, 0, total, pressure)
    if slope == np.inf:  # heights so large that springs round the load away: the lowest nodes carry it
        pressure[:] = 0.0
        _contact.settle_load(pressure, e, hardness, total, 0.0)
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
    max_iterations: int = MAX_ITERATIONS,
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
    convolutions_before = half_space.count
    p = np.array(start, dtype=float)
    u = half_space.deflection(p) if deflection is None else deflection
    if edge is not None:
        shape, soft = shape - edge, 2 * edge / hardness
    near, fresh, looked_at = NEAR if nearby else np.inf, deflection is None, 0
    tried = _Tried()
    while True:
        yielding = u if edge is None else u + soft * p
        flat = p.ravel(), shape.ravel(), yielding.ravel(), hardness
        approach, u_max = _contact.state_of(*flat)
        u_max = u_max if edge is None else float(u.max())
        worst = _contact.violation(*flat, approach) if fresh else np.nan
        if not np.isfinite(approach) or not 0 < u_max < np.inf or worst == np.inf:
            raise ContactError(
                "the contact solve met numbers that are not finite: check units of load, modulus and heights"
            )
        if fresh and worst <= tolerance * u_max and abs(p.sum() / total - 1) <= 1e-12:
            convolutions = half_space.count - convolutions_before
            return Contact(p, u, float(approach), float(worst / u_max), tried.iterations, convolutions)
        if tried.stuck > 1 or tried.iterations >= max_iterations or tried.rounds > max_iterations:
            raise ContactError(
                f"the contact solve stopped after {tried.iterations} iterations at a residual of {worst / u_max:.2g},"
                f" {tolerance:.2g} was asked for (tried: preconditioned conjugate gradients, {tried.restarts} restarts,"
                f" {tried.plain_steps} plain gradient steps)"
            )
        node = np.empty(p.size, dtype=np.int64)
        count, *block = _contact.candidates(p, shape, yielding, approach + near * u_max, node)
        # Not converged though nothing new came into sight: single precision is not enough.
        precise = not single or tolerance < SINGLE_TOLERANCE or (fresh and count <= looked_at)
        near, looked_at = NEAR, count
        _iterate(
            half_space,
            shape,
            total,
            p,
            yielding,
            node[:count],
            block,
            u_max,
            tolerance,
            hardness,
            precise,
            max_iterations,
            tried,
            trend if not fresh else None,
            np.empty(0) if edge is None else soft.ravel()[node[:count]],
        )
        u, fresh = half_space.deflection(p), True


@dataclass
class _Tried:
    """What a solve has done so far."""

    iterations: int = 0
    restarts: int = 0
    plain_steps: int = 0
    stuck: int = 0
    rounds: int = 0
    snapping: bool = True


def _iterate(
    half_space: HalfSpace,
    shape: Array,
    total: float,
    pressure: Array,
    deflection: Array,
    node: NDArray[np.int64],
    block: list[int],
    u_max: float,
    tolerance: float,
    cap: float,
    precise: bool,
    max_iterations: int,
    tried: _Tried,
    trend: tuple[Array, Array] | None,
    soft: Array,
) -> None:
    """Conjugate gradients on the candidates `node` within their block, until they hold the conditions; changes `pressure`."""
    first_row, last_row, first_column, last_column = block
    rows, columns = last_row - first_row + 1, last_column - first_column + 1
    transforms = half_space.convolution(rows - 1, columns - 1, single=not precise)
    transformed = transforms.real.ravel()
    p, g = pressure.ravel()[node], shape.ravel()[node] + deflection.ravel()[node]
    size, bordered = node.size, columns + 2
    in_padded, in_bordered = np.empty(size, np.uint32), np.empty(size, np.uint32)
    _contact.places(
        node, shape.shape[1], first_row, first_column, transforms.real.shape[1], bordered, in_padded, in_bordered
    )

    unit = 1.0 / half_space.unit
    stencil, reach = _inverse_stencil() * unit, unit / OWN_COEFFICIENT
    enough = AIM * tolerance * u_max
    give = 1 / (1 + soft * reach)
    grid = np.zeros((rows + 2) * bordered)
    dp, z, active = np.zeros(size), np.empty(size), np.empty(size, np.uint32)
    residual, previous = np.zeros(size), np.zeros(size)
    slope, greatest, zr, length = 0.0, 0.0, 0.0, 1.0
    snap = 0.01 * tolerance * u_max * reach / size if tried.snapping else 0.0
    tried.rounds += 1
    if trend is not None:
        # The first step goes by way of the extrapolation of the last solutions and of the gradient there, whose deflection is
        # known but for what the bounds cut off; from the exact start, with its exact line search, that does no harm.
        q, h = np.empty(size), g + trend[1].ravel()[node]
        if soft.size:
            h += soft * trend[0].ravel()[node]
        if _contact.extrapolate(p, trend[0].ravel()[node], g, cap, total, active, z, dp, q):
            _, approach, _, n_free, n_bound = _contact.advance(
                q,
                h,
                soft,
                give,
                dp,
                transformed,
                in_padded,
                0.0,
                0.0,
                cap,
                reach,
                0.0,
                residual,
                grid,
                in_bordered,
                active,
            )
            transforms.clear(rows)
            slope, *_ = _contact.aim(
                q, h, give, approach, residual, previous, grid, in_bordered, bordered, stencil, 0.0, 1.0, cap, reach, active,
                n_free, n_bound, total, False, z, dp, half_space.unit, in_padded, transformed,
            )  # fmt: skip
            if slope < 0:
                slope, greatest = _contact.step_by_way_of(q, p, g, cap, dp, half_space.unit, in_padded, transformed)
            if slope < 0:
                transforms.apply(rows)
                half_space.count += 1
                tried.iterations += 1
            else:
                slope = 0.0
                dp[:] = 0.0

    while True:
        residual, previous = previous, residual
        best, approach, worst, n_free, n_bound = _contact.advance(
            p,
            g,
            soft,
            give,
            dp,
            transformed,
            in_padded,
            slope,
            greatest,
            cap,
            reach,
            snap,
            residual,
            grid,
            in_bordered,
            active,
        )
        if not worst > enough or tried.iterations >= max_iterations:
            break
        snap = 0.01 * tolerance * u_max * reach / max(n_bound, 1) if tried.snapping else 0.0
        length *= min(max(best, 0.5), 2.0)
        transforms.clear(rows)
        slope, greatest, zr, length, restarts, plain = _contact.aim(
            p, g, give, approach, residual, previous, grid, in_bordered, bordered, stencil, zr, length, cap, reach, active,
            n_free, n_bound, total, best < LEAST_STEP, z, dp, half_space.unit, in_padded, transformed,
        )  # fmt: skip
        tried.restarts += restarts
        tried.plain_steps += plain
        tried.iterations += 1
        if not slope < 0:
            break
        tried.stuck = 0
        transforms.apply(rows)
        half_space.count += 1

    if not worst > enough:
        # What was put on a bound for good took its share of the load along: the free nodes have it, or the nearest to moving.
        if n_free:
            _contact.project(p, g, approach, z, 0.0, cap, active, n_free, 0, total, dp)
            p += dp
        elif abs(p.sum() / total - 1) > 1e-13:
            tried.snapping = False
            _contact.settle_load(p, g, cap, total, 0.0)
    elif not slope < 0 and tried.iterations:
        # Pressures of the order of rounding can pass for free nodes and set the approach: take the projection for the state.
        tried.stuck += 1
        p += dp
        _contact.settle_load(p, g, cap, total, 1e-9 * p.max())
    np.clip(p, 0.0, cap, out=p)
    pressure.ravel()[node] = p
