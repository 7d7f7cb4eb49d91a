"""Load along the track under the motion of the sphere, for the release under the moving load.

The motion gives the force at each position of a lap. The march under it gives the release, and an
approach that must agree with that of the motion.
"""

from __future__ import annotations

import numpy as np

from rolling._typing import Array
from rolling.dynamics import of_scene
from rolling.marches.force_law import force_law
from rolling.marches.result import MovingRelease, Result, vibration_key
from rolling.scene.scene import Scene


def load_along(scene: Scene, result: Result) -> MovingRelease:
    """Return force and approach of the motion at each position of a lap.

    A fault stands in their place where the sphere passes a position under more than one load, or
    under none. A motion of fewer than two positions has the constant load of the scene.
    """
    key, steps = vibration_key(scene), result.solved_steps
    motion = of_scene.motion(scene, force_law(scene, result))
    closed = scene.track.closed and scene.motion.is_constant(scene.duration)
    repeats = closed and motion.settled
    if result.steps > steps and not repeats:
        return MovingRelease.impossible(
            key, steps, "the record passes the track more than once, and its force does not repeat"
        )
    if motion.flight_share > 0:
        return MovingRelease.impossible(
            key, steps, "the sphere loses contact, and nothing is released under no load"
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
