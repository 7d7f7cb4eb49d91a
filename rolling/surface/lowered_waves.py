"""Waves along the track that are lowered, band by band, with the phases that they have.

The bands are third octaves of wavelength. Along the track a surface is a sum of waves, each with
its profile across. A wave keeps its profile and its place, and only becomes lower.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from acoustics.arrays import Array

PER_DECADE = 10  # third octaves
HALF_BAND = 10**0.05  # from the middle of a third octave to its edges
_PREFERRED = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)


def band_of(wavelength: ArrayLike) -> Array:
    """Return the numbers of the third octaves that hold wavelengths, 0 for that of 1."""
    return np.floor(PER_DECADE * np.log10(wavelength) + 0.5)


def nominal(wavelength: float) -> str:
    """Write the preferred number of the third octave of a wavelength: 31.5 for 31.62."""
    band = int(band_of(wavelength))
    return f"{_PREFERRED[band % PER_DECADE] * 10.0 ** (band // PER_DECADE):.4g}"


def lower_waves(heights: Array, spacing: float, lowered_db: Mapping[float, float]) -> None:
    """Lower the waves of one period of a surface, in place.

    Parameters
    ----------
    heights : (nodes along, nodes across) array, m
        Heights of one period.
    spacing : float, m
        Distance of the nodes.
    lowered_db : mapping of float to float
        By how much waves are lowered [dB], by the middle of their third octave [m].
    """
    if not lowered_db:
        return
    count = len(heights)
    waves = np.fft.rfft(heights, axis=0)
    wave_number = np.asarray(np.fft.rfftfreq(count, spacing)[1:], dtype=float)
    waves[1:] *= factors(wave_number, lowered_db)[:, None]
    heights[:] = np.fft.irfft(waves, count, axis=0)


def factors(wave_number: Array, lowered_db: Mapping[float, float]) -> Array:
    """Return the factors of amplitudes at wave numbers [1/m], above 0."""
    made = np.ones(len(wave_number))
    bands = band_of(1 / wave_number)
    for wavelength, db in lowered_db.items():
        made[bands == band_of(wavelength)] = 10 ** (-db / 20)
    return made


def waves_of_band(heights: Array, spacing: float, wavelength: float) -> Array:
    """Return the part of one period of heights [m] that the third octave of a wavelength [m] has.

    `heights` and the part are (nodes along, nodes across).
    """
    count = len(heights)
    waves = np.fft.rfft(heights, axis=0)
    wave_number = np.fft.rfftfreq(count, spacing)
    outside = np.ones(len(waves), dtype=bool)
    outside[1:] = band_of(1 / wave_number[1:]) != band_of(wavelength)
    waves[outside] = 0.0
    return np.asarray(np.fft.irfft(waves, count, axis=0))


def bands_of_track(length: float, spacing: float) -> Array:
    """Return the middles of the third octaves [m] that a period of a length [m] holds.

    The longest waves stand first. The shortest band lies above two spacings [m].
    """
    first = int(band_of(length))
    last = int(band_of(2 * spacing)) + 1
    return np.asarray(10.0 ** (np.arange(first, last - 1, -1) / PER_DECADE))
