"""Heights of a skewness and a kurtosis, from Johnson's system of distributions.

Bounded heights 1/(1 + exp(-v)) lie below the line of lognormal heights in the plane of skewness and
kurtosis, unbounded heights sinh(v) above it, with v = b u + a and a Gaussian u. Together they have
every kurtosis above the square of the skewness plus 1.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq
from scipy.special import expit, ndtri

from acoustics.arrays import Array
from rolling.surface.heights import moments

POINTS, END = 801, 9.0  # of the integrals over the Gaussian u
STEEPEST, FARTHEST = 128.0, 512.0  # limits of b and a
FLATTEST = 1e-4  # of b, where heights are Gaussian

Shape = Callable[[Array], Array]


def johnson_heights(skewness: float, kurtosis: float, count: int) -> Array:
    """Return ascending heights of mean 0 and mean square 1 with a skewness and a kurtosis.

    They are quantiles at equal steps of probability. Where the count is too small for the kurtosis,
    they come as near as the system allows.
    """
    quantiles = ndtri((np.arange(count) + 0.5) / count)
    u = np.linspace(-END, END, POINTS)
    weights = np.exp(-(u**2) / 2) / np.exp(-(u**2) / 2).sum()
    ends = float(quantiles[0]), float(quantiles[-1])
    shape, slope, offset = _fitted(abs(skewness), kurtosis, np.clip(u, *ends), weights)
    heights = shape(slope * quantiles + offset)
    if skewness < 0:
        heights = -heights[::-1]
    heights -= heights.mean()
    return np.asarray(heights / np.sqrt(np.mean(heights**2)))


def _fitted(
    skewness: float, kurtosis: float, u: Array, weights: Array
) -> tuple[Shape, float, float]:
    """Return shape, b and a of the heights of a skewness >= 0 and a kurtosis."""

    def lognormal(slope: float) -> Array:
        return moments(np.exp(slope * (u - u[-1])), weights)

    # The slope of the lognormal heights of this skewness is the least of both shapes.
    least = _root(lambda b: float(lognormal(b)[0]) - skewness, FLATTEST, STEEPEST)
    unbounded = kurtosis > lognormal(least)[1]
    shape, sign = (_unbounded, 1) if unbounded else (_bounded, -1)

    def offset(slope: float) -> float:
        def skewed(a: float) -> float:
            return float(moments(shape(slope * u + sign * a), weights)[0]) - skewness

        return sign * _root(skewed, 0.0, FARTHEST)

    def excess(slope: float) -> float:
        heights = shape(slope * u + offset(slope))
        return sign * float(moments(heights, weights)[1] - kurtosis)

    slope = _root(excess, least * (1 + 1e-6), STEEPEST)
    return shape, slope, offset(slope)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the root of a rising function between two ends, or the end that is nearest to it."""
    if function(low) >= 0:
        return low
    return high if function(high) <= 0 else float(brentq(function, low, high, xtol=1e-10))


def _unbounded(v: Array) -> Array:
    """Return sinh(v) over its maximum, free of overflow."""
    highest = np.abs(v).max()
    return np.asarray(np.exp(v - highest) - np.exp(-v - highest))


def _bounded(v: Array) -> Array:
    """Return 1/(1 + exp(-v)) over its maximum."""
    return np.asarray(expit(v) / expit(v.max()))
