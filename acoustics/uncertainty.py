"""Standard uncertainty of levels from the length of the record. Depends on the other numeric modules here.

The record is taken for a stretch of stationary Gaussian noise: the uncertainty is the standard deviation of the level
over other stretches as long, e.g. other seeds of a surface. Errors of the model are not in it. First order in the
relative spread u of the mean square, 10/ln(10) u = 4.34 u dB: what is above 2 dB is more in truth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from acoustics.bands import BANDWIDTH_HZ, third_octave_mean_square
from acoustics.level import SoundLevels
from acoustics.spectrum import line_spectrum
from acoustics.time_weighting import FAST_S, SLOW_S
from acoustics.weighting import a_weighting_db

_DB = 10.0 / math.log(10.0)

# The density at 0 Hz is read off the lines below: enough of them to be known, low enough to be that of 0 Hz.
_NEAR_ZERO_HZ = 50.0
_FEWEST_LINES = 4


@dataclass(frozen=True)
class LevelUncertainty:
    """Standard uncertainty in dB of each level of `acoustics.level.SoundLevels`; None where that is None.

    Those of LAFmax and LASmax are upper bounds. ``third_octave_db`` goes by nominal mid frequency and holds for Z and A.
    """

    laeq_db: float | None
    level_db: float | None
    laf_max_db: float | None
    las_max_db: float | None
    lz_peak_db: float | None
    third_octave_db: dict[str, float | None]


def level_uncertainty(
    pressure_pa: np.ndarray, sample_rate_hz: float, levels: SoundLevels, own_factor: bool, laps: float = 1.0
) -> LevelUncertainty:
    """Standard uncertainty of the levels of one record.

    - LZeq, LAeq: 4.34/sqrt(N) with the number N of independent lines, 2 (sum P)^2 / (sum P^2) - 1, over their mean
      squares P (A-weighted for LAeq). The 2 because a line of Gaussian noise is exponentially distributed,
      E P^2 = 2 (E P)^2; the 1 because the same few lines stand in numerator and denominator: it makes N = M for M equal
      lines. At least 1 line.
    - third octaves: 4.34/sqrt(B T), see `acoustics.bands.band_uncertainty_db`.
    - LAFmax, LASmax: the spread of a single reading, an average over min(T, 2 tau) (exponential averaging over tau
      equals a block of 2 tau). An upper bound: the greatest of many readings spreads less than each of them.
    - LZpeak: of the greatest of N extremes of Gaussian noise (Gumbel), relatively pi/sqrt(6) / (2 (ln N + 0.577)), with
      N = 2 f T, f the rms frequency; and of LZeq. Cartwright and Longuet-Higgins (1956) for the extremes, Davenport
      (1964) for the greatest.

    A record that was given its level by the rms of its own fluctuation (`own_factor`) has the mean square X/sqrt(Z) in
    place of X, where Z is the mean square of that fluctuation: the spread of Z goes out by half. LZeq then spreads half
    as much, a narrow band hardly less than with a fixed factor.

    In simulations with N of ten or more what is stated holds within 15 %, for the peak within 20 % (a narrow band has
    fewer extremes than it seems: they come in groups), and LAFmax spreads down to 0.4 times its bound, and
    red noise once 9 % above it. Fades at the ends are not counted off: a tenth of the record at either end is 6 % more.

    Parameters
    ----------
    pressure_pa
        Sound pressure (n,), Pa; the record closes on itself or is faded.
    sample_rate_hz
        Sample rate, Hz.
    levels
        The levels of the record, from `acoustics.level.sound_levels`.
    own_factor
        The factor to sound pressure is the record's own, as `acoustics.radiation.sound_pressure` gives without a gain.
    laps
        How often the record repeats itself; the noise is one lap long.

    Raises
    ------
    ValueError
        As `acoustics.spectrum.check_record`.
    """
    if levels.level_db is None:
        return LevelUncertainty(None, None, None, None, None, dict.fromkeys(levels.third_octave_db))
    frequency_hz, z = line_spectrum(pressure_pa, sample_rate_hz)
    a = z * 10.0 ** (a_weighting_db(frequency_hz) / 10.0)
    duration_s = len(pressure_pa) / sample_rate_hz / laps
    exponent = 0.5 if own_factor else 0.0
    whole = _variance(z, z, exponent)
    laeq_db = laf_max_db = las_max_db = None
    if levels.laeq_db is not None:
        weighted, part = _variance(a, z, exponent), _variance(a, z, 0.0)

        def a_maximum_db(time_constant_s: float) -> float:
            # A reading is a part of the record: it varies with Z as the whole does, and by itself in addition.
            return _db(weighted + part * (duration_s / min(duration_s, 2.0 * time_constant_s) - 1.0))

        laeq_db, laf_max_db, las_max_db = _db(weighted), a_maximum_db(FAST_S), a_maximum_db(SLOW_S)
    share = third_octave_mean_square(frequency_hz, z) / z.sum()
    # The covariance of a band and the whole is the variance of the band times its share.
    bands = (1.0 - 2.0 * exponent * share) / (BANDWIDTH_HZ * duration_s) + exponent**2 * _variance(z, z, 0.0)
    return LevelUncertainty(
        laeq_db=laeq_db,
        level_db=_db(whole),
        laf_max_db=None if levels.laf_max_db is None else laf_max_db,
        las_max_db=None if levels.las_max_db is None else las_max_db,
        lz_peak_db=_db(whole + _peak_variance(frequency_hz, z, duration_s)),
        third_octave_db={
            name: None if level is None else _db(variance)
            for (name, level), variance in zip(levels.third_octave_db.items(), bands, strict=True)
        },
    )


def steady_uncertainty_db(power: np.ndarray, sample_rate_hz: float) -> float | None:
    """Standard uncertainty in dB of the level of a mean power, from the power's density at 0 Hz.

    The mean over T spreads as the lines next to 0 Hz do, whose mean squares are each twice its variance:
    u = sqrt(mean of P / 2) / mean over the lines up to 50 Hz, or the first four where these reach higher.

    Parameters
    ----------
    power
        Power (n,), or anything in proportion to it; one lap of a record that repeats itself.
    sample_rate_hz
        Sample rate, Hz.

    Returns
    -------
    Uncertainty, or None where the mean has no level (<= 0) or the record no line above 0 Hz.
    """
    mean = float(np.mean(power))
    frequency_hz, mean_square = line_spectrum(power, sample_rate_hz)
    lines = max(_FEWEST_LINES, int(np.searchsorted(frequency_hz, _NEAR_ZERO_HZ, side="right")) - 1)
    low = mean_square[1 : lines + 1]
    if mean <= 0.0 or not len(low):
        return None
    return _DB * math.sqrt(float(low.mean()) / 2.0) / mean


def _variance(part: np.ndarray, whole: np.ndarray, exponent: float) -> float:
    """Relative variance of sum(part) / sum(whole)**exponent, both over lines of Gaussian noise."""
    share, total = part / part.sum(), whole / whole.sum()
    # The few lines that the sums are made of make this too small by 1/N of it.
    few = float(np.sum(share**2)) / 2.0
    return float(np.sum(np.square(share - exponent * total))) / 2.0 / (1.0 - few)


def _peak_variance(frequency_hz: np.ndarray, mean_square: np.ndarray, duration_s: float) -> float:
    """Relative variance of the square of the greatest |p| over the mean square."""
    rms_hz = math.sqrt(float(np.sum(np.square(frequency_hz) * (mean_square / mean_square.sum()))))
    extremes = max(1.0, 2.0 * rms_hz * duration_s)
    return (math.pi / math.sqrt(6.0) / (math.log(extremes) + np.euler_gamma)) ** 2


def _db(variance: float) -> float:
    return _DB * math.sqrt(variance)
