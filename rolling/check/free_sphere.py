"""Findings of a sphere that is let go from a height, and of modes of the sphere within hearing."""

from __future__ import annotations

import math

from acoustics.numbers import rounded
from rolling.check import cost, vibration
from rolling.check.finding import Finding, judged, si
from rolling.check.resolution import HEARING
from rolling.contact import closed_forms
from rolling.dynamics import drop
from rolling.scene.quantities import STEEL_DENSITY
from rolling.scene.scene import Scene

STEEL_GPA, STEEL_POISSON = 210.0, 0.3
MAX_CONTACT = 0.2  # contact radius over sphere radius
LOWEST_MODE = 0.84  # frequency of the lowest mode times diameter over the speed of shear waves


def findings(scene: Scene) -> list[Finding]:
    """Judge the first impact of a sphere that falls, and the modes of the sphere."""
    if scene.dynamics is None:
        return []
    falls = scene.rolling.drop_mm is not None
    return [*_modes(scene), *([_impact(scene), _room(scene), *_yielding(scene)] if falls else [])]


def lowest_mode_hz(scene: Scene) -> float:
    """Return the frequency [Hz] of the lowest mode of the sphere, of steel without a modulus."""
    sphere = scene.sphere
    young, poisson, density = STEEL_GPA, STEEL_POISSON, STEEL_DENSITY
    if sphere.youngs_modulus_gpa is not None and sphere.poissons_ratio is not None:
        young, poisson = sphere.youngs_modulus_gpa, sphere.poissons_ratio
        density = sphere.density_kg_m3 or STEEL_DENSITY
    shear_speed = math.sqrt(1e9 * young / (2 * (1 + poisson) * density))
    return LOWEST_MODE * shear_speed / (2 * scene.radius)


def _modes(scene: Scene) -> list[Finding]:
    """Warn of a mode of the sphere within hearing."""
    frequency = lowest_mode_hz(scene)
    if frequency >= HEARING[1]:
        return []
    steel = ", as if of steel" * (scene.sphere.youngs_modulus_gpa is None)
    most = scene.sphere.radius_mm * frequency / HEARING[1]
    return [judged("ball_modes", si(frequency, "Hz"), True, steel=steel, most=most)]


def _impact(scene: Scene) -> Finding:
    """State speed, time, force and contact of the first impact on a rigid plate."""
    fall, duration = drop.fall_s(scene), scene.duration
    value = (
        f"{si(drop.speed_m_s(scene), 'm/s')} after {si(fall, 's')}, up to"
        f" {si(drop.largest_force_n(scene), 'N')} for {si(drop.impact_s(scene), 's')}"
    )
    return judged("drop", value, fall >= duration, duration=duration, fall=fall)


def _room(scene: Scene) -> Finding:
    """Compare the contact of the first impact with surface, sphere and thickness."""
    force, period = drop.largest_force_n(scene), cost.shortest_period(scene)
    radius = closed_forms.hertz_radius(force, scene.radius, scene.contact_modulus)
    thickness, doubt = scene.plate.thickness_mm, ""
    if 2 * radius > period:
        doubt = "surface"
    elif radius > MAX_CONTACT * scene.radius:
        doubt = "sphere"
    elif thickness is not None and 1e3 * radius > vibration.THICK * thickness:
        doubt = "thickness"
    return judged(
        "drop_width",
        f"radius {si(radius, 'm')}",
        doubt,
        period=period,
        width_um=2e6 * radius,
        share=radius / scene.radius,
        most=MAX_CONTACT,
        thick=vibration.THICK,
        thickness=1e3 * radius / vibration.THICK,
    )


def _yielding(scene: Scene) -> list[Finding]:
    """Compare the drop with the height from which the impact yields."""
    if not math.isfinite(scene.hardness):
        return []
    height = drop.elastic_height_m(scene)
    value, yields = f"up to {rounded(1e3 * height)} mm", drop.height_m(scene) > height
    return [judged("impacts_yield", value, yields, most=1e3 * height)]
