"""Radiation of sphere and plate of a scene, per newton of fluctuating contact force."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rolling._typing import Array
from rolling.dynamics import of_scene
from rolling.scene.scene import Scene

RHO, C = 1.204, 343.2


def axis_transfer(scene: Scene, frequency_hz: Array) -> NDArray[np.complex128]:
    """Return the pressure on the axis over the force [Pa/N], on the side of the sphere."""
    iw = 2j * np.pi * frequency_hz
    r = scene.sound.distance_m
    bending = of_scene.plate(scene)
    density = scene.plate.density_kg_m3
    if bending is not None:
        plate = np.full(len(iw), -RHO / (2 * np.pi * r * bending.mass_per_area_kg_m2), complex)
    else:
        e, nu = scene.plate.youngs_modulus_gpa * 1e9, scene.plate.poissons_ratio
        c_l = np.sqrt(e * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) / density)
        plate = -RHO / (2 * np.pi * r * density * c_l) * iw
    if not scene.sound.ball:
        return plate
    ball = 3 * RHO / (8 * np.pi * scene.sphere.density_kg_m3 * C * r) * iw
    ka = 2 * np.pi * frequency_hz / C * scene.radius
    return plate + ball * 2 / np.sqrt(4 + ka**4)


def power_per_force(scene: Scene, frequency_hz: Array) -> tuple[Array, Array]:
    """Return sound power of plate and sphere over the mean square of the force [W/N2]."""
    bending = of_scene.plate(scene)
    if bending is None:
        plate = np.full(len(frequency_hz), np.nan)
    else:
        plate = np.where(
            frequency_hz < bending.critical_hz,
            RHO / (2 * np.pi * C * bending.mass_per_area_kg_m2**2),
            np.nan,
        )
    a = scene.radius
    ka = 2 * np.pi * frequency_hz / C * a
    w = np.maximum(2 * np.pi * frequency_hz, 1e-9)
    ball = 4 * np.pi * a**2 / 3 * RHO * C * (1 / (w * scene.mass)) ** 2 * ka**4 / (4 + ka**4)
    return plate, ball
