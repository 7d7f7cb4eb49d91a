"""Limits of the model for a scene with dynamics: force, plate, half-space, modes and falls."""

import math
from collections.abc import Iterator

from acoustics.numbers import rounded, rounded_down, rounded_up, si
from acoustics.rectangular_plate import MODES_HZ
from rolling.check import cost, forecast, resolution
from rolling.check.finding import Finding
from rolling.check.force_estimate import force_rms
from rolling.check.validity import MAX_CONTACT
from rolling.dynamics import drop
from rolling.dynamics.ball_on_plate import BENT, MIN_THICKNESSES
from rolling.in_si.physics_of_scene import bodies_of, plate_of, smooth_contact_of
from rolling.numbers.doubt import Doubt, Severity
from rolling.scene.scene import Scene
from rolling.scene.sections import WEIGHT
from rolling.scene.surfaces import MadeSurface
from rolling.scene.values_in_si import STEEL_DENSITY, STEEL_GPA, STEEL_POISSON, plate_modes

LOWEST_MODE = 0.84  # frequency of the lowest mode times diameter over the speed of shear waves
PEAKS = 4.0  # standard deviations of Gaussian noise that some 10^4 periods exceed once
THICK = 0.1  # contact radius over thickness up to which the contact sees a half-space
FAR = 3.0  # listener's distance over the distance from which the pressure on the axis holds
LOADED_HZ = 100.0  # frequency below which the air may load the plate
HALF_SPACE_HZ_M = 10e3  # frequency times distance from which a half-space's pressure holds
OWN_MARCH = "moving_release"  # key of the row whose march no run shares
MIN_STEPS = 8  # in a period of the resonance, for the release under the moving load


def rules(scene: Scene) -> Iterator[Finding | Doubt]:
    """Judge vibration, modes and fall of a scene with dynamics."""
    yield _resonance(scene)
    yield from _force(scene)
    yield from _waves(scene)
    if plate_of(scene.plate).bending is None:
        yield from _half_space_sound(scene)
    else:
        yield from _bending(scene)
    yield from _edges(scene)
    yield from _marches(scene)
    yield from _modes(scene)
    if not scene.keeps_its_load:
        yield from _fall(scene)


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
    chain = bodies_of(scene).smooth_chain
    quality = "undamped" if math.isinf(chain.quality) else f"Q {rounded(chain.quality)}"
    return Finding("resonance", "contact resonance", f"{si(chain.resonance_hz, 'Hz')}, {quality}")


# ---- contact force


def _force(scene: Scene) -> Iterator[Finding | Doubt]:
    """Estimate the fluctuation of the contact force over the load, and its extremes."""
    key = "force_ratio"
    name = "contact force over load"
    rms = force_rms(scene)
    if rms is None or scene.dynamics is None:
        reason = "for a height file" if scene.height_paths else "for faults and waviness alone"
        yield Finding(key, name, f"not estimated {reason}")
        return
    ratio = rms / scene.load
    low = 1 - PEAKS * ratio
    high = 1 + PEAKS * ratio
    extremes = f"{rounded(max(low, 0), 3)} to {rounded(high, 3)}"
    value = f"about {extremes}, rms {rounded(ratio)} (from the statistics)"
    if scene.faults:
        value += "; faults are left out"
    wave = scene.motion.fastest(scene.duration) / bodies_of(scene).bounce_hz
    if wave < 2 * smooth_contact_of(scene).semi_axes_m()[0]:
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


def _waves(scene: Scene) -> Iterator[Finding | Doubt]:
    """Compare the waves that feed the resonance with the correlation length.

    Shorter waves belong to the grid more than to the surface.
    """
    speed = scene.motion.fastest(scene.duration)
    frequency = bodies_of(scene).bounce_hz
    wave = speed / frequency
    name = "waves that feed the resonance"
    length = 1e-6 * min((law.lengths_um[0] for law in scene.laws), default=0.0)
    yield Finding("resonance_wave", name, si(wave, "m"))
    if wave < length:
        yield Doubt(
            "resonance_wave",
            f"the waves that feed the resonance at {rounded(speed, 3)} m/s are shorter than the "
            f"correlation length of {si(length, 'm')}, and the grid decides how much of them there "
            "is",
            Severity.INDICATIVE,
            advice=f"compare {resolution.finer(scene)}, or choose a rolling.speed_m_s of at least "
            f"{rounded_up(length * frequency)}",
        )


# ---- plate


def _bending(scene: Scene) -> Iterator[Finding | Doubt]:
    """Judge thickness, bending theory and distance of the listener of a plate that bends."""
    body = plate_of(scene.plate)
    plate = body.bending
    distance = scene.sound.distance_m
    assert plate is not None  # asked for by the caller
    radius = max(smooth_contact_of(scene).semi_axes_m())
    thickness = body.thickness_m
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
    share = radius / thickness
    name = "contact radius / thickness"
    yield Finding("contact_thickness", name, rounded(share))
    if share > THICK:
        yield Doubt(
            "contact_thickness",
            f"{name}: the contact is that of a half-space, which holds up to {THICK:g}",
            Severity.DO_NOT_QUOTE,
            advice=f"choose a plate.thickness_mm of at least {rounded_up(1e3 * radius / THICK)}",
        )
    limit = body.bending_limit_hz
    name = "thin-plate theory up to"
    yield Finding("bending", name, si(limit, "Hz"))
    if limit < resolution.HEARING[1]:
        most_mm = 1e3 * thickness * limit / resolution.HEARING[1]
        yield Doubt(
            "bending",
            f"{name}: bending waves above are shorter than {MIN_THICKNESSES:g} thicknesses",
            Severity.INDICATIVE,
            advice="do not trust the bands above, or choose a plate.thickness_mm of at most "
            f"{rounded_down(most_mm)}",
        )
    near = FAR * plate.nearest_m
    name = "coincidence of the plate"
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
    plate = plate_of(scene.plate).with_edges
    if plate is None:
        return
    modes = "none up to 30 kHz"
    count = plate.mode_count - plate.rigid_modes
    if count:
        lowest = float(plate.angular_frequency[plate.rigid_modes]) / (2 * math.pi)
        overlap = MODES_HZ / (plate.least_loss_factor * plate_modes(scene.plate))
        modes = f"{count} up to 30 kHz from {si(lowest, 'Hz')}"
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
    modal = bodies_of(scene).smooth_chain.modes
    assert modal is not None  # as there is a plate with edges
    sag = scene.load * modal.compliance_m_n
    name = "plate sinks under the load by"
    yield Finding("plate_sag", name, si(sag, "m"))
    if sag > BENT * 1e-3 * (scene.plate.thickness_mm or 0.0):
        yield Doubt(
            "plate_sag",
            f"{name}: thin-plate theory wants at most {BENT:g} of the thickness",
            Severity.INDICATIVE,
            advice="choose a lower rolling.load_n, or a thicker or smaller plate",
        )
    points = scene.plate.contact_ends_mm.values()
    ends = [f"[{rounded(x, 4)}, {rounded(y, 4)}] mm" for x, y in points]
    contact = f"fixed at {ends[0]}: seen from the plate the sphere rolls on the spot"
    if len(ends) > 1:
        contact = f"to-and-fro from {ends[0]} to {ends[1]}; its record does not loop"
    yield Finding("plate_contact", "contact on the plate", contact)


# ---- modes of the sphere within hearing, and its fall


def lowest_mode_hz(scene: Scene) -> float:
    """Return the frequency [Hz] of the lowest mode of the sphere, of steel without a modulus."""
    sphere = scene.sphere
    young = STEEL_GPA
    poisson = STEEL_POISSON
    density = STEEL_DENSITY
    if sphere.youngs_modulus_gpa is not None and sphere.poissons_ratio is not None:
        young = sphere.youngs_modulus_gpa
        poisson = sphere.poissons_ratio
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
    bodies = bodies_of(scene)
    fall = drop.fall_s(bodies)
    duration = scene.duration
    force = drop.largest_force_n(bodies)
    contact_time = drop.impact_s(bodies)
    yield Finding(
        "drop",
        "first impact, by Hertz",
        f"{si(drop.speed_m_s(bodies), 'm/s')} after {si(fall, 's')}, up to {si(force, 'N')} for "
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
    yield from _impact_width(scene, max(bodies.contact.semi_axes_m(force)))
    if math.isfinite(scene.hardness):
        height_mm = 1e3 * drop.elastic_height_m(bodies.contact, scene.hardness)
        yield Finding("impacts_yield", "elastic drop", f"up to {rounded(height_mm)} mm")
        if 1e3 * bodies.drop_height_m > height_mm:
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
    key = "drop_width"
    name = "contact of the first impact"
    yield Finding(key, name, f"radius {si(radius, 'm')}")
    period = cost.shortest_period(scene)
    thickness = scene.plate.thickness_mm
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


# ---- cost


def _marches(scene: Scene) -> Iterator[Finding | Doubt]:
    """State the cost of the marches at other loads and of the release under the moving load."""
    assert scene.dynamics is not None  # asked for by the caller
    (count, total), seconds = forecast.law_seconds(scene), cost.lap_seconds(scene)
    value = f"{count} more marches, {cost.computing(total)}, and more where the force leaves them"
    yield Finding("force_law", "force law", value, total)
    if not scene.moves_release:
        return
    speed = scene.motion.slowest(scene.duration)
    frequency = bodies_of(scene).bounce_hz
    steps = speed / (frequency * scene.step)
    name = "release under the moving load"
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
