"""Choice of the tolerance for `numerics.tolerance: auto`: the marches of its trial, and its rule.

A trial marches short stretches of the track on the run's grid at several tolerances and at half the
spacing. Its layout and its cost, counted in steps of the run, depend on the scene alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from rolling.check import error_cost
from rolling.check.finding import Finding
from rolling.scene.scene import Scene

LEAST, MOST = 1e-6, 1e-3  # limits of a tolerance that is chosen
FLAT = 3e-5  # the tolerance where nothing fluctuates to judge by
SHORT = 1e-4  # the tolerance of a track that is too short for a trial
SHORT_STEPS = 2000  # shorter tracks have no trial
BELOW_DB = 14.0  # distance of the solver's error from the grid's that is promised
# Distance that is aimed at beyond that, because a trial sees few steps of the track: the solver's
# error on other stretches was up to 6 dB higher.
MARGIN_DB = 6.0
# Cost of a trial over the cost of the run, by the counts below; measured times were up to a half
# more of the run, which takes steps at the chosen tolerance.
SHARE = 0.016
LEAST_BUDGET = 400.0  # a trial may cost so many steps of the run in any case
STRETCHES = 2, 4  # minimum and maximum number of stretches
STRETCH_STEPS = 16, 60  # minimum and maximum number of steps of a stretch
DIGITS = 1, 2, 5  # leading digits of a tolerance that is chosen
FIRST_ORDER_DB = 20.0  # fall of the solver's error per decade of tolerance, beyond the tried ones


@dataclass(frozen=True)
class Level:
    """Grid and tolerance of a march of a trial.

    side : float. Side of a cell in cells of the run.
    tolerance : float. Tolerance of the march.
    cost : float. Cost of a step over that of a step of the run at 1e-4, measured on six scenes.
    """

    side: float
    tolerance: float
    cost: float


LEVELS = {
    "fine": Level(0.5, 1e-5, 4.5),
    "tight": Level(1.0, 1e-6, 1.3),
    "middle": Level(1.0, 1e-5, 1.15),
    "loose": Level(1.0, 1e-3, 0.9),
}
_STEP_COST = sum(level.cost for level in LEVELS.values())


def is_open(scene: Scene) -> bool:
    """Return whether a scene leaves the choice of its tolerance to the program."""
    return scene.numerics.tolerance == "auto"


def untried(scene: Scene) -> tuple[float, str] | None:
    """Return the tolerance and the reason where no trial is made; None where a trial decides."""
    steps = scene.track.solved_steps
    if steps < SHORT_STEPS:
        return SHORT, f"the track has {steps} different steps, a trial needs {SHORT_STEPS}"
    if scene.surface.kind == "smooth":
        return FLAT, "a smooth surface makes no sound to judge by"
    return None


def layout(scene: Scene) -> error_cost.Layout:
    """Return the stretches of the trial, as many as the share of the cost pays for."""
    budget = max(LEAST_BUDGET, SHARE * scene.track.solved_steps)
    least, most = STRETCH_STEPS
    count = int(budget / (_STEP_COST * (least + error_cost.START_STEPS)))
    count = min(max(count, STRETCHES[0]), STRETCHES[1])
    steps = int(budget / (_STEP_COST * count) - error_cost.START_STEPS)
    steps = min(max(steps, least), most)
    return error_cost.Layout(
        steps, error_cost.spread(scene.track.solved_steps // steps, steps, count)
    )


def cost(scene: Scene) -> float:
    """Return the expected cost of the trial of a scene, in steps of the run; 0 without one."""
    if not is_open(scene) or untried(scene):
        return 0.0
    stretches = layout(scene)
    return len(stretches.firsts) * (stretches.steps + error_cost.START_STEPS) * _STEP_COST


def choice(grid_db: float, solver_db: Mapping[float, float]) -> float:
    """Choose the loosest tolerance that keeps the solver's error below the grid's.

    Parameters
    ----------
    grid_db : float, dB
        Rms error of the release from the grid.
    solver_db : mapping
        Rms error of the release from the solver [dB] by tolerance.
    """
    wanted = grid_db - BELOW_DB - MARGIN_DB
    series = [
        digit * 10.0**power
        for power in range(round(math.log10(LEAST)), round(math.log10(MOST)) + 1)
        for digit in DIGITS
    ]
    # The decimal text takes the rounding error of the power off.
    allowed = [float(f"{t:.0e}") for t in series if t < MOST * (1 + 1e-9)]
    return max((t for t in allowed if solver_error_db(t, solver_db) <= wanted), default=LEAST)


def solver_error_db(tolerance: float, solver_db: Mapping[float, float]) -> float:
    """Interpolate the error from the solver [dB] at a tolerance, in its logarithm.

    Beyond the tolerances that were tried the error is proportional to the tolerance.
    """
    place = math.log10(tolerance)
    tried = sorted((math.log10(t), db) for t, db in solver_db.items())
    (first, low), (last, high) = tried[0], tried[-1]
    if place <= first:
        return low + FIRST_ORDER_DB * (place - first)
    if place >= last:
        return high + FIRST_ORDER_DB * (place - last)
    return low + (high - low) * (place - first) / (last - first)


def finding(scene: Scene, step_seconds: float) -> Finding:
    """State the tolerance of a run, or the trial that will choose it.

    Parameters
    ----------
    step_seconds : float, s
        Expected time of a step.
    """
    text, seconds = f"{scene.tolerance:g}", 0.0
    if is_open(scene):
        if without := untried(scene):
            text = f"{without[0]:g} (auto, no trial: {without[1]})"
        else:
            steps = cost(scene)
            seconds = steps * step_seconds
            text = (
                f"auto: a trial before the run chooses it from {LEAST:g} to {MOST:g}, at a cost of"
                f" {steps:.0f} steps ({steps / scene.track.solved_steps:.1%} more)"
            )
    return Finding("tolerance", "tolerance", text, seconds=seconds)
