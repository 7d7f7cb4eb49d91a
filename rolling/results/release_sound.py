"""Sound of the release of a run, and its level where the vibration is heard."""

from __future__ import annotations

import math

from rolling.in_si.physics_of_scene import listener_of
from rolling.in_si.scene_surface import scene_surface
from rolling.marches.result import Result, released_energy
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound, contact_sound


def sound_of_release(scene: Scene, result: Result) -> ContactSound:
    """Return the sound of what a ball releases along its track, at the distance of the listener."""
    energy, is_closed = released_energy(scene, result)
    return contact_sound(
        energy,
        step=result.step,
        motion=scene.motion,
        listener=listener_of(scene),
        tolerance=scene.tolerance,
        closed=is_closed,
        lap_steps=result.solved_steps,
        has_seam=scene_surface(scene).has_seam,
    )


def shift_to_listener_db(scene: Scene) -> float:
    """Return the level of the release where the vibration is heard over that at distance_m [dB].

    The release spreads over a sphere, so that its intensity falls with the square of the distance.
    The square of the pressure follows the intensity, and under a fixed gain the pressure does.
    """
    ratio = scene.sound.distance_m / scene.vibration_distance_m
    factor = 20.0 if scene.sound.gain_pa_per_w_m2 is None else 40.0
    return factor * math.log10(ratio)
