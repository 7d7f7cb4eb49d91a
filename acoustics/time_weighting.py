"""Exponential time weighting Fast and Slow of a sound pressure record. Depends on numpy, scipy and the A-weighting."""

from __future__ import annotations

import math

import numpy as np
from scipy import signal

from acoustics.weighting import a_weighting_db

# IEC 61672-1:2013, 5.8: time constants of the time weightings F and S.
FAST_S = 0.125
SLOW_S = 1.0


def running_mean_square(
    pressure_pa: np.ndarray, sample_rate_hz: float, time_constant_s: float, closed: bool
) -> np.ndarray:
    """Exponentially weighted mean square at every sample: what a sound level meter shows while the record is played.

    The squared pressure through a low-pass of first order. The squares of a record of the audible band fold at 48 kHz,
    but to 3 kHz and above, where Fast leaves 1/2500 of them.

    Parameters
    ----------
    pressure_pa
        Sound pressure (n,), Pa, frequency-weighted before if it is to be.
    sample_rate_hz
        Sample rate, Hz.
    time_constant_s
        Time constant, s: ``FAST_S`` or ``SLOW_S``.
    closed
        The record closes on itself and has been going round for ever: the weighting is in its periodic state from the
        first sample, and its mean is the mean square of the record. Otherwise it starts from silence.

    Returns
    -------
    Mean square (n,), Pa^2.

    References
    ----------
    IEC 61672-1:2013, 3.8 and 5.8.
    """
    n = len(pressure_pa)
    decay = 1.0 / (sample_rate_hz * time_constant_s)  # per sample, in nepers
    running = signal.lfilter([-math.expm1(-decay)], [1.0, -math.exp(-decay)], np.square(pressure_pa))
    if closed:
        # One round takes the state s to s exp(-n decay) + the last value from silence; the settled state stays.
        settled = running[-1] / -math.expm1(-n * decay)
        running += settled * np.exp(-decay * np.arange(1, n + 1))
    return running


def maximum_mean_square(pressure_pa: np.ndarray, sample_rate_hz: float, time_constant_s: float, closed: bool) -> float:
    """Largest `running_mean_square`, Pa^2: as a level it is the maximum a meter holds."""
    return float(running_mean_square(pressure_pa, sample_rate_hz, time_constant_s, closed).max())


def a_weighted(pressure_pa: np.ndarray, sample_rate_hz: float) -> np.ndarray:
    """The A-weighted record, each line weighted by the exact curve: its mean square is that of LAeq.

    Without phase: a meter's filter delays and smears, by milliseconds at most, which no time weighting sees.

    Parameters
    ----------
    pressure_pa
        Sound pressure (n,), Pa; the record closes on itself or is faded.
    sample_rate_hz
        Sample rate, Hz.

    Returns
    -------
    Weighted record (n,), Pa.
    """
    n = len(pressure_pa)
    gain = 10.0 ** (a_weighting_db(np.fft.rfftfreq(n, 1.0 / sample_rate_hz)) / 20.0)
    return np.fft.irfft(np.fft.rfft(pressure_pa) * gain, n)
