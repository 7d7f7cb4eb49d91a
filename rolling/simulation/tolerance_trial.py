"""Trial of the tolerance before a run: short stretches of its own track, marched on four levels.

Places, lengths and levels depend on the scene alone, and so does the tolerance that is chosen: it
is equal for any number of workers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rolling._typing import Array
from rolling.check import cost, tolerance
from rolling.check.tolerance import LEVELS
from rolling.scene.scene import Scene
from rolling.simulation import error_stretches, pool
from rolling.simulation.error_stretches import Grid
from rolling.simulation.result import Result
from rolling.simulation.simulate import Order
from rolling.simulation.stretches import March, Trial
from rolling.sound.solver_error import SOLVER_ERROR
from rolling.terminal import progress as terminal

# Shorter work is done in this process, because other processes take about as long to start.
WORTH_PROCESSES = 4.0  # [s]


@dataclass(frozen=True)
class Choices:
    """Scenes with the tolerances that were chosen for them.

    scenes : list of Scene. All scenes in their order; after an interruption some are still open.
    interrupted : bool. Whether the trials were interrupted.
    """

    scenes: list[Scene]
    interrupted: bool


def choose(
    scenes: Sequence[Scene],
    results: Sequence[Result],
    workers: pool.Workers,
    progress: bool | None = None,
    chosen: Callable[[int, Scene], object] = lambda number, scene: None,
) -> Choices:
    """Choose the tolerances that scenes leave open, and note the trials in their results.

    Parameters
    ----------
    scenes : sequence of Scene. Scenes without a sweep, one per run.
    results : sequence of Result. One result per run, which gets the trial.
    workers : int or Cluster. Number of processes; 0: one per core.
    progress : bool. Whether a progress bar is shown. Default: on a terminal and in a notebook.
    chosen : callable. It receives number and changed scene of each run as soon as it is chosen.
    """
    pinned = list(scenes)
    marches: dict[int, list[March]] = {}

    def decide(number: int, trial: Trial) -> None:
        pinned[number] = scenes[number].with_({"numerics.tolerance": trial.tolerance})
        results[number].trial = trial
        terminal.detail(f"run {number + 1} of {len(scenes)}: {text(trial)}")
        chosen(number, pinned[number])

    for number, scene in enumerate(scenes):
        if not tolerance.is_open(scene):
            continue
        if without := tolerance.untried(scene):
            decide(number, Trial(without[0], without[1]))
        else:
            marches[number] = []
    tasks = [task for number in marches for task in _tasks(scenes[number], number)]
    if not tasks:
        return Choices(pinned, False)
    wanted = {number: sum(task.run == number for task in tasks) for number in marches}

    def finished(number: int, march: March) -> None:
        marches[number].append(march)
        if len(marches[number]) == wanted[number]:
            decide(number, trial_of(marches[number]))

    total = sum(task.cost for task in tasks)
    workers = 1 if total < WORTH_PROCESSES else workers or cost.cores()
    with terminal.bar(total, "trial of the tolerance", progress) as bar:
        outcome = pool.work(tasks, workers, finished, bar.update)
    for number, reason in outcome.failures.items():  # the run will fail for the same reason
        decide(number, Trial(tolerance.SHORT, f"the trial failed: {reason}"))
    return Choices(pinned, outcome.interrupted)


def choose_here(scene: Scene, result: Result, stopped: Callable[[], bool]) -> Scene:
    """Choose the tolerance of a scene that leaves it open in this process, without a bar.

    Raises
    ------
    ContactError, Interrupted : as in the tasks of the run.
    """
    if not tolerance.is_open(scene):
        return scene
    if without := tolerance.untried(scene):
        trial = Trial(without[0], without[1])
    else:
        marches = [
            task.function(*task.arguments, stopped, lambda share: None) for task in _tasks(scene, 0)
        ]
        trial = trial_of(marches)
    result.trial = trial
    return scene.with_({"numerics.tolerance": trial.tolerance})


def _tasks(scene: Scene, run: int) -> list[pool.Task]:
    """Return the marches of the trial of a scene, the longest first."""
    stretches = tolerance.layout(scene)
    step_seconds = cost.expected_seconds(scene) / scene.track.solved_steps
    made = []
    for name, level in LEVELS.items():
        grid, step_cost = Grid(name, level.side, level.tolerance), level.cost * step_seconds
        for first in stretches.firsts:
            arguments = (scene, grid, first, stretches.steps, Order(step_cost, mapped=False))
            cost_of_march = stretches.steps * step_cost
            made.append(pool.Task(run, error_stretches.march_grid, arguments, cost_of_march))
    return made


def trial_of(marches: Sequence[March]) -> Trial:
    """Judge the marches of a trial and choose the tolerance."""
    by_place = {(march.first, march.level): march for march in marches}
    faults = {march.first: march.fault for march in marches if march.fault}
    firsts = sorted({march.first for march in marches} - faults.keys())
    seconds = sum(march.seconds for march in marches)
    if not firsts:
        reason = f"the trial failed: {next(iter(faults.values()))}"
        return Trial(tolerance.SHORT, reason, seconds=seconds)
    release = {
        name: np.array([by_place[first, name].release for first in firsts]) for name in LEVELS
    }
    steps = release["tight"].shape[1]
    trial = Trial(tolerance.FLAT, "", len(firsts), steps, seconds=seconds)
    fluctuation, mean = float(release["tight"].std()), float(release["tight"].mean())
    if fluctuation <= SOLVER_ERROR * LEVELS["tight"].tolerance * mean:
        return replace(trial, reason="the release does not fluctuate, there is nothing to judge by")
    grid_db = _error_db(release["tight"], release["fine"], fluctuation)
    solver_db = {
        LEVELS[name].tolerance: _error_db(release[name], release["tight"], fluctuation)
        for name in ("middle", "loose")
    }
    chosen = tolerance.choice(grid_db, solver_db)
    return replace(
        trial,
        tolerance=chosen,
        grid_signal_db=grid_db,
        solver_signal_db=tolerance.solver_error_db(chosen, solver_db),
    )


def _error_db(release: Array, better: Array, fluctuation: float) -> float:
    """Return the rms difference of two releases over a fluctuation [dB]."""
    # Releases that agree to rounding have no error that counts.
    return 20 * math.log10(max(float(np.std(release - better)) / fluctuation, 1e-12))


def text(trial: Trial) -> str:
    """Write a chosen tolerance and its reason."""
    if trial.grid_signal_db is None or trial.solver_signal_db is None:
        return f"tolerance {trial.tolerance:g}, chosen without trial: {trial.reason}"
    return (
        f"tolerance {trial.tolerance:g}, chosen by a trial of {trial.stretches} stretches of"
        f" {trial.steps} steps: rms error of the release over its fluctuation"
        f" {trial.grid_signal_db:.0f} dB from the grid, {trial.solver_signal_db:.0f} dB from the"
        " solver"
    )
