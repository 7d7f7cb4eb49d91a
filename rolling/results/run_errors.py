"""Errors that grid and solver leave in the levels of a run.

An error is the reported value less the estimated true value: too loud is positive. The sound and
its levels stay as they were computed.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from acoustics.numbers import rounded
from rolling.check import error_cost
from rolling.marches import error_stretches
from rolling.marches.result import Result
from rolling.numbers.ball_numbers import BandNumbers, ErrorNumbers, RunNumbers
from rolling.numbers.quantity import BandQuantity
from rolling.results.solved_run import SolvedRun
from rolling.scene.scene import Scene
from rolling.sound import error_estimate
from rolling.sound.contact_sound import ContactSound
from rolling.sound.missing_band import MissingBand
from rolling.sound.vibration_sound import Vibration

LINEAR = 0.3  # rms of the contact force over the load up to which sphere and plate are linear
_NAN = np.full(len(BAND_NAMES) + 1, math.nan)


class RunErrors(NamedTuple):
    """Errors of a run, and the facts of their estimate.

    levels : LevelErrors. Errors of levels and of the signal.
    detail_db : (2, bands + 1) array, dB. Error of missing detail, and its standard uncertainty,
        over the bands with LAeq at their end.
    plastic : pair of float. Error of the plastic area over its size, and its standard uncertainty.
    facts : EstimateFacts. How the errors were estimated.
    reason : str. Why they were not; empty where they were.
    """

    levels: error_estimate.LevelErrors
    detail_db: Array
    plastic: tuple[float, float]
    facts: EstimateFacts
    reason: str = ""


class EstimateFacts(NamedTuple):
    """How errors were estimated: stretches, their steps, and the order of convergence."""

    stretches: int | None = None
    steps: int | None = None
    order: float | None = None
    order_measured: bool | None = None
    worst_uncertainty_db: float | None = None


def _unknown(reason: str) -> RunErrors:
    """Return errors that are unknown for a reason."""
    levels = error_estimate.LevelErrors(
        order=math.nan,
        order_measured=False,
        grid_db=_NAN,
        grid_uncertainty_db=_NAN,
        solver_db=_NAN,
        grid_signal_db=math.nan,
        grid_signal_uncertainty_db=math.nan,
        solver_signal_db=math.nan,
    )
    detail = np.stack([_NAN, _NAN])
    return RunErrors(levels, detail, (math.nan, math.nan), EstimateFacts(), reason)


def run_errors(run: SolvedRun) -> RunErrors | None:
    """Estimate the errors of a run; None unless the scene asks for them."""
    if not run.scene.numerics.error_estimate:
        return None
    reason = _reason_against(run)
    return _unknown(reason) if reason else _estimate(run)


def error_parts(errors: RunErrors | None) -> dict[str, float | None]:
    """Return the parts of the uncertainty of LAeq [dB] that grid and solver leave.

    The level is not corrected for the error of the grid, which therefore counts whole.
    """
    if errors is None:
        return {}
    levels = errors.levels
    parts = {
        "grid": known(math.hypot(levels.grid_db[-1], levels.grid_uncertainty_db[-1])),
        "solver": known(abs(float(levels.solver_db[-1]))),
    }
    if np.nan_to_num(errors.detail_db).any():
        parts["subgrid"] = known(math.hypot(*errors.detail_db[:, -1]))
    return parts


def band_error_parts(errors: RunErrors | None) -> dict[str, Array]:
    """Return the same parts of third octaves (31,) [dB]; 0 where one is unknown."""
    if errors is None:
        return {}
    levels = errors.levels
    parts = {
        "grid": np.hypot(levels.grid_db, levels.grid_uncertainty_db),
        "solver": np.abs(levels.solver_db),
        "subgrid": np.hypot(*errors.detail_db),
    }
    return {source: np.nan_to_num(part[:-1]) for source, part in parts.items()}


def error_numbers(errors: RunErrors | None, band: MissingBand | None) -> ErrorNumbers:
    """Return the errors of LAeq of a run: of the missing band, and as far as it estimates them."""
    numbers = ErrorNumbers(
        band_db=None if band is None else band.error_db,
        band_uncertainty_db=None if band is None else band.uncertainty_db,
        band_end_hz=None if band is None else band.highest_hz,
    )
    if errors is None:
        return numbers
    levels = errors.levels
    detail = errors.detail_db
    facts = errors.facts
    return replace(
        numbers,
        grid_db=known(float(levels.grid_db[-1])),
        grid_uncertainty_db=known(float(levels.grid_uncertainty_db[-1])),
        solver_db=known(float(levels.solver_db[-1])),
        subgrid_db=known(float(detail[0, -1])),
        subgrid_uncertainty_db=known(float(detail[1, -1])),
        plastic_ratio_grid=known(errors.plastic[0]),
        plastic_ratio_grid_uncertainty=known(errors.plastic[1]),
        grid_signal_db=known(levels.grid_signal_db),
        grid_signal_uncertainty_db=known(levels.grid_signal_uncertainty_db),
        solver_signal_db=known(levels.solver_signal_db),
        is_asked=True,
        reason=errors.reason or None,
        stretches=facts.stretches,
        stretch_steps=facts.steps,
        order=facts.order,
        order_measured=facts.order_measured,
        worst_uncertainty_db=facts.worst_uncertainty_db,
    )


def error_bands(errors: RunErrors | None, bands: BandNumbers) -> BandNumbers:
    """Return third octaves with their errors from grid, solver and missing detail."""
    if errors is None:
        return bands
    levels = errors.levels
    detail = errors.detail_db
    return replace(
        bands,
        grid_error=_band_errors(levels.grid_db, levels.grid_uncertainty_db),
        solver_error=BandQuantity.of(known_bands(levels.solver_db[:-1]), "dB"),
        subgrid_error=_band_errors(detail[0], detail[1]),
    )


def _band_errors(errors_db: Array, uncertainty_db: Array) -> BandQuantity:
    """Return errors of the third octaves, before that of LAeq at the end, as a quantity."""
    spreads = known_bands(uncertainty_db[:-1])
    return BandQuantity.of(known_bands(errors_db[:-1]), "dB", spreads)


def total_errors_db(numbers: RunNumbers) -> dict[str, float | None]:
    """Return the errors of the third octaves [dB] from grid and solver; empty without estimate."""
    grid = numbers.bands.grid_error
    solver = numbers.bands.solver_error
    if numbers.errors.stretches is None or grid is None or solver is None:
        return {}
    of_solver = solver.by_name
    return {
        name: None if error is None else error + (of_solver[name] or 0.0)
        for name, error in grid.by_name.items()
    }


def known(value: float) -> float | None:
    """Return a number for JSON, None where it is not finite."""
    return value if math.isfinite(value) else None


def _estimate(run: SolvedRun) -> RunErrors:
    """Estimate the errors of a run from its stretches."""
    scene = run.scene
    result = run.result
    sound = run.sound
    powers = error_stretches.stretch_powers(scene, result)
    own_factor = sound.source == "release" and scene.sound.gain_pa_per_w_m2 is None
    lap_s = sound.duration * result.solved_steps / result.steps
    record = error_estimate.RecordLevels.of(sound.levels, own_factor, lap_s)
    # A file of heights may lack detail; the law of a made surface may end before the grid.
    detail = np.full((2, len(_NAN)), math.nan if scene.height_paths else 0.0)
    if with_detail := error_stretches.detail_powers(scene, result):
        detail = error_estimate.detail_errors(with_detail, record)
    levels = error_estimate.level_errors(powers, record)
    plastic = error_estimate.mean_error(
        error_stretches.plastic_areas(scene, result, "tight"),
        error_stretches.plastic_areas(scene, result, "fine"),
    )
    facts = EstimateFacts(
        stretches=len(error_stretches.stretch_firsts(scene, result)),
        steps=result.stretches.steps if result.stretches else 0,
        order=levels.order,
        order_measured=levels.order_measured,
        worst_uncertainty_db=known(error_estimate.worst_uncertainty_db(powers)),
    )
    return RunErrors(levels, detail, plastic, facts)


def _reason_against(run: SolvedRun) -> str:
    """Explain why a run has no estimate; empty where it has one."""
    if run.vibration_sound is not None and run.sound.source == "vibration":
        reason = not_linear(run.vibration_sound)
        if reason:
            return reason
    return _reason(run.scene, run.result, run.sound)


def not_linear(vibration: Vibration) -> str:
    """Explain that no linear chain carries an error to the sound; empty where one does."""
    if vibration.motion.flight_share > 0:
        words = "contact is lost"
    elif vibration.rms_ratio > LINEAR:
        words = f"the contact force fluctuates by {rounded(vibration.rms_ratio)} of the load"
    else:
        return ""
    return f"{words}, and no linear chain carries an error of the approach to the sound then"


def _reason(scene: Scene, result: Result, sound: ContactSound) -> str:
    """Explain why stretches tell no errors of a sound; empty where they do."""
    if scene.is_smooth:
        return "a smooth surface makes no sound whose error could be estimated"
    if result.stretches and result.stretches.failure:
        return f"a stretch could not be solved again: {result.stretches.failure}"
    if not error_stretches.stretch_firsts(scene, result):
        return error_cost.too_short(scene) or "its stretches are not marched"
    return "the record is silent" if sound.levels.level_db is None else ""


def known_bands(values: Array) -> dict[str, float | None]:
    """Return values by nominal frequency, None where they are unknown."""
    return dict(zip(BAND_NAMES, map(known, values.tolist()), strict=True))
