"""Errors that grid and solver leave in the levels of a run.

An error is the reported value less the estimated true value: too loud is positive. The sound and
its levels stay as they were computed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, OFF_DB
from acoustics.numbers import rounded
from rolling.check import error_cost
from rolling.marches import error_stretches
from rolling.marches.result import Result
from rolling.scene.scene import Scene
from rolling.sound import error_estimate
from rolling.sound.contact_sound import ContactSound
from rolling.sound.error_estimate import DetailErrors, LevelErrors, RecordLevels
from rolling.sound.vibration_sound import Vibration

LINEAR = 0.3  # rms of the contact force over the load up to which sphere and plate are linear


@dataclass(frozen=True)
class RunErrors:
    """Errors of a run, or the reason why there are none.

    levels : LevelErrors. Errors of levels and signal; None without numbers.
    reason : str. Reason why there are no numbers; empty if there are.
    stretches, steps : int. Number of marched stretches, and of steps of each.
    worst_uncertainty_db : float, dB. Maximum standard error of the judged bands; inf: unknown.
    plastic_ratio : (float, float). Relative error of the plastic ratio from the grid and its
        standard uncertainty; NaN: unknown.
    detail : DetailErrors. Errors from missing detail below the spacing; None: unknown.
    """

    levels: LevelErrors | None
    reason: str = ""
    stretches: int = 0
    steps: int = 0
    worst_uncertainty_db: float = math.inf
    plastic_ratio: tuple[float, float] = (math.nan, math.nan)
    detail: DetailErrors | None = None

    @property
    def grid_db(self) -> dict[str, float | None]:
        """Errors of the band levels from the grid [dB]."""
        return _by_band(self.levels.grid_db if self.levels else None)

    @property
    def grid_uncertainty_db(self) -> dict[str, float | None]:
        """Standard errors of these errors [dB]."""
        return _by_band(self.levels.grid_uncertainty_db if self.levels else None)

    @property
    def solver_db(self) -> dict[str, float | None]:
        """Errors of the band levels from the solver [dB]."""
        return _by_band(self.levels.solver_db if self.levels else None)

    @property
    def subgrid_db(self) -> dict[str, float | None]:
        """Errors of the band levels from missing detail below the spacing [dB]."""
        return _by_band(self.detail.bands_db if self.detail else None)

    @property
    def total_db(self) -> dict[str, float | None]:
        """Errors of the band levels from grid and solver together [dB]."""
        solver = self.solver_db
        return {
            name: None if grid is None else grid + (solver[name] or 0.0)
            for name, grid in self.grid_db.items()
        }

    @property
    def for_plots(self) -> tuple[dict[str, float | None], dict[str, float | None]] | None:
        """Errors of the band levels and their standard errors [dB]; None without numbers."""
        return (self.total_db, self.grid_uncertainty_db) if self.levels else None

    def off_db(self) -> dict[str, float]:
        """Return the errors that exceed 1 dB by more than their standard error [dB]."""
        spread = self.grid_uncertainty_db
        return {
            name: error
            for name, error in self.total_db.items()
            if error is not None and abs(error) > OFF_DB + (spread[name] or 0.0)
        }

    def corrected_db(self, levels: Mapping[str, float | None]) -> dict[str, float | None]:
        """Return band levels less their errors [dB]; None where either is unknown."""
        errors = self.total_db
        return {
            name: None if level is None or (error := errors[name]) is None else level - error
            for name, level in levels.items()
        }


def run_errors(
    scene: Scene, result: Result, sound: ContactSound, vibration: Vibration | None = None
) -> RunErrors | None:
    """Estimate the errors of a run from its stretches; None if the scene does not ask for it."""
    if not scene.numerics.error_estimate:
        return None
    vibrating = vibration if sound.source == "vibration" else None
    if reason := _not_linear(vibrating) or _reason(scene, result, sound):
        return RunErrors(None, reason)
    powers = error_stretches.stretch_powers(scene, result)
    own_factor = sound.source == "release" and scene.sound.gain_pa_per_w_m2 is None
    lap_s = sound.duration * result.solved_steps / result.steps
    record = RecordLevels.of(sound.levels, own_factor, lap_s)
    tight, fine = (
        error_stretches.plastic_areas(scene, result, level) for level in ("tight", "fine")
    )
    detail = None if scene.height_paths else error_estimate.NO_DETAIL
    if with_detail := error_stretches.detail_powers(scene, result):
        detail = error_estimate.detail_errors(with_detail, record)
    return RunErrors(
        error_estimate.level_errors(powers, record),
        stretches=len(error_stretches.stretch_firsts(scene, result)),
        steps=result.stretches.steps if result.stretches else 0,
        worst_uncertainty_db=error_estimate.worst_uncertainty_db(powers),
        plastic_ratio=error_estimate.mean_error(tight, fine),
        detail=detail,
    )


def numbers(
    errors: RunErrors | None, record_db: float | None, others_db: Mapping[str, float] | None = None
) -> dict[str, Any]:
    """Return the numbers for summary.json, none if the scene does not ask for an estimate.

    errors : RunErrors. The errors of the run, or None.
    record_db : float, dB. Standard uncertainty of LAeq from the length of the record, or None.
    others_db : mapping, dB. Uncertainty of a vibration's LAeq by name of its origin. Default: none.
    """
    if errors is None:
        return {}
    levels, detail = errors.levels, errors.detail
    grid, spread, solver = (
        getattr(levels, f"laeq_{name}_db", math.nan)
        for name in ("grid", "grid_uncertainty", "solver")
    )
    # The level is not corrected for the error of the grid, which therefore counts whole.
    parts = {
        "record": record_db,
        "grid": known(math.hypot(grid, spread)),
        "solver": known(abs(solver)),
    } | dict(others_db or {})
    if detail and detail is not error_estimate.NO_DETAIL:
        parts["subgrid"] = known(math.hypot(detail.laeq_db, detail.laeq_uncertainty_db))
    total = math.sqrt(sum(part**2 for part in parts.values() if part is not None))
    return {
        "grid_error_db": errors.grid_db,
        "grid_error_uncertainty_db": errors.grid_uncertainty_db,
        "solver_error_db": errors.solver_db,
        "laeq_grid_error_db": known(grid),
        "laeq_grid_error_uncertainty_db": known(spread),
        "laeq_solver_error_db": known(solver),
        "subgrid_error_db": errors.subgrid_db,
        "subgrid_error_uncertainty_db": _by_band(detail.bands_uncertainty_db if detail else None),
        "laeq_subgrid_error_db": detail and known(detail.laeq_db),
        "laeq_subgrid_error_uncertainty_db": detail and known(detail.laeq_uncertainty_db),
        "plastic_ratio_grid_error": known(errors.plastic_ratio[0]),
        "plastic_ratio_grid_error_uncertainty": known(errors.plastic_ratio[1]),
        "grid_signal_db": known(getattr(levels, "grid_signal_db", math.nan)),
        "grid_signal_uncertainty_db": known(
            getattr(levels, "grid_signal_uncertainty_db", math.nan)
        ),
        "solver_signal_db": known(getattr(levels, "solver_signal_db", math.nan)),
        "laeq_uncertainty_db": None if levels is None else total,
        "laeq_uncertainty_parts_db": parts,
        "error_estimate": {"reason": errors.reason}
        if levels is None
        else {
            "stretches": errors.stretches,
            "steps": errors.steps,
            "order": levels.order,
            "order_measured": levels.order_measured,
            "worst_uncertainty_db": known(errors.worst_uncertainty_db),
        },
    }


def known(value: float) -> float | None:
    """Return a number for JSON, None where it is not finite."""
    return value if math.isfinite(value) else None


def _not_linear(vibration: Vibration | None) -> str:
    """Explain that no linear chain carries an error to the sound; empty where one does."""
    if vibration is None:
        return ""
    lost, rms = vibration.motion.flight_share > 0, vibration.rms_ratio
    if not lost and rms <= LINEAR:
        return ""
    words = (
        "contact is lost" if lost else f"the contact force fluctuates by {rounded(rms)} of the load"
    )
    return f"{words}, and no linear chain carries an error of the approach to the sound then"


def _reason(scene: Scene, result: Result, sound: ContactSound) -> str | None:
    """Explain why a run has no estimate, or return None."""
    if scene.is_smooth:
        return "a smooth surface makes no sound whose error could be estimated"
    if result.stretches and result.stretches.fault:
        return f"a stretch could not be solved again: {result.stretches.fault}"
    if not error_stretches.stretch_firsts(scene, result):
        return error_cost.too_short(scene) or "its stretches are not marched"
    return "the record is silent" if sound.levels.level_db is None else None


def _by_band(values: Array | None) -> dict[str, float | None]:
    """Return values by nominal frequency, None where they are unknown."""
    decibels = [math.nan] * len(BAND_NAMES) if values is None else np.asarray(values).tolist()
    return {name: known(value) for name, value in zip(BAND_NAMES, decibels, strict=True)}
