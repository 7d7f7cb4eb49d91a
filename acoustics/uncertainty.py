"""Standard uncertainty of levels from the length of the record, and the kurtosis of a record.

The record counts as a stretch of stationary Gaussian noise. The uncertainty is the standard
deviation of the level over other stretches of the same length, for example over other seeds of a
surface. It holds no error of the model. `excess_variance` tells how far a record is from Gaussian.

The mean square of N equal lines of Gaussian noise has a gamma distribution. Its level has the
standard deviation 10/ln(10) sqrt(psi'(N)) dB with the trigamma function psi', which is 5.57 dB for
a single line and 4.34/sqrt(N) dB for many.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import polygamma

from acoustics.arrays import Array, instance, over_largest, truth, within
from acoustics.bands import EDGES_HZ, third_octave_mean_square
from acoustics.level import FAST_S, SLOW_S, RecordNumbers, SoundLevels, a_weighted
from acoustics.spectrum import checked_record, line_spectrum
from acoustics.weighting import a_weighting_db

_DB = 10.0 / math.log(10.0)
# The lines below this frequency, or at least this many, give the density at 0 Hz.
_NEAR_ZERO_HZ = 50.0
_FEWEST_LINES = 4
MIN_LAPS = 1e-6  # repetitions in a record
MAX_LAPS = 1e12  # repetitions in a record
_LOWEST_LINES = 16  # of p^2, which tell its density at 0 Hz
_FEWEST_IN_BAND = 16  # lines of a third octave whose excess variance is known
_STUDENT = 1.32  # 68 % of Student's distribution with two degrees of freedom lie within it


@dataclass(frozen=True, repr=False)
class LevelUncertainty(RecordNumbers):
    """Standard uncertainty of each level of `SoundLevels`, dB; None where the level is None.

    - LZeq, LAeq, third octaves: 4.34 sqrt(psi'(N)) with the number N of independent lines,
      2 (sum P)^2 / (sum P^2) - 1, over their mean squares P (A-weighted for LAeq; the lines of
      the band for a third octave). The factor 2 follows from the exponential distribution of a
      line of Gaussian noise, E P^2 = 2 (E P)^2. The 1 accounts for the same few lines in numerator
      and denominator; it makes N = M for M equal lines. N is at least 1. In an even spectrum N is
      B T; a resonance leaves fewer lines.
    - LAFmax, LASmax: the spread of a single reading, an average over min(T, 2 tau), because
      exponential averaging over tau equals a block of 2 tau. This is an upper bound: the maximum of
      many readings spreads less than each of them.
    - LZpeak: the spread of the maximum of N extremes of Gaussian noise (Gumbel), relatively
      pi/sqrt(6) / (2 (ln N + 0.577)) with N = 2 f T and the rms frequency f, combined with LZeq.

    Parameters
    ----------
    laeq_db, level_db, laf_max_db, las_max_db, lz_peak_db : float or None, dB
        As in `SoundLevels`.
    third_octave_db : dict, dB
        Uncertainty by nominal mid frequency; it holds for Z and A levels.

    Examples
    --------
    >>> import numpy as np, acoustics
    >>> noise = np.random.default_rng(1).standard_normal(48000)
    >>> levels = acoustics.sound_levels(noise, 48000)
    >>> round(acoustics.level_uncertainty(noise, 48000, levels, own_factor=False).level_db, 2)
    0.03
    """

    def mapped(self, change: Callable[[float], float | None]) -> Self:
        """Return the uncertainties with a change to each that is known."""

        def changed(values: dict[str, float | None]) -> dict[str, float | None]:
            return {name: None if db is None else change(db) for name, db in values.items()}

        whole = {**vars(self)}
        bands = changed(whole.pop("third_octave_db"))
        return type(self)(**changed(whole), third_octave_db=bands)


def level_uncertainty(
    pressure_pa: Array,
    sample_rate_hz: float,
    levels: SoundLevels,
    own_factor: bool,
    laps: float = 1.0,
) -> LevelUncertainty:
    """Compute the standard uncertainty of the levels of one record.

    `LevelUncertainty` says how the uncertainty of each level is derived.

    A record whose level follows from the rms of its own fluctuation (`own_factor`) has the mean
    square X/sqrt(Z) in place of X, where Z is the mean square of that fluctuation. The spread of Z
    then cancels by half: LZeq spreads half as much, a narrow band hardly less than with a fixed
    factor.

    In simulations with N of three or more these values hold within 15 %, for the peak within 20 %
    because the extremes of a narrow band come in groups. LAFmax spreads down to 0.4 times its
    bound, and red noise once 9 % above it. Fades at the ends are not deducted: a tenth of the
    record at either end adds 6 %.

    Parameters
    ----------
    pressure_pa : array (n,), Pa
        Sound pressure; the record closes on itself or is faded.
    sample_rate_hz : float, Hz
        Sample rate.
    levels : SoundLevels
        Levels of the record, from `sound_levels`.
    own_factor : bool
        If true, the factor to sound pressure is the record's own, as `sound_pressure` gives it
        without a gain.
    laps : float
        Number of repetitions in the record; the noise is one lap long. Default 1.

    Returns
    -------
    LevelUncertainty, dB

    Raises
    ------
    ValueError
        As `acoustics.spectrum.checked_record`.

    References
    ----------
    Bendat and Piersol, Random Data, 4th ed. 2010, chapter 8. Cartwright and Longuet-Higgins,
    Proceedings of the Royal Society A 1956, 237, 212-232, for the extremes. Davenport, Proceedings
    of the Institution of Civil Engineers 1964, 28(2), 187-196, for their maximum.

    Examples
    --------
    >>> import numpy as np
    >>> from acoustics import level_uncertainty, sound_levels
    >>> noise = np.random.default_rng(1).standard_normal(48000)  # 1 s of 24,000 lines
    >>> spread = level_uncertainty(noise, 48000, sound_levels(noise, 48000), own_factor=False)
    >>> round(spread.level_db, 2), round(spread.third_octave_db["1000"], 2)
    (0.03, 0.28)
    """
    pressure_pa = checked_record(pressure_pa, sample_rate_hz, "pressure_pa")
    instance("levels", levels, SoundLevels)
    laps = within("laps", laps, MIN_LAPS, MAX_LAPS)
    own_factor = truth("own_factor", own_factor)
    if levels.level_db is None:
        return LevelUncertainty(
            laeq_db=None,
            level_db=None,
            laf_max_db=None,
            las_max_db=None,
            lz_peak_db=None,
            third_octave_db=dict.fromkeys(levels.third_octave_db),
        )
    duration_s = len(pressure_pa) / sample_rate_hz / laps
    frequency_hz, z = line_spectrum(pressure_pa, sample_rate_hz)
    frequency_hz, z = _lines_of_a_lap(frequency_hz, z, laps)
    exponent = 0.5 if own_factor else 0.0
    whole = _variance(z, z, exponent)
    laeq_db = None
    laf_max_db = None
    las_max_db = None
    if levels.laeq_db is not None:
        a = z * 10.0 ** (a_weighting_db(frequency_hz) / 10.0)
        weighted = _variance(a, z, exponent)
        own = _variance(a, z, 0.0)
        laeq_db = _db(weighted)
        # A reading is a part of the record: it varies with Z as the whole does, and on its own.
        if levels.laf_max_db is not None:
            readings = duration_s / min(duration_s, 2.0 * FAST_S)
            laf_max_db = _db(weighted + own * (readings - 1.0))
        if levels.las_max_db is not None:
            readings = duration_s / min(duration_s, 2.0 * SLOW_S)
            las_max_db = _db(weighted + own * (readings - 1.0))
    bands: dict[str, float | None] = dict.fromkeys(levels.third_octave_db)
    variances = _band_variances(frequency_hz, z, exponent)
    for (name, level), variance in zip(levels.third_octave_db.items(), variances, strict=True):
        if level is not None:
            bands[name] = _db(variance)
    return LevelUncertainty(
        laeq_db=laeq_db,
        level_db=_db(whole),
        laf_max_db=laf_max_db,
        las_max_db=las_max_db,
        lz_peak_db=_db(whole + _peak_variance(frequency_hz, z, duration_s)),
        third_octave_db=bands,
    )


def uncertainty_of_lines_db(mean_square: Array) -> float:
    """Return the standard uncertainty of the level of lines of Gaussian noise [dB].

    Parameters
    ----------
    mean_square : array (n,), any unit. Mean squares of the lines of a record, not all zero.
    """
    return _db(_variance(mean_square, mean_square, 0.0))


class ExpectedUncertainty(NamedTuple):
    """Standard uncertainties of levels that a record of a known spectrum is going to have.

    laeq_db : float, dB. Of LAeq.
    third_octave_db : (31,) array, dB. Of the third octaves; that of a single line without any.
    """

    laeq_db: float
    third_octave_db: Array


def expected_uncertainty(frequency_hz: Array, mean_square: Array) -> ExpectedUncertainty:
    """Return the uncertainty of levels before there is a record, from the spectrum of its noise.

    The variances are those of `level_uncertainty`. There the mean squares of lines are random, and
    here they are expected values, so N equal lines need no correction: N = (sum P)^2 / sum P^2.

    Parameters
    ----------
    frequency_hz : array (n,), Hz. Frequencies of the lines of the record.
    mean_square : array (n,), any unit. Expected mean squares of the lines, not all zero.
    """
    weighted = mean_square * 10.0 ** (a_weighting_db(frequency_hz) / 10.0)
    weighted = weighted / weighted.sum()
    count = np.maximum(1.0, 1.0 / np.array([np.sum(np.square(weighted))]))
    share = third_octave_mean_square(frequency_hz, weighted)
    squares = third_octave_mean_square(frequency_hz, np.square(weighted))
    in_band = np.ones(len(share))
    loud = squares > 0.0
    in_band[loud] = np.maximum(np.square(share[loud]) / squares[loud], 1.0)
    return ExpectedUncertainty(
        laeq_db=_db(float((_of_few_lines(count) / count)[0])),
        third_octave_db=_DB * np.sqrt(_of_few_lines(in_band) / in_band),
    )


def steady_uncertainty_db(power: Array, sample_rate_hz: float) -> float | None:
    """Return the standard uncertainty of the level of a mean power, from its density at 0 Hz [dB].

    The mean over T spreads like the lines next to 0 Hz, whose mean squares are each twice its
    variance: u = sqrt(mean of P / 2) / mean, over the lines up to 50 Hz or the first four if they
    reach higher.

    Parameters
    ----------
    power : array (n,), any unit. Power; one lap of a record that repeats itself.
    sample_rate_hz : float, Hz. Sample rate.

    Returns
    -------
    float or None, dB
        None if the mean has no level (<= 0) or the record has no line above 0 Hz.
    """
    mean = float(np.mean(power))
    frequency_hz, mean_square = line_spectrum(power, sample_rate_hz)
    lines = max(_FEWEST_LINES, int(np.searchsorted(frequency_hz, _NEAR_ZERO_HZ, side="right")) - 1)
    low = mean_square[1 : lines + 1]
    if mean <= 0.0 or not len(low):
        return None
    return _DB * math.sqrt(float(low.mean()) / 2.0) / mean


def record_scatter_db(
    pressure_pa: Array, sample_rate_hz: float, weighted: bool = True
) -> float | None:
    """Return the standard uncertainty of LAeq [dB] that the thirds of a record show.

    Unless it is `weighted`, it is that of the level without A-weighting. The mean squares of three
    thirds estimate the spread of their mean without a law for the noise. Three values estimate a
    spread poorly, so it is widened for the same probability of 68 %. It is None for silence, and
    for a record of fewer than three samples.
    """
    record = a_weighted(pressure_pa, sample_rate_hz) if weighted else pressure_pa
    thirds = np.array_split(np.square(record), 3)
    if not len(thirds[-1]) or not np.any(pressure_pa):
        return None
    squares = np.array([third.mean() for third in thirds])
    return _STUDENT * _DB * float(squares.std(ddof=1) / math.sqrt(3.0) / squares.mean())


class ExcessVariance(NamedTuple):
    """Variances of mean squares over those of Gaussian noise with the same spectrum; 1 or more.

    laeq, level : float. Of the mean square with and without A-weighting.
    third_octave : (31,) array. Of the third octaves; 1 in those of fewer than 16 lines.
    """

    laeq: float
    level: float
    third_octave: Array


def excess_variance(pressure_pa: Array, sample_rate_hz: float) -> ExcessVariance:
    """Return how much more the mean squares of a closed record vary than those of Gaussian noise.

    The mean of p^2 differs between stretches as much as the lines of p^2 next to 0 Hz are strong.
    Its line n is the sum of all products of two lines of p that are n lines apart. The lines of
    Gaussian noise are independent, so the square of this sum is that of its addends. If the
    strength of a noise changes along the record, its lines depend on each other, and the sum is
    larger. Its ratio is taken over the 16 lowest lines of p^2, which count the less the farther
    they are from 0 Hz, so it is known to some 40 %.
    """
    pressure = over_largest(pressure_pa, of_silence=math.nan)
    frequency_hz = np.fft.rfftfreq(len(pressure), 1.0 / sample_rate_hz)
    line = np.fft.rfft(pressure)
    line[0] = 0.0
    weighted = line.copy()
    weighted[1:] *= 10.0 ** (a_weighting_db(frequency_hz[1:]) / 20.0)
    edges = np.searchsorted(frequency_hz, EDGES_HZ)
    bands = []
    for first, last in pairwise(edges):
        # Half of the lines of a narrow band leave enough pairs.
        lowest = min(_LOWEST_LINES, (last - first) // 2)
        is_known = last - first >= _FEWEST_IN_BAND
        bands.append(_excess_of_lines(line[first:last], lowest) if is_known else 1.0)
    return ExcessVariance(
        laeq=_excess_of_lines(weighted, _LOWEST_LINES),
        level=_excess_of_lines(line, _LOWEST_LINES),
        third_octave=np.array(bands),
    )


def _excess_of_lines(line: NDArray[np.complex128], lowest: int) -> float:
    """Return the excess of the lowest lines of the square of a record with these lines."""
    variance = 0.0
    of_gaussian_noise = 0.0
    for lag in range(1, min(lowest, len(line) - 1) + 1):
        products = line[lag:] * line[:-lag].conj()
        variance += float(np.square(np.abs(products.sum()))) / lag
        of_gaussian_noise += float(np.square(np.abs(products)).sum()) / lag
    if not of_gaussian_noise > 0.0:
        return 1.0
    return max(1.0, variance / of_gaussian_noise)


def with_excess(spreads: LevelUncertainty, excess: ExcessVariance) -> LevelUncertainty:
    """Return uncertainties of Gaussian noise with the excess variance of their record."""
    widened_by_laeq = spreads.mapped(lambda db: db * math.sqrt(excess.laeq))
    bands: dict[str, float | None] = {}
    for (name, db), ratio in zip(spreads.third_octave_db.items(), excess.third_octave, strict=True):
        bands[name] = None if db is None else db * math.sqrt(ratio)
    level_db = spreads.level_db
    if level_db is not None:
        level_db *= math.sqrt(excess.level)
    return replace(widened_by_laeq, level_db=level_db, third_octave_db=bands)


def widened(spreads: LevelUncertainty, laeq_db: float | None) -> LevelUncertainty:
    """Return uncertainties that are widened by one factor, LAeq to at least a value [dB]."""
    if laeq_db is None or not spreads.laeq_db or laeq_db <= spreads.laeq_db:
        return spreads
    factor = laeq_db / spreads.laeq_db
    return spreads.mapped(lambda db: factor * db)


def _lines_of_a_lap(frequency_hz: Array, mean_square: Array, laps: float) -> tuple[Array, Array]:
    """Return frequencies [Hz] and mean squares of lines that are as far apart as those of a lap.

    A record of several laps has more lines than its noise has independent ones.
    """
    if laps <= 1.0:
        return frequency_hz, mean_square
    line_of_lap = np.rint(np.arange(len(mean_square)) / laps).astype(int)
    joined = np.asarray(np.bincount(line_of_lap, weights=mean_square), dtype=float)
    return np.asarray(np.arange(len(joined)) * (frequency_hz[1] * laps), dtype=float), joined


def _variance(part: Array, whole: Array, exponent: float) -> float:
    """Return the variance of the logarithm of sum(part) / sum(whole)**exponent.

    The sums run over lines of Gaussian noise.
    """
    share = part / part.sum()
    total = whole / whole.sum()
    count = _independent_lines(1.0, float(np.sum(share**2)))
    # This is too small by 1/N for sums of few lines.
    few = float(np.sum(share**2)) / 2.0
    first_order = float(np.sum(np.square(share - exponent * total))) / 2.0 / (1.0 - few)
    return first_order * float(_of_few_lines(count))


def _band_variances(frequency_hz: Array, mean_square: Array, exponent: float) -> Array:
    """Return the variance of the logarithm of each band over sum(mean_square)**exponent, (31,)."""
    total = mean_square.sum()
    share = third_octave_mean_square(frequency_hz, mean_square / total)
    squares = third_octave_mean_square(frequency_hz, np.square(mean_square / total))
    count = np.ones(len(share))
    loud = squares > 0.0
    count[loud] = _independent_lines(share[loud], squares[loud])
    # The covariance of a band and the whole is the variance of the band times its share.
    of_band = (1.0 - 2.0 * exponent * share) / count * _of_few_lines(count)
    return np.asarray(of_band + exponent**2 * _variance(mean_square, mean_square, 0.0))


def _independent_lines(total: ArrayLike, squares: ArrayLike) -> Array:
    """Return the number of independent lines from the sums of their mean squares P and of P^2."""
    return np.asarray(np.maximum(2.0 * np.square(total) / np.asarray(squares) - 1.0, 1.0))


def _of_few_lines(count: Array) -> Array:
    """Return the variance of the logarithm of a sum of equal lines over its first order, 1/N."""
    return np.asarray(count * polygamma(1, count))


def _peak_variance(frequency_hz: Array, mean_square: Array, duration_s: float) -> float:
    """Return the relative variance of the square of the maximum |p| over the mean square."""
    rms_hz = math.sqrt(float(np.sum(np.square(frequency_hz) * (mean_square / mean_square.sum()))))
    extremes = max(1.0, 2.0 * rms_hz * duration_s)
    return (math.pi / math.sqrt(6.0) / (math.log(extremes) + np.euler_gamma)) ** 2


def _db(variance: float) -> float:
    """Return the standard deviation of a level [dB] from the variance of its logarithm."""
    return _DB * math.sqrt(variance)


def kurtosis(record: Array) -> float:
    """Return the mean fourth power over the square of the mean square; NaN for silence.

    It is 3 for Gaussian noise, and larger for a record of single events.

    Parameters
    ----------
    record : array (n,), any unit
        Record without a mean.

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
    square = np.square(over_largest(record, of_silence=math.nan))
    return float(np.mean(np.square(square)) / np.mean(square) ** 2)


def kurtosis_uncertainty(record: Array) -> float:
    """Return the standard uncertainty of the kurtosis of Gaussian noise with a record's spectrum.

    A narrow band, and laps that repeat, leave fewer independent samples: the variance is 24/n times
    the sum of the fourth powers of the autocorrelation of n samples.

    Parameters
    ----------
    record : array (n,), any unit
        Record without a mean.

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
    power = np.square(np.abs(np.fft.rfft(over_largest(record, of_silence=math.nan))))
    correlation = np.fft.irfft(power, len(record))
    fourth = np.square(np.square(correlation / correlation[0]))
    return math.sqrt(24.0 * float(np.mean(fourth)))
