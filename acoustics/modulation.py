"""Modulation of a record: the spectrum of the envelope of a band."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acoustics.arrays import Array, positive, real_array, short_repr, truth
from acoustics.bands import EDGES_HZ, third_octave_mean_square
from acoustics.spectrum import audible_lines, checked_record
from acoustics.traps import ignoring_underflow
from acoustics.weighting import a_weighting_db

OCTAVE = 3  # third octaves
MULTIPLES = 5  # of a frequency whose lines are judged
FAINT_DB = 30.0  # below the loudest octave, where a modulation is not looked for
PARTS = 64  # of a period, over which an envelope is averaged before periods are compared
MIN_PERIODS = 2  # that can be compared
_PLACES = 8  # between two multiples, at most, where the floor is measured
_NOTHING = 1e-9  # modulation that is rounding
# The median of the amplitudes of lines of noise over their rms: they have a Rayleigh distribution.
_MEDIAN_OVER_RMS = math.sqrt(math.log(2.0))
# The median of the absolute values of Gaussian numbers over their standard deviation.
_MEDIAN_OVER_DEVIATION = 0.6745


@ignoring_underflow
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
    envelope : array (m,), unit of the record
        Envelope of the band at each sample.
    gain : array (m,)
        Factor by which the record was faded at each sample [-]; 1 where it was not.
    sample_rate_hz : float, Hz
        Sample rate.

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
    envelope: Array
    gain: Array
    sample_rate_hz: float

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

    def prominence(self, frequency_hz: float) -> float | None:
        """Return how far the first five multiples of a frequency stand out of the envelope.

        Periods of the frequency are laid over each other. Their mean has lines at the multiples
        alone. The floor under these lines is the larger of two. One is what does not repeat: the
        difference of the periods from their mean, between the multiples. The other is what noise
        that repeats in each period would have, such as the roughness of a ball: the scatter between
        neighbouring parts of the mean period, of which a pulse is but a few. No window widens the
        lines, so two periods suffice, whole or not.

        Parameters
        ----------
        frequency_hz : float, Hz
            Frequency of the modulation.

        Returns
        -------
        float or None. Mean modulation at the multiples over the floor [-]; noise has 1 to 3. None
            if the record has less than two periods, or the band no room for the sixth multiple.
        """
        period = _mean_period(self, frequency_hz)
        if period is None:
            return None
        between = period.floor_between_periods()
        texture = period.floor_of_texture(_width_hz(self))
        floor = max(between, texture, _NOTHING * period.level)
        return period.line / floor if floor > 0.0 else 0.0


@dataclass(frozen=True)
class _MeanPeriod:
    """Periods of an envelope, in `PARTS` parts each, and their mean.

    means : array (parts,), unit of the record. Mean of the envelope in each part of each period.
    gains : array (parts,). Factor by which each part was faded [-].
    frequency_hz : float, Hz. Frequency of the periods.
    """

    means: Array
    gains: Array
    frequency_hz: float

    @cached_property
    def shape(self) -> Array:
        """Mean of the periods before they were faded, (PARTS,)."""
        return _over_periods(self.means, self.gains)

    @cached_property
    def level(self) -> float:
        """Mean of the mean period."""
        return float(self.shape.mean())

    @cached_property
    def line(self) -> float:
        """Mean amplitude of the mean period at the multiples of the frequency."""
        lines = np.abs(np.fft.rfft(self.shape))[1 : MULTIPLES + 1]
        return float(2 * lines.mean() / PARTS)

    def floor_between_periods(self) -> float:
        """Return the median line between the multiples of what does not repeat."""
        count = len(self.means)
        rest = self.means - self.gains * np.resize(self.shape, count)
        periods = round(count / PARTS)
        places = np.arange(1, min(periods - 1, _PLACES) + 1)
        between = places / (len(places) + 1)
        orders = (np.arange(MULTIPLES + 1)[:, None] + between).ravel()
        angle = 2 * np.pi * (np.arange(count) + 0.5) / PARTS
        energy = float(np.square(self.gains).sum())
        amplitudes = []
        for order in orders:
            # A wave loses what it shares with the mean, as the rest has lost it.
            wave = np.exp(1j * order * angle)
            mean = _over_periods(wave.real, self.gains) + 1j * _over_periods(wave.imag, self.gains)
            wave -= self.gains * np.resize(mean, count)
            power = float(np.square(np.abs(wave) * self.gains).sum())
            amplitudes.append(2 * abs(np.vdot(wave, rest)) / math.sqrt(power * energy))
        return float(np.median(amplitudes))

    def floor_of_texture(self, width_hz: float) -> float:
        """Return the median line of noise that scatters as neighbouring parts of the mean period.

        Parts shorter than 1 / width of the band do not scatter independently, and are joined.
        """
        joined = math.ceil(PARTS * self.frequency_hz / width_hz)
        count = PARTS // joined
        parts = self.shape[: count * joined].reshape(count, joined).mean(axis=1)
        steps = np.abs(parts - np.roll(parts, 1))
        deviation = float(np.median(steps)) / _MEDIAN_OVER_DEVIATION / math.sqrt(2.0)
        return _MEDIAN_OVER_RMS * 2 * deviation / math.sqrt(count)


def _mean_period(spectrum: EnvelopeSpectrum, frequency_hz: float) -> _MeanPeriod | None:
    """Return the mean period of an envelope; None without two, or for a band too narrow."""
    samples = spectrum.sample_rate_hz / positive("frequency_hz", frequency_hz) / PARTS
    if _width_hz(spectrum) <= (MULTIPLES + 1) * frequency_hz:
        return None
    if round(len(spectrum.envelope) / samples) < MIN_PERIODS * PARTS:
        return None
    means = _part_means(spectrum.envelope, samples)
    return _MeanPeriod(means, _part_means(spectrum.gain, samples), frequency_hz)


def _width_hz(spectrum: EnvelopeSpectrum) -> float:
    """Return the width of the band of an envelope [Hz]."""
    return spectrum.band_hz[1] - spectrum.band_hz[0]


def _above_noise(spectrum: EnvelopeSpectrum, frequency_hz: float) -> float:
    """Return the lines of a frequency over those of noise as wide as the band; 0 for silence.

    The envelope of noise of the width B that repeats with f has lines in proportion to the root of
    f / B.
    """
    period = _mean_period(spectrum, frequency_hz)
    if period is None or not period.level > 0.0:
        return 0.0
    return period.line / period.level * math.sqrt(_width_hz(spectrum) / frequency_hz)


def _part_means(values: Array, samples: float) -> Array:
    """Return the means of values over successive parts of some samples, whole or not."""
    count = round(len(values) / samples)
    edges = np.minimum(np.arange(count + 1) * samples, len(values))
    sums = np.concatenate(([0.0], np.cumsum(values)))
    at_edges = np.interp(edges, np.arange(len(sums)), sums)
    return np.asarray(np.diff(at_edges) / np.diff(edges))


def _over_periods(means: Array, gains: Array) -> Array:
    """Return the mean period of least squares of means that were faded by gains, (PARTS,)."""
    part = np.arange(len(means)) % PARTS
    weights = np.bincount(part, np.square(gains), PARTS)
    sums = np.bincount(part, gains * means, PARTS)
    return np.asarray(sums / np.maximum(weights, np.finfo(float).tiny))


def modulated_octave(
    signal: Array,
    sample_rate_hz: float,
    frequency_hz: float,
    closed: bool = False,
    gain: Array | None = None,
) -> tuple[float, float]:
    """Return the edges of the octave in which a modulation and its multiples stand out most.

    Ten octaves side by side are compared. Octaves that are 30 dB(A) below the loudest of them or
    narrower than six multiples are left out; if all are, it is the `loudest_octave`. Of the octaves
    whose prominence is at least half the largest, the one is taken whose lines are largest over
    those of noise of the same width. Lines scatter less than their floor does, so records that
    differ by a few samples have the same octave.

    Parameters
    ----------
    signal : array (n,), any unit
        Record.
    sample_rate_hz : float, Hz
        Sample rate.
    frequency_hz : float, Hz
        Frequency of the modulation.
    closed, gain
        As in `envelope_spectrum`. Default: an open record that was not faded.

    Returns
    -------
    (float, float), Hz
        Lower and upper edge.

    Raises
    ------
    ValueError
        As `envelope_spectrum`, or if the frequency is not above 0.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import modulated_octave
    >>> t = np.arange(48000) / 48000
    >>> click = np.sin(2 * np.pi * 1000 * t) * (t % 0.1 < 0.01)
    >>> [round(edge) for edge in modulated_octave(click + np.sin(12000 * t), 48000, 10.0, True)]
    [562, 1122]
    """
    positive("frequency_hz", frequency_hz)
    closed = truth("closed", closed)
    power = _octave_power(signal, sample_rate_hz)[::OCTAVE]
    bands = [(float(EDGES_HZ[k]), float(EDGES_HZ[k + OCTAVE])) for k in range(0, 30, OCTAVE)]
    least = power.max() * 10 ** (-FAINT_DB / 10)
    candidates = list[tuple[EnvelopeSpectrum, float]]()
    for band, own in zip(bands, power, strict=True):
        if own > least:
            spectrum = envelope_spectrum(signal, sample_rate_hz, band, closed, gain)
            prominence = spectrum.prominence(frequency_hz)
            if prominence is not None:
                candidates.append((spectrum, prominence))
    if not candidates:
        return loudest_octave(signal, sample_rate_hz)
    largest = max(prominence for _, prominence in candidates)
    prominent = [spectrum for spectrum, prominence in candidates if prominence >= largest / 2]
    heights = [_above_noise(spectrum, frequency_hz) for spectrum in prominent]
    return prominent[int(np.argmax(heights))].band_hz


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
    gain: Array | None = None,
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
        the spectrum of the envelope has a Hann window. Default: false.
    gain : array (n,)
        Factor by which the record was faded at each sample [-], so that a fade does not count as a
        change of the sound. Default: it was not faded.

    Returns
    -------
    EnvelopeSpectrum
        Lines up to the width of the band; all 0 for a record without sound in the band.

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`, if the band is empty, or if the gain is of another
        length than the record or not above 0 anywhere.

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
    closed = truth("closed", closed)
    low, high = loudest_octave(signal, sample_rate_hz) if band_hz is None else _edges(band_hz)
    count = len(record)
    gain = np.ones(count) if gain is None else real_array("gain", gain, 1)
    if len(gain) != count or not gain.max() > 0.0 or gain.min() < 0.0:
        raise ValueError(
            f"gain: got {len(gain)} from {gain.min():g} up, allowed: {count} numbers from 0 up,"
            " one for each sample, and not all 0"
        )
    frequency = np.fft.rfftfreq(count, 1 / sample_rate_hz)
    analytic = np.zeros(count, dtype=complex)
    inside = np.flatnonzero((frequency >= low) & (frequency < high))
    analytic[inside] = 2 * np.fft.rfft(record)[inside]
    envelope = np.abs(np.fft.ifft(analytic))
    window = np.ones(count)
    if not closed:  # a Hann window
        window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(count) / count)
    mean = float(window @ envelope / window.sum())
    lines = 2 * np.abs(np.fft.rfft(window * (envelope - mean))) / window.sum()
    within_width = (frequency > 0) & (frequency <= high - low)
    modulation = np.zeros(np.count_nonzero(within_width))
    if mean > 0:
        modulation = lines[within_width] / mean
    return EnvelopeSpectrum(
        frequency_hz=np.asarray(frequency[within_width], dtype=float),
        modulation=modulation,
        band_hz=(low, high),
        envelope=envelope,
        gain=gain,
        sample_rate_hz=float(sample_rate_hz),
    )
