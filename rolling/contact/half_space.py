"""Pressure to deflection on an elastic half-space: Love's influence coefficients and a zero-padded FFT convolution (pyfftw)."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pyfftw
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Padded lengths that are quick for their size, by a trial of the products of 2, 3, 5 and 7: those between cost more than the next.
_SHORT = (16, 20, 24, 32, 40, 48, 64, 80, 100, 128)
_LONG = (1536, 2048, 2560, 3072, 4096, 5120, 6144, 8192, 10240, 12288, 16384)
_SINGLE_LENGTHS = (*_SHORT, 144, 160, 192, 240, 256, 320, 384, 400, 512, 640, 768, 800, 864, 896, 1024, 1280, *_LONG)
_DOUBLE_LENGTHS = (*_SHORT, 160, 200, 256, 320, 384, 400, 512, 640, 768, 800, 896, 1024, 1152, 1280, *_LONG)
MOST_NODES = _LONG[-1] // 2  # across a window

OWN_COEFFICIENT = 4 * np.log(1 + np.sqrt(2))  # of a unit square at its own centre


def padded_length(reach: int, single: bool = False) -> int:
    """Smallest quick length whose transform keeps nodes apart that are up to `reach` spacings from one another.

    The coefficients are even, so a distance of just half the length is still right.

    Raises
    ------
    ValueError : more than there is room for.
    """
    for length in _SINGLE_LENGTHS if single else _DOUBLE_LENGTHS:
        if length >= 2 * reach:
            return length
    raise ValueError(f"a window of {reach + 1} nodes is more than the {MOST_NODES} there is room for")


def love(rows: Array, columns: Array) -> Array:
    """Deflection coefficients of unit squares, without pi E* and spacing (Love 1929).

    Parameters
    ----------
    rows, columns : node distances from the loaded square's centre, in spacings, whole numbers.

    Returns
    -------
    (rows.size, columns.size) coefficients k: u = spacing / (pi E*) * sum k p.
    """

    def corner(s: Array, t: Array) -> Array:
        # Corners lie half a spacing off the nodes, so neither is ever zero; arcsinh does not cancel where log(y + r) would.
        return s * np.arcsinh(t / np.abs(s)) + t * np.arcsinh(s / np.abs(t))

    x, y = rows[:, None].astype(float), columns[None, :].astype(float)
    h = 0.5
    return corner(x + h, y + h) + corner(x - h, y - h) - corner(x + h, y - h) - corner(x - h, y + h)


@lru_cache(maxsize=32)
def _love_spectrum(m: int, n: int) -> Array:
    """Transform (m, n // 2 + 1) of the wrapped coefficients; real, because they are even in both directions."""
    distances = [np.minimum(np.arange(k), k - np.arange(k)) for k in (m, n)]
    return np.ascontiguousarray(np.fft.rfft2(love(*distances)).real)


class HalfSpace:
    """Deflection by pressure on windows of square cells; transforms of every padded size met are kept.

    Parameters
    ----------
    spacing : node spacing [m].
    contact_modulus : E* [Pa], of both bodies when both are elastic (the deflection is then the sum of theirs).
    """

    def __init__(self, spacing: float, contact_modulus: float) -> None:
        self.spacing = spacing
        self.contact_modulus = contact_modulus
        self.unit = spacing / (np.pi * contact_modulus)  # deflection [m] per pressure [Pa] and coefficient
        self._convolutions: dict[tuple[int, int, bool], Convolution] = {}
        self.count = 0  # convolutions done: a cost that does not depend on the machine

    def deflection(self, pressure: Array) -> Array:
        """Deflection [m] at the nodes of a window by the pressure [Pa] on them, shape (m, n) both; nothing is loaded outside.

        Padded only for what lies between a loaded node and the farthest node of the window.
        """
        m, n = pressure.shape
        convolution = self.convolution(*_reach(pressure))
        convolution.clear(m)
        convolution.real[:m, :n] = pressure
        convolution.apply(m)
        self.count += 1
        return convolution.real[:m, :n] * self.unit

    def convolution(self, row_reach: int, column_reach: int, single: bool = False) -> Convolution:
        """The transforms for nodes at most so many rows and columns apart. Who applies them adds to `count`."""
        key = (padded_length(row_reach, single), padded_length(column_reach, single), single)
        if key not in self._convolutions:
            self._convolutions[key] = Convolution(*key)
        return self._convolutions[key]


@njit(cache=True)
def _reach(pressure: Any) -> Any:
    """Greatest distance of any row from a loaded one, and never less than half the window, which must fit; so for columns."""
    rows, columns = pressure.shape
    first_row, last_row, first_column, last_column = rows, 0, columns, 0
    for i in range(rows):
        for j in range(columns):
            if pressure[i, j] != 0.0:
                first_row = min(first_row, i)
                last_row = i
                first_column = min(first_column, j)
                last_column = max(last_column, j)
    return (
        max(last_row, rows - 1 - first_row, (rows + 1) // 2),
        max(last_column, columns - 1 - first_column, (columns + 1) // 2),
    )


@njit(cache=True)
def _multiply(lines: Any, coefficients: Any) -> None:
    """lines *= coefficients, of which the second half of the rows mirrors the first."""
    rows = lines.shape[0]
    for i in range(rows):
        line, row = lines[i], coefficients[min(i, rows - i)]
        for j in range(row.size):
            line[j] *= row[j]


class Convolution:
    """The transforms of one padded size and their work arrays: pressure into `real`, `apply`, deflection out of `real`.

    Parameters
    ----------
    m, n : padded lengths along and across.
    single : transforms of single precision, about 1e-7 of the largest deflection off and up to twice as fast.

    Attributes
    ----------
    real : (m, n) pressure in its first rows and columns before, deflection after, in units of spacing / (pi E*).
    """

    def __init__(self, m: int, n: int, single: bool) -> None:
        real, both = ("float32", "complex64") if single else ("float64", "complex128")
        self.single = single
        self.real = pyfftw.zeros_aligned((m, n), real)
        self._lines = pyfftw.zeros_aligned((m, n // 2 + 1), both)
        self._as_pairs = self._lines.view(real)
        # Each coefficient twice, for the real and the imaginary part of its line. Even along the columns, half of the rows says
        # all and leaves the cache to the lines.
        self._coefficients = np.repeat(_love_spectrum(m, n)[: m // 2 + 1] / (m * n), 2, axis=1).astype(real)
        # FFTW_ESTIMATE, because plans chosen by timing differ from run to run, and with them the last digits.
        flags = ("FFTW_ESTIMATE",)
        self._column_forward = pyfftw.FFTW(self._lines, self._lines, axes=(0,), flags=flags)
        self._column_backward = pyfftw.FFTW(self._lines, self._lines, axes=(0,), direction="FFTW_BACKWARD", flags=flags)
        self._row_plans: dict[int, tuple[pyfftw.FFTW, pyfftw.FFTW]] = {}

    def clear(self, rows: int) -> None:
        """Nothing on the first `rows` rows, nor on what `apply` takes along with them."""
        self.real[: rows + 8] = 0.0

    def apply(self, rows: int) -> None:
        """Deflection on the first `rows` rows by the pressure on them; `real` holds nothing of use below."""
        rows = min(-8 * (-rows // 8), self.real.shape[0])
        if rows not in self._row_plans:
            head, lines = self.real[:rows], self._lines[:rows]
            backward = {"direction": "FFTW_BACKWARD", "flags": ("FFTW_ESTIMATE", "FFTW_DESTROY_INPUT")}
            self._row_plans[rows] = (
                pyfftw.FFTW(head, lines, axes=(1,), flags=("FFTW_ESTIMATE",)),
                pyfftw.FFTW(lines, head, axes=(1,), **backward),
            )
        row_forward, row_backward = self._row_plans[rows]
        row_forward.execute()
        self._lines[rows:] = 0.0
        self._column_forward.execute()
        _multiply(self._as_pairs, self._coefficients)
        self._column_backward.execute()
        row_backward.execute()
