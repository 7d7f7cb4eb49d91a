"""Validity of the model for any scene: materials, half-space, listener, bouncing."""

import math
from collections.abc import Iterator

from acoustics.numbers import rounded, rounded_up, si
from rolling.check import cost, long_steps, resolution
from rolling.check.finding import Finding
from rolling.in_si.physics_of_scene import bodies_of, smooth_contact_of
from rolling.numbers.doubt import Doubt, Severity
from rolling.scene import library
from rolling.scene.messages import plain_number
from rolling.scene.scene import Scene
from rolling.scene.surfaces import (
    BallHeightFile,
    Gaussian,
    GaussianBall,
    GradedBall,
    HeightFile,
    SelfAffine,
)

MAX_SLOPE = 0.3  # rms norm of the gradient that a half-space may have
NEAR = 3.0  # sphere radii within which a listener is too near
# These are limits of the length v / f0 of the waves that feed the resonance, divided by the sum of
# contact radius and correlation length: the contact averages shorter waves out, and the surface has
# few of them. By a linear model of the ball on a 10 mm steel plate (Q 20), 2 to 100 N, Ra 0.01 to
# 1 um, correlation lengths 10 to 100 um, 0.03 to 2 m/s, the bouncing adds -25 to -37 dB at 0.2 and
# -5 to -15 dB at 0.7, relative to the release within hearing.
FELT = 0.2
DOMINANT = 0.7
MAX_CONTACT = 0.2  # contact radius over sphere radius


def rules(scene: Scene) -> Iterator[Finding | Doubt]:
    """Judge whether the model and its materials hold for a scene; a height file is read."""
    yield from _materials(scene)
    yield from _half_space(scene)
    yield from _listener(scene)
    if scene.dynamics is None:
        yield from _bouncing(scene)


def _listener(scene: Scene) -> Iterator[Finding | Doubt]:
    """Warn of a listener so near that the sphere is no small source."""
    distance = scene.listener_distance_m
    least = NEAR * scene.radius
    if distance >= least:
        return
    yield Finding("listener", "listener", si(distance, "m"))
    if scene.is_listener_placed:
        text = (
            f"listener: the listener is {si(distance, 'm')} from the contact, within {NEAR:g} "
            "radii of the sphere, where the levels of a small source do not hold"
        )
        advice = f"place sound.listener_mm at least {math.ceil(1e3 * least)} mm from the contact"
    else:
        text = (
            f"listener: the listener is {rounded(distance, 3)} m away, within {NEAR:g} radii of "
            "the sphere, where the levels of a small source do not hold"
        )
        advice = f"choose a sound.distance_m of at least {rounded_up(least)}"
    yield Doubt("listener", text, Severity.TRUST, advice=advice)


def _half_space(scene: Scene) -> Iterator[Finding | Doubt]:
    """Compare slope and contact radius with the limits of a half-space."""
    slope = cost.roughness(scene)[1]
    yield Finding("slope", "rms slope", rounded(slope))
    if slope > MAX_SLOPE:
        yield Doubt(
            "slope",
            f"rms slope: the rms slope is {rounded(slope)}, a half-space holds up to {MAX_SLOPE:g}",
            Severity.DO_NOT_QUOTE,
            advice=_gentler(scene),
        )
    along = resolution.contact_radius(scene)
    across = smooth_contact_of(scene).semi_axes_m()[1]
    share = max(along / scene.radius, across / scene.radius_across)
    yield Finding("contact_radius", "contact radius / radius", rounded(share))
    if share > MAX_CONTACT:
        advice = "lower rolling.load_n or enlarge sphere.radius_mm"
        unit = long_steps.unit_of_radius(scene.sphere.radius_mm)
        if unit:
            got = f"sphere.radius_mm is {plain_number(scene.sphere.radius_mm)}"
            advice = f"{got}; {unit}"
        yield Doubt(
            "contact_radius",
            f"contact radius / radius: the contact radius is {rounded(share)} of the sphere's, a "
            f"half-space holds up to {MAX_CONTACT:g}",
            Severity.DO_NOT_QUOTE,
            advice=advice,
        )
    if not scene.faults:
        return
    steepest = max(fault.steepest for fault in scene.faults)
    yield Finding("fault_slope", "steepest fault", rounded(steepest))
    if steepest > MAX_SLOPE:
        yield Doubt(
            "fault_slope",
            f"steepest fault: the steepest fault has a slope of {rounded(steepest)}, a half-space "
            f"holds up to {MAX_SLOPE:g}",
            Severity.TRUST,
            advice="lower its depth_um or enlarge its size_um",
        )


def _gentler(scene: Scene) -> str:
    """Name the keys of the surfaces of plate and sphere that make the heights less steep."""
    advice = []
    for section, part in (("surface", scene.surface), ("sphere.surface", scene.sphere.surface)):
        if isinstance(part, Gaussian | GaussianBall):
            advice.append(
                f"lower {section}.roughness_ra_um or lengthen {section}.correlation_length_um"
            )
        elif isinstance(part, SelfAffine):
            advice.append(f"lengthen {section}.shortest_um or lower the roughness of {section}")
        elif isinstance(part, GradedBall):
            advice.append(f"choose a finer {section}.grade, or a longer correlation length of it")
        elif isinstance(part, HeightFile):
            advice.append(
                "filter the shortest wavelengths out of the heights by surface.s_filter_um"
            )
        elif isinstance(part, BallHeightFile):
            advice.append("filter the shortest wavelengths out of the heights of the sphere")
    return "; ".join(advice) or "make the faults gentler"


def _bouncing(scene: Scene) -> Iterator[Finding | Doubt]:
    """Name the frequency at which the ball bounces, and weigh its part of the sound.

    The maximum speed decides, where the record holds the frequency.
    """
    frequency = bodies_of(scene).bounce_hz
    speed = scene.motion.fastest(scene.duration)
    yield Finding("resonance", "contact resonance", si(frequency, "Hz"))
    highest = min(resolution.HEARING[1], speed / (2 * scene.track.step))
    if not resolution.HEARING[0] < frequency < highest:
        return
    density = scene.sphere.density_kg_m3
    correlation = 0.0
    ball = "of steel" if density is None else f"of {density:g} kg/m3"
    if scene.laws:
        correlation = 1e-6 * min(law.lengths_um[0] for law in scene.laws)
    wave = speed / frequency / (smooth_contact_of(scene).semi_axes_m()[0] + correlation)
    if wave < FELT:
        part = "this part of the sound is some 30 dB or more below the release"
    elif wave < DOMINANT:
        part = "this part of the sound is heard: do not trust the bands about that frequency"
    else:
        part = (
            "this is a large part of the sound or most of it: do not trust levels, nor bands from "
            "half of that frequency up, or choose a lower rolling.speed_m_s"
        )
    yield Doubt(
        "resonance",
        f"contact resonance: the load is held constant, but a free ball {ball} would ring on its "
        f"contact at {si(frequency, 'Hz')}, inside hearing",
        Severity.TRUST,
        advice=f"{part}; `dynamics: {{}}`, with both densities, lets the ball move",
    )


# ---- materials by name


def _materials(scene: Scene) -> Iterator[Finding | Doubt]:
    """State the materials of plate and sphere; warn where the model does not hold for them."""
    if scene.is_permanent and scene.dynamics is not None:  # which the passes alone decide
        value = f"{scene.passes} passes; the run is refused after them if the last still yields"
        yield Finding("running_in", "running-in before dynamics", value)
    for body in ("plate", "sphere"):
        if getattr(scene, body).material is not None:
            yield from _material(scene, body)
    material = scene.sphere.material
    hardness = material and library.named_values("plate", material)["hardness_gpa"]
    if isinstance(hardness, float) and 1e9 * hardness < scene.hardness:
        pressure = si(1e9 * hardness, "Pa")
        yield Finding("sphere_yields", "hardness of the sphere", pressure)
        yield Doubt(
            "sphere_yields",
            f"hardness of the sphere: the sphere would yield at {pressure}, before the plate, but "
            "the program keeps it elastic",
            Severity.INDICATIVE,
            advice="lower plate.hardness_gpa, or take a harder sphere",
        )


def _material(scene: Scene, body: str) -> Iterator[Finding | Doubt]:
    """State the material of a body and its own values; warn where the model does not hold."""
    section = getattr(scene, body)
    material = value = section.material
    damping = scene.plate.damping or library.HANDLED
    for key, usual in library.named_values(body, material, damping).items():
        own = getattr(section, key)
        if own not in (None, usual):
            value += f", own {key} {own}"
    yield Finding(f"{body}_material", f"material of the {body}", value)
    reason = library.data("materials")["materials"][material].get("sound_only")
    if reason:
        yield Doubt(
            f"{body}_material",
            f"material of the {body}: levels with {material} do not hold, because {reason}; the "
            "program computes isotropic bodies without grains, cracks or viscosity",
            Severity.DO_NOT_QUOTE,
        )
