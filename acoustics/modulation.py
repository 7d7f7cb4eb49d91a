"""Modulation of a record: the spectrum of the envelope of a band."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array, positive, real_array, short_repr
from acoustics.bands import EDGES_HZ, third_octave_mean_square
from acoustics.spectrum import audible_lines, checked_record
from acoustics.weighting import a_weighting_db

OCTAVE = 3  # third octaves
MULTIPLES = 5  # of a frequency whose lines are judged
FAINT_DB = 30.0  # below the loudest octave, where a modulation is not looked for
_NOTHING = 1e-9  # modulation that is rounding


@dataclass(frozen=True)
class EnvelopeSpectrum:
    """Spectrum of the envelope of a band of a record.

    Parameters
    ----------
    frequency_hz : array (n,), Hz
        Frequencies of the lines, without 0 Hz.
    modulation : array (n,)
        Amplitude of the envelope in each line over its mean [-].
    band_hz : (float, float), Hz
        Edges of the band.

    Examples
    --------
    >>> import numpy as np, acoustics
    >>> t = np.arange(48000) / 48000
    >>> tone = (1 + 0.5 * np.cos(2 * np.pi * 4 * t)) * np.sin(2 * np.pi * 1000 * t)
    >>> envelope = acoustics.envelope_spectrum(tone, 48000, closed=True)
    >>> [round(edge) for edge in envelope.band_hz], round(envelope.at(4.0), 6)
    ([562, 1122], 0.5)
    """

    __repr__ = short_repr

    frequency_hz: Array
    modulation: Array
    band_hz: tuple[float, float]

    def at(self, frequency_hz: float) -> float:
        """Return the largest modulation of the lines next to a frequency.

        Parameters
        ----------
        frequency_hz : float, Hz
            Frequency of the modulation.

        Returns
        -------
        float. Modulation [-]; 0 beyond the last line.
        """
        width = self.frequency_hz[:1]  # of a line
        near = np.abs(self.frequency_hz - frequency_hz) <= 1.5 * width
        return float(self.modulation[near].max(initial=0.0))

    def prominence(self, frequency_hz: float) -> float:
        """Return the mean modulation at the first five multiples of a frequency over the median.

        Parameters
        ----------
        frequency_hz : float, Hz
            Frequency of the modulation.

        Returns
        -------
        float. Ratio to the median of all lines up to the sixth multiple [-]; noise alone has 1 to
            3.
        """
        below = self.modulation[self.frequency_hz < (MULTIPLES + 1) * frequency_hz]
        lines = [self.at(k * frequency_hz) for k in range(1, MULTIPLES + 1)]
        return float(np.mean(lines) / max(np.median(below), _NOTHING)) if len(below) else 0.0


def modulated_octave(
    signal: Array, sample_rate_hz: float, frequency_hz: float, closed: bool = False
) -> tuple[float, float]:
    """Return the edges of the octave in which a modulation and its multiples stand out most.

    Ten octaves side by side are compared, by the prominence in their envelope spectra. Octaves that
    are 30 dB(A) below the loudest of them or narrower than six multiples are left out; if all are,
    it is the `loudest_octave`.

    Parameters
    ----------
    signal : array (n,), any unit
        Record.
    sample_rate_hz : float, Hz
        Sample rate.
    frequency_hz : float, Hz
        Frequency of the modulation.
    closed : bool
        As in `envelope_spectrum`. Default: false.

    Returns
    -------
    (float, float), Hz
        Lower and upper edge.

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import modulated_octave
    >>> t = np.arange(48000) / 48000
    >>> click = np.sin(2 * np.pi * 1000 * t) * (t % 0.1 < 0.01)
    >>> [round(edge) for edge in modulated_octave(click + np.sin(12000 * t), 48000, 10.0, True)]
    [562, 1122]
    """
    power = _octave_power(signal, sample_rate_hz)[::OCTAVE]
    bands = [(float(EDGES_HZ[k]), float(EDGES_HZ[k + OCTAVE])) for k in range(0, 30, OCTAVE)]
    least = power.max() * 10 ** (-FAINT_DB / 10)
    wide = (MULTIPLES + 1) * positive("frequency_hz", frequency_hz)
    loud = [band for band, own in zip(bands, power, strict=True) if own > least]
    heard = [(low, high) for low, high in loud if high - low > wide]

    def prominence(band: tuple[float, float]) -> float:
        return envelope_spectrum(signal, sample_rate_hz, band, closed).prominence(frequency_hz)

    return max(heard, key=prominence, default=loudest_octave(signal, sample_rate_hz))


def loudest_octave(signal: Array, sample_rate_hz: float) -> tuple[float, float]:
    """Return the edges of the octave with the largest A-weighted mean square.

    An octave is three neighbouring third octaves; the lowest of equal ones is taken.

    Parameters
    ----------
    signal : array (n,), any unit
        Record.
    sample_rate_hz : float, Hz
        Sample rate.

    Returns
    -------
    (float, float), Hz
        Lower and upper edge.

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import loudest_octave
    >>> tone = np.sin(2 * np.pi * 1000 * np.arange(4800) / 48000)
    >>> [round(edge) for edge in loudest_octave(tone, 48000)]
    [562, 1122]
    """
    first = int(np.argmax(_octave_power(signal, sample_rate_hz)))
    return float(EDGES_HZ[first]), float(EDGES_HZ[first + OCTAVE])


def _octave_power(signal: Array, sample_rate_hz: float) -> Array:
    """Return the A-weighted mean squares of the octaves from each third octave on (29,)."""
    frequency, mean_square = audible_lines(signal, sample_rate_hz)
    weighted = mean_square * 10 ** (a_weighting_db(frequency) / 10)
    power = third_octave_mean_square(frequency, weighted)
    return np.convolve(power, np.ones(OCTAVE), "valid")


def _edges(band_hz: Sequence[float]) -> tuple[float, float]:
    """Return the edges of a band [Hz]; raise ValueError unless they rise from 0 Hz."""
    edges = real_array("band_hz", band_hz, 1)
    if len(edges) != 2 or not 0 <= edges[0] < edges[1]:
        raise ValueError(f"band_hz: got {band_hz}, allowed: two edges that rise from 0 Hz")
    return float(edges[0]), float(edges[1])


def envelope_spectrum(
    signal: Array,
    sample_rate_hz: float,
    band_hz: tuple[float, float] | None = None,
    closed: bool = False,
) -> EnvelopeSpectrum:
    """Compute the spectrum of the Hilbert envelope of a band of a record.

    The envelope is the magnitude of the analytic signal of the band. A tone whose amplitude is
    modulated by the share m has a line of m at the frequency of the modulation.

    Parameters
    ----------
    signal : array (n,), any unit
        Record.
    sample_rate_hz : float, Hz
        Sample rate.
    band_hz : (float, float), Hz
        Edges of the band. Default: `loudest_octave`.
    closed : bool
        If true, the end of the record leads to its beginning, and no window is needed; otherwise
        the envelope has a Hann window. Default: false.

    Returns
    -------
    EnvelopeSpectrum
        Lines up to the width of the band; all 0 for a record without sound in the band.

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`, or if the band is empty.

    References
    ----------
    R. B. Randall and J. Antoni, Rolling element bearing diagnostics - a tutorial, Mechanical
    Systems and Signal Processing 25 (2011), 485-520.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import envelope_spectrum
    >>> t = np.arange(48000) / 48000
    >>> tone = (1 + 0.5 * np.cos(2 * np.pi * 4 * t)) * np.sin(2 * np.pi * 1000 * t)
    >>> round(envelope_spectrum(tone, 48000, closed=True).at(4.0), 6)
    0.5
    """
    record = checked_record(signal, sample_rate_hz)
    low, high = loudest_octave(signal, sample_rate_hz) if band_hz is None else _edges(band_hz)
    count = len(record)
    frequency = np.fft.rfftfreq(count, 1 / sample_rate_hz)
    analytic = np.zeros(count, dtype=complex)
    inside = np.flatnonzero((frequency >= low) & (frequency < high))
    analytic[inside] = 2 * np.fft.rfft(record)[inside]
    envelope = np.abs(np.fft.ifft(analytic))
    window = np.ones(count) if closed else 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(count) / count)
    mean = float(window @ envelope / window.sum())
    lines = 2 * np.abs(np.fft.rfft(window * (envelope - mean))) / window.sum()
    kept = (frequency > 0) & (frequency <= high - low)
    modulation = lines[kept] / mean if mean > 0 else np.zeros(np.count_nonzero(kept))
    return EnvelopeSpectrum(np.asarray(frequency[kept], dtype=float), modulation, (low, high))
