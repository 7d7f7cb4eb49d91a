"""Many convolutions with Love's coefficients in one plan of FFTW, two pieces to a complex array.

The transform of the coefficients is real, because they are even. Pressures of two pieces, as real
and imaginary part, therefore stay apart in the product, which takes no pass to separate them.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import numba
import numpy as np

from acoustics.arrays import Array
from rolling.contact import _transform_kernels as present
from rolling.contact._by_address import call
from rolling.contact._plans import Plan, zeros
from rolling.contact.half_space import half_spectrum, love

GAP = 4  # complex numbers between lines, so that columns do not meet in the same places of a cache
_deflect_window = present.window_kernel(1)
ROWS, COLUMNS, COLUMNS_BACK, ROWS_BACK = range(4)


class BatchTransforms:
    """Transforms of one padded size for so many pairs of pieces.

    Parameters
    ----------
    m, n : int
        Padded lengths along and across. The coefficients are right for nodes up to half a length
        apart.
    lines, pairs : int
        Rows that hold nodes, and pairs of pieces.
    unit : float, m/Pa
        Deflection per pressure and coefficient.
    single : bool
        Whether they are in single precision.
    """

    def __init__(self, m: int, n: int, lines: int, pairs: int, unit: float, single: bool) -> None:
        real, both = ("float32", "complex64") if single else ("float64", "complex128")
        half = half_spectrum(m, n, 1, love)
        along = np.minimum(np.arange(m), m - np.arange(m))
        across = np.minimum(np.arange(n), n - np.arange(n))
        spectrum = unit / (m * n) * half[along[:, None], across]
        self.spectrum = np.zeros((m, 2 * (n + GAP)), real)
        self.spectrum[:, : 2 * n] = np.repeat(spectrum, 2, axis=1)
        numbers = zeros((m, pairs, n + GAP), both)
        self.lines = numbers.view(real)
        rows = numbers[:lines].reshape(-1, n + GAP)[:, :n]
        columns = numbers.reshape(m, -1)
        self._plans = [
            Plan(rows, rows, 1),
            Plan(columns, columns, 0),
            Plan(columns, columns, 0, backward=True),
            Plan(rows, rows, 1, backward=True),
        ]
        self.execute = self._plans[0].execute
        self.plans = np.array([plan.address for plan in self._plans], np.int64)

    def deflect_nodes(self, d: Array, count: Array, at: Array, slots: Array, image: Array) -> None:
        """Set the image of listed nodes to the deflection by pressures d on them (see `_nodes`)."""
        _nodes(d, count, at, slots, self.lines, self.spectrum, (self.execute, self.plans), image)

    def deflect_frames(self, pressure: Array, slots: Array, deflection: Array) -> None:
        """Set the deflection of whole frames (k, rows, columns); the rest is that of `_nodes`."""
        _frames(pressure, slots, self.lines, self.spectrum, (self.execute, self.plans), deflection)


@numba.njit(fastmath={"reassoc", "contract", "nsz"}, nogil=True)
def transform(lines, spectrum, executable):
    """Replace pressures by their deflections; `executable` has FFTW's function and the plans."""
    execute, plans = executable
    call(execute, (plans[ROWS],))
    call(execute, (plans[COLUMNS],))
    for i in range(lines.shape[0]):
        factors = spectrum[i]
        for pair in range(lines.shape[1]):
            line = lines[i, pair]
            for j in range(factors.size):
                line[j] *= factors[j]
    call(execute, (plans[COLUMNS_BACK],))
    call(execute, (plans[ROWS_BACK],))


@numba.njit(nogil=True)
def _nodes(d, count, at, slots, lines, spectrum, executable, image):
    """Set the image of listed nodes to the deflection by pressures d on them.

    `d` and `image` (k, n) have `count` nodes of each piece, at rows `at[0]` and columns `at[1]`.
    `slots` (2 pairs,) tells which piece lies where, -1 none.
    """
    lines.reshape(-1)[:] = 0.0  # a single loop, which is faster
    for slot in range(slots.size):
        piece = slots[slot]
        for a in range(count[piece] if piece >= 0 else 0):
            lines[at[0, piece, a], slot // 2, 2 * at[1, piece, a] + slot % 2] = d[piece, a]
    transform(lines, spectrum, executable)
    for slot in range(slots.size):
        piece = slots[slot]
        for a in range(count[piece] if piece >= 0 else 0):
            image[piece, a] = lines[at[0, piece, a], slot // 2, 2 * at[1, piece, a] + slot % 2]


@numba.njit(nogil=True)
def _frames(pressure, slots, lines, spectrum, executable, deflection):
    """Set the deflection of whole frames by the pressure on them."""
    lines.reshape(-1)[:] = 0.0  # a single loop, which is faster
    for slot in range(slots.size):
        piece = slots[slot]
        for i in range(pressure.shape[1] if piece >= 0 else 0):
            line = lines[i, slot // 2]
            for j in range(pressure.shape[2]):
                line[2 * j + slot % 2] = pressure[piece, i, j]
    transform(lines, spectrum, executable)
    for slot in range(slots.size):
        piece = slots[slot]
        for i in range(pressure.shape[1] if piece >= 0 else 0):
            line = lines[i, slot // 2]
            for j in range(pressure.shape[2]):
                deflection[piece, i, j] = line[2 * j + slot % 2]


@numba.njit(nogil=True)
def nodes_by_own_plans(d, count, node, pieces, block, transforms, image):
    """Set the image of listed nodes to the deflection by pressures d on them, piece by piece.

    `d` and `image` are arrays (k, n), and `node` (k, n) are places in the array of the transforms,
    which the image of a piece has as well. `block` has the rows and columns of the nodes and the
    deflection per pressure and coefficient. `transforms` are the address of their kernel and their
    entry (see `deflect_nodes` of the present solver).
    """
    kernel, entry = transforms
    no_cells = np.empty(0, np.int64)
    here = (0, 0, block[0], block[1])
    for piece in pieces:
        nodes = node[piece][: count[piece]], no_cells
        own = d[piece][: count[piece]]
        present.deflect_nodes(kernel, entry, here, own, block[2], image[piece], nodes)


@numba.njit(nogil=True)
def frames_by_own_plans(pressure, pieces, unit, entry, deflection):
    """Set the deflection of whole frames by the pressure on them, piece by piece."""
    for piece in pieces:
        _deflect_window(pressure[piece], unit, entry, deflection[piece])
