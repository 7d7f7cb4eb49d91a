"""Loudness and sharpness of a sound by the package mosqito, which is imported on use.

A steady sound has one loudness. The loudness of another sound changes in time; N5, which it exceeds
for 5 % of the time, is what listeners judge it by (Zwicker and Fastl).
"""

import math
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array, refuse_masked
from acoustics.spectrum import checked_record
from acoustics.traps import ignoring_underflow

MIN_RATE_HZ = 48000  # mosqito would resample lower rates

# The filters of the lowest bands (25 Hz, 5.8 Hz wide) settle in 0.2 s; a loop is played long enough
# to make that negligible.
_PLAYED_S = 4.0

# ISO 532-1:2017, method 2, is defined at this rate.
_VARYING_RATE_HZ = 48000
# [s] for which a loop is played for its loudness in time. The second half is judged, in which the
# filters have settled.
_PLAYED_IN_TIME_S = 1.0
# [s] of silence after an open record, in which the loudness of its end rises and fades.
_AFTER_S = 0.2
_FRAME_S = 0.002  # of mosqito's loudness in time
_N5_SHARE = 0.05  # of the time


@ignoring_underflow
@dataclass(frozen=True)
class Loudness:
    """Loudness and sharpness of a record.

    Both are None where the method does not hold: if a third octave up to 250 Hz exceeds 120 dB, or
    if a record of some milliseconds does not close.

    Parameters
    ----------
    sone : float or None, sone. Loudness; 0 for silence.
    acum : float or None, acum. Sharpness; None without loudness.
    """

    sone: float | None
    acum: float | None


@ignoring_underflow
def loudness(pressure_pa: Array, sample_rate_hz: float, closed: bool) -> Loudness:
    """Compute loudness and sharpness of a steady record with mosqito.

    The sound field at the listener is free, and the sound comes from the front to both ears.

    Parameters
    ----------
    pressure_pa : array (n,), Pa. Calibrated sound pressure.
    sample_rate_hz : float, Hz. Sample rate, at least 48 kHz.
    closed : bool. If true, the record is looped for at least 4 s. Otherwise it is read once; the
        lowest bands of a record shorter than about a second are then too low.

    Returns
    -------
    Loudness

    Raises
    ------
    ModuleNotFoundError
        If mosqito is not installed.
    ValueError
        As `acoustics.spectrum.checked_record`, or for a sample rate below 48 kHz.

    References
    ----------
    ISO 532-1:2017, method 1, for stationary sounds; DIN 45692:2009 for sharpness.
    """
    refuse_masked("pressure_pa", pressure_pa)
    from acoustics import matplotlib_import

    matplotlib_import.ensure()  # because mosqito imports matplotlib
    from mosqito.sq_metrics import loudness_zwst, sharpness_din_from_loudness

    record = checked_record(pressure_pa, sample_rate_hz)
    if sample_rate_hz < MIN_RATE_HZ:
        raise ValueError(
            f"loudness needs a sample rate of {MIN_RATE_HZ} Hz or more, got {sample_rate_hz:g}"
        )
    # the onset of a mean would excite the filters like a bang
    fluctuation = record - np.mean(record)
    if not np.any(fluctuation):
        return Loudness(0.0, None)
    rounds = math.ceil(_PLAYED_S * sample_rate_hz / len(record)) if closed else 1
    try:
        played = np.tile(fluctuation, rounds)
        sone, specific, _ = loudness_zwst(played, sample_rate_hz, field_type="free")
    except ValueError:  # both cases raise this error
        return Loudness(None, None)
    if not sone > 0.0:
        return Loudness(0.0, None)
    acum = sharpness_din_from_loudness(sone, specific, weighting="din")
    return Loudness(float(sone), float(acum))


@ignoring_underflow
@dataclass(frozen=True)
class VaryingLoudness:
    """Loudness of a record that changes in time.

    Both are None where the method does not hold: if a third octave up to 250 Hz exceeds 120 dB.

    Parameters
    ----------
    n5_sone : float or None, sone. N5, which is exceeded for 5 % of the duration of the record; 0
        for silence.
    max_sone : float or None, sone. Maximum. The ear is slow, so it may come after a short record.
    """

    n5_sone: float | None
    max_sone: float | None


@ignoring_underflow
def varying_loudness(pressure_pa: Array, sample_rate_hz: float, closed: bool) -> VaryingLoudness:
    """Compute the loudness of a record that changes in time with mosqito.

    The sound field at the listener is free, and the sound comes from the front to both ears.

    Parameters
    ----------
    pressure_pa : array (n,), Pa. Calibrated sound pressure.
    sample_rate_hz : float, Hz. Sample rate, 48 kHz.
    closed : bool. If true, the record is looped for at least 1 s, and the second half is judged.
        Otherwise it is read once, with silence before and after it.

    Returns
    -------
    VaryingLoudness

    Raises
    ------
    ModuleNotFoundError
        If mosqito is not installed.
    ValueError
        As `acoustics.spectrum.checked_record`, or for another sample rate.

    References
    ----------
    ISO 532-1:2017, method 2, for time-varying sounds; H. Fastl and E. Zwicker, Psychoacoustics, 3rd
    ed., Springer 2007, 8.7, for N5.
    """
    refuse_masked("pressure_pa", pressure_pa)
    from acoustics import matplotlib_import

    matplotlib_import.ensure()  # because mosqito imports matplotlib
    from mosqito.sq_metrics import loudness_zwtv

    record = checked_record(pressure_pa, sample_rate_hz)
    if sample_rate_hz != _VARYING_RATE_HZ:
        raise ValueError(
            f"loudness in time needs a sample rate of {_VARYING_RATE_HZ} Hz, got {sample_rate_hz:g}"
        )
    # the onset of a mean would be heard as a bang
    fluctuation = record - np.mean(record)
    if not np.any(fluctuation):
        return VaryingLoudness(0.0, 0.0)
    duration = len(record) / sample_rate_hz
    if closed:
        rounds = max(2, math.ceil(_PLAYED_IN_TIME_S / duration))
        played = np.tile(fluctuation, rounds)
        before = rounds // 2
        first = round(before * duration / _FRAME_S)
        judged_s = (rounds - before) * duration
    else:
        played = np.append(fluctuation, np.zeros(round(_AFTER_S * sample_rate_hz)))
        first = 0
        judged_s = duration
    try:
        sone = loudness_zwtv(played, int(sample_rate_hz), field_type="free")[0]
    except ValueError:  # a third octave is too loud
        return VaryingLoudness(None, None)
    # The loudest frames are counted until they last for 5 % of the record. The ear is slow, so some
    # of them may lie in the silence after a short record.
    loudest = np.sort(sone[first:])[::-1]
    return VaryingLoudness(
        n5_sone=float(loudest[int(_N5_SHARE * judged_s / _FRAME_S)]), max_sone=float(loudest[0])
    )
