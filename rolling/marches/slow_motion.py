"""Stretch of a run that is marched again for its slow motion.

The stretch lies around the loudest event: the place where the release power, averaged over 20 um,
is largest; for a run that is heard by its vibration, where the contact force departs most from the
load. It is marched under the load of the scene, at a few percent of the run's cost at most.
"""

from __future__ import annotations

import math

import numpy as np

from acoustics.arrays import Array
from rolling.contact.solver import ContactError
from rolling.marches.force_law import law_motion
from rolling.marches.result import Result
from rolling.scene.scene import Scene

SECONDS = 3e-3  # [s] of rolling that are shown
SHARE = 0.05  # maximum share of the steps of the run
COLD_STEPS = 3  # cost of a cold start in steps
AVERAGED = 20e-6  # [m] over which the release is averaged to find the event
FROM, TO = 2e-6, 4e-6  # [m] from one map to the next, unless a step is longer
FEWEST, MOST = 30, 150  # maps


def film_stretch(scene: Scene, result: Result) -> range | None:
    """Choose the positions of the maps around the loudest event of a complete result.

    Return None for a smooth surface, which has no events, and for a run that is too short.
    """
    if scene.is_smooth or not result.complete:
        return None
    vibrates = scene.dynamics is not None and scene.sound.source == "vibration"
    try:
        position, speed = (_largest_departure if vibrates else _loudest_release)(scene, result)
    except ContactError:
        return None
    step = result.step
    wanted = SECONDS * speed / step
    stride = max(1, math.ceil(FROM / step - 1e-9))
    stride = max(stride, min(math.floor(TO / step + 1e-9), math.ceil(wanted / MOST - 1e-9)))
    affordable = SHARE * result.solved_steps - COLD_STEPS
    maps = min(MOST, int(min(wanted, affordable) // stride))
    if maps < FEWEST:
        return None
    length = (maps - 1) * stride
    first = min(max(0, position - length // 2), result.solved_steps - length)
    return range(first, first + length + 1, stride)


def _largest_departure(scene: Scene, result: Result) -> tuple[int, float]:
    """Return position and speed [m/s] where the force departs most from the load in a lap."""
    motion = law_motion(scene, result)
    departure = np.abs(motion.force_n / scene.load - 1.0)
    departure[motion.position_m > result.solved_steps * result.step] = 0.0
    largest = int(np.argmax(departure))
    speed = float(scene.motion.speed(motion.time_s[largest]))
    return round(float(motion.position_m[largest]) / result.step), speed


def _loudest_release(scene: Scene, result: Result) -> tuple[int, float]:
    """Return position and speed [m/s] of the largest release power."""
    energy, step = result.series["release_energy"], result.step
    middle = np.minimum((np.arange(len(energy)) + 0.5) * step, scene.motion.final_distance)
    speed = np.asarray(scene.motion.speed(scene.motion.time(middle)), dtype=float)
    position = loudest(energy * speed, max(1, round(AVERAGED / step)))
    return position, float(speed[position])


def loudest(power: Array, width: int) -> int:
    """Return the middle of the stretch of so many values with the largest mean."""
    sums = np.cumsum(np.concatenate([[0.0], power]))
    width = min(width, len(power))
    return int(np.argmax(sums[width:] - sums[:-width])) + width // 2
