"""Validity of the model: the half-space, and the constant load on a ball that could bounce."""

from __future__ import annotations

from acoustics.numbers import rounded
from rolling.check import cost, free_sphere, long_steps, vibration
from rolling.check.finding import Finding, judged, sentence, si
from rolling.check.free_sphere import MAX_CONTACT
from rolling.check.resolution import HEARING
from rolling.dynamics import of_scene
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


def findings(scene: Scene) -> list[Finding]:
    """Judge whether the model holds for a scene; a height file is read."""
    resonance = _bouncing(scene) if scene.dynamics is None else vibration.resonance(scene)
    moving = [*vibration.findings(scene), *free_sphere.findings(scene)]
    return [*_half_space(scene), *_near(scene), resonance, *moving]


def _near(scene: Scene) -> list[Finding]:
    """Warn of a listener to whom the sphere is no small source."""
    distance = scene.sound.distance_m
    if distance >= NEAR * scene.radius:
        return []
    numbers = {"distance": distance, "radii": NEAR, "least": NEAR * scene.radius}
    return [judged("listener", si(distance, "m"), True, **numbers)]


def _half_space(scene: Scene) -> list[Finding]:
    """Compare slope and contact radius with the limits of a half-space."""
    slope, share = cost.roughness(scene)[1], long_steps.contact_radius(scene) / scene.radius
    advice = "lower surface.roughness_ra_um or lengthen surface.correlation_length_um"
    if scene.sphere.surface is not None:
        advice += ", of plate or sphere"
    if isinstance(scene.surface, HeightFile):
        advice = "filter the shortest wavelengths out of the heights"
    steep = {"slope": slope, "most": MAX_SLOPE, "advice": advice}
    wide = {"share": share, "most": MAX_CONTACT}
    findings = [
        judged("slope", rounded(slope), slope > MAX_SLOPE, **steep),
        judged("contact_radius", rounded(share), share > MAX_CONTACT, **wide),
    ]
    if scene.faults:
        slope = max(fault.steepest for fault in scene.faults)
        sharp = {"slope": slope, "most": MAX_SLOPE}
        findings.append(judged("fault_slope", rounded(slope), slope > MAX_SLOPE, **sharp))
    return findings


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
    wave = speed / frequency / (of_scene.hertz_radius(scene) + correlation)
    part = sentence(
        "resonance", "quiet" if wave < FELT else "felt" if wave < DOMINANT else "dominant"
    )
    numbers = {"ball": ball, "frequency": frequency, "speed": speed, "part": part}
    return judged("resonance", si(frequency, "Hz"), True, **numbers)
