"""Periodic surface heights: generation by spectral filtering, statistics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.scene.balls import Roughness
from rolling.surface.parameters import roughness

AUTOCORRELATIONS = {  # name: (decay, exponent) of exp(-decay * (r / L)^exponent)
    "gaussian": (1.0, 2),
    "gaussian_10pct": (2.3, 2),
    "exponential": (1.0, 1),
    "exponential_10pct": (2.3, 1),
}


class SurfaceError(ValueError):
    """Fault of heights and its place."""


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


def gaussian(
    shape: tuple[int, int],
    spacing: float,
    ra: float,
    correlation_length: tuple[float, float],
    autocorrelation: str,
    seed: int | Sequence[int],
) -> Array:
    """Generate periodic Gaussian heights [m] of exact Ra and zero mean.

    White noise is filtered with the square root of the spectrum.

    Parameters
    ----------
    shape : (int, int)
        Nodes along and across the track.
    spacing : float, m
        Node spacing.
    ra : float, m
        Arithmetic mean roughness.
    correlation_length : (float, float), m
        Correlation lengths along and across the track.
    autocorrelation : str
        Key of AUTOCORRELATIONS; its r / L is the norm of (x / L_along, y / L_across).
    seed : int or sequence of int
        Seed of numpy's default generator.

    Raises
    ------
    SurfaceError
        The filter leaves nothing, because a correlation length is far above the size of the
        surface.
    """
    heights = filtered(white_noise(shape, seed), spacing, correlation_length, autocorrelation)
    heights *= ra / np.abs(heights).mean()
    return heights


def of_law(
    shape: tuple[int, int], spacing: float, law: Roughness, seed: int | Sequence[int]
) -> Array:
    """Generate the heights [m] of a law, as `gaussian` does."""
    ra = law.roughness_ra_um * 1e-6
    return gaussian(shape, spacing, ra, law.lengths_m, law.autocorrelation, seed)


def white_noise(shape: tuple[int, int], seed: int | Sequence[int]) -> Array:
    """Generate white noise of unit variance from a seed."""
    return np.random.default_rng(seed).standard_normal(shape)


def filtered(
    noise: Array, spacing: float, correlation_length: tuple[float, float], autocorrelation: str
) -> Array:
    """Filter periodic white noise to heights of zero mean and a variance of about 1.

    Parameters as in `gaussian`.

    Raises
    ------
    SurfaceError
        The filter leaves nothing.
    """
    shape = noise.shape
    density, exponent = _density(shape, spacing, correlation_length, autocorrelation)
    heights: Array = np.fft.irfft2(np.fft.rfft2(noise) * np.sqrt(density), s=shape)
    heights -= heights.mean()
    # A surface much smaller than its correlation length is flat except for rounding errors, which
    # would pass for roughness if they were scaled up.
    if not np.abs(heights).mean() > 1e-6 * np.sqrt(density.max() / heights.size):
        sizes = " x ".join(rounded(n * spacing * 1e6, 4) for n in shape)
        # Of a law that falls with (r / L)^exponent the share of roughness falls with its root.
        longest = 0.1 * 1e12 ** (1 / exponent) * max(shape) * spacing * 1e6
        lengths = " and ".join(rounded(length * 1e6, 4) for length in correlation_length)
        raise SurfaceError(
            f"no roughness left but rounding: got correlation lengths of {lengths} um"
            f" on {sizes} um, allowed: up to about {rounded(longest)} um; enlarge the surface"
        )
    return heights


def _density(
    shape: tuple[int, int],
    spacing: float,
    correlation_length: tuple[float, float],
    autocorrelation: str,
) -> tuple[Array, int]:
    """Return the spectral density of a law on a periodic grid, and the exponent of the law."""
    decay, exponent = AUTOCORRELATIONS[autocorrelation]
    along, across = (
        np.minimum(np.arange(n), n - np.arange(n)) * spacing / length
        for n, length in zip(shape, correlation_length, strict=True)
    )
    r2 = along[:, None] ** 2 + across[None, :] ** 2
    # On a periodic grid the law can have slightly negative spectral densities from rounding.
    return np.maximum(np.fft.rfft2(np.exp(-decay * r2 ** (exponent / 2))).real, 0.0), exponent


# A law has detail below the spacing where the amplitude of its waves at this share of the Nyquist
# frequency exceeds this share of the amplitude of its longest wave.
END, DETAIL = 0.75, 0.01


def has_detail(
    spacing: float, correlation_length: tuple[float, float], autocorrelation: str
) -> bool:
    """Return whether a law has heights that a grid of this spacing [m] cannot hold."""
    decay, exponent = AUTOCORRELATIONS[autocorrelation]
    # The Gaussian law has the spectrum exp(-(k L)^2 / (4 decay)), of whose root the tail counts.
    end = END * np.pi / spacing * min(correlation_length)
    return exponent < 2 or float(np.exp(-(end**2) / (8 * decay))) > DETAIL


def continued(
    heights: Array,
    spacing: float,
    laws: Sequence[tuple[float, tuple[float, float], str]],
    seed: Sequence[int],
) -> Array:
    """Continue heights [m], the sum of surfaces of some laws, to half the spacing [m].

    A law is the rms height [m], the correlation lengths [m] and the key of AUTOCORRELATIONS.

    Waves that the grid holds stay, less the share that shorter waves folded onto them. The shorter
    waves up to the end of the finer grid are new, and the nodes are the centres of the quarters of
    cells.
    """
    shape = 2 * heights.shape[0], 2 * heights.shape[1]
    rq, pairs = laws[0][0], [(own, (lengths, name)) for own, lengths, name in laws]
    coarse, fine = (
        np.sum([(own / rq) ** 2 * _density(size, step, *law)[0] for own, law in pairs], axis=0)
        for size, step in ((heights.shape, spacing), (shape, spacing / 2))
    )
    lines = rq * np.sqrt(fine) * np.fft.rfft2(np.random.default_rng(seed).standard_normal(shape))
    # The waves strictly below the end of the grid; a quarter of a node lies between the centres.
    along, across = (np.arange(-((n - 1) // 2), (n + 1) // 2) for n in heights.shape)
    kept = np.ix_(along, across[across >= 0])
    turn = [np.exp(-0.5j * np.pi * waves / n) for waves, n in zip(kept, heights.shape, strict=True)]
    # A wave of the coarse grid is a sum of four waves of the finer one at most.
    gain = 2 * np.sqrt(np.minimum(fine[kept] / np.maximum(coarse[kept], 1e-300), 4.0))
    lines[kept] = np.fft.rfft2(heights)[kept] * gain * turn[0] * turn[1]
    return np.asarray(np.fft.irfft2(lines, s=shape))


def smooth(shape: tuple[int, int]) -> Array:
    """Make flat heights [m]."""
    return np.zeros(shape)


def statistics(heights: Array, spacing: float) -> Statistics:
    """Compute roughness statistics of periodic heights (m, n) [m].

    The rms slope is the norm of the gradient over one spacing.
    """
    values = roughness(heights, spacing, wrap=True)
    rough = values["Sq"] > 0
    return Statistics(
        ra=values["Sa"],
        rq=values["Sq"],
        skewness=values["Ssk"] if rough else 0.0,
        kurtosis=values["Sku"] if rough else 0.0,
        rms_slope=values["Sdq"],
        highest=values["Sp"],
        lowest=0.0 - values["Sv"],
    )


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
        return Correlation(np.inf, 0.0)
    share = covariance / covariance[0]
    noise = float(np.clip(1 - (2 * share[1] - share[2]), 0.0, 1.0))
    below = np.flatnonzero(share < np.exp(-1))
    if not len(below):
        return Correlation(np.inf, noise)
    k = int(below[0])
    length = k - 1 + (share[k - 1] - np.exp(-1)) / (share[k - 1] - share[k])
    return Correlation(float(length) * spacing, noise)
