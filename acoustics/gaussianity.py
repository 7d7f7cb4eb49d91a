"""Kurtosis of a record, and its uncertainty for Gaussian noise with the record's spectrum."""

from __future__ import annotations

import math

import numpy as np

from acoustics.arrays import Array


def kurtosis(record: Array) -> float:
    """Return the mean fourth power over the square of the mean square; NaN for silence.

    It is 3 for Gaussian noise, and larger for a record of single events.

    Parameters
    ----------
    record : array (n,), any unit. Record without a mean.

    Returns
    -------
    float

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import kurtosis
    >>> round(kurtosis(np.sin(2 * np.pi * np.arange(100) / 100)), 6)
    1.5
    """
    largest = float(np.max(np.abs(record), initial=0.0))
    if largest == 0.0:
        return math.nan
    square = np.square(np.asarray(record) / largest)  # the fourth power of a pascal may underflow
    return float(np.mean(np.square(square)) / np.mean(square) ** 2)


def kurtosis_uncertainty(record: Array) -> float:
    """Return the standard uncertainty of the kurtosis of Gaussian noise with a record's spectrum.

    A narrow band, and laps that repeat, leave fewer independent samples: the variance is 24/n times
    the sum of the fourth powers of the autocorrelation of n samples.

    Parameters
    ----------
    record : array (n,), any unit. Record without a mean.

    Returns
    -------
    float
        NaN for silence.

    References
    ----------
    Z. A. Lomnicki, Tests for departure from normality in the case of linear stochastic processes,
    Metrika 4, 1961, 37-62.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import kurtosis_uncertainty
    >>> noise = np.random.default_rng(1).standard_normal(2400)
    >>> round(kurtosis_uncertainty(noise), 2)  # sqrt(24/2400)
    0.1
    """
    largest = float(np.max(np.abs(record), initial=0.0))
    if largest == 0.0:
        return math.nan
    power = np.square(np.abs(np.fft.rfft(np.asarray(record) / largest)))
    correlation = np.fft.irfft(power, len(record))
    fourth = np.square(np.square(correlation / correlation[0]))
    return math.sqrt(24.0 * float(np.mean(fourth)))
