"""Single faults of a surface: pits, scratches, dents, bumps, steps and grooves."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array

RIM_OF_DENT = 4.0  # radii of a dent within which its rim dies out


@dataclass(frozen=True, kw_only=True)
class SingleFault:
    """Fault of a surface at a place, or several equal faults at random places.

    Attributes
    ----------
    kind : str
        "pit", "scratch", "dent", "bump", "step" or "groove".
    size_m : float, m
        Diameter, or width of a scratch, groove or flank of a step.
    depth_m : float, m
        Depth, or height of a bump or step.
    at_m : (x, y) or None, m
        Place along the surface from its start, and across from its middle line. None: at random.
    count, seed : int
        Number of faults at random places, and seed of the places.
    length_m : float, m
        Length of a scratch.
    angle_rad : float, rad
        Angle of a scratch to the track.
    rim_height_m, rim_width_m : float, m
        Height and width of the ring of raised material around a pit, which begins at its edge.
    """

    kind: str
    size_m: float
    depth_m: float
    at_m: tuple[float, float] | None = None
    count: int = 0
    seed: int = 0
    length_m: float = 0.0
    angle_rad: float = math.pi / 2
    rim_height_m: float = 0.0
    rim_width_m: float = 0.0

    @property
    def reach_m(self) -> float:
        """Distance [m] from the place of a fault, or from the line of a scratch, where it ends."""
        radii = RIM_OF_DENT if self.kind == "dent" else 1.0
        return radii * self.size_m / 2 + self.rim_width_m

    @property
    def crosses(self) -> bool:
        """Whether the fault crosses the whole surface."""
        return self.kind in ("groove", "step")


def add_faults(heights: Array, faults: Sequence[SingleFault], spacing: float) -> None:
    """Add faults to periodic heights (along, across) [m] in place.

    A fault at y = 0 lies on the middle line of the width.
    """
    along, across = heights.shape
    line = np.zeros(along)  # of faults that cross the whole surface
    for fault in faults:
        for x, y in fault_places(fault, along * spacing, across * spacing):
            if fault.crosses:
                line += _crossing(fault, np.arange(along) * spacing - x, along * spacing)
            else:
                _add_patch(heights, fault, x / spacing, y / spacing + (across - 1) / 2, spacing)
    if line.any():
        heights += line[:, None]


def fault_places(fault: SingleFault, length: float, width: float) -> Array:
    """Return the places (n, 2) [m] of a fault on a surface of some length and width [m]."""
    if fault.at_m is not None:
        return np.array([fault.at_m])
    random = np.random.default_rng(fault.seed)
    return random.uniform((0.0, -width / 2), (length, width / 2), (fault.count, 2))


def _crossing(fault: SingleFault, x: Array, period: float) -> Array:
    """Return the heights [m] of a groove or step at distances x [m] along the track."""
    if fault.kind == "groove":
        away = np.abs((x + period / 2) % period - period / 2)
        return -fault.depth_m * _hill(2 * away / fault.size_m)
    past = x % period
    risen = 0.5 - 0.5 * np.cos(math.pi * np.minimum(past / fault.size_m, 1.0))
    return np.asarray(fault.depth_m * (risen - past / period))


def _add_patch(
    heights: Array, fault: SingleFault, row: float, column: float, spacing: float
) -> None:
    """Add a fault about a row and a column, in nodes, to the heights [m] around it."""
    size = fault.size_m
    length = fault.length_m
    reach = fault.reach_m + length / 2
    rows = _nodes_near(row, reach / spacing, heights.shape[0])
    columns = _nodes_near(column, reach / spacing, heights.shape[1])
    x = (rows[:, None] - row) * spacing
    y = (columns - column) * spacing
    if length:  # the distance from the line of a scratch
        cosine = math.cos(fault.angle_rad)
        sine = math.sin(fault.angle_rad)
        beyond_end = np.maximum(np.abs(cosine * x + sine * y) - length / 2, 0.0)
        distance = np.hypot(beyond_end, cosine * y - sine * x)
    else:
        distance = np.hypot(x, y)
    share = _fault_profile(fault.kind, 2 * distance / size)
    places = np.ix_(rows % heights.shape[0], columns % heights.shape[1])
    heights[places] += fault.depth_m * share
    if fault.rim_height_m > 0:
        from_middle = distance - size / 2 - fault.rim_width_m / 2
        heights[places] += fault.rim_height_m * _hill(2 * np.abs(from_middle) / fault.rim_width_m)


def _nodes_near(middle: float, reach: float, nodes: int) -> NDArray[np.int64]:
    """Return the nodes within a reach of a middle, at most one period of them."""
    first = max(math.ceil(middle - reach), math.ceil(middle - nodes / 2))
    last = min(math.floor(middle + reach), first + nodes - 1)
    return np.arange(first, last + 1, dtype=np.int64)


def _fault_profile(kind: str, r: Array) -> Array:
    """Return the heights of a kind over its depth, at r radii from its middle or line."""
    if kind == "pit":
        return np.minimum(r**2 - 1, 0.0)
    if kind == "dent":  # its volume is zero
        return np.asarray((r**2 - 1) * np.exp(-(r**2)))
    if kind == "bump":
        return _hill(r)
    return -_hill(r)


def _hill(r: Array) -> Array:
    """Return a raised cosine of height 1 and radius 1."""
    return 0.5 + 0.5 * np.cos(math.pi * np.minimum(r, 1.0))
