"""Validity of the model: materials, half-space, the constant load on a ball, and falls."""

from __future__ import annotations

import math
from collections.abc import Iterator

from acoustics.numbers import rounded
from rolling.check import cost, resolution, vibration
from rolling.check.finding import Finding, judged, sentence, si
from rolling.check.resolution import HEARING
from rolling.dynamics import drop
from rolling.dynamics.smooth_contact import semi_axes
from rolling.scene import library
from rolling.scene.quantities import STEEL_DENSITY
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile

MAX_SLOPE = 0.3  # rms norm of the gradient that a half-space may have
NEAR = 3.0  # sphere radii within which a listener is too near
# These are limits of the length v / f0 of the waves that feed the resonance, divided by the sum of
# contact radius and correlation length: the contact averages shorter waves out, and the surface has
# few of them. By a linear model of the ball on a 10 mm steel plate (Q 20), 2 to 100 N, Ra 0.01 to
# 1 um, correlation lengths 10 to 100 um, 0.03 to 2 m/s, the bouncing adds -25 to -37 dB at 0.2 and
# -5 to -15 dB at 0.7, relative to the release within hearing.
FELT = 0.2
DOMINANT = 0.7
STEEL_GPA, STEEL_POISSON = 210.0, 0.3
MAX_CONTACT = 0.2  # contact radius over sphere radius
LOWEST_MODE = 0.84  # frequency of the lowest mode times diameter over the speed of shear waves


def findings(scene: Scene) -> Iterator[Finding]:
    """Judge whether the model and its materials hold for a scene; a height file is read."""
    yield from _materials(scene)
    yield from _half_space(scene)
    distance, least = scene.sound.distance_m, NEAR * scene.radius
    if distance < least:
        numbers = {"distance": distance, "radii": NEAR, "least": least}
        yield judged("listener", si(distance, "m"), True, **numbers)
    if scene.dynamics is None:
        yield _bouncing(scene)
        return
    yield vibration.resonance(scene)
    yield from vibration.findings(scene)
    yield from _modes(scene)
    if scene.rolling.drop_mm is not None:
        yield from _fall(scene)


def _half_space(scene: Scene) -> Iterator[Finding]:
    """Compare slope and contact radius with the limits of a half-space."""
    slope = cost.roughness(scene)[1]
    along, across = resolution.contact_radius(scene), semi_axes(scene)[1]
    share = max(along / scene.radius, across / scene.radius_across)
    advice = "lower surface.roughness_ra_um or lengthen surface.correlation_length_um"
    if scene.sphere.surface is not None:
        advice += ", of plate or sphere"
    if isinstance(scene.surface, HeightFile):
        advice = "filter the shortest wavelengths out of the heights"
    steep = {"slope": slope, "most": MAX_SLOPE, "advice": advice}
    wide = {"share": share, "most": MAX_CONTACT}
    yield judged("slope", rounded(slope), slope > MAX_SLOPE, **steep)
    yield judged("contact_radius", rounded(share), share > MAX_CONTACT, **wide)
    if scene.faults:
        slope = max(fault.steepest for fault in scene.faults)
        sharp = {"slope": slope, "most": MAX_SLOPE}
        yield judged("fault_slope", rounded(slope), slope > MAX_SLOPE, **sharp)


def _bouncing(scene: Scene) -> Finding:
    """Name the frequency at which the ball bounces, and weigh its part of the sound.

    The maximum speed decides, where the record holds the frequency.
    """
    frequency, speed = cost.bounce_hz(scene), scene.motion.fastest(scene.duration)
    highest = min(HEARING[1], speed / (2 * scene.track.step))
    if not HEARING[0] < frequency < highest:
        return judged("resonance", si(frequency, "Hz"), False)
    density, correlation = scene.sphere.density_kg_m3, 0.0
    steel = f"as if of steel, {STEEL_DENSITY:g} kg/m3 (sphere.density_kg_m3)"
    ball = steel if density is None else f"of {density:g} kg/m3"
    if scene.laws:
        correlation = 1e-6 * min(law.lengths_um[0] for law in scene.laws)
    wave = speed / frequency / (semi_axes(scene)[0] + correlation)
    weight = "quiet" if wave < FELT else "felt" if wave < DOMINANT else "dominant"
    part = sentence("resonance", weight)
    numbers = {"ball": ball, "frequency": frequency, "speed": speed, "part": part}
    return judged("resonance", si(frequency, "Hz"), True, **numbers)


# ---- materials by name


def _materials(scene: Scene) -> Iterator[Finding]:
    """State the materials of plate and sphere; warn where the model does not hold for them."""
    if scene.is_permanent and scene.dynamics is not None:  # which the passes alone decide
        value = f"{scene.passes} passes; the run is refused after them if the last still yields"
        yield Finding("running_in", "running-in before dynamics", value)
    for body in ("plate", "sphere"):
        section = getattr(scene, body)
        if (name := section.material) is not None:
            value, reason = name, library.data("materials")["materials"][name].get("sound_only")
            for key, usual in library.named_values(body, name).items():
                if (own := getattr(section, key)) not in (None, usual):
                    value += f", own {key} {own}"
            yield judged(f"{body}_material", value, bool(reason), material=name, reason=reason)
    material = scene.sphere.material
    hardness = material and library.named_values("plate", material)["hardness_gpa"]
    if isinstance(hardness, float) and 1e9 * hardness < scene.hardness:
        yield judged("sphere_yields", si(1e9 * hardness, "Pa"), True, pressure=1e9 * hardness)


# ---- modes of the sphere within hearing, and its fall


def lowest_mode_hz(scene: Scene) -> float:
    """Return the frequency [Hz] of the lowest mode of the sphere, of steel without a modulus."""
    sphere = scene.sphere
    young, poisson, density = STEEL_GPA, STEEL_POISSON, STEEL_DENSITY
    if sphere.youngs_modulus_gpa is not None and sphere.poissons_ratio is not None:
        young, poisson = sphere.youngs_modulus_gpa, sphere.poissons_ratio
        density = sphere.density_kg_m3 or STEEL_DENSITY
    shear_speed = math.sqrt(1e9 * young / (2 * (1 + poisson) * density))
    return LOWEST_MODE * shear_speed / (2 * scene.radius)


def _modes(scene: Scene) -> Iterator[Finding]:
    """Warn of a mode of the sphere within hearing."""
    frequency = lowest_mode_hz(scene)
    if frequency < HEARING[1]:
        steel = ", as if of steel" * (scene.sphere.youngs_modulus_gpa is None)
        most = scene.sphere.radius_mm * frequency / HEARING[1]
        yield judged("ball_modes", si(frequency, "Hz"), True, steel=steel, most=most)


def _fall(scene: Scene) -> Iterator[Finding]:
    """State the first impact on a rigid plate, and compare it with surface, sphere and hardness."""
    fall, duration = drop.fall_s(scene), scene.duration
    force, contact_time = drop.largest_force_n(scene), drop.impact_s(scene)
    value = f"{si(drop.speed_m_s(scene), 'm/s')} after {si(fall, 's')}, up to"
    value += f" {si(force, 'N')} for {si(contact_time, 's')}"
    yield judged("drop", value, fall >= duration, duration=duration, fall=fall)
    radius = max(semi_axes(scene, force))
    period, thickness, doubt = cost.shortest_period(scene), scene.plate.thickness_mm, ""
    if 2 * radius > period:
        doubt = "surface"
    elif radius > MAX_CONTACT * scene.radius:
        doubt = "sphere"
    elif thickness is not None and 1e3 * radius > vibration.THICK * thickness:
        doubt = "thickness"
    numbers = {"period": period, "width_um": 2e6 * radius, "share": radius / scene.radius}
    numbers |= {"most": MAX_CONTACT, "thick": vibration.THICK}
    numbers |= {"thickness": 1e3 * radius / vibration.THICK}
    yield judged("drop_width", f"radius {si(radius, 'm')}", doubt, **numbers)
    if math.isfinite(scene.hardness):
        height = 1e3 * drop.elastic_height_m(scene)
        yields = 1e3 * drop.height_m(scene) > height
        yield judged("impacts_yield", f"up to {rounded(height)} mm", yields, most=height)
