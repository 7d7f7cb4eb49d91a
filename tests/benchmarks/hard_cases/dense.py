"""A dense contact solver that checks the fast solver and shares no code with it.

Sources: A. E. H. Love, Phil. Trans. R. Soc. A 228 (1929) (uniform pressure on a rectangle); Lee,
Kim & Kim, Inventions 10(1), 17 (2025), Fig. 3 (influence matrix, active set).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array


def influence_matrix(points: Array, spacing: float, contact_modulus: float) -> Array:
    """Compute the deflection of each node by unit pressure on each square cell (Love 1929).

    Parameters
    ----------
    points : (k, 2) array, m. Positions of nodes of a square grid.
    spacing : float, m. Side of the cells.
    contact_modulus : float, Pa. E* of both bodies.

    Returns
    -------
    (k, k) array, m/Pa. A symmetric positive definite matrix.
    """
    half = spacing / 2
    dx = points[:, None, 0] - points[None, :, 0]
    dy = points[:, None, 1] - points[None, :, 1]
    total = np.zeros_like(dx)
    # Corner antiderivative of 1/r, each logarithm written as it stands in Love's paper; corners
    # never fall on an axis.
    for sign, a, b in ((1, half, half), (1, -half, -half), (-1, half, -half), (-1, -half, half)):
        x = dx + a
        y = dy + b
        r = np.hypot(x, y)
        total += sign * (x * np.log(y + r) + y * np.log(x + r))
    return total / (np.pi * contact_modulus)


def dense_contact(
    shape: Array, load: float, spacing: float, contact_modulus: float, hardness: float = np.inf
) -> tuple[Array, float]:
    """Solve a contact by the article's method: influence matrix, direct solves, active set.

    Parameters
    ----------
    shape : (m, n) array, m. Undeformed gap.
    load : float, N. Normal load.
    spacing : float, m. Node spacing.
    contact_modulus : float, Pa. E* of both bodies.
    hardness : float, Pa. Maximum pressure. Default: infinite.

    Returns
    -------
    pressure : (m, n) array, Pa.
    approach : float, m.

    Raises
    ------
    RuntimeError : the sets did not settle in 500 changes; their convergence is not guaranteed.
    """
    m, n = shape.shape
    grid = np.stack(
        np.meshgrid(np.arange(m) * spacing, np.arange(n) * spacing, indexing="ij"), axis=-1
    ).reshape(-1, 2)
    matrix = influence_matrix(grid, spacing, contact_modulus)
    e = shape.ravel()
    total = load / spacing**2
    order = np.argsort(e)
    free = np.zeros(e.size, dtype=bool)
    free[order[: max(4, e.size // 8)]] = True
    capped = np.zeros_like(free)
    scale = np.ptp(e) + load / (contact_modulus * spacing)
    for _ in range(500):
        # all nodes are on a bound: the node nearest to release balances the load
        if not free.any():
            gap = e + matrix @ np.where(capped, hardness, 0.0)
            short = hardness * capped.sum() < total
            bound = np.flatnonzero(~capped if short else capped)
            node = bound[np.argmin(gap[bound]) if short else np.argmax(gap[bound])]
            free[node] = True
            capped[node] = False
        p, approach = _solve_sets(matrix, e, free, capped, hardness, total)
        gap = e + matrix @ p - approach
        low = free & (p < 0)
        high = free & (p > hardness)
        enter = ~free & ~capped & (gap < -1e-13 * scale)
        leave = capped & (gap > 1e-13 * scale)
        if not (low.any() or high.any() or enter.any() or leave.any()):
            return p.reshape(m, n), approach
        # Pressures are corrected before gaps, because simultaneous corrections can cycle.
        if low.any() or high.any():
            enter[:] = False
            leave[:] = False
        free = (free & ~low & ~high) | enter | leave
        capped = (capped & ~leave) | high
    raise RuntimeError("the active set did not settle in 500 changes")


def _solve_sets(
    matrix: Array,
    gap: Array,
    free: NDArray[np.bool_],
    capped: NDArray[np.bool_],
    hardness: float,
    total: float,
) -> tuple[Array, float]:
    """Solve for the pressures of the free nodes and the approach.

    The capped nodes bear the hardness.
    """
    inside = np.flatnonzero(free)
    system = np.zeros((inside.size + 1, inside.size + 1))
    system[:-1, :-1] = matrix[np.ix_(inside, inside)]
    system[:-1, -1] = -1.0
    system[-1, :-1] = 1.0
    known = (
        matrix[np.ix_(inside, np.flatnonzero(capped))].sum(axis=1) * hardness
        if capped.any()
        else 0.0
    )
    right = np.append(
        -gap[inside] - known, total - (hardness * capped.sum() if capped.any() else 0.0)
    )
    solved = np.linalg.solve(system, right)
    p = np.where(capped, hardness if capped.any() else 0.0, 0.0)
    p[inside] = solved[:-1]
    return p, float(solved[-1])
