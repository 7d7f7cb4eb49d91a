"""How impulsive a vibration is: peak, crest factor and kurtosis by band, and the kurtogram.

A fault of a bearing makes short pulses. They show where a band is narrow enough to leave out what
hides them, and wide enough to keep a pulse short: the kurtogram looks for this band.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array, over_largest, positive, short_repr
from acoustics.resampling import band_limit
from acoustics.spectrum import Band, band_edges, checked_record
from acoustics.uncertainty import kurtosis, kurtosis_uncertainty

ENDS_S = 0.1  # that a record is faded at each end, which count for nothing
LOWEST_PULSE_HZ = 300.0  # of a band in which pulses of a bearing are looked for
PULSES_APART = 4.0  # width of such a band over the frequency of pulses, at least
_ENDS_SHARE = 1 / 8  # of a record, at most
_BRANCHES = (2, 3)  # of a band: its thirds stand between its halves and its quarters
_LEAST_SAMPLES = 32  # independent ones of a band, which are as many as its lines
_LEAST_SHARE = 1e-8  # of the power of a record, below which a band holds rounding and onsets
_OVERSAMPLING = 2  # of an envelope, so that its square does not fold back


@dataclass(frozen=True)
class BandPulses:
    """How impulsive a record is within a band.

    Parameters
    ----------
    rms : float, unit of the record
        Root of the mean square.
    peak : float, unit of the record
        Largest magnitude of a sample.
    crest_factor : float or None
        Peak over rms [-]; noise has 4 to 5, and more in a longer record. None for silence.
    kurtosis : float or None
        Mean fourth power over the square of the mean square [-]; noise has 3. None for silence.
    kurtosis_uncertainty : float or None
        Standard uncertainty of the kurtosis of noise of this band and length [-].

    Examples
    --------
    >>> import acoustics
    >>> pulses = acoustics.BandPulses(
    ...     rms=0.5, peak=2.0, crest_factor=4.0, kurtosis=3.1, kurtosis_uncertainty=0.2
    ... )
    >>> pulses.crest_factor
    4.0
    """

    __repr__ = short_repr

    rms: float
    peak: float
    crest_factor: float | None
    kurtosis: float | None
    kurtosis_uncertainty: float | None


def band_pulses(
    signal: Array, sample_rate_hz: float, bands_hz: Mapping[str, Band]
) -> dict[str, BandPulses]:
    """Compute rms, peak, crest factor and kurtosis of a record in bands.

    The record closes nowhere. It is faded at both ends, cut at the edges of the band, and what was
    faded is left out.

    Parameters
    ----------
    signal : array (n,), any unit
        Record, at least 128 samples.
    sample_rate_hz : float, Hz
        Sample rate.
    bands_hz : mapping
        Edges of each band by its name [Hz].

    Returns
    -------
    dict of BandPulses by the names of the bands.

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`, for a shorter record, or for an empty band.

    References
    ----------
    R. B. Randall and J. Antoni, Rolling element bearing diagnostics - a tutorial, Mechanical
    Systems and Signal Processing 25 (2011), 485-520, section 4.

    Examples
    --------
    >>> import numpy as np, acoustics
    >>> tone = np.sin(2 * np.pi * 1000 * np.arange(48000) / 48000)
    >>> pulses = acoustics.band_pulses(tone, 48000, {"medium": (300, 1800)})["medium"]
    >>> round(pulses.crest_factor, 3), round(pulses.kurtosis, 3)
    (1.414, 1.5)
    """
    record = _open_record(signal, sample_rate_hz)
    ends = _ends(record, sample_rate_hz)
    faded = _faded(record, ends)
    by_band = {}
    for name, band_hz in bands_hz.items():
        low, high = band_edges(band_hz, sample_rate_hz)
        inside = band_limit(faded, sample_rate_hz, (low, high))[ends : len(faded) - ends]
        by_band[name] = _pulses_of(inside)
    return by_band


def _pulses_of(record: Array) -> BandPulses:
    """Return how impulsive a record is, all of which counts."""
    rms = math.sqrt(float(np.mean(np.square(record))))
    peak = float(np.abs(record).max())
    if not rms > 0:
        return BandPulses(0.0, 0.0, None, None, None)
    return BandPulses(
        rms=rms,
        peak=peak,
        crest_factor=peak / rms,
        kurtosis=kurtosis(record),
        kurtosis_uncertainty=kurtosis_uncertainty(record),
    )


# ---- kurtogram


@dataclass(frozen=True)
class Kurtogram:
    """Kurtosis of the envelope in bands of many places and widths.

    Parameters
    ----------
    band_hz : (float, float), Hz
        Edges of the band whose envelope has the largest kurtosis.
    kurtosis : float
        Its kurtosis [-]: mean fourth power of the envelope over the square of its mean square, less
        2; noise has 0, a tone -1. A band 80 dB below the record has -2.
    chance : float
        The largest kurtosis that noise would show in one of as many bands [-], about.
    low_hz, high_hz, all_kurtoses : arrays (bands,)
        Edges [Hz] and kurtosis [-] of all bands.

    Examples
    --------
    >>> import numpy as np, acoustics
    >>> noise = np.random.default_rng(1).standard_normal(48000)
    >>> found = acoustics.kurtogram(noise, 48000, (1800, 10000), 500)
    >>> found.stands_out
    False
    """

    __repr__ = short_repr

    band_hz: Band
    kurtosis: float
    chance: float
    low_hz: Array
    high_hz: Array
    all_kurtoses: Array

    @property
    def stands_out(self) -> bool:
        """Whether the largest kurtosis is more than noise shows by chance."""
        return self.kurtosis > self.chance


def kurtogram(
    signal: Array, sample_rate_hz: float, band_hz: Sequence[float], least_width_hz: float
) -> Kurtogram:
    """Look for the band whose envelope is most impulsive.

    The whole band is divided into 2, 3, 4, 6, 8, 12, 16 parts and so on, as long as a part is wide
    enough. The cut is that of the lines of the transform.

    Parameters
    ----------
    signal : array (n,), any unit
        Record, at least 128 samples.
    sample_rate_hz : float, Hz
        Sample rate.
    band_hz : (float, float), Hz
        Edges of the whole band.
    least_width_hz : float, Hz
        Least width of a part. Pulses that come at a frequency have a line in the envelope of a band
        that is wider than this frequency, and stand apart in one that is several times as wide.

    Returns
    -------
    Kurtogram

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`, for a shorter record, or for an empty band.

    References
    ----------
    J. Antoni, Fast computation of the kurtogram for the detection of transient faults, Mechanical
    Systems and Signal Processing 21 (2007), 108-124: the bands of its tree with halves and thirds.

    Examples
    --------
    >>> import numpy as np, acoustics
    >>> t = np.arange(48000) / 48000
    >>> pulses = np.exp(-2000 * (t % (1 / 90))) * np.sin(2 * np.pi * 4000 * t)
    >>> noise = 0.2 * np.random.default_rng(1).standard_normal(48000)
    >>> best = acoustics.kurtogram(pulses + noise, 48000, (500, 20000), 500)
    >>> best.band_hz[0] < 4000 < best.band_hz[1], best.stands_out
    (True, True)
    """
    record = over_largest(_open_record(signal, sample_rate_hz), of_silence=0.0)
    low, high = band_edges(band_hz, sample_rate_hz)
    width = positive("least_width_hz", least_width_hz)
    ends = _ends(record, sample_rate_hz)
    lines = np.asarray(np.fft.rfft(_faded(record, ends)), dtype=np.complex128)
    faded_share = ends / len(record)
    line_hz = sample_rate_hz / len(record)
    least_power = _LEAST_SHARE * float(np.sum(np.square(np.abs(lines))))
    bands = list[Band]()
    kurtoses = list[float]()
    chances = list[float]()
    for parts in _divisions((high - low) / max(width, _LEAST_SAMPLES * line_hz)):
        edges = np.linspace(low, high, parts + 1)
        for first_hz, last_hz in pairwise(edges.tolist()):
            first, last = math.ceil(first_hz / line_hz), math.ceil(last_hz / line_hz)
            bands.append((first_hz, last_hz))
            kurtoses.append(_envelope_kurtosis(lines[first:last], faded_share, least_power))
            chances.append(2 / math.sqrt(max((last - first) * (1 - 2 * faded_share), 1)))
    best = int(np.argmax(kurtoses))
    return Kurtogram(
        band_hz=bands[best],
        kurtosis=kurtoses[best],
        # The largest of many numbers of a Gaussian law is about sqrt(2 ln N) standard deviations.
        chance=chances[best] * math.sqrt(2 * math.log(len(bands) + 1)),
        low_hz=np.array([band[0] for band in bands]),
        high_hz=np.array([band[1] for band in bands]),
        all_kurtoses=np.array(kurtoses),
    )


def pulse_kurtogram(
    signal: Array, sample_rate_hz: float, highest_hz: float, pulses_hz: float
) -> Kurtogram:
    """Look for the band in which pulses of a bearing show best.

    It lies above 300 Hz, because turns and passes of balls have their own lines below, and it is at
    least four times as wide as pulses are frequent, so that they stand apart.

    Parameters
    ----------
    signal : array (n,), any unit
        Record, at least 128 samples.
    sample_rate_hz : float, Hz
        Sample rate.
    highest_hz : float, Hz
        Highest frequency that the record resolves.
    pulses_hz : float, Hz
        Largest frequency with which pulses may come.

    Returns
    -------
    Kurtogram

    Raises
    ------
    ValueError
        As `kurtogram`.

    Examples
    --------
    >>> import numpy as np, acoustics
    >>> t = np.arange(48000) / 48000
    >>> pulses = np.exp(-2000 * (t % (1 / 90))) * np.sin(2 * np.pi * 4000 * t)
    >>> low, high = acoustics.pulse_kurtogram(pulses, 48000, 10000, 90).band_hz
    >>> low >= 300, high - low >= 360
    (True, True)
    """
    band_hz = (LOWEST_PULSE_HZ, highest_hz)
    return kurtogram(signal, sample_rate_hz, band_hz, PULSES_APART * pulses_hz)


def _divisions(most: float) -> list[int]:
    """Return the numbers of parts of a tree with halves and thirds, 1 and others up to a limit."""
    numbers = {1}
    scale = 1
    while scale <= most:
        numbers |= {scale * branches for branches in _BRANCHES if scale * branches <= most}
        scale *= 2
    return sorted(numbers)


def _envelope_kurtosis(
    lines: NDArray[np.complex128], faded_share: float, least_power: float
) -> float:
    """Return the kurtosis of the envelope of the lines of a band; -2 for less than a least power.

    The envelope keeps its shape when the band is shifted to 0 Hz, where few samples hold it.
    """
    power = float(np.sum(np.square(np.abs(lines))))
    if not power > least_power:
        return -2.0
    count = _OVERSAMPLING * len(lines)
    envelope = np.fft.ifft(lines, count)
    ends = math.ceil(faded_share * count)
    square = np.square(np.abs(envelope[ends : count - ends]))
    mean = float(square.mean())
    return float(np.mean(np.square(square))) / mean**2 - 2.0


# ---- records


def _open_record(signal: Array, sample_rate_hz: float) -> Array:
    """Return a record that is long enough to be faded at its ends."""
    record = checked_record(signal, sample_rate_hz)
    if len(record) < 4 * _LEAST_SAMPLES:
        raise ValueError(
            f"signal: got {len(record)} samples, allowed: at least {4 * _LEAST_SAMPLES}"
        )
    return record


def _faded(record: Array, ends: int) -> Array:
    """Return a record without its mean, so smoothly faded at its ends that no tone leaks far."""
    half_cosine = 0.5 - 0.5 * np.cos(np.pi * (np.arange(ends) + 0.5) / max(ends, 1))
    rise = np.square(np.sin(0.5 * np.pi * half_cosine))
    window = np.ones(len(record))
    window[:ends] = rise
    window[len(record) - ends :] = rise[::-1]
    return np.asarray(window * (record - record.mean()))


def _ends(record: Array, sample_rate_hz: float) -> int:
    """Return the samples that are faded at each end."""
    return min(round(ENDS_S * sample_rate_hz), int(_ENDS_SHARE * len(record)))
