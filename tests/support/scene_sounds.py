"""Sounds of scenes without a march: of a release that is given, and of a force law."""

from __future__ import annotations

from acoustics.arrays import Array
from rolling.dynamics.force_law import ForceLaw
from rolling.in_si.physics_of_scene import bodies_of, listener_of
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import ContactSound, contact_sound
from rolling.sound.vibration_sound import Vibration, vibrate


def sound_of_release(
    scene: Scene,
    energy: Array,
    step: float,
    closed: bool,
    lap_steps: int | None = None,
    has_seam: bool = False,
) -> ContactSound:
    """Return the sound of a scene that releases energies [J] in steps of a length [m]."""
    return contact_sound(
        energy,
        step=step,
        motion=scene.motion,
        listener=listener_of(scene),
        tolerance=scene.tolerance,
        closed=closed,
        lap_steps=lap_steps,
        has_seam=has_seam,
    )


def vibration_over(scene: Scene, law: ForceLaw, highest: float) -> Vibration:
    """Return the vibration of a scene over whole laps of a force law."""
    return vibrate(
        bodies_of(scene),
        listener_of(scene),
        scene.travel,
        law,
        highest=highest,
        whole_laps=True,
    )
