"""Peaks of the velocity of a ring in a band: peak, crest factor and kurtosis."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.uncertainty import kurtosis, kurtosis_uncertainty

# What fades at each end, and is not looked at: a share of the record, and no more than a time.
_END = 0.2
_LONGEST_END_S = 0.1


class BandPulses(NamedTuple):
    """What pulses do to the velocity in a band.

    peak : float, m/s. The largest magnitude.
    crest_factor : float. The peak over the rms of the same stretch [-]; a sine has 1.4.
    kurtosis : float. Mean fourth power over the square of the mean square [-]; noise has 3.
    kurtosis_uncertainty : float. Its standard uncertainty for noise of such a band and length [-].
    """

    peak: float
    crest_factor: float
    kurtosis: float
    kurtosis_uncertainty: float


def band_pulses(signal: Array, rate_hz: float, band_hz: tuple[float, float]) -> BandPulses | None:
    """Return the pulses of a record between two frequencies; None for an empty band, or silence.

    The record closes nowhere, so its ends are faded before the band is cut out, and not looked at.

    Parameters
    ----------
    signal : array (n,)
        Velocity in one direction.
    rate_hz : float, Hz
        Sample rate.
    band_hz : pair of float, Hz
        Edges of the band.
    """
    low, high = band_hz
    count = len(signal)
    end = max(1, round(min(_END * count, _LONGEST_END_S * rate_hz)))
    half_cosine = 0.5 - 0.5 * np.cos(np.pi * (np.arange(end) + 0.5) / end)
    rise = np.square(np.sin(0.5 * np.pi * half_cosine))  # so smooth that no line leaks into a band
    window = np.ones(count)
    window[:end] = rise
    window[-end:] = rise[::-1]
    lines = np.fft.rfft(window * (signal - np.mean(signal)))
    frequency_hz = np.fft.rfftfreq(count, 1.0 / rate_hz)
    lines[(frequency_hz < low) | (frequency_hz >= high)] = 0.0
    inner = np.fft.irfft(lines, count)[end:-end]
    rms = float(np.sqrt(np.mean(np.square(inner)))) if len(inner) else 0.0
    if not rms > 0.0:
        return None
    peak = float(np.abs(inner).max())
    return BandPulses(
        peak=peak,
        crest_factor=peak / rms,
        kurtosis=kurtosis(inner),
        kurtosis_uncertainty=kurtosis_uncertainty(inner),
    )
