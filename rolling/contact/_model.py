"""Model problem of the contact solve: its stencil and its far field (see _model_kernels)."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rolling._typing import Array
from rolling.contact.half_space import love

# Waves up to this many nodes long count in the fit of the stencil. Contacts are some ten to a
# hundred nodes wide.
LONGEST_WAVE = 40
# Nodes from a coarse node of the far field to the next, at least. The far field is smooth over
# that length.
SHORTEST_TILE = 8
# Beyond so many nodes the half-space of the stencil is forgotten (1e-15 of its centre).
FORGOTTEN = 64


@lru_cache(maxsize=1)
def inverse_stencil() -> Array:
    """Fit a 5 x 5 stencil to the inverse of Love's coefficients, by least squares over waves.

    The waves are up to LONGEST_WAVE nodes long, for unit spacing and pi E* = 1.

    Returns
    -------
    (6,) array
        Centre, side, corner, second side, beside it, second corner.
    """
    distance = np.minimum(np.arange(256), 256 - np.arange(256))
    spectrum = np.fft.rfft2(love(distance, distance)).real
    along = 2 * np.pi * np.fft.fftfreq(256)[:, None]
    across = 2 * np.pi * np.fft.rfftfreq(256)[None, :]
    waves = np.hypot(along, across) >= 2 * np.pi / LONGEST_WAVE

    def ring(a: int, b: int) -> Array:
        nodes = {(x * m, y * n) for m, n in ((a, b), (b, a)) for x in (-1, 1) for y in (-1, 1)}
        # Sorted, because the order of a sum has an effect on its last digits.
        total: Array = np.sum([np.cos(m * along + n * across) for m, n in sorted(nodes)], axis=0)
        return total

    pairs = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)]
    columns = np.stack([(ring(a, b) * spectrum)[waves] for a, b in pairs], axis=1)
    weights: Array = np.linalg.lstsq(columns, np.ones(len(columns)), rcond=None)[0]
    return weights


@lru_cache(maxsize=1)
def half_space_of_stencil() -> Array:
    """Return the coefficients by distance that the stencil inverts, along and across.

    They are those of a large periodic grid, for unit spacing and pi E* = 1.

    Returns
    -------
    (FORGOTTEN, FORGOTTEN) array
        Coefficients; the sum over all nodes of the plane is `1 / sum(stencil)`.
    """
    nodes = 4 * FORGOTTEN
    wrapped, at = np.zeros((nodes, nodes)), np.arange(-2, 3)
    wrapped[at[:, None], at] = square_stencil()
    coefficients: Array = np.fft.irfft2(1.0 / np.fft.rfft2(wrapped).real)[:FORGOTTEN, :FORGOTTEN]
    return coefficients


def square_stencil() -> Array:
    """Return the stencil of the inverse as a (5, 5) array."""
    centre, side, corner, second, beside, far = inverse_stencil()
    quarter = np.array([[centre, side, second], [side, corner, beside], [second, beside, far]])
    at = np.abs(np.arange(-2, 3))
    square: Array = quarter[at[:, None], at]
    return square


def coarse_grid(rows: int, columns: int) -> tuple[int, int, int]:
    """Choose the coarse grid of the far field for a grid of the model.

    The tile grows with the root of the grid, so that sums over all pairs of coarse nodes take no
    longer than a few passes over the nodes.

    Parameters
    ----------
    rows, columns : int
        Nodes of the model along and across.

    Returns
    -------
    rows, columns : int
        Coarse nodes along and across.
    tile : int
        Nodes from a coarse node to the next.
    """
    tile = max(SHORTEST_TILE, round(max(rows, columns) ** 0.5))
    return (rows - 1) // tile + 2, (columns - 1) // tile + 2, tile


@lru_cache(maxsize=64)
def far_field(rows: int, columns: int, tile: int) -> NDArray[np.float32]:
    """Return the coefficients of the far field by distance on a coarse grid.

    They are Love's coefficients less those that the stencil inverts, for unit spacing and
    pi E* = 1.

    Parameters
    ----------
    rows, columns : int
        Coarse nodes along and across.
    tile : int
        Nodes from a coarse node to the next.

    Returns
    -------
    flat array
        Rows of 2 columns - 1 coefficients, from negative to positive distances along and across,
        and as many zeros as columns at the end.
    """
    along, across = np.arange(float(rows)) * tile, np.arange(float(columns)) * tile
    coefficients = love(along, across)
    near = half_space_of_stencil()[::tile, ::tile][:rows, :columns]
    coefficients[: near.shape[0], : near.shape[1]] -= near
    by_distance = coefficients[
        np.abs(np.arange(1 - rows, rows))[:, None], np.abs(np.arange(1 - columns, columns))
    ]
    return np.append(by_distance.ravel(), np.zeros(columns)).astype(np.float32)


class Stencils(NamedTuple):
    """Stencils of the inverse half-space in the units of a half-space.

    Parameters
    ----------
    preconditioner : (3, 3) array, Pa/m
        Stencil of the preconditioner: the centre of the inverse.
    model : (6,) array
        Stencil of the model problem over its centre.
    stiffness : float, Pa/m
        Centre of the stencil of the model problem.
    own, common : float
        Gap of a node by a unit of its own pressure, and by a unit of pressure all over, that the
        stencil of the model problem stands for.
    """

    preconditioner: Array
    model: NDArray[np.float32]
    stiffness: float
    own: float
    common: float


@lru_cache(maxsize=8)
def stencils(unit: float) -> Stencils:
    """Return the stencils for a half-space with a deflection of `unit` [m/Pa] per coefficient."""
    distance = np.minimum(np.arange(256), 256 - np.arange(256))
    inverse = np.fft.irfft2(1.0 / np.fft.rfft2(love(distance, distance)).real)
    centre = np.ascontiguousarray(np.roll(inverse, (1, 1), axis=(0, 1))[:3, :3])
    model = inverse_stencil()
    return Stencils(
        centre / unit,
        (model / model[0]).astype(np.float32),
        float(model[0] / unit),
        float(half_space_of_stencil()[0, 0]),
        float(1.0 / square_stencil().sum()),
    )
