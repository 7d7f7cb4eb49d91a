"""Rolling contact of a scene for the march: surface, bodies and numerics as plain numbers."""

from dataclasses import replace

from acoustics.arrays import Array
from rolling.contact.state import RollingContact, kept
from rolling.scene import grid_error
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.surface import refined
from rolling.surface.scene_surface import has_detail, heights


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


def auto_subcells(contact: RollingContact) -> int:
    """Choose the sub-cells along the side of a cell for a contact, as `numerics.subcells: auto`."""
    if not contact.has_blended_edges:
        return 1
    z = contact.heights
    slope = refined.rms_slope(kept(z, "step", lambda: refined.median_step(z)), contact.spacing)
    return grid_error.auto_subcells(slope, contact.contact_modulus, contact.hardness)


def on_subcells(
    contact: RollingContact, subcells: int, smooth: bool | None = None
) -> RollingContact:
    """Split the cells of a contact into sub-cells, r along the side of a cell.

    If `smooth`, the surface continues between its nodes. Default: its spectrum decides.
    """
    if subcells == 1 and not contact.has_blended_edges:
        return contact
    z = contact.heights
    is_smooth = smooth
    if is_smooth is None:
        is_smooth = bool(kept(z, "smooth", lambda: refined.dies_out(z)))
    key = (subcells, is_smooth)
    return replace(
        contact,
        heights=kept(z, key, lambda: refined.subcell_heights(z, subcells, is_smooth)),
        spacing=contact.spacing / subcells,
        subcells=subcells,
        slopes=is_smooth,
    )
