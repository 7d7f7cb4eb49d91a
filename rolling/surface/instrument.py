"""What the instrument of a measurement could not see: its cut-off, its noise, and the law below.

A stylus with a spherical tip traces the dilation of the surface by its ball, so that the waves
whose curvature exceeds that of the ball are lost. Sampling ends at two spacings. The noise of an
instrument is white, and where it lies above the surface the file shows noise instead of waves.
Above the longest of these wavelengths the spectrum is reliable. There a law is fitted to it, and
below it the law can take the place of what the file has.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array, short_repr
from acoustics.numbers import rounded, si
from rolling.surface.stylus import ALPHA

# A ball traces the waves that are longer than the wavelength down to which the rms curvature of the
# surface, times the radius of the ball, is CURVATURE. Scanning probes have the same criterion with
# the peak curvature and a constant of 1/2 (Sanner, Noehring, Thimons, Jacobs, Pastewka, Applied
# Surface Science Advances 7 (2022), 100190). Half of the coherence of the true and the traced
# surface is lost at 0.40 to 0.67: tests/benchmarks/instrument_study.py.
CURVATURE = 0.4
SAMPLES = 2.0  # sampling intervals of the shortest wave
BANDS_PER_OCTAVE = 4.0
MIN_LINES = 6  # of a band of the spectrum
FITTED_OCTAVES = 1.5  # above the cut-off, to which the law is fitted
FITTED_UP_TO = 0.75  # wave numbers of the fit over that of the cut-off, where a limit begins early
MIN_FITTED = 4  # bands of the fit
# Limits of the power of the wave number of a law over a plane: 2 + 2 H of a self-affine surface,
# whose Hurst exponent H lies between 0 and 1. A profile has one power less.
POWERS = 2.0, 4.0
# Power beyond which a spectrum falls faster than any self-affine one, and may have a Gaussian law.
# The bend at the roll-off of a self-affine surface looks Gaussian, too, but is less steep.
STEEP_POWER = 4.5
SECTORS = 8  # of the directions of waves
# Noise is recognized where the last octave of the spectrum is flatter than this power of the wave
# number, the surface stands out of it at long waves, and its law has fallen below it.
FLAT = 0.7
STANDS_OUT = 10.0  # spectrum of the longest waves over the plateau
LEAST_NOISE = 1e-5  # of Sq; a lower plateau is rounding
PASSED = 0.5  # of the amplitude at the nesting index of an S-filter
NOISY = 2.0  # spectrum over noise, below which the file shows noise


@dataclass(frozen=True, kw_only=True)
class InstrumentLimits:
    """Limits of an instrument at short waves; None where they are not known.

    tip_radius_m : float or None, m. Radius of the tip of a stylus.
    sampling_m : float or None, m. Distance of independent points.
    noise_m : float or None, m. Rms noise of a height.
    """

    tip_radius_m: float | None = None
    sampling_m: float | None = None
    noise_m: float | None = None


class WaveBands(NamedTuple):
    """Spectrum in bands of the wave number, averaged over the directions.

    wave_number : (bands,) array, 1/m. Geometric means of the edges.
    density : (bands,) array, m4 over a plane, m3 of a profile. Mean square per wave number.
    lines : (bands,) array. Number of lines.
    """

    wave_number: Array
    density: Array
    lines: NDArray[np.int64]


@dataclass(frozen=True)
class ShortLaw:
    """Law of the spectrum at short waves.

    is_gaussian : bool. If true, density = scale exp(-(k rate)^2), otherwise scale k^(-rate).
    log_scale : float. Natural logarithm of the scale.
    rate : float. Length [m] of a Gaussian law, power of a power law.
    """

    is_gaussian: bool
    log_scale: float
    rate: float

    def density(self, wave_number: Array) -> Array:
        """Return the density at wave numbers [1/m]."""
        if self.is_gaussian:
            exponent = -np.square(wave_number * self.rate)
        else:
            exponent = -self.rate * np.log(np.maximum(wave_number, 1e-300))
        return np.asarray(np.exp(np.minimum(self.log_scale + exponent, 600.0)))

    @property
    def words(self) -> str:
        """The law in words."""
        if self.is_gaussian:
            return "a Gaussian law"
        return f"the power {-self.rate:.1f} of the wave number"


@dataclass(frozen=True, eq=False)
class InstrumentSight:
    """What an instrument sees of a surface.

    cutoff : float, m. Wavelength below which the heights are not known.
    limit : str. What sets it: "tip", "sampling" or "noise".
    tip_cutoff, sampling_cutoff, noise_cutoff : float, m. Wavelengths of the limits; 0: none.
    law : ShortLaw or None. Law below the cut-off; None where the spectrum is too short for a fit.
    directions : (sectors,) array. Density by direction over its mean, near the cut-off.
    noise : float, m. Rms of the noise in the heights; 0: none.
    noise_is_recognized : bool. If true, the spectrum shows the noise; otherwise the scene states
        it.
    noise_share : float. Noise over Sq.
    noise_density : float. Density of the noise.
    is_ridged : bool. Whether the heights are constant across, as those of a profile are.
    s_filter : float, m. Nesting index of the S-filter that the heights have passed; 0: none.
    """

    __repr__ = short_repr

    cutoff: float
    limit: str
    tip_cutoff: float
    sampling_cutoff: float
    noise_cutoff: float
    law: ShortLaw | None
    directions: Array
    noise: float
    noise_is_recognized: bool
    noise_share: float
    noise_density: float
    is_ridged: bool
    s_filter: float = 0.0

    @property
    def limit_words(self) -> str:
        """The limit that sets the cut-off, in words."""
        if self.limit == "tip":
            return "the tip traces no shorter ones"
        if self.limit == "noise":
            return "shorter ones are lost in noise"
        return "two sampling intervals"

    @property
    def noise_words(self) -> str:
        """The noise in words; empty without noise."""
        if not self.noise:
            return ""
        share = f"{rounded(100 * self.noise_share)} % of Sq"
        origin = "seen in the spectrum" if self.noise_is_recognized else "as the scene states"
        return f"noise {si(self.noise, 'm')} rms, {share}, {origin}"

    @property
    def words(self) -> str:
        """What the instrument sees, in words."""
        text = f"waves longer than {si(self.cutoff, 'm')} ({self.limit_words})"
        if self.noise:
            text += f"; {self.noise_words}"
        if self.law is not None:
            text += f"; below, the spectrum would go on with {self.law.words}"
        return text


def sight(
    heights: Array, spacing: float, instrument: InstrumentLimits | None, file_spacing: float = 0.0
) -> InstrumentSight:
    """Find what an instrument sees of heights.

    Parameters
    ----------
    heights : (along, across) array, m
        One period of the measured surface.
    spacing : float, m
        Distance of its nodes.
    instrument : InstrumentLimits or None
        Tip radius, sampling and noise. None: only the noise is looked for.
    file_spacing : float, m
        Distance of the points of the file, where they were resampled.
    """
    ridged = is_ridged(heights)
    z = heights[:, :1] if ridged else heights
    z = z - z.mean()
    lines = _line_squares(z)
    along, across = _wave_numbers(z.shape, spacing)
    wave = np.hypot(along, across)
    area = _area(z.shape, spacing, ridged)
    bands = _bands(wave, lines * area, 0.5 / spacing)
    rms = float(np.sqrt(np.mean(z**2)))
    sampling = SAMPLES * max(spacing, file_spacing)
    limits = instrument or InstrumentLimits()
    if limits.sampling_m is not None:
        sampling = max(sampling, SAMPLES * limits.sampling_m)
    tip = 0.0
    if limits.tip_radius_m is not None:
        tip = _tip_cutoff(along, across, wave, lines, limits.tip_radius_m)
    seen = max(tip, sampling)
    cell = spacing if ridged else spacing**2
    noise_density = _plateau(bands, seen if sampling > 2.01 * spacing else 0.0)
    if noise_density < (LEAST_NOISE * rms) ** 2 * cell:
        noise_density = 0.0
    recognized = noise_density > 0
    if limits.noise_m is not None:
        noise_density = limits.noise_m**2 * cell
        recognized = False
    noise_cutoff = _noise_cutoff(bands, noise_density)
    cutoff = max(seen, noise_cutoff)
    limit = "sampling"
    if cutoff == tip:
        limit = "tip"
    if cutoff == noise_cutoff:
        limit = "noise"
    noise = math.sqrt(noise_density / cell)
    return InstrumentSight(
        cutoff=cutoff,
        limit=limit,
        tip_cutoff=tip,
        sampling_cutoff=sampling,
        noise_cutoff=noise_cutoff,
        law=_fitted(bands, noise_density, FITTED_UP_TO / cutoff, ridged),
        directions=_directions(along, across, wave, lines, 1 / cutoff),
        noise=noise,
        noise_is_recognized=recognized,
        noise_share=noise / rms if rms > 0 else 0.0,
        noise_density=noise_density,
        is_ridged=ridged,
    )


def is_ridged(heights: Array) -> bool:
    """Return whether heights are constant across the track, as those of a profile are."""
    return bool(np.all(heights == heights[:, :1]))


def with_law(heights: Array, spacing: float, seen: InstrumentSight, seed: Sequence[int]) -> Array:
    """Replace the waves below the cut-off by random waves of the law, and remove the noise.

    The S-filter is taken back from the waves above, to what it passed at its index at least.

    Parameters
    ----------
    heights : (along, across) array, m
        Measured heights, or a patch of them.
    spacing : float, m
        Distance of the nodes.
    seen : InstrumentSight
        Cut-off, law and noise.
    seed : sequence of int
        Seed of the random waves.
    """
    z = heights[:, :1] if seen.is_ridged else heights
    mean = z.mean()
    old = np.fft.rfft2(z - mean)
    along, across = _wave_numbers(z.shape, spacing)
    across = across[:, : old.shape[1]]
    wave = np.hypot(along, across)
    lost = wave > 1 / seen.cutoff
    if seen.s_filter:
        gains = [np.exp(-np.pi * (ALPHA * seen.s_filter * part) ** 2) for part in (along, across)]
        old = old / np.maximum(gains[0] * gains[1], PASSED)
    lines = np.zeros_like(old)
    if seen.law is not None:
        white = np.fft.rfft2(np.random.default_rng(seed).standard_normal(z.shape))
        density = np.where(lost, seen.law.density(np.where(lost, wave, 1 / seen.cutoff)), 0.0)
        if not seen.is_ridged:
            density = density * seen.directions[_sector(along, across)]
        cell = spacing if seen.is_ridged else spacing**2
        lines = white * np.sqrt(density / cell)
    new = np.fft.irfft2(np.where(lost, lines, old), s=z.shape) + mean
    return np.asarray(np.broadcast_to(new, heights.shape)) if seen.is_ridged else np.asarray(new)


def faded(heights: Array) -> Array:
    """Return heights that do not close [m], less their mean, and faded at all four edges.

    The window of Hann keeps the mean square of random heights. Unmeasured nodes, NaN, count as the
    mean.
    """
    z = np.nan_to_num(heights - np.nanmean(heights))
    for axis in (0, 1):
        count = z.shape[axis]
        if count > 1:
            window = np.sqrt(8 / 3) * np.hanning(count + 2)[1:-1]
            z = z * (window[:, None] if axis == 0 else window)
    return np.asarray(z)


# ---- spectrum


def _line_squares(z: Array) -> Array:
    """Return the mean square [m2] of each line of the plane of wave numbers."""
    return np.asarray(np.square(np.abs(np.fft.fft2(z))) / z.size**2)


def _wave_numbers(shape: tuple[int, ...], spacing: float) -> tuple[Array, Array]:
    """Return the wave numbers [1/m] along, a column, and across, a row."""
    along = np.fft.fftfreq(shape[0], spacing).astype(np.float64)
    across = np.fft.fftfreq(shape[1], spacing).astype(np.float64)
    return along[:, None], across[None]


def _area(shape: tuple[int, ...], spacing: float, ridged: bool) -> float:
    """Return the area [m2] of heights, the length [m] of a profile."""
    return shape[0] * spacing if ridged else shape[0] * shape[1] * spacing**2


def _bands(wave: Array, density: Array, highest: float) -> WaveBands:
    """Average a density over the lines of each band, up to a highest wave number [1/m]."""
    lowest = float(wave[wave > 0].min())
    count = max(1, math.ceil(BANDS_PER_OCTAVE * math.log2(highest / lowest)))
    edges = highest * np.exp2(np.arange(-count, 1) / BANDS_PER_OCTAVE)
    edges[-1] *= 1 + 1e-9
    band = np.searchsorted(edges, wave.ravel(), side="right") - 1
    inside = (band >= 0) & (band < count)
    lines = np.bincount(band[inside], minlength=count)
    sums = np.bincount(band[inside], density.ravel()[inside], count)
    filled = lines >= MIN_LINES
    middle = np.sqrt(edges[1:] * edges[:-1])
    return WaveBands(middle[filled], sums[filled] / lines[filled], lines[filled].astype(np.int64))


def _tip_cutoff(along: Array, across: Array, wave: Array, lines: Array, radius: float) -> float:
    """Return the wavelength [m] down to which a ball traces the waves; 0: it traces all."""
    order = np.argsort(wave, axis=None)
    steepest = np.zeros(wave.size)
    for component in (along, across):
        curvature = lines * np.broadcast_to(2 * np.pi * component, lines.shape) ** 4
        steepest = np.maximum(steepest, np.cumsum(curvature.ravel()[order]))
    lost = np.sqrt(steepest) * radius > CURVATURE
    if not lost.any():
        return 0.0
    return 1 / float(wave.ravel()[order][np.argmax(lost)])


def _plateau(bands: WaveBands, seen: float) -> float:
    """Return the density of white noise at short waves; 0 where the spectrum shows none."""
    if seen:  # waves below the sampling of the file hold what resampling made of them
        kept = bands.wave_number <= 1 / seen
        bands = WaveBands(bands.wave_number[kept], bands.density[kept], bands.lines[kept])
    if len(bands.density) < 3 * BANDS_PER_OCTAVE or not bands.density.min() > 0:
        return 0.0
    octave = int(BANDS_PER_OCTAVE)
    last = slice(-octave, None)
    slope = np.polyfit(np.log(bands.wave_number[last]), np.log(bands.density[last]), 1)[0]
    plateau = float(bands.density[-octave // 2 :].mean())
    if abs(slope) > FLAT or bands.density.max() < STANDS_OUT * plateau:
        return 0.0
    return plateau


def _noise_cutoff(bands: WaveBands, noise_density: float) -> float:
    """Return the wavelength [m] below which the spectrum is noise; 0 where it is not."""
    if not noise_density > 0:
        return 0.0
    above = np.flatnonzero(bands.density > NOISY * noise_density)
    if not len(above):
        return 1 / float(bands.wave_number[0])
    last = int(above[-1])
    if last + 1 == len(bands.density):
        return 0.0
    return 1 / math.sqrt(float(bands.wave_number[last] * bands.wave_number[last + 1]))


def _fitted(bands: WaveBands, noise_density: float, end: float, ridged: bool) -> ShortLaw | None:
    """Fit a power law and a Gaussian law below a wave number [1/m], and return the better one."""
    density = bands.density - noise_density
    known = (bands.wave_number < end) & (density > 0)
    near = known & (bands.wave_number > end * 2**-FITTED_OCTAVES)
    if near.sum() < MIN_FITTED:
        near = known & (np.cumsum(known[::-1])[::-1] <= MIN_FITTED)
    if near.sum() < 2:
        return None
    wave = bands.wave_number[near]
    logs = np.log(density[near])
    weights = np.sqrt(bands.lines[near])
    of_profile = 1.0 if ridged else 0.0
    power, scale = np.polyfit(-np.log(wave), logs, 1, w=weights)
    of_power = _errors(logs - scale + power * np.log(wave), weights)
    rate, log_scale = np.polyfit(-np.square(wave), logs, 1, w=weights)
    of_gauss = _errors(logs - log_scale + rate * np.square(wave), weights)
    if power > STEEP_POWER - of_profile and of_gauss < of_power:
        return ShortLaw(is_gaussian=True, log_scale=float(log_scale), rate=math.sqrt(rate))
    least, most = POWERS
    power = float(np.clip(power, least - of_profile, most - of_profile))
    scale = float(np.average(logs + power * np.log(wave), weights=weights**2))
    return ShortLaw(is_gaussian=False, log_scale=scale, rate=power)


def _errors(residuals: Array, weights: Array) -> float:
    """Return the weighted mean square of residuals."""
    return float(np.average(residuals**2, weights=weights**2))


def _sector(along: Array, across: Array) -> Array:
    """Return the sector of the direction of each wave."""
    angle = np.mod(np.arctan2(across, along), np.pi)
    return np.asarray(np.minimum((angle * (SECTORS / np.pi)).astype(int), SECTORS - 1))


def _directions(along: Array, across: Array, wave: Array, lines: Array, end: float) -> Array:
    """Return the density by sector over its mean, in the octave below a wave number [1/m]."""
    near = (wave > end / 2) & (wave <= end)
    sector = _sector(along, across)[near]
    counts = np.bincount(sector, minlength=SECTORS)
    sums = np.bincount(sector, lines[near], SECTORS)
    if not (counts > 0).all() or not sums.sum() > 0:
        return np.ones(SECTORS)
    means = sums / counts
    return np.asarray(means / means.mean())
