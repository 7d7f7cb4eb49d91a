"""The numbers of a run in its folder: numbers.json, and summary.json, their view for people.

They are read with a bound on their size, and have the types of their fields.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from rolling.contact.processor_time import ProcessorTime
from rolling.marches import effort
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.run_file import FORMAT, KIND, StoredNumbers
from rolling.numbers.stored import from_bytes, summary_of, to_bytes
from rolling.results.former_numbers import former_numbers
from rolling.results.run_folder import NUMBERS, SUMMARY, RunFolder
from rolling.scene.height_files import read_regular
from rolling.terminal import files
from rolling.terminal.files import FolderError

MAX_NUMBERS = 10_000_000  # bytes
_ADVICE = "delete it, and the same command solves the run again"


def read_stored(folder: Path) -> StoredNumbers:
    """Read the numbers of a run from its folder; those of a folder of 0.8 from its summary.json.

    Raises
    ------
    FolderError : the file is damaged, or not written by this program.
    """
    path = folder / NUMBERS
    if not path.is_file() and (folder / SUMMARY).is_file():
        path = folder / SUMMARY
    try:
        content = read_regular(path, MAX_NUMBERS)
        if path.name == SUMMARY:
            return former_numbers(content)
        stored = from_bytes(StoredNumbers, content)
        if stored.format != FORMAT or stored.kind != KIND:
            raise ValueError(f"format {stored.format} of a {stored.kind}")
    except OSError as error:
        reason = error.strerror or str(error)
        raise FolderError(f"{path}: not readable ({reason}); {_ADVICE}") from error
    except (ValueError, RecursionError) as error:
        raise FolderError(f"{path}: not readable ({error}); {_ADVICE}") from error
    return stored


def write_stored(folder: Path, stored: StoredNumbers) -> None:
    """Write the numbers of a run into its folder, last their view, which tells that it is whole.

    Raises
    ------
    OSError : a file cannot be written. An earlier file is kept.
    """
    files.write_bytes(folder / NUMBERS, to_bytes(stored))
    view = {
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


def with_page(stored: StoredNumbers, spent: ProcessorTime, runs: int) -> StoredNumbers:
    """Return stored numbers with the share of the run in the time of a page of so many runs."""
    numbers = stored.numbers
    parts = effort.with_page(numbers.effort.parts_cpu_s or {}, spent, runs)
    own = replace(numbers.effort, parts_cpu_s=parts)
    return replace(stored, numbers=replace(numbers, effort=own))
