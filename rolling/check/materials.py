"""Materials by name: values of the scene's own, and limits of the model that a material breaks."""

from __future__ import annotations

from collections.abc import Iterator

from rolling.check.finding import Finding, si
from rolling.scene import named
from rolling.scene.scene import Scene


def findings(scene: Scene) -> Iterator[Finding]:
    """State the materials of plate and sphere; warn where the model does not hold for them."""
    for body in ("plate", "sphere"):
        section = getattr(scene, body)
        if section.material is None:
            continue
        value, warning = section.material, None
        for key, usual in named.named_values(body, value).items():
            if (own := getattr(section, key)) not in (None, usual):
                value += f", own {key} {own}"
        if reason := named.data("materials")["materials"][section.material].get("sound_only"):
            warning = (
                f"{section.material} is for its sound only, not for levels, because {reason}; the"
                " contact is computed as of an isotropic elastic half-space that yields"
            )
        yield Finding(f"{body}_material", f"material of the {body}", value, warning)
    yield from _soft_sphere(scene)


def _soft_sphere(scene: Scene) -> Iterator[Finding]:
    """Warn of a sphere whose material yields at a lower pressure than the plate."""
    material = scene.sphere.material
    hardness = material and named.named_values("plate", material)["hardness_gpa"]
    if isinstance(hardness, float) and 1e9 * hardness < scene.hardness:
        pressure = si(1e9 * hardness, "Pa")
        warning = (
            f"the sphere would yield first, at {pressure}, and the program does not let it, because"
            " the plate bears more: lower plate.hardness_gpa, or take a harder sphere"
        )
        yield Finding("sphere_yields", "hardness of the sphere", pressure, warning)
