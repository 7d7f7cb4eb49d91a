"""Speed against error: one scene on finer grids, with other edges, tolerances, steps and precision, against a fine reference.

Depends on variants and sound. Numbers only: accuracy_report has the variants marched and writes down what is found here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acoustics.bands import BAND_NAMES
from rolling.accuracy.variants import Study, Variant
from rolling.scene.sections import Numerics
from rolling.simulation import simulate
from rolling.sound import contact_sound

Array = NDArray[np.float64]
Errors = dict[str, float]  # by ERRORS and BANDS; NaN: cannot be told, inf: lost

BANDS = tuple(name for name in BAND_NAMES if 100 <= float(name) <= 16000)
PERCENT = ("release", "contact_area", "plastic_area", "max_pressure")
ERRORS = ("signal", "laeq_db", *(f"{name}_percent" for name in PERCENT))
ORDERED = ("signal", "release_percent", "contact_area_percent", "max_pressure_percent")
LAEQ_LIMIT, BAND_LIMIT = 0.1, 0.5  # dB that a recommended variant may be off
ROUNDING = 1e-10  # ratio, dB or percent
LEAST_NYQUIST = 20e3  # [Hz] of steps that leave nothing of hearing out
MOST_ORDER, LEAST_ORDER = 2.0, 0.5  # of convergence that is believed where an error is extrapolated


# ---- what came of a variant ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Measured:
    """A variant marched and heard.

    intensity : (samples,) fluctuation in the audible band [W/m2] at 48 kHz. laeq_db, third_octave_db : as a run reports them.
    release : mean release power over time [W]. raw_rms : of the release power of each step about its mean [W], unfiltered.
    contact_area, plastic_area : means over the track [m2]. max_pressure : the greatest [Pa].
    step_ms : median of a step. seconds_per_second : of computing per second of sound, by the mean of a step without the
    slowest twentieth, which prepares transforms for those that follow. iterations, convolutions : per step.
    """

    variant: Variant
    steps: int
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


def measured(what: Study, variant: Variant, pieces: Sequence[simulate.Piece]) -> Measured:
    """The numbers of a variant from all its pieces."""
    pieces = sorted(pieces, key=lambda piece: piece.first)
    step = {name: np.concatenate([piece.steps[name] for piece in pieces]) for name in simulate.STEP_SERIES}
    state = {name: np.concatenate([piece.states[name] for piece in pieces])[1:] for name in simulate.STATE_SERIES}
    sound = contact_sound(
        what.as_solved(variant), step["release_energy"], variant.step_nodes * what.scene.spacing, what.closed
    )
    steps = len(step["release_energy"])
    usual = np.sort(step["step_time"])[: math.ceil(0.95 * steps)]
    return Measured(
        variant=variant,
        steps=steps,
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


def errors(got: Measured, reference: Measured) -> Errors:
    """Of `got` against `reference`: signal as rms over rms of the reference's fluctuation, levels in dB, the rest in percent."""

    def db(a: float | None, b: float | None) -> float:
        return math.nan if b is None else math.inf if a is None else a - b

    fluctuation = _rms(reference.intensity)
    off = _rms(got.intensity - reference.intensity)
    found = {"signal": off / fluctuation if fluctuation else math.nan, "laeq_db": db(got.laeq_db, reference.laeq_db)}
    for name in PERCENT:
        a, b = getattr(got, name), getattr(reference, name)
        found[f"{name}_percent"] = 100 * (a / b - 1) if b else math.nan
    return found | {band: db(got.third_octave_db[band], reference.third_octave_db[band]) for band in BANDS}


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def decibel(ratio: float) -> float:
    """Of an rms over another; -inf for none."""
    return 20 * math.log10(ratio) if ratio > 0 else -math.inf


def worst_band(found: Errors) -> tuple[str, float]:
    """The third octave that is off the most and by how much [dB]; of bands whose error can be told."""
    known = {band: abs(found[band]) for band in BANDS if not math.isnan(found.get(band, math.nan))}
    return max(known.items(), key=lambda item: item[1]) if known else ("", math.nan)


# ---- the reference's own error, orders -------------------------------------------------------------------------------


def extrapolated(coarse: Errors | None, fine: Errors) -> Errors:
    """Error that the finest of three grids is left with (Richardson), from the differences of each grid to the next.

    The order is the observed one, believed from 0.5 to 2; without a third grid 1.
    """
    left = {}
    for name, value in fine.items():
        before = coarse[name] if coarse else math.nan
        told = value and before and math.isfinite(value) and math.isfinite(before)
        order = math.log2(abs(before / value)) if told else 1.0
        left[name] = abs(value) / (2 ** min(max(order, LEAST_ORDER), MOST_ORDER) - 1)
    return left


def either(estimates: Sequence[Errors]) -> Errors:
    """The largest of several estimates of each error; inf where there is none."""
    found = {}
    for name in (*ERRORS, *BANDS):
        known = [abs(e[name]) for e in estimates if not math.isnan(e[name])]
        found[name] = max(known) if known else math.inf
    return found


def observed_order(sizes: Sequence[float], off: Sequence[float]) -> float:
    """Slope of log error over log size; NaN with fewer than two errors that are more than rounding."""
    told = [(size, abs(e)) for size, e in zip(sizes, off, strict=True) if ROUNDING < abs(e) < math.inf]
    if len(told) < 2:
        return math.nan
    x, y = np.log(told).T
    return float(np.polyfit(x, y, 1)[0])


def orders_of_differences(series: Sequence[tuple[float, Measured]]) -> Errors:
    """Orders from the differences between each size and the next smaller one: of no reference, so not flattered by one."""
    found = [errors(a, b) for (_, a), (_, b) in pairwise(series)]
    sizes = [size for size, _ in series[:-1]]
    return {name: observed_order(sizes, [each[name] for each in found]) for name in ORDERED}


# ---- what to take ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Candidate:
    """What a variant costs [s of computing per s of sound] and may be off [dB], the reference's own uncertainty counted in."""

    name: str
    seconds_per_second: float
    laeq_db: float
    band_db: float

    @property
    def excess(self) -> float:
        """Its worst error as a share of the limit: 1 and less is within."""
        return max(self.laeq_db / LAEQ_LIMIT, self.band_db / BAND_LIMIT)


@dataclass(frozen=True)
class Recommendation:
    """The cheapest within both limits, the cheapest within that of LAeq, and the one that comes nearest to both."""

    both: Candidate | None
    laeq_only: Candidate | None
    nearest: Candidate | None


def candidate(one: Measured, found: Errors, uncertainty: Errors) -> Candidate:
    """A variant with its errors; unknown ones count as infinite."""
    bands = [abs(found[b]) + uncertainty[b] for b in BANDS if not math.isnan(found[b])]
    laeq = abs(found["laeq_db"]) + uncertainty["laeq_db"]
    worst = max(bands, default=math.inf)
    return Candidate(one.variant.name, one.seconds_per_second, math.inf if math.isnan(laeq) else laeq, worst)


def recommend(candidates: Sequence[Candidate]) -> Recommendation:
    """What to take of the candidates; None where none keeps the limits."""

    def cheapest(those: list[Candidate]) -> Candidate | None:
        return min(those, key=lambda one: one.seconds_per_second, default=None)

    told = [one for one in candidates if math.isfinite(one.excess)]  # not those that lose a third octave
    return Recommendation(
        both=cheapest([one for one in told if one.excess <= 1]),
        laeq_only=cheapest([one for one in told if one.laeq_db <= LAEQ_LIMIT]),
        nearest=min(told, key=lambda one: one.excess, default=None),
    )


def loosest_tolerance(signal_errors: Mapping[float, float], grid_error: float) -> float | None:
    """The loosest tolerance whose signal error is a fifth of the grid's or less, and at -40 dB or below; None: none is.

    A fifth adds 0.2 dB to the error in all.
    """
    return max((t for t, off in signal_errors.items() if off <= min(0.2 * grid_error, 0.01)), default=None)


def default_tolerance() -> float:
    """Of scenes that do not say."""
    return float(Numerics().tolerance)


# ---- all together ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Findings:
    """What came of a study, whole or not.

    failures : why a variant has no numbers. reference : what `errors` are of; None: it is missing.
    solver_errors : against the scene's own grid and step, solved to 1e-8. by_edges, by_refining : what may be wrong with the
    reference, from the other edges on its grid and extrapolated from the ladder; uncertainty : the larger of both.
    tolerance : the loosest that serves the scene's grid.
    """

    study: Study
    measured: dict[Variant, Measured]
    failures: dict[Variant, str]
    reference: Variant | None
    errors: dict[Variant, Errors]
    solver_errors: dict[Variant, Errors]
    by_edges: Errors
    by_refining: Errors
    uncertainty: Errors
    orders: dict[str, Errors]
    recommendation: Recommendation
    tolerance: float | None

    @property
    def silent(self) -> bool:
        """The reference has no sound that could be off."""
        return self.reference is not None and math.isnan(self.errors[self.reference]["signal"])


def judge(what: Study, done: dict[Variant, Measured], failures: dict[Variant, str]) -> Findings:
    """Errors, orders and advice, from the variants that are there."""
    found: dict[Variant, Errors] = {}
    by_edges = by_refining = dict.fromkeys((*ERRORS, *BANDS), math.nan)
    best = next((v for e in what.all_edges[::-1] if (v := what.reference(e)) in done), None)
    if best:
        found = {v: errors(one, done[best]) for v, one in done.items()}
        other = [v for e in what.all_edges if (v := what.reference(e)) != best and v in done]
        by_edges = found[other[0]] if other else by_edges
        by_refining = _by_refining(what, done, best) or by_refining
    uncertainty = either([by_edges, by_refining])
    solved = done.get(what.solver_reference)
    own_grid = {v: one for v, one in done.items() if _same_grid(v, what.own)}
    solver_errors = {v: errors(one, solved) for v, one in own_grid.items()} if solved else {}
    by_tolerance = {v.tolerance: e["signal"] for v, e in solver_errors.items() if v.precision == what.own.precision}
    return Findings(
        study=what,
        measured=done,
        failures=failures,
        reference=best,
        errors=found,
        solver_errors=solver_errors,
        by_edges=by_edges,
        by_refining=by_refining,
        uncertainty=uncertainty,
        orders=_orders(what, done, solver_errors),
        recommendation=recommend([candidate(done[v], e, uncertainty) for v, e in found.items() if _hears(what, v)]),
        tolerance=loosest_tolerance(by_tolerance, found[what.own]["signal"]) if what.own in found else None,
    )


def _hears(what: Study, variant: Variant) -> bool:
    """Its step is not too long for hearing, or no longer than the scene's own."""
    return what.highest(variant) >= LEAST_NYQUIST or variant.step_nodes <= what.own.step_nodes


def _same_grid(one: Variant, other: Variant) -> bool:
    return (one.times, one.step_nodes, one.edges) == (other.times, other.step_nodes, other.edges)


def _by_refining(what: Study, done: dict[Variant, Measured], best: Variant) -> Errors | None:
    grids = [done.get(what.on_grid(times, best.edges)) for times in what.ladder[-2:]]
    if grids[-1] is None:
        return None
    coarse = errors(grids[0], grids[1]) if len(grids) > 1 and grids[0] and grids[1] else None
    return extrapolated(coarse, errors(grids[-1], done[best]))


def _orders(what: Study, done: dict[Variant, Measured], solver_errors: dict[Variant, Errors]) -> dict[str, Errors]:
    families = what.families()
    found = {}
    for name, variants in families.items():
        if name.startswith("spacing"):
            found[name] = orders_of_differences([(1 / v.times, done[v]) for v in variants if v in done])
    found["step"] = orders_of_differences([(v.step_nodes, done[v]) for v in families["step"] if v in done])
    judged = [v for v in families["tolerance"] if v in solver_errors]
    found["tolerance"] = {
        name: observed_order([v.tolerance for v in judged], [solver_errors[v][name] for v in judged])
        for name in ORDERED
    }
    return found


def plain(found: Mapping[str, Any]) -> dict[str, Any]:
    """For a JSON file: what is not finite is None."""
    return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in found.items()}
