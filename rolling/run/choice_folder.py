"""Folder of a choice: what is written into it, and which folder a choice may take.

Sentences, table, picture, page and sounds stand in the folder, and all that belongs to candidates
stands below `runs/`, so that no name of a candidate is that of a file of the choice.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from rolling.run import folder as folders
from rolling.terminal import progress, whole_files
from rolling.terminal.whole_files import FolderError, read_regular

CHOICE = "choice.json"
PAGE = "choice.html"
TABLE = "choice.csv"
PICTURE = "choice.png"
RUNS = "runs"
MAX_CHOICE = 10_000_000  # bytes of choice.json
_ENDINGS = (".json", ".html", ".csv", ".png", ".wav")  # of the files beside the runs
_UNKNOWN = "an older version"  # which did not write its name


def take(folder: Path, formats: tuple[str, ...]) -> dict[str, Any] | None:
    """Return what is stored of a choice that goes on in a folder; None for one that begins.

    An unfinished choice that version 0.8.0 or an older one began starts anew, beside its files.

    Parameters
    ----------
    folder : Path. Folder of the choice, which may not exist.
    formats : tuple of str. The format of this program, and older ones.

    Raises
    ------
    FolderError : the folder holds something else, or a choice of another program.
    """
    if not folder.exists() and not folder.is_symlink():
        return None
    if not folder.is_dir():
        raise FolderError(f"{folder}: not a folder")
    # A lock, and files that a killed command half wrote, begin with a dot.
    if all(path.name.startswith(".") for path in folder.iterdir()):
        return None
    way_out = f"take another --out, such as {folders.free_name(folder)}"
    stored = _stored(folder / CHOICE)
    if stored is None or stored.get("format") not in formats:
        raise FolderError(f"{folder}: holds no choice, but other files; {way_out}")
    maker = str(stored.get("program", _UNKNOWN))
    if maker == folders.this_program():
        return stored
    is_finished = "sentences" in stored or any(folder.glob("*.csv"))
    if is_finished or (folder / RUNS).exists() or _has_folder_of_file(folder):
        raise FolderError(
            f"{folder}: holds a choice of {maker}, and this is {folders.this_program()}; numbers"
            f" of two programs are not mixed, so {way_out}, or delete the folder"
        )
    progress.line(
        f"{folder}: holds an unfinished choice of {maker}, and this is {folders.this_program()};"
        " numbers of two programs are not mixed, so the choice starts anew, and older runs stay"
    )
    return None


def _has_folder_of_file(folder: Path) -> bool:
    """Tell whether a candidate of an older version has a folder by the name of a file.

    The files of a choice, which are written last, could not be written.
    """
    return any(path.suffix in _ENDINGS and path.is_dir() for path in folder.iterdir())


def _stored(path: Path) -> dict[str, Any] | None:
    """Return the content of choice.json; None for a missing or damaged file."""
    try:
        stored = json.loads(read_regular(path, MAX_CHOICE))
    except (OSError, ValueError, RecursionError):
        return None
    return stored if isinstance(stored, dict) else None


def begin(folder: Path, format_: str) -> None:
    """Write who began a choice."""
    whole_files.write_json(folder / CHOICE, {"format": format_, "program": folders.this_program()})
