"""How much alike the levels of tracks on one surface are, by the autocorrelation of what is heard.

Tracks on one scan share its ridges. The level of a track is that of the mean square of a signal
u(x, y) along it, whose autocorrelation C over the whole surface is known from the heights. For
Gaussian u the mean squares over two windows of the same length covary as the square of C, summed
over all pairs of their points (Isserlis), so the correlation of the levels of windows that are
shifted by (s, d) is

    r(s, d) = sum_m w(m) C(s + m, d)^2 / sum_m w(m) C(m, 0)^2

w is the triangle of the window, the number of pairs of its points at a lag m. The surface closes on
itself, so all lags are circular. Levels are logarithms of mean squares, whose correlation is the
same as far as they scatter by a few decibels.

The autocorrelation is that of the surface itself. What it has of chance makes tracks appear alike
by about the width of a ridge over the width of the surface, so the number of independent places is
rather too small than too large.

References
----------
L. Isserlis, On a formula for the product-moment coefficient of any order of a normal frequency
distribution in any number of variables, Biometrika 12, 1918, 134-139. J. S. Bendat and
A. G. Piersol, Random data, 4th edition, 2010, section 8.3, for the variance of mean squares.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import fft

from acoustics.arrays import Array


class AlikeLevels(NamedTuple):
    """Correlation of the levels of windows on one surface, and how much they scatter.

    correlation : (along, across) array. Correlation of two windows by their circular shift.
    variance : float. Variance of the mean square of a window over the square of its mean.
    """

    correlation: Array
    variance: float

    def between(self, along: Array, across: Array) -> Array:
        """Return the correlations of windows, (windows, windows).

        Parameters
        ----------
        along, across : (windows,) arrays of int
            Nodes by which they are shifted.
        """
        nodes_along, nodes_across = self.correlation.shape
        shift_along = (along[:, None] - along) % nodes_along
        shift_across = (across[:, None] - across) % nodes_across
        return np.asarray(self.correlation[shift_along, shift_across], dtype=float)


def alike_levels(signal: Array, window: int) -> AlikeLevels:
    """Return how much alike the levels of windows of a signal on a surface are.

    Parameters
    ----------
    signal : (along, across) array
        What is heard at each node, on a surface that closes on itself.
    window : int
        Nodes of a window along the surface, up to all.

    Raises
    ------
    ValueError : the signal is silent.
    """
    along, across = signal.shape
    spectrum = fft.rfft2(np.asarray(signal, dtype=np.float32))
    squares = fft.irfft2(np.square(np.abs(spectrum)), s=(along, across))
    if not squares[0, 0] > 0:
        raise ValueError("signal: got silence, allowed: a signal with fluctuations")
    squares /= squares[0, 0]
    np.square(squares, out=squares)
    box = np.zeros(along)
    box[:window] = 1.0 / window
    triangle = np.square(np.abs(fft.rfft(box)))[:, None]
    summed = fft.irfft(fft.rfft(squares, axis=0) * triangle, n=along, axis=0)
    of_window = float(summed[0, 0])
    return AlikeLevels(correlation=summed / of_window, variance=2.0 * of_window)
