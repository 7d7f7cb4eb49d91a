"""Geometry of a ball bearing, and the largest load and pressure of its balls, in closed form.

The rules of a scene need them before anything is computed. Sources: Harris and Kotzalas, Rolling
Bearing Analysis (2007), ch. 2, 6 and 7; K. L. Johnson, Contact Mechanics (1985), ch. 4.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from rolling.contact.closed_forms import hertz_ellipse, hertz_radius

SHOULDER = 0.2  # height of a shoulder over the diameter of a ball, as in usual bearings
_STEPS = 100  # of a bisection, which halves its range each time


@dataclass(frozen=True)
class Raceways:
    """Balls between two raceways, in SI.

    Attributes
    ----------
    balls : int
        Number of balls
    ball_diameter, pitch_diameter : float, m
        Diameters of the balls and of the circle of their centres
    conformity_inner, conformity_outer : float
        Groove radii over the diameter of the balls
    angle : float, rad
        Contact angle at which the balls touch
    clearance : float, m
        Radial clearance that is open before the balls touch
    contact_modulus : float, Pa
        Contact modulus E* of ball and raceway
    """

    balls: int
    ball_diameter: float
    pitch_diameter: float
    conformity_inner: float
    conformity_outer: float
    angle: float
    clearance: float
    contact_modulus: float

    def contact_radii(self, ring: str) -> tuple[float, float]:
        """Return the effective radii [m] along and across of a ball on the inner or outer ring."""
        radius = self.ball_diameter / 2
        projected = self.ball_diameter * math.cos(self.angle)
        if ring == "inner":
            curvature = 1 / radius + 2 * math.cos(self.angle) / (self.pitch_diameter - projected)
            conformity = self.conformity_inner
        else:
            curvature = 1 / radius - 2 * math.cos(self.angle) / (self.pitch_diameter + projected)
            conformity = self.conformity_outer
        return 1 / curvature, conformity * self.ball_diameter / (2 * conformity - 1)

    @property
    def stiffness(self) -> float:
        """Stiffness K [N/m^1.5] of both contacts of a ball in series: Q = K d^(3/2)."""
        compliance = 0.0
        for ring in ("inner", "outer"):
            equivalent, _, _ = hertz_ellipse(*self.contact_radii(ring))
            single = 4 / 3 * self.contact_modulus * math.sqrt(equivalent)
            compliance += single ** (-2 / 3)
        return float(compliance**-1.5)

    def pressure(self, load: float) -> float:
        """Return the maximum Hertz pressure [Pa] of a ball under a load [N], on either ring."""
        pressures = []
        for ring in ("inner", "outer"):
            equivalent, along, across = hertz_ellipse(*self.contact_radii(ring))
            radius = hertz_radius(load, equivalent, self.contact_modulus)
            pressures.append(1.5 * load / (math.pi * radius**2 * along * across))
        return float(max(pressures))

    def largest_load(self, axial: float, radial: float) -> float:
        """Return the largest load [N] of a ball under an axial and a radial load [N].

        One ball is in the middle of the load zone. With an axial load the balls touch at the
        contact angle, and the balance exists while the radial load is below axial/tan(angle).
        """
        cosines = [math.cos(2 * math.pi * ball / self.balls) for ball in range(self.balls)]
        if not axial:
            return self._largest_radial_load(radial, cosines)
        thrust = axial / math.sin(self.angle)
        wanted = radial / math.cos(self.angle) / thrust
        if not wanted:
            return float(thrust / self.balls)
        # The deflection of a ball is proportional to its cosine less an offset.
        low = -1 - 1 / wanted
        high = 1.0
        for _ in range(_STEPS):
            offset = (low + high) / 2
            shares = [max(cosine - offset, 0.0) ** 1.5 for cosine in cosines]
            moment = sum(share * cosine for share, cosine in zip(shares, cosines, strict=True))
            if moment < wanted * sum(shares):
                low = offset
            else:
                high = offset
        shares = [max(cosine - low, 0.0) ** 1.5 for cosine in cosines]
        return float(thrust * shares[0] / sum(shares))

    def _largest_radial_load(self, radial: float, cosines: list[float]) -> float:
        """Return the largest load [N] of a ball under a purely radial load."""
        stiffness = self.stiffness
        gap = self.clearance / 2
        low = 0.0
        high = (radial / stiffness) ** (2 / 3)  # one ball bears everything
        for _ in range(_STEPS):
            deflection = (low + high) / 2
            shift = deflection + gap
            force = 0.0
            for cosine in cosines:
                force += max(shift * cosine - gap, 0.0) ** 1.5 * cosine
            if stiffness * force < radial:
                low = deflection
            else:
                high = deflection
        return float(stiffness * high**1.5)

    def allowed_share(self, axial: float, radial: float, limit: float) -> float:
        """Return the share of both loads at which the largest pressure is at a limit [Pa]."""
        low = -60.0  # logarithms
        high = 0.0
        for _ in range(_STEPS):
            middle = (low + high) / 2
            share = math.exp(middle)
            if self.pressure(self.largest_load(share * axial, share * radial)) < limit:
                low = middle
            else:
                high = middle
        return math.exp(low)


class RingSection(NamedTuple):
    """Cross-section of a ring with its groove, in SI."""

    radius: float  # of the ring to the middle of the section [m]
    thickness: float  # mean over the width [m]
    width: float  # [m]

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
    wall = abs(surface_radius - bottom) + depth
    half_angle = math.acos(1 - depth / groove_radius)
    groove = groove_radius**2 * (half_angle - math.sin(half_angle) * math.cos(half_angle))
    thickness = wall - min(groove / width, depth)
    middle = -thickness / 2 if is_outer else thickness / 2
    return RingSection(radius=surface_radius + middle, thickness=thickness, width=width)


def groove_distance(ball_diameter: float, inner: float, outer: float) -> float:
    """Return the distance of the centres of both grooves [m] from the ball and both conformities.

    It is r_i + r_o - D.
    """
    return (inner + outer - 1) * ball_diameter


def angle_of(clearance: float, distance: float) -> float:
    """Return the free contact angle [rad] of a radial clearance and a distance of the grooves [m].

    cos(angle) = 1 - clearance/(2 distance)
    """
    return math.acos(1 - clearance / (2 * distance))


def clearance_of(angle: float, distance: float) -> float:
    """Return the radial clearance [m] of a free contact angle [rad]."""
    return 4 * distance * math.sin(angle / 2) ** 2
