"""Findings of a scene with dynamics: resonance, contact force, plate, and the cost of its marches.

The contact force is estimated from the statistics of the surface: the contact averages the heights
with its pressure, an ellipsoid over the circle in which a smooth contact is at most an rms height
apart, and their mean moves sphere, contact and plate as a linear chain. A looped record has the
lines of its lap, which a sharp resonance may miss. docs/dynamics.md compares the
estimate with runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from acoustics.rectangular_plate import MODES_HZ
from rolling.check import cost
from rolling.check.finding import Finding, computing, judged, si
from rolling.check.resolution import HEARING
from rolling.dynamics import of_scene
from rolling.dynamics.smooth_contact import semi_axes
from rolling.scene.laws import HeightLaw
from rolling.scene.quantities import plate_modes
from rolling.scene.scene import Scene
from rolling.scene.sections import WEIGHT
from rolling.surface import made

PEAKS = 4.0  # standard deviations of Gaussian noise that some 10^4 periods exceed once
THICK = 0.1  # contact radius over thickness up to which the contact sees a half-space
FAR = 3.0  # listener's distance over the distance from which the pressure on the axis holds
LOADED_HZ = 100.0  # frequency below which the air may load the plate
HALF_SPACE_HZ_M = 10e3  # frequency times distance from which a half-space's pressure holds
OWN_MARCH = "moving_release"  # key of the finding whose march no run shares
LEAST_STEPS = 8  # in a period of the resonance, for the release under the moving load
_NOTHING = 1e-200  # spectral density [m3] of a surface that the contact averages out
_SPEEDS = 61  # number of speeds, as a sharp resonance needs them
_WAVES, _ACROSS, _LINES = 160, 160, 40_000  # points along, across, and over the resonance


def findings(scene: Scene) -> Iterator[Finding]:
    """Judge the vibration of a scene with dynamics."""
    yield _force(scene)
    yield _waves(scene)
    if of_scene.plate(scene) is None:
        lowest = HALF_SPACE_HZ_M / scene.sound.distance_m
        yield judged("half_space_sound", si(lowest, "Hz"), lowest > HEARING[0])
    else:
        yield from _bending(scene)
    yield from _edges(scene)
    yield from _marches(scene)


def resonance(scene: Scene) -> Finding:
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
    density = np.sum([_mean_heights(scene, law, coarse) for law in scene.laws], axis=0)
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


def _mean_heights(scene: Scene, law: HeightLaw, along: Array) -> Array:
    """Return the two-sided spectral density [m3] of the heights that the contact averages."""
    widest = math.pi / scene.spacing
    across = np.concatenate(([0.0], np.geomspace(1e-4 * widest, widest, _ACROSS)))
    # The highest asperities carry where smooth surfaces would be an rms height apart.
    whole = cost.roughness(scene)[0]
    radii = scene.radius, scene.radius_across
    axes = zip(semi_axes(scene), radii, strict=True)
    length, width = (math.sqrt(axis**2 + radius * whole) for axis, radius in axes)
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
    return judged("resonance_wave", si(wave, "m"), wave < length, **numbers)


# ---- plate


def _bending(scene: Scene) -> Iterator[Finding]:
    """Judge thickness, bending theory and distance of the listener of a plate that bends."""
    plate, distance = of_scene.plate(scene), scene.sound.distance_m
    assert plate is not None  # asked for by the caller
    radius, thickness = max(semi_axes(scene)), of_scene.thickness_m(scene)
    share, limit = radius / thickness, of_scene.bending_limit_hz(scene)
    near, air = FAR * plate.nearest_m, plate.lowest_hz
    too_close = distance < near and scene.plate.edges_mm is None
    thin, thick = 1e3 * thickness * limit / HEARING[1], 1e3 * radius / THICK
    least, thicknesses = 1e3 * thickness * air / LOADED_HZ, of_scene.LEAST_THICKNESSES
    doubt, critical = limit < HEARING[1], si(plate.critical_hz, "Hz")
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
    (falling, total), seconds = cost.fall_seconds(scene), cost.lap_seconds(scene)
    others = scene.dynamics.loads - 1
    total += others * seconds
    value = f"{others + falling} more marches, {computing(total)}, and more where the force leaves"
    yield Finding("force_law", "force law", f"{value} them", None, total)
    if not scene.moves_release:
        return
    speed, frequency = scene.motion.slowest(scene.duration), cost.bounce_hz(scene)
    steps, least = speed / (frequency * scene.step), LEAST_STEPS * frequency * scene.step
    value = f"one more march, {computing(seconds)}, {rounded(steps)} steps in a period"
    if scene.dynamics.release is None:
        value += "; dynamics.release: false leaves it out"
    numbers = {"steps": steps, "least": LEAST_STEPS, "speed": least}
    yield replace(judged(OWN_MARCH, value, steps < LEAST_STEPS, **numbers), seconds=seconds)
