"""Bodies of a scene that does not describe them: a steel ball on a steel plate of 10 mm."""

from typing import Any

from acoustics.numbers import rounded
from rolling.scene.library import NONE
from rolling.scene.scene import Scene
from rolling.scene.values_in_si import STEEL_DENSITY, STEEL_GPA, STEEL_POISSON

THICKNESS_MM = 10.0
STEEL = {"plate.youngs_modulus_gpa": STEEL_GPA, "plate.poissons_ratio": STEEL_POISSON}
# Limits of another plate may be too high for steel, and the solved contact has them already.
ELASTIC = {"plate.density_kg_m3": STEEL_DENSITY, "plate.hardness_gpa": NONE}
UNLIMITED: dict[str, None] = {
    "plate.yield_strength_gpa": None,
    "plate.plasticity": None,
    "rolling.passes": None,
}


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
    ball = _material_text(scene.sphere.material, scene.sphere.density_kg_m3)
    plate = _material_text(scene.plate.material, scene.plate.density_kg_m3)
    thickness = scene.plate.thickness_mm or THICKNESS_MM
    return f"a ball of {ball} on a {rounded(thickness, 4)} mm plate of {plate}"


def _material_text(material: str | None, density: float | None) -> str:
    """Write the material of a body, its density [kg/m3], or the steel in place of both."""
    if material is not None:
        return material
    if density is None:
        return "steel"
    return f"{rounded(density, 4)} kg/m³"
