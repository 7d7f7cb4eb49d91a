"""Values in measured heights that mark unmeasured or saturated points, by suspicion.

Many instruments write a number where they measured none: 32767, -9999, 1e37, or zero in a scan that
lies elsewhere. Such a value repeats exactly, at an end of the heights or at zero, and it lies far
from its neighbours. Honest heights do not: a plateau repeats its height but leads into its
surroundings, a coarse digitizer repeats all heights, steps between flat levels have neighbours of
one height, and a period or a ridge repeats its surroundings as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array

Nodes = NDArray[np.bool_]

# Largest and smallest numbers of 16 and 32 bits, at which a digitizer ends.
FULL_SCALE = (32767, 32768, 65535, 2147483647, 2147483648, 4294967295)
BLANKS = (9999, 99999, 999999, 9999999)  # usual marks of missing points
HUGE = 1e9  # in any unit; real heights are smaller, marks such as 1e37 are larger
SMALLEST_MARK = 1e-12  # [m] smaller heights are rounding, in whatever unit
LEAST = 3  # nodes of a value that is no usual mark
FAR = 3.0  # jumps to the neighbours over the largest usual differences between neighbours
USUAL = 0.999  # quantile of the differences between neighbours that counts as their largest
NEAR = 0.1  # quantile of the jumps that must be large
FLOOR = 25  # nodes of a flat part, on average, from which it is a floor
OUTLIERS = 6  # threshold of `surface.outliers` with which a scene replaces such values
BEYOND = 10.0  # ranges of all other heights, from which on a mark is certain
_MOST = 6  # different marks that are looked for
_SAMPLED = 4_000_000  # nodes whose differences are sorted
_SHIFTS = 20  # places at which a repeated surrounding is looked for


@dataclass(frozen=True)
class Marker:
    """Value that repeats in heights as if it marked points, and the number of its nodes."""

    value: float
    unit: str
    count: int
    nodes: int  # of the whole file

    @property
    def text(self) -> str:
        """The value and its nodes in words."""
        verb = "is" if self.count == 1 else "are"
        size = f"{self.value:.10g} {self.unit}"
        return f"{self.count} of {self.nodes} heights {verb} exactly {size}"


def sentence(suspects: Sequence[Marker], section: str) -> str:
    """Write which values look like marks, and what to do about them.

    The section is "surface" or "sphere.surface" of a scene. Without a scene it is "file", where
    such points count as unmeasured at once, "possible", where they do not, or "reason" for the
    values alone.
    """
    keys = f"surface.outliers {OUTLIERS} together with surface.unmeasured fill"
    advice = f"{keys} replaces such points by their surroundings"
    if section == "sphere.surface":
        advice = "replace such points in the file, since a surface of a sphere has no key that does"
    elif section == "file":
        advice = f"they count as unmeasured here, and in a scene {advice}"
    elif section == "possible":
        advice = f"they count as heights here; if they are none, {advice}, also with --set"
    values = ", ".join(marker.text for marker in suspects)
    if section == "reason":
        return f"{values}, far beyond all others"
    return f"{values}, which looks like a mark of unmeasured or saturated points; {advice}"


def are_certain(values: Array, suspects: Sequence[Marker]) -> bool:
    """Tell whether suspects lie so far from all other heights that they are none.

    One of them suffices, because a file that marks points in one way may mark them in another.
    """
    others = without(np.asarray(values, dtype=np.float64), suspects)
    others = others[np.isfinite(others)]
    if not others.size:
        return False
    highest = float(others.max())
    lowest = float(others.min())
    size = BEYOND * (highest - lowest)
    return any(mark.value > highest + size or mark.value < lowest - size for mark in suspects)


def without(values: Array, suspects: Sequence[Marker]) -> Array:
    """Return heights with NaN where they hold one of the marks."""
    if not suspects:
        return values
    marks = [marker.value for marker in suspects]
    return np.where(np.isin(values, marks), np.nan, values)


def suspected(values: Array, unit: str = "m") -> tuple[Marker, ...]:
    """Return the values in heights (rows, columns) of a unit that look like marks of points.

    Values that are not finite are unmeasured already, and are no marks.
    """
    with np.errstate(over="ignore", invalid="ignore"):  # marks may be the largest numbers
        heights = np.array(values, dtype=np.float64)
        heights[~np.isfinite(heights)] = np.nan
        markers = list[Marker]()
        for _ in range(_MOST):
            marks = [value for value in _candidates(heights) if _is_mark(heights, value)]
            if not marks:
                break
            for mark in marks:
                nodes = heights == mark
                count = int(np.count_nonzero(nodes))
                markers.append(Marker(value=mark, unit=unit, count=count, nodes=heights.size))
                heights[nodes] = np.nan
    return tuple(markers)


def _candidates(heights: Array) -> list[float]:
    """Return maximum and minimum of heights, and zero, where they repeat or are usual marks."""
    if np.isnan(heights).all():
        return []
    highest = float(np.nanmax(heights))
    lowest = float(np.nanmin(heights))
    if highest == lowest:
        return []
    values = [highest, lowest]
    if 0.0 not in values:
        values.append(0.0)
    return [
        value
        for value in values
        if _is_usual_mark(value) or np.count_nonzero(heights == value) >= LEAST
    ]


def _is_mark(heights: Array, value: float) -> bool:
    """Tell whether a value marks points: far from its neighbours, or the end of a digitizer."""
    nodes = heights == value
    count = int(np.count_nonzero(nodes))
    if count == 0:
        return False
    if count >= LEAST and _has_digits(value, FULL_SCALE):
        return True
    jumps = _jumps(heights, nodes)
    if not _is_far(heights, nodes, jumps):
        return False
    if _is_usual_mark(value):
        return True
    if count < LEAST or len(np.unique(jumps)) == 1:  # steps between two flat levels
        return False
    return not _are_floors(nodes, value) and not _recurs(heights, nodes)


def _is_usual_mark(value: float) -> bool:
    """Tell whether a value is one of the numbers that instruments use as marks."""
    return abs(value) >= HUGE or _has_digits(value, FULL_SCALE + BLANKS)


def _has_digits(value: float, numbers: tuple[int, ...]) -> bool:
    """Tell whether a value is one of some numbers, apart from its sign and its unit.

    The number 32767 of nm is 3.2767e-05 where the file holds metres.
    """
    size = abs(value)
    if size < SMALLEST_MARK:
        return False
    for number in numbers:
        exponent = round(np.log10(size / number))
        if abs(size / (number * 10.0**exponent) - 1) < 1e-12:
            return True
    return False


def _is_far(heights: Array, nodes: Nodes, jumps: Array) -> bool:
    """Tell whether the jumps from some nodes to their neighbours exceed all usual differences."""
    value = heights[nodes][0]
    others = ~nodes & ~np.isnan(heights)
    highest = heights[others].max()
    lowest = heights[others].min()
    # The other end may be a mark as well, unless the heights have two levels in all.
    inner = others & (heights < highest) & (heights > lowest)
    usual = _largest_difference(heights, inner) or _largest_difference(heights, others)
    if not jumps.size or usual is None:
        nearest = np.abs(heights[others] - value).min()
        return bool(nearest > FAR * (highest - lowest))
    return bool(np.quantile(jumps, NEAR) > FAR * usual)


def _jumps(heights: Array, nodes: Nodes) -> Array:
    """Return the differences from some nodes to their measured neighbours of other heights."""
    value = heights[nodes][0]
    neighbours = []
    for axis in (0, 1):
        lines = np.moveaxis(heights, axis, 0)
        own = np.moveaxis(nodes, axis, 0)
        neighbours.append(lines[1:][own[:-1] & ~own[1:]])
        neighbours.append(lines[:-1][own[1:] & ~own[:-1]])
    beside = np.concatenate(neighbours)
    return np.asarray(np.abs(beside[~np.isnan(beside)] - value))


def _largest_difference(heights: Array, nodes: Nodes) -> float | None:
    """Return the usual largest difference between neighbours among some nodes, None without any.

    Of a large file a sample is taken.
    """
    differences = []
    for axis in (0, 1):
        stride = -(-heights.size // _SAMPLED)
        lines = np.moveaxis(heights, axis, 0)[:, ::stride]
        own = np.moveaxis(nodes, axis, 0)[:, ::stride]
        differences.append(np.abs(np.diff(lines, axis=0))[own[1:] & own[:-1]])
    both = np.concatenate(differences)
    if not both.size:
        return None
    return float(np.quantile(both, USUAL))


def _are_floors(nodes: Nodes, value: float) -> bool:
    """Tell whether nodes are wide flat parts, such as floors of grooves and dimples, not of zero.

    Zero is the number that a program writes into points without a height.
    """
    from scipy import ndimage  # slow to import

    parts = ndimage.label(nodes)[1]
    return value != 0 and bool(np.count_nonzero(nodes) >= FLOOR * parts)


def _recurs(heights: Array, nodes: Nodes) -> bool:
    """Tell whether the surroundings recur with a value, as on a period or a ridge."""
    places = np.argwhere(nodes)
    for row, column in (places - places[0])[1 : 1 + _SHIFTS]:
        rows, columns = heights.shape
        first = heights[: rows - row, max(-column, 0) : columns - max(column, 0)]
        second = heights[row:, max(column, 0) : columns + min(column, 0)]
        if np.array_equal(first, second, equal_nan=True):
            return True
    return False
