"""The sheets that people hand on: `rolling report --declare`, and those of a surface."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from acoustics.texts import printable
from rolling.commands.replaced import refuse_others, source_name
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import RunFolder
from rolling.numbers.sheet import Sheet
from rolling.report import text
from rolling.report.sheets import Sheets, sheets_csv, sheets_json, sheets_page
from rolling.run import folder as folders
from rolling.run.solving import open_runs
from rolling.terminal import defaults, pages, progress, whole_files
from rolling.terminal.whole_files import FolderError

DECLARATION = "declaration.html"


def declare(run_folders: Sequence[Path], out: Path | None = None) -> list[Path]:
    """Write the sheets of all runs that are done in run folders; return their files.

    Beside the page stand the same values as CSV and JSON. Nothing is marched.

    Parameters
    ----------
    run_folders : sequence of Path. The run folders.
    out : Path. Page to write. Default: declaration.html in the only run folder, where the command
        replaces its own files of the same folder.

    Raises
    ------
    FolderError, SceneError : a folder is no run folder, nothing is done in it, its runs have no
        sheets or are too many, or a file exists. Nothing is written.
    """
    if out is None and len(run_folders) > 1:
        raise FolderError("--out: give the file of the sheets of several run folders")
    page = run_folders[0] / DECLARATION if out is None else out
    if out is not None:
        pages.refuse_page(out)
        for path in _files(out):
            if path.exists():
                raise FolderError(f"{path}: exists; take another --out, or remove it")
    done = _done(run_folders)
    with progress.step("reading the runs, making their sheets"):
        runs = open_runs(done)
        sheets = {printable(run.label or run.scene.name): _sheets_of(run) for run in runs}
        title = f"Declared values: {text.titles(runs)}"
    source = "; ".join(source_name(folder, page.parent) for folder in run_folders)
    return write_sheets(page, title, sheets, source)


def _done(run_folders: Sequence[Path]) -> list[RunFolder]:
    """Return the runs of run folders that are done, each once."""
    by_place = {}
    for folder in run_folders:
        for run in folders.done_runs(folder):
            by_place[run.folder.resolve()] = run
    if len(by_place) > defaults.MAX_RUNS_ON_PAGE:
        raise FolderError(
            f"{len(by_place)} runs: --declare writes the sheets of {defaults.MAX_RUNS_ON_PAGE} at"
            " most; name the folders of single runs"
        )
    return list(by_place.values())


def _sheets_of(run: RunFolder) -> list[Sheet]:
    """Return all sheets of a run."""
    kind = kind_of(run.scene)
    sheets = [*kind.sheets(run), *kind.surface_sheets(run)]
    if not sheets:
        raise FolderError(
            f"{run.folder}: a run of a {kind.name} has nothing to declare; allowed: runs whose kind"
            " has sheets, such as balls and bearings"
        )
    return sheets


def write_sheets(page: Path, title: str, sheets: Sheets, source: str) -> list[Path]:
    """Write sheets as a page, CSV and JSON; return their files.

    Raises
    ------
    FolderError : a file exists that is not of the same source. Nothing is written.
    """
    contents = dict(zip(_files(page), sheet_contents(title, sheets, source), strict=True))
    for path, content in contents.items():
        refuse_others(path, content)
    page.parent.mkdir(parents=True, exist_ok=True)
    for path, content in contents.items():
        whole_files.write_bytes(path, content)
    return [*contents]


def sheet_contents(title: str, sheets: Sheets, source: str) -> tuple[bytes, bytes, bytes]:
    """Return the page, the CSV and the JSON of sheets, in which each names its source."""
    return (
        sheets_page(title, sheets, source),
        sheets_csv(sheets, source),
        sheets_json(sheets, source),
    )


def _files(page: Path) -> list[Path]:
    """Return the page, and the files with the same values beside it."""
    return [page, page.with_suffix(".csv"), page.with_suffix(".json")]
