"""Roughness over wavelength: of the surface, and as the contact under its load passes it on.

The approach under a constant load is the surface as the contact averages it. Its spectrum less the
spectrum of the surface is the contact filter of wheel and rail.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array

REFERENCE_M = 1e-6
_HALF_BAND = 10**0.05  # from the middle of a third octave to its edges


@dataclass(frozen=True, eq=False)
class WavelengthBands:
    """Third octaves over wavelength.

    Attributes
    ----------
    wavelength : (bands,) array, m
        Middle of each band, descending.
    mean_square : (bands,) array, m2
        Mean square of the heights in each band; NaN for a band without a line.
    """

    wavelength: Array
    mean_square: Array

    @property
    def level_db(self) -> Array:
        """Level [dB re 1 um]; NaN for a band without a line or without roughness."""
        rough = np.where(self.mean_square > 0, self.mean_square, np.nan)
        return np.asarray(10 * np.log10(rough / REFERENCE_M**2))


def wavelength_bands(profiles: Array, spacing: float, closed: bool) -> WavelengthBands:
    """Return the third octaves of profiles along the track, as their mean.

    Parameters
    ----------
    profiles : (n,) or (n, lines) array, m
        Heights along the track, of one line or several.
    spacing : float, m
        Distance of the heights.
    closed : bool
        If true, the end leads to the beginning. Otherwise a straight line is removed, and the
        ends are faded.
    """
    heights = profiles.reshape(len(profiles), -1)
    count = len(heights)
    if not closed:
        t = np.linspace(-1.0, 1.0, count)[:, None]
        heights = heights - heights.mean(axis=0)
        heights = heights - t * (np.sum(t * heights, axis=0) / np.sum(t**2))
        heights = heights * np.hanning(count)[:, None] * np.sqrt(8 / 3)
    lines = np.abs(np.fft.rfft(heights, axis=0)) ** 2 / count**2
    lines[1 : (count + 1) // 2] *= 2
    wave_number = np.fft.rfftfreq(count, spacing)[1:]
    mean_square = lines[1:].mean(axis=1)
    first = np.round(10 * np.log10(wave_number[0]))
    last = np.floor(10 * np.log10(wave_number[-1] / _HALF_BAND))
    middle = 10 ** (np.arange(first, last + 1) / 10)
    edges = np.append(middle / _HALF_BAND, middle[-1] * _HALF_BAND)
    band = np.searchsorted(edges, wave_number, side="right") - 1
    inside = (band >= 0) & (band < len(middle))
    sums = np.bincount(band[inside], mean_square[inside], len(middle))
    counts = np.bincount(band[inside], minlength=len(middle))
    return WavelengthBands(1 / middle, np.where(counts > 0, sums, np.nan))
