"""Random heights of a law: the waves of its spectrum, its skewness and its kurtosis.

Heights that are not Gaussian are found by iteration between distribution and spectrum (IAAFT):
the heights take the values of the distribution in their order, and then the waves their amplitudes.
The spectrum comes last, so the waves have the amplitudes of the Gaussian surface of the same seed.
Two-parameter corrections then bring skewness and kurtosis to the requested values.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from acoustics.arrays import Array
from rolling.surface import heights as surface
from rolling.surface.height_law import (
    CorrelationLaw,
    HeightSpectrum,
    SelfAffineSpectrum,
    self_affine_integrals,
)
from rolling.surface.heights import moments, spectral_density

ROUNDS = 40  # maximum number
CORRECTIONS = 30  # maximum number
NEAR = 0.05  # difference of skewness and kurtosis that ends the rounds
EXACT = 1e-4  # difference of skewness and kurtosis that ends the corrections
MIN_SHARE = 1e-14  # of the mean square, below which an octave of a law is rounding
SMALL = 1e-4  # rms height of the steps that show how a correction changes the moments
LARGEST = 0.1  # maximum rms height of a correction, over the rms height
STALLED = 6  # corrections without gain that end them
# A law has detail below the spacing where the amplitude of its waves at the share END of the
# Nyquist frequency exceeds the share DETAIL of the amplitude of its longest wave.
END = 0.75
DETAIL = 0.01


def of_law(
    shape: tuple[int, int], spacing: float, law: HeightSpectrum, seed: int | Sequence[int]
) -> Array:
    """Generate periodic heights [m] of a law, whose Ra, Sq or Sdq is exact.

    Raises
    ------
    SurfaceError
        The filter leaves nothing.
    """
    heights = surface.filtered(np.random.default_rng(seed).standard_normal(shape), spacing, law)
    if not law.is_gaussian:
        skewness, kurtosis = law.moments
        heights = _with_moments(heights, skewness, kurtosis)
    heights *= scale(heights, spacing, law)
    return heights


def scale(heights: Array, spacing: float, law: HeightSpectrum) -> float:
    """Return the factor that gives heights the Ra, Sq or Sdq of a law."""
    if isinstance(law, SelfAffineSpectrum) and law.rdq is not None:
        gradients = _wave_squares(heights) * surface.wave_numbers(heights.shape, spacing) ** 2
        return law.rdq / float(np.sqrt(gradients.sum()))
    if law.ra_m is None:
        return law.rq_m / float(np.sqrt(np.mean(heights**2)))
    return law.ra_m / float(np.abs(heights).mean())


# ---- spectra


def plane_density(law: HeightSpectrum, along: Array, across: Array) -> Array:
    """Return the two-sided spectral density [m4] of a law over wave numbers [rad/m].

    Its integral over the plane of wave numbers is the mean square of the heights.
    """
    if isinstance(law, SelfAffineSpectrum):
        square, _ = self_affine_integrals(law.hurst, law.end_ratio)
        plateau = law.rq_m**2 / (2 * np.pi * law.rolloff_rad_m**2 * square)
        return plateau * surface.self_affine(np.hypot(along, across), law)
    first, second = [length * law.decay ** (-1 / law.exponent) for length in law.lengths_m]
    u, v = surface.turned(along, across, law.angle_rad)
    scaled = np.square(u * first) + np.square(v * second)
    if law.exponent == 2:
        return np.asarray(law.rq_m**2 * first * second * np.exp(-scaled / 4) / (4 * np.pi))
    return np.asarray(law.rq_m**2 * first * second / (2 * np.pi * (1 + scaled) ** 1.5))


def has_detail(spacing: float, law: HeightSpectrum) -> bool:
    """Return whether a law has heights that a grid of this spacing [m] cannot hold."""
    if not isinstance(law, CorrelationLaw):
        return False  # its shortest wave has four nodes
    # The Gaussian law has the spectrum exp(-(k L)^2 / (4 decay)), of whose root the tail counts.
    end = END * np.pi / spacing * min(law.lengths_m)
    return law.exponent < 2 or float(np.exp(-(end**2) / (8 * law.decay))) > DETAIL


def continued(
    heights: Array, spacing: float, laws: Sequence[HeightSpectrum], seed: Sequence[int]
) -> Array:
    """Continue heights [m], the sum of surfaces of some laws, to half the spacing [m].

    Waves that the grid holds stay, less the share that shorter waves folded onto them. The shorter
    waves up to the end of the finer grid are new and Gaussian, and the nodes are the centres of the
    quarters of cells.
    """
    rq = laws[0].rq_m

    def density(shape: tuple[int, ...], step: float) -> Array:
        """Return the spectral densities of the laws, added by their mean squares."""
        weighted = [(law.rq_m / rq) ** 2 * spectral_density(shape, step, law) for law in laws]
        return np.asarray(np.sum(weighted, axis=0))

    rows, columns = heights.shape
    shape = (2 * rows, 2 * columns)
    coarse = density(heights.shape, spacing)
    fine = density(shape, spacing / 2)
    lines = rq * np.sqrt(fine) * np.fft.rfft2(np.random.default_rng(seed).standard_normal(shape))
    # The waves strictly below the end of the grid; a quarter of a node lies between the centres.
    along = np.arange(-((rows - 1) // 2), (rows + 1) // 2)
    across = np.arange((columns + 1) // 2)
    held = np.ix_(along, across)
    turn_along = np.exp(-0.5j * np.pi * held[0] / rows)
    turn_across = np.exp(-0.5j * np.pi * held[1] / columns)
    # A wave of the coarse grid is a sum of four waves of the finer one at most.
    gain = 2 * np.sqrt(np.minimum(fine[held] / np.maximum(coarse[held], 1e-300), 4.0))
    lines[held] = np.fft.rfft2(heights)[held] * gain * turn_along * turn_across
    return np.asarray(np.fft.irfft2(lines, s=shape))


# ---- skewness and kurtosis


def _with_moments(heights: Array, skewness: float, kurtosis: float) -> Array:
    """Give heights other phases, so that they have a skewness and a kurtosis."""
    z: Array = heights / np.sqrt(np.mean(heights**2))
    amplitudes = np.abs(np.fft.rfft2(z))
    amplitudes[0, 0] = 0.0
    targets = johnson_heights(skewness, kurtosis, z.size)
    wanted = np.array([skewness, kurtosis])
    for _ in range(ROUNDS):
        ranked = np.empty(z.size)
        ranked[np.argsort(z, axis=None)] = targets
        z = _with_amplitudes(ranked.reshape(z.shape), amplitudes)
        if np.abs(wanted - moments(z)).max() < NEAR:
            break
    nearest = z
    least_error = np.inf
    without_gain = 0
    for _ in range(CORRECTIONS):
        missing = wanted - moments(z)
        error = float(np.abs(missing).max())
        without_gain += 1
        if error < least_error:
            nearest = z
            least_error = error
            without_gain = 0
        if least_error < EXACT or without_gain > STALLED:
            break
        z = _corrected(z, amplitudes, missing)
    return nearest


def _with_amplitudes(heights: Array, amplitudes: Array) -> Array:
    """Give the waves of heights other amplitudes and keep their phases."""
    lines = np.fft.rfft2(heights)
    size = np.abs(lines)
    lines *= amplitudes / np.where(size > 0, size, 1.0)
    return np.asarray(np.fft.irfft2(lines, s=heights.shape))


def _corrected(z: Array, amplitudes: Array, missing: Array) -> Array:
    """Add a square and a cube to heights by a step of Newton's method for their moments."""
    steps = [power - power.mean() for power in (z**2, z**3)]
    steps = [step / np.sqrt(np.mean(step**2)) for step in steps]
    moved = [moments(_with_amplitudes(z + SMALL * step, amplitudes)) for step in steps]
    slopes = (np.array(moved) - moments(z)).T / SMALL
    factors = np.linalg.lstsq(slopes, missing, rcond=1e-6)[0]
    factors *= min(1.0, LARGEST / max(float(np.abs(factors).max()), 1e-12))
    total: Array = z + factors[0] * steps[0] + factors[1] * steps[1]
    return _with_amplitudes(total, amplitudes)


# ---- report


def is_described(law: HeightSpectrum) -> bool:
    """Tell whether made heights are compared with their law."""
    return isinstance(law, SelfAffineSpectrum) or not law.is_gaussian


def described(heights: Array, spacing: float, law: HeightSpectrum) -> dict[str, Any]:
    """Compare made heights [m] with a law.

    Returned are skewness and kurtosis, the mean square of the heights in each octave of wavelength
    [um] over that of the law of the same rms height [dB], and its standard deviation by chance.
    """
    skewness, kurtosis = moments(heights)
    counts = surface.wave_counts(heights.shape)
    density = spectral_density(heights.shape, spacing, law)
    density[0, 0] = 0.0
    with np.errstate(divide="ignore"):
        nodes = 2 * np.pi / surface.wave_numbers(heights.shape, spacing) / spacing
    octave = np.floor(np.log2(np.where(np.isfinite(nodes), nodes, 1.0)) + 1e-9).astype(int).ravel()
    got = np.bincount(octave, _wave_squares(heights).ravel())
    wanted = np.bincount(octave, (counts * density).ravel())
    squares = np.bincount(octave, (counts * density**2).ravel())
    shares = wanted / wanted.sum()
    # A random wave has an exponentially distributed mean square; the sum of all varies as well.
    spread = 2 * squares / np.where(wanted > 0, wanted, 1.0) ** 2
    spread = spread * (1 - 2 * shares) + (spread * shares**2).sum()
    errors = dict[str, float]()
    chances = dict[str, float]()
    for k in np.flatnonzero(wanted > MIN_SHARE * wanted.sum()):
        shortest_um = 2.0**k * spacing * 1e6
        longest_um = 2.0 ** (k + 1) * spacing * 1e6
        name = f"{shortest_um:.6g} to {longest_um:.6g}"
        error = 10 * np.log10(max(got[k] / got.sum() / shares[k], 1e-30))
        errors[name] = round(float(error), 3)
        chances[name] = round(float(10 / np.log(10) * np.sqrt(spread[k])), 3)
    return {
        "skewness": float(skewness),
        "kurtosis": float(kurtosis),
        "spectrum_error_db": errors,
        "spectrum_chance_db": chances,
    }


def _wave_squares(heights: Array) -> Array:
    """Return the mean square [m2] that each wave of the half plane, counted twice, adds."""
    lines = np.abs(np.fft.rfft2(heights)) ** 2 * surface.wave_counts(heights.shape)
    lines[0, 0] = 0.0
    return np.asarray(lines / heights.size**2)


# ---- Johnson's system of distributions
#
# Bounded heights 1/(1 + exp(-v)) lie below the line of lognormal heights in the plane of skewness
# and kurtosis, unbounded heights sinh(v) above it, with v = b u + a and a Gaussian u. Together they
# have every kurtosis above the square of the skewness plus 1.


REACH = 9.0  # integrals over the Gaussian u go from -REACH to REACH
POINTS = 801  # of these integrals
STEEPEST = 128.0  # maximum of b
FLATTEST = 1e-4  # minimum of b, where heights are Gaussian
FARTHEST = 512.0  # maximum of a

Shape = Callable[[Array], Array]


def johnson_heights(skewness: float, kurtosis: float, count: int) -> Array:
    """Return ascending heights of mean 0 and mean square 1 with a skewness and a kurtosis.

    They are quantiles at equal steps of probability. Where the count is too small for the kurtosis,
    they come as near as the system allows.
    """
    from scipy.special import ndtri  # slow to import

    quantiles = ndtri((np.arange(count) + 0.5) / count)
    u = np.linspace(-REACH, REACH, POINTS)
    weights = np.exp(-(u**2) / 2) / np.exp(-(u**2) / 2).sum()
    u = np.clip(u, quantiles[0], quantiles[-1])
    shape, slope, offset = _fitted(abs(skewness), kurtosis, u, weights)
    heights = shape(slope * quantiles + offset)
    if skewness < 0:
        heights = -heights[::-1]
    heights -= heights.mean()
    return np.asarray(heights / np.sqrt(np.mean(heights**2)))


def _fitted(
    skewness: float, kurtosis: float, u: Array, weights: Array
) -> tuple[Shape, float, float]:
    """Return shape, b and a of the heights of a skewness >= 0 and a kurtosis."""

    def lognormal_moments(slope: float) -> Array:
        return moments(np.exp(slope * (u - u[-1])), weights)

    def lognormal_excess_skewness(slope: float) -> float:
        return float(lognormal_moments(slope)[0]) - skewness

    # The slope of the lognormal heights of this skewness is the least of both shapes.
    least_slope = _root(lognormal_excess_skewness, FLATTEST, STEEPEST)
    shape: Shape
    if kurtosis > lognormal_moments(least_slope)[1]:
        shape = _unbounded
        sign = 1
    else:
        shape = _bounded
        sign = -1

    def fitted_offset(slope: float) -> float:
        """Return the a that gives heights of a slope b their skewness."""

        def excess_skewness(a: float) -> float:
            return float(moments(shape(slope * u + sign * a), weights)[0]) - skewness

        return sign * _root(excess_skewness, 0.0, FARTHEST)

    def excess_kurtosis(slope: float) -> float:
        heights = shape(slope * u + fitted_offset(slope))
        return sign * float(moments(heights, weights)[1] - kurtosis)

    slope = _root(excess_kurtosis, least_slope * (1 + 1e-6), STEEPEST)
    return shape, slope, fitted_offset(slope)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the root of a rising function between two ends, or the end that is nearest to it."""
    from scipy.optimize import brentq  # slow to import

    if function(low) >= 0:
        return low
    if function(high) <= 0:
        return high
    return float(brentq(function, low, high, xtol=1e-10))


def _unbounded(v: Array) -> Array:
    """Return sinh(v) over its maximum, free of overflow."""
    highest = np.abs(v).max()
    return np.asarray(np.exp(v - highest) - np.exp(-v - highest))


def _bounded(v: Array) -> Array:
    """Return 1/(1 + exp(-v)) over its maximum."""
    from scipy.special import expit  # slow to import

    return np.asarray(expit(v) / expit(v.max()))
