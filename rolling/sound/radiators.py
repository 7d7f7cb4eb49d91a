"""Bodies that a vibration makes heard, their sound power, and their linear gain."""

from __future__ import annotations

import math

import numpy as np

from acoustics import spectrum, wav
from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ, EDGES_HZ, third_octave_mean_square
from acoustics.radiation import Ball, HalfSpaceBody, ThinPlate, axis_transfer
from acoustics.sound_power import band_power
from rolling.dynamics import of_scene
from rolling.dynamics.bodies import Chain
from rolling.scene.scene import Scene
from rolling.sound import edged_sound
from rolling.sound.error_estimate import Gain


def sources(scene: Scene) -> list[ThinPlate | HalfSpaceBody | Ball]:
    """Return the bodies that are heard."""
    return [ground(scene), *([of_scene.ball(scene)] if scene.sound.ball else [])]


def powers(scene: Scene, force: Array, highest: float) -> tuple[Array, Array]:
    """Return the sound power [W] of plate and sphere in third octaves."""
    body, rate = ground(scene), wav.SAMPLE_RATE_HZ
    of_ball = band_power(force, rate, of_scene.ball(scene))
    plate = np.full(len(of_ball), np.nan)
    if (rectangle := of_scene.rectangular_plate(scene)) is not None:
        frequency, square = spectrum.line_spectrum(force, rate)
        audible = (frequency >= AUDIBLE_HZ[0]) & (frequency < AUDIBLE_HZ[1])
        frequency, square = frequency[audible], square[audible]
        power = edged_sound.power_per_force(scene, rectangle, frequency)
        plate = third_octave_mean_square(frequency, square * power)
    elif isinstance(body, ThinPlate):
        plate = band_power(force, rate, body)
        if not body.loss_factor:  # it decides the power above coincidence
            plate[EDGES_HZ[1:] > body.critical_hz] = np.nan
    known = known_bands(highest)
    return np.where(known, plate, np.nan), np.where(known, of_ball, np.nan)


def ground(scene: Scene) -> ThinPlate | HalfSpaceBody:
    """Return the plate that bends, or the half-space where the scene gives no thickness."""
    plate, bending = scene.plate, of_scene.plate(scene)
    if bending is not None:
        return bending
    assert plate.density_kg_m3 is not None  # dynamics needs it
    # An incompressible half-space would carry compression at once, and radiate nothing.
    nu = min(plate.poissons_ratio, 0.499)
    stiffness = plate.youngs_modulus_gpa * 1e9 * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    return HalfSpaceBody(plate.density_kg_m3, math.sqrt(stiffness / plate.density_kg_m3))


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
            square = edged_sound.square_transfer(scene, plate, frequency)
            return square * np.square(np.abs(force))
        transfer = sum(axis_transfer(frequency, body, scene.sound.distance_m) for body in bodies)
        return np.square(np.abs(transfer * force))

    return gain
