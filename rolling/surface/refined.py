"""Heights between the nodes of a surface: on finer and coarser grids and on sub-cells of cells.

A surface whose law or spectrum dies out before the end of its grid is known between its nodes:
there it is its trigonometric interpolation. Any other surface (pits, scratches, exponential laws)
is taken to be flat within the cell of each node. Every grid keeps the line of the sphere in the
middle of its width. `numerics.subcells: auto` takes sub-cells on steep surfaces.
"""

import math

import numpy as np

from acoustics.arrays import Array

# Share of the Nyquist frequency along either axis, above which a spectrum should have died out.
OUTER = 0.75
# Maximum height of the part above that share, over the rms height.
MAX_OUTER = 0.01
# Sub-cells along the side of a cell that `auto` takes on steep surfaces.
STEEP_SUBCELLS = 2
# A surface is steep from this ratio on: half the rms slope times the node spacing, over a node's
# deflection by the hardness on its own cell. Ra 0.1 um at 2.1 GPa has 1.2, Ra 1 um 12.
STEEP = 3.0
# Deflection of the centre of a square by a uniform pressure, over side times pressure over E*.
OWN = 4 * math.asinh(1) / math.pi
_COLUMNS = 64  # number of columns that are transformed together, to save memory


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
    along = np.fft.fftfreq(z.shape[0])
    across = np.fft.rfftfreq(z.shape[1])
    lines[np.ix_(2 * np.abs(along) < OUTER, 2 * np.abs(across) < OUTER)] = 0.0
    return float(np.abs(np.fft.irfft2(lines, s=z.shape)).max()) <= MAX_OUTER * rms


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
        return _repeated(heights, subcells)
    shift = (subcells - 1) / 2
    along = _padded_lines(heights, subcells, shift)
    return np.ascontiguousarray(_padded_lines(along.T, subcells, shift).T)


def cells_of_patch(
    heights: Array, first: int, rows: int, side: float, subcells: int, smooth: bool
) -> Array:
    """Return heights of some rows of a surface on finer or coarser cells with their sub-cells.

    Parameters
    ----------
    heights : (along, across) array, m
        The whole surface, periodic along and across.
    first, rows : int
        First row and number of rows, which is even; rows beyond the ends belong to the next
        period.
    side : float
        Side of the new cells in nodes of the surface: 1/2, 1 or 2.
    subcells : int
        Sub-cells r along the side of a new cell.
    smooth : bool
        If true, the surface continues between the nodes, and the centre of the first new cell lies
        on the first row. Otherwise each cell is flat, and new cells begin where old cells do.

    Returns
    -------
    (rows r / side, across r / side) array, m
        Heights at the centres of the sub-cells.
    """
    if not smooth:
        return _repeated(_flat_patch(heights, first, rows, side), subcells)
    fine = side / subcells
    across = heights.shape[1]
    along = round(rows / fine)
    width = int(across / side) * subcells
    lines = np.empty((along, across))
    for column in range(0, across, _COLUMNS):
        block = slice(column, column + _COLUMNS)
        start = first - (subcells - 1) / 2 * fine
        lines[:, block] = _lines_at(heights[:, block], start, fine, along)
    start = (across - 1) / 2 - (width - 1) / 2 * fine
    return np.ascontiguousarray(_lines_at(lines.T, start, fine, width).T)


def _flat_patch(heights: Array, first: int, rows: int, side: float) -> Array:
    """Return flat cells of some rows on finer cells, or the means of two by two cells."""
    patch = heights[(first + np.arange(rows)) % len(heights)]
    if side <= 1:
        return _repeated(patch, round(1 / side))
    pairs = patch[:, : patch.shape[1] // 2 * 2].reshape(rows // 2, 2, -1, 2)
    means: Array = pairs.mean(axis=(1, 3))
    return means


def _repeated(heights: Array, times: int) -> Array:
    """Return each height `times` times along and across."""
    return np.repeat(np.repeat(heights, times, axis=0), times, axis=1)


def _lines_at(values: Array, start: float, step: float, count: int) -> Array:
    """Interpolate periodic lines along the first axis at start + k step, in nodes.

    The step is a whole number of nodes or one over a whole number.
    """
    times = max(1, round(1 / step))
    stride = max(1, round(step))
    whole = round(start * times)
    if times > 1 or whole != start:
        values = _padded_lines(values, times, whole - start * times)
    return values[(whole + stride * np.arange(count)) % len(values)]


def _padded_lines(values: Array, times: int, shift: float) -> Array:
    """Interpolate along the first axis by zero-padding the transform, shifted in fine nodes."""
    n = len(values)
    lines = np.fft.rfft(values, axis=0) * times
    if n % 2 == 0 and times > 1:
        # this line holds +Nyquist and -Nyquist, which are two lines on the finer grid
        lines[-1] /= 2
    frequency = np.arange(len(lines)) / (n * times)
    return np.fft.irfft(lines * np.exp(-2j * np.pi * frequency * shift)[:, None], n * times, axis=0)


def median_step(heights: Array) -> float:
    """Return the median change of heights [m] from node to node, along and across together."""
    if heights.min() == heights.max():  # without a copy of a large smooth plate
        return 0.0
    steps = np.hypot(np.roll(heights, -1, axis=0) - heights, np.roll(heights, -1, axis=1) - heights)
    return float(np.median(steps))


def rms_slope(median: float, spacing: float) -> float:
    """Return the rms slope of random heights with this median step [m].

    Pits and scratches, which are steep in few places, hardly change it.
    """
    return median / spacing / math.sqrt(math.log(2))


def auto_subcells(slope: float, contact_modulus: float, hardness: float) -> int:
    """Choose the sub-cells along the side of a cell for a surface of this slope [-].

    Sub-cells gain most where the heights vary within a cell by more than pressures can level: on
    steep surfaces that yield. Elsewhere a single node per cell finds the edge well enough, as it
    does in an elastic contact.
    """
    levelled = OWN * hardness / contact_modulus
    if 0.5 * slope > STEEP * levelled:
        return STEEP_SUBCELLS
    return 1
