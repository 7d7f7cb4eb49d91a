"""Scenes solved on all cores in memory, the longest first, with a progress bar."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from typing import NoReturn

from tqdm import tqdm

from rolling.check import cost
from rolling.scene.scene import Scene
from rolling.simulation import simulate
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result

BAR = "{desc} {percentage:3.0f}%|{bar}| {elapsed} passed, {remaining} left"


def _ignore(run: int) -> None:
    """Do nothing with the number of a run."""


def solve(
    scenes: Sequence[Scene],
    results: Sequence[Result],
    workers: int,
    name: str,
    mapped: bool = True,
    progress: bool | None = None,
    begun: Callable[[int], object] = _ignore,
    added: Callable[[int], object] = _ignore,
) -> Outcome:
    """Solve the missing steps of runs and add them to their results.

    Parameters
    ----------
    scenes : Scenes without a sweep, one per run.
    results : Results of the runs; their solved steps are not solved again.
    workers : Processes; 0: one per core.
    name : Name of the progress bar.
    mapped : Whether pressure maps along the tracks are kept, some megabytes per run. Default: true.
    progress : Whether a progress bar is shown. Default: on a terminal and in a notebook.
    begun : Gets the number of a run as each of its pieces is handed to a process.
    added : Gets the number of a run after each piece is added to its result.
    """
    missing = [
        [*simulate.missing(result.solved_steps, result.series["release_energy"])]
        for result in results
    ]
    step_seconds = [
        cost.expected_seconds(scene) / result.solved_steps
        for scene, result in zip(scenes, results, strict=True)
    ]
    # The longest first, so that no core is left with one of them in the end.
    order = sorted((k for k in range(len(scenes)) if missing[k]), key=lambda k: -step_seconds[k])
    todo = [(k, first, last) for k in order for first, last in missing[k]]
    orders = [
        simulate.Order(seconds, mapped, result.identity.heights_sha256 if result.identity else None)
        for seconds, result in zip(step_seconds, results, strict=True)
    ]
    total = sum((last - first) * step_seconds[k] for k, first, last in todo)

    def finished(number: int, piece: simulate.Piece) -> None:
        results[number].add(piece)
        added(number)

    with progress_bar(total, name, progress) as bar:
        return simulate.march_pieces(
            scenes, todo, workers or cost.cores(), finished, bar.update, orders, begun
        )


def progress_bar(total: float, name: str, progress: bool | None = None) -> tqdm[NoReturn]:
    """Return a progress bar.

    Parameters
    ----------
    total : float. Sum of the shares that its `update` gets.
    name : str. Words before the bar.
    progress : bool. Whether it is shown. Default: on a terminal and in a notebook.
    """
    return tqdm(total=total, disable=_disabled(progress), desc=name, bar_format=BAR)


def _disabled(progress: bool | None) -> bool | None:
    """Return the value of tqdm's `disable`; None hides the bar unless the stream is a terminal."""
    if progress is None:
        return False if in_notebook() else None
    return not progress


def in_notebook() -> bool:
    """Return whether this code runs in a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return type(shell).__name__ == "ZMQInteractiveShell"
