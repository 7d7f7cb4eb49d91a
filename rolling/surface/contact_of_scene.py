"""Rolling contact of a scene for the march: surface, bodies and numerics as plain numbers."""

from __future__ import annotations

from rolling._typing import Array
from rolling.contact.state import RollingContact
from rolling.scene.scene import Scene
from rolling.surface.scene_surface import heights


def rolling_contact(scene: Scene, over: Array | None = None) -> RollingContact:
    """Make the rolling contact of a scene over its own or other heights [m].

    Raises
    ------
    SceneError
        The surface cannot be made or read.
    """
    return RollingContact(
        heights=heights(scene) if over is None else over,
        spacing=scene.spacing,
        radius=scene.radius,
        contact_modulus=scene.contact_modulus,
        hardness=scene.hardness,
        load=scene.load,
        step=scene.step,
        start=scene.start,
        tolerance=scene.numerics.tolerance,
        single=scene.numerics.precision == "single",
        blended=scene.numerics.edges == "blended",
    )
