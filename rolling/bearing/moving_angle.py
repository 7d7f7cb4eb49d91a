"""Static balance of a bearing whose contact angles turn under load (Jones).

The centres of both grooves are A = r_i + r_o - D apart where a ball just touches, at the free angle
alpha_0. A displacement of the rings by d_r along the radial load and d_a along the axis moves them,
at the angle phi of a ball from the middle of the load zone, to

    s_r = A cos(alpha_0) + d_r cos(phi),    s_a = A sin(alpha_0) + d_a

The ball is pressed by |s| - A, along a line whose angle is that of s. The rings do not tilt. The
motion of a ring keeps the free angle; this balance says how far the loads would turn it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import cos, pi, sin

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.bearing.geometry import BearingGeometry

_PLACES = 8  # of the cage, over which angles are stated
_TOLERANCE = 1e-10  # of the load
_BEARING = 1e-6  # of the largest load of a ball, from which on another one bears load


@dataclass(frozen=True)
class MovingAngleBalance:
    """Balance of two rings under loads that turn the contact angles.

    radial_m, axial_m : float, m. Displacement from where all balls just touch at the free angle.
    angles : array (balls,), rad. Contact angle of each ball.
    ball_load_n : array (balls,), N. Load of each ball.
    """

    __repr__ = short_repr

    radial_m: float
    axial_m: float
    angles: Array
    ball_load_n: Array


def moving_angle_balance(
    geometry: BearingGeometry,
    *,
    axial_load_n: float,
    radial_load_n: float,
    cage_angle: float = 0.0,
) -> MovingAngleBalance:
    """Return the balance of two rings under loads that turn the contact angles.

    Parameters
    ----------
    geometry : BearingGeometry
        Its contact angle is that without load.
    axial_load_n, radial_load_n : float, N
        Loads, not negative, one of them positive.
    cage_angle : float, rad
        Angle of ball 0 from the middle of the load zone.
    """
    from scipy.optimize import minimize  # slow to import

    distance = geometry.groove_distance_m
    stiffness = geometry.series_stiffness
    load = np.array([radial_load_n, axial_load_n])
    size = float(np.hypot(*load))
    length = (size / stiffness) ** (2 / 3)  # typical approach, in which displacements are counted
    free = np.array([cos(geometry.contact_angle), sin(geometry.contact_angle)]) * distance
    zone = np.cos(geometry.ball_angles(cage_angle))
    reach = np.stack((zone, np.ones_like(zone)), axis=1)  # of both displacements at each ball

    def state(displacement: Array) -> tuple[Array, Array, Array]:
        """Return directions (balls, 2), distances and approaches of the balls (balls,)."""
        vectors = free + length * displacement * reach
        distances = np.hypot(vectors[:, 0], vectors[:, 1])
        return vectors / distances[:, None], distances, np.maximum(distances - distance, 0.0)

    def energy(displacement: Array) -> float:
        """Return the energy of contacts and loads, over the load times the typical approach."""
        _, _, approach = state(displacement)
        elastic = 0.4 * stiffness * float(np.sum(approach**2.5)) / (size * length)
        return float(elastic - load @ displacement / size)

    def slope(displacement: Array) -> Array:
        """Return the forces that lack, over the load."""
        directions, _, approach = state(displacement)
        forces = stiffness * approach[:, None] ** 1.5 * directions * reach
        return np.asarray((forces.sum(axis=0) - load) / size)

    def curvature(displacement: Array) -> Array:
        """Return the stiffness of all balls, (2, 2), over the load and the typical approach."""
        directions, distances, approach = state(displacement)
        along = 1.5 * stiffness * np.sqrt(approach)
        across = stiffness * approach**1.5 / distances  # by the turning of the line
        outer = directions[:, :, None] * directions[:, None, :]
        both = (along - across)[:, None, None] * outer + across[:, None, None] * np.eye(2)
        both = both * reach[:, :, None] * reach[:, None, :]
        return np.asarray(both.sum(axis=0) * length / size)

    minimum = minimize(
        energy,
        load / size,
        jac=slope,
        hess=curvature,
        method="trust-exact",
        options={"gtol": _TOLERANCE, "maxiter": 1000},
    )
    directions, _, approach = state(minimum.x)
    radial, axial = (length * minimum.x).tolist()
    return MovingAngleBalance(
        radial_m=radial,
        axial_m=axial,
        angles=np.arctan2(directions[:, 1], directions[:, 0]),
        ball_load_n=stiffness * approach**1.5,
    )


@lru_cache(maxsize=8)  # of bearings whose check, doubts and numbers ask for the same angles
def angles_under_loads(
    geometry: BearingGeometry, *, axial_load_n: float, radial_load_n: float
) -> tuple[float, float]:
    """Return the least and the largest contact angle [rad] of balls that bear load.

    They are those over the places of the cage, as `moving_angle_balance` has them.
    """
    angles: list[float] = []
    for place in range(_PLACES):
        balance = moving_angle_balance(
            geometry,
            axial_load_n=axial_load_n,
            radial_load_n=radial_load_n,
            cage_angle=2 * pi * place / (_PLACES * geometry.balls),
        )
        loads = balance.ball_load_n
        angles += balance.angles[loads > _BEARING * loads.max()].tolist()
    return min(angles), max(angles)
