"""Stored runs as finished runs, runs that are saved, and the files derived from all runs."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from rolling.results import labels, runs_table
from rolling.results.run_files import read_run, write_run
from rolling.results.run_result import Run
from rolling.run import folder as folders
from rolling.run.folder import RunFolder
from rolling.terminal import defaults, files, progress
from rolling.terminal.files import FolderError

if TYPE_CHECKING:
    import pandas as pd

PAGE, TABLE = "report.html", "runs.csv"


def open_run(folder: Path | str) -> Run:
    """Read a stored run and make its sound again, without solving.

    Parameters
    ----------
    folder : Path or str. A run folder, or the folder of one run in a sweep.

    Returns
    -------
    run : Run. The run as `simulate` returns it.

    Raises
    ------
    FolderError : the folder is not a run folder, belongs to a whole sweep, or is not done.
    SceneError : the surface of the run cannot be read.

    Examples
    --------
    `open_run("outputs/mine").series["contact_area"]`
    """
    runs = folders.stored_runs(Path(folder))
    if len(runs) > 1:
        names = ", ".join(run.folder.name for run in runs[:3])
        raise FolderError(
            f"{folder}: holds {len(runs)} runs; open one of the folders in it ({names}, ...)"
        )
    if not runs[0].is_done:
        raise FolderError(f"{folder}: not done; the same `rolling run` goes on with it")
    return open_runs(runs)[0]


def open_runs(runs: Sequence[RunFolder]) -> list[Run]:
    """Read runs that are done, with labels that tell them apart."""
    return [
        replace(read_run(run.folder, run.scene, run.values, label), writer=save_run)
        for label, run in zip(labels.labels(runs), runs, strict=True)
    ]


def save_run(run: Run, folder: Path | str, report: bool = True) -> Path:
    """Write a run that is in memory into a new folder, with the files that `rolling run` writes.

    Parameters
    ----------
    run : Run. The run.
    folder : Path or str. The folder to make.
    report : bool. Write the report page as well. Default: true.

    Returns
    -------
    folder : Path. The new folder, for `open_run`.

    Raises
    ------
    FolderError : the folder holds files already.

    Examples
    --------
    `save_run(simulate(scene), "outputs/mine")`
    """
    folder = Path(folder)
    if folder.exists() and any(folder.iterdir()):
        raise FolderError(f"{folder}: holds files; take another, as {folders.free_name(folder)}")
    folder.mkdir(parents=True, exist_ok=True)
    with folders.held(folder):
        folders.write_scene(folder, run.scene)
        (alone,) = folders.stored_runs(folder)
        write_run(replace(run, folder=folder, values={}))
        derive(folder, [alone], report)
    return folder


def derive(folder: Path, runs: Sequence[RunFolder], report: bool) -> None:
    """Write table, figures and page of the runs that are done, unless they are up to date."""
    done = [run for run in runs if run.is_done]
    if len(done) == len(runs):
        shutil.rmtree(folder / folders.PIECES, ignore_errors=True)
    if not done:
        return
    newest = max((run.folder / folders.SUMMARY).stat().st_mtime_ns for run in done)
    report = report and len(runs) <= defaults.MOST_RUNS_COMPARED
    last = folder / (PAGE if report else TABLE)
    if last.is_file() and last.stat().st_mtime_ns >= newest:
        return
    with progress.step("writing the table"):
        write_table(runs_table.runs_table(runs), folder / TABLE)
    if report:
        write_report(open_runs(done), folder, [run for run in runs if not run.is_done])


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV."""
    files.write_bytes(path, table.to_csv(lineterminator="\n").encode("utf-8", "backslashreplace"))


def write_report(runs: Sequence[Run], folder: Path, unsolved: Sequence[RunFolder]) -> None:
    """Write the figures that compare runs and the page of all runs into a folder."""
    from rolling.figures import write_figures
    from rolling.report import page

    with progress.step("drawing the figures"):
        if len(runs) > 1:
            write_figures(runs, folder)
    with progress.step("writing the page"):
        names = labels.labels(unsolved) if unsolved else []
        files.write_bytes(folder / PAGE, page.page(runs, names))
