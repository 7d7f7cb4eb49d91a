"""Speeds of rings, cage and balls that roll without slip, and the lines that follow from them."""

from dataclasses import dataclass
from math import cos, pi

from rolling.bearing.geometry import BearingGeometry, Ring


@dataclass(frozen=True)
class Kinematics:
    """Turns per second of the bodies of a bearing, and rates at which they meet."""

    turning: Ring
    inner_hz: float
    outer_hz: float
    cage_hz: float
    ball_pass_outer_hz: float  # rate at which balls pass a place of the outer raceway, BPFO
    ball_pass_inner_hz: float  # the same of the inner raceway, BPFI
    ball_spin_hz: float  # of a ball beside its cage
    rolling_speed_m_s: float  # speed of a contact along its raceway

    @property
    def moving(self) -> Ring:
        """Ring that does not turn, and therefore is free to vibrate."""
        return "outer" if self.turning == "inner" else "inner"

    @property
    def turning_hz(self) -> float:
        """Turns per second of the ring that turns."""
        return self.inner_hz + self.outer_hz


def kinematics_of(
    geometry: BearingGeometry,
    turning: Ring,
    turns_hz: float,
    contact_angle: float | None = None,
) -> Kinematics:
    """Return the speeds of a bearing one of whose rings turns, by pure rolling.

    Parameters
    ----------
    geometry : BearingGeometry
    turning : "inner" or "outer"
        Ring that turns. The other one stands still.
    turns_hz : float, Hz
        Its turns per second, positive.
    contact_angle : float, rad, optional
        Angle at which the balls roll. Default: that of the geometry, without load.

    Returns
    -------
    Kinematics

    Notes
    -----
    T. A. Harris, Rolling Bearing Analysis, chapter 8: with g = D cos(alpha) / d_m the cage turns at
    (f_i (1 - g) + f_o (1 + g)) / 2, and a ball spins at d_m / (2 D) (f_i - f_o) (1 - g^2).
    """
    inner = turns_hz if turning == "inner" else 0.0
    outer = turns_hz if turning == "outer" else 0.0
    g = geometry.ratio
    if contact_angle is not None:
        g = geometry.ball_radius_m * cos(contact_angle) / geometry.pitch_radius_m
    cage = (inner * (1 - g) + outer * (1 + g)) / 2
    size_ratio = geometry.pitch_radius_m / geometry.ball_radius_m
    spin = size_ratio / 2 * abs(inner - outer) * (1 - g**2)
    return Kinematics(
        turning=turning,
        inner_hz=inner,
        outer_hz=outer,
        cage_hz=cage,
        ball_pass_outer_hz=geometry.balls * abs(cage - outer),
        ball_pass_inner_hz=geometry.balls * abs(inner - cage),
        ball_spin_hz=spin,
        rolling_speed_m_s=2 * pi * geometry.ball_radius_m * spin,
    )


def lines_of(speeds: Kinematics) -> dict[str, float]:
    """Return the lines of a bearing by their names [Hz], as figures mark them."""
    return {
        "cage": speeds.cage_hz,
        "turn": speeds.turning_hz,
        "ball spin": speeds.ball_spin_hz,
        "2 x ball spin": 2 * speeds.ball_spin_hz,
        "BPFO": speeds.ball_pass_outer_hz,
        "BPFI": speeds.ball_pass_inner_hz,
    }


def centrifugal_force(geometry: BearingGeometry, ball_mass_kg: float, cage_hz: float) -> float:
    """Return the part along the contact line [N] of the centrifugal force on a ball."""
    rate = 2 * pi * cage_hz
    return ball_mass_kg * rate**2 * geometry.pitch_radius_m * cos(geometry.contact_angle)
