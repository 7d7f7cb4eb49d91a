"""Bearings for tests of the room `rolling/bearing`, by their dimensions alone."""

from __future__ import annotations

from math import acos, cos, pi, radians

import numpy as np
from scipy.integrate import quad

from rolling.bearing.geometry import BearingGeometry, assemble
from rolling.bearing.kinematics import kinematics_of
from rolling.bearing.model import BearingModel
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


def model(geometry: BearingGeometry | None = None, **changes) -> BearingModel:
    """Return a bearing that turns, by default under an axial load of 70 N at 1,800 rpm.

    `turning` and `turns_hz` are those of `kinematics_of`.
    """
    shape = geometry or bearing()
    speeds = kinematics_of(shape, changes.pop("turning", "inner"), changes.pop("turns_hz", 30.0))
    ball_mass = 7800 * 4 / 3 * pi * shape.ball_radius_m**3
    given = {"ring_mass_kg": 0.06, "ball_mass_kg": ball_mass, "axial_load_n": 70.0}
    given |= {"radial_load_n": 0.0} | changes
    return BearingModel(geometry=shape, kinematics=speeds, **given)


def line(signal: np.ndarray, frequency_hz: float, rate_hz: float = 48000.0) -> complex:
    """Return the complex amplitude of a line of a record, by a Hann window and least squares.

    The record is long against the distance of its lines.
    """
    time = np.arange(len(signal)) / rate_hz
    window = np.hanning(len(signal))
    tone = np.exp(-2j * np.pi * frequency_hz * time)
    return complex(2 * np.sum(window * tone * signal) / np.sum(window))


def sjovall(load_zone: float) -> tuple[float, float]:
    """Return Sjoevall's integrals J_r and J_a of the load distribution over many balls.

    Parameters
    ----------
    load_zone : float
        Parameter epsilon of the load zone, positive: 0.5 (1 - P_d / (2 delta_r)) under a radial
        load alone, 0.5 without clearance.

    Returns
    -------
    radial, axial : float
        F_r = Z Q_max cos(alpha) J_r, and F_a = Z Q_max sin(alpha) J_a.

    Notes
    -----
    H. Sjoevall, Teknisk Tidskrift 1933, as T. A. Harris, Rolling Bearing Analysis, chapter 7, has
    them: J = 1 / (2 pi) times the integral of (1 - (1 - cos(psi)) / (2 epsilon))^1.5, for J_r times
    cos(psi), over the load zone.
    """
    end = pi if load_zone >= 1 else acos(1 - 2 * load_zone)

    def load_at(angle: float) -> float:
        """Return the load at an angle over the maximum load."""
        share = max(1 - (1 - cos(angle)) / (2 * load_zone), 0.0)
        return float(share**1.5)

    radial, _ = quad(lambda angle: load_at(angle) * cos(angle), 0.0, end)
    axial, _ = quad(load_at, 0.0, end)
    return float(radial) / pi, float(axial) / pi
