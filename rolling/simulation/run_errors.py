"""Errors that grid and solver leave in the levels of a run, as summary, tables and plots show them.

An error is the reported value less the estimated true value: too loud is positive. The sound and
its levels stay as they were computed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from acoustics.bands import BAND_NAMES, OFF_DB
from rolling._typing import Array
from rolling.check import error_cost
from rolling.scene.scene import Scene
from rolling.simulation import error_stretches
from rolling.simulation.result import Result
from rolling.sound import error_estimate
from rolling.sound.contact_sound import ContactSound
from rolling.sound.error_estimate import LevelErrors, RecordLevels
from rolling.sound.vibration_sound import Vibration

LINEAR = 0.3  # rms of the contact force over the load up to which sphere and plate are linear


@dataclass(frozen=True)
class Effort:
    """The marches behind an estimate.

    stretches, steps : int. Number of stretches, and of steps of each.
    seconds_share : float. Time of these marches over the time of the run.
    reached : bool. Whether the standard errors are as small as wanted.
    worst_uncertainty_db : float, dB. Maximum standard error of the judged bands; inf: unknown.
    shared_bands : list of lists of str. Nominal frequencies of bands that share an estimate.
    """

    stretches: int
    steps: int
    seconds_share: float
    reached: bool
    worst_uncertainty_db: float
    shared_bands: list[list[str]]


@dataclass(frozen=True)
class RunErrors:
    """Errors of a run, or the reason why there are none.

    levels : LevelErrors. Errors of levels and signal; None without numbers.
    effort : Effort. The marches behind the numbers; None without numbers.
    plastic_ratio : float. Relative error of the plastic ratio from the grid; NaN: unknown.
    reason : str. Reason why there are no numbers; empty if there are.
    """

    levels: LevelErrors | None
    effort: Effort | None
    plastic_ratio: float
    reason: str

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
    def total_db(self) -> dict[str, float | None]:
        """Errors of the band levels from grid and solver together [dB]."""
        solver = self.solver_db
        return {
            name: None if grid is None else grid + (solver[name] or 0.0)
            for name, grid in self.grid_db.items()
        }

    @property
    def for_plots(self) -> tuple[dict[str, float | None], dict[str, float | None]] | None:
        """Errors of the band levels and their standard uncertainty [dB]; None without numbers."""
        return (self.total_db, self.grid_uncertainty_db) if self.levels else None

    def off_db(self) -> dict[str, float]:
        """Return the errors of bands that are off by more than 1 dB, beyond doubt [dB].

        Their error exceeds 1 dB by more than its standard error.
        """
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
    firsts = error_stretches.marched(scene, result)
    vibrating = vibration if sound.source == "vibration" else None
    if reason := _not_linear(vibrating) or _reason(scene, result, sound, firsts):
        return RunErrors(None, None, math.nan, reason)
    powers = error_stretches.powers_of(scene, result, firsts)
    record = RecordLevels.of(
        sound.levels.third_octave_db,
        sound.levels.third_octave_a_db,
        sound.source == "release" and scene.sound.gain_pa_per_w_m2 is None,
    )
    levels = error_estimate.level_errors(powers, record)
    assert result.stretches is not None
    effort = Effort(
        len(firsts),
        result.stretches.steps,
        result.stretches.seconds / _seconds(result),
        error_stretches.suffices(powers),
        error_estimate.worst_uncertainty_db(powers),
        powers.shared_bands,
    )
    return RunErrors(levels, effort, _plastic_error(result, firsts, levels.order), "")


def _not_linear(vibration: Vibration | None) -> str:
    """Explain that no linear chain carries an error to the sound; empty where one does."""
    if vibration is None:
        return ""
    lost, rms = vibration.motion.flight_share > 0, vibration.rms_ratio
    if not lost and rms <= LINEAR:
        return ""
    words = "contact is lost" if lost else f"the contact force fluctuates by {rms:.2g} of the load"
    return f"{words}, and no linear chain carries an error of the approach to the sound then"


def _seconds(result: Result) -> float:
    """Return the time of the marches of a run at all its loads [s]."""
    others = 0.0 if result.load_marches is None else result.load_marches.seconds
    return float(result.series["step_time"].sum()) + others


def _reason(
    scene: Scene, result: Result, sound: ContactSound, firsts: tuple[int, ...]
) -> str | None:
    """Explain why a run has no estimate, or return None."""
    if scene.surface.kind == "smooth":
        return "a smooth surface makes no sound whose error could be estimated"
    if not result.complete:
        return "the run is not complete"
    if not result.stretches and (text := error_cost.too_short(scene)):
        return text
    if result.stretches and result.stretches.fault:
        return f"a stretch could not be solved again: {result.stretches.fault}"
    if result.stretches and error_stretches.lacks_approach(scene, result.stretches):
        return "its stretches were marched without dynamics"
    if len(firsts) < error_cost.FIRST_STRETCHES:
        return "its stretches are not solved yet"
    if sound.levels.level_db is None:
        return "the record is silent"
    return None


def _plastic_error(result: Result, firsts: tuple[int, ...], order: float) -> float:
    """Return the relative error of the area at the hardness from the grid; NaN without one."""
    tight, fine = (
        float(error_stretches.plastic_areas(result, firsts, level).mean())
        for level in ("tight", "fine")
    )
    if not fine > 0:
        return math.nan
    return error_estimate.refinement_factor(order) * (tight / fine - 1.0)


def _by_band(values: Array | None) -> dict[str, float | None]:
    """Return values by nominal frequency, None where they are unknown."""
    if values is None:
        return dict.fromkeys(BAND_NAMES)
    return {name: _known(float(value)) for name, value in zip(BAND_NAMES, values, strict=True)}


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def numbers(
    errors: RunErrors | None, record_db: float | None, law_db: float | None = None
) -> dict[str, Any]:
    """Return the numbers for summary.json, none if the scene does not ask for an estimate.

    Parameters
    ----------
    errors : RunErrors. The errors of the run, or None.
    record_db : float, dB. Standard uncertainty of LAeq from the length of the record, or None.
    law_db : float, dB. Error of the level of a vibration from its force law. Default: none.
    """
    if errors is None:
        return {}
    levels, effort = errors.levels, errors.effort
    laeq_grid = laeq_spread = laeq_solver = grid_signal = solver_signal = math.nan
    if levels is not None:
        laeq_grid, laeq_solver = levels.laeq_grid_db, levels.laeq_solver_db
        laeq_spread = levels.laeq_grid_uncertainty_db
        grid_signal, solver_signal = levels.grid_signal_db, levels.solver_signal_db
    parts = {
        "record": record_db,
        "grid": _known(math.hypot(laeq_grid, laeq_spread)),
        "solver": _known(abs(laeq_solver)),
    }
    if law_db is not None:
        parts["force_law"] = law_db
    return {
        "grid_error_db": errors.grid_db,
        "grid_error_uncertainty_db": errors.grid_uncertainty_db,
        "solver_error_db": errors.solver_db,
        "laeq_grid_error_db": _known(laeq_grid),
        "laeq_grid_error_uncertainty_db": _known(laeq_spread),
        "laeq_solver_error_db": _known(laeq_solver),
        "plastic_ratio_grid_error": _known(errors.plastic_ratio),
        "grid_signal_db": _known(grid_signal),
        "solver_signal_db": _known(solver_signal),
        "laeq_uncertainty_db": _combined(parts) if levels is not None else None,
        "laeq_uncertainty_parts_db": parts,
        "error_estimate": {"reason": errors.reason}
        if levels is None or effort is None
        else {
            "stretches": effort.stretches,
            "steps": effort.steps,
            "order": levels.order,
            "order_measured": levels.order_measured,
            "seconds_share": effort.seconds_share,
            "reached": effort.reached,
            "worst_uncertainty_db": _known(effort.worst_uncertainty_db),
            "shared_bands": effort.shared_bands,
        },
    }


def _combined(parts: Mapping[str, float | None]) -> float:
    """Return the root of the sum of squares of the known parts [dB].

    The part of the grid is its estimated error together with the standard error of the estimate,
    because the level is not corrected for it.
    """
    return float(np.sqrt(sum(part**2 for part in parts.values() if part is not None)))
