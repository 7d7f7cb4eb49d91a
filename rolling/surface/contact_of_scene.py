"""Rolling contact of a scene for the march: surface, bodies and numerics as plain numbers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rolling._typing import Array
from rolling.contact.half_space import HalfSpace
from rolling.contact.solver import own_deflection
from rolling.contact.state import RollingContact
from rolling.scene.scene import Scene
from rolling.surface.refinement import dies_out, subcell_heights
from rolling.surface.scene_surface import heights

# Sub-cells that `subcells: auto` takes on steep surfaces.
STEEP_SUBCELLS = 2
# A surface is steep from this ratio on: half the range of heights over a cell, by its slope, over a
# node's deflection by the hardness on its own cell. Ra 0.1 um at 2.1 GPa has 1.2, Ra 1 um 12.
STEEP = 3.0


def rolling_contact(scene: Scene, over: Array | None = None) -> RollingContact:
    """Make the rolling contact of a scene over its own or other heights [m].

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
    subcells = scene.numerics.subcells
    return on_subcells(contact, auto_subcells(contact) if subcells == "auto" else subcells)


def auto_subcells(contact: RollingContact) -> int:
    """Choose the sub-cells along the side of a cell for a contact.

    Sub-cells gain most where the heights vary within a cell by more than pressures can level: on
    steep surfaces that yield. Elsewhere a single node per cell finds the edge well enough, as it
    does in an elastic contact.
    """
    if not contact.has_blended_edges:
        return 1
    rise = 0.5 * _between(contact.heights).slope(contact.spacing) * contact.spacing
    half_space = HalfSpace(contact.spacing, contact.contact_modulus)
    steep = rise > STEEP * own_deflection(half_space, contact.hardness)
    return STEEP_SUBCELLS if steep else 1


def on_subcells(
    contact: RollingContact, subcells: int, smooth: bool | None = None
) -> RollingContact:
    """Return a contact on sub-cells of its cells.

    Parameters
    ----------
    contact : RollingContact
        A contact on cells.
    subcells : int
        Sub-cells along the side of a cell.
    smooth : bool or None
        True if the surface continues between its nodes. Default: its spectrum decides.
    """
    if subcells == 1 and not contact.has_blended_edges:
        return contact
    between = _between(contact.heights)
    if smooth is not None:
        between.smooth = smooth
    return replace(
        contact,
        heights=between.on_subcells(subcells),
        spacing=contact.spacing / subcells,
        subcells=subcells,
        slopes=between.smooth,
    )


@dataclass(eq=False)
class _Between:
    """The heights between the nodes of a surface, kept for further runs over it."""

    heights: Array
    fine: tuple[int, Array] | None = None

    @cached_property
    def smooth(self) -> bool:
        """True if the surface continues between its nodes."""
        return dies_out(self.heights)

    def slope(self, spacing: float) -> float:
        """Return the rms slope that random heights of the same median slope have.

        Pits and scratches, which are steep in few places, do not count.
        """
        z = self.heights
        steps = np.hypot(np.roll(z, -1, axis=0) - z, np.roll(z, -1, axis=1) - z)
        return float(np.median(steps) / spacing / np.sqrt(np.log(2)))

    def on_subcells(self, subcells: int) -> Array:
        """Return the heights of sub-cells [m]."""
        if self.fine is None or self.fine[0] != subcells:
            self.fine = subcells, subcell_heights(self.heights, subcells, self.smooth)
        return self.fine[1]


_kept: list[_Between] = []


def _between(z: Array) -> _Between:
    """Return the heights between the nodes of a surface; the last surface is kept."""
    if not _kept or _kept[0].heights is not z:
        _kept[:] = [_Between(z)]
    return _kept[0]
