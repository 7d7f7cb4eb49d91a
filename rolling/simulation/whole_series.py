"""The series of a whole run with repeated laps, and their distances and times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rolling._typing import Array
from rolling.scene.scene import Scene
from rolling.simulation.result import Result
from rolling.simulation.simulate import STATE_SERIES, STEP_SERIES
from rolling.sound.contact_sound import middle_speeds


@dataclass(frozen=True, eq=False)
class WholeSeries:
    """All series of a run in SI units, with NaN where a step is not solved.

    distance, time : (steps,) m and s. The middle of each step.
    position, position_time : (steps + 1,) m and s. The positions between which the steps lie.
    of_steps : dict. Series of shape (steps,) by name.
    of_positions : dict. Series of shape (steps + 1,) by name.
    """

    distance: Array
    time: Array
    position: Array
    position_time: Array
    of_steps: dict[str, Array]
    of_positions: dict[str, Array]


def whole_series(scene: Scene, result: Result) -> WholeSeries:
    """Repeat the solved laps of a run, and add speed, power and energy per metre.

    Parameters
    ----------
    scene : Scene. The scene of the run, for its motion.
    result : Result. The solved lap.
    """
    middles = np.asarray((np.arange(result.steps) + 0.5) * result.step, dtype=np.float64)
    ends = np.asarray(np.arange(result.steps + 1) * result.step, dtype=np.float64)
    times, speed = middle_speeds(scene.motion, result.steps, result.step)
    end_times = np.asarray(
        scene.motion.time(np.minimum(ends, scene.motion.final_distance)), dtype=float
    )
    of_steps = {name: result.whole(name) for name in STEP_SERIES} | {"speed": speed}
    for kind in ("release", "loading"):
        of_steps[f"{kind}_per_metre"] = of_steps[f"{kind}_energy"] * (1 / result.step)
        of_steps[f"{kind}_power"] = of_steps[f"{kind}_energy"] * (speed / result.step)
    of_positions = {name: result.whole(name) for name in STATE_SERIES}
    distance, position = (np.asarray(result.start + each, dtype=float) for each in (middles, ends))
    return WholeSeries(distance, times, position, end_times, of_steps, of_positions)
