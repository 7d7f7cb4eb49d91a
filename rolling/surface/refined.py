"""Surfaces between their nodes: whole surfaces and patches on finer and coarser grids.

Heights are interpolated as band-limited periodic surfaces. Every grid keeps the line of the sphere
in the middle of its width.
"""

from __future__ import annotations

import numpy as np

from rolling._typing import Array

_COLUMNS = 64  # number of columns that are transformed together, to save memory


def refined(heights: Array, times: int) -> Array:
    """Interpolate a band-limited periodic surface to a grid `times` finer.

    The surface moves across so that the line of the sphere stays in the middle.
    """
    along = _padded_lines(heights, times, 0.0)
    # Mid-width, at (n_across - 1) / 2 spacings, lies (times - 1) / 2 fine nodes further on.
    return np.ascontiguousarray(_padded_lines(along.T, times, (times - 1) / 2).T)


def refined_patch(heights: Array, first: int, rows: int) -> Array:
    """Interpolate some rows of a surface to half its spacing.

    The result equals these rows of `refined(heights, 2)`, and takes less memory.

    Parameters
    ----------
    heights : (along, across) array, m. The whole surface, periodic along and across.
    first, rows : int. First row and number of rows; rows beyond the ends are those of the next
        period.
    """
    fine = np.empty((2 * rows, heights.shape[1]))
    fine[::2] = patch(heights, first, rows)
    for column in range(0, heights.shape[1], _COLUMNS):
        block = slice(column, column + _COLUMNS)
        between = _padded_lines(heights[:, block], 1, -0.5)
        fine[1::2, block] = patch(between, first, rows)
    return np.ascontiguousarray(_padded_lines(fine.T, 2, 0.5).T)


def coarsened_patch(heights: Array, first: int, rows: int) -> Array:
    """Return every second node of some rows of a surface, along and across.

    The nodes across lie so that the line of the sphere stays in the middle.
    """
    lines = patch(heights, first, rows)[::2]
    across = heights.shape[1]
    count = across // 2
    # Middles lie (across - 1) / 2 and count - 1 nodes from the first node.
    shift = (count - 1) - (across - 1) / 2
    return np.ascontiguousarray(_padded_lines(lines.T, 1, shift).T[:, : 2 * count : 2])


def patch(heights: Array, first: int, rows: int) -> Array:
    """Return some rows of a surface that is periodic along the track."""
    return heights[(first + np.arange(rows)) % len(heights)]


def _padded_lines(values: Array, times: int, shift: float) -> Array:
    """Interpolate along the first axis by zero-padding the transform, shifted in fine nodes."""
    n = len(values)
    lines = np.fft.rfft(values, axis=0) * times
    if n % 2 == 0 and times > 1:
        # this line holds +Nyquist and -Nyquist, which are two lines on the finer grid
        lines[-1] /= 2
    frequency = np.arange(len(lines)) / (n * times)
    return np.fft.irfft(lines * np.exp(-2j * np.pi * frequency * shift)[:, None], n * times, axis=0)
