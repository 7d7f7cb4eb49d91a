"""Exact spectral operations that lead from step means of a closed track to audible samples.

A record of n samples is closed when its end meets its beginning: n samples are one period. The
lines of its transform are the signal itself, so filters are brick walls without ripple, delay or
alias.
"""

import numpy as np

from acoustics.arrays import Array, refuse_masked
from acoustics.bands import AUDIBLE_HZ

Edges = tuple[float, float]
_OVERSAMPLING = 8
DECIMATOR_REACH = 20  # samples of the output that a decimating filter reaches to either side

# A transform errs by less than 1e-15 of the rms of its input (measured to 1e6 samples, prime
# lengths included).
_ROUNDING = 1e-13


def undo_step_mean(means: Array) -> Array:
    """Return a signal at the step boundaries from its means over consecutive steps.

    Mean i covers the step from i to i + 1. Averaging multiplies line k of n by sinc(k/n), and the
    mean belongs to i + 1/2. Both are undone, which is exact for every band-limited signal. The line
    at Nyquist (even n) is set to zero: a step mean contains only its sine, which vanishes at the
    boundaries.

    Parameters
    ----------
    means : array (n,), any unit. Step means of a signal that is periodic over the n steps.

    Returns
    -------
    array (n,), same unit
        The signal at 0, 1, ..., n - 1 steps.
    """
    refuse_masked("means", means)
    n = len(means)
    lines = np.fft.rfft(means)
    f = np.arange(len(lines)) / n
    lines /= np.sinc(f) * np.exp(1j * np.pi * f)
    if n % 2 == 0:
        lines[-1] = 0.0
    return np.fft.irfft(lines, n)


def band_limit(signal: Array, sample_rate_hz: float, band_hz: Edges = AUDIBLE_HZ) -> Array:
    """Limit a closed record to low <= f < high by a brick wall, and remove its mean.

    Give the signal with its mean. A remainder that is only rounding (1e-13 of the rms) is
    recognised against it and returned as zeros, so a constant power is silent.

    Parameters
    ----------
    signal : array (n,), any unit. Closed record.
    sample_rate_hz : float, Hz. Sample rate.
    band_hz : pair of float, Hz. Edges of the pass band. Default: the 31 third octaves from 20 Hz to
        20 kHz.

    Returns
    -------
    array (n,), same unit
    """
    refuse_masked("signal", signal)
    n = len(signal)
    lines = np.fft.rfft(signal)
    frequency_hz = np.fft.rfftfreq(n, 1.0 / sample_rate_hz)
    lines[(frequency_hz < band_hz[0]) | (frequency_hz >= band_hz[1])] = 0.0
    lines[0] = 0.0
    limited = np.fft.irfft(lines, n)
    if _rms(limited) <= _ROUNDING * _rms(signal):
        return np.zeros(n)
    return limited


def resample_closed(signal: Array, n_out: int) -> Array:
    """Resample a closed record to another number of samples over the same period.

    Frequencies that both lengths can carry are exact. Lines at or above the new Nyquist frequency
    are dropped, so nothing folds back. The new sample rate is n_out / duration: choose a duration
    that holds a whole number of output samples.

    Parameters
    ----------
    signal : array (n,), any unit. Closed record.
    n_out : int. Number of output samples.

    Returns
    -------
    array (n_out,), same unit
        Closed record; sample 0 keeps its place.
    """
    refuse_masked("signal", signal)
    n = len(signal)
    if n_out == n:
        return np.array(signal, dtype=float)
    lines = np.fft.rfft(signal)
    spectrum = np.zeros(n_out // 2 + 1, dtype=complex)
    below_nyquist = (min(n, n_out) + 1) // 2
    spectrum[:below_nyquist] = lines[:below_nyquist]
    if n < n_out and n % 2 == 0:
        # this line stood for +Nyquist and -Nyquist, which are now two lines
        spectrum[n // 2] = lines[n // 2] / 2.0
    return np.fft.irfft(spectrum, n_out) * (n_out / n)


def interpolate_closed(signal: Array, index: Array) -> Array:
    """Interpolate a closed record between its samples.

    The lines are oversampled eight-fold, then a periodic cubic spline follows. Its measured error,
    rms over rms of a sine, is -112 dB at half of Nyquist and -91 dB at 0.9 of it. Values at unequal
    intervals (a track at varying speed) can reach above the Nyquist frequency of a coarse output:
    take them densely, then fade and `resample_closed`.

    Parameters
    ----------
    signal : array (n,), any unit. Closed record.
    index : array of any shape, samples. Positions; whole numbers are the samples themselves, and
        positions beyond 0 and n wrap.

    Returns
    -------
    array in the shape of ``index``, unit of ``signal``
    """
    refuse_masked("index", index)
    from scipy import ndimage  # slow to import, for varying speeds only

    fine = resample_closed(signal, _OVERSAMPLING * len(signal))
    position = np.asarray(index, dtype=float) * _OVERSAMPLING
    values: Array = ndimage.map_coordinates(fine, position[np.newaxis], order=3, mode="grid-wrap")
    return values


def fade(signal: Array, n: int) -> Array:
    """Fade the first and last n samples of an open record to zero by a raised cosine.

    Parameters
    ----------
    signal : array, any unit. Record.
    n : int. Samples of each fade.

    Returns
    -------
    array of the same length, same unit

    Raises
    ------
    ValueError
        If the two fades overlap.
    """
    refuse_masked("signal", signal)
    if not 0 <= 2 * n <= len(signal):
        raise ValueError(f"two fades of {n} samples do not fit into a record of {len(signal)}")
    ramp = np.square(np.sin(0.5 * np.pi * np.arange(n) / max(n, 1)))
    faded = np.array(signal, dtype=float)
    faded[:n] *= ramp
    faded[len(faded) - n :] *= ramp[::-1]
    return faded


class Decimator:
    """Low-pass filter from `factor` values per sample to one, in parts that join without a seam.

    It passes 20 kHz of a rate of 48 kHz, and stops by 100 dB beyond 28 kHz, which folds to 20 kHz.
    Values are a row (n,), or columns (n, m). Sample 0 belongs to value 0.
    """

    def __init__(self, factor: int) -> None:
        from scipy import signal  # slow to import, for long records only

        self._factor = factor
        reach = DECIMATOR_REACH * factor
        window = "kaiser", signal.kaiser_beta(100)
        self._filter = signal.firwin(2 * reach + 1, 1 / max(factor, 1.01), window=window)
        self._past: Array | None = None
        self._skip = DECIMATOR_REACH
        self._upfirdn = signal.upfirdn

    def add(self, values: Array) -> Array:
        """Take the next values, whole samples of them; return the samples that are complete."""
        if self._factor == 1:
            return values
        if self._past is None:
            self._past = np.zeros((len(self._filter) - 1, *values.shape[1:]))
        both = np.concatenate((self._past, values))
        self._past = both[len(values) :]
        whole = self._upfirdn(self._filter, both, down=self._factor, axis=0)
        first = 2 * DECIMATOR_REACH
        samples = whole[first : first + len(values) // self._factor]
        skipped = self._skip
        self._skip = max(self._skip - len(samples), 0)
        return np.asarray(samples[skipped:])

    def end(self) -> Array:
        """Return the samples that are left after the last values."""
        if self._factor == 1 or self._past is None:
            return np.zeros(0)
        return self.add(np.zeros((DECIMATOR_REACH * self._factor, *self._past.shape[1:])))


def _rms(signal: Array) -> float:
    return float(np.sqrt(np.mean(np.square(signal))))
