"""Closed forms and a dense influence-matrix solver to check the fast path against; imports nothing of that path.

All quantities SI. Sources: K. L. Johnson, Contact Mechanics (1985), ch. 3-4 (Hertz); A. E. H. Love, Phil. Trans. R. Soc. A 228
(1929) (uniform pressure on a rectangle); Lee, Kim & Kim, Inventions 10(1), 17 (2025), Fig. 3 (influence matrix, active set).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def hertz_radius(load: float, radius: float, contact_modulus: float) -> float:
    """Contact radius [m] of a smooth elastic sphere: a^3 = 3 W R / (4 E*)."""
    return float((3 * load * radius / (4 * contact_modulus)) ** (1 / 3))


def hertz_pressure(load: float, radius: float, contact_modulus: float) -> float:
    """Peak contact pressure [Pa] of a smooth elastic sphere: p0 = 3 W / (2 pi a^2)."""
    return float(3 * load / (2 * np.pi * hertz_radius(load, radius, contact_modulus) ** 2))


def hertz_approach(load: float, radius: float, contact_modulus: float) -> float:
    """Approach [m] of a smooth elastic sphere: a^2 / R."""
    return hertz_radius(load, radius, contact_modulus) ** 2 / radius


def smooth_release_power(load: float, speed: float, radius: float, contact_modulus: float) -> float:
    """Release power [W] of a smooth elastic rolling sphere: 3 W v a / (16 R), constant in time.

    It is the Hertz pressure over the trailing half of the contact times the rate v x / R at which the deflection falls there.
    """
    return 3 * load * speed * hertz_radius(load, radius, contact_modulus) / (16 * radius)


def left_end_excess(step: float, contact_radius: float) -> float:
    """Relative excess of the left-end release rule over the mean rule on a smooth sphere, first order: 4 step / (3 a)."""
    return 4 * step / (3 * contact_radius)


def influence_matrix(points: Array, spacing: float, contact_modulus: float) -> Array:
    """Deflection [m/Pa] at each node by unit pressure on each other node's square cell (Love 1929).

    Parameters
    ----------
    points : (k, 2) positions [m], nodes of a square grid.
    spacing : side of the cells [m].
    contact_modulus : E* [Pa].

    Returns
    -------
    (k, k) matrix, symmetric positive definite.
    """
    half = spacing / 2
    dx = points[:, None, 0] - points[None, :, 0]
    dy = points[:, None, 1] - points[None, :, 1]
    total = np.zeros_like(dx)
    # Corner antiderivative of 1/r, each logarithm written as it stands in Love's paper; corners never fall on an axis.
    for sign, a, b in ((1, half, half), (1, -half, -half), (-1, half, -half), (-1, -half, half)):
        x, y = dx + a, dy + b
        r = np.hypot(x, y)
        total += sign * (x * np.log(y + r) + y * np.log(x + r))
    return total / (np.pi * contact_modulus)


def dense_contact(
    shape: Array, load: float, spacing: float, contact_modulus: float, hardness: float = np.inf
) -> tuple[Array, float]:
    """Contact pressure by the article's method: influence matrix on the contact set, direct solves, the set changed until it holds.

    Parameters
    ----------
    shape : (m, n) undeformed gap [m] at unit node spacing `spacing`.
    load : normal load [N].
    hardness : pressure cap [Pa].

    Returns
    -------
    pressure (m, n) [Pa] and approach [m].

    Raises
    ------
    RuntimeError : the sets did not settle in 500 changes (the plain method has no guarantee to).
    """
    m, n = shape.shape
    grid = np.stack(np.meshgrid(np.arange(m) * spacing, np.arange(n) * spacing, indexing="ij"), axis=-1).reshape(-1, 2)
    matrix = influence_matrix(grid, spacing, contact_modulus)
    e, total = shape.ravel(), load / spacing**2
    order = np.argsort(e)
    free = np.zeros(e.size, dtype=bool)
    free[order[: max(4, e.size // 8)]] = True
    capped = np.zeros_like(free)
    scale = np.ptp(e) + load / (contact_modulus * spacing)
    for _ in range(500):
        if not free.any():  # all on a bound: the best of the others takes up, or gives up, what is missing
            gap = e + matrix @ np.where(capped, hardness, 0.0)
            short = hardness * capped.sum() < total
            bound = np.flatnonzero(~capped if short else capped)
            node = bound[np.argmin(gap[bound]) if short else np.argmax(gap[bound])]
            free[node], capped[node] = True, False
        inside = np.flatnonzero(free)
        # Unknown: pressures of the free nodes and the approach; known: hardness on the capped ones.
        system = np.zeros((inside.size + 1, inside.size + 1))
        system[:-1, :-1] = matrix[np.ix_(inside, inside)]
        system[:-1, -1], system[-1, :-1] = -1.0, 1.0
        known = matrix[np.ix_(inside, np.flatnonzero(capped))].sum(axis=1) * hardness if capped.any() else 0.0
        right = np.append(-e[inside] - known, total - (hardness * capped.sum() if capped.any() else 0.0))
        solved = np.linalg.solve(system, right)
        p = np.where(capped, hardness if capped.any() else 0.0, 0.0)
        p[inside] = solved[:-1]
        approach = float(solved[-1])
        gap = e + matrix @ p - approach
        low, high = free & (p < 0), free & (p > hardness)
        enter = ~free & ~capped & (gap < -1e-13 * scale)
        leave = capped & (gap > 1e-13 * scale)
        if not (low.any() or high.any() or enter.any() or leave.any()):
            return p.reshape(m, n), approach
        # Pressures are put right before gaps are: both at once can cycle.
        if low.any() or high.any():
            enter[:], leave[:] = False, False
        free = (free & ~low & ~high) | enter | leave
        capped = (capped & ~leave) | high
    raise RuntimeError("the active set did not settle in 500 changes")
