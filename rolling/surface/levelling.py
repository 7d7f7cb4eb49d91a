"""Tilt, form and seam of measured heights.

By default, heights are read as one period of the surface. A crop of a larger surface is no period:
its last row does not lead to its first, and a tilt of the specimen passes for a cliff there.
Subtracting a plane removes the tilt, and a form what a part is meant to have.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array
from rolling.surface.form import has_curved_form, named_form

# A seam stands out if it exceeds the maximum difference between neighbouring rows by this factor
# plus 4 / rows.
BEYOND_MAXIMUM = 1.2
# It must also exceed the median by more than this factor plus 16 / rows times the distance from the
# median to the maximum.
BEYOND_RANGE = 2.0
# A median difference below this factor times the usual rms is no sign of tilt: coarsely quantized
# heights have medians of zero or a whole quantum.
BEYOND_USUAL = 2.0


@dataclass(frozen=True)
class Seam:
    """Step from the last row of heights to the first, beside the steps between neighbours."""

    step: float  # [m] rms difference across the seam
    neighbours: float  # [m] median of the rms differences between neighbouring rows
    stands_out: bool  # whether the step is unlike the differences between neighbours


@dataclass(frozen=True)
class Levelling:
    """Plane of the heights of a file, along and across, and the part of it that was removed."""

    plane: tuple[float, float]  # [m/m] slopes of the least-squares plane of the heights as read
    taken: tuple[float, float]  # [m/m] slopes that were removed, or 0
    lengths: tuple[float, float]  # [m]
    ra_before: float  # [m]
    ra_after: float  # [m]
    seams: tuple[Seam, Seam]  # of the heights that are used
    form: str = ""  # what was removed with the plane, in words

    @property
    def rises(self) -> tuple[float, float]:
        """Height [m] of the subtracted plane over the whole file, along and across."""
        return self.taken[0] * self.lengths[0], self.taken[1] * self.lengths[1]


def level(heights: Array, spacing: float | Sequence[float], mode: str) -> tuple[Array, Levelling]:
    """Subtract the least-squares plane or form from heights of zero mean, if the mode asks for it.

    Heights that keep their plane are returned as they are.

    Parameters
    ----------
    heights : (m, n) array, m
        Heights along and across the track.
    spacing : float or (2,) sequence of float, m
        Node spacing, or the spacings along and across.
    mode : str
        "auto", "plane", "none", or a form: "quadratic", "polynomial-3" to "polynomial-8",
        "cylinder" or "sphere". "auto" removes each direction by itself, where the seam stands out
        and the plane lowers it.
    """
    seams = (seam(heights, 0), seam(heights, 1))
    along, across = np.broadcast_to(spacing, 2)
    steps = (float(along), float(across))
    plane = (slope(heights, steps[0], 0), slope(heights, steps[1], 1))
    form = ""
    removed = [0.0, 0.0]
    for axis in (0, 1):
        is_removed = mode != "none"
        if mode == "auto":
            is_removed = _lowers_seam(heights, steps[axis], axis, seams[axis], plane[axis])
        if is_removed:
            removed[axis] = plane[axis]
    taken = (removed[0], removed[1])
    ra_before = float(np.abs(heights).mean())
    ra_after = ra_before
    has_form = has_curved_form(mode)
    if any(taken) or has_form:
        if has_form:  # with its own tilt, as a round form without its plane is no longer round
            of_form, form = named_form(heights, steps, mode)
            heights = heights - of_form
        else:
            heights = heights - (taken[0] * steps[0] * centred(heights.shape[0]))[:, None]
            heights -= taken[1] * steps[1] * centred(heights.shape[1])
        ra_after = float(np.abs(heights).mean())
        seams = (seam(heights, 0), seam(heights, 1))
    levelling = Levelling(
        plane=plane,
        taken=taken,
        lengths=(heights.shape[0] * steps[0], heights.shape[1] * steps[1]),
        ra_before=ra_before,
        ra_after=ra_after,
        seams=seams,
        form=form,
    )
    return heights, levelling


def seam(heights: Array, axis: int) -> Seam:
    """Judge the step across the seam by the differences between all neighbouring rows.

    The seam stands out where its size s is above (1.2 + 4/m) times the maximum difference g of two
    neighbours, and above their median d by more than (2 + 16/m) (g - d), with m rows. The maximum
    decides, because grooves, spikes and cliffs of a periodic surface come in pairs, and half of
    such a pair at the seam is no seam. The median and the number of rows measure how far out a
    chance difference may lie. The size of a difference is its rms, or its median magnitude, which
    single outliers do not affect; either may show the seam. A groove or a cliff over the whole
    width hides a seam whose step is no deeper.
    """
    last_to_first = _across_seam(heights, axis)
    differences = np.abs(np.diff(heights, axis=axis))
    rms = np.sqrt(np.mean(np.square(differences), axis=1 - axis))
    step = float(np.sqrt(np.mean(last_to_first**2)))
    medians = np.median(differences, axis=1 - axis)
    usual = float(np.median(rms))
    middle = float(np.median(np.abs(last_to_first)))
    is_unusual = middle > BEYOND_USUAL * usual and _stands_out(middle, medians)
    return Seam(step=step, neighbours=usual, stands_out=_stands_out(step, rms) or is_unusual)


def slope(heights: Array, spacing: float, axis: int) -> float:
    """Return the slope [m/m] of the least-squares plane along one axis.

    On a grid the other axis does not change it.
    """
    return float(_share_of(heights, centred(heights.shape[axis]), axis)) / spacing


def form_share(heights: Array) -> float:
    """Return the share of the variance that a plane and parabolas make up, 0 to 1.

    The parabolas lie along and across the track.
    """
    variance = float(np.mean(np.square(heights)))
    if variance == 0:
        return 0.0
    explained = 0.0
    for axis, n in enumerate(heights.shape):
        line = centred(n)
        parabola = line**2 - np.mean(line**2)
        for shape in (line, parabola):  # orthogonal on the grid
            explained += _share_of(heights, shape, axis) ** 2 * float(np.mean(shape**2))
    return explained / variance


def centred(n: int) -> Array:
    """Return the positions of n nodes about their middle, in nodes."""
    return np.arange(n, dtype=np.float64) - (n - 1) / 2


def _share_of(heights: Array, shape: Array, axis: int) -> float:
    """Return the least-squares factor of a shape of zero mean along one axis in the heights."""
    return float(heights.mean(axis=1 - axis) @ shape / (shape @ shape))


def _lowers_seam(heights: Array, spacing: float, axis: int, seam: Seam, slope: float) -> bool:
    """Tell whether the seam stands out and subtracting the plane lowers it."""
    if not seam.stands_out:
        return False
    step = _across_seam(heights, axis) + slope * spacing * (heights.shape[axis] - 1)
    return bool(np.sqrt(np.mean(step**2)) < seam.step)


def _across_seam(heights: Array, axis: int) -> Array:
    """Return the differences from the last row of heights to the first [m]."""
    return np.asarray(np.take(heights, 0, axis) - np.take(heights, -1, axis))


def _stands_out(size: float, neighbours: Array) -> bool:
    """Tell whether a difference across the seam exceeds the range of all neighbours."""
    rows = len(neighbours) + 1
    median = float(np.median(neighbours))
    maximum = float(neighbours.max())
    beyond_range = (BEYOND_RANGE + 16 / rows) * (maximum - median)
    return size > (BEYOND_MAXIMUM + 4 / rows) * maximum and size - median > beyond_range
