"""Findings of a sphere that is let go from a height, and of modes of the sphere within hearing."""

from __future__ import annotations

import math

from acoustics.numbers import rounded
from rolling.check import cost, vibration
from rolling.check.finding import Finding, rounded_down, rounded_up, si
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
    largest = rounded_down(scene.sphere.radius_mm * frequency / HEARING[1])
    warning = (
        "within hearing, and the sphere is taken as a body without modes: do not trust the bands"
        f" above, or choose a sphere.radius_mm of at most {largest}"
    )
    name = "lowest mode of the sphere"
    if scene.sphere.youngs_modulus_gpa is None:
        name += ", as if of steel"
    return [Finding("ball_modes", name, si(frequency, "Hz"), warning)]


def _impact(scene: Scene) -> Finding:
    """State speed, time, force and contact of the first impact on a rigid plate."""
    force, fall, warning = drop.largest_force_n(scene), drop.fall_s(scene), None
    if fall >= scene.duration:
        warning = (
            f"the record ends after {si(scene.duration, 's')}, before the sphere hits the plate:"
            f" choose a record of more than {rounded_up(fall)} s"
        )
    value = (
        f"{si(drop.speed_m_s(scene), 'm/s')} after {si(fall, 's')}, up to {si(force, 'N')} for"
        f" {si(drop.impact_s(scene), 's')}"
    )
    return Finding("drop", "first impact, by Hertz", value, warning)


def impact_radius(scene: Scene) -> float:
    """Return the contact radius [m] under the largest force of the first impact."""
    force = drop.largest_force_n(scene)
    return closed_forms.hertz_radius(force, scene.radius, scene.contact_modulus)


def _room(scene: Scene) -> Finding:
    """Compare the contact of the first impact with surface, sphere and thickness."""
    radius, period = impact_radius(scene), cost.shortest_period(scene)
    thickness, warning = scene.plate.thickness_mm, None
    if 2 * radius > period:
        warning = (
            f"the surface has {si(period, 'm')}: harder impacts than that holds are extrapolated"
            f" by Hertz; choose a surface.width_um of at least {rounded_up(2e6 * radius)}, and a"
            " track as long"
        )
    elif radius > MAX_CONTACT * scene.radius:
        warning = (
            f"it is {rounded(radius / scene.radius)} of the sphere's radius, a half-space holds up"
            f" to {MAX_CONTACT:g}: choose a lower rolling.drop_mm"
        )
    elif thickness is not None and 1e3 * radius > vibration.THICK * thickness:
        warning = (
            f"more than {vibration.THICK:g} of the plate's thickness, and the contact is that of a"
            " half-space: choose a plate.thickness_mm of at least"
            f" {rounded_up(1e3 * radius / vibration.THICK)}"
        )
    value = f"radius {si(radius, 'm')}"
    return Finding("drop_width", "contact of the first impact", value, warning)


def _yielding(scene: Scene) -> list[Finding]:
    """Compare the drop with the height from which the impact yields."""
    if not math.isfinite(scene.hardness):
        return []
    height, warning = drop.elastic_height_m(scene), None
    if drop.height_m(scene) > height:
        warning = (
            "the impact would yield, and the force law gives its work back, so that the sphere"
            f" bounces too high: choose a rolling.drop_mm of at most {rounded_down(1e3 * height)},"
            " or plate.hardness_gpa: none"
        )
    value = f"up to {rounded(1e3 * height)} mm"
    return [Finding("impacts_yield", "elastic drop", value, warning)]
