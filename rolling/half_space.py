"""Pressure to deflection on an elastic half-space: Love's influence coefficients and a zero-padded FFT convolution (pyfftw)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pyfftw
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Padded lengths for which the transforms are quick; a window has half as many nodes. Steps of about 10 % keep the waste of
# rounding up low and the number of kept transforms small.
_LENGTHS = sorted(
    n for n in {2**a * 3**b * 5**c for a in range(3, 15) for b in range(3) for c in range(2)} if 16 <= n <= 16384
)


def window_size(nodes: int) -> int:
    """Smallest window length >= `nodes` whose padded transform is quick.

    Raises
    ------
    ValueError : more than 8192 nodes.
    """
    for length in _LENGTHS:
        if length >= 2 * nodes:
            return length // 2
    raise ValueError(f"a window of {nodes} nodes is more than the {_LENGTHS[-1] // 2} there is room for")


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
    """Transform (2m, n + 1) of the wrapped coefficients; real, because they are even in both directions."""
    distances = [np.minimum(np.arange(2 * k), 2 * k - np.arange(2 * k)) for k in (m, n)]
    return np.ascontiguousarray(np.fft.rfft2(love(*distances)).real)


class HalfSpace:
    """Deflection by pressure on windows of square cells, each window size with transforms of its own, kept.

    Parameters
    ----------
    spacing : node spacing [m].
    contact_modulus : E* [Pa], of both bodies when both are elastic (the deflection is then the sum of theirs).
    """

    def __init__(self, spacing: float, contact_modulus: float) -> None:
        self.spacing = spacing
        self.contact_modulus = contact_modulus
        self._convolutions: dict[tuple[int, int], _Convolution] = {}
        self.count = 0  # convolutions done: a cost that does not depend on the machine

    def deflection(self, pressure: Array, out: Array | None = None) -> Array:
        """Deflection [m] at the nodes of a window by the pressure [Pa] on them, shape (m, n) both; nothing is loaded outside."""
        m, n = pressure.shape
        size = (window_size(m), window_size(n))
        if size not in self._convolutions:
            self._convolutions[size] = _Convolution(*size)
        if out is None:
            out = np.empty((m, n))
        self._convolutions[size].apply(pressure, self.spacing / (np.pi * self.contact_modulus), out)
        self.count += 1
        return out


class _Convolution:
    """The four transforms of one window size and their work arrays."""

    def __init__(self, m: int, n: int) -> None:
        self.spectrum = _love_spectrum(m, n)
        self.real = pyfftw.zeros_aligned((m, 2 * n), "float64")
        self.complex = pyfftw.zeros_aligned((2 * m, n + 1), "complex128")
        # Row transforms of the padding are zero and its inverse is not needed: only m rows go through. FFTW_ESTIMATE, because
        # plans chosen by timing differ from run to run, and with them the last digits.
        head = self.complex[:m]
        flags = ("FFTW_ESTIMATE",)
        self.row_forward = pyfftw.FFTW(self.real, head, axes=(1,), flags=flags)
        self.column_forward = pyfftw.FFTW(self.complex, self.complex, axes=(0,), flags=flags)
        self.column_backward = pyfftw.FFTW(
            self.complex, self.complex, axes=(0,), direction="FFTW_BACKWARD", flags=flags
        )
        self.row_backward = pyfftw.FFTW(
            head, self.real, axes=(1,), direction="FFTW_BACKWARD", flags=(*flags, "FFTW_DESTROY_INPUT")
        )
        self.scale = 1.0 / (4 * m * n)

    def apply(self, pressure: Array, factor: float, out: Array) -> None:
        m, n = pressure.shape
        self.real[:m, :n] = pressure
        self.real[m:] = 0.0
        self.real[:m, n:] = 0.0
        self.complex[self.real.shape[0] :] = 0.0
        self.row_forward.execute()
        self.column_forward.execute()
        _multiply(self.complex, self.spectrum)
        self.column_backward.execute()
        self.row_backward.execute()
        np.multiply(self.real[:m, :n], factor * self.scale, out=out)


@njit(cache=True)
def _multiply(spectrum, coefficients):
    for i in range(spectrum.shape[0]):
        for j in range(spectrum.shape[1]):
            spectrum[i, j] *= coefficients[i, j]
