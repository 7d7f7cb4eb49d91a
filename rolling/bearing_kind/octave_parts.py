"""Parts of the ± of third octaves of what a ring shakes, from those of its velocity by band."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, MID_HZ
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.numbers.bearing_numbers import BandVelocities


def octave_parts(velocities: BandVelocities) -> dict[str, Array]:
    """Return parts of the ± of third octaves (31,) [dB], by source.

    They are the parts of the velocity in the band of ISO 15242 around them, those below and above
    the parts of the nearest one.
    """
    parts: dict[str, Array] = {}
    for band, velocity in velocities.by_band.items():
        is_inside = _is_of_band(band)
        for source, decibels in velocity.parts.items():
            parts.setdefault(source, np.zeros(len(BAND_NAMES)))[is_inside] = decibels
    return parts


def parts_of_total(parts: Mapping[str, Array], powers: Array) -> dict[str, float]:
    """Return parts of the ± of a total level [dB], from those of its third octaves (31,).

    They follow by the powers (31,) of the third octaves, because a wrong gain changes all third
    octaves of a band in the same sense. Without power there is no ±.
    """
    whole = float(powers.sum())
    if whole == 0:
        return dict.fromkeys(parts, 0.0)
    return {source: float(powers @ decibels) / whole for source, decibels in parts.items()}


def powers_of(levels_db: Mapping[str, float | None]) -> Array:
    """Return the powers of third octaves (31,) from their levels, 0 where one is unknown."""
    levels = [levels_db[name] for name in BAND_NAMES]
    return np.array([0.0 if level is None else 10 ** (level / 10) for level in levels])


def _is_of_band(band: str) -> NDArray[np.bool_]:
    """Tell which third octaves (31,) count with a band of ISO 15242."""
    first_hz, last_hz = VELOCITY_BANDS_HZ[band]
    if band == "low":
        first_hz = 0.0
    if band == "high":
        last_hz = math.inf
    return (first_hz <= MID_HZ) & (last_hz > MID_HZ)
