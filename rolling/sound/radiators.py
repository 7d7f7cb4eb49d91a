"""Sphere and plate of a scene as bodies that radiate."""

from __future__ import annotations

import math

from acoustics.radiation import Ball, HalfSpaceBody, ThinPlate
from rolling.dynamics import of_scene
from rolling.scene.scene import Scene


def ground(scene: Scene) -> ThinPlate | HalfSpaceBody:
    """Return the plate that bends, or the half-space where the scene gives no thickness."""
    plate, bending = scene.plate, of_scene.plate(scene)
    if bending is not None:
        return ThinPlate(
            bending.mass_per_area_kg_m2, bending.bending_stiffness_n_m, plate.loss_factor or 0.0
        )
    assert plate.density_kg_m3 is not None  # dynamics needs it
    # An incompressible half-space would carry compression at once, and radiate nothing.
    nu = min(plate.poissons_ratio, 0.499)
    stiffness = plate.youngs_modulus_gpa * 1e9 * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    return HalfSpaceBody(plate.density_kg_m3, math.sqrt(stiffness / plate.density_kg_m3))


def ball(scene: Scene) -> Ball:
    """Return the sphere."""
    assert scene.sphere.density_kg_m3 is not None  # dynamics needs it
    return Ball(scene.radius, scene.sphere.density_kg_m3)
