"""Bodies that a vibration makes heard: sound power, and levels by a linear chain.

Sphere, contact and plate are a chain of linear bodies that the approach under the constant load
moves. It gives the comb of a looped record, in which a sharp resonance falls on a line or between
two, and the level of the vibration that a run without dynamics leaves out. Its scene need not
describe the bodies: a steel sphere on a steel plate of 10 mm replaces missing ones.
"""

import math
from typing import Any

import numpy as np

from acoustics import level, wav
from acoustics.arrays import Array
from acoustics.bands import EDGES_HZ, third_octave_mean_square
from acoustics.numbers import rounded
from acoustics.radiation import Body, ThinPlate, axis_transfer
from acoustics.sound_power import band_power
from acoustics.spectrum import audible_lines
from acoustics.weighting import a_weighting_db
from rolling.dynamics import of_scene
from rolling.dynamics.bodies import Chain
from rolling.dynamics.comb import Comb, speeds_of_comb, spread_db
from rolling.dynamics.force_law import ForceLaw
from rolling.scene.library import NONE
from rolling.scene.quantities import STEEL_DENSITY, STEEL_GPA, STEEL_POISSON
from rolling.scene.scene import Scene
from rolling.sound import edged_sound
from rolling.sound.contact_sound import faded, oversampling
from rolling.sound.error_estimate import Gain


def sources(scene: Scene) -> list[Body]:
    """Return the bodies that are heard."""
    return [of_scene.ground(scene), *([of_scene.ball(scene)] if scene.sound.ball else [])]


def powers(scene: Scene, force: Array, highest: float) -> tuple[Array, Array]:
    """Return the sound power [W] of plate and sphere in third octaves."""
    body, rate = of_scene.ground(scene), wav.SAMPLE_RATE_HZ
    of_ball = band_power(force, rate, of_scene.ball(scene))
    plate = np.full(len(of_ball), np.nan)
    if (rectangle := of_scene.rectangular_plate(scene)) is not None:
        frequency, square = audible_lines(force, rate)
        power = edged_sound.power_per_force(scene, rectangle, frequency)
        plate = third_octave_mean_square(frequency, square * power)
    elif isinstance(body, ThinPlate):
        plate = band_power(force, rate, body)
        if not body.loss_factor:  # it decides the power above coincidence
            plate[EDGES_HZ[1:] > body.critical_hz] = np.nan
    known = known_bands(highest)
    return np.where(known, plate, np.nan), np.where(known, of_ball, np.nan)


def known_bands(highest: float) -> Array:
    """Return which bands lie below a highest frequency [Hz], a (31,) array of bool."""
    return np.asarray(EDGES_HZ[1:] <= min(highest, wav.SAMPLE_RATE_HZ / 2))


def roughness_gain(scene: Scene, chain: Chain | None = None) -> Gain:
    """Return the power gain [Pa2/m2] from an approach under the constant load to the pressure.

    Sphere, contact and plate are a linear chain with the stiffness of a smooth contact. It serves
    for ratios of powers, in which an error of the stiffness cancels.
    """
    chain, plate = chain or of_scene.smooth_chain(scene), of_scene.rectangular_plate(scene)
    bodies = sources(scene)

    def gain(frequency: Array) -> Array:
        force = chain.force(frequency, np.ones(len(frequency)))
        if plate is not None:
            return edged_sound.square_transfer(scene, plate, frequency) * np.square(np.abs(force))
        transfer = sum(axis_transfer(frequency, body, scene.sound.distance_m) for body in bodies)
        return np.square(np.abs(transfer * force))

    return gain


def comb(scene: Scene, law: ForceLaw, chain: Chain) -> Comb | None:
    """Return the levels over other speeds; None where a resonance holds several lines."""
    if law.period_m is None:
        return None
    approach = law.approach(law.position_m, scene.load)
    lines: Array = 2 * np.square(np.abs(np.fft.rfft(approach)[1:] / len(approach)))
    gain = roughness_gain(scene, chain)

    def weighted(frequency: Array) -> Array:
        """Return the A-weighted gain of lines."""
        return np.asarray(10 ** (a_weighting_db(frequency) / 10) * gain(frequency))

    speeds = speeds_of_comb(
        chain=chain,
        lines=lines,
        line_hz=scene.motion.fastest(scene.duration) / law.period_m,
        loss_factor=scene.plate.loss_factor or 0.0,
        gain=weighted,
    )
    if speeds is None:
        return None
    bands = np.array(
        [third_octave_mean_square(at.frequency_hz, lines[at.audible] * at.gain) for at in speeds]
    )
    sums = bands.sum(axis=1)
    if not sums.min() > 0:  # no line is heard
        return None
    return Comb(
        spread_db=spread_db(sums),
        mean_laeq_db=level.level_db(float(sums.mean())),
        band_spread_db=np.array([spread_db(band) for band in bands.T]),
    )


THICKNESS_MM = 10.0
STEEL = {"plate.youngs_modulus_gpa": STEEL_GPA, "plate.poissons_ratio": STEEL_POISSON}
# Limits of another plate may be too high for steel, and the solved contact has them already.
ELASTIC = {"plate.density_kg_m3": STEEL_DENSITY, "plate.hardness_gpa": NONE}
UNLIMITED = dict.fromkeys(("plate.yield_strength_gpa", "plate.plasticity", "rolling.passes"))
_POINTS = 8  # of the gain within the interval of a line, over which a resonance is averaged


def with_bodies(scene: Scene) -> Scene:
    """Return a scene that describes sphere and plate; one without a density is of steel."""
    plate = scene.plate
    bodies: dict[str, Any] = {"dynamics": {}, "sound.source": "release"}
    if plate.density_kg_m3 is None:
        bodies |= STEEL | ELASTIC | UNLIMITED
    bodies["plate.thickness_mm"] = plate.thickness_mm or THICKNESS_MM
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


def vibration_estimate(
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
    frequency, mean_square = audible_lines(signal - signal.mean(), len(signal) / duration)
    if not len(frequency):
        return None, 0.0
    bodies = with_bodies(scene)
    chain = of_scene.chain(bodies, of_scene.smooth_stiffness(scene))
    offsets = ((np.arange(_POINTS) + 0.5) / _POINTS - 0.5) / duration
    points = np.maximum(frequency[:, None] + offsets, 1.0).ravel()
    weighted = roughness_gain(bodies, chain)(points) * 10 ** (a_weighting_db(points) / 10)
    forces = np.square(np.abs(chain.force(points, np.ones(len(points)))))
    gains = (gain.reshape(-1, _POINTS).mean(axis=1) for gain in (weighted, forces))
    square, force_square = (float(mean_square @ gain) for gain in gains)
    return level.level_db(square), math.sqrt(force_square) / scene.load
