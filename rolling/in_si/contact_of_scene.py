"""Rolling contact of a scene for the march: surface, bodies and numerics as plain numbers."""

from acoustics.arrays import Array
from rolling.contact.state import RollingContact
from rolling.in_si.scene_surface import has_detail, heights
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.surface.subcell_contact import auto_subcells, on_subcells


def rolling_contact(scene: Scene, over: Array | None = None) -> RollingContact:
    """Make the rolling contact of a scene over its own or other heights [m].

    Raise SceneError for heights that cannot be metres.
    """
    z = heights(scene) if over is None else over
    try:
        contact = _on_nodes(scene, z)
    except ValueError as error:
        raise SceneError([f"surface: {error}"]) from error
    chosen = scene.numerics.subcells
    subcells = auto_subcells(contact) if chosen == "auto" else chosen
    return on_subcells(contact, subcells, continues(scene))


def _on_nodes(scene: Scene, z: Array) -> RollingContact:
    """Return the rolling contact of a scene over heights [m], without sub-cells."""
    return RollingContact(
        heights=z,
        spacing=scene.spacing,
        radius=scene.radius,
        radius_across=scene.radius_across,
        contact_modulus=scene.contact_modulus,
        hardness=scene.hardness,
        load=scene.load,
        step=scene.step,
        start=scene.start,
        tolerance=scene.tolerance,
        single=scene.numerics.precision == "single",
        blended=scene.numerics.edges == "blended",
    )


def continues(scene: Scene) -> bool | None:
    """Return whether the laws of a surface end before its grid does; None without a law.

    The spectrum of a surface of a few correlation lengths has a tail, from the edge of its period
    alone, that is no detail between nodes. Single faults follow no law.
    """
    if scene.faults or not scene.laws:
        return None
    return not has_detail(scene)
