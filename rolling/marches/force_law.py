"""Force law of a run: the loads of its marches, the law, its error, and the load that moves.

A law needs marches at several loads, since contact without memory has a force for each place and
approach. The loads depend on the scene alone. The motion over the law gives the force at each
position of a lap. A march under this force gives the release under the moving load.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from acoustics.arrays import Array
from rolling.contact import closed_forms
from rolling.contact.solver import ContactError
from rolling.dynamics import drop, of_scene
from rolling.dynamics.force_law import HIGHEST, LOWEST, MIN_SLOPE, ForceLaw
from rolling.dynamics.motion import BodyMotion
from rolling.dynamics.smooth_contact import equivalent_radius
from rolling.marches.piece import Piece
from rolling.marches.result import LoadMarches, MovingRelease, Result, vibration_key
from rolling.scene.scene import Scene

JUDGED_STEPS = 200  # maximum length of the stretch that is marched at loads between the others

NEAR, WIDE = 8.0, 2.0  # farther from the scene's load neighbours have this ratio at least


@dataclass(frozen=True)
class Loads:
    """Loads [N] of a force law.

    marched : list of float, N. The loads in ascending order.
    lacking : list of float, N. Loads beyond them that the force reaches and that lack pieces.
    wanted : set of float, N. All loads that the force reached, with the loads that failed.
    """

    marched: list[float]
    lacking: list[float]
    wanted: set[float]


def law_loads(scene: Scene, result: Result) -> Loads:
    """Return the loads of a run's force law, up to the extremes of its contact force.

    Loads are added in batches, each up to the extremes over the law before. None follows beyond a
    load that failed. Raise ContactError where a motion is not possible.
    """
    assert result.complete
    marches = result.load_marches or LoadMarches(result.solved_steps)
    wanted, further, loads = set[float](), _first_loads(scene), [scene.load]
    while further:
        wanted.update(further)
        if lacking := [load for load in further if load != scene.load and marches.missing(load)]:
            return Loads(loads, lacking, wanted)
        faults = wanted & marches.faults.keys()  # another run of the march may have more
        loads = sorted({*loads, *further} - faults)
        further = _beyond(scene, loads, faults, *_extremes(scene, result, loads))
    return Loads(loads, [], wanted)


def law_pieces(scene: Scene, result: Result, piece: Callable[..., Piece]) -> list[Piece]:
    """Return the pieces at other loads that the force law of a run lacks now.

    `piece` makes a piece from its kind, first and last position and load [N].
    """
    marches = result.load_marches or LoadMarches(result.solved_steps)
    if not result.complete:
        lacking = [load for load in _first_loads(scene) if load != scene.load]
    else:
        loads = law_loads(scene, result)
        lacking = loads.lacking
        if not lacking:
            last = min(JUDGED_STEPS, result.solved_steps)
            known = {*marches.judging, *marches.faults}
            judged = [load for load in _judged(scene, result, loads.marched) if load not in known]
            return [piece("judge", 0, last, load=load) for load in judged]
    missing = ((load, *ends) for load in lacking for ends in marches.missing(load))
    return [piece("load", first, last, load=load) for load, first, last in missing]


def own_marches(scene: Scene, result: Result) -> LoadMarches | None:
    """Return the marches that the force law of a run needs, without those of another run."""
    marches = result.load_marches
    if scene.dynamics is None or marches is None:
        return None
    loads = law_loads(scene, result)
    judged = set(_judged(scene, result, loads.marched))
    return replace(
        marches,
        approach={load: x for load, x in marches.approach.items() if load in loads.wanted},
        judging={load: x for load, x in marches.judging.items() if load in judged},
        faults={k: text for k, text in marches.faults.items() if k in loads.wanted | judged},
    )


def _judged(scene: Scene, result: Result, loads: Sequence[float]) -> list[float]:
    """Return the loads [N] whose marches judge a law: between its loads, and the largest force."""
    return [*_between(loads), *_beyond_top(scene, result, loads)]


def _first_loads(scene: Scene) -> list[float]:
    """Return the loads [N] that a scene asks for, the scene's own in the middle."""
    assert scene.dynamics is not None
    span, half = scene.dynamics.span, scene.dynamics.loads // 2
    return [scene.load * span**power if power else scene.load for power in range(-half, half + 1)]


def _ladder(scene: Scene, sign: int) -> Iterator[float]:
    """Yield loads [N] above (1) or below (-1) the scene's: by the span, and far from it wider."""
    assert scene.dynamics is not None
    if scene.rolling.drop_mm is not None:
        yield from drop.loads(scene, sign)
        return
    span, ratio, power = scene.dynamics.span, 1.0, sign
    while max(span**power, span**-power) <= NEAR:
        ratio, power = span**power, power + sign
        yield scene.load * ratio
    while LOWEST <= (ratio := ratio * max(span, WIDE) ** sign) <= HIGHEST:
        yield scene.load * ratio


def _extremes(scene: Scene, result: Result, loads: Sequence[float]) -> tuple[float, float]:
    """Return minimum and maximum force [N] over a law, from one motion for each law."""
    key = vibration_key(scene), tuple(loads)
    if key not in result.extremes:
        force = _motion(scene, result, loads).force_n
        result.extremes[key] = float(force.min()), float(force.max())
    return result.extremes[key]


def _motion(scene: Scene, result: Result, loads: Sequence[float]) -> BodyMotion:
    """Return the motion over a law, which the result keeps until the next."""
    key = vibration_key(scene), tuple(loads)
    if result.motion is None or result.motion[0] != key:
        result.motion = key, of_scene.motion(scene, law_over(scene, result, loads))
    return result.motion[1]


def law_motion(scene: Scene, result: Result) -> BodyMotion:
    """Return the motion over the force law of a run whose marches are there."""
    return _motion(scene, result, law_loads(scene, result).marched)


def _beyond(
    scene: Scene, loads: Sequence[float], faults: Container[float], least: float, most: float
) -> list[float]:
    """Return loads beyond the given ones up to the extremes of the force [N], or to a fault."""
    further = []
    for sign, wanted in ((1, most), (-1, least)):
        inner = scene.load
        for load in _ladder(scene, sign):
            if sign * (wanted - inner) <= 0 or load in faults:
                break
            if load not in loads:
                further.append(load)
            inner = load
    return further


def _beyond_top(scene: Scene, result: Result, loads: Sequence[float]) -> list[float]:
    """Return the largest force [N], in two digits, where it lies beyond the loads of a law."""
    largest = float(f"{_extremes(scene, result, loads)[1]:.2g}")
    return [largest] if largest > loads[-1] else []


def _between(loads: Sequence[float]) -> list[float]:
    """Return the geometric means of neighbouring loads [N]."""
    return [math.sqrt(low * high) for low, high in pairwise(loads)]


def force_law(scene: Scene, result: Result) -> ForceLaw:
    """Return the force law of a run whose marches are there."""
    return law_over(scene, result, law_loads(scene, result).marched)


def law_over(
    scene: Scene, result: Result, loads: Sequence[float], last: int | None = None
) -> ForceLaw:
    """Return the force law over some ascending loads [N], up to a last position or of the track."""
    marches = result.load_marches or LoadMarches(result.solved_steps)
    # The last position of a closed track is its first.
    closed = last is None and scene.track.lap_steps <= result.solved_steps
    count = result.solved_steps + (not closed) if last is None else last + 1
    own = result.series["approach"]
    rows = np.array([own if load == scene.load else marches.approach[load] for load in loads])
    position = np.arange(count, dtype=np.float64) * result.step
    period = count * result.step if closed else None
    known, approach = _rising(scene, np.array(loads), rows[:, :count])
    try:
        radius = equivalent_radius(scene)
        smooth = closed_forms.hertz_approach(1.0, radius, scene.contact_modulus)
        return ForceLaw(position, known, approach, period, smooth)
    except ValueError as error:
        raise ContactError(f"{error}; take a longer track") from error


def _rising(scene: Scene, loads: Array, approach: Array) -> tuple[Array, Array]:
    """Return loads [N] and approaches [m] that rise by a share of Hertz's at least.

    The error of the solver may exceed the difference between two loads. A single load gets a
    neighbour by the contact of a smooth sphere.
    """
    least, body = MIN_SLOPE, (equivalent_radius(scene), scene.contact_modulus)
    if len(loads) == 1:
        loads, approach, least = loads * [1.0, 1.01], np.stack([approach[0]] * 2), 1.0
    hertz = [closed_forms.hertz_approach(load, *body) for load in loads]
    lowest, rises = least * np.diff(hertz)[:, None], np.diff(approach, axis=0)
    if np.all(rises >= lowest):
        return loads, approach
    heights = np.cumsum(np.maximum(rises, lowest), axis=0)
    heights = np.concatenate((np.zeros_like(heights[:1]), heights))
    own = int(np.flatnonzero(loads == scene.load)[0])
    return loads, approach[own] + heights - heights[own]


@dataclass(frozen=True)
class LawError:
    """Error of a force law halfway between its loads, and beyond them.

    newtons : float, N. Rms error of the force along a stretch, the maximum over the loads.
    decibels : float, dB. The error of a level of the force that it makes where the force departs
        from the scene's load as far as the load of the march does.
    top : float or None. Rms error of the force over the largest force, which lies beyond the loads.
    """

    newtons: float
    decibels: float
    top: float | None = None


def law_error(scene: Scene, result: Result, loads: Sequence[float]) -> LawError | None:
    """Compare a law over some loads [N] with marches between them; None where there are none."""
    marches = result.load_marches
    between = [load for load in _between(loads) if marches and load in marches.judging]
    if marches is None or not between:
        return None
    steps = len(marches.judging[between[0]]) - 1
    law = law_over(scene, result, loads, steps)
    position = np.arange(steps + 1) * result.step

    def error(load: float) -> float:
        departure = law.force(position, marches.judging[load]) - load
        return float(np.sqrt(np.mean(np.square(departure))))

    newtons = np.array([error(load) for load in between])
    ratio = float(np.max(newtons / np.abs(np.array(between) - scene.load)))
    beyond = [load for load in _beyond_top(scene, result, loads) if load in marches.judging]
    top = error(beyond[0]) / beyond[0] if beyond else None
    return LawError(float(newtons.max()), 20 * math.log10(1 + ratio), top)


# ---- moving load


def load_along(scene: Scene, result: Result) -> MovingRelease:
    """Return force and approach of the motion at each position of a lap.

    A fault stands in their place where the sphere passes a position under more than one load, or
    under none. A motion of fewer than two positions has the constant load of the scene.
    """
    key, steps = vibration_key(scene), result.solved_steps
    motion = law_motion(scene, result)
    closed = scene.track.closed and scene.motion.is_constant(scene.duration)
    repeats = closed and motion.settled
    if result.steps > steps and not repeats:
        return MovingRelease.impossible(
            key,
            steps,
            "the record passes the track more than once, and its force does not repeat",
        )
    if motion.flight_share > 0:
        return MovingRelease.impossible(
            key,
            steps,
            "the sphere loses contact, and nothing is released under no load",
        )
    count = round(len(motion.force_n) * steps / result.steps)
    # A sphere that rests stays at its position.
    moved = np.flatnonzero(np.diff(motion.position_m[:count], prepend=-np.inf) > 0)
    if len(moved) < 2:  # it rests, or passes the lap before its force changes
        load, mean = np.full(steps + 1, scene.load), motion.approach_m.mean()
        return MovingRelease(key, load, np.full(steps + 1, mean))
    places = motion.position_m[moved]
    lap = steps * result.step if repeats else None
    positions = np.arange(steps + 1, dtype=float) * result.step
    force = _at(positions, places, motion.force_n[moved], lap)
    approach = _at(positions, places, motion.approach_m[moved], lap)
    if repeats:
        force[-1] = force[0]  # to the last digit
    if not force.min() > 0:
        return MovingRelease.impossible(key, steps, "the contact force falls to zero")
    return MovingRelease(key, force, approach)


def _at(positions: Array, places: Array, values: Array, lap: float | None) -> Array:
    """Interpolate values between places [m]; they repeat after a lap [m], unless it is None."""
    from scipy.interpolate import CubicSpline  # slow to import, for motions only

    if lap is None:
        return np.asarray(CubicSpline(places, values)(positions))
    around, again = np.append(places, places[0] + lap), np.append(values, values[0])
    return np.asarray(CubicSpline(around, again, bc_type="periodic")(positions))
