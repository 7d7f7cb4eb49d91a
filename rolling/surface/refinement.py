"""Heights between the nodes of a surface: on finer grids and on the sub-cells of cells.

A surface whose spectrum has died out before the end of its grid is known between its nodes: there
it is its trigonometric interpolation. Any other surface (pits, scratches, exponential laws) is
taken to be flat within the cell of each node.
"""

from __future__ import annotations

import numpy as np

from rolling._typing import Array

# Share of the Nyquist frequency along either axis, above which a spectrum should have died out.
OUTER = 0.75
# Maximum height of the part above that share, over the rms height.
MOST_OUTER = 0.01


def dies_out(heights: Array) -> bool:
    """Return whether the spectrum of heights (along, across) [m] dies out before the grid's end.

    The part of the heights above three quarters of the Nyquist frequency, along either axis, is
    nowhere more than 1 % of the rms height. A single pit of a node exceeds that limit.
    """
    if heights.min() == heights.max():  # without a copy of a large smooth plate
        return True
    z = heights - heights.mean()
    rms = float(np.sqrt(np.mean(z**2)))
    lines = np.fft.rfft2(z)
    along, across = (
        2 * np.abs(np.fft.fftfreq(z.shape[0])),
        2 * np.abs(np.fft.rfftfreq(z.shape[1])),
    )
    lines[np.ix_(along < OUTER, across < OUTER)] = 0.0
    outer = np.fft.irfft2(lines, s=z.shape)
    return float(np.abs(outer).max()) <= MOST_OUTER * rms


def refined(heights: Array, times: int) -> Array:
    """Interpolate a band-limited periodic surface to a grid `times` finer.

    The surface moves across so that the line of the sphere stays in the middle.
    """
    along = _padded_lines(heights, times, 0.0)
    # Mid-width, at (n_across - 1) / 2 spacings, lies (times - 1) / 2 fine nodes further on.
    return np.ascontiguousarray(_padded_lines(along.T, times, (times - 1) / 2).T)


def subcell_heights(heights: Array, subcells: int, smooth: bool) -> Array:
    """Return heights at the centres of the sub-cells, (along r, across r) [m].

    Parameters
    ----------
    heights : (along, across) array, m
        Heights at the centres of cells.
    subcells : int
        Sub-cells r along the side of a cell.
    smooth : bool
        If true, the surface continues between the nodes; otherwise each cell is flat.
    """
    if subcells == 1:
        return heights
    if not heights.any():  # the zeros of a smooth plate take no memory
        return np.zeros((heights.shape[0] * subcells, heights.shape[1] * subcells))
    if not smooth:
        return np.repeat(np.repeat(heights, subcells, axis=0), subcells, axis=1)
    shift = (subcells - 1) / 2
    along = _padded_lines(heights, subcells, shift)
    return np.ascontiguousarray(_padded_lines(along.T, subcells, shift).T)


def _padded_lines(values: Array, times: int, shift: float) -> Array:
    """Interpolate along the first axis by zero-padding the transform, shifted in fine nodes."""
    n = len(values)
    lines = np.fft.rfft(values, axis=0) * times
    if n % 2 == 0 and times > 1:
        # this line holds +Nyquist and -Nyquist, which are two lines on the finer grid
        lines[-1] /= 2
    frequency = np.arange(len(lines)) / (n * times)
    return np.fft.irfft(lines * np.exp(-2j * np.pi * frequency * shift)[:, None], n * times, axis=0)
