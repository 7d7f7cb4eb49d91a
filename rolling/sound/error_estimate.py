"""Errors of band levels, from a signal of the same stretches on several levels of accuracy.

The signal is the release, or the approach of a vibration, which a linear chain carries to the
listener. All levels of accuracy see the same asperities. The ratio of their powers is therefore
known far better than either power. The module takes arrays and plain numbers; it marches nothing.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, stdtrit

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, BANDWIDTH_HZ, EDGES_HZ, NOMINAL_HZ, third_octave_mean_square
from acoustics.level import SoundLevels
from acoustics.weighting import a_weighting_db

# Limits of the order of convergence in an extrapolation, by trial on three scenes. Levels of whole
# tracks fell at orders from 1.1 to 2.5 from 2 um over 1 um to 0.5 um, where the three grids of an
# estimate, with 4 um, showed 1.7 to 2. A higher limit extrapolates less, and understated the error
# of the scene with 1.3; `DOUBT` covers the other scenes.
ORDER_LIMITS = 0.5, 1.5
DOUBT = 0.5  # standard uncertainty of the part that is extrapolated, over this part
# Limits for the signal. From 2 um on it fell at orders of 1.5 and more on all scenes of the study.
SIGNAL_ORDERS = 1.0, 2.0
DEFAULT_ORDER = 1.0  # the order where it cannot be measured, and that of missing detail
SHARED_UP_TO_HZ = 800.0  # bands up to this one share an estimate, because a stretch is short
MIN_LINES = 2  # minimum number of lines of a stretch in a band with its own estimate
# Lines of a transform with a Hann window over independent lines: the power of a line is correlated
# by 4/9 with its neighbours and by 1/36 with the lines after them, 1 + 2 (4/9 + 1/36).
HANN_LINES = 35 / 18
GAIN_POINTS = 16  # frequencies of a band at which a gain is averaged
REPLACED_LINES = 24  # minimum number of lines of a group of bands where a surface is replaced
REPLACED_POINTS = 128  # of them where a surface is replaced, so that none misses a resonance
JUDGED_HZ = 1000.0, 16000.0  # bands whose standard error is judged
SOUND_SHARE = 1e-4  # a band with less than this share of the fluctuation carries no sound
_FIRST_LINE = 2  # below this line the Hann window mixes the mean into the lines
# Rows of the sums: powers of three levels,
_OWN = 0
_TIGHT = 1
_FINE = 2
# powers of the differences between two levels,
_SOLVER = 3  # own and tight
_GRID = 4  # tight and fine
_COARSE = 5  # coarse and tight
# and the common power of the differences `_COARSE` and `_GRID`.
_COMMON = 6
_ROWS = 7


Gain = Callable[[Array], Array]  # power gain over frequency [Hz]


@dataclass(frozen=True)
class StretchSignals:
    """Release or approach of the same stretches of track on several levels of accuracy.

    own, tight, fine, coarse : (stretches, steps) arrays, J or m. Release per step or approach on
        the scene's grid at its tolerance, on this grid at the tight tolerance, at half the spacing
        and the tight tolerance, and at twice the spacing.
    step : float, m. Length of a step.
    speeds : (stretches, passes) array, m/s. Mean speed at each pass over a stretch; 0: no pass.
    tolerance_ratio : float. Tight tolerance over the scene's tolerance; 1: they are equal.
    gain : callable. Power gain from an approach to the sound. Default: the signals are releases.
    """

    own: Array
    tight: Array
    fine: Array
    coarse: Array
    step: float
    speeds: Array
    tolerance_ratio: float
    gain: Gain | None = None

    def power(self, speed: float, frequency: Array, squares: Array) -> Array:
        """Return the sound's third octaves of lines over frequency at a speed, over time."""
        # The power of a release goes with the square of the speed, the time with its inverse.
        if self.gain is None:
            return speed * third_octave_mean_square(frequency, squares)
        return third_octave_mean_square(frequency, squares * self.gain(frequency)) / speed


@dataclass(frozen=True)
class BandPowers:
    """Powers of the signal and of differences between levels of accuracy, by band.

    sums : (stretches, 7, bands) array. Mean squares over the passes, weighted by their speed.
    lines : (bands,) array. Number of lines of a stretch at the typical speed.
    white : (bands,) array. Power gain to the sound, the mean over each band; 1 for a release.
    groups : tuple of tuples of int. Numbers of the bands that share an estimate.
    tolerance_ratio : float. As in `StretchSignals`.
    """

    sums: Array
    lines: NDArray[np.int64]
    white: Array
    groups: tuple[tuple[int, ...], ...]
    tolerance_ratio: float


@dataclass(frozen=True)
class RecordLevels:
    """Band powers of the record that is reported, as far as its errors depend on them.

    z, a : (bands,) arrays. Unweighted and A-weighted mean squares; NaN for a band without a level.
    own_factor : bool. If true, the record's own fluctuation sets its factor to sound pressure, so
        that half the error of its total level cancels.
    seconds : float, s. Time in which the record does not repeat itself. Default: a long record.
    """

    z: Array
    a: Array
    own_factor: bool
    seconds: float = math.inf

    @classmethod
    def of(cls, levels: SoundLevels, own_factor: bool, seconds: float) -> Self:
        """Make the powers from the band levels of a record."""
        return cls(
            z=_mean_squares(levels.third_octave_db),
            a=_mean_squares(levels.third_octave_a_db),
            own_factor=own_factor,
            seconds=seconds,
        )


def _mean_squares(levels_db: dict[str, float | None]) -> Array:
    """Return mean squares over the reference from levels [dB] by band, NaN for a missing level."""
    return np.array([np.nan if db is None else 10 ** (db / 10) for db in levels_db.values()])


class LevelErrors(NamedTuple):
    """Errors of levels and of the signal. An error is the reported value less the true value.

    The errors of levels are arrays [dB] over the bands, with LAeq at their end; NaN: unknown.
    """

    order: float  # of convergence, which extrapolates to infinitely fine grids
    order_measured: bool  # if false, the order is the default, because a level equals another
    grid_db: Array
    grid_uncertainty_db: Array  # standard uncertainty of the former
    solver_db: Array
    grid_signal_db: float  # rms error of the signal from the grid over its rms fluctuation
    grid_signal_uncertainty_db: float  # standard uncertainty of the former
    solver_signal_db: float


# ---- powers


def band_powers(signals: StretchSignals) -> BandPowers:
    """Sum the line powers of all levels to third octaves, stretch by stretch."""
    own = _spectrum(signals.own)
    tight = _spectrum(signals.tight)
    fine = _spectrum(signals.fine)
    coarse = _spectrum(signals.coarse)
    stretches, lines_of_stretch = own.shape
    powers = np.empty((stretches, _ROWS, lines_of_stretch))
    powers[:, _OWN] = np.abs(own) ** 2
    powers[:, _TIGHT] = np.abs(tight) ** 2
    powers[:, _FINE] = np.abs(fine) ** 2
    powers[:, _SOLVER] = np.abs(own - tight) ** 2
    powers[:, _GRID] = np.abs(tight - fine) ** 2
    powers[:, _COARSE] = np.abs(coarse - tight) ** 2
    powers[:, _COMMON] = np.real((coarse - tight) * (tight - fine).conj())
    length = signals.own.shape[1] * signals.step
    waves = np.arange(_FIRST_LINE, lines_of_stretch) / length  # per metre
    sums = np.zeros((stretches, _ROWS, len(BAND_NAMES)))
    for stretch in range(stretches):
        speeds = signals.speeds[stretch]
        different_speeds, passes = np.unique(speeds[speeds > 0], return_counts=True)
        for speed, count in zip(different_speeds, passes, strict=True):
            for row in range(_ROWS):
                squares = powers[stretch, row, _FIRST_LINE:]
                sums[stretch, row] += count * signals.power(speed, speed * waves, squares)
    moving = signals.speeds[signals.speeds > 0]
    typical_speed = np.median(moving) if len(moving) else 0.0
    frequency = waves * typical_speed
    lines_of_bands = np.histogram(frequency, np.asarray(EDGES_HZ))[0]
    loud = int(np.flatnonzero(sums[:, _FINE].sum(axis=0)).max(initial=-1))
    groups = _groups(lines_of_bands, loud + 1)
    return BandPowers(
        sums=sums,
        lines=lines_of_bands,
        white=_mean_gain(signals.gain),
        groups=groups,
        tolerance_ratio=signals.tolerance_ratio,
    )


def _mean_gain(gain: Gain | None, points: int = GAIN_POINTS) -> Array:
    """Return the mean power gain of each band, 1 for a release."""
    if gain is None:
        return np.ones(len(BAND_NAMES))
    within = (np.arange(points) + 0.5) / points
    low = np.asarray(EDGES_HZ[:-1])
    width = np.asarray(BANDWIDTH_HZ)
    frequency = low[:, None] + width[:, None] * within
    gains = np.asarray(gain(frequency.ravel())).reshape(frequency.shape)
    return np.asarray(gains.mean(axis=1))


def _spectrum(values: Array) -> NDArray[np.complex128]:
    """Return the transforms of stretches about their means, with a Hann window."""
    steps = values.shape[1]
    hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(steps) / steps)
    return np.fft.rfft((values - values.mean(axis=1, keepdims=True)) * hann, axis=1)


def _groups(lines: NDArray[np.int64], bands: int) -> tuple[tuple[int, ...], ...]:
    """Group the first bands so that each group has enough lines; the low bands form a group."""
    groups = list[tuple[int, ...]]()
    group = list[int]()
    for band in range(bands):
        group.append(band)
        if NOMINAL_HZ[band] >= SHARED_UP_TO_HZ and lines[group].sum() >= MIN_LINES:
            groups.append(tuple(group))
            group = []
    if group:  # the steps end within a band, so the rest joins the group before it
        if groups:
            group = [*groups.pop(), *group]
        groups.append(tuple(group))
    return tuple(groups)


# ---- errors


def detail_errors(powers: BandPowers, record: RecordLevels) -> Array:
    """Estimate the errors of a record from stretches without (own) and with detail (fine).

    The detail of a law below the spacing is missing. Each further octave of detail adds half as
    much, as the heights of an exponential law do in power. The few stretches count by their lines,
    because a jackknife needs more of them. The rows are the errors of the bands and of LAeq, and
    their standard uncertainties, (2, bands + 1) [dB].
    """
    errors, _ = _reported(powers.sums.sum(axis=0), powers, record)
    spread = np.sqrt(_line_scatter(powers, record).of_error)
    doubt = DOUBT * (1.0 - 1.0 / refinement_factor(DEFAULT_ORDER))
    return np.stack([errors, np.hypot(spread, doubt * errors)])


def replaced_errors(
    powers: BandPowers, own_factor: bool, factor: float, gain: Gain | None = None
) -> Array:
    """Return the errors of levels from stretches of a surface (own) and of another one (fine).

    Parameters
    ----------
    powers : BandPowers. Powers of the signals over both surfaces on the same grid, without a gain.
    own_factor : bool. As in `RecordLevels`.
    factor : float. Whole error over the difference on this grid; 1 if the grid holds all of it.
    gain : callable. Power gain from the signals to the sound. Its mean over a band counts, because
        the few lines of stretches may miss a sharp resonance. Default: none.

    Returns
    -------
    (2, bands + 1) array, dB
        Errors of the bands and of LAeq, and their standard uncertainties by a jackknife over the
        stretches. NaN: no sound.
    """
    white = _mean_gain(gain, REPLACED_POINTS)
    weights = 10 ** (a_weighting_db(np.array(NOMINAL_HZ)) / 10)

    groups = _wide_groups(powers)

    def errors(total: Array) -> Array:
        """Return the errors of the bands and of LAeq for sums over some stretches."""
        power = total[_FINE] * white
        difference = np.full(len(BAND_NAMES), np.nan)
        for group in groups:
            own, fine = total[[_OWN, _FINE]][:, group]
            solved = (own > 0) & (fine > 0)
            if solved.any():
                # The mean of logarithms favours neither surface, and no loud band.
                ratio = 10.0 * np.log10(own[solved] / fine[solved])
                lines = np.maximum(powers.lines[group][solved], 1)
                difference[group] = factor * np.average(ratio, weights=lines)
        known = np.where(np.isfinite(difference), power, np.nan)
        of_laeq = -_sum_error(known * weights, -difference)
        shift = 0.0
        if own_factor:
            shift = 0.5 * _sum_error(known, -difference)
        return np.append(difference, of_laeq) + shift

    value = errors(powers.sums.sum(axis=0))
    return np.stack([value, _jackknife(powers.sums, errors)])


def _wide_groups(powers: BandPowers) -> list[list[int]]:
    """Join groups of bands until each has REPLACED_LINES lines in all stretches together."""
    wide = list[list[int]]()
    group = list[int]()
    for narrow in powers.groups:
        group += narrow
        if len(powers.sums) * powers.lines[group].sum() >= REPLACED_LINES:
            wide.append(group)
            group = []
    if group:
        if wide:
            wide[-1] = wide[-1] + group
        else:
            wide.append(group)
    return wide


def level_errors(powers: BandPowers, record: RecordLevels) -> LevelErrors:
    """Estimate the errors of a record's levels and their standard errors.

    The part that the order extrapolates is in doubt by half.
    """
    total = powers.sums.sum(axis=0)
    order, measured = _order(total)
    grid, solver = _reported(total, powers, record)
    spread = _scatter(powers, record)
    spread[:-1] = np.hypot(spread[:-1], _not_shared(grid[:-1], spread[:-1], powers))
    doubt = DOUBT * (1.0 - 1.0 / refinement_factor(order))
    grid_signal = _grid_signal_db(total)
    grid_signal_spread = _jackknife(powers.sums, lambda part: np.array(_grid_signal_db(part)))
    extrapolated = grid_signal - _signal_db(total[_GRID], total[_FINE], 1.0)
    solver_factor = _solver_factor(powers.tolerance_ratio)
    return LevelErrors(
        order=order,
        order_measured=measured,
        grid_db=grid,
        grid_uncertainty_db=np.hypot(spread, doubt * np.abs(grid)),
        solver_db=solver,
        grid_signal_db=grid_signal,
        grid_signal_uncertainty_db=math.hypot(float(grid_signal_spread), DOUBT * extrapolated),
        solver_signal_db=_signal_db(total[_SOLVER], total[_TIGHT], solver_factor),
    )


def mean_error(own: Array, fine: Array) -> tuple[float, float]:
    """Return the relative error of a mean over stretches on a grid, and its standard uncertainty.

    It is extrapolated from the half spacing with the highest order. The means need not converge
    from one side, so the whole difference is in doubt.
    """
    if not (own.mean() > 0 and fine.mean() > 0):
        return math.nan, math.nan
    factor = refinement_factor(ORDER_LIMITS[1])
    means = np.stack([own, fine], axis=1)[:, :, None]
    with np.errstate(all="ignore"):  # the uncertainty is unknown if a single stretch yields
        logarithm = _jackknife(means, lambda part: factor * np.log(part[0] / part[1]))
    difference = math.log(own.mean() / fine.mean())
    ratio = math.exp(factor * difference)
    return ratio - 1.0, ratio * math.hypot(difference, float(logarithm[0]))


def worst_uncertainty_db(powers: BandPowers) -> float:
    """Return the maximum standard error [dB] of the bands of 1 to 16 kHz that carry sound.

    It is infinite if no band does.
    """
    bands = len(BAND_NAMES)
    flat = np.asarray(BANDWIDTH_HZ) * powers.white
    spread = _scatter(powers, RecordLevels(z=flat, a=flat, own_factor=False))[:bands]
    power = powers.sums[:, _FINE].sum(axis=0)
    nominal = np.array(NOMINAL_HZ)
    counts = (nominal >= JUDGED_HZ[0]) & (nominal <= JUDGED_HZ[1])
    counts &= (power > SOUND_SHARE * power.sum()) & np.isfinite(spread)
    if not counts.any():
        return math.inf
    return float(spread[counts].max(initial=0.0))


def _jackknife(sums: Array, numbers: Callable[[Array], Array]) -> Array:
    """Return widened standard errors of numbers from leaving out each stretch in turn."""
    return np.asarray(_widening(len(sums) - 1) * np.sqrt(_jackknife_variance(sums, numbers)))


def _jackknife_variance(sums: Array, numbers: Callable[[Array], Array]) -> Array:
    """Return variances of numbers from leaving out each stretch in turn."""
    count = len(sums)
    without_stretch = []
    for k in range(count):
        rest = np.delete(sums, k, axis=0).sum(axis=0)
        without_stretch.append(numbers(rest))
    return np.asarray((count - 1) * np.var(np.array(without_stretch), axis=0))


class _LineScatter(NamedTuple):
    """Variances of reported errors [dB2] if all lines are independent, and their basis.

    of_error, of_stretches : (bands + 1,) arrays. Variance of the estimated less the true error of
        the record, and that of the estimated error alone, of the bands and of LAeq.
    lines : float. Number of independent lines of all stretches and groups.
    """

    of_error: Array
    of_stretches: Array
    lines: float


def _scatter(powers: BandPowers, record: RecordLevels) -> Array:
    """Return the standard errors of bands and of LAeq [dB] from the choice of the stretches.

    The lines of the stretches and a jackknife over the stretches measure one variance. Each has
    its degrees of freedom, by which they are averaged: their ratio is one number of all groups, as
    the jackknife of a single group has only as many degrees as there are stretches, less one.
    """
    by_lines = _line_scatter(powers, record)
    jackknife = _jackknife_variance(powers.sums, lambda part: _reported(part, powers, record)[0])
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = jackknife / by_lines.of_stretches
    ratios = np.array([_first_known(ratio[list(group)]) for group in powers.groups])
    ratios = ratios[np.isfinite(ratios)]
    degrees_of_jackknife = len(powers.sums) - 1
    if not (degrees_of_jackknife and powers.groups and by_lines.lines):
        return np.full(len(BAND_NAMES) + 1, math.nan)
    degrees = by_lines.lines + degrees_of_jackknife * len(ratios)
    excess = by_lines.lines + degrees_of_jackknife * ratios.sum()
    scatter = np.full(len(BAND_NAMES) + 1, _widening(degrees) * math.sqrt(excess / degrees))
    if np.isfinite(ratio[-1]):  # bands that scatter together show in LAeq alone
        degrees += degrees_of_jackknife
        excess += degrees_of_jackknife * ratio[-1]
        scatter[-1] = _widening(degrees) * math.sqrt(excess / degrees)
    return np.asarray(scatter * np.sqrt(by_lines.of_error))


def _first_known(values: Array) -> float:
    """Return the first finite value; NaN without one."""
    finite = values[np.isfinite(values)]
    return float(finite[0]) if len(finite) else math.nan


def _line_scatter(powers: BandPowers, record: RecordLevels) -> _LineScatter:
    """Return the variances of errors if all lines are independent.

    The power of n independent lines plus independent differences of a share e of it scatters by
    sqrt(2 e / n): once in the stretches, from which the error of a group follows, and once in each
    band of the record, whose own error it is. The stretches are part of the record, so both have
    their common lines in common. A gain that all lines share is no such difference.
    """
    total = powers.sums.sum(axis=0)
    bands = len(BAND_NAMES)
    factor = refinement_factor(_order(total)[0])
    own_factor = _whole_difference(total)
    in_decibels = (10 / math.log(10)) ** 2
    weights = _weights(record)
    of_stretches = np.zeros(bands + 1)
    of_error = np.zeros(bands + 1)
    all_lines = 0.0
    unknown = np.ones(bands, dtype=bool)
    for group in map(list, powers.groups):
        tight, fine, difference = total[[_TIGHT, _FINE, _GRID]][:, group].sum(axis=1)
        if not fine > 0:
            continue
        unknown[group] = False
        independent = max(0.0, difference - (math.sqrt(tight) - math.sqrt(fine)) ** 2)
        single = in_decibels * 2 * independent / fine  # variance of a single line
        lines = _independent_lines(total[_FINE, group], powers, group)
        all_lines += lines
        of_estimate = factor**2 * single / lines
        of_bands = own_factor**2 * single / _record_lines(powers, record, group)
        in_common = factor / own_factor * total[_FINE, group] / fine * of_bands
        own = weights[:, group]
        whole = own.sum(axis=1)
        of_stretches += whole**2 * of_estimate
        of_error += whole**2 * of_estimate + own**2 @ of_bands - 2 * whole * (own @ in_common)
    of_error[:-1][unknown] = np.nan
    return _LineScatter(np.maximum(of_error, 0.0), of_stretches, all_lines)


def _weights(record: RecordLevels) -> Array:
    """Return the weights of the bands' errors in the reported errors, (bands + 1, bands)."""
    a = np.nan_to_num(record.a)
    z = np.nan_to_num(record.z)
    a_share = a / (a.sum() or 1.0)
    z_share = z / (z.sum() or 1.0)
    weights = np.vstack([np.eye(len(BAND_NAMES)), a_share])
    if record.own_factor:
        weights = weights - 0.5 * z_share
    return weights


def _independent_lines(power: Array, powers: BandPowers, group: list[int]) -> float:
    """Return the number of independent lines of all stretches in a group, at least one.

    Differences between grids are as strong in all lines of a signal, so that the lines of a loud
    band decide over the scatter of the group.
    """
    lines = powers.lines[group]
    has_lines = lines > 0
    white = powers.white[group] * lines
    products = float(np.sum(power[has_lines] * white[has_lines] / lines[has_lines]))
    effective = 1.0
    if products > 0:
        effective = float(power.sum() * white.sum()) / products
    return max(1.0, len(powers.sums) * effective / HANN_LINES)


def _record_lines(powers: BandPowers, record: RecordLevels, group: list[int]) -> Array:
    """Return the number of lines of each band of a record that weigh as the lines of its group.

    Differences between grids are as strong in all lines of a signal. A line of the signal that is
    quieter than the lines that the stretches hold counts less. The sound of a vibration is divided
    by the gain first, because a quiet line of the sound may be a loud line of the approach.
    """
    z = record.z[group]
    white = powers.white[group] * np.asarray(BANDWIDTH_HZ)[group]
    count = np.maximum(np.asarray(BANDWIDTH_HZ)[group] * record.seconds, 1.0)
    has_sound = z > 0
    solved = has_sound & (powers.lines[group] > 0)
    if solved.any() and white[solved].sum() > 0:
        typical = z[solved].sum() / white[solved].sum()
        count[has_sound] *= z[has_sound] / white[has_sound] / typical
    return np.where(has_sound, count, math.inf)


def _whole_difference(total: Array) -> float:
    """Return the rms error of the signal over its difference to half the spacing."""
    if not (total[_GRID].sum() > 0 and total[_FINE].sum() > 0):
        return 1.0
    error = 10 ** (_grid_signal_db(total) / 10) * total[_FINE].sum() / total[_GRID].sum()
    return math.sqrt(error)


def _not_shared(errors: Array, spread: Array, powers: BandPowers) -> Array:
    """Return how far a band's own error may lie from the error of its group [dB].

    The error changes over a group as from this group to the next, less the scatter of both.
    """
    own_error_db = np.zeros(len(BAND_NAMES))
    groups = [list(group) for group in powers.groups]
    neighbours = [*pairwise(groups), *pairwise(groups[::-1])]
    for group, neighbour in neighbours:
        if len(group) > 1:
            k = group[0]
            n = neighbour[0]
            excess = (errors[k] - errors[n]) ** 2 - spread[k] ** 2 - spread[n] ** 2
            own_error_db[group] = np.fmax(own_error_db[group], math.sqrt(max(0.0, excess)))
    return own_error_db


def _widening(degrees: float) -> float:
    """Return Student's factor, with which twice a standard error holds 95 %; NaN for no degree."""
    if not degrees > 0:
        return math.nan
    return float(stdtrit(degrees, 0.975) / ndtri(0.975))


def _order(total: Array) -> tuple[float, bool]:
    """Return the order of convergence of the signal within its limits, and whether it is known."""
    coarse = float(total[_COARSE].sum())
    grid = float(total[_GRID].sum())
    if not (coarse > 0 and grid > 0):
        return DEFAULT_ORDER, False
    least, most = ORDER_LIMITS
    return float(np.clip(0.5 * math.log2(coarse / grid), least, most)), True


def refinement_factor(order: float) -> float:
    """Return the whole error over the difference between a grid and half its spacing."""
    return 1.0 / (1.0 - math.exp2(-order))


def _grid_signal_db(total: Array) -> float:
    """Return the rms error of the signal from the grid over its rms fluctuation [dB].

    On three grids whose errors fall by a factor r, a common shape a and independent errors b leave
    a coarse difference (a / r - a)^2 + (1 + 1 / r^2) b^2, a fine difference (a - r a)^2 + (1 + r^2)
    b^2, and in common (a - r a)^2 / r - b^2. The order extrapolates the common shape alone.
    """
    fine = float(total[_FINE].sum())
    grid = float(total[_GRID].sum())
    coarse = float(total[_COARSE].sum())
    common = float(total[_COMMON].sum())
    if not (fine > 0 and grid > 0):
        return math.nan
    least_order, highest_order = SIGNAL_ORDERS
    r = math.exp2(-least_order)
    if coarse > 0:
        r = min(max(math.sqrt(grid / coarse), math.exp2(-highest_order)), r)
    independent = min(max((grid - r * common) / (1 + r + r**2), 0.0), grid / (1 + r**2))
    shape = (grid - (1 + r**2) * independent) / (1 - r) ** 2
    return 10.0 * math.log10((shape + independent) / fine)


def _solver_factor(tolerance_ratio: float) -> float:
    """Return the whole error over its difference to the tight tolerance; NaN if both are equal.

    The error is proportional to the tolerance.
    """
    if tolerance_ratio >= 1.0:
        return math.nan
    return 1.0 / (1.0 - tolerance_ratio)


def _ratios(total: Array, powers: BandPowers) -> tuple[Array, Array]:
    """Return the errors of the power of each band [dB] from grid and solver."""
    factor = refinement_factor(_order(total)[0])
    of_solver = _solver_factor(powers.tolerance_ratio)
    grid = np.full(len(BAND_NAMES), np.nan)
    solver = np.full(len(BAND_NAMES), np.nan)
    for group in map(list, powers.groups):
        own, tight, fine = total[:3, group].sum(axis=1)
        if min(own, tight, fine) > 0:
            grid[group] = factor * 10.0 * math.log10(tight / fine)
            solver[group] = of_solver * 10.0 * math.log10(own / tight)
    return grid, solver


def _reported(total: Array, powers: BandPowers, record: RecordLevels) -> Array:
    """Return the errors of reported bands and of LAeq from grid and solver, (2, bands + 1) [dB]."""
    errors = []
    for error in _ratios(total, powers):
        shift = 0.0
        if record.own_factor:
            shift = -0.5 * _sum_error(record.z, error)
        bands = np.where(np.isnan(record.z), np.nan, error)
        errors.append(np.append(bands, _sum_error(record.a, error)) + shift)
    return np.array(errors)


def _sum_error(power: Array, error_db: Array) -> float:
    """Return the error of a sum of bands [dB] from the errors of its bands."""
    known = np.isfinite(power) & np.isfinite(error_db)
    true = float(np.sum(power[known] * 10.0 ** (-error_db[known] / 10.0)))
    return 10.0 * math.log10(float(power[known].sum()) / true) if true > 0 else math.nan


def _signal_db(difference: Array, signal: Array, factor: float) -> float:
    """Return an extrapolated rms difference over the rms of a signal [dB]; NaN: unknown."""
    if not (signal.sum() > 0 and difference.sum() > 0):
        return math.nan
    return 20.0 * math.log10(factor) + 10.0 * math.log10(float(difference.sum() / signal.sum()))
