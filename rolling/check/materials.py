"""Materials by name: values of the scene's own, and limits of the model that a material breaks."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rolling.check.finding import Finding, si
from rolling.scene import named
from rolling.scene.scene import Scene


def findings(scene: Scene) -> Iterator[Finding]:
    """State the materials of plate and sphere; warn where the model does not hold for them."""
    for body in ("plate", "sphere"):
        section = getattr(scene, body)
        entry = named.entries("materials").get(section.material or "")
        if entry is None:
            continue
        own = named.own_values(body, section.model_dump())
        but = ", ".join(f"{key} {value}" for key, value in own.items())
        value = section.material + (f" with its own {but}" if own else "")
        warning = None
        if reason := entry.get("sound_only"):
            warning = (
                f"{section.material} is for its sound only, not for levels, because {reason}; the"
                " contact is computed as of an isotropic elastic half-space that yields"
            )
        yield Finding(f"{body}_material", f"material of the {body}", value, warning)
    yield from _soft_sphere(scene)


def _soft_sphere(scene: Scene) -> Iterator[Finding]:
    """Warn of a sphere whose material yields at a lower pressure than the plate."""
    hardness = scene.sphere.material and named.hardness_gpa(scene.sphere.material)
    if not hardness or 1e9 * hardness >= scene.hardness:
        return
    plate = "is purely elastic"
    if math.isfinite(scene.hardness):
        plate = f"bears up to {si(scene.hardness, 'Pa')}"
    warning = (
        f"the sphere would yield first, at {si(1e9 * hardness, 'Pa')}, and the program does not let"
        f" it: the plate {plate}; give the plate a hardness of the sphere, or a harder sphere"
    )
    yield Finding("sphere_yields", "hardness of the sphere", si(1e9 * hardness, "Pa"), warning)
