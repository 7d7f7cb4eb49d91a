"""The numbers of a run in its folder: numbers.json, and summary.json, their view for people.

They are read with a bound on their size, and have the types of their fields. Runs of balls and of
bearings are written and read in the same way.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from rolling.contact.processor_time import ProcessorTime
from rolling.marches import effort
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.run_file import StoredBearing, StoredNumbers
from rolling.numbers.stored import from_bytes, summary_of, to_bytes
from rolling.results.former_numbers import former_numbers
from rolling.results.run_folder import (
    MAX_NUMBERS,
    NUMBERS,
    SUMMARY,
    RunFolder,
    is_former,
)
from rolling.scene.height_files import read_regular
from rolling.terminal import files
from rolling.terminal.files import FolderError

_ADVICE = "delete it, and the same command solves the run again"
_Stored = TypeVar("_Stored", StoredNumbers, StoredBearing)


def read_stored(folder: Path) -> StoredNumbers:
    """Read the numbers of a run of a ball from its folder.

    Raises
    ------
    FolderError : the file is damaged, or not written by this program.
    """
    return read_kind(folder, StoredNumbers, former_numbers)


def read_kind(folder: Path, kind: type[_Stored], former: Callable[[bytes], _Stored]) -> _Stored:
    """Read the numbers of a kind of run from its folder.

    Those of a folder of version 0.8 are read from its summary.json, by the function `former`.

    Raises
    ------
    FolderError : the file is damaged, or not written by this program.
    """
    path = folder / NUMBERS
    if is_former(folder):
        path = folder / SUMMARY
    try:
        content = read_regular(path, MAX_NUMBERS)
        if path.name == SUMMARY:
            return former(content)
        stored = from_bytes(kind, content)
        if stored.format != kind.format or stored.kind != kind.kind:
            raise ValueError(f"format {stored.format} of a {stored.kind}")
    except OSError as error:
        reason = error.strerror or str(error)
        raise FolderError(f"{path}: not readable ({reason}); {_ADVICE}") from error
    except (ValueError, RecursionError) as error:
        raise FolderError(f"{path}: not readable ({error}); {_ADVICE}") from error
    return stored


def write_stored(folder: Path, stored: StoredNumbers | StoredBearing) -> None:
    """Write the numbers of a run into its folder, last their view, which tells that it is whole.

    Raises
    ------
    OSError : a file cannot be written. An earlier file is kept.
    """
    files.write_bytes(folder / NUMBERS, to_bytes(stored))
    view: dict[str, Any] = {
        "format": stored.format,
        "kind": stored.kind,
        **summary_of(stored.numbers),
        "files": summary_of(stored.files),
        "provenance": summary_of(stored.provenance),
    }
    files.write_json(folder / SUMMARY, view)


def numbers_of(run: RunFolder) -> RunNumbers | None:
    """Return the numbers of a run, from its folder unless it is in memory; None without any."""
    numbers: RunNumbers | None = getattr(run, "numbers", None)
    if numbers is None and (run.folder / SUMMARY).is_file():
        numbers = read_stored(run.folder).numbers
    return numbers


def with_page(stored: _Stored, spent: ProcessorTime, runs: int) -> _Stored:
    """Return stored numbers with the share of the run in the time of a page of so many runs."""
    known = stored.numbers.effort.parts_cpu_s or {}
    return with_parts(stored, effort.with_page(known, spent, runs))


def with_parts(stored: _Stored, parts_cpu_s: dict[str, float | None]) -> _Stored:
    """Return stored numbers with other processor times [s] of the parts of the run."""
    own = replace(stored.numbers.effort, parts_cpu_s=parts_cpu_s)
    return replace(stored, numbers=replace(stored.numbers, effort=own))
