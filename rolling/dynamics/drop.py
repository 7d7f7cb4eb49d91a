"""Ball that is let go from a height: its first impact by Hertz, its start, and its restitution.

The plate takes some of the energy, so the impact of a rigid plate is the hardest.
"""

import math

import numpy as np

from rolling.contact import closed_forms
from rolling.contact.smooth_contact import SmoothContact
from rolling.dynamics.ball_on_plate import BallOnPlate
from rolling.dynamics.bodies import Chain
from rolling.dynamics.force_law import LOWEST, ForceLaw
from rolling.dynamics.motion import BodyMotion, longest_step_s

IMPACT_STEPS = 40  # in the time of the first impact: force off by 0.3 %, restitution by 0.001
LONGEST_S = 1 / 96e3  # which resolves hearing
RATIO = 4.0  # ratio of neighbouring loads of the force law of a drop


def speed_m_s(bodies: BallOnPlate) -> float:
    """Return the speed [m/s] at which the ball hits the plate."""
    return math.sqrt(2 * bodies.load_n * bodies.drop_height_m / bodies.mass_kg)


def fall_s(bodies: BallOnPlate) -> float:
    """Return the time [s] of the fall."""
    return speed_m_s(bodies) * bodies.mass_kg / bodies.load_n


def impact_s(bodies: BallOnPlate) -> float:
    """Return the time [s] of the first impact."""
    speed = speed_m_s(bodies)
    contact = bodies.contact
    radius = contact.equivalent_radius_m
    return closed_forms.hertz_impact_time(bodies.mass_kg, speed, radius, contact.modulus_pa)


def largest_force_n(bodies: BallOnPlate) -> float:
    """Return the largest force [N] of the first impact."""
    energy = bodies.load_n * bodies.drop_height_m
    contact = bodies.contact
    return closed_forms.hertz_force(energy, contact.equivalent_radius_m, contact.modulus_pa)


def elastic_height_m(contact: SmoothContact, hardness_pa: float) -> float:
    """Return the height [m] from which the pressure of the impact reaches a hardness [Pa]."""
    sphere, along, across = closed_forms.hertz_ellipse(contact.radius_m, contact.radius_across_m)
    pressure = hardness_pa * along * across  # of the equivalent sphere
    radius = math.pi * sphere * pressure / (2 * contact.modulus_pa)
    force = 2 / 3 * math.pi * pressure * radius**2
    return 0.4 * force * radius**2 / sphere / contact.load_n


def loads(bodies: BallOnPlate, sign: int) -> list[float]:
    """Return loads [N] above (1) the bodies', up to the force of the impact, or below it (-1).

    They are the same from all heights, so that falls share their marches.
    """
    reach = 1 / LOWEST
    if sign > 0:
        reach = largest_force_n(bodies) / bodies.load_n
    count = math.floor(math.log(max(reach, 1.0), RATIO))
    return [bodies.load_n * RATIO ** (sign * k) for k in range(1, count + 1)]


def start(bodies: BallOnPlate, law: ForceLaw, chain: Chain) -> tuple[float, float]:
    """Return approach [m] and velocity [m/s] of a ball let go above its first place.

    A motion is seen from an infinite plate that the load alone would sink, at a constant speed.
    """
    lift_off = float(law.approach(law.position_m[0], 0.0))
    approach = lift_off - bodies.drop_height_m
    if chain.modes is not None:
        return approach, 0.0
    return approach, -(chain.mobility_s_kg * bodies.load_n)


def time_step_s(bodies: BallOnPlate, law: ForceLaw, chain: Chain, speed: float) -> float:
    """Return the time step [s] for the first impact, the resonance and the track at a speed."""
    return min(impact_s(bodies) / IMPACT_STEPS, longest_step_s(law, chain, speed), LONGEST_S)


def restitution(bodies: BallOnPlate, motion: BodyMotion) -> float | None:
    """Return speed after over speed before the first impact; None without an end of it."""
    is_free = motion.force_n == 0
    first = int(np.argmin(is_free))
    if first == 0:  # it never hits the plate
        return None
    after = first + int(np.argmax(is_free[first:]))
    if after == first:
        return None
    acceleration = bodies.load_n / bodies.mass_kg
    velocity = motion.velocity_m_s[after] - motion.velocity_m_s[0]  # it starts at rest
    velocity += acceleration * motion.time_step_s / 2
    height = bodies.drop_height_m - (motion.approach_m[after] - motion.approach_m[0])
    square = velocity**2 + 2 * acceleration * height
    return math.sqrt(max(square, 0.0)) / speed_m_s(bodies)
