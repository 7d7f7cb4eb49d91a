"""Vibration of rolling bearings: velocity in three bands, and the narrow spectra of its lines.

A bearing that turns has lines at frequencies of its kinematics. They are read from a spectrum whose
window falls fast, or from the spectrum of the squared envelope of a band, where the pulses of a
fault have lines. What the record does not separate from a stronger line is not read.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array, short_repr
from acoustics.spectrum import band_edges, checked_record
from acoustics.tone_window import (
    REACH,
    SEPARATED,
    SIDE_LOBES,
    SpectralTone,
    lines_apart,
    lobe,
    place_error,
    tone_is_at,
    tone_window,
    with_pull,
)
from acoustics.traps import ignoring_underflow

VELOCITY_BANDS_HZ: dict[str, tuple[float, float]] = {
    "low": (50.0, 300.0),
    "medium": (300.0, 1800.0),
    "high": (1800.0, 10000.0),
}
"""Edges of the bands of ISO 15242-1 by their names [Hz]."""

_WINDOWS = 5  # of half a record, over which the power of a band is averaged
_PARTS = 8  # of a record, whose scatter gives the uncertainty
_SHORTEST = 16 * _PARTS  # samples of a record
_SURROUNDINGS = 40  # lines to either side of a tone, whose median is its surroundings
_STANDS_OUT = 5.0  # height from which on a peak is a tone, which noise seldom has
_LEAK = 0.03  # of the rms of a line that other tones may make
_SAME_LINE = 1e-3  # lines; tones that are nearer are one

Indices = NDArray[np.int_]


@dataclass(frozen=True)
class VelocityBands:
    """Velocity of a bearing's ring in the three bands of ISO 15242-1.

    Parameters
    ----------
    rms_m_s : dict, m/s
        Root of the mean square by the name of the band: low (50 to 300 Hz), medium (300 to
        1,800 Hz) and high (1,800 to 10,000 Hz).
    uncertainty_db : dict, dB
        Standard uncertainty of each from the length of the record; 0 for a record at rest.

    Examples
    --------
    >>> import numpy as np, acoustics
    >>> tone = 1e-5 * np.sqrt(2) * np.sin(2 * np.pi * 100 * np.arange(48000) / 48000)
    >>> bands = acoustics.velocity_bands(tone, 48000)
    >>> [round(1e6 * rms, 2) for rms in bands.rms_m_s.values()]  # um/s
    [10.0, 0.0, 0.0]
    """

    __repr__ = short_repr

    rms_m_s: dict[str, float]
    uncertainty_db: dict[str, float]


def velocity_bands(
    velocity_m_s: Array,
    sample_rate_hz: float,
    bands_hz: Mapping[str, tuple[float, float]] = VELOCITY_BANDS_HZ,
) -> VelocityBands:
    """Compute the rms velocity of a bearing's ring in the three bands of ISO 15242-1.

    The record is a stretch of a longer one and closes nowhere, so its power is the mean under five
    Hann windows of half its length T. A line farther than 4/T from an edge stays on its side. The
    standard's filters have slopes instead.

    The uncertainty is the scatter between eighths of the record over the root of eight. Lines that
    a turning bearing repeats do not scatter, noise does.

    Parameters
    ----------
    velocity_m_s : array (n,), m/s
        Velocity of the ring in one direction, at least 128 samples.
    sample_rate_hz : float, Hz
        Sample rate, at least twice the highest edge: 20 kHz.
    bands_hz : mapping
        Edges of each band by its name [Hz], where a record does not reach as far as the standard
        asks. Default: those of the standard.

    Returns
    -------
    VelocityBands

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`, for fewer samples, and for a lower rate.

    References
    ----------
    ISO 15242-1:2015, Rolling bearings - Measuring methods for vibration - Part 1, for the bands.
    Welch, IEEE Transactions on Audio and Electroacoustics 1967, 15(2), 70-73, for the windows.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import velocity_bands
    >>> noise = 1e-5 * np.random.default_rng(1).standard_normal(48000)
    >>> bands = velocity_bands(noise, 48000)  # 24 kHz wide
    >>> round(1e6 * bands.rms_m_s["high"], 1), bands.uncertainty_db["high"] < 0.2
    (5.7, True)
    """
    record = checked_record(velocity_m_s, sample_rate_hz, "velocity_m_s")
    highest_hz = max(high for _, high in bands_hz.values())
    if sample_rate_hz < 2 * highest_hz:
        raise ValueError(
            f"sample_rate_hz: got {sample_rate_hz:g}, allowed: at least {2 * highest_hz:g}"
        )
    if len(record) < _SHORTEST:
        raise ValueError(f"velocity_m_s: got {len(record)} samples, allowed: at least {_SHORTEST}")
    whole = _band_mean_squares(record, sample_rate_hz, bands_hz)
    samples = len(record) // _PARTS
    parts = np.array(
        [
            _band_mean_squares(
                record[number * samples : (number + 1) * samples], sample_rate_hz, bands_hz
            )
            for number in range(_PARTS)
        ]
    )
    rms = {}
    uncertainty_db = {}
    for number, name in enumerate(bands_hz):
        rms[name] = math.sqrt(whole[number])
        uncertainty_db[name] = _uncertainty_db(parts[:, number])
    return VelocityBands(rms_m_s=rms, uncertainty_db=uncertainty_db)


def _band_mean_squares(
    record: Array, sample_rate_hz: float, bands_hz: Mapping[str, tuple[float, float]]
) -> list[float]:
    """Return the mean squares of bands, as means over Hann windows that overlap."""
    count = len(record) // 2
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * (np.arange(count) + 0.5) / count)
    frequency_hz = np.fft.rfftfreq(count, 1.0 / sample_rate_hz)
    power = np.zeros(len(frequency_hz))
    for number in range(_WINDOWS):
        first = number * (len(record) - count) // (_WINDOWS - 1)
        lines = np.fft.rfft(window * record[first : first + count])
        power += np.square(lines.real) + np.square(lines.imag)
    # Both signs of a frequency have the same power.
    power *= 2.0 / (_WINDOWS * count * float(np.square(window).sum()))
    mean_squares = []
    for low, high in bands_hz.values():
        inside = (frequency_hz >= low) & (frequency_hz < high)
        mean_squares.append(float(power[inside].sum()))
    return mean_squares


def _uncertainty_db(mean_squares: Array) -> float:
    """Return the standard uncertainty [dB] of the mean of mean squares that scatter."""
    mean = float(mean_squares.mean())
    if not mean > 0.0:
        return 0.0
    share = float(mean_squares.std(ddof=1)) / mean / math.sqrt(len(mean_squares))
    return 10.0 / math.log(10.0) * share


# ---- lines


class LineReading(NamedTuple):
    """A line of a spectrum, as far as the record separates it from stronger ones.

    rms : float or None, unit of the record. Root of the mean square of the tone; None where the
        record does not separate it from a stronger one. It is 0 below the side lobes of the window.
    height : float or None. Its ratio to the median of its surroundings [-]; noise has 1 to 3.
    resolving_s : float or None, s. Length of a record that would separate it; None where this one
        does.
    """

    rms: float | None
    height: float | None
    resolving_s: float | None = None


@ignoring_underflow
@dataclass(frozen=True)
class NarrowSpectrum:
    """Spectrum of a record under a Blackman-Harris window, from which tones are read.

    Parameters
    ----------
    frequency_hz : array (n,), Hz
        Frequencies of the lines from 0 Hz on, 1/T apart.
    rms : array (n,), unit of the record
        Root of the mean square of a tone at each line. Noise stands higher by the root of the
        noise bandwidth of a line, and falls with the length of the record.

    Examples
    --------
    >>> import numpy as np, acoustics
    >>> tone = np.sqrt(2) * np.sin(2 * np.pi * 92.2 * np.arange(48000) / 48000)
    >>> spectrum = acoustics.narrow_spectrum(tone, 48000)
    >>> line = spectrum.read_line(92.2)
    >>> round(line.rms, 3), line.height > 1000
    (1.0, True)
    >>> hidden = spectrum.read_line(94.2)  # within the lobe of the tone
    >>> hidden.rms is None, round(hidden.resolving_s, 1)
    (True, 2.5)
    """

    __repr__ = short_repr

    frequency_hz: Array
    rms: Array

    @property
    def line_width_hz(self) -> float:
        """Distance of two lines [Hz]."""
        return float(self.frequency_hz[1] - self.frequency_hz[0])

    def read_line(self, frequency_hz: float, beside_hz: Sequence[float] = ()) -> LineReading:
        """Read the line of a tone whose frequency is known, between two lines too.

        Parameters
        ----------
        frequency_hz : float, Hz
            Frequency of the tone.
        beside_hz : sequence of float, Hz
            Frequencies of other tones that may be there. Where one tone may be this or another of
            them, neither is read. Default: none.

        Returns
        -------
        LineReading
            Its rms is within some per cent of that of the tone. It has none where stronger tones
            make more than 3 % of it, and more than the noise of its surroundings.
        """
        place = frequency_hz / self.line_width_hz
        if not 0 < place <= len(self.rms) - 1:
            return LineReading(rms=0.0, height=0.0)
        rivals = [other / self.line_width_hz for other in beside_hz]
        rivals = [other for other in rivals if abs(other - place) > _SAME_LINE]
        rms = self._rms_at(place)
        others = list[SpectralTone]()
        if 2 * place < SEPARATED:  # from the image of a tone of a real record, below 0 Hz
            others.append(SpectralTone(place=-place, error=0.0, rms=rms))
        is_peak = False
        for tone in self._tones_about(place):
            if not tone_is_at(tone, place):
                others.append(tone)
                continue
            is_peak = True
            near = [abs(other - place) for other in rivals if tone_is_at(tone, other)]
            if near:
                return LineReading(None, None, self._resolving_s(min(near)))
        hidden = sum(tone.rms * self._lobe_at(place, tone.place) for tone in others)
        floor = self._floor(place)
        # What stands out and is no peak is the flank of others, which may be several tones.
        is_flank = bool(others) and not is_peak and rms >= _STANDS_OUT * floor
        if is_flank or (hidden > _LEAK * rms and hidden > floor):
            separation = lines_apart(place, others, rivals)
            return LineReading(None, None, self._resolving_s(separation))
        if rms <= SIDE_LOBES * self._largest:
            return LineReading(rms=0.0, height=0.0)
        return LineReading(rms=rms, height=rms / floor)

    def peaks_hz(
        self, count: int, low_hz: float, high_hz: float, least_height: float
    ) -> list[float]:
        """Return the frequencies of the largest peaks between two frequencies, largest first.

        Parameters
        ----------
        count : int
            Number of peaks, at most.
        low_hz, high_hz : float, Hz
            Frequencies between which they lie.
        least_height : float
            Least ratio to the median of their surroundings [-].

        Returns
        -------
        list of float, Hz. Between lines, each is that of the parabola through the logarithms of
            three lines.
        """
        tops = self._tops(1, len(self.rms) - 2)
        at_hz = self.frequency_hz[tops]
        tops = tops[(at_hz >= low_hz) & (at_hz < high_hz)]
        peaks = list[float]()
        for top in tops[np.argsort(-self.rms[tops], kind="stable")]:
            place = self._top_place(int(top))
            frequency = place * self.line_width_hz
            near = min((abs(frequency - other) for other in peaks), default=math.inf)
            is_new = near > REACH * self.line_width_hz
            if is_new and self._rms_at(place) >= least_height * self._floor(place):
                peaks.append(frequency)
            if len(peaks) == count:
                break
        return peaks

    def is_at(self, line_hz: float, peak_hz: float) -> bool:
        """Tell whether a peak may be a tone of a given frequency, as far as noise lets one know.

        Parameters
        ----------
        line_hz : float, Hz
            Frequency of the tone.
        peak_hz : float, Hz
            Frequency of the peak, as of `peaks_hz`.

        Returns
        -------
        bool
        """
        place = peak_hz / self.line_width_hz
        error = place_error(self._rms_at(place) / self._floor(place))
        return abs(line_hz - peak_hz) <= error * self.line_width_hz

    def hides(self, line_hz: float, peak_hz: float) -> bool:
        """Tell whether a peak is so near to a frequency that a tone there cannot be read.

        Parameters
        ----------
        line_hz : float, Hz
            Frequency of the tone.
        peak_hz : float, Hz
            Frequency of the peak.

        Returns
        -------
        bool
        """
        return abs(line_hz - peak_hz) < SEPARATED * self.line_width_hz

    @cached_property
    def _largest(self) -> float:
        """Largest line."""
        return float(self.rms.max(initial=0.0))

    def _resolving_s(self, lines_apart: float) -> float:
        """Return the length of a record [s] that separates tones now so many lines apart.

        It is longer than this record, which does not separate them. Where the flank of several
        tones hides a line that is farther from each of them, they count as a reach apart.
        """
        separated_lines = lines_apart if lines_apart < SEPARATED else REACH
        return SEPARATED / (separated_lines * self.line_width_hz)

    def _rms_at(self, place: float) -> float:
        """Return the rms of a tone at a place between lines, from the nearest line and its lobe."""
        line = min(round(place), len(self.rms) - 1)
        return float(self.rms[line]) / float(lobe(line - place))

    def _lobe_at(self, place: float, tone_place: float) -> float:
        """Return which part of a tone elsewhere is read at a place."""
        line = min(round(place), len(self.rms) - 1)
        if abs(line - tone_place) >= REACH:
            return 0.0
        return float(lobe(line - tone_place) / lobe(line - place))

    def _surroundings(self, place: float) -> float:
        """Return the median of 40 lines to either side of the lobe at a place."""
        first = max(math.ceil(place - REACH), 0)
        last = max(min(math.floor(place + REACH) + 1, len(self.rms)), first)
        below = self.rms[max(first - _SURROUNDINGS, 1) : first]
        above = self.rms[last : last + _SURROUNDINGS]
        beside = np.concatenate((below, above))
        return float(np.median(beside)) if len(beside) else 0.0

    def _floor(self, place: float) -> float:
        """Return the rms that surroundings and side lobes have at a place, above zero."""
        surroundings = self._surroundings(place)
        return max(surroundings, SIDE_LOBES * self._largest, float(np.finfo(float).tiny))

    def _tops(self, first: int, last: int) -> Indices:
        """Return the numbers of the lines that are above their neighbours, from first to last."""
        middle = self.rms[first : last + 1]
        before = self.rms[first - 1 : last]
        behind = self.rms[first + 1 : last + 2]
        return np.asarray(np.flatnonzero((middle >= before) & (middle > behind)) + first)

    def _top_place(self, top: int) -> float:
        """Return the place of a tone about a line that is above its neighbours."""
        low, middle, high = np.log(np.maximum(self.rms[top - 1 : top + 2], np.finfo(float).tiny))
        bend = low - 2 * middle + high
        return top + float((low - high) / (2 * bend)) if bend < 0 else float(top)

    def _tones_about(self, place: float) -> list[SpectralTone]:
        """Return the tones that stand out and whose lobes may reach the lines about a place."""
        first = max(math.floor(place - REACH - 2), 1)
        last = min(math.ceil(place + REACH + 2), len(self.rms) - 2)
        tones = []
        for top in self._tops(first, last) if last >= first else ():
            at = self._top_place(int(top))
            rms = self._rms_at(at)
            height = rms / self._floor(at)
            if height >= _STANDS_OUT:
                tones.append(SpectralTone(place=at, error=place_error(height), rms=rms))
        return [with_pull(tone, tones) for tone in tones]


def narrow_spectrum(signal: Array, sample_rate_hz: float) -> NarrowSpectrum:
    """Compute the spectrum of a record under a Blackman-Harris window, with the rms of tones.

    Parameters
    ----------
    signal : array (n,), any unit
        Record, at least 8 samples. Its mean under the window is subtracted.
    sample_rate_hz : float, Hz
        Sample rate.

    Returns
    -------
    NarrowSpectrum

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`, and for fewer samples.

    References
    ----------
    Harris, Proceedings of the IEEE 1978, 66(1), 51-83.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import narrow_spectrum
    >>> tone = np.sqrt(2) * np.sin(2 * np.pi * 1000 * np.arange(4800) / 48000)
    >>> round(float(narrow_spectrum(tone, 48000).rms.max()), 6)
    1.0
    """
    record = checked_record(signal, sample_rate_hz)
    count = len(record)
    if count < 8:
        raise ValueError(f"signal: got {count} samples, allowed: at least 8")
    window = tone_window(count)
    mean = float(window @ record) / float(window.sum())
    amplitudes = 2.0 * np.abs(np.fft.rfft(window * (record - mean))) / window.sum()
    frequency_hz = np.fft.rfftfreq(count, 1.0 / sample_rate_hz)
    rms = np.asarray(amplitudes / math.sqrt(2.0), dtype=float)
    return NarrowSpectrum(np.asarray(frequency_hz, dtype=float), rms)


def squared_envelope_spectrum(
    signal: Array,
    sample_rate_hz: float,
    band_hz: Sequence[float] = VELOCITY_BANDS_HZ["high"],
) -> NarrowSpectrum:
    """Compute the spectrum of the squared envelope of a band over its mean.

    Pulses that come at a frequency, such as those of a ball that meets a pit, have lines at this
    frequency and its multiples, with side bands at the frequency with which their strength changes.

    Parameters
    ----------
    signal : array (n,), any unit
        Record, at least 8 samples.
    sample_rate_hz : float, Hz
        Sample rate.
    band_hz : (float, float), Hz
        Edges of the band. Default: 1,800 to 10,000 Hz.

    Returns
    -------
    NarrowSpectrum
        Lines up to the width of the band [-]; all 0 for a record without power in the band.

    Raises
    ------
    ValueError
        As `narrow_spectrum`, or if the band is empty.

    References
    ----------
    R. B. Randall and J. Antoni, Rolling element bearing diagnostics - a tutorial, Mechanical
    Systems and Signal Processing 25 (2011), 485-520, section 3.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import squared_envelope_spectrum
    >>> t = np.arange(48000) / 48000
    >>> pulses = np.exp(-2000 * (t % (1 / 90))) * np.sin(2 * np.pi * 4000 * t)
    >>> spectrum = squared_envelope_spectrum(pulses, 48000)
    >>> spectrum.read_line(90.0).height > 100, spectrum.read_line(137.0).height < 10
    (True, True)
    """
    record = checked_record(signal, sample_rate_hz)
    low, high = band_edges(band_hz, sample_rate_hz)
    count = len(record)
    frequency_hz = np.fft.rfftfreq(count, 1.0 / sample_rate_hz)
    inside = np.flatnonzero((frequency_hz >= low) & (frequency_hz < high))
    analytic = np.zeros(count, dtype=complex)
    analytic[inside] = 2.0 * np.fft.rfft(record)[inside]
    values = np.fft.ifft(analytic)
    square = np.square(values.real) + np.square(values.imag)
    mean = float(square.mean())
    spectrum = narrow_spectrum(square / mean if mean > 0.0 else square, sample_rate_hz)
    shown = spectrum.frequency_hz <= high - low
    return NarrowSpectrum(spectrum.frequency_hz[shown], spectrum.rms[shown])
