"""Deflection of an elastic half-space by pressure.

Love's influence coefficients are convolved with the pressure by zero-padded FFTs (pyfftw).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rolling._typing import Array
from rolling.contact import _transform_kernels, spectra
from rolling.contact._compiled import njit
from rolling.contact._fftw import pyfftw

# These padded lengths are quick for their size, by a trial of the even products of 2, 3, 5 and 7 up
# to 650: any length between two of them costs more than the longer one, or hardly less.
_SHORT = (16, 20, 32, 40, 48, 64, 72, 80)
_LONG = (
    *(640, 768, 800, 896, 1024, 1280, 1536, 2048, 2560, 3072),
    *(4096, 5120, 6144, 8192, 10240, 12288, 16384),
)
_SINGLE_LENGTHS = (*_SHORT, 100, 120, 128, 144, 160, 180, 200, 256, 288, 320, 360, 400, 512, *_LONG)
_DOUBLE_LENGTHS = (*_SHORT, 96, 112, 128, 144, 160, 200, 256, 288, 320, 384, 400, 512, *_LONG)
# Columns of these lengths, and all long columns, are transformed in two halves, because half of a
# column is zero. Elsewhere this saves nothing within a march.
_SINGLE_HALVED = (256, 288, 320, 360, 400, 512)
_DOUBLE_HALVED = (256,)
# Columns of these lengths are transformed in place, because that is quicker, and long columns,
# because it saves memory. Other columns go from one array to another.
_SINGLE_IN_PLACE = (256, 288)
_DOUBLE_IN_PLACE = (256, 384, 400)

MOST_NODES = _LONG[-1] // 2  # maximum number of nodes across a window

# Bytes of transforms that a half-space keeps. A rough track asks for some hundred sizes; without a
# limit they took 4 GB in each process. A step needs few sizes, which fit up to 1,000 nodes across.
KEPT_BYTES = 2**28

MOST_INFLUENCE = 2**20  # maximum size of a transform that keeps coefficients by distance

OWN_COEFFICIENT = 4 * np.log(1 + np.sqrt(2))  # coefficient of a unit square at its own centre


def padded_length(reach: int, single: bool = False) -> int:
    """Return the minimum quick length of a transform for nodes up to `reach` spacings apart.

    The coefficients are even, so a distance of half the length is still correct.

    Parameters
    ----------
    reach : int
        Maximum distance between a loaded node and a node whose deflection counts.
    single : bool
        If true, the transform is in single precision. Default: false.

    Raises
    ------
    ValueError
        `reach` exceeds the longest transform.
    """
    for length in _SINGLE_LENGTHS if single else _DOUBLE_LENGTHS:
        if length >= 2 * reach:
            return length
    raise ValueError(
        f"a window of {reach + 1} nodes is more than the {MOST_NODES} there is room for"
    )


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

    def corner(s: Array, t: Array) -> Array:
        # Corners lie half a spacing off the nodes, so neither s nor t is ever zero; arcsinh does
        # not cancel where log(y + r) would.
        return s * np.arcsinh(t / np.abs(s)) + t * np.arcsinh(s / np.abs(t))

    x, y = rows[:, None].astype(float), columns[None, :].astype(float)
    h = 0.5
    return corner(x + h, y + h) + corner(x - h, y - h) - corner(x + h, y - h) - corner(x - h, y + h)


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
        Number of convolutions so far, a cost that does not depend on the machine.
    subcells : int
        Nodes along the side of a cell of the transforms, 1 here.

    Examples
    --------
    Unit pressure on one cell deflects its centre by 4 ln(1 + sqrt 2) spacing / (pi E*):

    >>> import numpy as np
    >>> from rolling.contact.half_space import HalfSpace
    >>> pressure = np.zeros((5, 5))
    >>> pressure[2, 2] = 1e9
    >>> deflection = HalfSpace(spacing=1e-6, contact_modulus=230e9).deflection(pressure)
    >>> f"{deflection[2, 2] * 1e9:.3f} nm"
    '4.879 nm'
    """

    def __init__(self, spacing: float, contact_modulus: float) -> None:
        self.spacing = spacing
        self.contact_modulus = contact_modulus
        self.unit = spacing / (np.pi * contact_modulus)
        self._convolutions: dict[tuple[int, int, bool], Convolution] = {}
        self.count = 0
        self.subcells = 1

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
            The window exceeds the longest transform.
        """
        m, n = pressure.shape
        convolution = self.convolution(*_reach(pressure))
        block = convolution.block(m, n)
        _load(pressure, block)
        convolution.apply(m, n)
        self.count += 1
        deflection = np.empty((m, n))
        _scale(block, self.unit, deflection)
        return deflection

    def convolution(self, row_reach: int, column_reach: int, single: bool = False) -> Convolution:
        """Return the transforms for nodes at most so many rows and columns apart.

        The caller that applies them adds to `count`.
        """
        key = (self._length(row_reach, single), self._length(column_reach, single), single)
        convolution = self._convolutions.pop(key, None)
        if convolution is None:
            convolution = self._make(*key)
            room = KEPT_BYTES - convolution.nbytes
            sizes = [kept.nbytes for kept in self._convolutions.values()]
            # The last size is kept in any case: solves take turns in both precisions.
            while len(sizes) > 1 and sum(sizes) > room:
                del self._convolutions[next(iter(self._convolutions))], sizes[0]
        self._convolutions[key] = convolution  # the last is the one that was used last
        return convolution

    def _make(self, m: int, n: int, single: bool) -> Convolution:
        """Make the transforms of a padded size."""
        return Convolution(m, n, single, spectra.half_spectrum(m, n, 1, love))

    def _length(self, reach: int, single: bool) -> int:
        """Return the padded length for nodes up to `reach` spacings from one another."""
        return padded_length(reach, single)


@njit(cache=True)
def _reach(pressure: Array) -> tuple[int, int]:
    """Return the maximum distances of a row and a column from a loaded row and column.

    They are at least half the window, which must fit.
    """
    rows, columns = pressure.shape
    first_row, last_row, first_column, last_column = rows, 0, columns, 0
    for i in range(rows):
        row = pressure[i]
        j = 0
        while j < columns and row[j] == 0.0:
            j += 1
        if j == columns:
            continue
        first_row = min(first_row, i)
        last_row = i
        first_column = min(first_column, j)
        k = columns - 1
        while row[k] == 0.0:
            k -= 1
        last_column = max(last_column, k)
    return (
        max(last_row, rows - 1 - first_row, (rows + 1) // 2),
        max(last_column, columns - 1 - first_column, (columns + 1) // 2),
    )


@njit(cache=True)
def _load(pressure: Array, out: Array) -> None:
    """Set the first rows and columns of `out` to the pressure, and the rest to 0."""
    rows, columns = pressure.shape
    for i in range(out.shape[0]):
        line = out[i]
        if i >= rows:
            line[:] = 0.0
            continue
        row = pressure[i]
        for j in range(columns):
            line[j] = row[j]
        line[columns:] = 0.0


@njit(cache=True)
def _scale(values: Array, unit: float, out: Array) -> None:
    """Set `out` to the first rows and columns of the values times the unit."""
    for i in range(out.shape[0]):
        row, line = values[i], out[i]
        for j in range(line.size):
            line[j] = unit * row[j]


class Convolution:
    """Transforms of one padded size and their work arrays.

    Write the pressure to a `block`, call `apply`, then read the deflection.

    Parameters
    ----------
    m, n : int
        Padded lengths along and across.
    single : bool
        If true, transforms are in single precision: their error is about 1e-7 of the maximum
        deflection, and they are up to twice as fast.
    spectrum : (m // 2 + 1, n // 2 + 1) array
        Transform of the wrapped coefficients, the first half of its rows.

    Attributes
    ----------
    real : (m, n) array
        Pressure on the cells before the transforms, and deflection after them.
    """

    def __init__(self, m: int, n: int, single: bool, spectrum: Array) -> None:
        real, both = ("float32", "complex64") if single else ("float64", "complex128")
        self.single = single
        self._influence: NDArray[np.float32] | None = None
        self.real = pyfftw.zeros_aligned((m, n), real)
        self._lines = pyfftw.zeros_aligned((m, n // 2 + 1), both)
        long = m >= _LONG[0]
        in_place = long or m in (_SINGLE_IN_PLACE if single else _DOUBLE_IN_PLACE)
        columns = self._lines if in_place else pyfftw.zeros_aligned(self._lines.shape, both)
        self._columns = columns
        # The coefficients are even along the columns, so half of the rows suffices and leaves the
        # cache to the lines.
        self._coefficients = (spectrum / (m * n)).astype(real)
        parts, half = [slice(None)], 0
        if long or m in (_SINGLE_HALVED if single else _DOUBLE_HALVED):
            half = m // 2
            parts = [slice(half), slice(half, m)]
        self._turns = np.exp(-2j * np.pi / m * np.arange(half)).astype(both)
        # FFTW_ESTIMATE is used because plans that are chosen by timing differ from run to run, and
        # the last digits with them.
        flags = ("FFTW_ESTIMATE",)
        self._columns_forward = [
            pyfftw.FFTW(self._lines[part], columns[part], axes=(0,), flags=flags) for part in parts
        ]
        self._columns_backward = [
            pyfftw.FFTW(
                columns[part],
                self._lines[part],
                axes=(0,),
                direction="FFTW_BACKWARD",
                flags=flags,
            )
            for part in parts
        ]
        self._row_plans: dict[int, tuple[pyfftw.FFTW, pyfftw.FFTW]] = {}

    @property
    def nbytes(self) -> int:
        """Memory of the arrays [bytes]."""
        arrays = [self.real, self._lines, self._coefficients]
        if self._columns is not self._lines:
            arrays.append(self._columns)
        if self._influence is not None:
            arrays.append(self._influence)
        return sum(int(array.nbytes) for array in arrays)

    def block(self, rows: int, columns: int) -> Array:
        """Return the array of a block of nodes, which may have further rows and columns.

        It holds the pressure before `apply`, with zeros on the further rows and columns, and the
        deflection in units of spacing / (pi E*) afterwards.
        """
        view: Array = self.real[: rows + 8]
        return view

    @property
    def influence_row(self) -> int:
        """Number of coefficients in a row of `influence`."""
        return int(2 * (self.real.shape[1] // 2) + 1)

    def influence(self) -> NDArray[np.float32]:
        """Return the coefficients of nodes by distance, along and across, as a flat array.

        Its middle is the distance zero. It is empty for large transforms, whose memory it would
        add to.
        """
        if self._influence is None:
            m, n = self.real.shape
            small = m * n <= MOST_INFLUENCE
            rows, columns = (
                np.abs(np.arange(-(k // 2), k // 2 + 1.0)) if small else np.empty(0) for k in (m, n)
            )
            self._influence = love(rows, columns).astype(np.float32).ravel()
        return self._influence

    def cells_of(
        self, node: NDArray[np.int64], columns: int, block: tuple[int, int, int, int]
    ) -> NDArray[np.int64] | None:
        """Return None, because each node is a cell."""
        return None

    def apply(self, rows: int, columns: int, listed: NDArray[np.int64] | None = None) -> None:
        """Replace the pressure on a block of so many rows and columns by its deflection.

        Further rows and columns are invalid afterwards.
        """
        self._transform(rows)

    def _transform(self, rows: int) -> None:
        """Convolve the first `rows` rows of the array of the transforms."""
        rows = min(-8 * (-rows // 8), self.real.shape[0])
        if rows not in self._row_plans:
            head, lines = self.real[:rows], self._lines[:rows]
            backward = {
                "direction": "FFTW_BACKWARD",
                "flags": ("FFTW_ESTIMATE", "FFTW_DESTROY_INPUT"),
            }
            self._row_plans[rows] = (
                pyfftw.FFTW(head, lines, axes=(1,), flags=("FFTW_ESTIMATE",)),
                pyfftw.FFTW(lines, head, axes=(1,), **backward),
            )
        row_forward, row_backward = self._row_plans[rows]
        row_forward.execute()
        halved = self._turns.size > 0
        if halved:
            _transform_kernels.separate(self._lines, rows, self._turns)
        else:
            self._lines[rows:] = 0.0
        for plan in self._columns_forward:
            plan.execute()
        _transform_kernels.multiply(self._columns, self._coefficients, halved)
        for plan in self._columns_backward:
            plan.execute()
        if halved:
            _transform_kernels.combine(self._lines, rows, self._turns)
        row_backward.execute()
