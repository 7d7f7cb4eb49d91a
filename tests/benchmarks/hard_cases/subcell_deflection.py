"""A second implementation of the deflection of sub-cells by way of whole cells.

It uses plain arrays and scipy's convolution, and shares no code with the solver.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from acoustics.arrays import Array

Distances = NDArray[np.signedinteger]
Coefficients = Callable[[Distances, Distances], Array]


def interpolation(r: int) -> Array:
    """Solve for the parabola of three cells; return their weights (r, 3) in it.

    The parabola has their first and second differences, and the mean of the middle cell over its r
    sub-cells.
    """
    x = (np.arange(r) + 0.5) / r - 0.5
    # rows: mean over the sub-cells, central difference, second difference of 1, x, x^2
    conditions = np.array([[1.0, x.mean(), np.mean(x**2)], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]])
    given = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 1.0], [1.0, -2.0, 1.0]])
    weights: Array = np.stack([np.ones(r), x, x**2], axis=1) @ np.linalg.solve(conditions, given)
    return weights


def deflection(p: Array, r: int, coefficients: Coefficients) -> Array:
    """Compute the deflection of sub-cells, for pi E* = spacing of sub-cells = 1.

    Parameters
    ----------
    p : (m, n) array
        Pressure on sub-cells; m and n are whole numbers of cells.
    r : int
        Sub-cells along the side of a cell.
    coefficients : callable
        Function of the distances of nodes, which broadcast.

    Returns
    -------
    (m, n) array
        Deflection of the sub-cells.
    """
    m = p.shape[0] // r
    n = p.shape[1] // r
    along = _matrix(m, r)
    across = _matrix(n, r)
    cells = along.T @ p @ across / r**2  # with a border of one cell
    between = _between(m + 2, n + 2, r, coefficients)
    smooth = fftconvolve(cells, between)[m + 1 : 2 * m + 3, n + 1 : 2 * n + 3]
    result: Array = along @ smooth @ across.T + _within(p, r, coefficients)
    return result


def _matrix(cells: int, r: int) -> Array:
    """Return the interpolation (cells r, cells + 2) along one axis."""
    matrix = np.zeros((cells * r, cells + 2))
    for i in range(cells):
        matrix[i * r : (i + 1) * r, i : i + 3] = interpolation(r)
    return matrix


def _between(m: int, n: int, r: int, coefficients: Coefficients) -> Array:
    """Return the mean deflection of a cell by the mean pressure of another cell.

    The distances are all within (m, n) cells.
    """
    rows = np.arange(1 - m * r, m * r)
    columns = np.arange(1 - n * r, n * r)
    triangle = np.convolve(np.ones(r), np.ones(r)) / r
    fine = coefficients(rows[:, None], columns[None, :])
    mean = fftconvolve(fine, np.outer(triangle, triangle), mode="same")
    middle = m * r - 1, n * r - 1
    picked: Array = mean[middle[0] - (m - 1) * r :: r, middle[1] - (n - 1) * r :: r]
    return picked[: 2 * m - 1, : 2 * n - 1]


def _within(p: Array, r: int, coefficients: Coefficients) -> Array:
    """Return the corrections of the deflections by the pressures within the same cell.

    A correction is the exact deflection less the deflection by way of the cells.
    """
    i, j = (k.ravel() for k in np.indices((r, r)))
    exact = coefficients(i[:, None] - i[None, :], j[:, None] - j[None, :])
    along = _matrix(1, r)
    both = np.kron(along, along)
    a, b = (k.ravel() for k in np.indices((3, 3)))
    between = _between(3, 3, r, coefficients)[
        2 + a[:, None] - a[None, :], 2 + b[:, None] - b[None, :]
    ]
    block = exact - both @ between @ both.T / r**2
    m = p.shape[0] // r
    n = p.shape[1] // r
    own = p.reshape(m, r, n, r).transpose(0, 2, 1, 3).reshape(m, n, r * r) @ block
    result: Array = own.reshape(m, n, r, r).transpose(0, 2, 1, 3).reshape(m * r, n * r)
    return result
