"""Heights and gaps that cannot be metres, and the unit that was meant.

A half-space under a contact has slopes far below 1. Heights in micrometres, read as metres, have
slopes of 1e4 and more: one node would bear the whole load, and the numbers would look like results.
"""

import math

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded

MAX_SLOPE = 10.0  # rms slope; steeper heights are in another unit than metres
# Share of neighbours that are steeper than MAX_SLOPE where the unit is wrong.
MIN_STEEP_SHARE = 0.2
MAX_HEIGHT = 1e6  # [m]
USUAL_SLOPE = 0.1  # of a rough surface, between nodes
_UNITS = {"mm": 1e-3, "um": 1e-6, "nm": 1e-9}
_ROWS = 256  # rows that are differenced at once, which saves memory


def rms_slope(heights: Array) -> float:
    """Return the root mean square of the differences of neighbours along and across [m]."""
    squares = count = 0.0
    for first in range(0, len(heights), _ROWS):
        block = heights[first : first + _ROWS + 1]
        for differences in (np.diff(block, axis=0), np.diff(block[:_ROWS], axis=1)):
            squares += float(np.sum(np.square(differences)))
            count += differences.size
    return math.sqrt(squares / max(count, 1.0))


def rms_height(heights: Array) -> float:
    """Return the rms height [m] about the mean."""
    return float(np.std(heights))


def refuse_steep(name: str, heights: Array, spacing: float) -> None:
    """Raise ValueError for heights or a gap [m] that no unit of metres explains, with the unit.

    A spike, a cliff or the side of a punch may be as steep as it likes. In another unit nearly all
    neighbours are steep.
    """
    slope = rms_slope(heights) / spacing
    if slope <= MAX_SLOPE:
        return
    differences = [np.diff(heights, axis=axis).ravel() for axis in (0, 1)]
    steep = np.abs(np.concatenate(differences)) > MAX_SLOPE * spacing
    if np.mean(steep) < MIN_STEEP_SHARE:
        return
    raise ValueError(
        f"{name}: got an rms slope of {rounded(slope)}, allowed: heights in metres, whose rms slope"
        f" is at most {MAX_SLOPE:g}{_likely_unit(slope)}"
    )


def refuse_rough(name: str, rms: float, radius: float) -> None:
    """Raise ValueError for an rms height [m] above the radius of the sphere [m]."""
    if rms <= radius:
        return
    raise ValueError(
        f"{name}: got an rms height of {rounded(rms)} m, allowed: heights in metres, whose rms"
        f" height is less than the radius of the sphere, {rounded(radius)} m"
    )


def refuse_high(name: str, heights: Array) -> None:
    """Raise ValueError for heights [m] that double precision holds too coarsely for a contact."""
    highest = float(np.abs(heights).max())
    if highest > MAX_HEIGHT:
        raise ValueError(f"{name}: got {rounded(highest)} m, allowed: at most {MAX_HEIGHT:g} m")


def _likely_unit(slope: float) -> str:
    """Write the unit in which the slope would be nearest to that of usual surfaces."""
    slopes = {unit: slope * size for unit, size in _UNITS.items()}
    nearest = min(slopes, key=lambda unit: abs(math.log(slopes[unit] / USUAL_SLOPE)))
    if slopes[nearest] > MAX_SLOPE:
        return "; take a larger spacing, or check the unit"
    real = rounded(slopes[nearest])
    size = _UNITS[nearest]
    return f"; were they in {nearest}, it would be {real}: multiply them by {size:g}"
