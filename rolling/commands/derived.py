"""Files that follow from runs that are done: one gain, table, figures and page."""

from __future__ import annotations

import shutil
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from rolling.contact.processor_time import ProcessorTime
from rolling.marches import effort
from rolling.results import labels, runs_table
from rolling.results.common_gain import write_with_common_gain
from rolling.results.run_folder import PAGE, SUMMARY, TABLE, RunFolder, read_summary
from rolling.results.run_result import Run
from rolling.run import folder as folders
from rolling.run.solving import open_runs
from rolling.terminal import defaults, files, progress
from rolling.terminal.files import FolderError

if TYPE_CHECKING:
    import pandas as pd


def write_derived_alone(
    folder: Path, runs: Sequence[RunFolder], report: bool, part: folders.Part | None = None
) -> None:
    """Write table, figures and page of a folder on which no other command works.

    After a part of a sweep, the part that ends last writes them: it finds no other at work.
    """
    if part is not None and not all(run.is_done or run.failure for run in runs):
        return
    with ExitStack() as stack:
        try:
            stack.enter_context(folders.locked(folder))
        except FolderError:
            if part is None:
                progress.line("another command works on the folder; it writes table and page")
            else:
                progress.line("other parts are at work; the last one writes table and page")
            return
        write_derived(folder, runs, report)


def write_derived(folder: Path, runs: Sequence[RunFolder], report: bool) -> None:
    """Write what follows from the runs that are done: one gain, table, figures and page.

    Files that are up to date stay as they are.
    """
    done = [run for run in runs if run.is_done]
    if len(done) == len(runs):
        shutil.rmtree(folder / folders.PIECES, ignore_errors=True)
    if not done:
        return
    write_with_common_gain(runs)
    newest = max((run.folder / SUMMARY).stat().st_mtime_ns for run in done)
    report = report and len(runs) <= defaults.MAX_RUNS_COMPARED
    last = folder / TABLE
    if report:
        last = folder / PAGE
    # A page from the future was written before a clock was set back.
    if last.is_file() and newest <= last.stat().st_mtime_ns <= time.time_ns():
        return
    with progress.step("writing the table"):
        write_table(runs_table.runs_table(runs), folder / TABLE)
    if not report:
        return
    began = ProcessorTime.now()
    content = _drawn_report(open_runs(done), folder, [run for run in runs if not run.is_done])
    spent = ProcessorTime.now().since(began)
    for run in done:  # before the page, which must not be older than a summary
        summary = read_summary(run.folder / SUMMARY)
        files.write_json(run.folder / SUMMARY, effort.with_page(summary, spent, len(done)))
    files.write_bytes(folder / PAGE, content)


def write_table(frame: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV, without a text that a spreadsheet takes for a formula."""
    safe = runs_table.without_formulas(frame)
    files.write_bytes(path, safe.to_csv(lineterminator="\n").encode("utf-8", "backslashreplace"))


def write_report(runs: Sequence[Run], folder: Path, unsolved: Sequence[RunFolder]) -> None:
    """Write the figures that compare runs and the page of all runs into a folder."""
    content = _drawn_report(runs, folder, unsolved)
    files.write_bytes(folder / PAGE, content)


def _drawn_report(runs: Sequence[Run], folder: Path, unsolved: Sequence[RunFolder]) -> bytes:
    """Write the figures that compare runs into a folder, and return the page of all runs."""
    from rolling.figures import write_figures
    from rolling.report import page

    with progress.step("drawing the figures"):
        if len(runs) > 1:
            write_figures(runs, folder)
    with progress.step("writing the page"):
        names: list[str] = []
        if unsolved:
            names = labels.labels(unsolved)
        return page.page(runs, names)
