"""Errors of band levels, from a signal of the same stretches on several levels of accuracy.

The signal is the release, or the approach of a vibration, which a linear chain carries to the
listener. All levels of accuracy see the same asperities. The ratio of their powers is therefore
known far better than either power. The module takes arrays and plain numbers; it marches nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri, stdtrit

from acoustics.bands import BAND_NAMES, EDGES_HZ, NOMINAL_HZ, third_octave_mean_square
from rolling._typing import Array

# Limits of the order of convergence in an extrapolation, by trial on three scenes. Levels of whole
# tracks fell at orders from 1.1 to 2.5 from 2 um over 1 um to 0.5 um, where the three grids of an
# estimate, with 4 um, showed 1.7 to 2. A higher limit extrapolates less, and understated the error
# of the scene with 1.3; `DOUBT` covers the other scenes.
ORDER_LIMITS = 0.5, 1.5
DOUBT = 0.5  # standard uncertainty of the part that is extrapolated, over this part
DEFAULT_ORDER = 1.0  # the order where it cannot be measured
SHARED_BELOW_HZ = 1000.0  # bands below share an estimate, because a stretch is short
LEAST_LINES = 2  # minimum number of lines of a stretch in a band with its own estimate
JUDGED_HZ = 1000.0, 16000.0  # bands whose standard error decides whether stretches suffice
WANTED_DB = 0.2  # standard error [dB] that suffices
SOUND_SHARE = 1e-4  # a band with less than this share of the fluctuation carries no sound
_FIRST_LINE = 2  # below this line the Hann window mixes the mean into the lines
# Rows of the sums: powers of three levels, and powers of the differences between two levels.
_OWN, _TIGHT, _FINE, _SOLVER, _GRID, _COARSE = range(6)


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

    sums : (stretches, 6, bands) array. Mean squares over the passes, weighted by their speed.
    groups : tuple of tuples of int. Numbers of the bands that share an estimate.
    tolerance_ratio : float. As in `StretchSignals`.
    """

    sums: Array
    groups: tuple[tuple[int, ...], ...]
    tolerance_ratio: float

    @property
    def shared_bands(self) -> list[list[str]]:
        """The nominal frequencies of bands that share an estimate, several in each list."""
        return [[BAND_NAMES[band] for band in group] for group in self.groups if len(group) > 1]


@dataclass(frozen=True)
class RecordLevels:
    """Band powers of the record that is reported, as far as its errors depend on them.

    z, a : (bands,) arrays. Unweighted and A-weighted mean squares; NaN for a band without a level.
    own_factor : bool. If true, the record's own fluctuation sets its factor to sound pressure, so
        that half the error of its total level cancels.
    """

    z: Array
    a: Array
    own_factor: bool

    @classmethod
    def of(
        cls,
        third_octave_db: dict[str, float | None],
        third_octave_a_db: dict[str, float | None],
        own_factor: bool,
    ) -> RecordLevels:
        """Make the powers from the band levels of a record [dB]."""

        def power(levels: dict[str, float | None]) -> Array:
            values = [levels[name] for name in BAND_NAMES]
            return np.array([np.nan if x is None else 10.0 ** (x / 10.0) for x in values])

        return cls(power(third_octave_db), power(third_octave_a_db), own_factor)


@dataclass(frozen=True)
class LevelErrors:
    """Errors of levels and of the signal. An error is the reported value less the true value.

    order : float. Order of convergence that extrapolates to infinitely fine grids.
    order_measured : bool. If false, the order is the default, because a level equals another.
    grid_db, grid_uncertainty_db, solver_db : (bands,) arrays, dB. Errors of the band levels from
        grid and solver, and the standard uncertainty of the former; NaN: unknown.
    laeq_grid_db, laeq_grid_uncertainty_db, laeq_solver_db : float, dB. The same of LAeq.
    grid_signal_db, solver_signal_db : float, dB. Rms error of the signal over its rms fluctuation.
    """

    order: float
    order_measured: bool
    grid_db: Array
    grid_uncertainty_db: Array
    solver_db: Array
    laeq_grid_db: float
    laeq_grid_uncertainty_db: float
    laeq_solver_db: float
    grid_signal_db: float
    solver_signal_db: float


# ---- powers


def band_powers(signals: StretchSignals) -> BandPowers:
    """Sum the line powers of all levels to third octaves, stretch by stretch."""
    spectra = [
        _spectrum(values) for values in (signals.own, signals.tight, signals.fine, signals.coarse)
    ]
    own, tight, fine, coarse = spectra
    powers = np.stack(
        [_square(x) for x in (own, tight, fine, own - tight, tight - fine, coarse - tight)], axis=1
    )
    steps = signals.own.shape[1]
    waves = np.arange(powers.shape[2]) / (steps * signals.step)  # per metre
    sums = np.zeros((len(powers), powers.shape[1], len(BAND_NAMES)))
    for stretch, lines, speeds in zip(sums, powers, signals.speeds, strict=True):
        for speed, passes in zip(*np.unique(speeds[speeds > 0], return_counts=True), strict=True):
            frequency = speed * waves[_FIRST_LINE:]
            for row, squares in zip(stretch, lines, strict=True):
                row += passes * signals.power(speed, frequency, squares[_FIRST_LINE:])
    width_hz = _typical_speed(signals.speeds) / (steps * signals.step)
    return BandPowers(sums, _groups(sums[:, _FINE].sum(axis=0), width_hz), signals.tolerance_ratio)


def _spectrum(values: Array) -> NDArray[np.complex128]:
    """Return the transforms of stretches about their means, with a Hann window."""
    steps = values.shape[1]
    hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(steps) / steps)
    return np.fft.rfft((values - values.mean(axis=1, keepdims=True)) * hann, axis=1)


def _square(spectrum: NDArray[np.complex128]) -> Array:
    """Return the squared magnitudes of a spectrum."""
    return np.asarray(spectrum.real**2 + spectrum.imag**2)


def _typical_speed(speeds: Array) -> float:
    """Return the median of the speeds above zero [m/s], or 0 without one."""
    moving = speeds[speeds > 0]
    return float(np.median(moving)) if len(moving) else 0.0


def _groups(power: Array, width_hz: float) -> tuple[tuple[int, ...], ...]:
    """Group the bands that share an estimate, up to the last band with power.

    The bands below 1 kHz form a group. A group with too few lines takes up the next band.
    """

    def lines(group: list[int]) -> int:
        return sum(_lines(band, width_hz) for band in group)

    low = [band for band, nominal in enumerate(NOMINAL_HZ) if nominal < SHARED_BELOW_HZ]
    groups = [low]
    for band in range(len(low), int(np.flatnonzero(power).max(initial=-1)) + 1):
        if lines(groups[-1]) >= LEAST_LINES:
            groups.append([])
        groups[-1].append(band)
    if len(groups) > 1 and lines(groups[-1]) < LEAST_LINES:  # the steps end within the band
        groups[-2:] = [groups[-2] + groups[-1]]
    return tuple(tuple(group) for group in groups)


def _lines(band: int, width_hz: float) -> int:
    """Return the number of usable lines of a stretch in a band; `width_hz` is their distance."""
    if width_hz <= 0:
        return 0
    low, high = (math.ceil(float(EDGES_HZ[band + end]) / width_hz) for end in (0, 1))
    return max(0, high - max(low, _FIRST_LINE))


# ---- errors


def level_errors(powers: BandPowers, record: RecordLevels) -> LevelErrors:
    """Estimate the errors of a record's levels.

    Their standard errors come from the jackknife over stretches, from the doubt about the bands of
    a group and from the doubt about the order that extrapolates them.
    """
    total = powers.sums.sum(axis=0)
    order, measured = _order(total)
    bands = len(BAND_NAMES)
    numbers = _reported(total, powers, record)
    spread = _jackknife(powers.sums, lambda part: _reported(part, powers, record))
    spread[:bands] = _band_spread(spread[:bands], numbers[:bands], powers.groups)
    spread = np.hypot(spread, DOUBT * (1.0 - 1.0 / refinement_factor(order)) * np.abs(numbers))
    grid, solver = numbers[:bands], numbers[bands : 2 * bands]
    return LevelErrors(
        order=order,
        order_measured=measured,
        grid_db=grid,
        grid_uncertainty_db=spread[:bands],
        solver_db=solver,
        laeq_grid_db=float(numbers[-2]),
        laeq_grid_uncertainty_db=float(spread[-2]),
        laeq_solver_db=float(numbers[-1]),
        grid_signal_db=_signal_db(total[_GRID], total[_FINE], refinement_factor(order)),
        solver_signal_db=_signal_db(
            total[_SOLVER], total[_TIGHT], _solver_factor(powers.tolerance_ratio)
        ),
    )


def worst_uncertainty_db(powers: BandPowers) -> float:
    """Return the maximum standard error [dB] of the bands of 1 to 16 kHz that carry sound.

    It is infinite if no band does or fewer than two stretches are known.
    """
    if len(powers.sums) < 2:
        return math.inf
    spread = _jackknife(powers.sums, lambda part: _ratios(part, powers)[0])
    power = powers.sums[:, _FINE].sum(axis=0)
    nominal = np.array(NOMINAL_HZ)
    judged = (nominal >= JUDGED_HZ[0]) & (nominal <= JUDGED_HZ[1])
    judged &= (power > SOUND_SHARE * power.sum()) & np.isfinite(spread)
    return float(spread[judged].max()) if judged.any() else math.inf


def _jackknife(sums: Array, numbers: Callable[[Array], Array]) -> Array:
    """Return standard errors from leaving out each stretch in turn; NaN below two stretches.

    They are widened by Student's factor, so that twice the standard error holds 95 % even for four
    stretches.
    """
    count = len(sums)
    if count < 2:
        return np.full_like(numbers(sums.sum(axis=0)), np.nan)
    left_out = np.array([numbers(np.delete(sums, k, axis=0).sum(axis=0)) for k in range(count)])
    widened = float(stdtrit(count - 1, 0.975) / ndtri(0.975))
    return np.asarray(widened * np.sqrt((count - 1) * np.var(left_out, axis=0)))


def _band_spread(spread: Array, errors: Array, groups: Sequence[Sequence[int]]) -> Array:
    """Return standard errors of bands [dB] from a few stretches and their neighbours.

    The jackknife over four stretches is often too small by chance in a single band. Above the
    lowest group it is therefore at least the rms over a group and its neighbours. Bands of a group
    may differ from each other as much as the group differs from the nearest of its neighbours.

    Parameters
    ----------
    spread, errors : (bands,) arrays, dB. Standard errors by the jackknife, and errors.
    groups : sequence of sequences of int. Numbers of the bands that share an estimate.
    """
    known = [
        bands
        for group in groups
        if (bands := [band for band in group if np.isfinite(spread[band] + errors[band])])
    ]
    firsts = [bands[0] for bands in known]
    result = spread.copy()
    for k, bands in enumerate(known):
        near = [j for j in (k - 1, k + 1) if 0 <= j < len(known)]
        own = spread[firsts[k]]
        if k > 0:
            around = spread[[firsts[k], *(firsts[j] for j in near if j > 0)]]
            own = max(own, float(np.sqrt(np.mean(around**2))))
        steps = [abs(errors[firsts[k]] - errors[firsts[j]]) for j in near]
        shared = min(steps, default=0.0) if len(bands) > 1 else 0.0
        result[bands] = math.hypot(own, shared)
    return result


def _order(total: Array) -> tuple[float, bool]:
    """Return the observed order of convergence of the signal within its limits.

    The second value tells whether it could be observed.
    """
    coarse, grid = float(total[_COARSE].sum()), float(total[_GRID].sum())
    if not (coarse > 0 and grid > 0):
        return DEFAULT_ORDER, False
    return float(np.clip(0.5 * math.log2(coarse / grid), *ORDER_LIMITS)), True


def refinement_factor(order: float) -> float:
    """Return the whole error over the difference between a grid and half its spacing."""
    return 1.0 / (1.0 - math.exp2(-order))


def _solver_factor(tolerance_ratio: float) -> float:
    """Return the whole error over the difference between a tolerance and the tight tolerance.

    The error is proportional to the tolerance. The result is NaN if both are equal.
    """
    return 1.0 / (1.0 - tolerance_ratio) if tolerance_ratio < 1.0 else math.nan


def _ratios(total: Array, powers: BandPowers) -> tuple[Array, Array]:
    """Return the errors of the power of each band [dB] from grid and solver."""
    factor = refinement_factor(_order(total)[0])
    grid, solver = np.full((2, len(BAND_NAMES)), np.nan)
    for group in powers.groups:
        own, tight, fine = total[:3, list(group)].sum(axis=1)
        if min(own, tight, fine) > 0:
            grid[list(group)] = factor * 10.0 * math.log10(tight / fine)
            solver[list(group)] = (
                _solver_factor(powers.tolerance_ratio) * 10.0 * math.log10(own / tight)
            )
    return grid, solver


def _reported(total: Array, powers: BandPowers, record: RecordLevels) -> Array:
    """Return errors of the reported band levels and of LAeq, from grid and solver [dB]."""
    errors, of_laeq = [], []
    for error in _ratios(total, powers):
        shift = -0.5 * _sum_error(record.z, error) if record.own_factor else 0.0
        errors.append(np.where(np.isnan(record.z), np.nan, error + shift))
        of_laeq.append(_sum_error(record.a, error) + shift)
    return np.concatenate([*errors, of_laeq])


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
