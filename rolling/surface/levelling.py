"""Tilt and seam of measured heights: what a wrap-around would add to a crop, and the plane that takes it off.

Depends on numpy only. Heights are read as one period of the surface. A crop of a larger one is none: its last row does not lead
to its first, and a tilt of the table passes for a cliff there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Of the greatest difference between neighbouring rows: a seam that stands out is larger by this much and by 4 / rows.
BEYOND_GREATEST = 1.2
# Of the distance from the median to the greatest: a seam that stands out lies further out by this much and by 16 / rows.
BEYOND_RANGE = 2.0
# Of the usual rms: less is no tilt by medians, which on coarsely quantized heights are zero or a whole quantum.
BEYOND_USUAL = 2.0


@dataclass(frozen=True)
class Seam:
    """The step from the last row of heights to the first one.

    step : rms across the seam [m].
    neighbours : median over all neighbouring rows of the rms between them [m].
    stands_out : the seam is no neighbour like the others.
    """

    step: float
    neighbours: float
    stands_out: bool


@dataclass(frozen=True)
class Levelling:
    """The plane of heights that were read, and what was done about it; pairs are along and across the track.

    plane : slopes of the least-squares plane of the heights as they were read [m/m].
    taken : slopes that were taken off [m/m], 0 where nothing was.
    lengths : of the file [m].
    ra_before, ra_after : arithmetic mean roughness [m].
    seams : of the heights that are used.
    """

    plane: tuple[float, float]
    taken: tuple[float, float]
    lengths: tuple[float, float]
    ra_before: float
    ra_after: float
    seams: tuple[Seam, Seam]

    @property
    def rises(self) -> tuple[float, float]:
        """Height that was taken off over the file [m], along and across."""
        return self.taken[0] * self.lengths[0], self.taken[1] * self.lengths[1]


def level(heights: Array, spacing: float, mode: str) -> tuple[Array, Levelling]:
    """Take the least-squares plane off heights of zero mean; heights that keep theirs are returned as they are.

    Parameters
    ----------
    heights : (m, n) heights [m] along and across the track.
    spacing : node spacing [m].
    mode : auto, plane or none. auto: each direction of its own, where the seam stands out and the plane lowers it.
    """
    seams = seam(heights, 0), seam(heights, 1)
    plane = slope(heights, spacing, 0), slope(heights, spacing, 1)
    wanted = [mode == "plane" or (mode == "auto" and _helps(heights, spacing, k, seams[k], plane[k])) for k in (0, 1)]
    taken = plane[0] if wanted[0] else 0.0, plane[1] if wanted[1] else 0.0
    before = after = float(np.abs(heights).mean())
    if any(taken):
        along, across = (s * spacing * centred(n) for s, n in zip(taken, heights.shape, strict=True))
        heights = heights - along[:, None]
        heights -= across
        after = float(np.abs(heights).mean())
        seams = seam(heights, 0), seam(heights, 1)
    lengths = heights.shape[0] * spacing, heights.shape[1] * spacing
    return heights, Levelling(plane, taken, lengths, before, after, seams)


def seam(heights: Array, axis: int) -> Seam:
    """Judge the step across the seam of one axis by the differences between all neighbouring rows.

    The seam stands out where its size s is beyond (1.2 + 4/m) times the greatest difference g of two neighbours, and beyond
    the median d of them by more than (2 + 16/m) (g - d), m being the number of rows. The greatest one decides, so that grooves,
    spikes and cliffs of a periodic surface, which come in pairs, are not called a seam when one half of a pair lies there; the
    median and the number of rows measure how far out a chance difference may lie. The size of a difference is its rms, or its
    median magnitude, which single outliers do not reach: either may show the seam. A groove or a cliff over the
    whole width that is as deep as the seam's step hides it.
    """
    last_to_first = np.take(heights, 0, axis) - np.take(heights, -1, axis)
    differences = np.abs(np.diff(heights, axis=axis))
    rms = np.sqrt(np.mean(np.square(differences), axis=1 - axis))
    step = float(np.sqrt(np.mean(last_to_first**2)))
    medians = np.median(differences, axis=1 - axis)
    usual, middle = float(np.median(rms)), float(np.median(np.abs(last_to_first)))
    stands_out = _stands_out(step, rms) or (middle > BEYOND_USUAL * usual and _stands_out(middle, medians))
    return Seam(step, usual, stands_out)


def slope(heights: Array, spacing: float, axis: int) -> float:
    """Slope of the least-squares plane along one axis [m/m]; on a grid it does not depend on the other one."""
    return float(_share_of(heights, centred(heights.shape[axis]), axis)) / spacing


def form_share(heights: Array) -> float:
    """Share of the heights' variance that a plane and a parabola along and across make up, from 0 to 1."""
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
    """Places of n nodes about their middle, in nodes."""
    return np.arange(n, dtype=np.float64) - (n - 1) / 2


def _share_of(heights: Array, shape: Array, axis: int) -> float:
    """Least-squares factor of a shape along one axis, of zero mean, in the heights."""
    return float(heights.mean(axis=1 - axis) @ shape / (shape @ shape))


def _helps(heights: Array, spacing: float, axis: int, seam: Seam, slope: float) -> bool:
    if not seam.stands_out:
        return False
    step = np.take(heights, 0, axis) - np.take(heights, -1, axis) + slope * spacing * (heights.shape[axis] - 1)
    return bool(np.sqrt(np.mean(step**2)) < seam.step)


def _stands_out(size: float, neighbours: Array) -> bool:
    rows = len(neighbours) + 1
    median, greatest = float(np.median(neighbours)), float(neighbours.max())
    return size > (BEYOND_GREATEST + 4 / rows) * greatest and size - median > (BEYOND_RANGE + 16 / rows) * (
        greatest - median
    )
