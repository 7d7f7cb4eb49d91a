"""Runs of scenes, solved on all cores and kept as they go. Depends on simulate and store."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from rolling import cost, labels, simulate, store
from rolling.pool import Outcome
from rolling.run_folder import Keeper
from rolling.scenario import Scene
from rolling.sound import middle_speeds
from rolling.store import Result

RESULT = "result.h5"
BAR = "{desc} {percentage:3.0f}%|{bar}| {elapsed} passed, {remaining} left"


@dataclass(frozen=True)
class Run:
    """One run of a scene: the values its sweep gave it, the scene they make, its folder."""

    values: dict[str, float]
    scene: Scene
    folder: Path

    @property
    def label(self) -> str:
        """The name of the run alone: its swept values, or its load. Several are named together by `labels.labels`."""
        return labels.labels([self])[0]


def solve(runs: Sequence[Run], results: Sequence[Result], workers: int, name: str, mapped: bool = True) -> Outcome:
    """Solve what is missing of runs; each result.h5 is written as it grows and once more in the end.

    Parameters
    ----------
    results : one per run, of which what is solved already is not solved again.
    workers : processes; 0: one per core.
    name : what the progress bar is of.
    mapped : keep pressure maps along the tracks, some megabytes a run.
    """
    missing = [[*simulate.missing(result.solved_steps, result.series["release_energy"])] for result in results]
    step_seconds = [
        cost.expected_seconds(one.scene) / result.solved_steps for one, result in zip(runs, results, strict=True)
    ]
    # The longest first, so that no core is left with one of them in the end.
    order = sorted((k for k in range(len(runs)) if missing[k]), key=lambda k: -step_seconds[k])
    todo = [(k, first, last) for k in order for first, last in missing[k]]
    keepers = {k: Keeper() for k in order}

    def finished(number: int, piece: simulate.Piece) -> None:
        results[number].add(piece)
        if keepers[number].due() or results[number].complete:
            began = time.monotonic()
            keep(runs[number], results[number])
            keepers[number].wrote(time.monotonic() - began)

    for k in order:
        keep(runs[k], results[k])
    scenes = [one.scene for one in runs]
    total = sum((last - first) * step_seconds[k] for k, first, last in todo)
    with tqdm(total=total, disable=None, desc=name, bar_format=BAR) as bar:
        outcome = simulate.simulate(scenes, todo, workers or cost.cores(), finished, bar.update, step_seconds, mapped)
    for k in order:
        keep(runs[k], results[k])
    return outcome


def keep(one: Run, result: Result) -> None:
    """Write the result of a run into its folder."""
    _, speeds = middle_speeds(one.scene, result.steps, result.step)
    store.save(one.folder / RESULT, result, speeds, one.scene.name)
