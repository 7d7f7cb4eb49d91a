"""Sub-cells: pressures, heights and bounds on r x r parts of cells, with transforms of whole cells.

The far field is smooth, so transforms act on cells only. The adjoint of an interpolation spreads
the pressures of sub-cells over the cells around, the interpolation brings the deflection of the
cells back, and the exact coefficients among the sub-cells of a cell correct the difference
(multi-level multi-integration, Brandt & Lubrecht, J. Comput. Phys. 90 (1990)). The operator stays
symmetric and positive.
"""

from __future__ import annotations

from functools import lru_cache, partial
from typing import Any

import numpy as np

from acoustics.arrays import Array
from rolling.contact import _transform_kernels as kernels
from rolling.contact.half_space import Convolution, HalfSpace, half_spectrum, love


def interpolation(subcells: int) -> Array:
    """Return the weights (r, 3) of a cell and its neighbours in the deflection of its sub-cells.

    The interpolation is quadratic and keeps the mean over the cell.
    """
    x = (np.arange(subcells) - (subcells - 1) / 2) / subcells
    bend = (x**2 - np.mean(x**2)) / 2
    return np.ascontiguousarray(np.stack([bend - x / 2, 1 - 2 * bend, bend + x / 2], axis=1))


def mean_coefficients(rows: Array, columns: Array, subcells: int) -> Array:
    """Compute coefficients of the mean deflection of a cell by pressure on another cell.

    Distances along and across are whole numbers of cells; the spacing is that of sub-cells.
    """
    shifts = range(1 - subcells, subcells)
    total = np.zeros((len(rows), len(columns)))
    for a in shifts:
        for b in shifts:
            pairs = (subcells - abs(a)) * (subcells - abs(b)) / subcells**2
            total += pairs * love(np.abs(rows * subcells + a), np.abs(columns * subcells + b))
    return total


@lru_cache(maxsize=4)
def own_block(subcells: int) -> Array:
    """Return corrections (r r, r r) of coefficients: exact less those by way of the cells."""
    r = subcells
    weights = interpolation(r)
    both = np.einsum("ak,bl->abkl", weights, weights).reshape(r * r, 9)
    place = np.arange(r)
    distance = np.abs(place[:, None] - place[None, :])
    near = np.arange(float(r))
    exact = love(near, near)[distance[:, None, :, None], distance[None, :, None, :]].reshape(
        r * r, r * r
    )
    cell = np.arange(3)
    cell_distance = np.abs(cell[:, None] - cell[None, :])
    around = np.arange(3.0)
    between = mean_coefficients(around, around, r)[
        cell_distance[:, None, :, None], cell_distance[None, :, None, :]
    ].reshape(9, 9)
    return np.ascontiguousarray(exact - both @ between @ both.T / r**2)


class SubcellSpace(HalfSpace):
    """Half-space under pressures on sub-cells, with transforms of whole cells.

    The spacing is that of sub-cells [m]; windows begin and end with whole cells.
    """

    def __init__(self, spacing: float, contact_modulus: float, subcells: int) -> None:
        super().__init__(spacing, contact_modulus)
        self.subcells = subcells

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.spacing, self.contact_modulus, self.subcells)

    def _make(self, m: int, n: int, single: bool) -> SubcellConvolution:
        """Make the transforms of a padded size of cells."""
        return SubcellConvolution(m, n, single, self.subcells)


class SubcellConvolution(Convolution):
    """Transforms of one padded size of cells, behind blocks of sub-cells."""

    def __init__(self, m: int, n: int, single: bool, subcells: int) -> None:
        coefficients = partial(mean_coefficients, subcells=subcells)
        spectrum = half_spectrum(m, n, subcells, coefficients)
        super().__init__(m, n, single, spectrum, subcells)
        # Blocks of any shape follow one another without gaps, so that passes over a block touch no
        # more memory than it has.
        self._fine = np.zeros((m - 2) * (n - 2) * subcells**2, self.real.dtype)
        self._weights = interpolation(subcells).astype(self.real.dtype)
        self._own_block = own_block(subcells).astype(self.real.dtype)
        # Coefficients by distance would depend on the place within a cell.
        self._influence = np.empty(0, np.float32)
        self._entry[kernels.BLOCK] = self._fine.ctypes.data
        self._entry[kernels.WEIGHTS] = self._weights.ctypes.data
        self._entry[kernels.OWN_BLOCK] = self._own_block.ctypes.data

    @property
    def nbytes(self) -> int:
        """Memory of the arrays [bytes]."""
        return super().nbytes + int(self._fine.nbytes)


def half_space_of(spacing: float, contact_modulus: float, subcells: int = 1) -> HalfSpace:
    """Return the half-space for nodes of this spacing [m], so many along the side of a cell."""
    if subcells == 1:
        return HalfSpace(spacing, contact_modulus)
    return SubcellSpace(spacing, contact_modulus, subcells)


def cell_means(values: Array, subcells: int) -> Array:
    """Return the means over whole cells of values (rows, columns) on sub-cells."""
    if subcells == 1:
        return values
    rows, columns = (n // subcells for n in values.shape)
    means: Array = values.reshape(rows, subcells, columns, subcells).mean(axis=(1, 3))
    return means
