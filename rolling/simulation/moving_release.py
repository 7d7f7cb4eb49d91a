"""Release under the moving load: one more march, with the contact force at each position.

The motion gives the force at each position of a lap. The march under it gives the release, and an
approach that must agree with that of the motion. It belongs to speed, masses and thickness, so runs
that share their other marches do not share it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from rolling._typing import Array
from rolling.contact.march import march
from rolling.contact.of_scene import rolling_contact
from rolling.contact.recovery import step_energy
from rolling.contact.solver import ContactError
from rolling.dynamics import of_scene
from rolling.scene.scene import Scene
from rolling.simulation import force_law, pool, simulate
from rolling.simulation.moving_load import MOVING_SERIES, MovingPiece, MovingRelease, moving_key
from rolling.simulation.result import Result


def moving_release(scene: Scene, result: Result) -> MovingRelease | None:
    """Return the release under the moving load of a run, or its fault; None while it is missing."""
    if not scene.moves_release:
        return None
    moving = result.moving.get(moving_key(scene))
    return moving if moving is not None and moving.complete else None


def moving_numbers(result: Result, moving: MovingRelease | None) -> dict[str, Any]:
    """Return the numbers of a release under the moving load for summary.json."""
    if moving is None or moving.fault:
        return {}
    stored = result.series["stored_energy"].max()
    return {
        "force_law_error_m": moving.law_error,
        "moving_release_balance_error": float(np.abs(moving.steps["energy_defect"]).max() / stored),
    }


def is_missing(scene: Scene, result: Result) -> bool:
    """Return whether a run asks for a release under the moving load that is not complete."""
    if not scene.moves_release:
        return False
    moving = result.moving.get(moving_key(scene))
    return moving is None or not moving.complete


def load_along(scene: Scene, result: Result) -> MovingRelease:
    """Return force and approach of the motion at each position of a lap.

    A fault stands in their place where the sphere passes a position under more than one load, or
    under none. A motion of fewer than two positions has the constant load of the scene.
    """
    steps = result.solved_steps
    loads = force_law.loads_of(scene, result, of_scene.extremes).marched
    motion = of_scene.motion(scene, force_law.force_law(scene, result, loads))
    closed = scene.track.closed and scene.motion.is_constant(scene.duration)
    repeats = closed and motion.settled
    if result.steps > steps and not repeats:
        return MovingRelease.impossible(
            steps, "the record passes the track more than once, and its force does not repeat"
        )
    if motion.flight_share > 0:
        return MovingRelease.impossible(
            steps, "the sphere loses contact, and nothing is released under no load"
        )
    count = round(len(motion.force_n) * steps / result.steps)
    # A sphere that rests stays at its position.
    moved = np.flatnonzero(np.diff(motion.position_m[:count], prepend=-np.inf) > 0)
    if len(moved) < 2:  # it rests, or passes the lap before its force changes
        load, mean = np.full(steps + 1, scene.load), motion.approach_m.mean()
        return MovingRelease(load, np.full(steps + 1, mean))
    places = motion.position_m[moved]
    lap = steps * result.step if repeats else None
    positions = np.arange(steps + 1, dtype=float) * result.step
    force = _at(positions, places, motion.force_n[moved], lap)
    approach = _at(positions, places, motion.approach_m[moved], lap)
    if repeats:
        force[-1] = force[0]  # to the last digit
    if not force.min() > 0:
        return MovingRelease.impossible(steps, "the contact force falls to zero")
    return MovingRelease(force, approach)


def _at(positions: Array, places: Array, values: Array, lap: float | None) -> Array:
    """Interpolate values between places [m]; they repeat after a lap [m], unless it is None."""
    from scipy.interpolate import CubicSpline  # slow to import, for motions only

    if lap is None:
        return np.asarray(CubicSpline(places, values)(positions))
    around, again = np.append(places, places[0] + lap), np.append(values, values[0])
    return np.asarray(CubicSpline(around, again, bc_type="periodic")(positions))


def tasks(
    scenes: Sequence[Scene], result: Result, run: int, step_seconds: float
) -> list[pool.Task]:
    """Return the marches under moving loads that the runs of a shared result need next."""
    made = []
    for scene in scenes:
        if not is_missing(scene, result) or force_law.is_missing(scene, result):
            continue
        key = moving_key(scene)
        if key not in result.moving:
            result.moving[key] = load_along(scene, result)
        moving = result.moving[key]
        if moving.fault:
            continue
        order = simulate.Order.of(result.identity, step_seconds)
        for first, last in simulate.missing(result.solved_steps, moving.steps["release_energy"]):
            arguments = (scene, key, first, last, moving.force, order)
            made.append(pool.Task(run, march_moving, arguments, (last - first) * step_seconds))
    return made


def march_moving(
    scene: Scene,
    key: str,
    first: int,
    last: int,
    force: Array,
    order: simulate.Order,
    stopped: Callable[[], bool],
    progress: Callable[[float], object],
) -> MovingPiece:
    """March a piece of the track under the load at each position; a failure is a fault of it.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    key : str. The vibration that moves the load.
    first, last : int. Positions between which the piece lies.
    force : (steps + 1,) array, N. Load at each position of a lap.
    order : Order. Progress of a step, and the surface.
    stopped, progress : callable. As in `simulate.simulate_piece`.

    Raises
    ------
    ContactError : the heights were replaced or removed.
    Interrupted : `stopped` returned true.
    """
    simulate.refuse_other_surface(scene, order.surface_sha256)
    contact = replace(rolling_contact(scene), loads=force)
    elastic = simulate.half_space(contact.spacing, contact.contact_modulus, contact.subcells)
    left_end = scene.recovery.rule == "left_end"
    steps: dict[str, list[float]] = {name: [] for name in MOVING_SERIES}
    approach, old = list[float](), None
    try:
        for state in march(contact, first, last, elastic):
            if stopped():
                raise pool.Interrupted
            if old is not None:
                energy = step_energy(old, state, elastic, left_end)
                values = (energy.release, energy.loading, energy.defect)
                for name, value in zip(MOVING_SERIES, values, strict=True):
                    steps[name].append(value)
                progress(order.step_cost)
            if state.position > first or first == 0:
                approach.append(state.approach)
            old = state
    except ContactError as error:
        return MovingPiece(key, first, last, {}, np.empty(0), str(error))
    arrays = {name: np.array(values) for name, values in steps.items()}
    return MovingPiece(key, first, last, arrays, np.array(approach))
