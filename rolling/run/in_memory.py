"""Runs of a scene in memory, without a folder."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path

from rolling.check import refusals
from rolling.marches.result import Result
from rolling.results import labels
from rolling.results.run_result import Run, hear
from rolling.run.executor import RunLoop
from rolling.run.folder import RunFolder
from rolling.run.pools import local_pool
from rolling.scene.scene import Scene
from rolling.scene.sweep import Value
from rolling.terminal import progress

Values = Value | tuple[Value, ...]


def simulated(
    scene: Scene, workers: int, shown: bool | None
) -> tuple[dict[Values, Run], dict[str, str]]:
    """Simulate the runs of a scene; return them by swept values, and failures by label."""
    if type(workers) is not int or workers < 0:
        raise ValueError(f"workers: got {workers!r}, allowed: a whole number >= 0")
    refusals.refuse(scene, workers)
    runs = [RunFolder(values, single, Path()) for values, single in scene.runs()]
    names, heard = labels.labels(runs), dict[int, Run]()

    def finish(number: int, result: Result) -> None:
        run = runs[number]
        heard[number] = hear(names[number], run.values, run.folder, run.scene, result)

    def start(number: int) -> Result:
        return Result.empty(runs[number].scene)

    scenes = [run.scene for run in runs]

    silence = progress.begin(progress.Level.QUIET) if shown is False else nullcontext()
    with silence, progress.Bar(0.0, scene.name, shown) as bar:
        loop = RunLoop(scenes, start, finish, lambda number: None, None, False, bar)
        with local_pool(workers, scenes) as pool:
            loop.run(pool)
    swept: dict[Values, Run] = {}
    for number, run in sorted(heard.items()):
        values = tuple(runs[number].values.values())
        swept[values[0] if len(values) == 1 else values] = run
    return swept, {names[number]: reason for number, reason in loop.failures.items()}
