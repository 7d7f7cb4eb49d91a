"""Deflection of an elastic half-space by pressure.

Love's influence coefficients are convolved with the pressure by zero-padded FFTs (pyfftw).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array, positive, real_array
from acoustics.traps import ignoring_underflow
from rolling.contact import _transform_kernels as kernels
from rolling.contact import _window_kernels
from rolling.contact._plans import Plan, zeros
from rolling.contact._transform_kernels import COLUMN_GAP, GROUP
from rolling.contact.kept import Kept

# Columns of these lengths, and all longer columns, are transformed in two halves, because half of a
# column is zero. Elsewhere this takes longer.
_HALVED = (80, 256)
# Columns of these lengths are transformed in place, because that is quicker, and longer columns,
# because it saves memory. Other columns go from one array to another.
_IN_PLACE = (128, 256, 512, 1024)
MAX_SIZE = 1e300  # of a length, a modulus or a load in SI

# Bytes of transforms that a half-space keeps. A rough track asks for some hundred sizes; without a
# limit they took 4 GB in each process. A step needs few sizes, which fit up to 1,000 nodes across.
KEPT_BYTES = 2**28

MAX_INFLUENCE = 2**20  # maximum size of a transform that keeps coefficients by distance


# These padded lengths are quick for their size, along columns and across them, by a trial of the
# even products of 2, 3, 5 and 7 up to 650: any length between two of them costs more than the
# longer one, or hardly less.
_LONG = (1024, 1280, 1536, 2048, 2560, 3072, 4096, 5120, 6144, 8192, 10240, 12288, 16384)
_MEDIUM = (144, 160, 200, 240, 256, 320, 384, 400, 512, 640, 768, 800)
ALONG = (16, 20, 32, 40, 64, 80, 128, 144, 256, 288, 320, 512, 640, 800, *_LONG)
ACROSS = (16, 20, 32, 40, 48, 64, 80, 96, 128, *_MEDIUM, *_LONG)
MAX_NODES = _LONG[-1] // 2  # maximum number of nodes across a window


@lru_cache(maxsize=4096)
def padded_length(reach: int, across: bool = False, subcells: int = 1) -> int:
    """Return the minimum quick length for nodes up to `reach` spacings apart, in cells.

    The coefficients are even, so a distance of half the length is still correct. Raises ValueError
    where there is none.
    """
    lengths = ACROSS if across else ALONG
    # The interpolation on sub-cells spreads pressure into a border of one cell on both sides.
    cells = reach if subcells == 1 else -(-reach // subcells) + 2
    place = bisect_left(lengths, 2 * cells)
    if place == len(lengths):
        raise ValueError(
            f"window: got {reach // subcells + 1} nodes along a side, allowed: {MAX_NODES} there"
            " is room for"
        )
    return lengths[place]


def love(rows: Array, columns: Array) -> Array:
    """Compute the deflection coefficients of unit squares, without pi E* and spacing.

    Source: A. E. H. Love, Phil. Trans. R. Soc. A 228 (1929).

    Parameters
    ----------
    rows, columns : (m,) and (n,) arrays
        Distances of nodes from the centre of the loaded square, whole numbers of spacings.

    Returns
    -------
    (m, n) array
        Coefficients k of the deflection u = spacing / (pi E*) * sum k p.
    """
    # Neighbouring squares share corners, so each corner is computed once instead of four times.
    # Distances may repeat or leave some out, as those between sub-cells do.
    sides = np.add.outer([-0.5, 0.5], np.asarray(rows, np.float64))
    ends = np.add.outer([-0.5, 0.5], np.asarray(columns, np.float64))
    x, (x_minus, x_plus) = np.unique(sides, return_inverse=True)
    y, (y_minus, y_plus) = np.unique(ends, return_inverse=True)
    s, t = x[:, None], y[None, :]
    # Corners lie half a spacing off the nodes, so neither s nor t is ever zero; arcsinh does not
    # cancel where log(y + r) would.
    corners = s * np.arcsinh(t / np.abs(s)) + t * np.arcsinh(s / np.abs(t))
    plus, minus = corners[x_plus], corners[x_minus]
    coefficients: Array = plus[:, y_plus] + minus[:, y_minus] - plus[:, y_minus] - minus[:, y_plus]
    return coefficients


def by_signed_distance(coefficients: NDArray[Any]) -> NDArray[Any]:
    """Return coefficients by distances of both signs from those by distance, which are even.

    Parameters
    ----------
    coefficients : (m, n) array
        Coefficients by distance along and across, from 0.

    Returns
    -------
    (2 m - 1, 2 n - 1) array
        Coefficients from the distances 1 - m and 1 - n, with that of distance 0 in the middle.
    """
    along, across = (np.abs(np.arange(1 - length, length)) for length in coefficients.shape)
    return coefficients[along][:, across]


# Bytes of spectra that a process keeps beside its transforms: the hundred sizes of a rough track up
# to 300 nodes across, or seven sizes of 1,000 nodes. A longer spectrum is not kept at all.
KEPT_SPECTRA = 2**26

_spectra: Kept[Array] = Kept(KEPT_SPECTRA, lambda half: half.nbytes, fewest=0)


def half_spectrum(
    m: int, n: int, subcells: int, coefficients: Callable[[Array, Array], Array]
) -> Array:
    """Return m // 2 + 1 rows and n // 2 + 1 columns of the transform of wrapped coefficients.

    The transform is real, and its other rows mirror these, because the coefficients are even in
    both directions. The padded lengths m and n are even, so a quarter of the coefficients tells
    all, and each direction is transformed by itself. The spectrum is kept for other precisions and
    half-spaces, by padded lengths and number of sub-cells along the side of a cell.
    """

    def make() -> Array:
        quarter = coefficients(np.arange(m // 2 + 1.0), np.arange(n // 2 + 1.0))
        across = even_transform(quarter)
        return np.ascontiguousarray(even_transform(across.T).T)

    return _spectra.value((m, n, subcells), make)


def even_transform(values: Array) -> Array:
    """Return the transform of each row, continued as f(-x) = f(x) with the period 2 columns - 2.

    It is real and even itself, so it has as many numbers. It is that of `scipy.fft.dct` of type 1,
    which takes long to import.
    """
    last = values.shape[1] - 1
    period = np.concatenate([values, values[:, last - 1 : 0 : -1]], axis=1)
    # The copy frees the imaginary parts, which are zero but for rounding.
    return np.fft.rfft(period).real.copy()


class HalfSpace:
    """Elastic half-space under pressure on windows of square cells.

    It keeps the transforms of the padded sizes that were used last, up to KEPT_BYTES.

    Parameters
    ----------
    spacing : float, m
        Node spacing.
    contact_modulus : float, Pa
        Contact modulus E* of both bodies. Where both are elastic, the deflection is the sum over
        both.

    Attributes
    ----------
    unit : float, m/Pa
        Deflection per pressure and coefficient.
    count : int
        Number of deflections so far, by transforms or direct sums: a cost that does not depend on
        the machine.
    subcells : int
        Nodes along the side of a cell of the transforms, 1 here.

    Examples
    --------
    Unit pressure on one cell deflects its centre by 4 ln(1 + sqrt 2) spacing / (pi E*):

    >>> import numpy as np, rolling
    >>> pressure = np.zeros((5, 5))
    >>> pressure[2, 2] = 1e9
    >>> half_space = rolling.HalfSpace(spacing=1e-6, contact_modulus=230e9)
    >>> deflection = half_space.deflection(pressure)
    >>> f"{deflection[2, 2] * 1e9:.3f} nm"
    '4.879 nm'
    """

    @ignoring_underflow
    def __init__(self, spacing: float, contact_modulus: float) -> None:
        self.spacing = positive("spacing", spacing, MAX_SIZE)
        self.contact_modulus = positive("contact_modulus", contact_modulus, MAX_SIZE)
        self.unit = self.spacing / (np.pi * self.contact_modulus)
        self.subcells = 1
        self.count = 0
        # The last two sizes are kept in any case: solves take turns in both precisions.
        self._convolutions: Kept[Convolution] = Kept(KEPT_BYTES, lambda size: size.nbytes, fewest=2)
        self._coarser: HalfSpace | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle without transforms, whose plans are addresses of this process."""
        return type(self), (self.spacing, self.contact_modulus)

    def coarser(self) -> HalfSpace:
        """Return the half-space of cells twice as wide, which is made once."""
        if self._coarser is None:
            self._coarser = HalfSpace(2 * self.spacing, self.contact_modulus)
        return self._coarser

    def __repr__(self) -> str:
        modulus = f"contact_modulus={self.contact_modulus:g} Pa"
        return f"{type(self).__name__}(spacing={self.spacing:g} m, {modulus})"

    @ignoring_underflow
    def deflection(self, pressure: Array) -> Array:
        """Compute the deflection of the nodes of a window by the pressure on them.

        All nodes outside the window are unloaded.

        The padding is only as wide as the distance between a loaded node and the farthest node of
        the window.

        Parameters
        ----------
        pressure : (m, n) array, Pa
            Pressure on the nodes.

        Returns
        -------
        (m, n) array, m
            Deflection of the nodes.

        Raises
        ------
        ValueError
            The window exceeds the longest transform, or the pressures are no numbers in two
            dimensions.
        """
        return self.deflect(real_array("pressure", pressure, 2))

    def deflect(self, pressure: Array, out: Array | None = None) -> Array:
        """Compute the deflection [m] as `deflection`, whose check it leaves out."""
        rows, columns = _window_kernels.reach(pressure)
        convolution = self.convolution(rows, columns)
        deflection = np.empty(pressure.shape) if out is None else out
        deflect_window = kernels.window_kernel(self.subcells)
        entry = convolution.planned_entry(pressure.shape[0])
        deflect_window(pressure, self.unit, entry, deflection)
        self.count += 1
        return deflection

    def convolution(self, row_reach: int, column_reach: int, single: bool = False) -> Convolution:
        """Return the transforms for nodes at most so many rows and columns apart.

        The caller that applies them adds to `count`.
        """
        key = (
            padded_length(row_reach, False, self.subcells),
            padded_length(column_reach, True, self.subcells),
            single,
        )

        def make() -> Convolution:
            with np.errstate(under="ignore"):
                return self._make(*key)

        return self._convolutions.value(key, make)

    def _make(self, m: int, n: int, single: bool) -> Convolution:
        """Make the transforms of a padded size."""
        return Convolution(m, n, single, half_spectrum(m, n, 1, love))


class Convolution:
    """Transforms of one padded size and their work arrays.

    Compiled code uses them by the numbers of `planned_entry`, which _transform_kernels lists. In
    single precision their error is typically 1e-7 of the maximum deflection, and they are up to
    twice as fast.
    `real` (m / 2, n, 2) holds rows of cells side by side in pairs.
    """

    def __init__(self, m: int, n: int, single: bool, spectrum: Array, subcells: int = 1) -> None:
        real, both = ("float32", "complex64") if single else ("float64", "complex128")
        self.single = single
        self._influence: NDArray[np.float32] | None = None
        length = m // 2
        self._pairs = zeros((length, n), both)
        self.real = self._pairs.view(real).reshape(length, n, 2)
        # Lines of a power of two would meet in the same places of the cache.
        self._lines = zeros((length, n + COLUMN_GAP), both)
        in_place = m in _IN_PLACE or m > _IN_PLACE[-1]
        self._columns = self._lines if in_place else zeros(self._lines.shape, both)
        # Transforms there and back multiply by their size.
        first = spectrum[: length // 2 + 1] / (length * n)
        second = spectrum[length - np.arange(length // 2 + 1)] / (length * n)
        angle = np.pi / length * np.arange(length // 2 + 1)
        mean = 0.5 * (first + second)
        difference = 0.5 * (first - second)
        factors = [mean, difference, np.sin(angle), np.cos(angle)]
        self._factors = [array.astype(real) for array in factors]
        parts = [slice(None)]
        half = 0
        if m in _HALVED or m > _HALVED[-1]:
            half = length // 2
            parts = [slice(half), slice(half, length)]
        self._turns = np.exp(-2j * np.pi / length * np.arange(half)).astype(both)
        lines = self._lines[:, :n]
        columns = self._columns[:, :n]
        self._plans = [Plan(lines[part], columns[part], 0) for part in parts]
        self._plans += [Plan(columns[part], lines[part], 0, backward=True) for part in parts]
        self._row_plans = np.zeros((-(-length // GROUP) + 1, 2), np.int64)
        # Numbers of rows. Each descent asks, and a set answers without arithmetic.
        self._planned: set[int] = set()
        entry = np.zeros(kernels.ENTRIES, np.int64)
        self._entry = entry
        entry[kernels.LENGTH] = m
        entry[kernels.WIDTH] = n
        entry[kernels.SUBCELLS] = subcells
        entry[kernels.HALF] = half
        entry[kernels.EXECUTE] = self._plans[0].execute
        addresses = [plan.address for plan in self._plans]
        entry[kernels.FORWARD :][: len(parts)] = addresses[: len(parts)]
        entry[kernels.BACKWARD :][: len(parts)] = addresses[len(parts) :]
        arrays = self._pairs, self._pairs, self._lines, self._columns, *self._factors, self._turns
        entry[kernels.BLOCK : kernels.TURNS + 1] = [array.ctypes.data for array in arrays]
        entry[kernels.ROW_PLANS] = self._row_plans.ctypes.data

    def planned_entry(self, rows: int) -> NDArray[np.int64]:
        """Return the numbers by which compiled code transforms a block, planned for its rows.

        Plans are made at the first call for so many rows, because a march needs few of them.
        Only blocks of numbers of rows that were asked for may be transformed by them: executing a
        plan that was not made ends the process.
        """
        if rows not in self._planned:
            self._plan_lines(rows)
            self._planned.add(rows)
        return self._entry

    def _plan_lines(self, rows: int) -> None:
        """Plan the transforms along the lines of a block of so many rows, unless they are there."""
        length, n, _ = self.real.shape
        count = kernels.lines_of(rows, int(self._entry[kernels.SUBCELLS]), 2 * length)
        group = -(-count // GROUP)
        if self._row_plans[group].all():
            return
        head = self._pairs[:count]
        lines = self._lines[:count, :n]
        plans = Plan(head, lines, 1), Plan(lines, head, 1, backward=True)
        self._plans += plans
        self._row_plans[group] = [plan.address for plan in plans]

    @property
    def nbytes(self) -> int:
        """Memory of the arrays [bytes]."""
        arrays = [self.real, self._lines, *self._factors]
        if self._columns is not self._lines:
            arrays.append(self._columns)
        if self._influence is not None:
            arrays.append(self._influence)
        return sum(int(array.nbytes) for array in arrays)

    def influence(self) -> NDArray[np.float32]:
        """Return the coefficients by distance along and across, flat, with zero in the middle.

        There are none for large transforms, whose memory they would add to.
        """
        if self._influence is None:
            length, n, _ = self.real.shape
            if self.real.size <= MAX_INFLUENCE:
                quarter = love(np.arange(length + 1.0), np.arange(n // 2 + 1.0))
                self._influence = by_signed_distance(quarter.astype(np.float32)).ravel()
            else:
                self._influence = np.empty(0, np.float32)
        return self._influence
