"""Validity of the model: the half-space, and the constant load on a ball that could bounce."""

from __future__ import annotations

from rolling.check import long_steps, resonance, vibration
from rolling.check.finding import Finding, si
from rolling.check.sampling import HEARING
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile

MAX_SLOPE = 0.3  # rms norm of the gradient that a half-space may have
MAX_CONTACT = 0.2  # contact radius over sphere radius


def findings(scene: Scene, slope: float) -> list[Finding]:
    """Judge whether the model holds for a scene.

    Parameters
    ----------
    slope : float
        Rms slope of the surface.
    """
    return [*_half_space(scene, slope), _resonance(scene), *vibration.findings(scene)]


def _half_space(scene: Scene, slope: float) -> list[Finding]:
    """Compare slope and contact radius with the limits of a half-space."""
    steep = wide = None
    if slope > MAX_SLOPE:
        advice = (
            "filter the shortest wavelengths out of the heights"
            if isinstance(scene.surface, HeightFile)
            else ""
        )
        advice = advice or "lower surface.roughness_ra_um or lengthen surface.correlation_length_um"
        steep = f"the rms slope is {slope:.2g}, a half-space holds up to {MAX_SLOPE:g}: {advice}"
    share = long_steps.contact_radius(scene) / scene.radius
    if share > MAX_CONTACT:
        wide = (
            f"the contact radius is {share:.2g} of the sphere's, a half-space holds up to"
            f" {MAX_CONTACT:g}: lower rolling.load_n or enlarge sphere.radius_mm"
        )
    return [
        Finding("slope", "rms slope", f"{slope:.2g}", steep),
        Finding("contact_radius", "contact radius / radius", f"{share:.2g}", wide),
    ]


def _resonance(scene: Scene) -> Finding:
    """Name the frequency at which the ball bounces, and weigh its part of the sound.

    The maximum speed decides, where the record holds the frequency.
    """
    if scene.dynamics is not None:
        return vibration.resonance_of(scene)
    frequency = resonance.frequency(scene)
    speed = scene.motion.fastest(scene.duration)
    highest = min(HEARING[1], speed / (2 * scene.track.step))
    if not HEARING[0] < frequency < highest:
        return Finding("resonance", "contact resonance", si(frequency, "Hz"))
    density = scene.sphere.density_kg_m3
    ball = (
        "as if of steel, 7850 kg/m3 (sphere.density_kg_m3)"
        if density is None
        else f"of {density:g} kg/m3"
    )
    wave = resonance.relative_wave(scene, speed)
    if wave < resonance.FELT:
        part = "its part is some 30 dB or more below the release, and the levels hold"
    elif wave < resonance.DOMINANT:
        part = "its part is heard: do not trust the bands about that frequency"
    else:
        part = (
            "it is a large part of the sound or most of it: do not trust levels, nor bands from a"
            " half of that frequency up, or choose a lower rolling.speed_m_s"
        )
    warning = (
        f"a free ball {ball} would bounce on its contact at {si(frequency, 'Hz')}, inside hearing"
        f" and the simulated band, and the load is held constant here; at {speed:.3g} m/s waves of"
        f" {si(speed / frequency, 'm')} feed it, {wave:.2g} of contact radius and correlation"
        f" length: {part}; the section dynamics (`dynamics: {{}}`, with both densities) lets the"
        " sphere bounce"
    )
    return Finding("resonance", "contact resonance", si(frequency, "Hz"), warning)
