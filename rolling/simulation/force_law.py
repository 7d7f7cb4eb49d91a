"""Force law of a run: the loads of its marches, the marches, and the law's error.

A law needs marches at several loads, since contact without memory has a force for each place and
approach. Loads and pieces depend on the scenes alone, so the law is equal for any number of
workers. Runs that share their march share the law.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from rolling._typing import Array
from rolling.contact.march import march
from rolling.contact.of_scene import rolling_contact
from rolling.contact.solver import ContactError
from rolling.dynamics.force_law import HIGHEST, LOWEST, ForceLaw
from rolling.scene.scene import Scene
from rolling.simulation import pool, simulate
from rolling.simulation.load_marches import LoadMarches, LoadPiece
from rolling.simulation.moving_load import moving_key
from rolling.simulation.result import Result

JUDGED_STEPS = 200  # maximum length of the stretch that is marched at loads between the others


def first_loads(scene: Scene) -> list[float]:
    """Return the loads [N] that a scene asks for, the scene's own in the middle."""
    assert scene.dynamics is not None
    half = scene.dynamics.loads // 2
    return [_load(scene, power) for power in range(-half, half + 1)]


def _load(scene: Scene, power: int) -> float:
    """Return the scene's load times a power of the span [N]."""
    assert scene.dynamics is not None
    return scene.load if power == 0 else scene.load * scene.dynamics.span**power


def is_missing(scene: Scene, result: Result) -> bool:
    """Return whether a scene asks for a force law that is not complete."""
    if scene.dynamics is None:
        return False
    marches = result.load_marches
    return (
        marches is None
        or not marches.complete
        or bool(_unmarched(first_loads(scene), scene.load, result))
    )


def _unmarched(loads: Sequence[float], own: float, result: Result) -> list[tuple[float, int, int]]:
    """Return load, first and last position of the pieces that lack, except the own load [N]."""
    known = result.load_marches.approach if result.load_marches else {}
    todo = []
    for load in loads:
        if load == own:
            continue
        approach = known.get(load)
        for first, last in simulate.pieces(result.solved_steps):
            if approach is None or np.isnan(approach[first + 1 : last + 1]).any():
                todo.append((load, first, last))
    return todo


# ---- the law


Extremes = Callable[[Scene, ForceLaw], tuple[float, float]]


@dataclass(frozen=True)
class Loads:
    """The loads of a run's force law.

    A run takes no more of the marches than it needs itself, so that its numbers do not depend on
    the runs that it shares them with.

    marched : list of float, N. The loads in ascending order.
    lacking : list of float, N. Loads beyond them that the force reaches, but are not marched.
    """

    marched: list[float]
    lacking: list[float]


def loads_of(scene: Scene, result: Result, extremes: Extremes) -> Loads:
    """Return the loads that a run needs, up to the extremes of its contact force.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    result : Result. A complete result with the marches that the scene asks for.
    extremes : callable. It returns minimum and maximum force [N] of the scene over a law.

    Raises
    ------
    ContactError : a force law or a motion is not possible.
    """
    marches = result.load_marches
    known = (
        {load for load, a in marches.approach.items() if not np.isnan(a).any()} if marches else ()
    )
    loads = first_loads(scene)
    while further := _beyond(scene, loads, *_extremes_of(scene, result, loads, extremes)):
        marched = [load for load in further if load in known]
        lacking = [load for load in further if load not in known]
        if lacking and not marched:
            return Loads(loads, lacking)
        loads = sorted([*loads, *marched])
    return Loads(loads, [])


def _extremes_of(
    scene: Scene, result: Result, loads: Sequence[float], extremes: Extremes
) -> tuple[float, float]:
    """Return minimum and maximum force [N] over a law, from one motion for each law."""
    marches, key = result.load_marches, (moving_key(scene), tuple(loads))
    assert marches is not None
    if key not in marches.extremes:
        marches.extremes[key] = extremes(scene, force_law(scene, result, loads))
    return marches.extremes[key]


def _beyond(scene: Scene, loads: Sequence[float], least: float, most: float) -> list[float]:
    """Return loads beyond the given ones up to the extremes of the force [N]."""
    further = []
    for sign, wanted, limit in ((1, most, HIGHEST), (-1, least, LOWEST)):
        for k in range(1, 100):
            load = _load(scene, sign * k)
            if sign * (wanted - _load(scene, sign * (k - 1))) <= 0:
                break
            if sign * (load - scene.load * limit) > 0:
                break
            if load not in loads:
                further.append(load)
    return further


def force_law(
    scene: Scene, result: Result, loads: Sequence[float], last: int | None = None
) -> ForceLaw:
    """Return the force law of a run from its marches at some loads.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    result : Result. The result with the marches.
    loads : sequence of float, N. Ascending loads.
    last : int. Last position of the law. Default: that of the track.

    Raises
    ------
    ContactError : the approach does not rise with the load everywhere.
    """
    marches = result.load_marches
    assert marches is not None
    # The last position of a closed track is its first.
    closed = last is None and scene.track.lap_steps <= result.solved_steps
    count = result.solved_steps + (not closed) if last is None else last + 1
    own = result.series["approach"]
    rows = [own if load == scene.load else marches.approach[load] for load in loads]
    position = np.arange(count, dtype=np.float64) * result.step
    period = count * result.step if closed else None
    try:
        return ForceLaw(position, np.array(loads), np.array(rows)[:, :count], period)
    except ValueError as error:
        raise ContactError(
            f"{error}: the solver's error is larger than the difference between two loads; take a"
            " larger dynamics.span or a smaller numerics.tolerance"
        ) from error


@dataclass(frozen=True)
class LawError:
    """The error of a force law halfway between its loads.

    newtons : float, N. Rms error of the force along a stretch, the maximum over the loads.
    decibels : float, dB. The error of a level of the force that it makes where the force departs
        from a marched load as far as this load does.
    """

    newtons: float
    decibels: float


def law_error(scene: Scene, result: Result, loads: Sequence[float]) -> LawError | None:
    """Compare a law over some loads with marches between them; None where there are none."""
    marches = result.load_marches
    between = [each for each in _between(loads) if marches and each in marches.judging]
    if marches is None or not between:
        return None
    steps = len(marches.judging[between[0]]) - 1
    law = force_law(scene, result, loads, steps)
    position = np.arange(steps + 1) * result.step
    newtons, ratios = [], []
    for load in between:
        error = float(
            np.sqrt(np.mean(np.square(law.force(position, marches.judging[load]) - load)))
        )
        newtons.append(error)
        ratios.append(error / float(np.abs(np.array(loads) - load).min()))
    return LawError(max(newtons), 20 * math.log10(1 + max(ratios)))


# ---- marching


def tasks(
    scenes: Sequence[Scene],
    result: Result,
    run: int,
    step_seconds: float,
    extremes: Extremes,
) -> list[pool.Task]:
    """Return the marches that the runs of a shared result need next, as tasks of one run.

    Parameters
    ----------
    scenes : sequence of Scene. The scenes of all runs that share the result.
    result : Result. The shared result.
    run : int. Number of the run that the tasks belong to.
    step_seconds : float, s. Expected time of a step.
    extremes : callable. It returns minimum and maximum force [N] of a scene over a law.

    Raises
    ------
    ContactError : a force law or a motion is not possible.
    """
    vibrating = [scene for scene in scenes if scene.dynamics is not None]
    if not vibrating:
        return []
    if result.load_marches is None:
        result.load_marches = LoadMarches(result.solved_steps)
    marches = result.load_marches
    order = simulate.Order.of(result.identity, step_seconds)

    def task(load: float, first: int, last: int, judging: bool, may_fail: bool) -> pool.Task:
        cost = (last - first) * step_seconds
        arguments = (vibrating[0], load, first, last, order, judging, may_fail)
        return pool.Task(run, march_load, arguments, cost)

    own = vibrating[0].load
    needed = list(dict.fromkeys(load for scene in vibrating for load in first_loads(scene)))
    begun = [load for load in marches.approach if load not in needed]
    if todo := [*_unmarched(needed, own, result)]:
        return [task(*each, False, False) for each in todo]
    if todo := _unmarched(begun, own, result):
        return [task(*each, False, True) for each in todo]
    if not result.complete or marches.complete:
        return []
    loads = [loads_of(scene, result, extremes) for scene in vibrating]
    further = list(dict.fromkeys(load for each in loads for load in each.lacking))
    if further and not marches.fault:
        return [task(*each, False, True) for each in _unmarched(further, own, result)]
    between = list(dict.fromkeys(load for each in loads for load in _between(each.marched)))
    judged = [load for load in between if load not in marches.judging]
    last = min(JUDGED_STEPS, result.solved_steps)
    if judged and not marches.fault:
        return [task(load, 0, last, True, True) for load in judged]
    marches.complete = True
    return []


def _between(loads: Sequence[float]) -> list[float]:
    """Return the geometric means of neighbouring loads [N]."""
    return [math.sqrt(low * high) for low, high in pairwise(loads)]


def march_load(
    scene: Scene,
    load: float,
    first: int,
    last: int,
    order: simulate.Order,
    judging: bool,
    may_fail: bool,
    stopped: Callable[[], bool],
    progress: Callable[[float], object],
) -> LoadPiece:
    """March a piece of the track at another load.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    load : float, N. The load.
    first, last : int. Positions between which the piece lies.
    order : Order. Progress of a step, and the surface.
    judging : bool. Whether the march judges the force law.
    may_fail : bool. Whether a contact that cannot be solved is a fault of the march alone.
    stopped, progress : callable. As in `simulate.simulate_piece`.

    Raises
    ------
    ContactError : the heights were replaced or removed, or the contact cannot be solved.
    Interrupted : `stopped` returned true.
    """
    simulate.refuse_other_surface(scene, order.surface_sha256)
    began = time.perf_counter()
    contact = replace(rolling_contact(scene), load=load)
    half_space = simulate.half_space(contact.spacing, contact.contact_modulus, contact.subcells)
    approach: list[float] = []
    try:
        for state in march(contact, first, last, half_space):
            if stopped():
                raise pool.Interrupted
            if state.position > first:
                progress(order.step_cost)
            if state.position > first or first == 0:
                approach.append(state.approach)
    except ContactError as error:
        if not may_fail:
            raise ContactError(f"force law at {load:.4g} N: {error}") from error
        return LoadPiece(load, first, last, np.empty(0), 0.0, judging, f"{load:.4g} N: {error}")
    seconds = time.perf_counter() - began
    values: Array = np.array(approach)
    return LoadPiece(load, first, last, values, seconds, judging)
