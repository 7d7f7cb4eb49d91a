"""Gaussian filters of ISO 16610: of profiles (part 21), areal (61), and areal and robust (71)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import fft

from acoustics.arrays import Array
from rolling.surface.parameters import without_plane
from rolling.surface.stylus import ALPHA

REACH = 2.0  # of a Gaussian filter in units of ALPHA times its index: exp(-4 pi) is 3e-6
# Distance of a height from the mean surface, in median magnitudes of all of them, from which on it
# does not count: three standard deviations of Gaussian heights (ISO 16610-31).
FAR = 4.4478
_SETTLED = 1e-4  # relative change of that distance at which the iteration ends
_MOST_PASSES = 50
_LEAST_WEIGHT = 1e-12


def smoothed(heights: Array, steps: Sequence[float], index: float, wraps: bool) -> Array:
    """Return the waves longer than a nesting index [m] that the areal Gaussian filter passes.

    The filter halves the amplitude at the index. Heights that do not wrap are filtered without
    their plane, and the weights are scaled to a sum of 1 at the edges.
    """
    z = heights if wraps else without_plane(heights)
    return np.asarray(_averaged(z, steps, index, wraps) + (heights - z))


def robust_smoothed(heights: Array, steps: Sequence[float], index: float, wraps: bool) -> Array:
    """Return the long waves that the robust areal Gaussian filter passes, past pits and scratches.

    It is the Gaussian regression of order 0, with weights (1 - (r/c)^2)^2 of Tukey for a distance r
    from the long waves, and 0 beyond c, which is FAR times the median of all distances. Weights and
    waves take turns until c stays. Heights that do not wrap are filtered without their plane.
    """
    z = heights if wraps else without_plane(heights)
    long = _averaged(z, steps, index, wraps)
    last = np.inf
    for _ in range(_MOST_PASSES):
        distance = np.abs(z - long)
        far = FAR * float(np.median(distance))
        if not far > 0 or abs(far - last) <= _SETTLED * far:
            break
        last = far
        weights = np.square(np.maximum(1 - np.square(distance / far), 0.0))
        total = _averaged(weights, steps, index, wraps)
        weighted = _averaged(weights * z, steps, index, wraps)
        # Where no height counts, as in a pit wider than the filter, the waves stay as they were.
        has_any = total > _LEAST_WEIGHT
        long = np.where(has_any, weighted / np.where(has_any, total, 1.0), long)
    return np.asarray(long + (heights - z))


def _averaged(z: Array, steps: Sequence[float], index: float, wraps: bool) -> Array:
    """Return the areal Gaussian means of heights."""
    for axis, step in enumerate(steps):
        z = long_waves(z, step, index, wraps, axis)
    return z


def long_waves(z: Array, step: float, index: float, wraps: bool, axis: int = 0) -> Array:
    """Return the Gaussian means of heights along one axis, as the mean lines of profiles.

    At ends that do not wrap the weights have a sum of 1, too.
    """
    n = z.shape[axis]
    pad = 0 if wraps else int(REACH * ALPHA * index / step) + 1
    size = fft.next_fast_len(n + pad, real=True) if pad else n
    gain = np.exp(-np.pi * (ALPHA * index * fft.rfftfreq(size, step)) ** 2)
    weight = fft.irfft(fft.rfft(np.ones(n), size) * gain, size)[:n]
    if axis == 0:
        gain = gain[:, None]
        weight = weight[:, None]
    passed = fft.irfft(fft.rfft(z, size, axis) * gain, size, axis).take(range(n), axis)
    return np.asarray(passed / weight)
