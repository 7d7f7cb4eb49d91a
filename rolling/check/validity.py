"""Validity of the model: materials, half-space, vibration, and falls.

The contact force of a scene with dynamics is estimated from the statistics of the surface: the
contact averages the heights with its pressure, an ellipsoid over the circle in which a smooth
contact is at most an rms height apart, and their mean moves sphere, contact and plate as a linear
chain. A looped record has the lines of its lap, which a sharp resonance may miss. docs/dynamics.md
compares the estimate with runs.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded, si
from acoustics.rectangular_plate import MODES_HZ
from rolling.check import cost, forecast, resolution
from rolling.check.finding import Finding, computing, judged, sentence, written
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


def findings(scene: Scene) -> Iterator[Finding]:
    """Judge whether the model and its materials hold for a scene; a height file is read."""
    yield from _materials(scene)
    yield from _half_space(scene)
    distance, least = scene.listener_distance_m, NEAR * scene.radius
    if distance < least and scene.is_listener_placed:
        warning = (
            f"the listener is {si(distance, 'm')} from the contact, within {NEAR:g} radii of the"
            " sphere, where the levels of a small source do not hold: place sound.listener_mm at"
            f" least {math.ceil(1e3 * least)} mm from the contact"
        )
        yield Finding("listener", "listener", si(distance, "m"), warning)
    elif distance < least:
        numbers = {"distance": distance, "radii": NEAR, "least": least}
        yield judged("listener", si(distance, "m"), True, **numbers)
    if scene.dynamics is None:
        yield _bouncing(scene)
        return
    yield from _vibration(scene)
    yield from _modes(scene)
    if scene.rolling.drop_mm is not None:
        yield from _fall(scene)


def _half_space(scene: Scene) -> Iterator[Finding]:
    """Compare slope and contact radius with the limits of a half-space."""
    slope = cost.roughness(scene)[1]
    along, across = resolution.contact_radius(scene), semi_axes(scene)[1]
    share = max(along / scene.radius, across / scene.radius_across)
    steep = {"slope": slope, "most": MAX_SLOPE, "advice": _gentler(scene)}
    wide = {"share": share, "most": MAX_CONTACT}
    yield judged("slope", rounded(slope), slope > MAX_SLOPE, **steep)
    yield judged("contact_radius", rounded(share), share > MAX_CONTACT, **wide)
    if scene.faults:
        slope = max(fault.steepest for fault in scene.faults)
        sharp = {"slope": slope, "most": MAX_SLOPE}
        yield judged("fault_slope", rounded(slope), slope > MAX_SLOPE, **sharp)


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


def _bouncing(scene: Scene) -> Finding:
    """Name the frequency at which the ball bounces, and weigh its part of the sound.

    The maximum speed decides, where the record holds the frequency.
    """
    frequency, speed = cost.bounce_hz(scene), scene.motion.fastest(scene.duration)
    highest = min(resolution.HEARING[1], speed / (2 * scene.track.step))
    if not resolution.HEARING[0] < frequency < highest:
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
    if frequency < resolution.HEARING[1]:
        steel = ", as if of steel" * (scene.sphere.youngs_modulus_gpa is None)
        most = scene.sphere.radius_mm * frequency / resolution.HEARING[1]
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
    elif thickness is not None and 1e3 * radius > THICK * thickness:
        doubt = "thickness"
    width_um = written("{width_um:up}", width_um=2e6 * radius)
    larger = f"measure a surface of at least {width_um} um each way"
    if isinstance(scene.surface, MadeSurface):
        larger = f"choose a surface.width_um of at least {width_um}, and a track as long"
    numbers = {"period": period, "larger": larger, "share": radius / scene.radius}
    numbers |= {"most": MAX_CONTACT, "thick": THICK, "thickness": 1e3 * radius / THICK}
    yield judged("drop_width", f"radius {si(radius, 'm')}", doubt, **numbers)
    if math.isfinite(scene.hardness):
        height = 1e3 * drop.elastic_height_m(scene)
        yields = 1e3 * drop.height_m(scene) > height
        yield judged("impacts_yield", f"up to {rounded(height)} mm", yields, most=height)


# ---- scenes with dynamics


def _vibration(scene: Scene) -> Iterator[Finding]:
    """Judge the vibration of a scene with dynamics."""
    yield _resonance(scene)
    yield _force(scene)
    yield _waves(scene)
    if of_scene.plate(scene) is None:
        lowest = HALF_SPACE_HZ_M / scene.sound.distance_m
        yield judged("half_space_sound", si(lowest, "Hz"), lowest > resolution.HEARING[0])
    else:
        yield from _bending(scene)
    yield from _edges(scene)
    yield from _marches(scene)


def _resonance(scene: Scene) -> Finding:
    """State resonance and damping of the sphere on contact and plate."""
    chain = of_scene.smooth_chain(scene)
    quality = "undamped" if math.isinf(chain.quality) else f"Q {rounded(chain.quality)}"
    return Finding("resonance", "contact resonance", f"{si(chain.resonance_hz, 'Hz')}, {quality}")


# ---- contact force


def _force(scene: Scene) -> Finding:
    """Estimate the fluctuation of the contact force over the load, and its extremes."""
    rms = force_rms(scene)
    if rms is None or scene.dynamics is None:
        reason = "for a height file" if scene.height_paths else "for faults and waviness alone"
        return Finding("force_ratio", "contact force over load", f"not estimated {reason}")
    ratio = rms / scene.load
    low, high = 1 - PEAKS * ratio, 1 + PEAKS * ratio
    extremes = f"{rounded(max(low, 0), 3)} to {rounded(high, 3)}"
    value = f"about {extremes}, rms {rounded(ratio)} (from the statistics)"
    if scene.faults:
        value += "; faults are left out"
    wave = scene.motion.fastest(scene.duration) / cost.bounce_hz(scene)
    if wave < 2 * semi_axes(scene)[0]:
        value += "; short waves may multiply it"
    or_load = " or a higher rolling.load_n" * (scene.rolling.load_n != WEIGHT)
    return judged("force_ratio", value, low < 0, ratio=ratio, or_load=or_load)


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


def _waves(scene: Scene) -> Finding:
    """Compare the waves that feed the resonance with the correlation length.

    Shorter waves belong to the grid more than to the surface.
    """
    speed, frequency = scene.motion.fastest(scene.duration), cost.bounce_hz(scene)
    wave = speed / frequency
    length = 1e-6 * min((law.lengths_um[0] for law in scene.laws), default=0.0)
    numbers = {"speed": speed, "length": length, "least": length * frequency}
    finer = "a finer measurement"
    if isinstance(scene.surface, MadeSurface):
        finer = "a smaller surface.spacing_um"
    return judged("resonance_wave", si(wave, "m"), wave < length, finer=finer, **numbers)


# ---- plate


def _bending(scene: Scene) -> Iterator[Finding]:
    """Judge thickness, bending theory and distance of the listener of a plate that bends."""
    plate, distance = of_scene.plate(scene), scene.sound.distance_m
    assert plate is not None  # asked for by the caller
    radius, thickness = max(semi_axes(scene)), of_scene.thickness_m(scene)
    share, limit = radius / thickness, of_scene.bending_limit_hz(scene)
    near, air = FAR * plate.nearest_m, plate.lowest_hz
    too_close = distance < near and scene.plate.edges_mm is None
    thin, thick = 1e3 * thickness * limit / resolution.HEARING[1], 1e3 * radius / THICK
    least, thicknesses = 1e3 * thickness * air / LOADED_HZ, of_scene.MIN_THICKNESSES
    doubt, critical = limit < resolution.HEARING[1], si(plate.critical_hz, "Hz")
    yield judged("air_load", si(air, "Hz"), air > LOADED_HZ, least=least)
    yield judged("contact_thickness", rounded(share), share > THICK, most=THICK, least=thick)
    yield judged("bending", si(limit, "Hz"), doubt, thicknesses=thicknesses, most=thin)
    yield judged("coincidence", critical, too_close, near=near)


def _edges(scene: Scene) -> Iterator[Finding]:
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
    modal = of_scene.smooth_chain(scene).modes
    assert modal is not None  # as there is a plate with edges
    sag, most = scene.load * modal.compliance_m_n, of_scene.BENT
    bends = sag > most * 1e-3 * (scene.plate.thickness_mm or 0.0)
    points = scene.plate.contact_ends_mm.values()
    ends = [f"[{rounded(x, 4)}, {rounded(y, 4)}] mm" for x, y in points]
    contact = f"fixed at {ends[0]}: seen from the plate the sphere rolls on the spot"
    if len(ends) > 1:
        contact = f"to-and-fro from {ends[0]} to {ends[1]}; its record does not loop"
    yield judged("plate_modes", modes, not count)
    yield judged("plate_sag", si(sag, "m"), bends, most=most)
    yield Finding("plate_contact", "contact on the plate", contact)


# ---- cost


def _marches(scene: Scene) -> Iterator[Finding]:
    """State the cost of the marches at other loads and of the release under the moving load."""
    assert scene.dynamics is not None  # asked for by the caller
    (count, total), seconds = forecast.law_seconds(scene), cost.lap_seconds(scene)
    value = f"{count} more marches, {computing(total)}, and more where the force leaves"
    yield Finding("force_law", "force law", f"{value} them", None, total)
    if not scene.moves_release:
        return
    speed, frequency = scene.motion.slowest(scene.duration), cost.bounce_hz(scene)
    steps, least = speed / (frequency * scene.step), MIN_STEPS * frequency * scene.step
    value = f"one more march, {computing(seconds)}, {rounded(steps)} steps in a period"
    if scene.dynamics.release is None:
        value += "; dynamics.release: false leaves it out"
    numbers = {"steps": steps, "least": MIN_STEPS, "speed": least}
    yield replace(judged(OWN_MARCH, value, steps < MIN_STEPS, **numbers), seconds=seconds)
