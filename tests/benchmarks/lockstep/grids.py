"""The costly operations of a batch on whole grids, by an array library (numpy, cupy).

All grids are arrays (k, rows, columns) of single precision. `xp` is the module of the library.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rolling.contact._system import BORDER
from rolling.contact.half_space import half_spectrum, love

STILL = 2  # nodes on each side of a grid that never move


def spectrum(xp: Any, rows: int, columns: int, unit: float) -> Any:
    """Return the transform of Love's coefficients on a grid padded to twice its size.

    `unit` is the deflection per pressure and coefficient [m/Pa].
    """
    m = 2 * rows
    n = 2 * columns
    half = half_spectrum(m, n, 1, love)
    along = np.minimum(np.arange(m), m - np.arange(m))
    return xp.asarray((unit * half[along]).astype(np.float32))


def deflect(xp: Any, pressure: Any, factors: Any) -> Any:
    """Return the deflection by the pressure on all grids: k transforms there and back at once."""
    rows, columns = pressure.shape[1:]
    padded = (2 * rows, 2 * columns)
    frequencies = xp.fft.rfft2(pressure, s=padded, axes=(1, 2)) * factors
    return xp.fft.irfft2(frequencies, s=padded, axes=(1, 2))[:, :rows, :columns]


def around_nodes(moved: Any, values: Any) -> Any:
    """Return the stencil of the model times the moves, without its centre, off the border.

    `values` are side, corner, second side, beside it and second corner.
    """
    side, corner, second, beside, far = values

    def at(i: int, j: int) -> Any:
        """Return the moves so many rows and columns away."""
        rows, columns = moved.shape[1:]
        return moved[:, STILL + i : rows - STILL + i, STILL + j : columns - STILL + j]

    def both(i: int, j: int) -> Any:
        """Return the sum at both signs of both distances."""
        if j == 0:
            return at(i, 0) + at(-i, 0)
        if i == 0:
            return at(0, j) + at(0, -j)
        return (at(i, j) + at(i, -j)) + (at(-i, j) + at(-i, -j))

    return (
        side * (both(1, 0) + both(0, 1))
        + corner * both(1, 1)
        + second * (both(2, 0) + both(0, 2))
        + beside * (both(1, 2) + both(2, 1))
        + far * both(2, 2)
    )


def settle(
    xp: Any, change: Any, gap: Any, bounds: tuple[Any, Any], values: Any, sweeps: int
) -> tuple[Any, Any]:
    """Settle the model of all grids by Jacobi sweeps; return the changes and the gaps.

    Arguments and algorithm are those of `settle_model` of the present solver, on all nodes but
    STILL on each side, which are zero in the answer.
    """
    inner = (slice(None), slice(STILL, -STILL), slice(STILL, -STILL))
    low, high = (bound[inner] for bound in bounds)
    closing = change[inner] - gap[inner]
    moved = xp.zeros_like(change)
    moved[inner] = xp.clip(closing, low, high) - change[inner]
    changed = xp.zeros_like(change)
    opened = xp.zeros_like(gap)
    for sweep in range(1, sweeps + 1):
        bounded = xp.clip(closing, low, high)
        added = around_nodes(moved, values)
        if sweep == sweeps:
            changed[inner] = bounded + added
            opened[inner] = bounded - closing
            break
        before = bounded - closing
        closing = closing + added
        moved[inner] = (xp.clip(closing, low, high) - closing) - before
    return changed, opened


def tile_weights(xp: Any, nodes: int, tile: int) -> Any:
    """Return the bilinear weights (coarse nodes, nodes) of the far field, zero on the border."""
    weights = np.zeros(((nodes - 1) // tile + 2, nodes), np.float32)
    node = np.arange(BORDER, nodes - BORDER)
    share = node % tile / tile
    weights[node // tile, node] = 1 - share
    weights[node // tile + 1, node] = share
    return xp.asarray(weights)


def restrict(values: Any, along: Any, across: Any) -> Any:
    """Return the sums of all grids on their coarse grids, by the weights along and across."""
    return along @ values @ across.T


def prolong(field: Any, along: Any, across: Any) -> Any:
    """Return the bilinear interpolation of coarse grids on the nodes, by the same weights."""
    return along.T @ field @ across
