"""Long records with the spectrum of a short one, for listening.

An extended record is stationary Gaussian noise with the band levels of its record. It has neither
the single events of the record nor their order, and it never repeats the record.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.bands import EDGES_HZ, NOMINAL_HZ, third_octave_mean_square
from acoustics.spectrum import line_spectrum

_GOLDEN = 0x9E3779B9  # distance of the counters of two seeds


def extend(
    record: Array, samples: int, sample_rate_hz: float, laps: float = 1.0, seed: int = 0
) -> Array:
    """Make a longer record with the spectrum of a record and with random phases.

    A record of T seconds has lines 1/T apart. The longer one has more lines: they share the power
    of the line that they are nearest to, and each band is scaled to its level in the record. The
    density is constant within 1/T, therefore the autocorrelation is zero at lag T, where a
    repeated record has its maximum. The record may hold several equal laps; its density is then
    constant within the inverse of a lap.

    The phases depend on the number of the line and on the seed alone, so the same record always
    gives the same samples. The result closes on itself.

    Parameters
    ----------
    record : array (n,), any unit. Record that closes on itself or is faded.
    samples : int. Number of samples to make, more than n.
    sample_rate_hz : float, Hz. Sample rate of both records.
    laps : float. Number of repetitions in the record. Default 1.
    seed : int. Number of the noise. Default 0.

    Returns
    -------
    array (samples,), same unit
        The longer record; zeros for a silent one.

    Raises
    ------
    ValueError
        If the result would not be longer than the record, and as `check_record`.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import extend, laeq_db
    >>> noise = np.random.default_rng(1).standard_normal(24000)
    >>> longer = extend(noise, 10 * 24000, 48000)
    >>> abs(laeq_db(longer, 48000) - laeq_db(noise, 48000)) < 0.05
    True
    """
    frequency_hz, mean_square = line_spectrum(record, sample_rate_hz)
    if samples <= len(record):
        raise ValueError(
            f"a record of {len(record)} samples is extended to more than that, got {samples}"
        )
    of_record = _groups(np.arange(len(mean_square)) / laps)
    line = np.arange(samples // 2 + 1)
    group = _groups(line * len(record) / samples / laps)
    count = np.bincount(group, minlength=int(of_record[-1]) + 1)
    power = np.bincount(of_record, weights=mean_square, minlength=len(count))
    shared = power[group] / count[group]
    longer_hz = np.asarray(line * (sample_rate_hz / samples), dtype=float)
    shared *= _band_factors(frequency_hz, mean_square, longer_hz, shared)
    amplitude = samples * np.sqrt(shared / 2.0)
    return np.asarray(np.fft.irfft(amplitude * np.exp(1j * _phases(line, seed)), samples))


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


def _groups(place: Array) -> NDArray[np.int64]:
    """Return the number of the nearest whole line."""
    return np.floor(place + 0.5).astype(np.int64)


def _band_factors(
    frequency_hz: Array, mean_square: Array, longer_hz: Array, shared: Array
) -> Array:
    """Return the factor on each line that gives each band its mean square in the record.

    Lines outside of the bands are not heard and get none.
    """
    wanted = third_octave_mean_square(frequency_hz, mean_square)
    present = third_octave_mean_square(longer_hz, shared)
    factors = np.divide(wanted, present, out=np.zeros_like(wanted), where=present > 0.0)
    band = np.searchsorted(EDGES_HZ, longer_hz, side="right")
    return np.concatenate([[0.0], factors, [0.0]])[np.minimum(band, len(NOMINAL_HZ) + 1)]


def _phases(line: NDArray[np.int64], seed: int) -> Array:
    """Return a phase for each line from a hash of its number, equal in every program.

    References
    ----------
    C. Wellons, Prospecting for Hash Functions, 2018: lowbias32.
    """
    x = (line + (seed * _GOLDEN & 0xFFFFFFFF)).astype(np.uint32)
    x = (x ^ (x >> np.uint32(16))) * np.uint32(0x7FEB352D)
    x = (x ^ (x >> np.uint32(15))) * np.uint32(0x846CA68B)
    return np.asarray((x ^ (x >> np.uint32(16))) * (2.0 * math.pi / 2.0**32))
