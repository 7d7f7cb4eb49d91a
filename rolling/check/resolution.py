"""Resolution of heights, contact and sound: spacing, steps and length of the record.

The release of a step is the mean pressure at its ends times the fall between them. It is
accurate to second order in the step, and wrong as soon as the contacts at both ends have little in
common.
"""

import math
from collections.abc import Iterator

import numpy as np

from acoustics import bands
from acoustics.numbers import rounded, rounded_down, rounded_up, si
from rolling.check.finding import Finding
from rolling.contact.estimated_contact import contact_radius_m
from rolling.contact.track import MIN_SHARE
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.numbers.doubt import Doubt, Severity, sized
from rolling.numbers.quantity import SERIES
from rolling.scene import grid_error
from rolling.scene.scene import Scene
from rolling.scene.surfaces import MadeSurface

KEY = "resolution"  # of the error of the release
LEVEL_KEY = "grid"  # of what it leaves of the level
# Keys of rules of thumb for the grid, which say nothing more once its error is measured.
GRID_RULES = (KEY, "hertz_nodes", "resonance_wave")
WANTED_DB = -20.0  # rms error of the release over its rms fluctuation
# The rule warns a little earlier: it then finds every scene above -18 dB.
MARGIN_DB = 1.0
# Blended edges leave third octaves up to 16 kHz within 1 dB at this error (0.7 dB at -31.9 dB).
BANDS_DB = -32.0
MAX_TRIED = 10_000  # numbers of nodes that a search for a spacing of few digits tries

HEARING = (bands.NOMINAL_HZ[0], bands.NOMINAL_HZ[-1])  # [Hz]

DOUBTFUL_RADII = 0.25  # step over contact radius, above which a scene gets a warning

# A smooth elastic sphere, marched at 32 nodes per radius, loses these shares of the release. Rough
# and yielding contacts are wider than the radius and lose the same within 0.02, or less (twelve
# scenes, 5 to 100 N, Ra 0 to 1 um, elastic and down to 0.7 GPa).
_RADII = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0)
_LOST = (0.0, 0.0045, 0.0167, 0.0368, 0.0644, 0.1393, 0.2347, 0.3344, 0.4177, 0.5383)
# The error of the level up to the Nyquist frequency of the steps stays below this bound [dB per
# radius], which is read from the ten rough scenes among the twelve.
LEVEL_ERROR_DB = 3.0


def rules(scene: Scene) -> Iterator[Finding | Doubt]:
    """Judge the step against hearing and contact, and the spacing against the heights."""
    yield from _nyquist(scene)
    yield from _step_length(scene)
    yield from _grid_tone(scene)
    yield from _spacing(scene)


# ---- error of the grid


def grid_of_level(scene: Scene, reason: str | None = None) -> Doubt:
    """Return the doubt about a level whose error of the grid is not measured, for a reason.

    The rule for the release holds for the level of a release; of a vibration nothing is known.
    """
    error = None
    if scene.sound.source != "vibration":
        error = grid_error.grid_signal_db(scene)
    if error is not None and error > WANTED_DB:
        decibels = 20 * math.log10(1 + 10 ** (error / 20))
        text = f"the grid may leave {rounded(decibels)} dB, by a rule"
        return sized(LEVEL_KEY, text, decibels, least=Severity.INDICATIVE)
    return _unknown_grid(f"because {reason}" if reason else "without numerics.error_estimate")


def grid_of_silent_vibration() -> Doubt:
    """Return the doubt about a vibration that is computed while the release is measured."""
    advice = "`sound.source: vibration` measures the vibration"
    return _unknown_grid("because it is estimated for the record that is measured", advice)


def _unknown_grid(why: str, advice: str = "") -> Doubt:
    """Return the doubt about a level whose error of the grid is unknown."""
    text = f"the error of the grid is unknown, {why}"
    return Doubt(LEVEL_KEY, text, Severity.INDICATIVE, advice=advice)


def _spacing(scene: Scene) -> Iterator[Finding | Doubt]:
    """Judge the spacing of a random surface by the error that it leaves."""
    error = grid_error.grid_signal_db(scene)
    if error is None:
        return
    shortest = min(min(law.lengths_um) for law in scene.laws)
    nodes = shortest / scene.spacing_um
    yield Finding("correlation_nodes", "nodes per correlation length", rounded(nodes, 3))
    value = f"about {error:.0f} dB of the fluctuation"
    if WANTED_DB - MARGIN_DB >= error > BANDS_DB:
        fine = spacing(scene, error, BANDS_DB)
        value += f"; third octaves within 1 dB up to 16 kHz take {fine:g} um"
    yield Finding(KEY, "error of the grid", value)
    yield from too_coarse(scene, error, "by a rule that is off by some 4 dB", grid_of_level(scene))


def too_coarse(scene: Scene, error: float, source: str, of_level: Doubt) -> Iterator[Doubt]:
    """Warn of an error of the release from the grid [dB] by its source, unless it is small.

    It is as severe as the doubt that the grid leaves about the level. Check and run share this
    limit and its advice.
    """
    if error <= WANTED_DB - MARGIN_DB:
        return
    yield Doubt(
        KEY,
        f"error of the grid: the grid leaves an error of the release of about {error:.0f} dB of "
        f"its fluctuation (rms, {source}), {WANTED_DB:g} dB and a margin of {MARGIN_DB:g} dB are "
        "wanted",
        of_level.severity,
        of_level.decibels,
        _finer_grid(scene, error + MARGIN_DB),
        about=(SERIES,),
    )


def _finer_grid(scene: Scene, error: float) -> str:
    """Name the spacing that brings an error of the grid [dB] down to the wanted error.

    A file cannot choose its spacing: it needs a finer measurement.
    """
    wanted_um = spacing(scene, error, WANTED_DB)
    advice = f"{finer(scene, wanted_um)} is needed"
    if isinstance(scene.surface, MadeSurface):
        bands_um = spacing(scene, error, BANDS_DB)
        advice = (
            f"choose a surface.spacing_um of at most {wanted_um:g}, or {bands_um:g} for third "
            "octaves within 1 dB up to 16 kHz"
        )
    may_blend = math.isfinite(scene.hardness) and not scene.is_permanent
    if may_blend and scene.numerics.edges == "sharp":
        advice = f"choose numerics.edges: blended, or {advice}"
    return advice


def finer(scene: Scene, at_most_um: float | None = None) -> str:
    """Name what makes the grid of a scene finer, down to a spacing [um] where it is known."""
    return finer_heights(isinstance(scene.surface, MadeSurface), at_most_um)


def finer_heights(is_made: bool, at_most_um: float | None = None) -> str:
    """Name what makes a grid finer, down to a spacing [um] where it is known.

    Made heights have a key for it, and a file needs a finer measurement.
    """
    if is_made:
        if at_most_um is None:
            return "a smaller surface.spacing_um"
        return f"a surface.spacing_um of at most {rounded_down(at_most_um)}"
    if at_most_um is None:
        return "a finer measurement"
    return f"a measurement with a spacing of at most {rounded_down(at_most_um)} um"


def spacing(scene: Scene, error: float, goal: float) -> float:
    """Return the spacing [um] that brings an error of the grid [dB] down to a goal [dB]."""
    factor = 10 ** ((goal - error) / grid_error.PER_SPACING_DB)
    return fitting_spacing(scene, scene.spacing_um * factor)


def fitting_spacing(scene: Scene, spacing_um: float) -> float:
    """Return the largest spacing [um] of few digits up to a limit that fits the scene's width."""
    if not isinstance(scene.surface, MadeSurface):
        return float(f"{math.floor(spacing_um * 100) / 100 or spacing_um:.2g}")
    width = scene.surface.width_um
    least = math.ceil(width / spacing_um - 1e-9)
    # Among millions of nodes no spacing of few digits need fit, and the search would take seconds.
    for nodes in range(least, min(2 * least, least + MAX_TRIED)):
        spacing = float(f"{width / nodes:.3g}")
        if abs(width / spacing - nodes) <= 1e-7 * nodes:
            return spacing
    return width / least


# ---- steps and record


def _nyquist(scene: Scene) -> Iterator[Finding | Doubt]:
    """Judge the Nyquist frequency of the steps against the end of hearing.

    At a varying speed the share of the record with a short band counts.
    """
    motion = scene.motion
    duration = scene.duration
    step = scene.track.step
    slowest = motion.slowest(duration)
    fastest = motion.fastest(duration)
    low_hz = slowest / (2 * step)
    high_hz = fastest / (2 * step)
    name = "simulated Nyquist"
    hearing = si(HEARING[1], "Hz")
    wanted_speed = 2 * HEARING[1] * step
    step_um = motion.usual_speed(duration) / (2 * HEARING[1]) * 1e6
    if motion.is_constant(duration):
        yield Finding("nyquist", name, si(high_hz, "Hz"))
        if fastest < wanted_speed:
            yield Doubt(
                "nyquist",
                f"{name}: the simulated band ends at {si(high_hz, 'Hz')} at {fastest:g} m/s, "
                f"hearing at {hearing}",
                Severity.INDICATIVE,
                advice=f"choose a step of at most {rounded_down(step_um)} um or a speed of at "
                f"least {rounded_up(wanted_speed)} m/s",
            )
        return
    yield Finding("nyquist", name, f"{si(low_hz, 'Hz')} to {si(high_hz, 'Hz')}")
    seconds = motion.time_below(wanted_speed, duration)
    if seconds >= MIN_SHARE * duration:
        yield Doubt(
            "nyquist",
            f"{name}: for {rounded(100 * seconds / duration, 3)} % of the record "
            f"({si(seconds, 's')}) the simulated band ends below {hearing}, at "
            f"{si(low_hz, 'Hz')} at the slowest",
            Severity.INDICATIVE,
            advice="the bands above hold the sound of the faster stretches alone; choose a step of "
            f"at most {rounded_down(step_um)} um or a speed of at least "
            f"{rounded_up(wanted_speed)} m/s for {100 - 100 * MIN_SHARE:g} % of the record",
        )


def _grid_tone(scene: Scene) -> Iterator[Finding | Doubt]:
    """Name the tone of the grid that steps below a node make audible."""
    if scene.step_nodes >= 1:
        return
    motion = scene.motion
    duration = scene.duration
    tone = si(motion.slowest(duration) / scene.spacing, "Hz")
    if not motion.is_constant(duration):
        tone = f"{tone} to {si(motion.fastest(duration) / scene.spacing, 'Hz')}"
    yield Finding("grid_tone", "tone of the grid", tone)
    if motion.time_below(HEARING[1] * scene.spacing, duration) >= MIN_SHARE * duration:
        spacing_um = motion.usual_speed(duration) / HEARING[1] * 1e6
        yield Doubt(
            "grid_tone",
            f"tone of the grid: steps below one node sound a tone of the grid at {tone}",
            Severity.INDICATIVE,
            advice=f"choose numerics.step_nodes 1 or {finer(scene, spacing_um)}",
        )


def contact_radius(scene: Scene) -> float:
    """Return the larger of the elastic and the fully plastic reach [m] of a smooth contact."""
    return contact_radius_m(smooth_contact_of(scene), scene.hardness)


def lost_release(radii: float) -> float:
    """Estimate the share of the mean release that steps of so many contact radii lose."""
    return float(np.interp(radii, _RADII, _LOST))


def _step_length(scene: Scene) -> Iterator[Finding | Doubt]:
    """Compare the step with the contact, and state the error of a long step."""
    radius = contact_radius(scene)
    radii = scene.track.step / radius
    name = "step / contact radius"
    yield Finding("step_length", name, rounded(radii))
    if radii > DOUBTFUL_RADII:
        level_db = LEVEL_ERROR_DB * scene.track.step / radius
        yield sized(
            "step_length",
            f"{name}: a step is {rounded(radii)} contact radii of {si(radius, 'm')}, at most "
            f"{DOUBTFUL_RADII:g} are wanted",
            level_db,
            f"the mean release is up to about {rounded(100 * lost_release(radii))} % low, levels "
            f"are off by up to {rounded(level_db)} dB; choose a step of at most "
            f"{rounded_down(DOUBTFUL_RADII * radius * 1e6)} um",
        )


def record(scene: Scene) -> Iterator[Finding]:
    """Count the third octaves whose level the length of the record makes certain within 2 dB."""
    certain = bands.reliable(scene.duration)
    value = f"{certain.sum()} of {len(certain)}"
    if not certain.all():
        lowest = [name for name, sure in zip(bands.BAND_NAMES, certain, strict=True) if sure][:1]
        value += f", from {lowest[0]} Hz on" if lowest else ", the record is very short"
    yield Finding("third_octaves", "third octaves within 2 dB", value)
