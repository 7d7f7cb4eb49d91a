"""Validity of the model: materials, half-space, vibration, and falls.

The contact force of a scene with dynamics is estimated from the statistics of the surface: the
contact averages the heights with its pressure, an ellipsoid over the circle in which a smooth
contact is at most an rms height apart, and their mean moves sphere, contact and plate as a linear
chain. A looped record has the lines of its lap, which a sharp resonance may miss. docs/dynamics.md
compares the estimate with runs.
"""

import math
from collections.abc import Iterator

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded, rounded_down, rounded_up, si
from acoustics.rectangular_plate import MODES_HZ
from rolling.check import cost, forecast, resolution
from rolling.check.doubt import Doubt, Finding, Severity
from rolling.dynamics import drop, of_scene
from rolling.dynamics.smooth_contact import semi_axes
from rolling.scene import library
from rolling.scene.laws import HeightLaw
from rolling.scene.quantities import STEEL_DENSITY, STEEL_GPA, STEEL_POISSON, plate_modes
from rolling.scene.scene import Scene
from rolling.scene.sections import WEIGHT
from rolling.scene.surfaces import (
    BallHeightFile,
    Gaussian,
    GaussianBall,
    GradedBall,
    HeightFile,
    MadeSurface,
    SelfAffine,
)
from rolling.surface import made

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
LOWEST_MODE = 0.84  # frequency of the lowest mode times diameter over the speed of shear waves
PEAKS = 4.0  # standard deviations of Gaussian noise that some 10^4 periods exceed once
THICK = 0.1  # contact radius over thickness up to which the contact sees a half-space
FAR = 3.0  # listener's distance over the distance from which the pressure on the axis holds
LOADED_HZ = 100.0  # frequency below which the air may load the plate
HALF_SPACE_HZ_M = 10e3  # frequency times distance from which a half-space's pressure holds
OWN_MARCH = "moving_release"  # key of the finding whose march no run shares
MIN_STEPS = 8  # in a period of the resonance, for the release under the moving load
_NOTHING = 1e-200  # spectral density [m3] of a surface that the contact averages out
_SPEEDS = 61  # number of speeds, as a sharp resonance needs them
_WAVES, _ACROSS, _LINES = 160, 160, 40_000  # points along, across, and over the resonance


def rules(scene: Scene) -> Iterator[Finding | Doubt]:
    """Judge whether the model and its materials hold for a scene; a height file is read."""
    yield from _materials(scene)
    yield from _half_space(scene)
    yield from _listener(scene)
    if scene.dynamics is None:
        yield from _bouncing(scene)
        return
    yield from _vibration(scene)
    yield from _modes(scene)
    if scene.rolling.drop_mm is not None:
        yield from _fall(scene)


def _listener(scene: Scene) -> Iterator[Finding | Doubt]:
    """Warn of a listener so near that the sphere is no small source."""
    distance, least = scene.listener_distance_m, NEAR * scene.radius
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
    along, across = resolution.contact_radius(scene), semi_axes(scene)[1]
    share = max(along / scene.radius, across / scene.radius_across)
    yield Finding("contact_radius", "contact radius / radius", rounded(share))
    if share > MAX_CONTACT:
        yield Doubt(
            "contact_radius",
            f"contact radius / radius: the contact radius is {rounded(share)} of the sphere's, a "
            f"half-space holds up to {MAX_CONTACT:g}",
            Severity.DO_NOT_QUOTE,
            advice="lower rolling.load_n or enlarge sphere.radius_mm",
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
    frequency, speed = cost.bounce_hz(scene), scene.motion.fastest(scene.duration)
    yield Finding("resonance", "contact resonance", si(frequency, "Hz"))
    highest = min(resolution.HEARING[1], speed / (2 * scene.track.step))
    if not resolution.HEARING[0] < frequency < highest:
        return
    density, correlation = scene.sphere.density_kg_m3, 0.0
    ball = f"as if of steel, {STEEL_DENSITY:g} kg/m3 (sphere.density_kg_m3)"
    if density is not None:
        ball = f"of {density:g} kg/m3"
    if scene.laws:
        correlation = 1e-6 * min(law.lengths_um[0] for law in scene.laws)
    wave = speed / frequency / (semi_axes(scene)[0] + correlation)
    if wave < FELT:
        part = "its part is some 30 dB or more below the release"
    elif wave < DOMINANT:
        part = "its part is heard: do not trust the bands about that frequency"
    else:
        part = (
            "it is a large part of the sound or most of it: do not trust levels, nor bands from a "
            "half of that frequency up, or choose a lower rolling.speed_m_s"
        )
    yield Doubt(
        "resonance",
        f"contact resonance: a free ball {ball} would bounce on its contact at "
        f"{si(frequency, 'Hz')}, inside hearing and the simulated band, and the load is held "
        "constant here",
        Severity.TRUST,
        advice=f"at {rounded(speed, 3)} m/s {part}; `dynamics: {{}}`, with both densities, lets "
        "the sphere bounce",
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
    for key, usual in library.named_values(body, material).items():
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


def _modes(scene: Scene) -> Iterator[Finding | Doubt]:
    """Warn of a mode of the sphere within hearing."""
    frequency = lowest_mode_hz(scene)
    if frequency >= resolution.HEARING[1]:
        return
    name = "lowest mode of the sphere"
    if scene.sphere.youngs_modulus_gpa is None:
        name += ", as if of steel"
    most_mm = scene.sphere.radius_mm * frequency / resolution.HEARING[1]
    yield Finding("ball_modes", name, si(frequency, "Hz"))
    yield Doubt(
        "ball_modes",
        f"{name}: within hearing, and the sphere is taken as a body without modes",
        Severity.INDICATIVE,
        advice="do not trust the bands above, or choose a sphere.radius_mm of at most "
        f"{rounded_down(most_mm)}",
    )


def _fall(scene: Scene) -> Iterator[Finding | Doubt]:
    """State the first impact on a rigid plate, and compare it with surface, sphere and hardness."""
    fall, duration = drop.fall_s(scene), scene.duration
    force, contact_time = drop.largest_force_n(scene), drop.impact_s(scene)
    yield Finding(
        "drop",
        "first impact, by Hertz",
        f"{si(drop.speed_m_s(scene), 'm/s')} after {si(fall, 's')}, up to {si(force, 'N')} for "
        f"{si(contact_time, 's')}",
    )
    if fall >= duration:
        yield Doubt(
            "drop",
            f"first impact, by Hertz: the record ends after {si(duration, 's')}, before the "
            "sphere hits the plate",
            Severity.INDICATIVE,
            advice=f"choose a record of more than {rounded_up(fall)} s",
        )
    yield from _impact_width(scene, max(semi_axes(scene, force)))
    if math.isfinite(scene.hardness):
        height_mm = 1e3 * drop.elastic_height_m(scene)
        yield Finding("impacts_yield", "elastic drop", f"up to {rounded(height_mm)} mm")
        if 1e3 * drop.height_m(scene) > height_mm:
            yield Doubt(
                "impacts_yield",
                "elastic drop: the impact would yield, and the force law gives its work back, so "
                "that the sphere bounces too high",
                Severity.DO_NOT_QUOTE,
                advice=f"choose a rolling.drop_mm of at most {rounded_down(height_mm)}, or "
                "plate.hardness_gpa: none",
            )


def _impact_width(scene: Scene, radius: float) -> Iterator[Finding | Doubt]:
    """Compare the contact of the first impact [m] with the surface, the sphere and the plate."""
    key, name = "drop_width", "contact of the first impact"
    yield Finding(key, name, f"radius {si(radius, 'm')}")
    period, thickness = cost.shortest_period(scene), scene.plate.thickness_mm
    if 2 * radius > period:
        width_um = rounded_up(2e6 * radius)
        larger = f"measure a surface of at least {width_um} um each way"
        if isinstance(scene.surface, MadeSurface):
            larger = f"choose a surface.width_um of at least {width_um}, and a track as long"
        yield Doubt(
            key,
            f"{name}: the surface has {si(period, 'm')}",
            Severity.INDICATIVE,
            advice=f"harder impacts than that holds are extrapolated by Hertz; {larger}",
        )
    elif radius > MAX_CONTACT * scene.radius:
        yield Doubt(
            key,
            f"{name}: it is {rounded(radius / scene.radius)} of the sphere's radius, a half-space "
            f"holds up to {MAX_CONTACT:g}",
            Severity.INDICATIVE,
            advice="choose a lower rolling.drop_mm",
        )
    elif thickness is not None and 1e3 * radius > THICK * thickness:
        yield Doubt(
            key,
            f"{name}: more than {THICK:g} of the plate's thickness, and the contact is that of a "
            "half-space",
            Severity.INDICATIVE,
            advice=f"choose a plate.thickness_mm of at least {rounded_up(1e3 * radius / THICK)}",
        )


# ---- scenes with dynamics


def _vibration(scene: Scene) -> Iterator[Finding | Doubt]:
    """Judge the vibration of a scene with dynamics."""
    yield _resonance(scene)
    yield from _force(scene)
    yield from _waves(scene)
    if of_scene.plate(scene) is None:
        yield from _half_space_sound(scene)
    else:
        yield from _bending(scene)
    yield from _edges(scene)
    yield from _marches(scene)


def _half_space_sound(scene: Scene) -> Iterator[Finding | Doubt]:
    """Name the frequency from which the pressure of a half-space holds at the listener."""
    lowest = HALF_SPACE_HZ_M / scene.sound.distance_m
    yield Finding("half_space_sound", "sound of a half-space from", si(lowest, "Hz"))
    if lowest > resolution.HEARING[0]:
        yield Doubt(
            "half_space_sound",
            "sound of a half-space from: below, the pressure is too high, by 14 dB at 100 Hz and "
            "1 m",
            Severity.INDICATIVE,
            advice="give plate.thickness_mm, or a larger sound.distance_m",
        )


def _resonance(scene: Scene) -> Finding:
    """State resonance and damping of the sphere on contact and plate."""
    chain = of_scene.smooth_chain(scene)
    quality = "undamped" if math.isinf(chain.quality) else f"Q {rounded(chain.quality)}"
    return Finding("resonance", "contact resonance", f"{si(chain.resonance_hz, 'Hz')}, {quality}")


# ---- contact force


def _force(scene: Scene) -> Iterator[Finding | Doubt]:
    """Estimate the fluctuation of the contact force over the load, and its extremes."""
    key, name = "force_ratio", "contact force over load"
    rms = force_rms(scene)
    if rms is None or scene.dynamics is None:
        reason = "for a height file" if scene.height_paths else "for faults and waviness alone"
        yield Finding(key, name, f"not estimated {reason}")
        return
    ratio = rms / scene.load
    low, high = 1 - PEAKS * ratio, 1 + PEAKS * ratio
    extremes = f"{rounded(max(low, 0), 3)} to {rounded(high, 3)}"
    value = f"about {extremes}, rms {rounded(ratio)} (from the statistics)"
    if scene.faults:
        value += "; faults are left out"
    wave = scene.motion.fastest(scene.duration) / cost.bounce_hz(scene)
    if wave < 2 * semi_axes(scene)[0]:
        value += "; short waves may multiply it"
    yield Finding(key, name, value)
    if low < 0:
        advice = (
            "impacts need a small step, and more loads are marched; choose a lower "
            "rolling.speed_m_s"
        )
        if scene.rolling.load_n != WEIGHT:
            advice += " or a higher rolling.load_n"
        yield Doubt(
            key,
            f"{name}: it fluctuates by about {rounded(ratio)} of the load, and the sphere loses "
            "contact",
            Severity.INDICATIVE,
            advice=advice,
        )


def force_rms(scene: Scene) -> float | None:
    """Estimate the rms fluctuation of the contact force [N] at the maximum speed.

    Return None for a height file, whose statistics the scene does not know.
    """
    if not scene.laws:
        return 0.0 if scene.is_smooth else None
    chain, speed = of_scene.smooth_chain(scene), scene.motion.fastest(scene.duration)
    longest, shortest = scene.track.n_along * scene.spacing, 2 * scene.step
    coarse = np.geomspace(2 * math.pi / longest, 2 * math.pi / shortest, _WAVES)
    density = np.sum([mean_heights(scene, law, coarse) for law in scene.laws], axis=0)
    if longest <= shortest or not density.max() > _NOTHING:
        return 0.0
    kept = np.log(np.maximum(density, _NOTHING))

    def power(waves: Array, ratio: float = 1.0) -> Array:
        """Return the spectral density of the force [N2 m] at another ratio of speeds."""
        gain = chain.force(waves * (ratio * speed / (2 * math.pi)), np.ones(len(waves)))
        spectrum = np.exp(np.interp(np.log(waves), np.log(coarse), kept))
        return np.asarray(2 * spectrum * np.square(np.abs(gain)))

    if scene.track.closed and scene.track.n_along <= 2 * _LINES:
        lines = coarse[0] * np.arange(1, math.floor(coarse[-1] / coarse[0]) + 1)
        ratios = np.linspace(1 - of_scene.NEAR_SPEEDS, 1 + of_scene.NEAR_SPEEDS, _SPEEDS)
        typical = np.median([power(lines, ratio).sum() for ratio in ratios])
        return float(np.sqrt(coarse[0] * typical))
    fine = np.geomspace(coarse[0], coarse[-1], _LINES)
    return float(np.sqrt(np.trapezoid(power(fine), fine)))


def contact_axes(scene: Scene) -> tuple[float, float]:
    """Return the semi-axes [m] of the contact of a rough surface, along and across.

    The highest asperities carry where smooth surfaces would be an rms height apart.
    """
    whole = cost.roughness(scene)[0]
    length, width = semi_axes(scene)
    return math.sqrt(length**2 + scene.radius * whole), math.sqrt(
        width**2 + scene.radius_across * whole
    )


def mean_heights(scene: Scene, law: HeightLaw, along: Array) -> Array:
    """Return the two-sided spectral density [m3] of the heights that the contact averages."""
    widest = math.pi / scene.spacing
    across = np.concatenate(([0.0], np.geomspace(1e-4 * widest, widest, _ACROSS)))
    length, width = contact_axes(scene)
    q = np.hypot(length * along[:, None], width * across)
    pressure = 3 * (np.sin(q) - q * np.cos(q)) / q**3
    sides = [made.plane_density(law, along[:, None], side) for side in (across, -across)]
    density: Array = np.trapezoid((sides[0] + sides[1]) * pressure**2, across, axis=1)
    return density


def _waves(scene: Scene) -> Iterator[Finding | Doubt]:
    """Compare the waves that feed the resonance with the correlation length.

    Shorter waves belong to the grid more than to the surface.
    """
    speed, frequency = scene.motion.fastest(scene.duration), cost.bounce_hz(scene)
    wave, name = speed / frequency, "waves that feed the resonance"
    length = 1e-6 * min((law.lengths_um[0] for law in scene.laws), default=0.0)
    yield Finding("resonance_wave", name, si(wave, "m"))
    if wave < length:
        yield Doubt(
            "resonance_wave",
            f"{name}: at {rounded(speed, 3)} m/s they are shorter than the correlation length of "
            f"{si(length, 'm')}, and the grid decides how much of them there is",
            Severity.INDICATIVE,
            advice=f"compare {resolution.finer(scene)}, or choose a rolling.speed_m_s of at least "
            f"{rounded_up(length * frequency)}",
        )


# ---- plate


def _bending(scene: Scene) -> Iterator[Finding | Doubt]:
    """Judge thickness, bending theory and distance of the listener of a plate that bends."""
    plate, distance = of_scene.plate(scene), scene.sound.distance_m
    assert plate is not None  # asked for by the caller
    radius, thickness = max(semi_axes(scene)), of_scene.thickness_m(scene)
    yield Finding("air_load", "air loads the plate below", si(plate.lowest_hz, "Hz"))
    if plate.lowest_hz > LOADED_HZ:
        least_mm = 1e3 * thickness * plate.lowest_hz / LOADED_HZ
        yield Doubt(
            "air_load",
            "air loads the plate below: the load of the air is left out, and levels there are too "
            "high",
            Severity.TRUST,
            advice="choose a denser plate or a plate.thickness_mm of at least "
            f"{rounded_up(least_mm)}",
        )
    share, name = radius / thickness, "contact radius / thickness"
    yield Finding("contact_thickness", name, rounded(share))
    if share > THICK:
        yield Doubt(
            "contact_thickness",
            f"{name}: the contact is that of a half-space, which holds up to {THICK:g}",
            Severity.DO_NOT_QUOTE,
            advice=f"choose a plate.thickness_mm of at least {rounded_up(1e3 * radius / THICK)}",
        )
    limit, name = of_scene.bending_limit_hz(scene), "thin-plate theory up to"
    yield Finding("bending", name, si(limit, "Hz"))
    if limit < resolution.HEARING[1]:
        most_mm = 1e3 * thickness * limit / resolution.HEARING[1]
        yield Doubt(
            "bending",
            f"{name}: bending waves above are shorter than {of_scene.MIN_THICKNESSES:g} "
            "thicknesses",
            Severity.INDICATIVE,
            advice="do not trust the bands above, or choose a plate.thickness_mm of at most "
            f"{rounded_down(most_mm)}",
        )
    near, name = FAR * plate.nearest_m, "coincidence of the plate"
    yield Finding("coincidence", name, si(plate.critical_hz, "Hz"))
    if distance < near and scene.plate.edges_mm is None:
        yield Doubt(
            "coincidence",
            f"{name}: the pressure on the axis holds from about {rounded(near)} m for this plate",
            Severity.INDICATIVE,
            advice=f"choose a sound.distance_m of at least {rounded_up(near)}",
        )


def _edges(scene: Scene) -> Iterator[Finding | Doubt]:
    """State modes, contact point and limits of a plate with edges."""
    plate = of_scene.rectangular_plate(scene)
    if plate is None:
        return
    modes, count = "none up to 30 kHz", len(plate.angular_frequency)
    if count:
        lowest = float(plate.angular_frequency[0]) / (2 * math.pi)
        overlap = MODES_HZ / (plate.loss_factor * plate_modes(scene.plate))
        modes = f"{len(plate.orders)} up to 30 kHz from {si(lowest, 'Hz')}"
        if overlap < MODES_HZ:
            modes += f", separate below {si(overlap, 'Hz')}"
    yield Finding("plate_modes", "modes of the plate", modes)
    if not count:
        yield Doubt(
            "plate_modes",
            "modes of the plate: bending waves in hearing are longer than the plate, which moves "
            "as a stiff block",
            Severity.INDICATIVE,
            advice="choose a larger plate.length_mm and plate.width_mm, or no plate.thickness_mm",
        )
    modal = of_scene.smooth_chain(scene).modes
    assert modal is not None  # as there is a plate with edges
    sag, name = scene.load * modal.compliance_m_n, "plate sinks under the load by"
    yield Finding("plate_sag", name, si(sag, "m"))
    if sag > of_scene.BENT * 1e-3 * (scene.plate.thickness_mm or 0.0):
        yield Doubt(
            "plate_sag",
            f"{name}: thin-plate theory wants at most {of_scene.BENT:g} of the thickness",
            Severity.INDICATIVE,
            advice="choose a lower rolling.load_n, or a thicker or smaller plate",
        )
    points = scene.plate.contact_ends_mm.values()
    ends = [f"[{rounded(x, 4)}, {rounded(y, 4)}] mm" for x, y in points]
    contact = f"fixed at {ends[0]}: seen from the plate the sphere rolls on the spot"
    if len(ends) > 1:
        contact = f"to-and-fro from {ends[0]} to {ends[1]}; its record does not loop"
    yield Finding("plate_contact", "contact on the plate", contact)


# ---- cost


def _marches(scene: Scene) -> Iterator[Finding | Doubt]:
    """State the cost of the marches at other loads and of the release under the moving load."""
    assert scene.dynamics is not None  # asked for by the caller
    (count, total), seconds = forecast.law_seconds(scene), cost.lap_seconds(scene)
    value = f"{count} more marches, {cost.computing(total)}, and more where the force leaves them"
    yield Finding("force_law", "force law", value, total)
    if not scene.moves_release:
        return
    speed, frequency = scene.motion.slowest(scene.duration), cost.bounce_hz(scene)
    steps, name = speed / (frequency * scene.step), "release under the moving load"
    value = f"one more march, {cost.computing(seconds)}, {rounded(steps)} steps in a period"
    if scene.dynamics.release is None:
        value += "; dynamics.release: false leaves it out"
    yield Finding(OWN_MARCH, name, value, seconds)
    if steps < MIN_STEPS:
        least = rounded_up(MIN_STEPS * frequency * scene.step)
        yield Doubt(
            OWN_MARCH,
            f"{name}: {rounded(steps)} steps in a period of the resonance, {MIN_STEPS} are wanted",
            Severity.TRUST,
            advice=f"choose a smaller step or a rolling.speed_m_s of at least {least}",
        )
