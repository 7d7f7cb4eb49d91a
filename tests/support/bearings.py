"""Bearings for tests of the room `rolling/bearing`, by their dimensions alone."""

from __future__ import annotations

from math import radians

from rolling.bearing.geometry import BearingGeometry, assemble
from rolling.contact.closed_forms import contact_modulus

STEEL = contact_modulus(210e9, 0.3, 210e9, 0.3)


def bearing(
    balls: int = 8,
    ball_mm: float = 7.938,
    pitch_mm: float = 33.5,
    angle_deg: float = 12.0,
    inner: float = 0.515,
    outer: float = 0.525,
) -> BearingGeometry:
    """Return a bearing of steel, like a 6204 by default."""
    return assemble(
        balls=balls,
        ball_diameter_m=1e-3 * ball_mm,
        pitch_diameter_m=1e-3 * pitch_mm,
        contact_angle=radians(angle_deg),
        conformity_inner=inner,
        conformity_outer=outer,
        contact_modulus=STEEL,
    )


def angular(balls: int = 17) -> BearingGeometry:
    """Return an angular contact bearing, like a 7210."""
    return bearing(balls=balls, ball_mm=12.7, pitch_mm=70.0, angle_deg=40.0, inner=0.52, outer=0.53)


def miniature(balls: int = 7) -> BearingGeometry:
    """Return a miniature bearing, like a 608."""
    return bearing(balls=balls, ball_mm=3.969, pitch_mm=15.0, angle_deg=15.0, inner=0.52)
