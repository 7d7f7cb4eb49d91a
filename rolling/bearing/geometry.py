"""Geometry of a ball bearing without load, and the elliptic Hertz contacts of its balls.

The contact angle is that without load. `contact_lines` says how loads turn it.
"""

from dataclasses import dataclass
from math import cos, pi, sqrt
from typing import Literal

import numpy as np

from acoustics.arrays import Array
from rolling.contact import closed_forms

Ring = Literal["inner", "outer"]


@dataclass(frozen=True)
class RacewayContact:
    """Smooth contact of a ball with a raceway."""

    radius_m: float  # of the circle on the raceway on which the balls roll
    radius_along_m: float  # effective radius of curvature along the track
    radius_across_m: float  # effective radius of curvature across the track
    stiffness_n_m15: float  # K of Q = K d^(3/2)


@dataclass(frozen=True)
class BearingGeometry:
    """Geometry of a ball bearing in SI, with the contacts of a ball with both raceways."""

    balls: int
    ball_radius_m: float
    pitch_radius_m: float
    contact_angle: float  # [rad]
    inner: RacewayContact
    outer: RacewayContact

    @property
    def series_stiffness(self) -> float:
        """Stiffness K [N/m^1.5] of both contacts of a ball in series: Q = K d^(3/2)."""
        compliance = self.inner.stiffness_n_m15 ** (-2 / 3) + self.outer.stiffness_n_m15 ** (-2 / 3)
        return float(compliance ** (-3 / 2))

    @property
    def groove_distance_m(self) -> float:
        """Distance of the centres of both grooves r_i + r_o - D [m] where balls just touch."""
        radii = groove_radius(self.ball_radius_m, self.inner) + groove_radius(
            self.ball_radius_m, self.outer
        )
        return radii - 2 * self.ball_radius_m

    def groove_circle_m(self, ring: Ring) -> float:
        """Return the radius of the circle of the centres of a ring's groove [m]."""
        if ring == "inner":
            beside = groove_radius(self.ball_radius_m, self.inner) - self.ball_radius_m
            return self.pitch_radius_m + beside * cos(self.contact_angle)
        beside = groove_radius(self.ball_radius_m, self.outer) - self.ball_radius_m
        return self.pitch_radius_m - beside * cos(self.contact_angle)

    @property
    def ratio(self) -> float:
        """Ratio g = D cos(alpha) / d_m."""
        return self.ball_radius_m * cos(self.contact_angle) / self.pitch_radius_m

    def ball_angles(self, cage_angle: float = 0.0) -> Array:
        """Return the angles [rad] of all balls, (balls,), where ball 0 is at the cage's angle."""
        return cage_angle + 2 * pi * np.arange(self.balls) / self.balls


def groove_radius(ball_radius_m: float, contact: RacewayContact) -> float:
    """Return the radius of a groove [m] across the track: 1/R_across = 1/r_b - 1/r_groove."""
    return 1 / (1 / ball_radius_m - 1 / contact.radius_across_m)


def assemble(
    *,
    balls: int,
    ball_diameter_m: float,
    pitch_diameter_m: float,
    contact_angle: float,
    conformity_inner: float,
    conformity_outer: float,
    contact_modulus: float,
) -> BearingGeometry:
    """Return the geometry of a bearing from its dimensions.

    Parameters
    ----------
    balls : int
        Number of balls Z.
    ball_diameter_m, pitch_diameter_m : float, m
        Diameter D of the balls, and diameter d_m of the circle of their centres.
    contact_angle : float, rad
        Contact angle alpha.
    conformity_inner, conformity_outer : float
        Radius of each groove over the ball diameter, above 0.5.
    contact_modulus : float, Pa
        Contact modulus E* of ball and raceway.

    Returns
    -------
    BearingGeometry

    Raises
    ------
    ValueError
        If a groove is not wider than the balls, or the inner raceway has no radius.

    Notes
    -----
    The effective radii along the track are those of T. A. Harris, Rolling Bearing Analysis,
    chapter 2: 1/R = 1/r_b + 2 cos(alpha) / (d_m - D cos(alpha)) on the inner raceway, and
    1/r_b - 2 cos(alpha) / (d_m + D cos(alpha)) on the outer.
    """
    ball_radius = ball_diameter_m / 2
    pitch_radius = pitch_diameter_m / 2
    reach = ball_radius * cos(contact_angle)
    if pitch_radius <= reach:
        raise ValueError(
            f"pitch_diameter_m: got {pitch_diameter_m:g}, allowed: more than {2 * reach:g},"
            " so that the inner raceway has a radius"
        )
    conformities = {"conformity_inner": conformity_inner, "conformity_outer": conformity_outer}
    for name, conformity in conformities.items():
        if conformity <= 0.5:
            raise ValueError(f"{name}: got {conformity:g}, allowed: more than 0.5")
    inner_curvature = 1 / ball_radius + cos(contact_angle) / (pitch_radius - reach)
    outer_curvature = 1 / ball_radius - cos(contact_angle) / (pitch_radius + reach)
    inner_across = 1 / ball_radius - 1 / (conformity_inner * ball_diameter_m)
    outer_across = 1 / ball_radius - 1 / (conformity_outer * ball_diameter_m)
    return BearingGeometry(
        balls=balls,
        ball_radius_m=ball_radius,
        pitch_radius_m=pitch_radius,
        contact_angle=contact_angle,
        inner=_contact(pitch_radius - reach, inner_curvature, inner_across, contact_modulus),
        outer=_contact(pitch_radius + reach, outer_curvature, outer_across, contact_modulus),
    )


def _contact(
    radius_m: float, curvature_along: float, curvature_across: float, contact_modulus: float
) -> RacewayContact:
    """Return a contact from its effective curvatures [1/m]."""
    along = 1 / curvature_along
    across = 1 / curvature_across
    equivalent, _, _ = closed_forms.hertz_ellipse(along, across)
    return RacewayContact(
        radius_m=radius_m,
        radius_along_m=along,
        radius_across_m=across,
        stiffness_n_m15=4 / 3 * contact_modulus * sqrt(equivalent),
    )
