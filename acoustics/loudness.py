"""Loudness and sharpness of a steady sound. Depends on the package mosqito, imported only when it is asked for."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from acoustics.spectrum import check_record

LEAST_RATE_HZ = 48000  # below, mosqito would resample

# The filters of the lowest bands (25 Hz, 5.8 Hz wide) take 0.2 s to swing in; a loop is played for as long as makes
# that no matter.
_PLAYED_S = 4.0


@dataclass(frozen=True)
class Loudness:
    """Loudness in sone, 0 for silence; sharpness in acum, None where there is no loudness.

    Both are None where the method does not hold: a third octave up to 250 Hz above 120 dB, or a record of some
    milliseconds that does not close.
    """

    sone: float | None
    acum: float | None


def loudness(pressure_pa: np.ndarray, sample_rate_hz: float, closed: bool) -> Loudness:
    """Loudness (ISO 532-1:2017, method 1, stationary) and sharpness (DIN 45692:2009) of a record, by mosqito.

    The sound field at the listener is taken to be free, the sound to come from the front, heard by both ears.

    Parameters
    ----------
    pressure_pa
        Sound pressure (n,), Pa: calibrated, the result hangs on its level.
    sample_rate_hz
        Sample rate, 48 kHz or more.
    closed
        The record closes on itself; it is looped for 4 s or more. Otherwise it is taken as it is,
        and of one shorter than about a second the lowest bands are read too low.

    Raises
    ------
    ModuleNotFoundError
        If mosqito is not installed.
    ValueError
        As `acoustics.spectrum.check_record`, or for a sample rate below 48 kHz.
    """
    from mosqito.sq_metrics import loudness_zwst, sharpness_din_from_loudness

    check_record(pressure_pa)
    if sample_rate_hz < LEAST_RATE_HZ:
        raise ValueError(f"loudness needs a sample rate of {LEAST_RATE_HZ} Hz or more, got {sample_rate_hz:g}")
    heard = pressure_pa - np.mean(pressure_pa)  # to the filters its onset would be a bang
    if not np.any(heard):
        return Loudness(0.0, None)
    rounds = math.ceil(_PLAYED_S * sample_rate_hz / len(pressure_pa)) if closed else 1
    try:
        sone, specific, _ = loudness_zwst(np.tile(heard, rounds), sample_rate_hz, field_type="free")
    except ValueError:  # its words for either
        return Loudness(None, None)
    if not sone > 0.0:
        return Loudness(0.0, None)
    return Loudness(float(sone), float(sharpness_din_from_loudness(sone, specific, weighting="din")))
