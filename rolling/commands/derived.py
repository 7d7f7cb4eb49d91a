"""Files that follow from runs that are done: one gain, table, figures and page."""

from __future__ import annotations

import os
import time
import warnings
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acoustics.traps import ignoring_underflow
from rolling.contact.processor_time import ProcessorTime
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import BANDS, PAGE, SUMMARY, TABLE, RunFolder
from rolling.results import labels, runs_table
from rolling.results.common_gain import write_with_common_gain
from rolling.results.stored_numbers import read_stored, with_page, write_stored
from rolling.run import folder as folders
from rolling.run.ending import Ending
from rolling.run.kept_runs import KeptRuns, keep
from rolling.run.solving import open_runs
from rolling.terminal import defaults, progress, whole_files
from rolling.terminal.whole_files import FolderError

if TYPE_CHECKING:
    import pandas as pd


def write_derived_alone(
    ending: Ending, runs: Sequence[RunFolder], report: bool, part: folders.Part | None = None
) -> None:
    """Write table, figures and page of a folder on which no other command works.

    After a part of a sweep, the part that ends last writes them: it finds no other at work.
    """
    if part is not None and not all(run.is_done or run.failure for run in runs):
        return
    with ExitStack() as stack:
        try:
            stack.enter_context(folders.locked(ending.folder))
        except FolderError:
            if part is None:
                progress.line("another command works on the folder; it writes table and page")
            else:
                progress.line("other parts are at work; the last one writes table and page")
            return
        write_derived(ending, runs, report)


def write_derived(ending: Ending, runs: Sequence[RunFolder], report: bool) -> None:
    """Write what follows from the runs that are done: one gain, table, figures and page.

    Files that are up to date stay as they are.
    """
    folder = ending.folder
    done = [run for run in runs if run.is_done]
    if len(done) == len(runs):
        folders.drop_all_pieces(folder)
        ending.kept.remove_others()
    if not done:
        return
    write_with_common_gain(runs, lambda run: ending.kept.only(run).read, ending.each)
    newest = max((run.folder / SUMMARY).stat().st_mtime_ns for run in done)
    report = report and len(runs) <= defaults.MAX_RUNS_COMPARED
    last = folder / TABLE
    if report:
        last = folder / PAGE
    # A page from the future was written before a clock was set back.
    if last.is_file() and newest <= last.stat().st_mtime_ns <= time.time_ns():
        return
    if not report:
        with progress.step("writing the table"):
            write_tables(runs, folder)
        return
    content, spent = _drawn(ending, runs)
    for run in done:  # before the page, which must not be older than a summary
        write_stored(run.folder, with_page(read_stored(run.folder), spent, len(done)))
    whole_files.write_bytes(folder / PAGE, content)


def _drawn(ending: Ending, runs: Sequence[RunFolder]) -> tuple[bytes, ProcessorTime]:
    """Write table and figures of runs, and return their page and its processor time.

    Where the command has several processes, one writes table and figures and another one the page,
    so that this process need not load what draws.
    """
    page_file = ending.folder / f".{PAGE}{whole_files.PARTIAL}"
    done = [run for run in runs if run.is_done]
    unsolved = [run for run in runs if not run.is_done]
    names = labels.labels(unsolved) if unsolved else []
    calls: list[tuple[Any, ...]] = [
        (_table_and_figures, (ending.kept, runs, ending.folder)),
        (_page_file, (ending.kept, done, page_file, names)),
    ]
    with progress.step("drawing the figures and the page"):
        drawn = ending.each(_with_warnings, calls)
    try:
        content = page_file.read_bytes()
    finally:
        page_file.unlink(missing_ok=True)
    whole = ProcessorTime(0.0, 0.0)
    warned = list[str]()
    for spent, of_call in drawn:
        whole = whole.plus(spent)
        warned += of_call
    if warned:
        from rolling.figures.settings import PictureWarning  # slow to import

        for text in warned:
            warnings.warn(text, PictureWarning, stacklevel=2)
    return content, whole


@ignoring_underflow
def _with_warnings(
    function: Callable[..., None], arguments: tuple[Any, ...]
) -> tuple[ProcessorTime, list[str]]:
    """Call a function that draws; return its processor time, and the pictures that it left out."""
    from rolling.figures.settings import PictureWarning  # slow to import

    began = ProcessorTime.now()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", PictureWarning)
        function(*arguments)
    texts = []
    for warning in caught:
        if issubclass(warning.category, PictureWarning):
            texts.append(str(warning.message))
        else:
            warnings.warn_explicit(
                warning.message, warning.category, warning.filename, warning.lineno
            )
    return ProcessorTime.now().since(began), texts


def _table_and_figures(kept: KeptRuns, runs: Sequence[RunFolder], folder: Path) -> None:
    """Write the table of runs, and the figures of those that are done, into a folder."""
    from rolling import figures  # slow to import

    write_tables(runs, folder)
    done = [run for run in runs if run.is_done]
    if figures.has_written_figures(done):
        figures.write_figures(open_runs(done, kept.read), folder)


def _page_file(
    kept: KeptRuns,
    done: Sequence[RunFolder],
    path: Path,
    unsolved: Sequence[str],
) -> None:
    """Write the page of runs into a file."""
    from rolling.report import report_page  # slow to import, for pages only

    content = report_page.page(open_runs(done, kept.read), unsolved)
    whole_files.write_bytes(path, content)


@ignoring_underflow
def write_first_page(kept: KeptRuns, pilots: Sequence[RunFolder], notice: str, path: Path) -> str:
    """Write the page of pilots with a notice into a file, and return the file.

    Its time is long past, so that no whole page passes for up to date because of it.
    """
    from rolling.report import report_page  # slow to import, for pages only

    content = report_page.page(open_runs(pilots, kept.read), notice=notice)
    whole_files.write_bytes(path, content)
    os.utime(path, (0, 0))
    return str(path)


@ignoring_underflow
def prepare_page(kept: KeptRuns, run: RunFolder, label: str) -> str:
    """Make what a page shows of a run alone, and keep the run with it.

    Return the digest of its new file; empty where the page has to make it, as where it fails.
    """
    with suppress(Exception), warnings.catch_warnings():  # which the page meets again, and tells
        warnings.simplefilter("ignore")
        opened = kept.read(run, label)
        if kind_of(run.scene).prepare_page(opened):
            return keep(opened)
    return ""


def write_tables(runs: Sequence[RunFolder], folder: Path) -> list[Path]:
    """Write the numbers of runs that a person reads, and their third octaves, as CSV.

    Return the files, that of the numbers first. Runs without third octaves have one file.
    """
    paths = [folder / TABLE]
    bands = runs_table.bands_table(runs)
    if len(bands):
        paths.append(folder / BANDS)
        write_table(bands, folder / BANDS)
    write_table(runs_table.runs_table(runs, shown=True), folder / TABLE)
    return paths


def write_table(frame: pd.DataFrame, path: Path) -> None:
    """Write a table as CSV, without a text that a spreadsheet takes for a formula."""
    safe = runs_table.without_formulas(frame)
    whole_files.write_bytes(
        path, safe.to_csv(lineterminator="\n").encode("utf-8", "backslashreplace")
    )


def write_report(runs: Sequence[Any], folder: Path, unsolved: Sequence[RunFolder]) -> None:
    """Write the figures and the page of runs into their folder."""
    from rolling import figures
    from rolling.report import report_page

    if figures.has_written_figures(runs):
        with progress.step("drawing the figures"):
            figures.write_figures(runs, folder)
    with progress.step("writing the page"):
        names: list[str] = []
        if unsolved:
            names = labels.labels(unsolved)
        whole_files.write_bytes(folder / PAGE, report_page.page(runs, names))
