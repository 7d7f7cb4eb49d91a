"""Lengths of a ball bearing in closed form: contact angle and clearance, section of a ring."""

from __future__ import annotations

import math
from typing import NamedTuple

SHOULDER = 0.2  # height of a shoulder over the diameter of a ball, as in usual bearings


class RingSection(NamedTuple):
    """Cross-section of a ring with its groove, in SI."""

    radius: float  # of the ring to the middle of the section [m]
    thickness: float  # mean over the width [m]
    width: float  # [m]
    wall: float  # behind the bottom of the groove [m]
    depth: float  # of the groove below the shoulders [m]

    @property
    def area(self) -> float:
        """Area of the section [m2]."""
        return self.thickness * self.width


def ring_section(
    surface_radius: float,
    pitch_radius: float,
    ball_radius: float,
    groove_radius: float,
    width: float,
) -> RingSection:
    """Return the cross-section of a ring from the radius of its cylinder [m] to its shoulders.

    The shoulders rise above the bottom of the groove by SHOULDER ball diameters.
    """
    is_outer = surface_radius > pitch_radius
    bottom = pitch_radius + ball_radius if is_outer else pitch_radius - ball_radius
    depth = SHOULDER * 2 * ball_radius
    wall = abs(surface_radius - bottom)
    half_angle = math.acos(1 - depth / groove_radius)
    groove = groove_radius**2 * (half_angle - math.sin(half_angle) * math.cos(half_angle))
    thickness = wall + depth - min(groove / width, depth)
    middle = -thickness / 2 if is_outer else thickness / 2
    return RingSection(
        radius=surface_radius + middle, thickness=thickness, width=width, wall=wall, depth=depth
    )


def groove_distance(ball_diameter: float, inner: float, outer: float) -> float:
    """Return the distance of the centres of both grooves [m] from the ball and both conformities.

    It is r_i + r_o - D.
    """
    return (inner + outer - 1) * ball_diameter


def angle_of(clearance: float, distance: float) -> float:
    """Return the free contact angle [rad] of a radial clearance and a distance of the grooves [m].

    cos(angle) = 1 - clearance/(2 distance). Balls that a negative clearance presses touch in the
    middle of the grooves, at 0.
    """
    return math.acos(1 - max(clearance, 0.0) / (2 * distance))


def clearance_of(angle: float, distance: float) -> float:
    """Return the radial clearance [m] of a free contact angle [rad]."""
    return 4 * distance * math.sin(angle / 2) ** 2
