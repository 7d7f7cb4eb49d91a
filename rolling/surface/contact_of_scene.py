"""The rolling contact of a scene for the march: surface, bodies and numerics as plain numbers."""

from __future__ import annotations

import math
from dataclasses import replace

from rolling._typing import Array
from rolling.contact.state import RollingContact
from rolling.scene.scene import Scene
from rolling.surface.refinement import dies_out, subcell_heights
from rolling.surface.scene_surface import heights

# of `subcells: auto` where a plate yields
YIELDING_SUBCELLS = 2

# heights of the last surface, their sub-cells along the side of a cell, whether they run on between
# the nodes, and the heights of the sub-cells
_kept: list[tuple[Array, int, bool, Array]] = []


def subcells_of(scene: Scene) -> int:
    """Return the number of sub-cells along the side of a cell.

    `auto` takes sub-cells where edges are blended and the plate yields. The sharp edge of an elastic
    contact, where the pressure falls to zero, gains nothing that their time would be worth.
    """
    if scene.numerics.subcells != "auto":
        return scene.numerics.subcells
    yields = math.isfinite(scene.hardness) and scene.numerics.edges == "blended"
    return YIELDING_SUBCELLS if yields else 1


def on_subcells(contact: RollingContact, subcells: int) -> RollingContact:
    """Return the same contact on sub-cells of its cells."""
    z = contact.heights
    if not _kept or _kept[0][0] is not z or _kept[0][1] != subcells:
        smooth = dies_out(z)
        _kept[:] = [(z, subcells, smooth, subcell_heights(z, subcells, smooth))]
    _, _, smooth, fine = _kept[0]
    return replace(
        contact,
        heights=fine,
        spacing=contact.spacing / subcells,
        subcells=subcells,
        slopes=smooth,
    )


def rolling_contact(scene: Scene, over: Array | None = None) -> RollingContact:
    """Make the rolling contact of a scene, over its own heights or over others [m].

    Raises
    ------
    SceneError
        The surface cannot be made or read.
    """
    contact = RollingContact(
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
    if contact.has_blended_edges or subcells_of(scene) > 1:
        return on_subcells(contact, subcells_of(scene))
    return contact
