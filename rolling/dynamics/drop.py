"""Sphere that is let go from a height: its first impact by Hertz, its start, and its restitution.

The plate takes some of the energy, so the impact of a rigid plate is the hardest.
"""

import math

import numpy as np

from rolling.contact import closed_forms
from rolling.dynamics.bodies import Chain
from rolling.dynamics.force_law import LOWEST, ForceLaw
from rolling.dynamics.motion import BodyMotion, longest_step_s
from rolling.dynamics.smooth_contact import equivalent_radius
from rolling.scene.scene import Scene

IMPACT_STEPS = 40  # in the time of the first impact: force off by 0.3 %, restitution by 0.001
LONGEST_S = 1 / 96e3  # which resolves hearing
RATIO = 4.0  # ratio of neighbouring loads of the force law of a drop


def height_m(scene: Scene) -> float:
    """Return the height [m] above the surface from which the sphere is let go, 0 for none."""
    return 1e-3 * (scene.rolling.drop_mm or 0.0)


def speed_m_s(scene: Scene) -> float:
    """Return the speed [m/s] at which the sphere hits the plate."""
    return math.sqrt(2 * scene.load * height_m(scene) / scene.mass)


def fall_s(scene: Scene) -> float:
    """Return the time [s] of the fall."""
    return speed_m_s(scene) * scene.mass / scene.load


def impact_s(scene: Scene) -> float:
    """Return the time [s] of the first impact."""
    speed = speed_m_s(scene)
    radius = equivalent_radius(scene)
    return closed_forms.hertz_impact_time(scene.mass, speed, radius, scene.contact_modulus)


def largest_force_n(scene: Scene) -> float:
    """Return the largest force [N] of the first impact."""
    energy = scene.load * height_m(scene)
    radius = equivalent_radius(scene)
    return closed_forms.hertz_force(energy, radius, scene.contact_modulus)


def elastic_height_m(scene: Scene) -> float:
    """Return the height [m] from which the pressure of the impact reaches the hardness."""
    sphere, along, across = closed_forms.hertz_ellipse(scene.radius, scene.radius_across)
    pressure = scene.hardness * along * across  # of the equivalent sphere
    radius = math.pi * sphere * pressure / (2 * scene.contact_modulus)
    force = 2 / 3 * math.pi * pressure * radius**2
    return 0.4 * force * radius**2 / sphere / scene.load


def loads(scene: Scene, sign: int) -> list[float]:
    """Return loads [N] above (1) the scene's, up to the force of the impact, or below it (-1).

    They are the same from all heights, so that falls share their marches.
    """
    reach = 1 / LOWEST
    if sign > 0:
        reach = largest_force_n(scene) / scene.load
    count = math.floor(math.log(max(reach, 1.0), RATIO))
    return [scene.load * RATIO ** (sign * k) for k in range(1, count + 1)]


def start(scene: Scene, law: ForceLaw, chain: Chain) -> tuple[float, float]:
    """Return approach [m] and velocity [m/s] of a sphere let go above its first place.

    A motion is seen from an infinite plate that the load alone would sink, at a constant speed.
    """
    lift_off = float(law.approach(law.position_m[0], 0.0))
    approach = lift_off - height_m(scene)
    if chain.modes is not None:
        return approach, 0.0
    return approach, -(chain.mobility_s_kg * scene.load)


def time_step_s(scene: Scene, law: ForceLaw, chain: Chain, speed: float) -> float:
    """Return the time step [s] for the first impact, the resonance and the track at a speed."""
    return min(impact_s(scene) / IMPACT_STEPS, longest_step_s(law, chain, speed), LONGEST_S)


def restitution(scene: Scene, motion: BodyMotion) -> float | None:
    """Return speed after over speed before the first impact; None without an end of it."""
    apart = motion.force_n == 0
    first = int(np.argmin(apart))
    if first == 0:  # it never hits the plate
        return None
    after = first + int(np.argmax(apart[first:]))
    if after == first:
        return None
    acceleration = scene.load / scene.mass
    velocity = motion.velocity_m_s[after] - motion.velocity_m_s[0]  # it starts at rest
    velocity += acceleration * motion.time_step_s / 2
    height = height_m(scene) - (motion.approach_m[after] - motion.approach_m[0])
    square = velocity**2 + 2 * acceleration * height
    return math.sqrt(max(square, 0.0)) / speed_m_s(scene)
