"""Exponential time weighting Fast and Slow of a sound pressure record."""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import blas

from acoustics._typing import Array
from acoustics.weighting import a_weighting_db

# IEC 61672-1:2013, 5.8: time constants of the time weightings F and S.
FAST_S = 0.125
SLOW_S = 1.0


def running_mean_square(
    pressure_pa: Array, sample_rate_hz: float, time_constant_s: float, closed: bool
) -> Array:
    """Return the exponentially weighted mean square at every sample.

    A sound level meter shows it as a level. The squared pressure passes a low-pass of first order.
    At 48 kHz the squares of a record of the audible band fold back to 3 kHz and above, where Fast
    leaves 1/2500 of them.

    Parameters
    ----------
    pressure_pa : array (n,), Pa. Sound pressure, frequency-weighted before if needed.
    sample_rate_hz : float, Hz. Sample rate.
    time_constant_s : float, s. Time constant, ``FAST_S`` or ``SLOW_S``.
    closed : bool. If true, the record loops: the weighting is in its periodic state from the first
        sample, and its mean is the mean square of the record. Otherwise it starts from silence.

    Returns
    -------
    array (n,), Pa^2

    References
    ----------
    IEC 61672-1:2013, 3.8 and 5.8.
    """
    n = len(pressure_pa)
    decay = 1.0 / (sample_rate_hz * time_constant_s)  # decay per sample in nepers
    # Each value is the value before it times exp(-decay), plus a share of the new square: a system
    # of two bands. (scipy.signal, which has such filters, takes half a second to import.)
    bands = np.ones((2, n), order="F")
    bands[1] = -math.exp(-decay)
    new = -math.expm1(-decay) * np.square(pressure_pa)
    running: Array = blas.dtbsv(1, bands, new, lower=1, diag=1)
    if closed:
        # A lap turns the state s into s exp(-n decay) plus the last value from silence. The settled
        # state does not change.
        settled = running[-1] / -math.expm1(-n * decay)
        running += settled * np.exp(-decay * np.arange(1, n + 1))
    return running


def maximum_mean_square(
    pressure_pa: Array, sample_rate_hz: float, time_constant_s: float, closed: bool
) -> float:
    """Return the maximum of `running_mean_square` [Pa^2].

    Its level is the maximum that a sound level meter holds.
    """
    return float(running_mean_square(pressure_pa, sample_rate_hz, time_constant_s, closed).max())


def a_weighted(pressure_pa: Array, sample_rate_hz: float) -> Array:
    """Return the A-weighted record, each line weighted by the exact curve.

    Its mean square is the mean square of LAeq. The weighting has no phase. A meter's filter delays
    and smears by milliseconds at most, which no time weighting resolves.

    Parameters
    ----------
    pressure_pa : array (n,), Pa. Sound pressure; the record closes on itself or is faded.
    sample_rate_hz : float, Hz. Sample rate.

    Returns
    -------
    array (n,), Pa
    """
    n = len(pressure_pa)
    gain = 10.0 ** (a_weighting_db(np.fft.rfftfreq(n, 1.0 / sample_rate_hz)) / 20.0)
    return np.fft.irfft(np.fft.rfft(pressure_pa) * gain, n)
