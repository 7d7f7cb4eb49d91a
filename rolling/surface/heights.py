"""Periodic surface heights: generation by spectral filtering, and statistics."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.surface.height_law import CorrelationLaw, HeightSpectrum, SelfAffineSpectrum
from rolling.surface.parameters import roughness

_NEGLIGIBLE = 1e-7  # autocorrelation
_MAX_LAGS = 2e8  # nodes of a turned law


class SurfaceError(ValueError):
    """Error of heights that cannot be made or used."""


@dataclass(frozen=True)
class Correlation:
    """Autocorrelation of heights along one axis, in two numbers."""

    length: float  # [m] lag at which it falls to 1/e, infinite where it never does
    noise: float  # share of the variance of a node alone, from 0 (smooth) to 1 (white noise)


@dataclass(frozen=True)
class Statistics:
    """Roughness of a surface about its mean plane; lengths are in m, the rest has no unit."""

    ra: float
    rq: float
    skewness: float
    kurtosis: float
    rms_slope: float
    highest: float
    lowest: float


def filtered(noise: Array, spacing: float, law: HeightSpectrum) -> Array:
    """Filter periodic white noise (m, n) of a spacing [m] to heights of a law and any size.

    Raises
    ------
    SurfaceError
        The filter leaves nothing.
    """
    density = spectral_density(noise.shape, spacing, law)
    heights: Array = np.fft.irfft2(np.fft.rfft2(noise) * np.sqrt(density), s=noise.shape)
    heights -= heights.mean()
    # A surface much smaller than its correlation length is flat except for rounding errors, which
    # would pass for roughness if they were scaled up.
    least = 1e-6 * np.sqrt(density.max() / heights.size)
    if isinstance(law, CorrelationLaw) and not np.abs(heights).mean() > least:
        surface_um = " x ".join(rounded(n * spacing * 1e6, 4) for n in noise.shape)
        # If the law falls with (r / L)^exponent, the share of roughness falls with its root.
        longest = 0.1 * 1e12 ** (1 / law.exponent) * max(noise.shape) * spacing * 1e6
        lengths_um = " and ".join(rounded(length * 1e6, 4) for length in law.lengths_m)
        raise SurfaceError(
            f"no roughness left but rounding: got correlation lengths of {lengths_um} um"
            f" on {surface_um} um, allowed: up to about {rounded(longest)} um; enlarge the surface"
        )
    return heights


def spectral_density(shape: tuple[int, ...], spacing: float, law: HeightSpectrum) -> Array:
    """Return the spectral density of a law on the half plane of waves of a periodic grid.

    Its mean over all waves is 1 [-].
    """
    if isinstance(law, SelfAffineSpectrum):
        density = self_affine(wave_numbers(shape, spacing), law)
        density[0, 0] = 0.0
        return np.asarray(density * (shape[0] * shape[1] / (wave_counts(shape) * density).sum()))
    first, second = law.lengths_m
    angle = law.angle_rad
    x = spacing * _periodic_lags(shape[0])
    y = spacing * _periodic_lags(shape[1])

    def autocorrelation(x: Array, y: Array) -> Array:
        """Return the autocorrelation at lags along and across [m]."""
        along, across = turned(x[:, None], y, angle)
        r2 = (along / first) ** 2 + (across / second) ** 2
        return np.asarray(np.exp(-law.decay * r2 ** (law.exponent / 2)))

    periodic = autocorrelation(x, y)
    if angle:
        ends = turned_reach(law, spacing)
        # The law is added about the neighbouring origins of the grid. Without them a turned law,
        # which is no function of the magnitudes of both lags, would have a step where a period
        # ends, and the surface a roughness in short waves.
        sizes = spacing * np.array(shape)
        counts = np.maximum(np.ceil(ends / sizes - 0.5), 0).astype(int)
        for i in range(-counts[0], counts[0] + 1):
            along = x + i * sizes[0]
            rows = np.flatnonzero(np.abs(along) <= ends[0])
            for j in range(-counts[1], counts[1] + 1):
                if i == 0 and j == 0:
                    continue
                across = y + j * sizes[1]
                periodic[rows] += autocorrelation(along[rows], across)
    # On a periodic grid the law can have slightly negative spectral densities from rounding.
    density = np.maximum(np.fft.rfft2(periodic).real, 0.0)
    if angle:
        return np.asarray(density / periodic[0, 0])
    return np.asarray(density)


def turned_reach(law: CorrelationLaw, spacing: float) -> Array:
    """Return how far [m] a turned autocorrelation reaches along and across.

    Raises
    ------
    SurfaceError
        The reach has too many nodes of the spacing [m].
    """
    first, second = law.lengths_m
    reach = (-np.log(_NEGLIGIBLE) / law.decay) ** (1 / law.exponent)
    cosine = np.cos(law.angle_rad)
    sine = np.sin(law.angle_rad)
    ends = reach * np.hypot([first * cosine, first * sine], [second * sine, second * cosine])
    if 4 * ends[0] * ends[1] > _MAX_LAGS * spacing**2:
        longest = math.sqrt(_MAX_LAGS / (4 * ends[0] * ends[1])) * spacing
        raise SurfaceError(
            "lay_deg: got correlation lengths that reach too far to be turned, allowed: up to"
            f" {rounded(longest, 2)} times as long"
        )
    return np.asarray(ends)


def _periodic_lags(nodes: int) -> Array:
    """Return the lags [nodes] of a periodic axis, those beyond half a period as negative ones."""
    return np.asarray((np.arange(nodes) + nodes // 2) % nodes - nodes // 2, float)


def self_affine(wave_number: Array, law: SelfAffineSpectrum) -> Array:
    """Return a self-affine spectrum over its plateau at wave numbers [rad/m]."""
    ratio = wave_number / law.rolloff_rad_m
    falling = np.maximum(ratio, 1.0) ** (-2 * (1 + law.hurst))
    # Rounding must not take the shortest wave itself away.
    return np.where(ratio <= law.end_ratio * (1 + 1e-9), falling, 0.0)


def wave_counts(shape: tuple[int, ...]) -> Array:
    """Return how many waves of the plane each column of the half plane stands for, 1 or 2."""
    counts = np.full(shape[1] // 2 + 1, 2.0)
    counts[0] = 1.0
    if shape[1] % 2 == 0:
        counts[-1] = 1.0
    return counts


def wave_numbers(shape: tuple[int, ...], spacing: float) -> Array:
    """Return the wave numbers [rad/m] of the half plane of waves of a periodic grid."""
    along = np.fft.fftfreq(shape[0], spacing)
    across = np.fft.rfftfreq(shape[1], spacing)
    return np.asarray(2 * np.pi * np.hypot(along[:, None], across))


def turned(x: Any, y: Any, angle: float) -> tuple[Any, Any]:
    """Return coordinates in axes that are turned by an angle [rad] from x to y."""
    if not angle:
        return x, y
    return np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x


def statistics(heights: Array, spacing: float) -> Statistics:
    """Compute roughness statistics of periodic heights (m, n) [m].

    The rms slope is the norm of the gradient over one spacing.
    """
    values = roughness(heights, spacing, wrap=True)
    is_rough = values["Sq"] > 0
    return Statistics(
        ra=values["Sa"],
        rq=values["Sq"],
        skewness=values["Ssk"] if is_rough else 0.0,
        kurtosis=values["Sku"] if is_rough else 0.0,
        rms_slope=values["Sdq"],
        highest=values["Sp"],
        lowest=0.0 - values["Sv"],
    )


def moments(heights: Array, weights: Array | None = None) -> Array:
    """Return skewness and kurtosis of heights, each node counting by its weight."""
    z = heights - np.average(heights, weights=weights)
    square = z * z
    variance = np.average(square, weights=weights)
    third = np.average(square * z, weights=weights)
    fourth = np.average(square * square, weights=weights)
    return np.array([third / variance**1.5, fourth / variance**2])


def correlation(heights: Array, spacing: float, axis: int) -> Correlation:
    """Estimate the correlation of periodic heights (m, n) [m] along one axis.

    The estimate is the mean over all lines. The length is interpolated between nodes. White noise
    falls to 1/e at 0.63 of a node, the minimum on a grid. The noise is the difference at lag 0
    between the autocorrelation and a straight line through lags 1 and 2; a smooth surface has none.
    """
    z = heights - heights.mean()
    n = z.shape[axis]
    power = np.mean(np.abs(np.fft.rfft(z, axis=axis)) ** 2, axis=1 - axis)
    covariance = np.fft.irfft(power, n)[: n // 2 + 1]
    if not covariance[0] > 0:
        return Correlation(length=np.inf, noise=0.0)
    share = covariance / covariance[0]
    noise = float(np.clip(1 - (2 * share[1] - share[2]), 0.0, 1.0))
    below = np.flatnonzero(share < np.exp(-1))
    if not len(below):
        return Correlation(length=np.inf, noise=noise)
    k = int(below[0])
    length = k - 1 + (share[k - 1] - np.exp(-1)) / (share[k - 1] - share[k])
    return Correlation(length=float(length) * spacing, noise=noise)
