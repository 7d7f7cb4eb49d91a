"""The ellipse on which an autocorrelation falls to a level, by which a scene has a lay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from rolling.surface.parameters import decay_of_rays, ray_angles

E_FOLD = math.exp(-1)
TURNED_DEG = 5.0  # angle between a lay and the nearest axis up to which it counts as aligned
LAY = 1.5  # ratio of both lengths from which on heights have a lay that may be turned
EQUAL = 1.1  # ratio of both lengths below which they differ by chance
SIDES = 2.0  # times half the surface: a length beyond all lags is taken to reach so far at most


class Ellipse(NamedTuple):
    """Lags at which an autocorrelation falls to a level, in two perpendicular directions.

    first, second : float, m. The lags in both directions.
    angle_deg : float. Direction of the first, from the track towards positive y; 0 unless the lay
        is turned, and then the first is the shorter one.
    is_continued : bool. Whether a lag lies beyond half the surface, up to which lags are known.
    """

    first: float
    second: float
    angle_deg: float = 0.0
    is_continued: bool = False

    @property
    def across(self) -> float:
        """The lag across the track [m]."""
        angle = math.radians(self.angle_deg)
        return 1 / math.hypot(math.sin(angle) / self.first, math.cos(angle) / self.second)


def ellipse(
    share: Array,
    axes: Sequence[float],
    steps: Array,
    wrap: bool,
    exponent: int,
    level: float = E_FOLD,
    least: float = LAY,
) -> Ellipse | None:
    """Return the ellipse of an autocorrelation with lag 0 in the middle.

    Where the autocorrelation stays above the level up to half the surface, its decay up to there
    goes on as exp(-(r/L)^exponent). It is None where it falls to the level along no axis.

    Parameters
    ----------
    share : (m, n) array
        Autocorrelation, of several nodes each way.
    axes : (2,) sequence, m
        Lags along and across at which it falls to the level, NaN where it does not.
    steps : (2,) array, m
        Spacings along and across.
    wrap : bool
        Whether the surface closes.
    exponent : int
        2 of a Gaussian decay, 1 of an exponential one.
    level : float
        Value to which the autocorrelation falls, by default 1/e.
    least : float
        Ratio of both lengths from which on a lay may be turned.
    """
    if not np.isfinite(axes).any():
        return None
    lags, ends = decay_of_rays(share, steps, wrap, level)
    quarter = len(lags) // 2  # rays from along to across
    lags[[0, quarter]] = axes  # as the sentences have them
    first = _turned_ray(lags, least)
    second = (first + quarter) % len(lags)
    angle_deg = 180.0 * first / len(lags)
    if angle_deg > 90.0:
        angle_deg -= 180.0
    lengths = []
    for ray in (first, second):
        length = float(lags[ray])
        if not math.isfinite(length):
            end = float(ends[ray])
            length = _continued(_at(share, steps, ray, end), end, exponent, level)
        lengths.append(length)
    is_continued = not np.isfinite(lags[[first, second]]).all()
    return Ellipse(lengths[0], lengths[1], angle_deg, is_continued)


def _turned_ray(lags: Array, least: float) -> int:
    """Return the ray of the shortest lag of a lay that is turned, or the ray along the track.

    On an ellipse the inverse square of the lag is a constant and a wave of twice the angle.
    """
    inverse = np.where(np.isfinite(lags), lags, np.inf) ** -2.0
    wave = 2 * np.mean(inverse * np.exp(2j * ray_angles()))
    if abs(wave) / inverse.mean() < (least**2 - 1) / (least**2 + 1):
        return 0
    normal_deg = float(np.degrees(np.angle(wave))) / 2
    from_axis = abs((normal_deg + 45.0) % 90.0 - 45.0)
    if from_axis <= TURNED_DEG:
        return 0
    return round(normal_deg / 180.0 * len(lags)) % len(lags)


def _at(share: Array, steps: Array, ray: int, distance: float) -> float:
    """Return an autocorrelation at a distance [m] on a ray, linear between lags."""
    from scipy import ndimage  # slow to import

    angle = ray_angles()[ray]
    direction = np.array([math.cos(angle), math.sin(angle)])
    place = np.array(share.shape) // 2 + direction * distance / steps
    return float(ndimage.map_coordinates(share, place[:, None], order=1, mode="nearest")[0])


def _continued(share: float, end: float, exponent: int, level: float) -> float:
    """Return the lag [m] at which a decay from 1 to a share at an end falls to a lower level."""
    longest = SIDES * end
    if share >= 1.0:
        return longest
    ratio = math.log(level) / math.log(share)
    return float(min(end * ratio ** (1 / exponent), longest))
