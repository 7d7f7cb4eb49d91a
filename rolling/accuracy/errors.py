"""Errors of a scene's variants against a fine reference, with orders and a recommendation.

The module computes numbers only: `study` marches the variants, `text` and `plot` show the results.
The recommendation is the cheapest variant within the limits.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from acoustics.bands import BAND_NAMES
from rolling._typing import Array
from rolling.accuracy.record import RecordCheck, record_check
from rolling.accuracy.variants import Study, Variant
from rolling.simulation import simulate
from rolling.sound.contact_sound import contact_sound

Errors = dict[str, float]  # errors by ERRORS and BANDS; NaN: unknown, inf: lost

BANDS = tuple(name for name in BAND_NAMES if 100 <= float(name) <= 16000)
PERCENT = ("release", "contact_area", "plastic_area", "max_pressure")
ERRORS = ("signal", "laeq_db", *(f"{name}_percent" for name in PERCENT))
ORDERED = ("signal", "release_percent", "contact_area_percent", "max_pressure_percent")
LAEQ_LIMIT, BAND_LIMIT = 0.1, 0.5  # dB, maximum errors of a recommended variant
ROUNDING = 1e-10  # ratio, dB or percent
LEAST_NYQUIST = 20e3  # Nyquist frequency [Hz] of steps that cover all of hearing
MOST_ORDER, LEAST_ORDER = 2.0, 0.5  # limits of the order of convergence in an extrapolation


# ---- the numbers of a variant


@dataclass(frozen=True)
class Measurement:
    """The numbers of a variant that was marched.

    Parameters
    ----------
    variant : Variant. Its settings.
    steps : int. Number of steps.
    release_energy : array (steps,), J. Release of each step.
    intensity : array (samples,), W/m2. Fluctuation in the audible band at 48 kHz.
    laeq_db, third_octave_db : dB. Levels as a run reports them.
    release : float, W. Mean release power over time.
    raw_rms : float, W. Rms of the release power of each step about its mean, unfiltered.
    contact_area, plastic_area : float, m2. Means over the track.
    max_pressure : float, Pa. Maximum along the track.
    step_ms : float, ms. Median time of a step.
    seconds_per_second : float. Computing time per second of sound, from the mean of a step without
        the slowest twentieth, which prepares transforms for later steps.
    iterations, convolutions : float. Mean numbers per step.
    """

    variant: Variant
    steps: int
    release_energy: Array
    intensity: Array
    laeq_db: float | None
    third_octave_db: dict[str, float | None]
    release: float
    raw_rms: float
    contact_area: float
    plastic_area: float
    max_pressure: float
    step_ms: float
    seconds_per_second: float
    iterations: float
    convolutions: float


def measure(study: Study, variant: Variant, pieces: Sequence[simulate.Piece]) -> Measurement:
    """Compute the numbers of a variant from all its pieces."""
    pieces = sorted(pieces, key=lambda piece: piece.first)
    step = {
        name: np.concatenate([piece.steps[name] for piece in pieces])
        for name in simulate.STEP_SERIES
    }
    state = {
        name: np.concatenate([piece.states[name] for piece in pieces])[1:]
        for name in simulate.STATE_SERIES
    }
    sound = contact_sound(
        study.as_solved(variant),
        step["release_energy"],
        variant.step_nodes * study.scene.spacing,
        study.closed,
    )
    steps = len(step["release_energy"])
    usual = np.sort(step["step_time"])[: math.ceil(0.95 * steps)]
    return Measurement(
        variant=variant,
        steps=steps,
        release_energy=step["release_energy"],
        intensity=sound.pressure / (sound.factor or 1.0),
        laeq_db=sound.levels.laeq_db,
        third_octave_db=sound.levels.third_octave_db,
        release=sound.mean_power,
        raw_rms=sound.power_rms,
        contact_area=float(state["contact_area"].mean()),
        plastic_area=float(state["plastic_area"].mean()),
        max_pressure=float(state["max_pressure"].max()),
        step_ms=float(np.median(step["step_time"]) * 1e3),
        seconds_per_second=float(usual.mean()) * steps / sound.duration,
        iterations=float(state["iterations"].mean()),
        convolutions=float(state["convolutions"].mean()),
    )


def errors(measurement: Measurement, reference: Measurement) -> Errors:
    """Compute the errors of a measurement against a reference.

    The signal's error is an rms over the rms of the reference's fluctuation; levels are in dB, the
    others in percent.
    """

    def db(a: float | None, b: float | None) -> float:
        return math.nan if b is None else math.inf if a is None else a - b

    fluctuation = _rms(reference.intensity)
    off = _rms(measurement.intensity - reference.intensity)
    differences = {
        "signal": off / fluctuation if fluctuation else math.nan,
        "laeq_db": db(measurement.laeq_db, reference.laeq_db),
    }
    for name in PERCENT:
        a, b = getattr(measurement, name), getattr(reference, name)
        differences[f"{name}_percent"] = 100 * (a / b - 1) if b else math.nan
    return differences | {
        band: db(measurement.third_octave_db[band], reference.third_octave_db[band])
        for band in BANDS
    }


def _rms(values: Array) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def decibel(ratio: float) -> float:
    """Convert the ratio of two rms values to dB; -inf for zero."""
    return 20 * math.log10(ratio) if ratio > 0 else -math.inf


def worst_band(errors_by_name: Errors) -> tuple[str, float]:
    """Return the third octave with the largest known error and this error [dB]."""
    known = {
        band: abs(errors_by_name[band])
        for band in BANDS
        if not math.isnan(errors_by_name.get(band, math.nan))
    }
    return max(known.items(), key=lambda item: item[1]) if known else ("", math.nan)


# ---- the reference's own error, orders


def extrapolated(coarse: Errors | None, fine: Errors) -> Errors:
    """Extrapolate the error of the finest of three grids from their differences (Richardson).

    The order is the observed order, limited to 0.5 to 2; without a third grid it is 1.
    """
    left = {}
    for name, value in fine.items():
        before = coarse[name] if coarse else math.nan
        known = value and before and math.isfinite(value) and math.isfinite(before)
        order = math.log2(abs(before / value)) if known else 1.0
        left[name] = abs(value) / (2 ** min(max(order, LEAST_ORDER), MOST_ORDER) - 1)
    return left


def either(estimates: Sequence[Errors]) -> Errors:
    """Return the maximum of several estimates of each error, or inf without an estimate."""
    largest = {}
    for name in (*ERRORS, *BANDS):
        known = [abs(estimate[name]) for estimate in estimates if not math.isnan(estimate[name])]
        largest[name] = max(known) if known else math.inf
    return largest


def observed_order(sizes: Sequence[float], errors_by_size: Sequence[float]) -> float:
    """Return the slope of log error over log size, or NaN with fewer than two usable errors."""
    points = [
        (size, abs(error))
        for size, error in zip(sizes, errors_by_size, strict=True)
        if ROUNDING < abs(error) < math.inf
    ]
    if len(points) < 2:
        return math.nan
    x, y = np.log(points).T
    return float(np.polyfit(x, y, 1)[0])


def orders_of_differences(series: Sequence[tuple[float, Measurement]]) -> Errors:
    """Compute orders from the differences between each size and the next smaller size.

    This estimate needs no reference, so no reference can flatter it.
    """
    differences = [errors(a, b) for (_, a), (_, b) in pairwise(series)]
    sizes = [size for size, _ in series[:-1]]
    return {
        name: observed_order(sizes, [errors_there[name] for errors_there in differences])
        for name in ORDERED
    }


# ---- the recommendation


@dataclass(frozen=True)
class Candidate:
    """The cost and the errors of a variant, with the reference's own uncertainty added.

    Parameters
    ----------
    name : str. Name of the variant.
    seconds_per_second : float. Computing time per second of sound.
    laeq_db, band_db : float, dB. Error of LAeq, and the largest error of a third octave.
    """

    name: str
    seconds_per_second: float
    laeq_db: float
    band_db: float

    @property
    def excess(self) -> float:
        """The worst error as a share of its limit; up to 1 it is within the limit."""
        return max(self.laeq_db / LAEQ_LIMIT, self.band_db / BAND_LIMIT)


@dataclass(frozen=True)
class Recommendation:
    """The cheapest variants within both limits and within the limit of LAeq, and the nearest."""

    both: Candidate | None
    laeq_only: Candidate | None
    nearest: Candidate | None


def candidate(measurement: Measurement, errors_by_name: Errors, uncertainty: Errors) -> Candidate:
    """Return a variant with its errors; unknown errors count as infinite."""
    bands = [
        abs(errors_by_name[band]) + uncertainty[band]
        for band in BANDS
        if not math.isnan(errors_by_name[band])
    ]
    laeq = abs(errors_by_name["laeq_db"]) + uncertainty["laeq_db"]
    worst = max(bands, default=math.inf)
    return Candidate(
        measurement.variant.name,
        measurement.seconds_per_second,
        math.inf if math.isnan(laeq) else laeq,
        worst,
    )


def recommend(candidates: Sequence[Candidate]) -> Recommendation:
    """Choose among the candidates; the choice is None if no candidate keeps the limits."""

    def cheapest(allowed: list[Candidate]) -> Candidate | None:
        return min(allowed, key=lambda candidate: candidate.seconds_per_second, default=None)

    known = [candidate for candidate in candidates if math.isfinite(candidate.excess)]
    return Recommendation(
        both=cheapest([candidate for candidate in known if candidate.excess <= 1]),
        laeq_only=cheapest([candidate for candidate in known if candidate.laeq_db <= LAEQ_LIMIT]),
        nearest=min(known, key=lambda candidate: candidate.excess, default=None),
    )


def loosest_tolerance(signal_errors: Mapping[float, float], grid_error: float) -> float | None:
    """Return the loosest tolerance whose signal error is small beside the grid's.

    It is at most a fifth of the grid's error and at most -40 dB; a fifth adds 0.2 dB to the whole
    error. The result is None if no tolerance qualifies.
    """
    return max(
        (
            tolerance
            for tolerance, error in signal_errors.items()
            if error <= min(0.2 * grid_error, 0.01)
        ),
        default=None,
    )


# ---- all together


@dataclass(frozen=True)
class Findings:
    """The results of a study, complete or partial.

    Parameters
    ----------
    study : Study. The scene and its stretch.
    measurements : dict from Variant to Measurement. Variants that were marched.
    failures : dict from Variant to str. Reasons for missing numbers.
    reference : Variant or None. Reference of `errors`, None if it is missing.
    errors : dict from Variant to Errors. Errors against the reference.
    solver_errors : dict from Variant to Errors. Errors against the scene's own grid and step,
        solved to 1e-8.
    by_edges, by_refining : Errors. Two estimates of the reference's own error: from the other edges
        on its grid, and extrapolated from the ladder of grids.
    uncertainty : Errors. The larger of both.
    orders : dict from str to Errors. Observed orders by family.
    wider : Errors or None. Errors of the scene as it stands against its wider surface.
    record : RecordCheck or None. The record's length against its stated uncertainty.
    recommendation : Recommendation. The variants to use.
    tolerance : float or None. The loosest tolerance that serves the scene's grid.
    """

    study: Study
    measurements: dict[Variant, Measurement]
    failures: dict[Variant, str]
    reference: Variant | None
    errors: dict[Variant, Errors]
    solver_errors: dict[Variant, Errors]
    by_edges: Errors
    by_refining: Errors
    uncertainty: Errors
    orders: dict[str, Errors]
    wider: Errors | None
    record: RecordCheck | None
    recommendation: Recommendation
    tolerance: float | None

    @property
    def silent(self) -> bool:
        """True if the reference has no sound and levels cannot be compared."""
        return self.reference is not None and math.isnan(self.errors[self.reference]["signal"])


def judge(study: Study, done: dict[Variant, Measurement], failures: dict[Variant, str]) -> Findings:
    """Compute errors, orders and the recommendation from the variants with results."""
    errors_by_variant: dict[Variant, Errors] = {}
    by_edges = by_refining = dict.fromkeys((*ERRORS, *BANDS), math.nan)
    best = next(
        (v for edges in study.all_edges[::-1] if (v := study.reference(edges)) in done), None
    )
    if best:
        errors_by_variant = {v: errors(measurement, done[best]) for v, measurement in done.items()}
        other = [
            v for edges in study.all_edges if (v := study.reference(edges)) != best and v in done
        ]
        by_edges = errors_by_variant[other[0]] if other else by_edges
        by_refining = _by_refining(study, done, best) or by_refining
    uncertainty = either([by_edges, by_refining])
    solved = done.get(study.solver_reference)
    own = done.get(study.own)
    own_grid = {v: measurement for v, measurement in done.items() if _same_grid(v, study.own)}
    solver_errors = (
        {v: errors(measurement, solved) for v, measurement in own_grid.items()} if solved else {}
    )
    by_tolerance = {
        v.tolerance: off["signal"]
        for v, off in solver_errors.items()
        if v.precision == study.own.precision
    }
    return Findings(
        study=study,
        measurements=done,
        failures=failures,
        reference=best,
        errors=errors_by_variant,
        solver_errors=solver_errors,
        by_edges=by_edges,
        by_refining=by_refining,
        uncertainty=uncertainty,
        orders=_orders(study, done, solver_errors),
        wider=_against_wider(study, done),
        record=record_check(study, own.release_energy) if own is not None else None,
        recommendation=recommend(
            [
                candidate(done[v], off, uncertainty)
                for v, off in errors_by_variant.items()
                if _hears(study, v) and v.width == 1
            ]
        ),
        tolerance=loosest_tolerance(by_tolerance, errors_by_variant[study.own]["signal"])
        if study.own in errors_by_variant
        else None,
    )


def _against_wider(study: Study, done: dict[Variant, Measurement]) -> Errors | None:
    """Compute the errors of the scene as it stands against the same on a wider surface."""
    if study.wider is None or study.wider not in done or study.own not in done:
        return None
    return errors(done[study.own], done[study.wider])


def _hears(study: Study, variant: Variant) -> bool:
    """Return whether a step is short enough for hearing, or no longer than the scene's own."""
    return study.highest(variant) >= LEAST_NYQUIST or variant.step_nodes <= study.own.step_nodes


def _same_grid(variant: Variant, other: Variant) -> bool:
    """Return whether two variants share grid, step, edges and width."""
    return (variant.times, variant.step_nodes, variant.edges, variant.width) == (
        other.times,
        other.step_nodes,
        other.edges,
        other.width,
    )


def _by_refining(study: Study, done: dict[Variant, Measurement], best: Variant) -> Errors | None:
    """Extrapolate the error of the reference from the ladder of grids.

    The result is None without a finer grid.
    """
    grids = [done.get(study.on_grid(times, best.edges)) for times in study.ladder[-2:]]
    if grids[-1] is None:
        return None
    coarse = errors(grids[0], grids[1]) if len(grids) > 1 and grids[0] and grids[1] else None
    return extrapolated(coarse, errors(grids[-1], done[best]))


def _orders(
    study: Study, done: dict[Variant, Measurement], solver_errors: dict[Variant, Errors]
) -> dict[str, Errors]:
    """Compute the observed orders of all families."""
    families = study.families()
    orders = {}
    for name, variants in families.items():
        if name.startswith("spacing"):
            orders[name] = orders_of_differences(
                [(1 / v.times, done[v]) for v in variants if v in done]
            )
    orders["step"] = orders_of_differences(
        [(v.step_nodes, done[v]) for v in families["step"] if v in done]
    )
    judged = [v for v in families["tolerance"] if v in solver_errors]
    orders["tolerance"] = {
        name: observed_order(
            [v.tolerance for v in judged], [solver_errors[v][name] for v in judged]
        )
        for name in ORDERED
    }
    return orders


def plain(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """Convert for JSON: a non-finite number becomes None."""
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in numbers.items()
    }
