"""Stretches of track for the error estimate of a run, and their cost.

The cost is counted in steps of the run. It is a function of the scene alone, so that the stretches
do not depend on the speed of a machine.
"""

import math
from dataclasses import dataclass, replace

from rolling.check import cost
from rolling.in_si.scene_surface import has_detail, scene_surface
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile

SHARE = 0.25  # maximum cost of the estimate over the cost of the run
# Expected time [s] of one core up to which the estimate is marched whatever its share of the run.
# It decides only whether a short track has the shortest stretches or none. Their places and lengths
# do not follow from it, so that a new measurement of the time of a step leaves them as they are.
ALLOWED_SECONDS = 20.0
# Four stretches give a standard error; more than eight hardly lower it, because longer tracks have
# longer stretches first.
MIN_STRETCHES = 4
MAX_STRETCHES = 8
MIN_STEPS = 64  # of a stretch
MAX_STEPS = 400
# Steps that a cold start costs beside its own: 6.5 on the run's grid and 7.7 at half the spacing,
# the mean of ten scenes at three to five places (3 at Ra 0.01 um and 20 N, 12 to 15 at Ra 1 um).
COLD_STEPS = 7
TIGHTER = 10.0  # the scene's tolerance over the tight tolerance
MIN_TOLERANCE = 1e-10  # rounding does not let a solve come closer
# The cost of a step, as it is counted here, grows with this power of the nodes along a side. It
# does not follow `cost.STEP_LAWS`, whose powers are 1.45 to 2.3: when they are measured anew, the
# stretches of a scene, and all numbers that follow from them, have to stay.
COST_POWER = 1.95
LEVELS = ("tight", "fine", "coarse")  # marches of a stretch, beside the run itself
# The level of half the spacing with the detail of the surface's law. It is not paid from the share,
# which would shorten all stretches.
DETAIL = "detail"
DETAILED = 4  # stretches that are marched on it
# Levels of a measured surface: with the law of its spectrum below the cut-off of the instrument,
# and, at half the spacing, as it was measured.
WITH_LAW = "with_law"
MEASURED = "measured"
# Spacings of the shortest wave of the instrument, from which the scene's own grid holds enough of
# the waves that are missing. A finer instrument needs half the spacing.
MIN_CUTOFF_NODES = 3.0
INSTRUMENT_STRETCHES = 4
# Steps of the run over those of a stretch of the instrument, at least, on the own and a finer grid.
INSTRUMENT_SHARE = 4
INSTRUMENT_FINE_SHARE = 6


@dataclass(frozen=True)
class Layout:
    """Stretches of a track, evenly spaced.

    steps : int. Number of steps of a stretch.
    firsts : tuple of int. First position of each stretch.
    marches : list of (int, str). First position and level of each march.
    """

    steps: int
    firsts: tuple[int, ...]
    marches: list[tuple[int, str]]


def tight_tolerance(scene: Scene) -> float:
    """Return the tolerance against which the tolerance of a scene is judged."""
    own = scene.tolerance
    return min(own, max(own / TIGHTER, MIN_TOLERANCE))


def level_cost(scene: Scene, level: str, power: float = COST_POWER) -> float:
    """Return the expected cost of a step on a level, in steps of the run.

    It grows with a power of the nodes along a side.
    """
    if level == "coarse":  # at twice the spacing and the scene's own tolerance
        return math.pow(2.0, -power)
    if level in (WITH_LAW, MEASURED) and not needs_finer_grid(scene):
        return 1.0
    if level in (DETAIL, WITH_LAW, MEASURED):  # at half the spacing and the scene's own tolerance
        return math.pow(2.0, power)
    # The number of iterations is proportional to the logarithm of the tolerance.
    tighter = math.log(tight_tolerance(scene)) / math.log(scene.tolerance)
    if level == "fine":
        return tighter * math.pow(2.0, power)
    return tighter


def marched_steps(scene: Scene) -> int:
    """Return the number of steps that a run marches: those of its track, at each of its loads."""
    loads = 1 if scene.dynamics is None else scene.dynamics.loads
    return loads * scene.track.solved_steps


def layout(scene: Scene) -> Layout | None:
    """Return the stretches that the estimate of a scene asks for, or None.

    Longer tracks have longer stretches first, then more of them. A track that is too short to pay
    for them has the fewest and shortest stretches, if these take few seconds.
    """
    if not scene.numerics.error_estimate or scene.is_smooth:
        return None
    solved = scene.track.solved_steps
    # Steps and cold starts of all stretches.
    paid = SHARE * marched_steps(scene) / _step_cost(scene)
    steps = int(min(paid / MIN_STRETCHES - COLD_STEPS, solved / MIN_STRETCHES, MAX_STEPS))
    if steps < MIN_STEPS:
        steps = MIN_STEPS
        paid = MIN_STRETCHES * (steps + COLD_STEPS)
        if solved < MIN_STRETCHES * steps or shortest_seconds(scene) > ALLOWED_SECONDS:
            return None
    slots = solved // steps
    count = min(MAX_STRETCHES, slots, int(paid / (steps + COLD_STEPS) + 1e-9))
    firsts = tuple(k * slots // count * steps for k in range(count))
    marches = [(first, level) for first in firsts for level in LEVELS]
    if has_detail(scene):
        marches += [(first, DETAIL) for first in firsts[:: max(1, count // DETAILED)][:DETAILED]]
    return Layout(steps, firsts, marches)


def needs_finer_grid(scene: Scene) -> bool:
    """Return whether the waves that an instrument does not see are too short for the own grid."""
    seen = scene_surface(scene).seen
    return seen is not None and seen.cutoff < MIN_CUTOFF_NODES * scene.spacing


def instrument_layout(scene: Scene) -> Layout | None:
    """Return the stretches that tell what the instrument of a measurement leaves uncertain.

    They are those of the error estimate, if the scene asks for it. It is None without an
    instrument, without a law, on a plate that remembers, under a sphere with a surface of its own,
    whose short waves are not those of the file, and on a track that is too short.
    """
    if not has_instrument(scene) or scene.is_permanent or scene.sphere.surface is not None:
        return None
    seen = scene_surface(scene).seen
    if seen is None or seen.law is None:
        return None
    estimate = layout(scene)
    if estimate is None:
        solved = scene.track.solved_steps
        share = INSTRUMENT_FINE_SHARE if needs_finer_grid(scene) else INSTRUMENT_SHARE
        steps = min(max(solved // share, MIN_STEPS), MAX_STEPS)
        slots = solved // steps
        if slots < INSTRUMENT_STRETCHES:
            return None
        firsts = tuple(
            k * slots // INSTRUMENT_STRETCHES * steps for k in range(INSTRUMENT_STRETCHES)
        )
    else:
        steps = estimate.steps
        every = max(1, len(estimate.firsts) // INSTRUMENT_STRETCHES)
        firsts = estimate.firsts[::every][:INSTRUMENT_STRETCHES]
    levels = [WITH_LAW]
    if needs_finer_grid(scene):
        levels.append(MEASURED)
    return Layout(steps, firsts, [(first, level) for first in firsts for level in levels])


def has_instrument(scene: Scene) -> bool:
    """Return whether a scene states the instrument of its measurement."""
    surface = scene.surface
    return isinstance(surface, HeightFile) and surface.instrument is not None


def marches(scene: Scene) -> Layout | None:
    """Return all marches of stretches of a scene, those of estimate and instrument together."""
    estimate = layout(scene)
    instrument = instrument_layout(scene)
    if estimate is None or instrument is None:
        return estimate or instrument
    return replace(estimate, marches=estimate.marches + instrument.marches)


def instrument_seconds(scene: Scene) -> float:
    """Return the expected time [s] of the stretches of the instrument on one core; 0 without."""
    stretches = instrument_layout(scene)
    if stretches is None:
        return 0.0
    power = cost.STEP_LAWS[cost.step_law(scene, cost.roughness(scene)[0])][1]
    per_step = sum(level_cost(scene, level, power) for _, level in stretches.marches)
    return (stretches.steps + COLD_STEPS) * per_step * cost.step_ms(scene) * 1e-3


def shortest_seconds(scene: Scene) -> float:
    """Return the expected time [s] on one core of the fewest and shortest stretches."""
    levels = [*LEVELS, DETAIL] if has_detail(scene) else [*LEVELS]
    power = cost.STEP_LAWS[cost.step_law(scene, cost.roughness(scene)[0])][1]
    per_step = sum(level_cost(scene, level, power) for level in levels)
    steps = MIN_STRETCHES * (MIN_STEPS + COLD_STEPS)
    return steps * per_step * cost.step_ms(scene) * 1e-3


def too_short(scene: Scene) -> str | None:
    """Explain that a track is too short for an estimate, or return None."""
    if scene.is_smooth or layout(scene) is not None:
        return None
    solved = scene.track.solved_steps
    fewest = MIN_STRETCHES * MIN_STEPS
    if solved < fewest:
        return f"the track has {solved} different steps, and the estimate needs {fewest}"
    least = MIN_STRETCHES * (MIN_STEPS + COLD_STEPS) * _step_cost(scene) / SHARE
    needed = math.ceil(least * solved / marched_steps(scene))
    return (
        f"it would take about {shortest_seconds(scene):.0f} s on one core, more than "
        f"{ALLOWED_SECONDS:g} s and more than {SHARE:.0%} of the run: the track has {solved} "
        f"different steps, and {needed} are needed for that share"
    )


def cost_share(scene: Scene, power: float = COST_POWER) -> float:
    """Return the cost of the estimate over the cost of the run; 0 without an estimate.

    The power of `cost.STEP_LAWS` makes it a share of time.
    """
    if (stretches := layout(scene)) is None:
        return 0.0
    per_step = sum(level_cost(scene, level, power) for _, level in stretches.marches)
    return (stretches.steps + COLD_STEPS) * per_step / marched_steps(scene)


def seconds(scene: Scene) -> float:
    """Return the expected time [s] of the estimate on one core; 0 without an estimate."""
    if layout(scene) is None:
        return 0.0
    power = cost.STEP_LAWS[cost.step_law(scene, cost.roughness(scene)[0])][1]
    return cost_share(scene, power) * marched_steps(scene) * cost.step_ms(scene) * 1e-3


def _step_cost(scene: Scene) -> float:
    """Return the cost of a step of a stretch on all levels, in steps of the run."""
    return sum(level_cost(scene, level) for level in LEVELS)
