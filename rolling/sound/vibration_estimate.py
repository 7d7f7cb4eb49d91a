"""Level of the vibration that a run without dynamics leaves out, estimated by a linear chain.

The approach under the constant load moves sphere, contact and plate, which a scene without dynamics
need not describe: a steel sphere on a steel plate of 10 mm replaces the missing bodies.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from acoustics import level
from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ
from acoustics.numbers import rounded
from acoustics.spectrum import line_spectrum
from acoustics.weighting import a_weighting_db
from rolling.dynamics import of_scene
from rolling.scene.quantities import STEEL_DENSITY
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import faded, oversampling
from rolling.sound.radiators import roughness_gain

THICKNESS_MM = 10.0
STEEL = {"plate.youngs_modulus_gpa": 210.0, "plate.poissons_ratio": 0.3}
_POINTS = 8  # of the gain within the interval of a line, over which a resonance is averaged


def with_bodies(scene: Scene) -> Scene:
    """Return a scene that describes sphere and plate, with steel where a scene says nothing."""
    plate = scene.plate
    bodies: dict[str, Any] = {"dynamics": {}, "sound.source": "release"}
    if plate.density_kg_m3 is None:
        bodies |= STEEL | {"plate.density_kg_m3": STEEL_DENSITY}
    if plate.thickness_mm is None:
        bodies["plate.thickness_mm"] = THICKNESS_MM
    if scene.sphere.density_kg_m3 is None:
        bodies["sphere.density_kg_m3"] = STEEL_DENSITY
    return scene.with_(bodies)


def bodies_text(scene: Scene) -> str:
    """Write the bodies of an estimate: a ball of steel on a 10 mm plate of steel."""
    ball, plate = (
        "steel" if density is None else f"{rounded(density, 4)} kg/m³"
        for density in (scene.sphere.density_kg_m3, scene.plate.density_kg_m3)
    )
    thickness = scene.plate.thickness_mm or THICKNESS_MM
    return f"a ball of {ball} on a {rounded(thickness, 4)} mm plate of {plate}"


def estimate(
    scene: Scene, approach: Array, step: float, closed: bool
) -> tuple[float | None, float]:
    """Estimate LAeq [dB] of the vibration, and the rms of its contact force over the load.

    The approach [m] under the constant load stands at the ends of steps [m], of whole laps if
    `closed`. LAeq is None where it does not fluctuate within hearing.
    """
    motion, steps = scene.motion, len(approach) - 1
    duration = motion.duration(steps * step)
    if scene.is_smooth or steps < 4:
        return None, 0.0
    signal, constant = approach[:-1], motion.is_constant(duration)
    if not constant:
        count = steps * oversampling(motion, duration, step)
        places = np.asarray(motion.distance(np.arange(count) * duration / count)) / step
        signal = np.interp(places, np.arange(steps + 1), approach)
    if not (closed and constant):
        signal = faded(signal, duration)
    rate = len(signal) / duration
    frequency, mean_square = line_spectrum(signal - signal.mean(), rate)
    heard = (frequency >= AUDIBLE_HZ[0]) & (frequency < AUDIBLE_HZ[1])
    if not heard.any():
        return None, 0.0
    stiffness = 2 * scene.contact_modulus * of_scene.hertz_radius(scene)
    bodies = with_bodies(scene)
    chain = of_scene.chain(bodies, stiffness)
    offsets = ((np.arange(_POINTS) + 0.5) / _POINTS - 0.5) / duration
    points = np.maximum(frequency[heard][:, None] + offsets, 1.0).ravel()
    weighted = roughness_gain(bodies, chain)(points) * 10 ** (a_weighting_db(points) / 10)
    forces = np.square(np.abs(chain.force(points, np.ones(len(points)))))
    square, force_square = (
        float(mean_square[heard] @ gain.reshape(-1, _POINTS).mean(axis=1))
        for gain in (weighted, forces)
    )
    return level.level_db(square), math.sqrt(force_square) / scene.load
