"""Vibration of a run: the motion over its force law, its sound, and its numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from acoustics.bands import BAND_NAMES
from acoustics.level import level_db
from rolling.contact import closed_forms
from rolling.dynamics import of_scene
from rolling.scene.scene import Scene
from rolling.simulation import force_law
from rolling.simulation.result import Result
from rolling.sound.contact_sound import ContactSound
from rolling.sound.vibration_sound import P_REF_W, Vibration, vibrate


def vibration_of(scene: Scene, result: Result, release: ContactSound) -> Vibration | None:
    """Return the vibration of a run; None without dynamics, or while its marches are missing.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    result : Result. The result of the run.
    release : ContactSound. The sound of its release.

    Raises
    ------
    ContactError : the marches make no force law.
    """
    if scene.dynamics is None or not result.complete or force_law.is_missing(scene, result):
        return None
    whole_laps = scene.track.closed and result.steps % result.solved_steps == 0
    laps = result.steps / result.solved_steps
    loads = force_law.loads_of(scene, result, of_scene.extremes).marched
    law = force_law.force_law(scene, result, loads)
    return vibrate(scene, law, release.highest, whole_laps and release.constant_speed, laps)


def numbers(
    scene: Scene, result: Result, release: ContactSound, vibrating: Vibration | None
) -> dict[str, Any]:
    """Return the numbers of the vibration for summary.json; none where there is none."""
    if vibrating is None:
        return {}
    return {
        "source": scene.sound.source,
        **_levels(scene, release, vibrating),
        **_force(vibrating),
        **_law(scene, result, vibrating.law.load_n.tolist()),
        **_bodies(scene, vibrating),
        **_motion(vibrating),
    }


def _levels(scene: Scene, release: ContactSound, vibrating: Vibration) -> dict[str, Any]:
    """Return the levels of both sources, their difference, and the sound power."""
    difference = None
    if release.levels.laeq_db is not None and vibrating.levels.laeq_db is not None:
        difference = release.levels.laeq_db - vibrating.levels.laeq_db
    # The level of a release follows 10 lg q, unless the scene has a gain.
    free = difference is not None and scene.sound.gain_pa_per_w_m2 is None
    return {
        "vibration_laeq_db": vibrating.levels.laeq_db,
        "vibration_level_db": vibrating.levels.level_db,
        "release_laeq_db": release.levels.laeq_db,
        "release_level_db": release.levels.level_db,
        "release_over_vibration_db": difference,
        "equivalent_q": scene.sound.q * 10 ** (-difference / 10)
        if free and difference is not None
        else None,
        "vibration_third_octave_db": vibrating.levels.third_octave_db,
        "release_third_octave_db": release.levels.third_octave_db,
        "plate_power_level_db": _total(vibrating.plate_power),
        "ball_power_level_db": _total(vibrating.ball_power),
        "plate_power_third_octave_db": vibrating.power_levels(),
        "ball_power_third_octave_db": vibrating.ball_power_levels(),
        "loss_factor": scene.plate.loss_factor,
    }


def _total(power: Any) -> float | None:
    """Return the level of the bands together [dB re 1 pW]; None where a band is unknown."""
    known = power[np.isfinite(power)]
    return level_db(float(known.sum()), P_REF_W) if len(known) else None


def _force(vibrating: Vibration) -> dict[str, Any]:
    """Return the contact force over the load, and its share in flight."""
    motion, ratio = vibrating.motion, vibrating.force_ratio
    bands = zip(BAND_NAMES, vibrating.force_bands.tolist(), strict=True)
    return {
        "force_rms_n": vibrating.rms_ratio * vibrating.load,
        "force_rms_ratio": vibrating.rms_ratio,
        "force_max_ratio": float(ratio.max()),
        "force_min_ratio": float(ratio.min()),
        "force_third_octave_n": {name: _known(rms) for name, rms in bands},
        "flight_share": motion.flight_share,
        "impacts": motion.impacts,
    }


def _law(scene: Scene, result: Result, loads: list[float]) -> dict[str, Any]:
    """Return the loads of the force law, its error, and the time of its marches."""
    marches = result.load_marches
    assert marches is not None
    error = force_law.law_error(scene, result, loads)
    return {
        "force_law_loads": len(loads),
        "force_law_min_n": loads[0],
        "force_law_max_n": loads[-1],
        "force_law_error_n": error and error.newtons,
        "force_law_error_db": error and error.decibels,
        "force_law_seconds": marches.seconds,
        "force_law_fault": marches.fault or None,
    }


def _bodies(scene: Scene, vibrating: Vibration) -> dict[str, Any]:
    """Return resonance and damping, and the numbers that say whether the model holds."""
    chain, motion = vibrating.chain, vibrating.motion
    plate = of_scene.plate(scene)
    radius = closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus)
    fastest = scene.motion.fastest(scene.duration)
    return {
        "ball_mass_kg": chain.mass_kg,
        "contact_stiffness_n_m": chain.stiffness_n_m,
        "plate_mobility_s_kg": chain.mobility_s_kg,
        "resonance_hz": chain.resonance_hz,
        "resonance_q": _known(chain.quality),
        "resonance_wavelength_m": fastest / chain.resonance_hz,
        "critical_hz": plate and plate.critical_hz,
        "bending_limit_hz": plate and of_scene.bending_limit_hz(plate),
        "plate_deflection_m": float(np.ptp(motion.plate_m)),
        "contact_radius_over_thickness": plate and float(radius / plate.thickness_m),
    }


def _motion(vibrating: Vibration) -> dict[str, Any]:
    """Return the accuracy of the time steps and the end of the run-in."""
    motion = vibrating.motion
    return {
        "force_outside_share": motion.outside_share,
        "motion_time_step_s": motion.time_step_s,
        "motion_balance_error": motion.energy_error,
        "motion_settled": bool(motion.settled),
        "motion_laps": motion.laps,
        "motion_transient_s": _known(motion.transient_s),
    }


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None
