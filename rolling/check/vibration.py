"""Findings of a scene with dynamics: resonance, contact force, plate, and the cost of its marches.

Each limit of the model has a number here, and a warning where the number exceeds it.
"""

from __future__ import annotations

import math

from rolling.check import cost, force_estimate, resonance
from rolling.check.finding import Finding, clock, on_cores, rounded_down, rounded_up, si
from rolling.check.sampling import HEARING
from rolling.contact import closed_forms
from rolling.dynamics import of_scene
from rolling.dynamics.force_law import LOWEST
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian

THICK = 0.1  # contact radius over thickness up to which the contact sees a half-space
FAR = 3.0  # listener's distance over the distance from which the pressure on the axis holds
LOADED_HZ = 100.0  # frequency below which the air may load the plate
HALF_SPACE_HZ_M = 10e3  # frequency times distance from which a half-space's pressure holds
OWN_MARCH = "moving_release"  # key of the finding whose march no run shares
LEAST_STEPS = 8  # in a period of the resonance, for the release under the moving load
SPEED_OF_SOUND = 343.2  # [m/s] in air


def findings(scene: Scene) -> list[Finding]:
    """Judge the vibration of a scene; nothing without dynamics."""
    if scene.dynamics is None:
        return []
    return [_force(scene), _fed(scene), *_plate(scene), _marches(scene), *_release(scene)]


def resonance_of(scene: Scene) -> Finding:
    """State resonance and damping of the sphere on contact and plate."""
    chain = of_scene.smooth_chain(scene)
    quality = "undamped" if math.isinf(chain.quality) else f"Q {chain.quality:.2g}"
    value = f"{si(chain.resonance_hz, 'Hz')}, {quality}"
    return Finding("resonance", "contact resonance", value)


def _force(scene: Scene) -> Finding:
    """Estimate the fluctuation of the contact force over the load, and its extremes."""
    rms = force_estimate.force_rms(scene)
    if rms is None:
        return Finding("force_ratio", "contact force over load", "not estimated for a height file")
    ratio = rms / scene.load
    low, high = 1 - force_estimate.PEAKS * ratio, 1 + force_estimate.PEAKS * ratio
    value = f"about {max(low, 0):.3g} to {high:.3g}, rms {ratio:.2g} (from the statistics)"
    warning = None
    if low < 0:
        warning = (
            f"the contact force fluctuates by about {ratio:.2g} of the load, and the sphere loses"
            " contact: impacts need a small step, and the forces leave the marched loads; choose"
            " a lower rolling.speed_m_s or a higher rolling.load_n"
        )
    elif low < (least := _least_marched(scene)):  # a force above the highest has lost contact, too
        warning = (
            f"the contact force falls to about {low:.2g} of the load, and loads are marched down to"
            f" {least:.2g} of it: the force below may be extrapolated; choose a lower"
            " rolling.speed_m_s or a higher rolling.load_n"
        )
    return Finding("force_ratio", "contact force over load", value, warning)


def _least_marched(scene: Scene) -> float:
    """Return the minimum load that a force law may have, over the load of the scene."""
    assert scene.dynamics is not None
    return min(LOWEST, scene.dynamics.span ** -(scene.dynamics.loads // 2))


def _fed(scene: Scene) -> Finding:
    """Compare the waves that feed the resonance with the correlation length.

    Shorter waves belong to the grid more than to the surface.
    """
    speed = scene.motion.fastest(scene.duration)
    wave = speed / resonance.frequency(scene)
    value, warning = si(wave, "m"), None
    if isinstance(scene.surface, Gaussian):
        shortest = scene.surface.correlation_length_um * 1e-6
        if wave < shortest:
            warning = (
                f"at {speed:.3g} m/s waves of {si(wave, 'm')} feed the resonance, shorter than the"
                f" correlation length of {si(shortest, 'm')}: the grid decides how much of them"
                " there is; choose a smaller surface.spacing_um and compare, or a"
                f" rolling.speed_m_s of at least"
                f" {rounded_up(shortest * resonance.frequency(scene))}"
            )
    return Finding("resonance_wave", "waves that feed the resonance", value, warning)


def _plate(scene: Scene) -> list[Finding]:
    """Judge thickness, bending theory and distance of the listener."""
    plate, distance = of_scene.plate(scene), scene.sound.distance_m
    if plate is None:
        lowest = HALF_SPACE_HZ_M / distance
        warning = None
        if lowest > HEARING[0]:
            warning = (
                f"the pressure of a half-space holds from {si(lowest, 'Hz')} at {distance:g} m and"
                " is too high below, by 14 dB at 100 Hz and 1 m: give plate.thickness_mm, or a"
                " larger sound.distance_m"
            )
        return [
            Finding("half_space_sound", "sound of a half-space from", si(lowest, "Hz"), warning)
        ]
    radius = closed_forms.hertz_radius(scene.load, scene.radius, scene.contact_modulus)
    share, limit = radius / plate.thickness_m, of_scene.bending_limit_hz(plate)
    stiff = 8 * plate.bending_stiffness_n_m / plate.mass_per_area_kg_m2
    near = FAR * math.sqrt(stiff) / SPEED_OF_SOUND
    air = plate.radiator().lowest_hz
    thin = short = close = light = None
    if share > THICK:
        thin = (
            f"the contact radius is {share:.2g} of the thickness, and the contact is that of a"
            f" half-space, which holds up to {THICK:g}: choose a plate.thickness_mm of at least"
            f" {rounded_up(1e3 * radius / THICK)}"
        )
    if limit < HEARING[1]:
        short = (
            f"bending waves above {si(limit, 'Hz')} are shorter than"
            f" {of_scene.LEAST_THICKNESSES:g} thicknesses, and thin-plate theory ends there:"
            " do not trust the bands above, or choose a plate.thickness_mm of at most"
            f" {rounded_down(1e3 * plate.thickness_m * limit / HEARING[1])}"
        )
    if distance < near:
        close = (
            f"the pressure on the axis holds from about {near:.2g} m for this plate: choose a"
            f" sound.distance_m of at least {rounded_up(near)}"
        )
    if air > LOADED_HZ:
        least = 1e3 * plate.thickness_m * air / LOADED_HZ
        light = (
            f"the air loads a plate as light as this below some {si(air, 'Hz')}, which is left out:"
            " levels there are too high; choose a plate.thickness_mm of at least"
            f" {rounded_up(least)}, or a denser plate"
        )
    return [
        Finding("air_load", "air loads the plate below", si(air, "Hz"), light),
        Finding("contact_thickness", "contact radius / thickness", f"{share:.2g}", thin),
        Finding("bending", "thin-plate theory up to", si(limit, "Hz"), short),
        Finding("coincidence", "coincidence of the plate", si(plate.critical_hz, "Hz"), close),
    ]


def _marches(scene: Scene) -> Finding:
    """State the cost of the marches at other loads."""
    assert scene.dynamics is not None
    others = scene.dynamics.loads - 1
    seconds = others * cost.expected_seconds(scene) / cost.cores()
    return Finding(
        "force_law",
        "force law",
        f"{others} more marches, about {clock(seconds)} on {on_cores()}, and more where the force"
        " leaves them",
        seconds=seconds,
    )


def _release(scene: Scene) -> list[Finding]:
    """Judge the steps of a release under the moving load, and state its cost."""
    if not scene.moves_release:
        return []
    speed, frequency = scene.motion.slowest(scene.duration), resonance.frequency(scene)
    steps, warning = speed / (frequency * scene.step), None
    if steps < LEAST_STEPS:
        warning = (
            f"the track has {steps:.2g} steps in a period of the resonance, a release under the"
            f" moving load needs {LEAST_STEPS}: choose a rolling.speed_m_s of at least"
            f" {rounded_up(LEAST_STEPS * frequency * scene.step)} or a smaller step"
        )
    seconds = cost.expected_seconds(scene) / cost.cores()
    value = f"one more march, about {clock(seconds)} on {on_cores()}, {steps:.2g} steps in a period"
    if scene.dynamics is not None and scene.dynamics.release is None:
        value += "; dynamics.release: false leaves it out"
    return [Finding(OWN_MARCH, "release under the moving load", value, warning, seconds)]
