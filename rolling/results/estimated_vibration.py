"""Vibration that a linear chain estimates for a scene without dynamics, from its marches."""

from __future__ import annotations

import numpy as np

from acoustics.arrays import Array
from rolling.in_si.assumed_bodies import with_bodies
from rolling.in_si.physics_of_scene import bodies_of, listener_of, smooth_contact_of
from rolling.marches.result import Result
from rolling.marches.stiffness import solved_stiffness
from rolling.scene.scene import Scene
from rolling.sound import radiators
from rolling.sound.contact_sound import ContactSound
from rolling.sound.linear_sound import LinearVibration
from rolling.sound.radiators import VibrationEstimate


def contact_stiffness(scene: Scene, result: Result) -> Array:
    """Return the contact stiffness [N/m] along the track; that of a smooth contact is one value."""
    if scene.is_smooth:
        return np.array([smooth_contact_of(scene).stiffness_n_m])
    return solved_stiffness(scene, result)


def approach_of(result: Result, release: ContactSound) -> Array:
    """Return the approach [m] of a lap that repeats, or of the whole record of a release."""
    is_looped = release.closed and release.constant_speed
    return result.series["approach"] if is_looped else result.whole_series("approach")


def linear_vibration(
    scene: Scene, approach: Array, step: float, closed: bool, stiffness: Array
) -> LinearVibration:
    """Return the linear chain of a scene, whose bodies are assumed where it has none.

    The approach [m] is that of `VibrationEstimate`, and the stiffness [N/m] that along the track.
    """
    described = with_bodies(scene)
    return LinearVibration(
        bodies=bodies_of(described),
        listener=listener_of(described),
        stiffness_n_m=float(1 / np.mean(1 / stiffness)),
        motion=scene.motion,
        approach=approach,
        step=step,
        closed=closed,
    )


def vibration_estimate(vibration: LinearVibration, stiffness: Array) -> VibrationEstimate:
    """Return the level that a linear chain gives, with a stiffness [N/m] that changes."""
    return radiators.vibration_estimate(
        vibration.bodies,
        vibration.listener,
        vibration.motion,
        approach=vibration.approach,
        step=vibration.step,
        closed=vibration.closed,
        stiffness_n_m=stiffness,
    )
