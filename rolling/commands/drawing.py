"""Pictures of runs, drawn on all cores with a progress bar."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rolling.check import cost
from rolling.figures import run_figures
from rolling.figures.run_figures import SHEET_PICTURES, SHEETS, Scales
from rolling.report import page as pages
from rolling.report.page import Exhibit
from rolling.simulation import pool
from rolling.simulation.run_result import RunResult
from rolling.terminal import progress

_OF_ALL = 6  # pictures of all runs together, about
# A process takes as long to start as a few pictures to draw: each has to draw more than these.
_WORTH_A_PROCESS = 10


@dataclass(frozen=True)
class _Sheet:
    """A sheet of pictures of one run, in a form that goes to another process.

    number : place among `SHEETS`.
    paged : names of pictures that the page shows are made into exhibits.
    """

    run: RunResult
    number: int
    scales: Scales
    compared: int
    paged: bool


def draw(
    folder: Path, runs: Sequence[RunResult], of_each: bool, paged: bool, workers: int
) -> list[tuple[RunResult | None, Exhibit]]:
    """Draw the pictures of runs into their folders, and the pictures of all of them into `folder`.

    Parameters
    ----------
    of_each : Whether the pictures of each run are drawn.
    paged : Whether a page is wanted.
    workers : Processes; 0: one per core.

    Returns
    -------
    exhibits : The pictures for the page, each with its run or with None if it shows several.

    Raises
    ------
    OSError : a file cannot be written, or a process was killed.
    KeyboardInterrupt : Ctrl-C, after the picture at hand.
    """
    total = sum(SHEET_PICTURES) * len(runs) * of_each + _OF_ALL * (len(runs) > 1)
    exhibits: list[tuple[RunResult | None, Exhibit]] = []
    with progress.bar(total, "pictures") as bar:
        if of_each:
            own = paged and len(runs) <= pages.MOST_RUNS
            exhibits += _draw_each(runs, own, workers, bar.update)
        if len(runs) > 1:
            for picture in run_figures.of_runs(runs):
                picture.write(folder)
                if paged:
                    exhibits.append((None, pages.exhibit(picture)))
                bar.update(1)
    return exhibits


def _draw_each(
    runs: Sequence[RunResult], paged: bool, workers: int, progress: Callable[[float], object]
) -> list[tuple[RunResult | None, Exhibit]]:
    """Draw the pictures of each run, in this process where there are few."""
    most = sum(SHEET_PICTURES) * len(runs) // _WORTH_A_PROCESS
    workers = max(1, min(workers or cost.cores(), most))
    scales = Scales.of(runs)
    tasks, drawn = [], {}
    for k, run in enumerate(runs):
        for number, pictures in enumerate(SHEET_PICTURES):
            sent = run if workers == 1 else _without_maps(run)
            sheet = _Sheet(sent, number, scales, len(runs), paged)
            tasks.append(pool.Task(k, _draw_sheet, (sheet, pictures), pictures))

    def finished(run: int, result: tuple[int, list[Exhibit]]) -> None:
        drawn[run, result[0]] = result[1]

    outcome = pool.work(tasks, workers, finished, progress)
    if outcome.interrupted:
        raise KeyboardInterrupt
    for reason in outcome.failures.values():
        raise OSError(f"pictures: {reason}")
    return [(runs[k], exhibit) for k, number in sorted(drawn) for exhibit in drawn[k, number]]


def _without_maps(run: RunResult) -> RunResult:
    """Return a run without its pressure maps and its writer, which cannot go to another process."""
    return replace(run, result=replace(run.result, maps={}), writer=None)


def _draw_sheet(
    sheet: _Sheet,
    pictures: float,
    stopped: Callable[[], bool],
    progress: Callable[[float], object],
) -> tuple[int, list[Exhibit]]:
    """Draw a sheet of pictures into the folder of its run; return its number and its exhibits.

    Raises
    ------
    Interrupted : `stopped` said so.
    """
    exhibits = []
    for picture in SHEETS[sheet.number](sheet.run, sheet.scales):
        if stopped():
            raise pool.Interrupted
        picture.write(sheet.run.folder)
        if sheet.paged and pages.belongs(sheet.run, picture.name, sheet.compared):
            exhibits.append(pages.exhibit(picture))
    progress(pictures)
    return sheet.number, exhibits
