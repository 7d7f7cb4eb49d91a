"""Levels of a sound pressure record: equivalent, greatest, in third octaves. Depends on the other numeric modules here.

What has no sound is None, never -inf.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from acoustics.bands import BAND_NAMES, EDGES_HZ, third_octave_mean_square
from acoustics.radiation import I_REF_W_M2, P_REF_PA, RHO_C
from acoustics.resampling import resample_closed
from acoustics.spectrum import line_spectrum
from acoustics.time_weighting import FAST_S, SLOW_S, a_weighted, maximum_mean_square
from acoustics.weighting import a_weighting_db

__all__ = ["I_REF_W_M2", "P_REF_PA", "RHO_C", "SoundLevels", "a_weighted_rms", "laeq_db", "level_db", "sound_levels"]

# What lies 200 dB below the record counts as rounding. Transforms leave -300 dB, or -200 dB of a fluctuation that is
# 1e-5 of its mean; hearing spans 130 dB, and no contact solve is better than 1e-10.
_ROUNDING = 1e-20

# Smaller mean squares are silence: their parts would be numbers of few digits, or none (1e-308 and below).
_SILENCE = 1e-280

_PEAK_OVERSAMPLING = 8


@dataclass(frozen=True)
class SoundLevels:
    """Levels of one record, dB re 20 uPa; None where there is no sound.

    laeq_db, level_db : LAeq and LZeq of the whole record. laf_max_db, las_max_db : LAFmax and LASmax, greatest A-weighted
    level with time weighting Fast and Slow. lz_peak_db : LZpeak, of the greatest |p| between and at the samples.
    The two dictionaries go by nominal mid frequency, "20" to "20000", and always hold all 31 bands.
    """

    laeq_db: float | None
    level_db: float | None
    laf_max_db: float | None
    las_max_db: float | None
    lz_peak_db: float | None
    third_octave_db: dict[str, float | None]
    third_octave_a_db: dict[str, float | None]


def level_db(mean_square: float, reference: float = P_REF_PA**2) -> float | None:
    """10 lg(mean square / reference) in dB, or None when there is no sound (<= 0).

    Serves intensities too, with their own reference ``I_REF_W_M2``.

    Raises
    ------
    ValueError
        If the mean square is not finite: a fault upstream must not pass as silence, nor as a level.
    """
    if not math.isfinite(mean_square):
        raise ValueError(f"the mean square is not a finite number ({mean_square})")
    return 10.0 * (math.log10(mean_square) - math.log10(reference)) if mean_square > 0.0 else None


def laeq_db(pressure_pa: np.ndarray, sample_rate_hz: float) -> float | None:
    """A-weighted equivalent level LAeq of the whole record in dB re 20 uPa, or None when there is no sound.

    Weighted in the frequency domain with the exact curve, so without a filter's settling time or error near Nyquist.

    Parameters
    ----------
    pressure_pa
        Sound pressure (n,), Pa; the record closes on itself or is faded.
    sample_rate_hz
        Sample rate, Hz.
    """
    return level_db(a_weighted_rms(pressure_pa, sample_rate_hz) ** 2)


def a_weighted_rms(pressure_pa: np.ndarray, sample_rate_hz: float) -> float:
    """A-weighted rms of the whole record, in the unit of the record; 0 where only rounding is left."""
    frequency_hz, mean_square = line_spectrum(pressure_pa, sample_rate_hz)
    return math.sqrt(_heard(_a_weighted(frequency_hz, mean_square).sum(), mean_square.sum()))


def peak_pressure(pressure_pa: np.ndarray) -> float:
    """Greatest |p| of a record in Pa, between its samples, too: 8-fold interpolation.

    What lies between those points can exceed them by 0.01 dB at 5 kHz and 0.15 dB at the top of the audible band (48 kHz).

    Parameters
    ----------
    pressure_pa
        Sound pressure (n,), Pa; the record closes on itself or is faded.
    """
    fine = resample_closed(pressure_pa, _PEAK_OVERSAMPLING * len(pressure_pa))
    return float(max(fine.max(), -fine.min()))


def sound_levels(
    pressure_pa: np.ndarray, sample_rate_hz: float, highest_hz: float = math.inf, closed: bool = True
) -> SoundLevels:
    """All levels of one record.

    ``level_db`` and ``laeq_db`` are over all lines of the record; each A-weighted third octave is weighted line by
    line, so the bands of a record limited to 20 Hz to 20 kHz add up to the two.

    Parameters
    ----------
    pressure_pa
        Sound pressure (n,), Pa; the record closes on itself or is faded.
    sample_rate_hz
        Sample rate, Hz.
    highest_hz
        Up to where the record carries information, e.g. the Nyquist frequency of the simulation it comes from. A band
        that reaches above it, or above the record's own Nyquist frequency, is None: it is not known, or only in part.
    closed
        The record closes on itself, and the time weightings read it as it loops; otherwise they start from silence.

    Returns
    -------
    Levels in dB re 20 uPa. A band is None, too, if it has no line power; what is below 1e-20 of the record's mean
    square (-200 dB) is rounding and counts as none.

    Raises
    ------
    ValueError
        As `acoustics.spectrum.check_record`, or if the mean square is not finite.
    """
    frequency_hz, mean_square = line_spectrum(pressure_pa, sample_rate_hz)
    weighted = _a_weighted(frequency_hz, mean_square)
    whole = float(mean_square.sum())
    if whole < _SILENCE:
        nothing = dict.fromkeys(BAND_NAMES)
        return SoundLevels(None, None, None, None, None, {**nothing}, {**nothing})
    known = EDGES_HZ[1:] <= min(highest_hz, sample_rate_hz / 2.0)

    def bands(line_mean_square: np.ndarray) -> dict[str, float | None]:
        band_mean_square = np.where(known, third_octave_mean_square(frequency_hz, line_mean_square), 0.0)
        return {name: level_db(_heard(value, whole)) for name, value in zip(BAND_NAMES, band_mean_square, strict=True)}

    a_weighted_pa = a_weighted(pressure_pa, sample_rate_hz)

    def a_maximum(time_constant_s: float) -> float | None:
        greatest = maximum_mean_square(a_weighted_pa, sample_rate_hz, time_constant_s, closed)
        return level_db(_heard(greatest, whole))

    return SoundLevels(
        laeq_db=level_db(_heard(weighted.sum(), whole)),
        level_db=level_db(whole),
        laf_max_db=a_maximum(FAST_S),
        las_max_db=a_maximum(SLOW_S),
        lz_peak_db=level_db(peak_pressure(pressure_pa) ** 2),
        third_octave_db=bands(mean_square),
        third_octave_a_db=bands(weighted),
    )


def _a_weighted(frequency_hz: np.ndarray, line_mean_square: np.ndarray) -> np.ndarray:
    return line_mean_square * 10.0 ** (a_weighting_db(frequency_hz) / 10.0)


def _heard(mean_square: float, whole: float) -> float:
    """The mean square of a part of a record, 0 if it is no more than the rounding of the whole."""
    return float(mean_square) if mean_square > _ROUNDING * whole else 0.0
