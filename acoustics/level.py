"""Levels of a sound pressure record: equivalent, maximum with time weighting, in third octaves.

A level without sound is None, never -inf.
"""

import math
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array, finite, positive, refuse_masked, short_repr, truth
from acoustics.bands import BAND_NAMES, EDGES_HZ, third_octave_mean_square
from acoustics.radiation import P_REF_PA
from acoustics.resampling import resample_closed
from acoustics.spectrum import checked_record, line_spectrum
from acoustics.weighting import a_weighting_db

# A part 200 dB below the record counts as rounding. Transforms leave -300 dB, or -200 dB of a
# fluctuation that is 1e-5 of its mean. Hearing spans 130 dB, and no contact solve is better than
# 1e-10.
_ROUNDING = 1e-20

# Smaller mean squares count as silence, because numbers of 1e-308 and below lose their digits.
_SILENCE = 1e-280

_PEAK_OVERSAMPLING = 8

# A record is a single event if most of its energy falls into a small share of its time. Noise of
# any length has this energy in nearly as large a share of the time.
_MOST_ENERGY = 0.9
_EVENT_SHARE = 0.2

# IEC 61672-1:2013, 5.8: time constants of the time weightings F and S.
FAST_S = 0.125
SLOW_S = 1.0


@dataclass(frozen=True)
class RecordNumbers:
    """A number of dB for each level of a record; None where there is none."""

    __repr__ = short_repr

    laeq_db: float | None
    level_db: float | None
    laf_max_db: float | None
    las_max_db: float | None
    lz_peak_db: float | None
    third_octave_db: dict[str, float | None]


@dataclass(frozen=True, repr=False)
class SoundLevels(RecordNumbers):
    """Levels of one record, dB re 20 uPa; None where there is no sound.

    Parameters
    ----------
    laeq_db, level_db : float or None, dB
        LAeq and LZeq of the whole record.
    laf_max_db, las_max_db : float or None, dB
        LAFmax and LASmax, the maximum A-weighted level with time weighting Fast and Slow.
    lz_peak_db : float or None, dB
        LZpeak, the level of the maximum |p| at and between the samples.
    third_octave_db, third_octave_a_db : dict, dB
        Z and A levels by nominal mid frequency, "20" to "20000"; all 31 bands are always present.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import sound_levels
    >>> tone = np.sqrt(2) * np.sin(2 * np.pi * 100 * np.arange(48000) / 48000)  # 1 Pa rms, 100 Hz
    >>> round(sound_levels(tone, 48000).third_octave_a_db["100"], 2)
    74.84
    """

    third_octave_a_db: dict[str, float | None]


def level_db(mean_square: float, reference: float = P_REF_PA**2) -> float | None:
    """Return 10 lg(mean square / reference) in dB, or None if there is no sound (<= 0).

    Parameters
    ----------
    mean_square : float, Pa^2
        Mean square, or an intensity with its own reference.
    reference : float, Pa^2
        Reference. Default (20 uPa)^2; `I_REF_W_M2` for intensities.

    Returns
    -------
    float or None, dB

    Raises
    ------
    ValueError
        If the mean square is not finite, or the reference not above 0: an error upstream must pass
        neither as silence nor as a level.

    References
    ----------
    ISO 1683:2015 for the reference values.

    Examples
    --------
    >>> from acoustics import level_db
    >>> round(level_db(1.0), 2), level_db(0.0)
    (93.98, None)
    """
    finite("mean_square", mean_square)
    positive("reference", reference)
    if mean_square <= 0.0:
        return None
    return 10.0 * (math.log10(mean_square) - math.log10(reference))


def laeq_db(pressure_pa: Array, sample_rate_hz: float) -> float | None:
    """Return the A-weighted equivalent level LAeq of the whole record, or None for silence.

    The weighting is exact and works in the frequency domain. It has neither the settling time of a
    filter nor its error near the Nyquist frequency.

    Parameters
    ----------
    pressure_pa : array (n,), Pa
        Sound pressure; the record closes on itself or is faded.
    sample_rate_hz : float, Hz
        Sample rate.

    Returns
    -------
    float or None, dB re 20 uPa

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`.

    References
    ----------
    IEC 61672-1:2013, 3.9 and annex E.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import laeq_db
    >>> tone = np.sqrt(2) * np.sin(2 * np.pi * 100 * np.arange(48000) / 48000)  # 1 Pa rms, 100 Hz
    >>> round(laeq_db(tone, 48000), 2)  # 93.98 - 19.14
    74.84
    """
    return level_db(a_weighted_rms(pressure_pa, sample_rate_hz) ** 2)


def lae_db(pressure_pa: Array, sample_rate_hz: float) -> float | None:
    """Return the A-weighted sound exposure level LAE of the whole record, or None for silence.

    It is the level that the energy of the record would have if it lasted for one second: LAeq plus
    10 lg of the duration in seconds. Silence before or after an event does not change it, so events
    in records of different lengths are compared by it.

    Parameters
    ----------
    pressure_pa : array (n,), Pa
        Sound pressure; the record closes on itself or is faded.
    sample_rate_hz : float, Hz
        Sample rate.

    Returns
    -------
    float or None, dB re (20 uPa)^2 s

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`.

    References
    ----------
    IEC 61672-1:2013, 3.12; ISO 1996-1:2016, 3.1.8.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import lae_db
    >>> tone = np.sqrt(2) * np.sin(2 * np.pi * 1000 * np.arange(4800) / 48000)  # 0.1 s of 1 Pa rms
    >>> round(lae_db(tone, 48000), 1), round(lae_db(np.append(tone, np.zeros(4800)), 48000), 1)
    (84.0, 84.0)
    """
    mean_square = a_weighted_rms(pressure_pa, sample_rate_hz) ** 2
    return level_db(mean_square * len(pressure_pa) / sample_rate_hz)


def is_single_event(pressure_pa: Array, sample_rate_hz: float) -> bool:
    """Tell whether a record holds a single event, such as a knock, and little besides.

    It does if 90 % of its A-weighted energy falls into a fifth of its duration or less. Noise needs
    nearly 90 % of the time for it, and a few equal knocks all the time between them.

    Parameters
    ----------
    pressure_pa : array (n,), Pa
        Sound pressure; the record closes on itself or is faded.
    sample_rate_hz : float, Hz
        Sample rate.

    Returns
    -------
    bool. False for silence.

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import is_single_event
    >>> t = np.arange(4800) / 48000
    >>> tone = np.sin(2 * np.pi * 1000 * t)
    >>> is_single_event(tone * np.exp(-t / 0.005), 48000), is_single_event(tone, 48000)
    (True, False)
    """
    record = checked_record(pressure_pa, sample_rate_hz, "pressure_pa")
    energy = np.concatenate(([0.0], np.cumsum(np.square(a_weighted(record, sample_rate_hz)))))
    most = _MOST_ENERGY * energy[-1]
    if not most > 0.0:
        return False
    # From each sample on, the first sample at which most of the energy has passed.
    ends = np.searchsorted(energy, energy + most)
    lengths = (ends - np.arange(len(energy)))[ends < len(energy)]
    return bool(lengths.min(initial=len(record)) <= _EVENT_SHARE * len(record))


def a_weighted_rms(pressure_pa: Array, sample_rate_hz: float) -> float:
    """Return the A-weighted rms of the whole record, in its unit; 0 if it is only rounding."""
    pressure_pa = checked_record(pressure_pa, sample_rate_hz, "pressure_pa")
    frequency_hz, mean_square = line_spectrum(pressure_pa, sample_rate_hz)
    weighted = _a_weighted(frequency_hz, mean_square).sum()
    return math.sqrt(_above_rounding(weighted, mean_square.sum()))


def peak_pressure(pressure_pa: Array) -> float:
    """Return the maximum |p| of a record at and between its samples [Pa].

    The samples are interpolated 8-fold. The pressure between the interpolated points can exceed
    them by 0.01 dB at 5 kHz, and by 0.15 dB at the top of the audible band (at 48 kHz).

    Parameters
    ----------
    pressure_pa : array (n,), Pa. Sound pressure; the record closes on itself or is faded.

    Returns
    -------
    float, Pa
    """
    fine = resample_closed(pressure_pa, _PEAK_OVERSAMPLING * len(pressure_pa))
    return float(max(fine.max(), -fine.min()))


def crest_factor_db(pressure_pa: Array) -> float | None:
    """Return the peak of a record over its rms, both without weighting [dB]; None for silence.

    A sine has 3.0 dB, Gaussian noise 12 to 14 dB, and knocks have more.

    Parameters
    ----------
    pressure_pa : array (n,), Pa. Sound pressure; the record closes on itself or is faded.

    Returns
    -------
    float or None, dB
    """
    mean_square = float(np.mean(np.square(pressure_pa)))
    if mean_square == 0.0:
        return None
    return level_db(peak_pressure(pressure_pa) ** 2, mean_square)


def sound_levels(
    pressure_pa: Array, sample_rate_hz: float, highest_hz: float = math.inf, closed: bool = True
) -> SoundLevels:
    """Compute all levels of one record.

    ``level_db`` and ``laeq_db`` cover all lines of the record. Each A-weighted third octave is
    weighted line by line. The bands of a record limited to 20 Hz to 20 kHz therefore add up to
    these two levels.

    Parameters
    ----------
    pressure_pa : array (n,), Pa
        Sound pressure; the record closes on itself or is faded.
    sample_rate_hz : float, Hz
        Sample rate.
    highest_hz : float, Hz
        Highest frequency that the record resolves, for example the Nyquist frequency of its
        simulation. A band that reaches above it, or above the record's own Nyquist frequency, is
        None. Default infinity.
    closed : bool
        If true, the time weightings read the record as a loop; otherwise they start from silence.
        Default True.

    Returns
    -------
    SoundLevels, dB re 20 uPa
        A band without line power is None. Power below 1e-20 of the record's mean square (-200 dB)
        is rounding and counts as none.

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`, or if the mean square is not finite.

    References
    ----------
    IEC 61672-1:2013 for weightings, IEC 61260-1:2014 for third octaves. `acoustics/CONFORMANCE.md`
    has the deviations from both.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import sound_levels
    >>> tone = np.sqrt(2) * np.sin(2 * np.pi * 1000 * np.arange(48000) / 48000)  # 1 Pa rms
    >>> levels = sound_levels(tone, 48000)
    >>> round(levels.laf_max_db, 2), round(levels.lz_peak_db, 2)
    (93.98, 96.99)
    >>> round(levels.third_octave_db["1000"], 2)
    93.98
    """
    pressure_pa = checked_record(pressure_pa, sample_rate_hz, "pressure_pa")
    frequency_hz, mean_square = line_spectrum(pressure_pa, sample_rate_hz)
    weighted = _a_weighted(frequency_hz, mean_square)
    highest_hz = positive("highest_hz", highest_hz, infinite=True)
    closed = truth("closed", closed)
    whole = float(mean_square.sum())
    if whole < _SILENCE:
        return SoundLevels(
            laeq_db=None,
            level_db=None,
            laf_max_db=None,
            las_max_db=None,
            lz_peak_db=None,
            third_octave_db=dict.fromkeys(BAND_NAMES),
            third_octave_a_db=dict.fromkeys(BAND_NAMES),
        )
    known = EDGES_HZ[1:] <= min(highest_hz, sample_rate_hz / 2.0)

    def bands(line_mean_square: Array) -> dict[str, float | None]:
        """Return the level of each band from the mean squares of all lines."""
        squares = np.where(known, third_octave_mean_square(frequency_hz, line_mean_square), 0.0)
        levels: dict[str, float | None] = {}
        for name, square in zip(BAND_NAMES, squares, strict=True):
            levels[name] = level_db(_above_rounding(square, whole))
        return levels

    a_weighted_pa = a_weighted(pressure_pa, sample_rate_hz)

    def a_maximum(time_constant_s: float) -> float | None:
        """Return the maximum A-weighted level with a time weighting."""
        running = running_mean_square(a_weighted_pa, sample_rate_hz, time_constant_s, closed)
        return level_db(_above_rounding(float(running.max()), whole))

    return SoundLevels(
        laeq_db=level_db(_above_rounding(weighted.sum(), whole)),
        level_db=level_db(whole),
        laf_max_db=a_maximum(FAST_S),
        las_max_db=a_maximum(SLOW_S),
        lz_peak_db=level_db(peak_pressure(pressure_pa) ** 2),
        third_octave_db=bands(mean_square),
        third_octave_a_db=bands(weighted),
    )


def _a_weighted(frequency_hz: Array, line_mean_square: Array) -> Array:
    """Return the A-weighted mean squares of lines."""
    return line_mean_square * 10.0 ** (a_weighting_db(frequency_hz) / 10.0)


def _above_rounding(mean_square: float, whole: float) -> float:
    """Return the mean square of a part of a record, or 0 if it is rounding of the whole."""
    if mean_square > _ROUNDING * whole:
        return float(mean_square)
    return 0.0


# ---- time weighting


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
    refuse_masked("pressure_pa", pressure_pa)
    from scipy.linalg import blas  # slow to import

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
    refuse_masked("pressure_pa", pressure_pa)
    n = len(pressure_pa)
    gain = 10.0 ** (a_weighting_db(np.fft.rfftfreq(n, 1.0 / sample_rate_hz)) / 20.0)
    return np.fft.irfft(np.fft.rfft(pressure_pa) * gain, n)
