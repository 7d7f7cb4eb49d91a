"""Loudness and sharpness of a steady sound by the package mosqito, which is imported on use."""

import math
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array
from acoustics.spectrum import checked_record

MIN_RATE_HZ = 48000  # mosqito would resample lower rates

# The filters of the lowest bands (25 Hz, 5.8 Hz wide) settle in 0.2 s; a loop is played long enough
# to make that negligible.
_PLAYED_S = 4.0


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
    ModuleNotFoundError
        If mosqito is not installed.
    ValueError
        As `acoustics.spectrum.checked_record`, or for a sample rate below 48 kHz.

    References
    ----------
    ISO 532-1:2017, method 1, for stationary sounds; DIN 45692:2009 for sharpness.
    """
    from mosqito.sq_metrics import loudness_zwst, sharpness_din_from_loudness

    record = checked_record(pressure_pa, sample_rate_hz)
    if sample_rate_hz < MIN_RATE_HZ:
        needed = f"a sample rate of {MIN_RATE_HZ} Hz or more"
        raise ValueError(f"loudness needs {needed}, got {sample_rate_hz:g}")
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
