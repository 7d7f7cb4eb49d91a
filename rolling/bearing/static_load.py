"""Static balance of the ring that moves: its displacement, the loads of the balls, its stiffness.

The ring is rigid, does not tilt, and is pressed by the loads against balls whose contacts are Hertz
springs in series. The balance is the minimum of a convex energy, so Newton's method finds it.
"""

from dataclasses import dataclass
from math import cos, pi, tan

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.bearing.geometry import BearingGeometry, Ring, contact_lines

_MAX_ITERATIONS = 200
_TOLERANCE = 1e-11  # of the load
_ROUNDING = 1e-13  # of the energy
_SMALLEST_CURVATURE = 1e-9  # of the mean stiffness, where balls do not hold a direction


@dataclass(frozen=True)
class StaticBalance:
    """Balance of the ring that moves under its loads."""

    __repr__ = short_repr

    displacement_m: Array  # (3,) x, y, z of the ring
    ball_load_n: Array  # (balls,)
    stiffness_n_m: Array  # (3, 3) tangent stiffness of all balls


def load_vector(axial_load_n: float, radial_load_n: float, moving: Ring) -> Array:
    """Return the load on the ring that moves [N], (3,).

    The radial load presses it against the balls at angle 0, the middle of the load zone.
    """
    sign = 1.0 if moving == "inner" else -1.0
    return np.array([sign * radial_load_n, 0.0, axial_load_n])


def least_axial_load(geometry: BearingGeometry, radial_load_n: float) -> float:
    """Return the axial load [N] that must be exceeded so that a radial load has a balance.

    At a fixed contact angle the balls push the ring off along its axis. With a ball on either side
    of the load zone's middle, their loads balance both forces if F_a > F_r tan(alpha) / cos(pi/Z).
    """
    return radial_load_n * tan(geometry.contact_angle) / cos(pi / geometry.balls)


def static_balance(
    geometry: BearingGeometry,
    *,
    axial_load_n: float,
    radial_load_n: float,
    cage_angle: float = 0.0,
    gap_m: float = 0.0,
    moving: Ring = "outer",
) -> StaticBalance:
    """Return the static balance of the ring that moves.

    Parameters
    ----------
    geometry : BearingGeometry
    axial_load_n, radial_load_n : float, N
        Loads on the ring, not negative, one of them positive.
    cage_angle : float, rad
        Angle of ball 0 from the middle of the load zone.
    gap_m : float, m
        Gap of each ball along its contact line while the ring is centred: half of the radial
        clearance at contact angle 0, and zero where an axial load has closed it.
    moving : "outer" or "inner"
        Ring that moves.

    Returns
    -------
    StaticBalance

    Raises
    ------
    ValueError
        If no load acts, or the axial load does not hold the ring on its balls.
    """
    if axial_load_n < 0 or radial_load_n < 0 or axial_load_n + radial_load_n <= 0:
        raise ValueError("loads of a bearing: allowed: not negative, and one of them positive")
    least = least_axial_load(geometry, radial_load_n)
    if geometry.contact_angle > 0 and axial_load_n <= least:
        raise ValueError(
            f"axial_load_n: got {axial_load_n:g}, allowed: more than {least:g} at the radial load"
            f" of {radial_load_n:g} N, or the ring is pushed off its balls"
        )
    if geometry.contact_angle <= 0 and axial_load_n > 0:
        raise ValueError(
            f"axial_load_n: got {axial_load_n:g}, allowed: 0 at a contact angle of 0, where no ball"
            " bears an axial load"
        )
    lines = contact_lines(geometry.ball_angles(cage_angle), geometry.contact_angle, moving)
    load = load_vector(axial_load_n, radial_load_n, moving)
    return _minimum(lines, geometry.series_stiffness, load, gap_m)


def _minimum(lines: Array, stiffness: float, load: Array, gap_m: float) -> StaticBalance:
    """Return the state of minimum energy, by Newton's method with steps that lower the energy."""
    size = float(np.linalg.norm(load))
    typical = (size / stiffness) ** (2 / 3)
    displacement = (gap_m + typical) * load / size
    energy = _energy(lines, stiffness, load, gap_m, displacement)
    for _ in range(_MAX_ITERATIONS):
        forces, tangents = _forces(lines, stiffness, gap_m, displacement)
        missing = load - forces @ lines
        if np.linalg.norm(missing) <= _TOLERANCE * size:
            break
        curvature = (lines.T * tangents) @ lines
        smallest = _SMALLEST_CURVATURE * (np.trace(curvature) + stiffness * np.sqrt(typical))
        step = np.linalg.solve(curvature + smallest * np.eye(3), missing)
        share = 1.0
        new = _energy(lines, stiffness, load, gap_m, displacement + step)
        while new > energy + _ROUNDING * abs(energy) and share > 1e-12:
            share /= 2
            new = _energy(lines, stiffness, load, gap_m, displacement + share * step)
        displacement = displacement + share * step
        energy = new
    forces, tangents = _forces(lines, stiffness, gap_m, displacement)
    return StaticBalance(
        displacement_m=displacement,
        ball_load_n=forces,
        stiffness_n_m=(lines.T * tangents) @ lines,
    )


def _forces(
    lines: Array, stiffness: float, gap_m: float, displacement: Array
) -> tuple[Array, Array]:
    """Return the load [N] and the stiffness [N/m] of each ball at a displacement of the ring."""
    approach = np.maximum(lines @ displacement - gap_m, 0.0)
    return stiffness * approach**1.5, 1.5 * stiffness * np.sqrt(approach)


def _energy(
    lines: Array, stiffness: float, load: Array, gap_m: float, displacement: Array
) -> float:
    """Return the energy [J] of all contacts and of the load."""
    approach = np.maximum(lines @ displacement - gap_m, 0.0)
    return float(0.4 * stiffness * np.sum(approach**2.5) - load @ displacement)
