"""Forecast of the time of a run: marches, motion, start of the processes, files and page.

The marches of a scene share the cores. The command starts once, every process loads the solver, and
one process writes figures and page. tests/benchmarks/forecast_study.py compares forecasts with
runs.
"""

from collections.abc import Sequence

from rolling.check import cost, error_cost
from rolling.check.finding import Finding
from rolling.check.memory_and_disk import SAMPLE_RATE
from rolling.check.run_size import run_size
from rolling.in_si.physics_of_scene import bodies_of, plate_of
from rolling.scene.scene import Scene

SHORT = 10.0  # [s] below which a forecast is a few seconds
# Processor seconds of the parts beside the marches.
START = 1.2  # of the command, which loads the program
WORKER = 2.2  # of each process, which loads the compiled solver
RUN = 0.5  # of the files of a run
PAGE = 0.7
PAGE_RUN = 0.5  # of each run on the page
FIGURES = 3.0  # that compare runs
STEP = 6e-6  # per step of a record, in files and page
SAMPLE = 6e-6  # per sample of a record, in files and page
TIME_STEP = 3e-7  # per time step of a motion
MODE_STEP = 3.6e-9  # per time step and mode of a plate with edges
MODE = 3e-3  # per mode of a plate, in the sound of a run
MOTIONS = 3  # of a run: over the first loads, over all loads, and with longer time steps
# A motion on a closed track runs in for so many decay times of the resonance, or laps at most.
RUN_IN_DECAYS = 12.0
RUN_IN_LAPS = 400.0
JUDGED_STEPS = 200  # of the stretch at loads between those of a force law
MAX_RUNS_ON_PAGE = 24  # with players; more runs have their figures only
SURFACE = "surface_time"  # key of the row whose time runs with the same surface share
MIN_SECONDS = 1.0  # shorter times for making a surface are not listed


def law_seconds(scene: Scene) -> tuple[int, float]:
    """Estimate number and time [s] of the marches at other loads for a force law."""
    if scene.dynamics is None:
        return 0, 0.0
    falls, fall_seconds = cost.fall_seconds(scene)
    others = scene.dynamics.loads - 1
    judged_steps = min(JUDGED_STEPS, scene.track.solved_steps)
    judged_seconds = judged_steps * cost.step_ms(scene) * 1e-3
    seconds = fall_seconds + others * (cost.lap_seconds(scene) + judged_seconds)
    return others + falls, seconds


def march_seconds(scene: Scene) -> float:
    """Estimate the time [s] of all marches of a run on one core."""
    _, of_law = law_seconds(scene)
    seconds = cost.expected_seconds(scene) + error_cost.seconds(scene) + of_law
    if scene.moves_release:
        seconds += cost.lap_seconds(scene)
    return seconds


def motion_seconds(scene: Scene) -> float:
    """Estimate the time [s] in which sphere and plate move and become sound; 0 without dynamics."""
    if scene.dynamics is None:
        return 0.0
    plate = plate_of(scene.plate).with_edges
    modes = 0 if plate is None else plate.mode_count
    duration = moved = scene.duration
    if scene.track.closed and scene.motion.is_constant(duration) and not scene.is_one_event:
        decay = bodies_of(scene).smooth_chain.own_decay_s
        moved += min(RUN_IN_DECAYS * decay, RUN_IN_LAPS * duration)
    moved = MOTIONS * moved + (scene.sound.listen_s or 0.0)
    steps = moved * run_size(scene).motion_rate_hz
    return steps * (TIME_STEP + MODE_STEP * modes) + MODE * modes


def beside_seconds(scenes: Sequence[Scene], cores: int) -> float:
    """Estimate the time [s] beside the marches, on all cores times their number.

    It holds start, motions, files, figures and page. Runs share the cores, and the rest is done by
    one process.
    """
    alone = START + WORKER + PAGE + PAGE_RUN * min(len(scenes), MAX_RUNS_ON_PAGE)
    if len(scenes) > 1:
        alone += FIGURES
    shared = sum(
        RUN + STEP * scene.track.steps + SAMPLE * scene.duration * SAMPLE_RATE for scene in scenes
    )
    shared += sum(map(motion_seconds, scenes))
    if len(scenes) < cores:  # the others wait
        shared *= cores / len(scenes)
    return alone * cores + shared


def pilot_seconds(pilots: Sequence[Scene]) -> float:
    """Estimate the time [s] of short runs that give a first answer, with their page.

    Others may be solved meanwhile, so it counts on one core.
    """
    if not pilots:
        return 0.0
    seconds = PAGE
    for scene in pilots:
        seconds += march_seconds(scene) + motion_seconds(scene) + RUN + PAGE_RUN
        seconds += STEP * scene.track.steps + SAMPLE * scene.duration * SAMPLE_RATE
    return seconds


def takes(core_seconds: float) -> str:
    """Write the time of a whole run: a few seconds, or so long on all cores."""
    if core_seconds / cost.cores() < SHORT:
        return "a few seconds"
    return cost.computing(core_seconds)


def surface_time(scene: Scene, slow: float = 1.0) -> list[Finding]:
    """State the time to make a random surface, which every process does; nothing if it is short.

    `slow` is the time that this machine took over the expected one.
    """
    seconds = slow * cost.cores() * sum(cost.surface_seconds(scene))
    if seconds < MIN_SECONDS:
        return []
    value = f"{cost.computing(seconds)}, each of which makes it"
    return [Finding(SURFACE, "making of the surface", value, seconds)]
