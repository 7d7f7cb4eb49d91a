"""The summary of a run, its provenance, and the table of levels for the terminal."""

from __future__ import annotations

import math
import platform
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from typing import Any

import numpy as np

from acoustics import loudness
from rolling import tables
from rolling.check import cost, findings, height_files
from rolling.contact import closed_forms
from rolling.folders import program
from rolling.scene.scene import Scene
from rolling.simulation import caveats, force_law, run_errors, simulate
from rolling.simulation.labels import printable
from rolling.simulation.moving_load import MovingRelease
from rolling.simulation.result import Result
from rolling.simulation.run_errors import RunErrors
from rolling.sound.contact_sound import ContactSound
from rolling.sound.vibration_sound import Vibration
from rolling.surface.levelling import Levelling
from rolling.surface.scene_surface import scene_surface

PACKAGES = ("numpy", "scipy", "numba", "pyfftw", "soundfile", "matplotlib", "h5py", "pydantic")
ERROR_HEADS = "grid error dB", "solver error dB"  # of LAeq, where the scene asks for them


def summarize(
    scene: Scene,
    result: Result,
    sound: ContactSound,
    sound_seconds: float,
    errors: RunErrors | None = None,
    vibration: Vibration | None = None,
    moving: MovingRelease | None = None,
) -> dict[str, Any]:
    """Collect the numbers of a run over the solved steps; levels of silence are None.

    `moving` is the release under the moving load, or its fault.
    """
    steps = result.done_steps
    made = scene_surface(scene)
    solved_time = result.whole("step_time")[: min(steps, result.solved_steps)]
    return {
        "name": scene.name,
        "load_n": scene.load,
        "complete": result.complete,
        "steps": steps,
        **_levels(sound),
        **run_errors.numbers(
            errors, sound.uncertainty.laeq_db, _law_error_db(scene, result, vibration)
        ),
        **_loudness(scene, sound),
        **_release(sound),
        **_contact(scene, result),
        **_tolerance(scene, result),
        "step_ms": float(np.median(solved_time) * 1e3),
        "seconds": float(solved_time.sum()),
        "sound_seconds": sound_seconds,
        "caveats": [
            asdict(each)
            for each in caveats.caveats(
                scene, sound, findings.findings(scene), result.complete, errors, vibration, moving
            )
        ],
        "surface": asdict(made.statistics),
        "levelling": None if made.levelling is None else _levelling(made.levelling),
    }


def _levels(sound: ContactSound) -> dict[str, Any]:
    """Collect the levels of a sound with their uncertainties."""
    return {
        "laeq_db": sound.levels.laeq_db,
        "level_db": sound.levels.level_db,
        "laf_max_db": sound.levels.laf_max_db,
        "las_max_db": sound.levels.las_max_db,
        "lz_peak_db": sound.levels.lz_peak_db,
        "steady_level_db": sound.steady_level,
        "uncertainty_db": {
            "laeq": sound.uncertainty.laeq_db,
            "level": sound.uncertainty.level_db,
            "laf_max": sound.uncertainty.laf_max_db,
            "las_max": sound.uncertainty.las_max_db,
            "lz_peak": sound.uncertainty.lz_peak_db,
            "steady": sound.steady_uncertainty,
        },
        "third_octave_db": sound.levels.third_octave_db,
        "third_octave_a_db": sound.levels.third_octave_a_db,
        "third_octave_uncertainty_db": sound.uncertainty.third_octave_db,
    }


def _release(sound: ContactSound) -> dict[str, Any]:
    """Collect the duration of a sound, and the release power behind it."""
    return {
        "duration_s": sound.duration,
        "loops": sound.loops,
        "highest_frequency_hz": sound.highest,
        "factor_pa_per_w_m2": sound.factor,
        "release_power_mean_w": sound.mean_power,
        "release_power_rms_w": sound.power_rms,
        "release_power_audible_rms_w": sound.audible_rms,
        "release_power_resolved_rms_w": sound.resolved_rms,
    }


def _contact(scene: Scene, result: Result) -> dict[str, Any]:
    """Collect areas, pressure, balance and effort over the solved steps."""
    steps = result.done_steps
    defect = result.whole("energy_defect")[:steps]
    state = {name: result.whole(name)[: steps + 1] for name in simulate.STATE_SERIES}
    hertz_area = (
        np.pi * closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus) ** 2
    )
    plastic = float(state["plastic_area"].mean())
    return {
        "hertz_area_m2": float(hertz_area),
        "contact_area_mean_m2": float(state["contact_area"].mean()),
        "plastic_area_mean_m2": plastic,
        "plastic_ratio": plastic / float(hertz_area),
        "max_pressure_pa": float(state["max_pressure"].max()),
        "energy_balance_error": float(np.abs(defect).max() / state["stored_energy"].max()),
        "residual_max": float(state["residual"].max()),
        "iterations_mean": float(state["iterations"].mean()),
        "convolutions_mean": float(state["convolutions"].mean()),
    }


def _law_error_db(scene: Scene, result: Result, vibration: Vibration | None) -> float | None:
    """Return the error of the heard level from the force law [dB]; None for a release."""
    if vibration is None or scene.sound.source == "release":
        return None
    error = force_law.law_error(scene, result, vibration.law.load_n.tolist())
    return None if error is None else error.decibels


def _tolerance(scene: Scene, result: Result) -> dict[str, Any]:
    """Collect the tolerance, and the trial behind it if the scene left it open."""
    trial = result.trial
    numbers: dict[str, Any] = {"tolerance": scene.tolerance, "tolerance_chosen": trial is not None}
    if trial is None:
        return numbers
    if trial.reason:
        return numbers | {"tolerance_trial": {"reason": trial.reason}}
    return numbers | {
        "tolerance_trial": {
            "stretches": trial.stretches,
            "steps": trial.steps,
            "grid_signal_db": trial.grid_signal_db,
            "solver_signal_db": trial.solver_signal_db,
            "seconds": trial.seconds,
        }
    }


def _levelling(levelling: Levelling) -> dict[str, Any]:
    """Collect the tilt removed from the heights of a file, and the seam of the levelled heights."""
    (along, across), (rise_along, rise_across), seam = (
        levelling.taken,
        levelling.rises,
        levelling.seams[0],
    )
    return {
        "slope_along": along,
        "slope_across": across,
        "height_along_m": rise_along,
        "height_across_m": rise_across,
        "ra_before_m": levelling.ra_before,
        "ra_after_m": levelling.ra_after,
        "seam_step_m": seam.step,
        "seam_neighbours_m": seam.neighbours,
        "seam_stands_out": seam.stands_out,
        "text": height_files.tilt_text(levelling),
    }


def _loudness(scene: Scene, sound: ContactSound) -> dict[str, float | None]:
    """Compute loudness and sharpness if the scene requests them."""
    if not scene.sound.loudness:
        return {}
    result = loudness.loudness(sound.pressure, sound.sample_rate, sound.closed)
    return {"loudness_sone": result.sone, "sharpness_acum": result.acum}


def provenance(scene: Scene) -> dict[str, Any]:
    """Collect the provenance of the numbers: versions, state of the source, machine, seed."""
    made_by = program.identity()
    packages = (*PACKAGES, "mosqito") if scene.sound.loudness else PACKAGES
    return {
        "program": made_by.version,
        "source": made_by.commit and f"{made_by.commit[:12]}{'-dirty' if made_by.dirty else ''}",
        "python": platform.python_version(),
        "packages": {name: _version(name) for name in packages},
        "machine": f"{platform.system()} {platform.machine()}, {cost.cores()} processors",
        "seed": getattr(scene.surface, "seed", None),
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
    }


@cache
def _version(package: str) -> str:
    """Return the version of an installed package, looked up once."""
    return metadata.version(package)


def uncertain(level: float, uncertainty: float | None) -> str:
    """Write a level with its standard uncertainty [dB], rounded up to a tenth.

    The uncertainty never prints as 0.0 dB, because no level is known exactly.
    """
    return f"{level:.1f}" + (
        "" if uncertainty is None else f" ± {math.ceil(uncertainty * 10) / 10:.1f}"
    )


def laeq_errors(summary: dict[str, Any]) -> tuple[str, str]:
    """Write the errors of LAeq from grid and solver [dB]; `-` where they are unknown."""
    grid, solver = summary.get("laeq_grid_error_db"), summary.get("laeq_solver_error_db")
    spread = summary.get("laeq_grid_error_uncertainty_db")
    return (
        "-" if grid is None else f"{grid:+.2f}" + ("" if spread is None else f" ± {spread:.2f}"),
        "-" if solver is None else f"{solver:+.2f}",
    )


def error_line(label: str, summary: dict[str, Any]) -> str:
    """Write the error estimate of a run, or an empty text without one."""
    estimate = summary.get("error_estimate")
    if estimate is None or "reason" in estimate or summary["laeq_grid_error_db"] is None:
        return ""
    grid, solver = summary["laeq_grid_error_db"], summary["laeq_solver_error_db"] or 0.0
    signal_name = "sound" if summary.get("source") == "vibration" else "release"
    corrected = uncertain(summary["laeq_db"] - grid - solver, summary["uncertainty_db"]["laeq"])
    signal = [
        f"{summary[key]:.0f} dB from the {name}"
        for key, name in (("grid_signal_db", "grid"), ("solver_signal_db", "solver"))
        if summary[key] is not None
    ]
    return (
        f"errors of {label}: LAeq corrected for grid and solver {corrected} dB(A); rms error of the"
        f" {signal_name} over its fluctuation {', '.join(signal)};"
        f" {estimate['stretches']} stretches of {estimate['steps']} steps,"
        f" order {estimate['order']:.1f}, {estimate['seconds_share']:.0%} of the run's time"
    )


def table(runs: Sequence[tuple[str, str, dict[str, Any] | None]]) -> str:
    """Write levels and cost of runs as a table for the terminal.

    LAeq stands with its standard uncertainty. The caveats of all levels follow the table.

    Parameters
    ----------
    runs : sequence of tuples. Label, folder and summary of each run; the summary is None where too
        few steps are solved.
    """
    estimated = any("error_estimate" in summary for _, _, summary in runs if summary)
    head = (
        "run",
        "LAeq dB(A)",
        *(ERROR_HEADS if estimated else ()),
        "LZeq dB",
        "steady dB",
        "plastic ratio",
        "steps",
        "ms/step",
        "files",
    )
    rows: list[tuple[str, ...]] = [head]
    for label, folder, summary in runs:
        if summary is None:
            rows.append((label, *["-"] * (len(head) - 2), printable(folder)))
            continue

        def db(name: str, summary: dict[str, Any] = summary) -> str:
            if summary[name] is None:
                no_level = name == "steady_level_db" and summary.get("source") == "vibration"
                return "-" if no_level else "silent"
            return f"{summary[name]:.1f}"

        laeq = "silent"
        if summary["laeq_db"] is not None:
            laeq = uncertain(summary["laeq_db"], summary["uncertainty_db"]["laeq"])
        steps = f"{summary['steps']}" + ("" if summary["complete"] else " (partial)")
        rows.append(
            (
                label,
                laeq,
                *(laeq_errors(summary) if estimated else ()),
                db("level_db"),
                db("steady_level_db"),
                f"{summary['plastic_ratio']:.3f}",
                steps,
                f"{summary['step_ms']:.1f}",
                printable(folder),
            )
        )
    remarks = _remarks([(label, summary) for label, _, summary in runs if summary is not None])
    errors = [error_line(label, summary) for label, _, summary in runs if summary is not None]
    return "\n".join([tables.columns(rows), *filter(None, errors), *remarks])


def _remarks(runs: list[tuple[str, dict[str, Any]]]) -> list[str]:
    """Write the caveats of the levels, the surfaces, the short repetitions and the warnings.

    Each kind of warning is written once.
    """
    remarks = caveats.gathered([(label, caveats.stored(summary)) for label, summary in runs])
    beside = [each for each in remarks if each.key in caveats.HEADLINE]
    of_levels = " ".join(each.line for each in beside if each.key != "uncertainty")
    of_uncertainty = " ".join(each.line for each in beside if each.key == "uncertainty")
    surfaces = dict.fromkeys(
        f"surface: Ra {s['ra'] * 1e6:.4g} µm, Rq {s['rq'] * 1e6:.4g} µm, "
        f"skewness {s['skewness']:.2f},"
        f" kurtosis {s['kurtosis']:.2f}, rms slope {s['rms_slope']:.3g}"
        for s in (summary["surface"] for _, summary in runs)
    )
    levelled = [summary["levelling"] for _, summary in runs if summary.get("levelling")]
    tilts = dict.fromkeys(
        f"tilt: {each['text']}" for each in levelled if each["slope_along"] or each["slope_across"]
    )
    repeats = [f"note: {each.line}" for each in remarks if each.key in caveats.REPEATS]
    warnings = [f"warning: {each.line}" for each in remarks if each.key not in caveats.STANDING]
    return [*filter(None, (of_levels, of_uncertainty)), "", *surfaces, *tilts, *repeats, *warnings]
