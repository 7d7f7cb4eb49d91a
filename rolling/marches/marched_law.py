"""Force law of a run: the loads of its marches, the law, its error, and the load that moves.

A law needs marches at several loads, since contact without memory has a force for each place and
approach. The loads depend on the scene alone. The motion over the law gives the force at each
position of a lap. A march under this force gives the release under the moving load.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TypeVar

import numpy as np

from acoustics.arrays import Array
from rolling.contact import closed_forms
from rolling.contact.solver import ContactError
from rolling.dynamics import drop
from rolling.dynamics.force_law import HIGHEST, LOWEST, MIN_SLOPE, ForceLaw
from rolling.dynamics.motion import BodyMotion
from rolling.dynamics.motion_of_ball import motion_of_ball
from rolling.in_si.physics_of_scene import bodies_of, smooth_contact_of
from rolling.marches.piece import Piece
from rolling.marches.result import (
    LoadMarches,
    MotionOverLaw,
    MovingRelease,
    Result,
    vibration_key,
)
from rolling.scene.scene import Scene

JUDGED_STEPS = 200  # maximum length of the stretch that is marched at loads between the others
NEAR = 8.0  # ratio of a load to the scene's up to which neighbours have the ratio of the scene
WIDE = 2.0  # minimum ratio of neighbours that are farther away

Value = TypeVar("Value")


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
    assert result.is_complete
    marches = result.load_marches or LoadMarches(result.solved_steps)
    loads = [scene.load]
    wanted = set[float]()
    further = _first_loads(scene)
    while further:
        wanted.update(further)
        lacking = [load for load in further if load != scene.load and marches.missing(load)]
        if lacking:
            return Loads(loads, lacking, wanted)
        failures = wanted & marches.failures.keys()  # another run of the march may have more
        loads = sorted({*loads, *further} - failures)
        least, most = _force_extremes(scene, result, loads)
        further = _loads_beyond(scene, loads, failures, least, most)
    return Loads(loads, [], wanted)


def first_law_pieces(scene: Scene, result: Result) -> list[Piece]:
    """Return the pieces at the loads that the force law of a run needs in any case."""
    loads = [load for load in _first_loads(scene) if load != scene.load]
    return _load_pieces(scene, result, loads)


def law_pieces(scene: Scene, result: Result) -> list[Piece]:
    """Return the pieces at other loads that the force law of a complete run lacks now."""
    loads = law_loads(scene, result)
    if loads.lacking:
        return _load_pieces(scene, result, loads.lacking)
    return _judging_pieces(scene, result, loads.marched)


def _load_pieces(scene: Scene, result: Result, loads: Sequence[float]) -> list[Piece]:
    """Return the pieces that a run lacks at some loads [N]."""
    marches = result.load_marches or LoadMarches(result.solved_steps)
    return [
        Piece(scene, result.identity, "load", first, last, load=load, sunk=result.sunk)
        for load in loads
        for first, last in marches.missing(load)
    ]


def _judging_pieces(scene: Scene, result: Result, loads: Sequence[float]) -> list[Piece]:
    """Return the pieces that a run lacks to judge its law over some loads [N]."""
    last = min(JUDGED_STEPS, result.solved_steps)
    marches = result.load_marches or LoadMarches(result.solved_steps)
    known = {*marches.judging, *marches.failures}
    return [
        Piece(scene, result.identity, "judge", 0, last, load=load, sunk=result.sunk)
        for load in _judging_loads(scene, result, loads)
        if load not in known
    ]


def own_marches(scene: Scene, result: Result) -> LoadMarches | None:
    """Return the marches that the force law of a run needs, without those of another run."""
    marches = result.load_marches
    if scene.dynamics is None or marches is None:
        return None
    loads = law_loads(scene, result)
    judging = set(_judging_loads(scene, result, loads.marched))
    return replace(
        marches,
        approach=_of_loads(marches.approach, loads.wanted),
        judging=_of_loads(marches.judging, judging),
        failures=_of_loads(marches.failures, loads.wanted | judging),
    )


def _of_loads(by_load: dict[float, Value], loads: Container[float]) -> dict[float, Value]:
    """Return the values of some loads [N]."""
    return {load: value for load, value in by_load.items() if load in loads}


def _judging_loads(scene: Scene, result: Result, loads: Sequence[float]) -> list[float]:
    """Return the loads [N] whose marches judge a law: between its loads, and the largest force."""
    return [*_loads_between(loads), *_largest_force_beyond(scene, result, loads)]


def _first_loads(scene: Scene) -> list[float]:
    """Return the loads [N] that a scene asks for, the scene's own in the middle."""
    assert scene.dynamics is not None
    half = scene.dynamics.loads // 2
    lighter = [scene.load * scene.dynamics.span**power for power in range(-half, 0)]
    heavier = [scene.load * scene.dynamics.span**power for power in range(1, half + 1)]
    return [*lighter, scene.load, *heavier]


def _neighbouring_loads(scene: Scene, sign: int) -> Iterator[float]:
    """Yield loads [N] above (1) or below (-1) the scene's: by the span, and far from it wider."""
    assert scene.dynamics is not None
    if not scene.keeps_its_load:
        yield from drop.loads(bodies_of(scene), sign)
        return
    span = scene.dynamics.span
    ratio = 1.0
    power = sign
    while max(span**power, span**-power) <= NEAR:
        ratio = span**power
        yield scene.load * ratio
        power += sign
    wide = max(span, WIDE) ** sign
    ratio *= wide
    while LOWEST <= ratio <= HIGHEST:
        yield scene.load * ratio
        ratio *= wide


def _force_extremes(scene: Scene, result: Result, loads: Sequence[float]) -> tuple[float, float]:
    """Return minimum and maximum force [N] over a law, from one motion for each law."""
    key = vibration_key(scene), tuple(loads)
    if key not in result.extremes:
        force = _motion_over(scene, result, loads).force_n
        result.extremes[key] = float(force.min()), float(force.max())
    return result.extremes[key]


def _motion_over(scene: Scene, result: Result, loads: Sequence[float]) -> BodyMotion:
    """Return the motion over a law, which the result keeps until the next."""
    key = vibration_key(scene), tuple(loads)
    if result.motion is None or result.motion.key != key:
        motion = motion_of_ball(bodies_of(scene), scene.travel, law_over(scene, result, loads))
        result.motion = MotionOverLaw(key, motion)
    return result.motion.motion


def law_motion(scene: Scene, result: Result) -> BodyMotion:
    """Return the motion over the force law of a run whose marches are there."""
    return _motion_over(scene, result, law_loads(scene, result).marched)


def _loads_beyond(
    scene: Scene, loads: Sequence[float], failures: Container[float], least: float, most: float
) -> list[float]:
    """Return loads beyond the given ones up to the extremes of the force [N], or to a failure."""
    further = []
    for sign, extreme in ((1, most), (-1, least)):
        inner = scene.load
        for load in _neighbouring_loads(scene, sign):
            is_enough = sign * (extreme - inner) <= 0
            if is_enough or load in failures:
                break
            if load not in loads:
                further.append(load)
            inner = load
    return further


def _largest_force_beyond(scene: Scene, result: Result, loads: Sequence[float]) -> list[float]:
    """Return the largest force [N], in two digits, where it lies beyond the loads of a law."""
    _, most = _force_extremes(scene, result, loads)
    largest = float(f"{most:.2g}")
    if largest <= loads[-1]:
        return []
    return [largest]


def _loads_between(loads: Sequence[float]) -> list[float]:
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
    approaches = {**marches.approach, scene.load: result.series["approach"]}
    period = None
    if last is not None:
        count = last + 1
    elif scene.track.lap_steps <= result.solved_steps:  # a closed track ends where it begins
        count = result.solved_steps
        period = count * result.step
    else:
        count = result.solved_steps + 1
    rows = np.array([approaches[load] for load in loads])
    rising_loads, approach = _rising(scene, np.array(loads), rows[:, :count])
    radius = smooth_contact_of(scene).equivalent_radius_m
    try:
        return ForceLaw(
            np.arange(count, dtype=np.float64) * result.step,
            rising_loads,
            approach,
            period,
            closed_forms.hertz_approach(1.0, radius, scene.contact_modulus),
        )
    except ValueError as error:
        raise ContactError(f"{error}; take a longer track") from error


def _rising(scene: Scene, loads: Array, approach: Array) -> tuple[Array, Array]:
    """Return loads [N] and approaches [m] that rise by a share of Hertz's at least.

    The error of the solver may exceed the difference between two loads. A single load gets a
    neighbour by the contact of a smooth sphere.
    """
    slope = MIN_SLOPE
    if len(loads) == 1:
        loads = loads * [1.0, 1.01]
        approach = np.stack([approach[0], approach[0]])
        slope = 1.0
    radius = smooth_contact_of(scene).equivalent_radius_m
    hertz = [closed_forms.hertz_approach(load, radius, scene.contact_modulus) for load in loads]
    least_rises = slope * np.diff(hertz)[:, None]
    rises = np.diff(approach, axis=0)
    if np.all(rises >= least_rises):
        return loads, approach
    sums = np.cumsum(np.maximum(rises, least_rises), axis=0)
    sums = np.concatenate((np.zeros_like(sums[:1]), sums))
    own = int(np.flatnonzero(loads == scene.load)[0])
    return loads, approach[own] + sums - sums[own]


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
    if result.load_marches is None:
        return None
    judging = result.load_marches.judging
    between = [load for load in _loads_between(loads) if load in judging]
    if not between:
        return None
    steps = len(judging[between[0]]) - 1
    law = law_over(scene, result, loads, steps)
    newtons = np.array([_rms_error(law, load, judging[load], result.step) for load in between])
    ratio = float(np.max(newtons / np.abs(np.array(between) - scene.load)))
    top = None
    for load in _largest_force_beyond(scene, result, loads):
        if load in judging:
            top = _rms_error(law, load, judging[load], result.step) / load
    return LawError(
        newtons=float(newtons.max()),
        decibels=20 * math.log10(1 + ratio),
        top=top,
    )


def _rms_error(law: ForceLaw, load: float, approach: Array, step: float) -> float:
    """Return the rms error [N] of a law against a march at a load [N], from its approach [m]."""
    position = np.arange(len(approach)) * step
    departure = law.force(position, approach) - load
    return float(np.sqrt(np.mean(np.square(departure))))


# ---- moving load


def load_along(scene: Scene, result: Result) -> MovingRelease:
    """Return force and approach of the motion at each position of a lap.

    A reason stands in their place where the sphere passes a position under more than one load, or
    under none. A motion of fewer than two positions has the constant load of the scene.
    """
    key = vibration_key(scene)
    steps = result.solved_steps
    motion = law_motion(scene, result)
    is_periodic = scene.track.closed and scene.motion.is_constant(scene.duration)
    repeats = is_periodic and motion.settled
    if result.steps > steps and not repeats:
        reason = "the record passes the track more than once, and its force does not repeat"
        return MovingRelease.impossible(key, steps, reason)
    if motion.flight_share > 0:
        reason = "the sphere loses contact, and nothing is released under no load"
        return MovingRelease.impossible(key, steps, reason)
    count = round(len(motion.force_n) * steps / result.steps)
    # A sphere that rests stays at its position.
    moved = np.flatnonzero(np.diff(motion.position_m[:count], prepend=-np.inf) > 0)
    if len(moved) < 2:  # it rests, or passes the lap before its force changes
        return MovingRelease(
            key,
            force=np.full(steps + 1, scene.load),
            motion_approach=np.full(steps + 1, motion.approach_m.mean()),
        )
    places = motion.position_m[moved]
    lap = None
    if repeats:
        lap = steps * result.step
    positions = np.arange(steps + 1, dtype=float) * result.step
    force = _interpolated(positions, places, motion.force_n[moved], lap)
    approach = _interpolated(positions, places, motion.approach_m[moved], lap)
    if repeats:
        force[-1] = force[0]  # to the last digit
    if not force.min() > 0:
        return MovingRelease.impossible(key, steps, "the contact force falls to zero")
    return MovingRelease(key, force, approach)


def _interpolated(positions: Array, places: Array, values: Array, lap: float | None) -> Array:
    """Interpolate values between places [m]; they repeat after a lap [m], unless it is None."""
    from scipy.interpolate import CubicSpline  # slow to import, for motions only

    if lap is None:
        return np.asarray(CubicSpline(places, values)(positions))
    closed_places = np.append(places, places[0] + lap)
    closed_values = np.append(values, values[0])
    return np.asarray(CubicSpline(closed_places, closed_values, bc_type="periodic")(positions))
