"""Errors that grid and solver leave in the levels of a run, as numbers of summary.json.

An error is the reported value less the estimated true value: too loud is positive. The sound and
its levels stay as they were computed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from acoustics.numbers import rounded
from rolling.check import error_cost
from rolling.marches import error_stretches
from rolling.marches.result import Result
from rolling.results.solved_run import SolvedRun
from rolling.scene.scene import Scene
from rolling.sound import error_estimate
from rolling.sound.contact_sound import ContactSound
from rolling.sound.vibration_sound import Vibration

LINEAR = 0.3  # rms of the contact force over the load up to which sphere and plate are linear
_NAN = np.full(len(BAND_NAMES) + 1, math.nan)


class RunErrors(NamedTuple):
    """Errors of a run, and the facts of their estimate.

    levels : LevelErrors. Errors of levels and of the signal.
    detail_db : (2, bands + 1) array, dB. Error of missing detail, and its standard uncertainty,
        over the bands with LAeq at their end.
    plastic : pair of float. Error of the plastic area over its size, and its standard uncertainty.
    facts : dict. How the errors were estimated, or the reason why they were not.
    """

    levels: error_estimate.LevelErrors
    detail_db: Array
    plastic: tuple[float, float]
    facts: dict[str, Any]


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
    return RunErrors(levels, detail, (math.nan, math.nan), {"reason": reason})


def error_numbers(run: SolvedRun, spreads: Mapping[str, float | None]) -> dict[str, Any]:
    """Return the errors of a run for summary.json; none unless the scene asks for them.

    `spreads` are uncertainties of LAeq [dB] by their origin: the record and, of a vibration, more.
    """
    if not run.scene.numerics.error_estimate:
        return {}
    reason = _reason_against(run)
    errors = _unknown(reason) if reason else _estimate(run)
    levels = errors.levels
    detail = errors.detail_db
    # The level is not corrected for the error of the grid, which therefore counts whole.
    parts = dict.fromkeys(("record", "grid", "solver")) | dict(spreads)
    parts["grid"] = known(math.hypot(levels.grid_db[-1], levels.grid_uncertainty_db[-1]))
    parts["solver"] = known(abs(levels.solver_db[-1]))
    if np.nan_to_num(detail).any():
        parts["subgrid"] = known(math.hypot(*detail[:, -1]))
    total = math.sqrt(sum(part**2 for part in parts.values() if part is not None))
    arrays = {
        "grid_error_db": levels.grid_db,
        "grid_error_uncertainty_db": levels.grid_uncertainty_db,
        "solver_error_db": levels.solver_db,
        "subgrid_error_db": detail[0],
        "subgrid_error_uncertainty_db": detail[1],
    }
    return {
        **{name: known_bands(values[:-1]) for name, values in arrays.items()},
        **{f"laeq_{name}": known(float(values[-1])) for name, values in arrays.items()},
        "plastic_ratio_grid_error": known(errors.plastic[0]),
        "plastic_ratio_grid_error_uncertainty": known(errors.plastic[1]),
        "grid_signal_db": known(levels.grid_signal_db),
        "grid_signal_uncertainty_db": known(levels.grid_signal_uncertainty_db),
        "solver_signal_db": known(levels.solver_signal_db),
        "laeq_uncertainty_db": None if reason else total,
        "laeq_uncertainty_parts_db": parts,
        "error_estimate": errors.facts,
    }


def total_errors_db(summary: Mapping[str, Any]) -> dict[str, float | None]:
    """Return the errors of the third octaves [dB] from grid and solver; empty without estimate."""
    if "stretches" not in summary.get("error_estimate", {}):
        return {}
    solver = summary["solver_error_db"]
    return {
        name: None if grid is None else grid + (solver[name] or 0.0)
        for name, grid in summary["grid_error_db"].items()
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
    facts = {
        "stretches": len(error_stretches.stretch_firsts(scene, result)),
        "steps": result.stretches.steps if result.stretches else 0,
        "order": levels.order,
        "order_measured": levels.order_measured,
        "worst_uncertainty_db": known(error_estimate.worst_uncertainty_db(powers)),
    }
    return RunErrors(levels, detail, plastic, facts)


def _reason_against(run: SolvedRun) -> str:
    """Explain why a run has no estimate; empty where it has one."""
    if run.vibration is not None and run.sound.source == "vibration":
        reason = not_linear(run.vibration)
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
    if result.stretches and result.stretches.fault:
        return f"a stretch could not be solved again: {result.stretches.fault}"
    if not error_stretches.stretch_firsts(scene, result):
        return error_cost.too_short(scene) or "its stretches are not marched"
    return "the record is silent" if sound.levels.level_db is None else ""


def known_bands(values: Array) -> dict[str, float | None]:
    """Return values by nominal frequency, None where they are unknown."""
    return dict(zip(BAND_NAMES, map(known, values.tolist()), strict=True))
