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
# Lines of a transform with a Hann window over independent lines.
HANN_LINES = 1.5
JUDGED_HZ = 1000.0, 16000.0  # bands whose standard error is judged
SOUND_SHARE = 1e-4  # a band with less than this share of the fluctuation carries no sound
_FIRST_LINE = 2  # below this line the Hann window mixes the mean into the lines
# Rows of the sums: powers of three levels, powers of the differences between two levels, and the
# common power of the differences between coarse and tight and between tight and fine.
_OWN, _TIGHT, _FINE, _SOLVER, _GRID, _COARSE, _COMMON = range(7)


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
    groups : tuple of tuples of int. Numbers of the bands that share an estimate.
    tolerance_ratio : float. As in `StretchSignals`.
    """

    sums: Array
    lines: NDArray[np.int64]
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
        z, a = (
            np.array([np.nan if x is None else 10 ** (x / 10) for x in db.values()])
            for db in (levels.third_octave_db, levels.third_octave_a_db)
        )
        return cls(z, a, own_factor, seconds)


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
    marches = signals.own, signals.tight, signals.fine, signals.coarse
    own, tight, fine, coarse = map(_spectrum, marches)
    spectra = own, tight, fine, own - tight, tight - fine, coarse - tight
    common = np.real((coarse - tight) * (tight - fine).conj())
    powers = np.stack([*(np.abs(lines) ** 2 for lines in spectra), common], axis=1)
    length = signals.own.shape[1] * signals.step
    waves = np.arange(_FIRST_LINE, powers.shape[2]) / length  # per metre
    sums = np.zeros((*powers.shape[:2], len(BAND_NAMES)))
    for stretch, lines, speeds in zip(sums, powers, signals.speeds, strict=True):
        for speed, passes in zip(*np.unique(speeds[speeds > 0], return_counts=True), strict=True):
            for row, squares in zip(stretch, lines[:, _FIRST_LINE:], strict=True):
                row += passes * signals.power(speed, speed * waves, squares)
    moving = signals.speeds[signals.speeds > 0]
    frequency = waves * (np.median(moving) if len(moving) else 0.0)
    lines_of_bands = np.histogram(frequency, np.asarray(EDGES_HZ))[0]
    loud = int(np.flatnonzero(sums[:, _FINE].sum(axis=0)).max(initial=-1))
    groups = _groups(lines_of_bands, loud + 1)
    return BandPowers(sums, lines_of_bands, groups, signals.tolerance_ratio)


def _spectrum(values: Array) -> NDArray[np.complex128]:
    """Return the transforms of stretches about their means, with a Hann window."""
    steps = values.shape[1]
    hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(steps) / steps)
    return np.fft.rfft((values - values.mean(axis=1, keepdims=True)) * hann, axis=1)


def _groups(lines: NDArray[np.int64], bands: int) -> tuple[tuple[int, ...], ...]:
    """Group the first bands so that each group has enough lines; the low bands form a group."""
    groups, group = list[tuple[int, ...]](), list[int]()
    for band in range(bands):
        group.append(band)
        if NOMINAL_HZ[band] >= SHARED_UP_TO_HZ and lines[group].sum() >= MIN_LINES:
            groups.append(tuple(group))
            group = []
    if group:  # the steps end within a band
        groups[-1:] = [(*(groups[-1] if groups else ()), *group)]
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
    widening = _widening(len(powers.sums))
    of_lines = _scatter(powers, math.inf) / widening
    share = np.nan_to_num(record.a * 10.0 ** (-errors[:-1] / 10.0))
    share /= share.sum() or 1.0
    laeq = math.hypot(*(of_lines[k[0]] * share[list(k)].sum() for k in powers.groups))
    spread = np.append(_scatter(powers, _record_lines(powers, record)) / widening, laeq)
    doubt = DOUBT * (1.0 - 1.0 / refinement_factor(DEFAULT_ORDER))
    return np.stack([errors, np.hypot(spread, doubt * errors)])


def level_errors(powers: BandPowers, record: RecordLevels) -> LevelErrors:
    """Estimate the errors of a record's levels and their standard errors.

    The part that the order extrapolates is in doubt by half.
    """
    total = powers.sums.sum(axis=0)
    order, measured = _order(total)
    grid, solver = _reported(total, powers, record)
    spread, _ = _jackknife(powers.sums, lambda part: _reported(part, powers, record))
    bands = np.hypot(spread[:-1], _scatter(powers, _record_lines(powers, record)))
    spread[:-1] = np.hypot(bands, _not_shared(grid[:-1], bands, powers))
    doubt = DOUBT * (1.0 - 1.0 / refinement_factor(order))
    signal = _grid_signal_db(total)
    signal_spread = _jackknife(powers.sums, lambda part: np.array(_grid_signal_db(part)))
    extrapolated = signal - _signal_db(total[_GRID], total[_FINE], 1.0)
    return LevelErrors(
        order,
        measured,
        grid,
        np.hypot(spread, doubt * np.abs(grid)),
        solver,
        signal,
        math.hypot(float(signal_spread), DOUBT * extrapolated),
        _signal_db(total[_SOLVER], total[_TIGHT], _solver_factor(powers.tolerance_ratio)),
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
    spread = _jackknife(powers.sums, lambda part: _ratios(part, powers)[0])
    spread = np.hypot(spread, _scatter(powers, math.inf))
    power, nominal = powers.sums[:, _FINE].sum(axis=0), np.array(NOMINAL_HZ)
    judged = (nominal >= JUDGED_HZ[0]) & (nominal <= JUDGED_HZ[1])
    judged &= (power > SOUND_SHARE * power.sum()) & np.isfinite(spread)
    return float(spread[judged].max(initial=0.0)) if judged.any() else math.inf


def _jackknife(sums: Array, numbers: Callable[[Array], Array]) -> Array:
    """Return widened standard errors of numbers from leaving out each stretch in turn."""
    count = len(sums)
    left_out = np.array([numbers(np.delete(sums, k, axis=0).sum(axis=0)) for k in range(count)])
    return np.asarray(_widening(count) * np.sqrt((count - 1) * np.var(left_out, axis=0)))


def _record_lines(powers: BandPowers, record: RecordLevels) -> Array:
    """Return the number of lines of each band of a record that weigh as the lines of its group.

    Differences of grids are as strong in all lines of a group, so a line that is quieter than the
    lines that the stretches hold counts less.
    """
    width = np.asarray(BANDWIDTH_HZ)
    count, density = width * record.seconds, record.z / width
    for group in map(list, powers.groups):
        seen = [band for band in group if powers.lines[band] and record.z[band] > 0]
        if seen:
            count[group] *= np.fmin(density[group] / np.mean(density[seen]), 1.0)
    return np.asarray(np.maximum(count, 1.0))


def _scatter(powers: BandPowers, record_lines: Array | float) -> Array:
    """Return the widened standard error of bands [dB] if differences of grids are independent.

    A jackknife over four stretches is often smaller by chance. The power of n independent lines
    plus independent differences of a share e of it scatters by sqrt(2 e / n), in the stretches and
    in the lines of a band of the record. A gain that all lines share is no such difference.
    """
    count, total = len(powers.sums), powers.sums.sum(axis=0)
    factor, spread = refinement_factor(_order(total)[0]), np.full(len(BAND_NAMES), np.nan)
    of_record = np.broadcast_to(record_lines, len(BAND_NAMES))
    for group in map(list, powers.groups):
        lines = max(1.0, count * powers.lines[group].sum() / HANN_LINES)
        tight, fine, difference = total[[_TIGHT, _FINE, _GRID]][:, group].sum(axis=1)
        if fine > 0:
            independent = max(0.0, difference - (math.sqrt(tight) - math.sqrt(fine)) ** 2)
            share = np.sqrt(2 * independent / fine * (1 / lines + 1 / of_record[group]))
            spread[group] = _widening(count) * factor * 10 / math.log(10) * share
    return spread


def _not_shared(errors: Array, spread: Array, powers: BandPowers) -> Array:
    """Return how far a band's own error may lie from the error of its group [dB].

    The error changes over a group as from this group to the next, less the scatter of both.
    """
    apart, groups = np.zeros(len(BAND_NAMES)), [list(group) for group in powers.groups]
    for group, other in [*pairwise(groups), *pairwise(groups[::-1])]:
        if len(group) > 1:
            k, n = group[0], other[0]
            excess = (errors[k] - errors[n]) ** 2 - spread[k] ** 2 - spread[n] ** 2
            apart[group] = np.fmax(apart[group], math.sqrt(max(0.0, excess)))
    return apart


def _widening(count: int) -> float:
    """Return Student's factor, with which twice a standard error holds 95 %; NaN for one."""
    return float(stdtrit(count - 1, 0.975) / ndtri(0.975)) if count > 1 else math.nan


def _order(total: Array) -> tuple[float, bool]:
    """Return the order of convergence of the signal within its limits, and whether it is known."""
    coarse, grid = float(total[_COARSE].sum()), float(total[_GRID].sum())
    if not (coarse > 0 and grid > 0):
        return DEFAULT_ORDER, False
    return float(np.clip(0.5 * math.log2(coarse / grid), *ORDER_LIMITS)), True


def refinement_factor(order: float) -> float:
    """Return the whole error over the difference between a grid and half its spacing."""
    return 1.0 / (1.0 - math.exp2(-order))


def _grid_signal_db(total: Array) -> float:
    """Return the rms error of the signal from the grid over its rms fluctuation [dB].

    On three grids whose errors fall by a factor r, a common shape a and independent errors b leave
    a coarse difference (a / r - a)^2 + (1 + 1 / r^2) b^2, a fine difference (a - r a)^2 + (1 + r^2)
    b^2, and in common (a - r a)^2 / r - b^2. The order extrapolates the common shape alone.
    """
    fine, grid, coarse, common = (float(total[k].sum()) for k in (_FINE, _GRID, _COARSE, _COMMON))
    if not (fine > 0 and grid > 0):
        return math.nan
    low, high = (math.exp2(-order) for order in SIGNAL_ORDERS)
    r = min(max(math.sqrt(grid / coarse), high), low) if coarse > 0 else low
    independent = min(max((grid - r * common) / (1 + r + r**2), 0.0), grid / (1 + r**2))
    shape = (grid - (1 + r**2) * independent) / (1 - r) ** 2
    return 10.0 * math.log10((shape + independent) / fine)


def _solver_factor(tolerance_ratio: float) -> float:
    """Return the whole error over its difference to the tight tolerance; NaN if both are equal.

    The error is proportional to the tolerance.
    """
    return 1.0 / (1.0 - tolerance_ratio) if tolerance_ratio < 1.0 else math.nan


def _ratios(total: Array, powers: BandPowers) -> tuple[Array, Array]:
    """Return the errors of the power of each band [dB] from grid and solver."""
    factor, of_solver = refinement_factor(_order(total)[0]), _solver_factor(powers.tolerance_ratio)
    grid, solver = np.full((2, len(BAND_NAMES)), np.nan)
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
        shift = -0.5 * _sum_error(record.z, error) if record.own_factor else 0.0
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
