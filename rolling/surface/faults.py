"""Heights of single faults, added to the heights of a surface."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from rolling.scene.laws import SurfaceFault

RIM = 4.0  # radii of a dent within which its rim dies out


def add_faults(heights: Array, faults: Sequence[SurfaceFault], spacing: float) -> None:
    """Add faults to periodic heights (along, across) [m] in place.

    A fault at y = 0 lies on the line of the sphere, in the middle of the width.
    """
    along, across = heights.shape
    line = np.zeros(along)  # of faults that cross the whole surface
    for fault in faults:
        for x, y in _places(fault, along * spacing, across * spacing):
            if fault.crosses:
                line += _crossing(fault, np.arange(along) * spacing - x, along * spacing)
            else:
                _add_patch(heights, fault, x / spacing, y / spacing + (across - 1) / 2, spacing)
    if line.any():
        heights += line[:, None]


def _places(fault: SurfaceFault, length: float, width: float) -> Array:
    """Return the places (n, 2) [m] of a fault on a surface of some length and width [m]."""
    if fault.at_mm is not None:
        return np.array([fault.at_mm]) * 1e-3
    random = np.random.default_rng(fault.seed)
    return random.uniform((0.0, -width / 2), (length, width / 2), (fault.count or 0, 2))


def _crossing(fault: SurfaceFault, x: Array, period: float) -> Array:
    """Return the heights [m] of a groove or step at distances x [m] along the track."""
    size, depth = fault.size_um * 1e-6, fault.depth_um * 1e-6
    if fault.kind == "groove":
        away = np.abs((x + period / 2) % period - period / 2)
        return -depth * _hill(2 * away / size)
    past = x % period
    risen = 0.5 - 0.5 * np.cos(math.pi * np.minimum(past / size, 1.0))
    return np.asarray(depth * (risen - past / period))


def _add_patch(
    heights: Array, fault: SurfaceFault, row: float, column: float, spacing: float
) -> None:
    """Add a fault about a row and a column, in nodes, to the heights [m] around it."""
    size, length = fault.size_um * 1e-6, (fault.length_um or 0.0) * 1e-6
    reach = (RIM if fault.kind == "dent" else 1.0) * size / 2 + length / 2
    rows, columns = (
        _within(middle, reach / spacing, nodes)
        for middle, nodes in zip((row, column), heights.shape, strict=True)
    )
    x, y = (rows[:, None] - row) * spacing, (columns - column) * spacing
    if length:  # the distance from the line of a scratch
        angle = math.radians(90.0 if fault.angle_deg is None else fault.angle_deg)
        cosine, sine = math.cos(angle), math.sin(angle)
        along = np.maximum(np.abs(cosine * x + sine * y) - length / 2, 0.0)
        x, y = along, cosine * y - sine * x
    share = _shape(fault.kind, 2 * np.hypot(x, y) / size)
    places = np.ix_(rows % heights.shape[0], columns % heights.shape[1])
    heights[places] += fault.depth_um * 1e-6 * share


def _within(middle: float, reach: float, nodes: int) -> NDArray[np.int64]:
    """Return the nodes within a reach of a middle, at most one period of them."""
    first = max(math.ceil(middle - reach), math.ceil(middle - nodes / 2))
    last = min(math.floor(middle + reach), first + nodes - 1)
    return np.arange(first, last + 1, dtype=np.int64)


def _shape(kind: str, r: Array) -> Array:
    """Return the heights of a kind over its depth, at r radii from its middle or line."""
    if kind == "pit":
        return np.minimum(r**2 - 1, 0.0)
    if kind == "dent":  # its volume is zero
        return np.asarray((r**2 - 1) * np.exp(-(r**2)))
    return _hill(r) if kind == "bump" else -_hill(r)


def _hill(r: Array) -> Array:
    """Return a raised cosine of height 1 and radius 1."""
    return 0.5 + 0.5 * np.cos(math.pi * np.minimum(r, 1.0))
