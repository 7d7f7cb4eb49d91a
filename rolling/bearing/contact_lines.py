"""Lines along which the ring that moves presses the balls, at contact angles that loads may turn.

The centres of both grooves are A = r_i + r_o - D apart where a ball just touches, and a gap nearer
while the ring is centred. Displacements of the ring move them, in the plane of a ball, by v along
the radius and the axis, and press the ball by

    |(A - gap) n + v| - A

along the line between the centres, whose direction without displacement is n (A. B. Jones, Trans.
ASME 82 D, 1960). With the curvature c = 1/(A - gap), p = n . v and q the part of v across n, that
length is the elongation e of the line less the gap, and its direction is n' with its normal t':

    e = (2 p + c (p^2 + q^2)) / (1 + w),   w = |(1 + c p, c q)|,   n' = ((1 + c p) n + c q t) / w

Nothing cancels in them, however small the displacements are. A fixed angle is the case c = 0.

A load Q that turns with its line holds the ring across it as well. The tangent stiffness of a ball
is k n' n'^T + Q c/w t' t'^T.
"""

from dataclasses import dataclass
from functools import cached_property
from math import cos, sin
from typing import Literal, NamedTuple

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.bearing.geometry import BearingGeometry, Ring

Angle = Literal["fixed", "moving"]
"""Whether the contact angle stays as it is without load, or turns with the displacement."""
# Displacements of a rigid ring, before those of bending: x, y, z, and turns about x and y.
RIGID = 5


class PressedLines(NamedTuple):
    """Lines at a displacement of the ring, for each place."""

    approach_m: Array  # (n,) by which a ball is pressed; negative where it is free
    lines: Array  # (n, m) derivative of the approach by the displacement, the line's direction
    across: Array  # (n, m) the same of a way across the line
    turning: Array  # (n,) [1/m] turn of a line for a way across it, 0 at a fixed angle
    angles: Array  # (n,) [rad] contact angle of each line

    def of(self, columns: list[int]) -> "PressedLines":
        """Return the lines for some of the displacements alone."""
        return self._replace(lines=self.lines[:, columns], across=self.across[:, columns])


@dataclass(frozen=True)
class ContactLines:
    """Lines of balls at some places, and what a displacement of the ring makes of them.

    places : array (n,), rad. Angles of the balls, from x, the middle of the load zone.
    contact_angle : float, rad. Contact angle without displacement.
    gap_m : float, m. Gap of each ball along its line while the ring is centred.
    curvature : float, 1/m. 1/(A - gap), or 0 at a fixed angle.
    moving : "inner" or "outer". Ring that moves.
    tilt_radius_m : float, m. Radius of the circle of the centres of its groove.
    orders : tuple of int. Waves around the ring of its bending modes.
    """

    __repr__ = short_repr

    places: Array
    contact_angle: float
    gap_m: float
    curvature: float
    moving: Ring
    tilt_radius_m: float
    orders: tuple[int, ...] = ()

    @cached_property
    def _ways(self) -> tuple[Array, Array]:
        """Ways p along the lines and q across them for a unit of each displacement, (n, m) each."""
        sign = 1.0 if self.moving == "inner" else -1.0
        radial = np.zeros((len(self.places), RIGID + 2 * len(self.orders)))
        axial = np.zeros_like(radial)
        radial[:, 0] = sign * np.cos(self.places)
        radial[:, 1] = sign * np.sin(self.places)
        axial[:, 2] = 1.0
        axial[:, 3] = self.tilt_radius_m * np.sin(self.places)
        axial[:, 4] = -self.tilt_radius_m * np.cos(self.places)
        for number, order in enumerate(self.orders):
            radial[:, RIGID + 2 * number] = sign * np.cos(order * self.places)
            radial[:, RIGID + 2 * number + 1] = sign * np.sin(order * self.places)
        cosine, sine = cos(self.contact_angle), sin(self.contact_angle)
        return cosine * radial + sine * axial, cosine * axial - sine * radial

    def at(self, displacement: Array) -> PressedLines:
        """Return the lines at a displacement of the ring.

        Parameters
        ----------
        displacement : array (3,), (5,) or (5 + 2 k,)
            x, y radial and z axial [m], the turns [rad] of the ring about x and y, and the cosine
            and the sine part [m] of each of k bending modes. A positive z presses the balls,
            whichever ring moves.
        """
        count = len(displacement)
        along, across = (way[:, :count] for way in self._ways)
        p = along @ displacement
        q = across @ displacement
        stretched = 1 + self.curvature * p
        turned = self.curvature * q
        length = np.hypot(stretched, turned)
        elongation = (2 * p + self.curvature * (p**2 + q**2)) / (1 + length)
        cosine = (stretched / length)[:, None]
        sine = (turned / length)[:, None]
        return PressedLines(
            approach_m=elongation - self.gap_m,
            lines=cosine * along + sine * across,
            across=cosine * across - sine * along,
            turning=self.curvature / length,
            angles=self.contact_angle + np.arctan2(turned, stretched),
        )


def contact_lines(
    geometry: BearingGeometry,
    places: Array,
    *,
    gap_m: float = 0.0,
    moving: Ring = "outer",
    angle: Angle = "fixed",
    orders: tuple[int, ...] = (),
) -> ContactLines:
    """Return the lines of balls at some places of a bearing.

    Parameters
    ----------
    geometry : BearingGeometry
        Its contact angle is that without load.
    places : array (n,), rad
        Angles of the balls from the middle of the load zone.
    gap_m : float, m
        Gap of each ball along its line while the ring is centred, below the distance of the
        centres of the grooves.
    moving : "inner" or "outer"
        Ring that moves.
    angle : "fixed" or "moving"
        Whether displacements turn the lines.
    orders : tuple of int
        Waves around the ring of its bending modes. Default: it is rigid.
    """
    return ContactLines(
        places=np.asarray(places, dtype=float),
        contact_angle=geometry.contact_angle,
        gap_m=gap_m,
        curvature=line_curvature(geometry, gap_m, angle),
        moving=moving,
        tilt_radius_m=geometry.groove_circle_m(moving),
        orders=orders,
    )


def free_columns(tilts: bool, modes: int) -> list[int]:
    """Return which displacements of a ring are free, of those that its lines have.

    They are x, y and z, then its bending, then its turns.

    Parameters
    ----------
    tilts : bool
        Whether it turns about x and y.
    modes : int
        Number of its bending modes, with two displacements each.
    """
    turns = range(3, RIGID) if tilts else ()
    return [0, 1, 2, *range(RIGID, RIGID + 2 * modes), *turns]


def line_curvature(geometry: BearingGeometry, gap_m: float, angle: Angle) -> float:
    """Return by how much a way across a line turns it [1/m], 0 at a fixed angle."""
    return 1 / (geometry.groove_distance_m - gap_m) if angle == "moving" else 0.0
