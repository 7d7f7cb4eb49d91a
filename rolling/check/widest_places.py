"""Places where a contact is wider than its surface: what heights tell before a march.

A contact ends at its outermost loaded nodes. On a rough surface these are lone summits far from the
middle, so the width differs from surface to surface: 84 to 136 um over twelve seeds of one law,
where the mean width is 70 um. A summit is loaded where its gap is less than the approach, and a
Winkler foundation knows the approach within a tenth of the roughness. So the positions at risk are
found without a solve. A cold start at the widest of them is certain.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rolling.check.highest_summit import hertz_approach, is_surely_wide_enough
from rolling.contact import closed_forms, solver
from rolling.contact.march import march
from rolling.contact.solver import ContactError
from rolling.contact.state import RollingContact, Window
from rolling.contact.subcells import half_space_of
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.scene.scene import Scene

SAMPLES = 8  # positions whose approach tells that of the others
SPREAD = 2.5  # standard deviations of the approach that the first search allows
# The foundation of a smooth contact sinks by 0.58 of the Hertz approach, and less is missing on a
# rough one.
MISSING = 0.42
LOOKED_AT = 32  # positions whose own approach is computed, the widest first
SOLVED = 4  # positions that are solved


class _Place(NamedTuple):
    """Position of a contact, and how far it reaches over the period of the surface [-]."""

    position: int
    share: float


def reason_against(scene: Scene) -> str:
    """Return why a track has no solution, as positions that are solved tell; empty if none does.

    Positions are solved where the contact may be wider than the surface.
    """
    if is_surely_wide_enough(scene):
        return ""
    contact = rolling_contact(scene)
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    try:
        places = _places_at_risk(scene, contact, 0.0)
        if not places:
            places = _places_at_risk(scene, contact, MISSING * hertz_approach(scene))
        for place in places[:: max(1, len(places) // SOLVED)][:SOLVED]:
            for _ in march(contact, place.position, place.position, half_space):
                pass
    except ContactError as error:
        return str(error)
    return ""


def may_be_too_narrow(scene: Scene) -> bool:
    """Tell whether a contact is probably wider than the surface somewhere; nothing is solved.

    What the foundation lacks in approach, the deflection beside the load takes away.
    """
    if is_surely_wide_enough(scene):
        return False
    try:
        return bool(_places_at_risk(scene, rolling_contact(scene), 0.0))
    except ContactError:  # a load that no foundation carries, which other rules refuse
        return False


# ---- positions at risk


def _places_at_risk(scene: Scene, contact: RollingContact, missing: float) -> list[_Place]:
    """Return positions where the contact may be wider than the surface, the widest first.

    Parameters
    ----------
    scene, contact : Scene, RollingContact. The scene, and its contact.
    missing : float, m. Approach that the foundation lacks.
    """
    steps = scene.track.solved_steps
    samples = [_approach(contact, k * steps // SAMPLES) for k in range(SAMPLES)]
    highest = float(np.mean(samples) + SPREAD * np.std(samples)) + missing
    wide = [place for place in _places(contact, range(steps + 1), highest) if place.share > 1]
    places = []
    for place in sorted(wide, key=lambda place: -place.share)[:LOOKED_AT]:
        k = place.position
        places += _places(contact, range(k, k + 1), _approach(contact, k) + missing)
    return sorted([place for place in places if place.share > 1], key=lambda place: -place.share)


def _places(contact: RollingContact, positions: range, approach: float) -> list[_Place]:
    """Return positions with their widths at an approach [m]."""
    along, across = contact.heights.shape
    radius, radius_across = contact.radii
    reach = 2 * (approach + contact.maxima.highest)
    longest = 2 * math.sqrt(max(0.0, radius * reach)) / contact.spacing
    widest = 2 * math.sqrt(max(0.0, radius_across * reach)) / contact.spacing
    if longest < along and widest < across:  # the highest summit of the surface touches nowhere
        return []
    border = 2 if contact.has_blended_edges else 0
    places = []
    for k in positions:
        window = contact.overlap(k, approach)
        if window is not None:
            share = max((window.rows - border) / along, (window.columns - border) / across)
            places.append(_Place(k, share))
    return places


def _approach(contact: RollingContact, k: int) -> float:
    """Return the approach at position k on a Winkler foundation that fits Hertz [m]."""
    radius, _, _ = closed_forms.hertz_ellipse(*contact.radii)
    hertz = closed_forms.hertz_radius(contact.load, radius, contact.contact_modulus)
    stiffness = 4 * contact.contact_modulus / (math.pi * hertz)
    window = _foundation_window(contact, k, hertz**2 / radius)
    gap = contact.gap(k, window)
    pressure = solver.foundation(gap, contact.load, contact.spacing, stiffness, contact.hardness)
    loaded = pressure > 0
    return float((pressure[loaded] / stiffness + gap[loaded]).max())


def _foundation_window(contact: RollingContact, k: int, approach: float) -> Window:
    """Return the nodes that a smooth contact may load at position k, within one surface."""
    place = contact.position(k), contact.mid_width
    row, column = (round(distance / contact.spacing) for distance in place)
    along, across = contact.heights.shape
    whole = Window(row - along // 2, column - across // 2, along, across)
    around = contact.overlap(k, approach)
    if around is None:
        return whole
    wanted = around.room(contact.subcells)
    first_row = max(whole.row, wanted.row)
    first_column = max(whole.column, wanted.column)
    return Window(
        row=first_row,
        column=first_column,
        rows=min(whole.row + along, wanted.row + wanted.rows) - first_row,
        columns=min(whole.column + across, wanted.column + wanted.columns) - first_column,
    )
