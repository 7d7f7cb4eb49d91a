"""Rolling contact on sub-cells: heights within the cells, and how many sub-cells `auto` takes."""

from dataclasses import replace

from rolling.contact.state import RollingContact, kept
from rolling.surface import refined


def auto_subcells(contact: RollingContact) -> int:
    """Choose the sub-cells along the side of a cell for a contact, as `numerics.subcells: auto`."""
    if not contact.has_blended_edges:
        return 1
    z = contact.heights
    slope = refined.rms_slope(kept(z, "step", lambda: refined.median_step(z)), contact.spacing)
    return refined.auto_subcells(slope, contact.contact_modulus, contact.hardness)


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
