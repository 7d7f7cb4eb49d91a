"""Loudness and sharpness of a sound by the package mosqito, which is imported on use.

A steady sound has one loudness. The loudness of another sound changes in time; N5, which it exceeds
for 5 % of the time, is what listeners judge it by (Zwicker and Fastl).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acoustics import loudness_steps
from acoustics.arrays import Array, refuse_masked
from acoustics.spectrum import checked_record

MIN_RATE_HZ = 48000  # mosqito would resample lower rates

# The filters of the lowest bands (25 Hz, 5.8 Hz wide) settle in 0.2 s; a loop is played long enough
# to make that negligible.
_PLAYED_S = 4.0

# ISO 532-1:2017, method 2, is defined at this rate.
VARYING_RATE_HZ = 48000
# [s] for which a loop is played for its loudness in time. The second half is judged, in which the
# filters have settled.
_PLAYED_IN_TIME_S = 1.0
# [s] of silence after an open record, in which the loudness of its end rises and fades.
_AFTER_S = 0.2
_FRAME_S = 0.002  # of mosqito's loudness in time
_FINE_FRAMES = 4  # of 0.5 ms, in which mosqito computes
_N5_SHARE = 0.05  # of the time


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
    ValueError
        As `acoustics.spectrum.checked_record`, or for a sample rate below 48 kHz.

    References
    ----------
    ISO 532-1:2017, method 1, for stationary sounds; DIN 45692:2009 for sharpness.
    """
    fluctuation = heard_fluctuation(pressure_pa, sample_rate_hz)
    from mosqito.sq_metrics import loudness_zwst, sharpness_din_from_loudness

    if not np.any(fluctuation):
        return Loudness(0.0, None)
    rounds = 1
    if closed:
        rounds = math.ceil(_PLAYED_S * sample_rate_hz / len(fluctuation))
    try:
        played = np.tile(fluctuation, rounds)
        sone, specific, _ = loudness_zwst(played, sample_rate_hz, field_type="free")
    except ValueError:  # both cases raise this error
        return Loudness(None, None)
    if not sone > 0.0:
        return Loudness(0.0, None)
    acum = sharpness_din_from_loudness(sone, specific, weighting="din")
    return Loudness(float(sone), float(acum))


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
    ValueError
        As `acoustics.spectrum.checked_record`, or for another sample rate.

    References
    ----------
    ISO 532-1:2017, method 2, for time-varying sounds; H. Fastl and E. Zwicker, Psychoacoustics, 3rd
    ed., Springer 2007, 8.7, for N5.
    """
    fluctuation = heard_fluctuation(pressure_pa, sample_rate_hz)
    _check_varying_rate(sample_rate_hz)
    if not np.any(fluctuation):
        return VaryingLoudness(0.0, 0.0)
    duration = len(fluctuation) / sample_rate_hz
    if closed:
        rounds = max(2, math.ceil(_PLAYED_IN_TIME_S / duration))
        played = np.tile(fluctuation, rounds)
        before = rounds // 2
        first_s = before * duration
        judged_s = (rounds - before) * duration
    else:
        played = np.append(fluctuation, np.zeros(round(_AFTER_S * sample_rate_hz)))
        first_s = 0.0
        judged_s = duration
    courses = loudness_in_time([played], sample_rate_hz)
    if courses is None:
        return VaryingLoudness(None, None)
    sone = courses[0]
    return VaryingLoudness(
        n5_sone=n5_sone(sone, first_s, judged_s),
        max_sone=float(np.max(sone[round(first_s / _FRAME_S) :])),
    )


def n5_sone(sone: Array, first_s: float, judged_s: float) -> float:
    """Return N5 of a course of loudness in time [sone].

    The loudest frames are counted until they last for 5 % of `judged_s`. The ear is slow, so some
    of them may lie after a short record.

    Parameters
    ----------
    sone : array (frames,), sone. Loudness, from `loudness_in_time`.
    first_s : float, s. Start of the part that is judged.
    judged_s : float, s. Duration of the sound.
    """
    loudest = np.sort(sone[round(first_s / _FRAME_S) :])[::-1]
    return float(loudest[int(_N5_SHARE * judged_s / _FRAME_S)])


def loudness_in_time(records: Sequence[Array], sample_rate_hz: float) -> list[Array] | None:
    """Return the loudness of records in frames of 2 ms [sone].

    Parameters
    ----------
    records : sequence of arrays (n,), Pa. Sound pressures, without a mean.
    sample_rate_hz : float, Hz. Sample rate, 48 kHz.

    Returns
    -------
    list of arrays (frames,), sone
        None if a third octave up to 250 Hz exceeds 120 dB, where the method does not hold.

    Raises
    ------
    ValueError
        For another sample rate.

    References
    ----------
    ISO 532-1:2017, method 2.
    """
    import_mosqito()
    _check_varying_rate(sample_rate_hz)
    try:
        return [_course(record) for record in records]
    except ValueError:  # a third octave is too loud
        return None


def _course(record: Array) -> Array:
    """Return the loudness in time of a record [sone], by the steps of mosqito's `loudness_zwtv`.

    Decay and slopes are our own, which have the same digits in a hundredth of the time. A release
    of mosqito that has its steps elsewhere computes all of it.
    """
    from mosqito.sq_metrics import loudness_zwtv

    try:
        from mosqito.sq_metrics.loudness.loudness_zwst._main_loudness import _main_loudness
        from mosqito.sq_metrics.loudness.loudness_zwtv._temporal_weighting import (
            _temporal_weighting,
        )
        from mosqito.sq_metrics.loudness.loudness_zwtv._third_octave_levels import (
            _third_octave_levels,
        )
    except ImportError:
        return np.asarray(loudness_zwtv(record, VARYING_RATE_HZ, field_type="free")[0])
    third_octaves_db = _third_octave_levels(record, VARYING_RATE_HZ)[0]
    core = _main_loudness(third_octaves_db, "free")
    total = loudness_steps.total(loudness_steps.decayed(core))
    return np.asarray(_temporal_weighting(total)[::_FINE_FRAMES])


def heard_fluctuation(pressure_pa: Array, sample_rate_hz: float) -> Array:
    """Return a record without its mean, whose onset the ear's filters would hear as a bang.

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`, or for a sample rate below 48 kHz.
    """
    refuse_masked("pressure_pa", pressure_pa)
    record = checked_record(pressure_pa, sample_rate_hz, "pressure_pa")
    import_mosqito()
    if sample_rate_hz < MIN_RATE_HZ:
        raise ValueError(
            f"sample_rate_hz: got {sample_rate_hz:g}, allowed: a sample rate of {MIN_RATE_HZ} Hz"
            " or more, by which mosqito computes"
        )
    return np.asarray(record - np.mean(record))


def import_mosqito() -> None:
    """Import mosqito, which takes a second and is needed by few."""
    from acoustics import matplotlib_import

    matplotlib_import.ensure()  # because mosqito imports matplotlib
    import mosqito.sq_metrics  # noqa: F401


def _check_varying_rate(sample_rate_hz: float) -> None:
    """Raise ValueError for a sample rate for which method 2 is not defined."""
    if sample_rate_hz != VARYING_RATE_HZ:
        raise ValueError(
            f"sample_rate_hz: got {sample_rate_hz:g}, allowed for loudness in time: a sample rate"
            f" of {VARYING_RATE_HZ} Hz"
        )
