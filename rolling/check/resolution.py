"""Resolution of heights, contact and sound: spacing, steps and length of the record.

The rule for the error that the grid leaves in the release was fitted to 36 scenes and tested on 24
others (docs/accuracy.md): 60 steps of each were marched on a grid of 2 um and on a quarter of it.
On the others it is off by 3.7 dB rms, and by 10 dB at most.

The release of a step is the mean pressure at its ends times the fall between them. It is
accurate to second order in the step, and wrong as soon as the contacts at both ends have little in
common.
"""

import math
from collections.abc import Iterator

import numpy as np

from acoustics import bands
from acoustics.numbers import rounded, si
from rolling.check import cost
from rolling.check.finding import Finding, judged, sentence, written
from rolling.dynamics.smooth_contact import semi_axes
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.sections import STEP_NODES
from rolling.scene.surfaces import MadeSurface
from rolling.scene.sweep import run_name
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
MAX_TRIED = 10_000  # numbers of nodes that a search for a spacing of few digits tries

HEARING = (bands.NOMINAL_HZ[0], bands.NOMINAL_HZ[-1])  # [Hz]
MIN_SHARE = 0.01  # share of a record; shorter stretches that are too slow for hearing are ignored

DOUBTFUL_RADII = 0.25  # step over contact radius, above which a scene gets a warning
MAX_RADII = 4.0  # step over contact radius, above which half of the release is lost

# A smooth elastic sphere, marched at 32 nodes per radius, loses these shares of the release. Rough
# and yielding contacts are wider than the radius and lose the same within 0.02, or less (twelve
# scenes, 5 to 100 N, Ra 0 to 1 um, elastic and down to 0.7 GPa).
_RADII = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0)
_LOST = (0.0, 0.0045, 0.0167, 0.0368, 0.0644, 0.1393, 0.2347, 0.3344, 0.4177, 0.5383)
# The error of the level up to the Nyquist frequency of the steps stays below this bound [dB per
# radius], which is read from the ten rough scenes among the twelve.
LEVEL_ERROR_DB = 3.0


def findings(scene: Scene) -> Iterator[Finding]:
    """Judge the step against hearing and contact, and the spacing against the heights."""
    yield _nyquist(scene)
    yield _step_length(scene)
    if scene.numerics.step_nodes < 1:
        yield _grid_tone(scene)
    yield from _spacing(scene)


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
    length, width = semi_axes(scene)
    pressure = min(scene.hardness, max(rough, scene.load / (math.pi * (length * width))))
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


def _spacing(scene: Scene) -> Iterator[Finding]:
    """Judge the spacing of a random surface by the error that it leaves."""
    error = grid_signal_db(scene)
    if error is None:
        return
    shortest = min(min(law.lengths_um) for law in scene.laws)
    nodes = shortest / scene.spacing_um
    value = f"about {error:.0f} dB of the fluctuation"
    warning = too_coarse(scene, error, "by a rule that is off by some 4 dB")
    if warning is None and error > BANDS_DB:
        fine = spacing(scene, error, BANDS_DB)
        value += f"; third octaves within 1 dB up to 16 kHz take {fine:g} um"
    yield Finding("correlation_nodes", "nodes per correlation length", rounded(nodes, 3))
    yield Finding(KEY, "error of the grid", value, warning)


def too_coarse(scene: Scene, error: float, source: str) -> str | None:
    """Warn of an error of the grid [dB] by its source; None where it is small enough.

    Check and run share this limit and its advice.
    """
    if error <= WANTED_DB - MARGIN_DB:
        return None
    numbers = {"error": error, "wanted": WANTED_DB, "margin": MARGIN_DB}
    words = {"source": source, "advice": advice(scene, error + MARGIN_DB)}
    return sentence(KEY, "warning", **numbers, **words)


def advice(scene: Scene, error: float) -> str:
    """Name the spacing that brings an error of the grid [dB] down to the wanted error.

    A file cannot choose its spacing: it needs a finer measurement.
    """
    wanted, bands = (spacing(scene, error, goal) for goal in (WANTED_DB, BANDS_DB))
    blended = ""
    may_blend = math.isfinite(scene.hardness) and not scene.is_permanent
    if may_blend and scene.numerics.edges == "sharp":
        blended = "choose numerics.edges: blended, or "
    kind = "made" if isinstance(scene.surface, MadeSurface) else "measured"
    return blended + sentence(KEY, kind, wanted=wanted, bands=bands)


def finer(scene: Scene, spacing_um: float) -> str:
    """Name the spacing [um] that is needed: of made heights a key, of a file a measurement."""
    most = written("{spacing_um:down}", spacing_um=spacing_um)
    if isinstance(scene.surface, MadeSurface):
        return f"a surface.spacing_um of at most {most}"
    return f"a measurement with a spacing of at most {most} um"


def spacing(scene: Scene, error: float, goal: float) -> float:
    """Return the spacing [um] that brings an error of the grid [dB] down to a goal [dB]."""
    factor = 10 ** ((goal - error) / PER_SPACING_DB)
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


def _nyquist(scene: Scene) -> Finding:
    """Judge the Nyquist frequency of the steps against the end of hearing.

    At a varying speed the share of the record with a short band counts.
    """
    motion, duration, step = scene.motion, scene.duration, scene.track.step
    slowest, fastest = motion.slowest(duration), motion.fastest(duration)
    low, high = slowest / (2 * step), fastest / (2 * step)
    wanted = 2 * HEARING[1] * step
    step_um = _usual_speed(scene, duration) / (2 * HEARING[1]) * 1e6
    numbers = {"hearing": HEARING[1], "step_um": step_um, "wanted": wanted}
    if motion.is_constant(duration):
        numbers |= {"end": high, "speed": fastest}
        return judged("nyquist", si(high, "Hz"), fastest < wanted, **numbers)
    seconds = motion.time_below(wanted, duration)
    numbers |= {"percent": 100 * seconds / duration, "slow": seconds, "end": low}
    doubt = "varying" if seconds >= MIN_SHARE * duration else ""
    value, share = f"{si(low, 'Hz')} to {si(high, 'Hz')}", 100 - 100 * MIN_SHARE
    return judged("nyquist", value, doubt, share=share, **numbers)


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
    ends = motion.slowest(duration), motion.fastest(duration)
    low, high = (speed / scene.spacing for speed in ends)
    tone = si(low, "Hz") if motion.is_constant(duration) else f"{si(low, 'Hz')} to {si(high, 'Hz')}"
    audible = motion.time_below(HEARING[1] * scene.spacing, duration) >= MIN_SHARE * duration
    spacing_um = _usual_speed(scene, duration) / HEARING[1] * 1e6
    return judged("grid_tone", tone, audible, tone=tone, finer=finer(scene, spacing_um))


def contact_radius(scene: Scene) -> float:
    """Return the larger of the elastic and the fully plastic reach [m] of a smooth contact."""
    plastic = math.sqrt(scene.load / (math.pi * scene.hardness))
    plastic *= math.sqrt(math.sqrt(scene.radius / scene.radius_across))
    return max(semi_axes(scene)[0], plastic)


def lost_release(radii: float) -> float:
    """Estimate the share of the mean release that steps of so many contact radii lose."""
    return float(np.interp(radii, _RADII, _LOST))


def refuse_long_steps(scene: Scene) -> None:
    """Raise SceneError for the runs of a scene with steps longer than `MAX_RADII` contact radii."""
    faults = []
    for values, run in scene.runs():
        radius = contact_radius(run)
        if run.step > MAX_RADII * radius:
            which = f" (in the run {run_name(values)} of the sweep)" if values else ""
            faults.append(f"{scene.place('numerics.step_nodes')}: {_fault(run, radius)}{which}")
    if faults:
        raise SceneError(faults)


def _fault(scene: Scene, radius: float) -> str:
    """Write the length of the steps, the longest that are allowed, and the nearest number."""
    longest = MAX_RADII * radius
    fitting = [nodes for nodes in STEP_NODES if nodes * scene.spacing <= longest]
    is_made = isinstance(scene.surface, MadeSurface)
    advice = f"a measurement with a spacing of at most {rounded(longest * 1e6, 3)} um"
    if is_made:
        advice = sentence("refused", "spacing", longest_um=longest * 1e6)
    if fitting:
        advice = (
            sentence("refused", "nodes", nodes=max(fitting)) if is_made else f"{max(fitting):g}"
        )
    numbers = {"nodes": scene.numerics.step_nodes, "step": scene.step, "longest": longest}
    numbers |= {"radii": scene.step / radius, "radius_um": radius * 1e6, "most": MAX_RADII}
    return sentence("refused", "long_steps", advice=advice, **numbers)


def _step_length(scene: Scene) -> Finding:
    """Compare the step with the contact, and state the error of a long step."""
    radius = contact_radius(scene)
    radii = scene.track.step / radius
    numbers = {"radii": radii, "radius": radius, "most": DOUBTFUL_RADII}
    numbers |= {"percent": 100 * lost_release(radii), "level_db": LEVEL_ERROR_DB * radii}
    numbers |= {"step_um": DOUBTFUL_RADII * radius * 1e6}
    return judged("step_length", rounded(radii), radii > DOUBTFUL_RADII, **numbers)


def record(scene: Scene) -> Iterator[Finding]:
    """Count the third octaves whose level the length of the record makes certain within 2 dB."""
    certain = bands.reliable(scene.duration)
    value = f"{certain.sum()} of {len(certain)}"
    if not certain.all():
        lowest = [name for name, sure in zip(bands.BAND_NAMES, certain, strict=True) if sure][:1]
        value += f", from {lowest[0]} Hz on" if lowest else ", the record is very short"
    yield Finding("third_octaves", "third octaves within 2 dB", value)
