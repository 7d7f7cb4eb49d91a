"""Rolling contact of a scene for the march: surface, bodies and numerics as plain numbers."""

from dataclasses import dataclass, replace
from functools import cached_property

from acoustics.arrays import Array
from rolling.contact.state import RollingContact, fingerprint
from rolling.scene.scene import Scene
from rolling.surface import refined
from rolling.surface.scene_surface import has_detail, heights


def rolling_contact(scene: Scene, over: Array | None = None) -> RollingContact:
    """Make the rolling contact of a scene over its own or other heights [m]."""
    contact = RollingContact(
        heights=heights(scene) if over is None else over,
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
    chosen = scene.numerics.subcells
    subcells = auto_subcells(contact) if chosen == "auto" else chosen
    return on_subcells(contact, subcells, continues(scene))


def continues(scene: Scene) -> bool | None:
    """Return whether the laws of a surface end before its grid does; None without a law.

    The spectrum of a surface of a few correlation lengths has a tail, from the edge of its period
    alone, that is no detail between nodes. Single faults follow no law.
    """
    return not has_detail(scene) if scene.laws and not scene.faults else None


def auto_subcells(contact: RollingContact) -> int:
    """Choose the sub-cells along the side of a cell for a contact, as `numerics.subcells: auto`."""
    if not contact.has_blended_edges:
        return 1
    slope = refined.rms_slope(_between(contact.heights).median_step, contact.spacing)
    return refined.auto_subcells(slope, contact.contact_modulus, contact.hardness)


def on_subcells(
    contact: RollingContact, subcells: int, smooth: bool | None = None
) -> RollingContact:
    """Split the cells of a contact into sub-cells, r along the side of a cell.

    If `smooth`, the surface continues between its nodes. Default: its spectrum decides.
    """
    if subcells == 1 and not contact.has_blended_edges:
        return contact
    between = _between(contact.heights)
    smooth = between.smooth if smooth is None else smooth
    return replace(
        contact,
        heights=between.on_subcells(subcells, smooth),
        spacing=contact.spacing / subcells,
        subcells=subcells,
        slopes=smooth,
    )


@dataclass(eq=False)
class _Between:
    """Heights between the nodes of a surface, kept for further contacts on it."""

    heights: Array
    fingerprint: float
    fine: tuple[int, bool, Array] | None = None

    @cached_property
    def smooth(self) -> bool:
        """Whether the surface continues between its nodes."""
        return refined.dies_out(self.heights)

    @cached_property
    def median_step(self) -> float:
        """Median change of heights from node to node [m]."""
        return refined.median_step(self.heights)

    def on_subcells(self, subcells: int, smooth: bool) -> Array:
        """Return the heights of sub-cells [m], of a surface that continues if `smooth`."""
        if self.fine is None or self.fine[:2] != (subcells, smooth):
            fine = refined.subcell_heights(self.heights, subcells, smooth)
            self.fine = subcells, smooth, fine
        return self.fine[2]


_last: list[_Between] = []


def _between(z: Array) -> _Between:
    """Return the heights between the nodes of a surface; the last surface is kept."""
    if not _last or _last[0].heights is not z or _last[0].fingerprint != fingerprint(z):
        _last[:] = [_Between(z, fingerprint(z))]
    return _last[0]
