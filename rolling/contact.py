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
from rolling.half_space import HalfSpace, love

Array = NDArray[np.float64]

MAX_ITERATIONS = 1000


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
    nothing, pressure, change = np.zeros_like(e), np.empty_like(e), np.empty_like(e)
    everywhere = np.arange(e.size)
    _contact.project(nothing, e, 0.0, nothing, e, -stiffness, hardness, everywhere, e.size, 0, total, pressure, change)
    return pressure.reshape(shape.shape)


def solve(
    half_space: HalfSpace,
    shape: Array,
    load: float,
    start: Array,
    tolerance: float,
    hardness: float = np.inf,
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

    Raises
    ------
    ContactError : not converged; the message has residual, iterations and what was tried.
    """
    spacing = half_space.spacing
    total = load / spacing**2
    unit = np.pi * half_space.contact_modulus / spacing
    stencil = _inverse_stencil() * unit
    reach = unit / float(love(np.zeros(1), np.zeros(1))[0, 0])
    convolutions_before = half_space.count

    e = np.ascontiguousarray(shape).ravel()
    p = np.array(start, dtype=float).ravel()
    size, columns = p.size, shape.shape[1]
    u = half_space.deflection(p.reshape(shape.shape)).ravel()
    residual, previous = np.zeros(size), np.zeros(size)
    trial, dp, du = p.copy(), np.zeros(size), np.zeros(size)
    z, direction = np.empty(size), np.empty(size)
    free, active = np.zeros(size, dtype=np.bool_), np.empty(size, dtype=np.int64)
    length, zr_before, t, fresh, stuck = 1.0, 0.0, 0.0, True, False
    snap, snapping = 0.01 * tolerance * float(u.max()) * reach / size, True
    restarts = plain_steps = 0

    for iteration in range(max_iterations):
        residual, previous = previous, residual
        approach, worst, u_max, n_free, n_bound = _contact.update_and_sort(
            p, u, trial, du, t, e, hardness, reach, snap, residual, free, active
        )
        if not np.isfinite(worst) or not u_max > 0:
            raise ContactError(
                "the contact solve met numbers that are not finite: check units of load, modulus and heights"
            )
        if worst <= tolerance * u_max:
            if fresh and abs(p.sum() / total - 1) <= 1e-12:
                return Contact(
                    p.reshape(shape.shape),
                    u.reshape(shape.shape),
                    float(approach),
                    float(worst / u_max),
                    iteration,
                    half_space.count - convolutions_before,
                )
            # u was carried along; what is accepted must hold for the deflection of this very pressure, and carry the load.
            if n_free:
                direction[:n_free] = 0.0
            else:
                # Put on a bound for good, a last free node took its share of the load along: let the nearest to moving have it.
                snapping = False
                n_free = size
                active[:] = np.arange(size)
                direction[:] = -reach * (e + u - approach)
            _contact.project(p, e, approach, u, direction, 1.0, hardness, active, n_free, 0, total, trial, dp)
            p[:] = trial
            u = half_space.deflection(p.reshape(shape.shape)).ravel()
            residual, previous = previous, residual
            t, fresh = 0.0, True
            snap = snap if snapping else 0.0
            continue

        snap = 0.01 * tolerance * u_max * reach / max(n_bound, 1) if snapping else 0.0
        _contact.precondition(residual, free, active, n_free, columns, stencil, z)
        zr, change = _contact.conjugate(z, residual, previous, active, n_free)
        beta = max(0.0, change / zr_before) if zr_before > 0 else 0.0
        zr_before = zr
        nodes = active[:n_free]
        direction[:n_free] = -z[:n_free]
        if beta:
            direction[:n_free] += beta / length * dp[nodes]
        else:
            length = 1.0
        slope, greatest = _contact.project(
            p, e, approach, u, direction, length, hardness, active, n_free, n_bound, total, trial, dp
        )
        if not slope < 0 and beta:
            restarts += 1
            direction[:n_free] = -z[:n_free]
            length = 1.0
            slope, greatest = _contact.project(
                p, e, approach, u, direction, length, hardness, active, n_free, n_bound, total, trial, dp
            )
        if not slope < 0:
            # The plain projected gradient, of all nodes, always descends, short of a solution.
            plain_steps += 1
            active[:] = np.arange(size)
            direction[:] = -reach * (e + u - approach)
            length, zr_before = 1.0, 0.0
            slope, greatest = _contact.project(
                p, e, approach, u, direction, length, hardness, active, size, 0, total, trial, dp
            )
        if not slope < 0:
            if stuck:
                break
            # Pressures of the order of rounding can pass for free nodes and set the approach: take the projection for the state.
            stuck = True
            p[:] = trial
            u = half_space.deflection(p.reshape(shape.shape)).ravel()
            t, fresh = 0.0, True
            continue
        stuck = False
        half_space.deflection(dp.reshape(shape.shape), out=du.reshape(shape.shape))
        curvature = _contact.dot(dp, du)
        best = -slope / curvature if curvature > 0 else 1.0
        t = min(best, greatest)
        length *= min(max(best, 0.5), 2.0)
        fresh = False

    raise ContactError(
        f"the contact solve stopped after {iteration + 1} iterations at a residual of {worst / u_max:.2g},"
        f" {tolerance:.2g} was asked for (tried: preconditioned conjugate gradients, {restarts} restarts,"
        f" {plain_steps} plain gradient steps)"
    )
