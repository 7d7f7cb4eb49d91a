"""Resolution of heights, contact and sound: spacing, steps and length of the record.

The rule for the error that the grid leaves in the release was fitted to 36 scenes and tested on 24
others (docs/accuracy.md): 60 steps of each were marched on a grid of 2 um and on a quarter of it.
On the others it is off by 3.7 dB rms, and by 10 dB at most.
"""

from __future__ import annotations

import math

from acoustics import bands
from acoustics.numbers import rounded
from rolling.check import cost, long_steps
from rolling.check.finding import Finding, rounded_down, rounded_up, si
from rolling.dynamics import of_scene
from rolling.scene.scene import Scene
from rolling.scene.surfaces import MadeSurface
from rolling.surface import refined

KEY = "resolution"
WANTED_DB = -20.0  # rms error of the release over its rms fluctuation
# The rule warns a little earlier: it then finds every scene above -18 dB.
MARGIN_DB = 1.0
# Blended edges leave third octaves up to 16 kHz within 1 dB at this error (0.7 dB at -31.9 dB).
BANDS_DB = -32.0
CONSTANT_DB, PER_LENGTH_DB, PER_AREA_DB = -7.2, -14.8, -4.9
# Flat cells, as exponential laws have them; the reference has them as well.
FLAT_DB = -4.4
# Sharp edges add this per decade of slope over the slope that the hardness levels.
SHARP_DB = 27.5
SHARP_FLAT_DB = 5.8
SUBCELLS_DB = -6.0  # per doubling of the sub-cells beyond the number of `auto`
PER_SPACING_DB = -PER_LENGTH_DB - 2 * PER_AREA_DB  # per decade of the spacing
MOST_TRIED = 10_000  # numbers of nodes that a search for a spacing of few digits tries

HEARING = (bands.NOMINAL_HZ[0], bands.NOMINAL_HZ[-1])  # [Hz]
MIN_SHARE = 0.01  # share of a record; shorter stretches that are too slow for hearing are ignored


def findings(scene: Scene) -> list[Finding]:
    """Judge the step against hearing and contact, and the spacing against the heights."""
    tone = [_grid_tone(scene)] if scene.numerics.step_nodes < 1 else []
    return [_nyquist(scene), _step_length(scene), *tone, *_spacing(scene)]


# ---- error of the grid


def grid_signal_db(scene: Scene) -> float | None:
    """Estimate the rms error of the release from the grid over its rms fluctuation [dB].

    The numbers of nodes within rms roughness over slope and within the loaded area decide. None is
    returned for a surface that is not random or has no slope.
    """
    if not scene.laws:
        return None
    rq, slope = cost.roughness(scene)
    if not slope > 0:
        return None
    flat = any(law.goes_on for law in scene.laws)
    # A rough elastic contact carries E* slope / sqrt(2 pi) on its loaded area, a smooth one Hertz's
    # mean pressure, and no area more than the hardness.
    rough = scene.contact_modulus * slope / math.sqrt(2 * math.pi)
    radius = of_scene.hertz_radius(scene)
    pressure = min(scene.hardness, max(rough, scene.load / (math.pi * radius**2)))
    error = CONSTANT_DB + PER_LENGTH_DB * math.log10(rq / slope / scene.spacing)
    error += PER_AREA_DB * math.log10(scene.load / pressure / scene.spacing**2)
    error += FLAT_DB if flat else 0.0
    if math.isfinite(scene.hardness) and scene.numerics.edges == "sharp":
        sharp = SHARP_DB * math.log10(1 + rough / scene.hardness)
        error += min(SHARP_FLAT_DB, sharp) if flat else sharp
    if cost.has_blended_edges(scene):
        slope_of_heights = cost.SLOPE_MARGIN * slope
        usual = refined.auto_subcells(slope_of_heights, scene.contact_modulus, scene.hardness)
        error += SUBCELLS_DB * math.log2(cost.subcells(scene) / usual)
    return error


def _spacing(scene: Scene) -> list[Finding]:
    """Judge the spacing of a random surface by the error that it leaves."""
    error = grid_signal_db(scene)
    if error is None:
        return []
    shortest = min(min(law.lengths_um) for law in scene.laws)
    nodes = shortest / scene.surface.spacing_um
    value = f"about {error:.0f} dB of the fluctuation"
    warning = too_coarse(scene, error, "by a rule that is off by some 4 dB")
    if warning is None and error > BANDS_DB:
        fine = spacing(scene, error, BANDS_DB)
        value += f"; third octaves within 1 dB up to 16 kHz take {fine:g} um"
    return [
        Finding("correlation_nodes", "nodes per correlation length", rounded(nodes, 3)),
        Finding(KEY, "error of the grid", value, warning),
    ]


def too_coarse(scene: Scene, error: float, source: str) -> str | None:
    """Warn of an error of the grid [dB] by its source; None where it is small enough.

    Check and run share this limit and its advice.
    """
    if error <= WANTED_DB - MARGIN_DB:
        return None
    return (
        f"the grid leaves an error of the release of about {error:.0f} dB of its fluctuation (rms,"
        f" {source}), {WANTED_DB:g} dB and a margin of {MARGIN_DB:g} dB are wanted:"
        f" {advice(scene, error + MARGIN_DB)}"
    )


def advice(scene: Scene, error: float) -> str:
    """Name the spacing that brings an error of the grid [dB] down to the wanted error.

    A file cannot choose its spacing: it needs a finer measurement.
    """
    wanted, bands = (spacing(scene, error, goal) for goal in (WANTED_DB, BANDS_DB))
    blended = ""
    if math.isfinite(scene.hardness) and scene.numerics.edges == "sharp":
        blended = "choose numerics.edges: blended, or "
    if not isinstance(scene.surface, MadeSurface):
        return f"{blended}a measurement with a spacing of at most {wanted:g} um is needed"
    return (
        f"{blended}choose a surface.spacing_um of at most {wanted:g}, or {bands:g} for third"
        " octaves within 1 dB up to 16 kHz"
    )


def spacing(scene: Scene, error: float, goal: float) -> float:
    """Return the spacing [um] that brings an error of the grid [dB] down to a goal [dB]."""
    factor = 10 ** ((goal - error) / PER_SPACING_DB)
    return fitting_spacing(scene, scene.surface.spacing_um * factor)


def fitting_spacing(scene: Scene, spacing_um: float) -> float:
    """Return the largest spacing [um] of few digits up to a limit that fits the scene's width."""
    if not isinstance(scene.surface, MadeSurface):
        return float(f"{math.floor(spacing_um * 100) / 100 or spacing_um:.2g}")
    width = scene.surface.width_um
    least = math.ceil(width / spacing_um - 1e-9)
    # Among millions of nodes no spacing of few digits need fit, and the search would take seconds.
    for nodes in range(least, min(2 * least, least + MOST_TRIED)):
        spacing = float(f"{width / nodes:.3g}")
        if abs(width / spacing - nodes) <= 1e-7 * nodes:
            return spacing
    return width / least


# ---- steps and record


def _nyquist(scene: Scene) -> Finding:
    """Judge the Nyquist frequency of the steps against the end of hearing.

    At a varying speed the share of the record with a short band counts.
    """
    motion, duration, step = scene.motion, scene.duration, scene.track.step
    slowest, fastest = motion.slowest(duration), motion.fastest(duration)
    low, high = (si(speed / (2 * step), "Hz") for speed in (slowest, fastest))
    wanted, end = 2 * HEARING[1] * step, si(HEARING[1], "Hz")
    seconds = motion.time_below(wanted, duration)
    step_um = rounded_down(_usual_speed(scene, duration) / (2 * HEARING[1]) * 1e6)
    advice = (
        f"choose a step of at most {step_um} um or a speed of at least {rounded_up(wanted)} m/s"
    )
    if motion.is_constant(duration):
        short = f"the simulated band ends at {high} at {fastest:g} m/s, hearing at {end}: {advice}"
        short_band = fastest < wanted
        return Finding("nyquist", "simulated Nyquist", high, short if short_band else None)
    short = (
        f"for {rounded(100 * seconds / duration, 3)} % of the record ({si(seconds, 's')}) the"
        f" simulated band ends below {end}, at {low} at the slowest: the bands above hold the sound"
        f" of the faster stretches alone; {advice} for {100 - 100 * MIN_SHARE:g} % of the record"
    )
    short_band = seconds >= MIN_SHARE * duration
    value = f"{low} to {high}"
    return Finding("nyquist", "simulated Nyquist", value, short if short_band else None)


def _usual_speed(scene: Scene, duration: float) -> float:
    """Return the speed [m/s] that the sphere reaches for most of the record.

    It rolls more slowly for less than `MIN_SHARE` of the record.
    """
    low, high = 0.0, scene.motion.fastest(duration)
    for _ in range(60):
        middle = (low + high) / 2
        below = scene.motion.time_below(middle, duration) < MIN_SHARE * duration
        low, high = (middle, high) if below else (low, middle)
    return low or high


def _grid_tone(scene: Scene) -> Finding:
    """Name the tone of the grid that steps below a node make audible."""
    motion, duration = scene.motion, scene.duration
    low, high = (
        speed / scene.spacing for speed in (motion.slowest(duration), motion.fastest(duration))
    )
    tone = si(low, "Hz") if motion.is_constant(duration) else f"{si(low, 'Hz')} to {si(high, 'Hz')}"
    audible = None
    if motion.time_below(HEARING[1] * scene.spacing, duration) >= MIN_SHARE * duration:
        audible = (
            f"steps below one node sound a tone of the grid at {tone}: choose numerics.step_nodes 1"
            " or a surface.spacing_um of at most"
            f" {rounded_down(_usual_speed(scene, duration) / HEARING[1] * 1e6)}"
        )
    return Finding("grid_tone", "tone of the grid", tone, audible)


def _step_length(scene: Scene) -> Finding:
    """Compare the step with the contact, and state the error of a long step."""
    radius = long_steps.contact_radius(scene)
    radii = scene.track.step / radius
    warning = None
    if radii > long_steps.DOUBTFUL_RADII:
        lost = long_steps.lost_release(radii)
        warning = (
            f"a step is {rounded(radii)} contact radii of {si(radius, 'm')}, at most"
            f" {long_steps.DOUBTFUL_RADII:g} are wanted: the mean release is up to about"
            f" {rounded(100 * lost)} % low, levels are off by up to"
            f" {rounded(long_steps.LEVEL_ERROR_DB * radii)} dB; choose a step of at most"
            f" {rounded_down(long_steps.DOUBTFUL_RADII * radius * 1e6)} um"
        )
    return Finding("step_length", "step / contact radius", rounded(radii), warning)


def record(scene: Scene) -> Finding:
    """Count the third octaves whose level the length of the record makes certain within 2 dB."""
    certain = bands.reliable(scene.duration)
    value = f"{certain.sum()} of {len(certain)}"
    if not certain.all():
        lowest = [name for name, sure in zip(bands.BAND_NAMES, certain, strict=True) if sure][:1]
        value += f", from {lowest[0]} Hz on" if lowest else ", the record is very short"
    return Finding("third_octaves", "third octaves within 2 dB", value)
