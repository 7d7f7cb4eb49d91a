"""Names of the files that this program writes; other files in its folders are foreign.

Foreign files are never removed.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from rolling.folders import run_record
from rolling.folders.claim import LOCK, PARTS
from rolling.folders.files import FolderError
from rolling.folders.run_record import RunRecord

_PICTURES = [
    "spectrum",
    "article_spectrum",
    "psd",
    "third_octaves",
    "third_octaves_a",
    "third_octaves_of_seeds",
    "levels",
    "spectrogram",
    "release_power",
    "surface",
    "contact",
    "recovery_events",
    "sources",
    "contact_force",
    "contact_filter",
    "mobilities",
    "speed_slopes",
]
_INPUTS = [run_record.FILE, "scene.yaml", "resolved.yaml"]
_OF_ALL = [
    *_INPUTS,
    "report.html",
    *(f"{name}.{ending}" for name in _PICTURES for ending in ("png", "svg", "csv")),
]
_OF_A_RUN = [
    "result.h5",
    "summary.json",
    "provenance.json",
    "signal.wav",
    "signal.json",
    "listen.wav",
    "listen.json",
    "extended.wav",
    "extended.json",
]
_OF_A_SWEEP = [
    "sweep.json",
    *(
        f"{name}.{ending}"
        for name in ("runs", "bands", "statistics")
        for ending in ("csv", "parquet")
    ),
    *(f"mean_third_octaves.{ending}" for ending in ("png", "svg", "csv")),
]

# These are the names by kind of folder. Folders of other kinds are never replaced.
FILES: dict[str, frozenset[str]] = {
    "run": frozenset([*_OF_ALL, *_OF_A_RUN]),
    "sweep": frozenset([*_OF_ALL, *_OF_A_SWEEP]),
    "accuracy": frozenset(
        [*_INPUTS, "study.json", *(f"accuracy.{ending}" for ending in ("json", "md", "png", "svg"))]
    ),
}
VARIANTS = "variants"  # folder of an accuracy study
_VARIANT = re.compile(
    r"spacing-over-\d+_step-[\d.e+-]+_[\d.]+e-?\d+_[a-z]+_[a-z]+(_width-\d+)?"
    r"(\.json|_\d+-\d+\.npz)"  # numbers, and pieces of a study that is not done
)
_PLOT = re.compile(r"plot_[\w.]+_against_[\w.]+\.(png|svg|csv)")  # of `rolling table`
_PARTIAL = re.compile(r"\.(.+?)(\.[0-9a-f]{16})?\.partial")


@dataclass(frozen=True)
class Contents:
    """Contents of a folder of this program: its own files and folders, and foreign entries.

    Inner files and folders come first.
    """

    files: list[Path]
    folders: list[Path]
    foreign: list[Path]


def contents(folder: Path, record: RunRecord) -> Contents:
    """Separate the files of this program in a folder and its runs from foreign files.

    Raises
    ------
    FolderError
        The folder cannot be read.
    """
    result = Contents([], [], [])
    _sort_run(folder, record, result)
    return result


def foreign(folder: Path, record: RunRecord) -> list[Path]:
    """Return the foreign entries in a folder of this program.

    Raises
    ------
    FolderError
        The folder cannot be read.
    """
    return contents(folder, record).foreign


def remove(folder: Path, record: RunRecord) -> bool:
    """Remove a folder of this program unless foreign files are in it.

    Its run.json goes last. Return whether the folder is gone.
    """
    with suppress(FolderError, OSError):
        inside = contents(folder, record)
        if inside.foreign:
            return False
        marker = folder / run_record.FILE
        for file in inside.files:
            if file != marker:
                file.unlink(missing_ok=True)
        for inner in inside.folders[:-1]:
            inner.rmdir()
        marker.unlink(missing_ok=True)
        folder.rmdir()
        return True
    return False


def refuse_file(out: Path, force: bool, is_page: Callable[[Path], bool]) -> None:
    """Raise FolderError if a report page may not be written to a file.

    Parameters
    ----------
    force : bool
        If true, a page of this program may be replaced.
    is_page : callable
        Function that tells whether a file is such a page.
    """
    if not os.path.lexists(out):
        return
    if out.is_symlink():
        raise FolderError(f"{out}: a symbolic link, which is not replaced; take another --out")
    if not out.is_file():
        raise FolderError(
            f"{out}: {'is a folder' if out.is_dir() else 'is no file'}, --out is the file to write"
        )
    if not force:
        raise FolderError(
            f"{out}: exists; take another --out, or --force to replace a page of this program"
        )
    try:
        replaceable = is_page(out)
    except OSError as error:
        raise FolderError(
            f"{out}: not readable ({error.strerror or error}), so it is not replaced"
        ) from error
    if not replaceable:
        raise FolderError(
            f"{out}: not replaced, because it is not a page that this version can tell as its own;"
            " take another --out"
        )


def _sort_run(folder: Path, record: RunRecord, into: Contents) -> None:
    """Sort the entries of a folder of this program."""
    own = FILES.get(record.kind, frozenset())
    for entry in _entries(folder):
        path = Path(entry.path)
        if not entry.is_dir(follow_symlinks=False):
            plotted = record.kind == "sweep" and _is_own(entry, None, _PLOT)
            is_own = plotted or _is_own(entry, own)
            (into.files if is_own else into.foreign).append(path)
        elif entry.name in record.runs:
            _sort_inner(path, into)
        elif record.kind == "sweep" and entry.name == PARTS:
            _sort_parts(path, into)
        elif record.kind == "accuracy" and entry.name == VARIANTS:
            for each in _entries(path):
                (into.files if _is_own(each, None) else into.foreign).append(Path(each.path))
            into.folders.append(path)
        else:
            into.foreign.append(path)
    into.folders.append(folder)


def _sort_parts(folder: Path, into: Contents) -> None:
    """Sort the parts of a sweep, which have nothing but their records."""
    for part in _entries(folder):
        if not part.is_dir(follow_symlinks=False):
            into.foreign.append(Path(part.path))
            continue
        for entry in _entries(Path(part.path)):
            own = _is_own(entry, frozenset([run_record.FILE]))
            (into.files if own else into.foreign).append(Path(entry.path))
        into.folders.append(Path(part.path))
    into.folders.append(folder)


def _sort_inner(folder: Path, into: Contents) -> None:
    """Sort a run of a sweep; all of it is foreign when its record is foreign."""
    try:
        record = run_record.read(folder) or run_record.new("run")  # killed before it was written
    except FolderError:
        record = None
    if record is not None and record.kind == "run" and not record.runs:
        _sort_run(folder, record, into)
    else:
        into.foreign.append(folder)


def _is_own(
    entry: os.DirEntry[str], names: frozenset[str] | None, pattern: re.Pattern[str] = _VARIANT
) -> bool:
    """Tell whether an entry is a file with one of the names.

    `names` None stands for the pattern.

    Temporary files of killed writes count as well.
    """
    if not entry.is_file(follow_symlinks=False):
        return False
    partial = _PARTIAL.fullmatch(entry.name)
    name = partial[1] if partial else entry.name
    return bool(pattern.fullmatch(name)) if names is None else name in names or entry.name == LOCK


def _entries(folder: Path) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(folder) as entries:
            return sorted(entries, key=lambda entry: entry.name)
    except OSError as error:
        raise FolderError(f"{folder}: not readable ({error.strerror or error})") from error
