"""The numbers of summary.json and the provenance of a run."""

from __future__ import annotations

import math
import platform
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

import rolling
from acoustics import ears, loudness, uncertainty, wav
from acoustics.arrays import Array
from acoustics.level import SoundLevels, is_single_event, lae_db, level_db
from acoustics.modulation import MIN_PERIODS, envelope_spectrum, modulated_octave
from acoustics.numbers import rounded
from rolling.check import cost, heights
from rolling.dynamics import drop, of_scene
from rolling.dynamics.motion import BodyMotion
from rolling.dynamics.smooth_contact import maximum_pressure, semi_axes
from rolling.marches import effort, force_law
from rolling.marches.observers import STATE_SERIES
from rolling.marches.passes import Passes
from rolling.marches.result import MovingRelease, Result, released_energy
from rolling.marches.stiffness import solved_stiffness
from rolling.results import verdict
from rolling.results.description import runs_sentence
from rolling.results.doubts import doubts
from rolling.results.instrument_spread import instrument_numbers, part_db
from rolling.results.run_errors import error_numbers, known, known_bands
from rolling.results.solved_run import SolvedRun
from rolling.scene.scene import Scene
from rolling.sound import radiators
from rolling.sound.contact_sound import ContactSound
from rolling.sound.missing_band import MissingBand, missing_band
from rolling.sound.vibration_sound import P_REF_W, Vibration, by_band, compact_source_db
from rolling.surface.levelling import Levelling
from rolling.surface.scene_surface import SceneSurface, scene_surface
from rolling.terminal import program

STEADY_S = 1.0  # [s] of a record that does not close, from which on its loudness is that of a tone
MAXIMA = ("laf_max_db", "las_max_db")  # with a time weighting that a short record may not reach
_ROUNDING_DB = 1e-6
_PACKAGES = ("numpy", "scipy", "numba", "pyfftw", "soundfile", "h5netcdf", "xarray", "pydantic")


def summarize(run: SolvedRun, release: ContactSound) -> dict[str, Any]:
    """Collect the numbers of a run, with the sound of its release; levels of silence are None."""
    scene = run.scene
    result = run.result
    sound = run.sound
    vibration = run.vibration
    surface = scene_surface(scene)
    is_event = _is_event(sound)
    band = _missing_band(run)
    law = _force_law(run)
    moving = result.moving if scene.moves_release else None
    stiffness = _solved_stiffness(run)
    instrument = instrument_numbers(run)
    summary = {
        **_scene(run),
        **_levels(run, is_event),
        **_uncertainty(run),
        **error_numbers(run, _uncertainty_parts(run, law, band, instrument)),
        **_band(band),
        **_loudness(run, is_event),
        **_ears(run),
        **_record(sound, release),
        **_contact(scene, result),
        **_effort(scene, result),
        **_surface(surface),
        **instrument,
        **_turns(scene, surface, sound),
        "wavelength_octaves": [octave._asdict() for octave in run.wavelength_octaves],
    }
    if vibration is not None:
        summary |= _vibration(scene, release, vibration)
    summary |= law
    if moving is not None and not moving.fault:
        summary |= _moving(result, moving)
    if scene.dynamics is None:
        summary |= _vibration_estimate(run, release, stiffness)
    if scene.sound.listen_s is not None:
        summary["listening"] = run.long.numbers if run.long else {"refused": run.no_long}
    found = doubts(scene, sound, summary, vibration, moving)
    summary["doubts"] = verdict.as_json(found)
    summary["verdict"] = None if summary["laeq_db"] is None else verdict.verdict(found)
    summary["answer"] = verdict.answers_as_json(summary, runs_sentence([run]))
    if result.passes is not None:
        summary["passes"] = _passes(run, result.passes, stiffness)
    if run.channels:
        summary["channels"] = [channel.numbers for channel in run.channels]
    return summary


def _scene(run: SolvedRun) -> dict[str, Any]:
    """Return the name, the load and the source of a run, with the q of a release without a gain."""
    scene = run.scene
    sound = run.sound
    has_q = sound.source == "release" and scene.sound.gain_pa_per_w_m2 is None
    return {
        "name": scene.name,
        "load_n": scene.load,
        "steps": run.result.steps,
        "source": sound.source,
        "q": scene.sound.q if has_q else None,
    }


# ---- levels and their uncertainty


def _levels(run: SolvedRun, is_event: bool) -> dict[str, Any]:
    """Return the levels of a record.

    An open record begins in silence. If it ends before the time weighting has risen to the LAeq of
    the record, its maximum with this weighting says how short it is, and nothing of the sound.
    """
    sound = run.sound
    levels = asdict(sound.levels)
    for key in MAXIMA:
        if _is_below_laeq(run, levels[key]):
            levels[key] = None
    return levels | {
        "lae_db": lae_db(sound.pressure, sound.sample_rate),
        "single_event": is_event,
        "record_laeq_db": run.record_laeq_db,
        "steady_level_db": sound.steady_level,
    }


def _is_below_laeq(run: SolvedRun, maximum_db: float | None) -> bool:
    """Tell whether a maximum with a time weighting lies below the LAeq of its record."""
    if maximum_db is None or run.record_laeq_db is None:
        return False
    return maximum_db < run.record_laeq_db - _ROUNDING_DB


def _is_event(sound: ContactSound) -> bool:
    """Tell whether a record is a fall or another single event; one that closes repeats."""
    if sound.once:
        return True
    return not sound.closed and is_single_event(sound.pressure, sound.sample_rate)


def _uncertainty(run: SolvedRun) -> dict[str, Any]:
    """Return the standard uncertainties of the levels from the length of the record [dB]."""
    sound = run.sound
    vibration = run.vibration
    stated = asdict(sound.uncertainty)
    third_octaves = stated.pop("third_octave_db")
    spreads = {name.removesuffix("_db"): spread for name, spread in stated.items()}
    spreads["lae"] = spreads["laeq"]  # they differ by the duration, or by a comb that ± covers
    levels = asdict(sound.levels)
    for key in MAXIMA:
        if levels[key] is None or _is_below_laeq(run, levels[key]):
            spreads[key.removesuffix("_db")] = None
    spreads["steady"] = sound.steady_uncertainty
    laps = run.result.steps / run.result.solved_steps
    if sound.source == "vibration" and not (vibration and vibration.motion.settled):
        laps = 1.0  # the motion does not repeat from lap to lap
    return {
        "uncertainty_db": spreads,
        "third_octave_uncertainty_db": third_octaves,
        "record_scatter_db": record_scatter(sound.pressure, laps),
    }


def _uncertainty_parts(
    run: SolvedRun,
    law: Mapping[str, Any],
    band: MissingBand | None,
    instrument: Mapping[str, Any],
) -> dict[str, float | None]:
    """Return the uncertainties of LAeq [dB] by their origin, but for grid and solver."""
    parts: dict[str, float | None] = {"record": run.sound.uncertainty.laeq_db}
    if run.vibration is not None and run.sound.source == "vibration":
        parts = {**run.vibration.parts}
        law_error = law.get("force_law_error_db")
        if law_error is not None:
            parts["force_law"] = law_error
    if band is not None:
        parts["band"] = float(np.hypot(band.error_db, band.uncertainty_db))
    of_instrument = part_db(instrument, run.sound.source)
    if of_instrument is not None:
        parts["instrument"] = of_instrument
    return parts


def record_scatter(pressure: Array, laps: float = 1.0) -> float | None:
    """Return the scatter of LAeq between thirds of the different laps of a record [dB]."""
    lap = pressure[: round(len(pressure) / max(1.0, laps))]
    return uncertainty.record_scatter_db(lap, wav.SAMPLE_RATE_HZ)


def _loudness(run: SolvedRun, is_event: bool) -> dict[str, float | None]:
    """Compute loudness and sharpness if the scene requests them.

    A steady sound has one loudness. The loudness of falls, impacts and changing speeds, and that of
    a short record, has numbers of its course in time.
    """
    sound = run.sound
    vibration = run.vibration
    if not run.scene.sound.loudness:
        return {}
    flies = False
    if sound.source == "vibration" and vibration is not None:
        flies = vibration.motion.flight_share > 0
    is_steady = sound.constant_speed and not flies and not is_event
    is_short = sound.duration < STEADY_S
    numbers: dict[str, float | None] = {
        "loudness_sone": None,
        "sharpness_acum": None,
        "loudness_n5_sone": None,
        "loudness_max_sone": None,
    }
    if is_steady and (sound.closed or not is_short):  # a short record that closes is looped
        steady = loudness.loudness(sound.pressure, sound.sample_rate, sound.closed)
        numbers["loudness_sone"] = steady.sone
        numbers["sharpness_acum"] = steady.acum
    if is_short or not is_steady:
        varying = loudness.varying_loudness(sound.pressure, sound.sample_rate, sound.closed)
        numbers["loudness_n5_sone"] = varying.n5_sone
        numbers["loudness_max_sone"] = varying.max_sone
    return numbers


def _ears(run: SolvedRun) -> dict[str, Any]:
    """Compute roughness and prominence of tones if the scene requests loudness.

    They are null where a record is too short, and for tones where none is found.
    """
    sound = run.sound
    if not run.scene.sound.loudness:
        return {}
    found = ears.tones(sound.pressure, sound.sample_rate)
    numbers: dict[str, Any] = {
        "roughness_asper": ears.roughness_asper(sound.pressure, sound.sample_rate),
        "tone_to_noise_db": None,
        "tone_to_noise_hz": None,
        "tone_to_noise_prominent": None,
        "prominence_ratio_db": None,
        "prominence_ratio_hz": None,
        "prominence_ratio_prominent": None,
    }
    if found is None:
        return numbers
    for name, tone in (
        ("tone_to_noise", found.tone_to_noise),
        ("prominence_ratio", found.prominence),
    ):
        numbers[f"{name}_prominent"] = tone is not None and tone.is_prominent
        if tone is not None:
            numbers[f"{name}_db"] = tone.decibels
            numbers[f"{name}_hz"] = tone.frequency_hz
    return numbers


def _missing_band(run: SolvedRun) -> MissingBand | None:
    """Return the part of the sound that the Nyquist frequency of the steps cuts off."""
    result = run.result
    if run.sound.source == "vibration":
        series = result.series["approach"]
        vibration = run.vibration
    else:
        series, _ = released_energy(run.scene, result)
        vibration = None
    lap = series[: result.solved_steps]
    return missing_band(run.scene, run.sound, lap, result.step, vibration)


def _band(band: MissingBand | None) -> dict[str, Any]:
    """Return what the missing band does to LAeq [dB], and where it begins [Hz]."""
    return {
        "laeq_band_error_db": None if band is None else band.error_db,
        "laeq_band_error_uncertainty_db": None if band is None else band.uncertainty_db,
        "laeq_band_end_hz": None if band is None else band.highest_hz,
    }


def _record(sound: ContactSound, release: ContactSound) -> dict[str, Any]:
    """Return duration and band of a record, and the powers of its release."""
    return {
        "duration_s": sound.duration,
        "loops": sound.loops,
        "highest_frequency_hz": sound.highest,
        "factor_pa_per_w_m2": sound.factor,
        "release_power_mean_w": release.mean_power,
        "release_power_rms_w": release.power_rms,
        "release_power_audible_rms_w": release.audible_rms,
        "release_power_resolved_rms_w": release.resolved_rms,
    }


# ---- contact and surface


def _contact(scene: Scene, result: Result) -> dict[str, Any]:
    """Return areas, pressure, balance and effort over all positions."""
    state = {name: result.whole_series(name) for name in STATE_SERIES}
    length, width = semi_axes(scene)
    hertz_area = float(np.pi * (length * width))
    plastic = float(state["plastic_area"].mean())
    defect = np.abs(result.whole_series("energy_defect")).max()
    return {
        "hertz_area_m2": hertz_area,
        "contact_area_mean_m2": float(state["contact_area"].mean()),
        "plastic_area_mean_m2": plastic,
        "plastic_ratio": plastic / hertz_area,
        "max_pressure_pa": float(state["max_pressure"].max()),
        "energy_balance_error": float(defect / state["stored_energy"].max()),
        "energy_joint_error": joint_error(scene, result),
        "residual_max": float(state["residual"].max()),
        "iterations_mean": float(state["iterations"].mean()),
        "convolutions_mean": float(state["convolutions"].mean()),
    }


def joint_error(scene: Scene, result: Result) -> float | None:
    """Return the largest difference of the stored energy at joints over its maximum.

    A position where two pieces join is solved twice: at the end of a piece, and from a cold start
    at the beginning of the next. A step has the energies of its own piece, and the series has the
    state of the piece before, so their balance misses the difference of both solves. The end of a
    closed lap is the solve of its beginning once more.

    It is None for a plate that remembers, whose loading includes the plastic work.
    """
    if scene.is_permanent:
        return None
    series = result.series
    stored = series["stored_energy"]
    own_change = series["loading_energy"] - series["release_energy"] - series["energy_defect"]
    differences = np.abs(own_change - np.diff(stored))
    largest = float(differences.max())
    if scene.track.steps >= scene.track.lap_steps:
        largest = max(largest, float(abs(stored[-1] - stored[0])))
    return largest / float(stored.max())


def _effort(scene: Scene, result: Result) -> dict[str, Any]:
    """Return tolerance and steps, and processor times, which a march from a file lacks."""
    times = result.series["step_time"]
    times = times[np.isfinite(times)]
    choice = scene.step_choice
    return {
        "tolerance": scene.tolerance,
        "step_nodes": scene.step_nodes,
        "step_choice": scene.step_reason,
        "step_lowest_speed_m_s": choice.lowest if choice is not None and choice.lowest else None,
        "step_ms": float(np.median(times) * 1e3) if len(times) else None,
        "march_cpu_s": result.effort.march_s,
        effort.PARTS: result.effort.numbers(effort.OF_SPHERE),
    }


def _surface(surface: SceneSurface) -> dict[str, Any]:
    """Return the roughness of a surface, and how its heights were made or prepared."""
    numbers = {
        "surface": asdict(surface.statistics),
        "levelling": None if surface.levelling is None else _levelling(surface.levelling),
        **surface.made,
    }
    if surface.preparation:
        numbers["preparation"] = [asdict(step) for step in surface.preparation]
    return numbers


def _levelling(levelling: Levelling) -> dict[str, Any]:
    """Return the tilt removed from the heights of a file, and the seam of the levelled heights."""
    seam = levelling.seams[0]
    return {
        "slope_along": levelling.taken[0],
        "slope_across": levelling.taken[1],
        "height_along_m": levelling.rises[0],
        "height_across_m": levelling.rises[1],
        "ra_before_m": levelling.ra_before,
        "ra_after_m": levelling.ra_after,
        "seam_step_m": seam.step,
        "seam_neighbours_m": seam.neighbours,
        "seam_stands_out": seam.stands_out,
        "text": heights.tilt_text(levelling),
    }


def _turns(scene: Scene, surface: SceneSurface, sound: ContactSound) -> dict[str, Any]:
    """Return the turns of a sphere with a surface, and how they modulate an octave."""
    track = scene.track
    if not track.turn_nodes or surface.part_ra is None:
        return {}
    plate_ra, ball_ra = surface.part_ra
    turn_hz = None
    if scene.motion.is_constant(sound.duration):
        turn_hz = track.turns / sound.duration
    numbers = {
        "turns": track.turns,
        "plate_ra_m": plate_ra,
        "ball_ra_m": ball_ra,
        "turn_hz": turn_hz,
        "turn_modulation": None,
        "turn_prominence": None,
        "turn_band_hz": None,
    }
    if sound.levels.laeq_db is None:
        return numbers | {"turn_reason": "the record is silent"}
    if sound.once:
        reason = "the sphere falls, and does not roll over the same places again and again"
        return numbers | {"turn_reason": reason}
    if turn_hz is None:
        return numbers | {"turn_reason": "the speed changes, so the turns have no single frequency"}
    pressure = sound.pressure
    rate = sound.sample_rate
    band = modulated_octave(pressure, rate, turn_hz, sound.closed, sound.fade)
    spectrum = envelope_spectrum(pressure, rate, band, sound.closed, sound.fade)
    prominence = spectrum.prominence(turn_hz)
    if prominence is None:
        return numbers | {"turn_reason": _unknown_prominence(scene, turn_hz)}
    return numbers | {
        "turn_modulation": spectrum.at(turn_hz),
        "turn_prominence": prominence,
        "turn_band_hz": list(spectrum.band_hz),
        "turn_reason": None,
    }


def _unknown_prominence(scene: Scene, turn_hz: float) -> str:
    """Explain why nobody can tell whether a record at constant speed repeats with the turns."""
    turns = scene.track.turns
    turn = scene.track.turn_nodes * scene.track.spacing
    if turns < MIN_PERIODS:
        least_mm = math.ceil(MIN_PERIODS * turn * 1e4) / 10
        return (
            f"the record has {rounded(turns, 3)} turns of the sphere, and whether its sound repeats"
            f" with them can be told from {MIN_PERIODS} turns on; choose a rolling.distance_mm of"
            f" at least {least_mm:g}"
        )
    return (
        f"the octaves that are heard are narrower than six times the {turn_hz:.0f} turns per"
        " second, so their envelopes have no room for the lines of a turn; choose a lower"
        " rolling.speed_m_s"
    )


def _passes(run: SolvedRun, passes: Passes, stiffness: Array | None) -> list[dict[str, Any]]:
    """Return levels, release power, plastic work and maximum depth of each pass.

    The level of the vibration is an estimate from the approach, for scenes without dynamics.
    """
    scene = run.scene
    result = run.result
    steps = np.arange(result.steps) % result.solved_steps
    places = np.append(steps, steps[-1] + 1)
    rows = []
    for k, sound in enumerate(run.pass_sounds):
        vibration_db = None
        if scene.dynamics is None:
            approach = passes.series["approach"][k, places]
            estimate = radiators.vibration_estimate(
                scene, approach, result.step, sound.closed, stiffness
            )
            vibration_db = estimate.laeq_db
        row = {
            "laeq_db": sound.levels.laeq_db,
            "level_db": sound.levels.level_db,
            "vibration_estimate_laeq_db": vibration_db,
            "release_power_mean_w": sound.mean_power,
            "plastic_work_j": float(passes.series["plastic_work"][k].sum()),
            "depth_um": float(passes.depth[k]) * 1e6,
        }
        rows.append(row)
    return rows


# ---- vibration


def _vibration(scene: Scene, release: ContactSound, vibration: Vibration) -> dict[str, Any]:
    """Return the numbers of a vibration: levels of both sources, power, force, bodies, motion."""
    return {
        **_difference(scene, release.levels, vibration.stated_levels),
        **_fall(scene, vibration.motion),
        **_mean_level(scene, vibration),
        **_listeners(scene, vibration),
        **_power(scene, vibration),
        **_force(scene, vibration),
        **_chain(scene, vibration),
        **_limits_of_plate(scene, vibration.motion),
        **_motion(vibration),
    }


def _difference(scene: Scene, release: SoundLevels, vibration: SoundLevels) -> dict[str, Any]:
    """Return the levels of both sources, their difference, and the q that makes them equal.

    Both levels belong to the place where the vibration is heard.
    """
    shift = _shift_to_listener_db(scene)
    levels: dict[str, Any] = {
        "vibration_laeq_db": vibration.laeq_db,
        "vibration_level_db": vibration.level_db,
        "vibration_third_octave_db": vibration.third_octave_db,
        "release_laeq_db": _shifted(release.laeq_db, shift),
        "release_level_db": _shifted(release.level_db, shift),
        "release_third_octave_db": {
            band: _shifted(band_level, shift)
            for band, band_level in release.third_octave_db.items()
        },
    }
    difference = equal = None
    if release.laeq_db is not None and vibration.laeq_db is not None:
        difference = levels["release_laeq_db"] - vibration.laeq_db
        if scene.sound.gain_pa_per_w_m2 is None:  # the level of a release follows 10 lg q
            equal = scene.sound.q * 10 ** (-difference / 10)
    return levels | {"release_over_vibration_db": difference, "equivalent_q": equal}


def _fall(scene: Scene, motion: BodyMotion) -> dict[str, float | None]:
    """Return height and restitution of a fall; its impacts compare with no release."""
    if scene.rolling.drop_mm is None:
        return {}
    return {
        "drop_mm": scene.rolling.drop_mm,
        "restitution": drop.restitution(scene, motion),
        "release_over_vibration_db": None,
        "equivalent_q": None,
    }


def _mean_level(scene: Scene, vibration: Vibration) -> dict[str, float | None]:
    """Return the level of a compact source, which a plate with edges has over a half sphere."""
    level = _shifted(compact_source_db(scene, vibration), _to_mean_db(vibration))
    if of_scene.rectangular_plate(scene) is None:
        return {"compact_source_level_db": level}
    return {"hemisphere_mean_level_db": level}


def _listeners(scene: Scene, vibration: Vibration) -> dict[str, Any]:
    """Return places and levels of the listeners of a plate with edges.

    Where LAeq is the mean over a comb, the others differ from it as their records do.
    """
    if scene.plate.edges_mm is None:
        return {}
    to_mean_db = _to_mean_db(vibration)
    rows = []
    for place_m, levels in zip(scene.listeners, vibration.listener_levels(), strict=True):
        row = {
            "at_mm": [round(1e3 * x, 6) for x in place_m],
            "laeq_db": _shifted(levels.laeq_db, to_mean_db),
            "level_db": levels.level_db,
        }
        rows.append(row)
    return {"listeners": rows}


def _power(scene: Scene, vibration: Vibration) -> dict[str, Any]:
    """Return the sound power of plate and sphere to one side [dB re 1 pW]."""
    return {
        "plate_power_level_db": _total(vibration.plate_power),
        "ball_power_level_db": _total(vibration.ball_power),
        "plate_power_third_octave_db": by_band(vibration.plate_power),
        "ball_power_third_octave_db": by_band(vibration.ball_power),
        "loss_factor": scene.plate.loss_factor,
    }


def _force(scene: Scene, vibration: Vibration) -> dict[str, Any]:
    """Return fluctuation and extremes of the contact force, and the impacts."""
    motion = vibration.motion
    largest_n = float(motion.force_n.max())
    # A sphere that yields in an impact leaves a dent, and a contact without memory springs back.
    impacts_yield = False
    if motion.impacts and largest_n:
        impacts_yield = bool(maximum_pressure(scene, largest_n) > scene.hardness)
    return {
        "force_rms_n": vibration.rms_ratio * vibration.load,
        "force_rms_ratio": vibration.rms_ratio,
        "force_max_ratio": float(vibration.force_ratio.max()),
        "force_min_ratio": float(vibration.force_ratio.min()),
        "force_third_octave_n": known_bands(vibration.force_bands),
        "largest_force_n": largest_n,
        "impacts_yield": impacts_yield,
        "flight_share": motion.flight_share,
        "impacts": motion.impacts,
    }


def _chain(scene: Scene, vibration: Vibration) -> dict[str, Any]:
    """Return masses, stiffness and resonance of the linear chain."""
    chain = vibration.chain
    edges = of_scene.rectangular_plate(scene)
    numbers = {
        "ball_mass_kg": chain.mass_kg,
        "contact_stiffness_n_m": chain.stiffness_n_m,
        "plate_mobility_s_kg": chain.mobility_s_kg,
    }
    if edges is not None:
        numbers["plate_modes"] = edges.mode_count
    fastest = scene.motion.fastest(scene.duration)
    return numbers | {
        "resonance_hz": chain.resonance_hz,
        "resonance_q": known(chain.quality),
        "resonance_wavelength_m": fastest / chain.resonance_hz,
    }


def _limits_of_plate(scene: Scene, motion: BodyMotion) -> dict[str, Any]:
    """Return coincidence, and how far the thin plate bends; null for a half-space."""
    plate = of_scene.plate(scene)
    critical_hz = bending_limit_hz = share = None
    if plate is not None:
        critical_hz = plate.critical_hz
        bending_limit_hz = of_scene.bending_limit_hz(scene)
        share = max(semi_axes(scene)) / of_scene.thickness_m(scene)
    return {
        "critical_hz": critical_hz,
        "bending_limit_hz": bending_limit_hz,
        "plate_deflection_m": float(np.ptp(motion.plate_m)),
        "contact_radius_over_thickness": share,
    }


def _motion(vibration: Vibration) -> dict[str, Any]:
    """Return time step, errors and course of the motion, and the comb of a repeated lap."""
    motion = vibration.motion
    return {
        "force_outside_share": motion.outside_share,
        "comb_spread_db": vibration.spreads.get("comb"),
        "comb_mean_laeq_db": vibration.mean_laeq,
        "motion_time_step_s": motion.time_step_s,
        "motion_step_error_db": vibration.spreads.get("time_step"),
        "contact_loss_db": vibration.contact_loss_db,
        "baffle_db": vibration.spreads.get("baffle", 0.0),
        "motion_balance_error": motion.energy_error,
        "motion_settled": bool(motion.settled),
        "motion_laps": motion.laps,
        "motion_transient_s": known(motion.transient_s),
    }


def _force_law(run: SolvedRun) -> dict[str, Any]:
    """Return the loads of the force law and its error."""
    vibration = run.vibration
    marches = run.result.load_marches
    if vibration is None or marches is None:
        return {}
    loads = vibration.law.load_n.tolist()
    error = force_law.law_error(run.scene, run.result, loads)
    return {
        "force_law_loads": len(loads),
        "force_law_min_n": loads[0],
        "force_law_max_n": loads[-1],
        "force_law_error_n": None if error is None else error.newtons,
        "force_law_error_db": None if error is None else error.decibels,
        "force_law_top_error": None if error is None else error.top,
        "force_law_fault": marches.fault or None,
    }


def _moving(result: Result, moving: MovingRelease) -> dict[str, Any]:
    """Return the errors of a release under the moving load."""
    defect = np.abs(moving.steps["energy_defect"]).max()
    return {
        "force_law_error_m": moving.law_error,
        "moving_release_balance_error": float(defect / result.series["stored_energy"].max()),
    }


def _solved_stiffness(run: SolvedRun) -> Array | None:
    """Return the contact stiffness [N/m] of a rough contact whose vibration is estimated."""
    if run.scene.dynamics is not None or run.scene.is_smooth:
        return None
    return solved_stiffness(run.scene, run.result)


def _vibration_estimate(
    run: SolvedRun, release: ContactSound, stiffness: Array | None
) -> dict[str, Any]:
    """Return the estimate of the vibration that a scene without dynamics leaves out."""
    scene = run.scene
    result = run.result
    is_looped = release.closed and release.constant_speed
    approach = result.series["approach"] if is_looped else result.whole_series("approach")
    estimate = radiators.vibration_estimate(scene, approach, result.step, release.closed, stiffness)
    return {
        "vibration_estimate_laeq_db": estimate.laeq_db,
        "vibration_estimate_uncertainty_db": estimate.uncertainty_db,
        "vibration_estimate_force_ratio": estimate.force_ratio,
        "vibration_estimate_bodies": radiators.bodies_text(scene),
        "contact_loss_db": estimate.contact_loss_db,
    }


def _to_mean_db(vibration: Vibration) -> float:
    """Return the stated LAeq less that of the record [dB]; 0 unless it is the mean over a comb."""
    stated = vibration.stated_levels.laeq_db
    own = vibration.levels.laeq_db
    if stated is None or own is None:
        return 0.0
    return stated - own


def _shift_to_listener_db(scene: Scene) -> float:
    """Return the level of the release where the vibration is heard over that at distance_m [dB].

    The release spreads over a sphere, so that its intensity falls with the square of the distance.
    The square of the pressure follows the intensity, and under a fixed gain the pressure does.
    """
    ratio = scene.sound.distance_m / scene.vibration_distance_m
    factor = 20.0 if scene.sound.gain_pa_per_w_m2 is None else 40.0
    return factor * math.log10(ratio)


def _shifted(level: float | None, shift_db: float) -> float | None:
    """Return a level [dB] with a shift added; None of silence."""
    return None if level is None else level + shift_db


def _total(power: Array) -> float | None:
    """Return the level of the bands together [dB re 1 pW]; None where all are unknown."""
    finite = power[np.isfinite(power)]
    return level_db(float(finite.sum()), P_REF_W) if len(finite) else None


# ---- provenance


def provenance(scene: Scene, label: str) -> dict[str, Any]:
    """Collect the provenance of the numbers: versions, state of the source, machine, seed, run."""
    packages = (*_PACKAGES, "mosqito") if scene.sound.loudness else _PACKAGES
    facts = program_provenance(label, packages)
    return {**facts, "seed": getattr(scene.surface, "seed", None)}


def program_provenance(label: str, packages: Sequence[str] = _PACKAGES) -> dict[str, Any]:
    """Collect the provenance of the numbers of a run of any scene."""
    return {
        "program": rolling.__version__,
        "sources": program.identity().sources,
        "source": _commit(),
        "python": platform.python_version(),
        "packages": {name: _version(name) for name in packages},
        "machine": f"{platform.system()} {platform.machine()}, {cost.cores()} processors",
        "label": label,
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
    }


_version = cache(metadata.version)


@cache
def _commit() -> str | None:
    """Return the commit of the checkout with the mark of changes; None outside a checkout."""
    root = Path(rolling.__file__).parents[1]
    git = ["git", "--git-dir", str(root / ".git"), "--work-tree", str(root)]
    command = [*git, "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip() or None
