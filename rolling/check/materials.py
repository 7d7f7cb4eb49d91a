"""Materials by name: values of the scene's own, and limits of the model that a material breaks."""

from __future__ import annotations

from collections.abc import Iterator

from rolling.check.finding import Finding, judged, si
from rolling.scene import library
from rolling.scene.scene import Scene


def findings(scene: Scene) -> Iterator[Finding]:
    """State the materials of plate and sphere; warn where the model does not hold for them."""
    for body in ("plate", "sphere"):
        section = getattr(scene, body)
        if (name := section.material) is not None:
            value, reason = name, library.data("materials")["materials"][name].get("sound_only")
            for key, usual in library.named_values(body, name).items():
                if (own := getattr(section, key)) not in (None, usual):
                    value += f", own {key} {own}"
            yield judged(f"{body}_material", value, bool(reason), material=name, reason=reason)
    material = scene.sphere.material
    hardness = material and library.named_values("plate", material)["hardness_gpa"]
    if isinstance(hardness, float) and 1e9 * hardness < scene.hardness:
        yield judged("sphere_yields", si(1e9 * hardness, "Pa"), True, pressure=1e9 * hardness)
