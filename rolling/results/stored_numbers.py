"""The numbers of a run in its folder: numbers.json, and summary.json, their view for people.

They are read with a bound on their size, and have the types of their fields. Runs of balls and of
bearings are written and read in the same way.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from rolling.contact.processor_time import ProcessorTime
from rolling.kinds.kind import Kind
from rolling.kinds.registry import kind_named, kind_of, scene_types
from rolling.kinds.run_folder import (
    MAX_NUMBERS,
    NUMBERS,
    SUMMARY,
    RunFolder,
    is_former,
)
from rolling.marches import effort
from rolling.numbers.number_files import from_bytes, summary_of, to_bytes
from rolling.terminal import whole_files
from rolling.terminal.whole_files import FolderError, read_regular

_ADVICE = "delete it, and the same command solves the run again"


def read_stored(folder: Path, kind: str = "") -> Any:
    """Read the numbers of a run from its folder, as its kind stores them.

    Those of a folder of version 0.8 are read from its summary.json.

    Parameters
    ----------
    folder : Path
        The folder of the run.
    kind : str
        Name of the kind that the run must have. Default: any.

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
            return _of_kind(_former(content), kind)
        stored_type = _kind_of_content(content).stored_type
        stored = from_bytes(stored_type, content)
        if stored.format != stored_type.format:
            raise ValueError(f"format {stored.format} of a {stored.kind}")
        return _of_kind(stored, kind)
    except OSError as error:
        reason = error.strerror or str(error)
        raise FolderError(f"{path}: not readable ({reason}); {_ADVICE}") from error
    except (ValueError, RecursionError) as error:
        raise FolderError(f"{path}: not readable ({error}); {_ADVICE}") from error


def _of_kind(stored: Any, kind: str) -> Any:
    """Return stored numbers; raise ValueError where they are of another kind than a wanted one."""
    if kind and stored.kind != kind:
        raise ValueError(f"numbers of the kind {stored.kind}")
    return stored


def _kind_of_content(content: bytes) -> Kind:
    """Return the kind whose numbers a file has; raise ValueError where it names none."""
    values = json.loads(content)
    name = values.get("kind") if isinstance(values, dict) else None
    if name not in scene_types():
        raise ValueError(f"numbers of the kind {name}")
    return kind_named(str(name))


def _former(content: bytes) -> Any:
    """Return the numbers of a summary.json of version 0.8; raise ValueError where it is none."""
    values = json.loads(content)
    written = values.get("format") if isinstance(values, dict) else None
    for name in scene_types():
        kind = kind_named(name)
        if kind.former_format == written:
            return kind.former_stored(content)
    raise ValueError(f"the file beside it, {NUMBERS}, is missing")


def write_stored(folder: Path, stored: Any) -> None:
    """Write the numbers of a run into its folder, last their view, which tells that it is whole.

    Raises
    ------
    OSError : a file cannot be written. An earlier file is kept.
    """
    whole_files.write_bytes(folder / NUMBERS, to_bytes(stored))
    view: dict[str, Any] = {
        "format": stored.format,
        "kind": stored.kind,
        **summary_of(stored.numbers),
        "files": summary_of(stored.files),
        "provenance": summary_of(stored.provenance),
    }
    whole_files.write_json(folder / SUMMARY, view)


def numbers_of(run: RunFolder) -> Any | None:
    """Return the numbers of a run, from its folder unless it is in memory; None without any."""
    numbers = getattr(run, "numbers", None)
    if numbers is None and (run.folder / SUMMARY).is_file():
        numbers = read_stored(run.folder, kind_of(run.scene).name).numbers
    return numbers


def with_page(stored: Any, spent: ProcessorTime, runs: int) -> Any:
    """Return stored numbers with the share of the run in the time of a page of so many runs."""
    known = stored.numbers.effort.parts_cpu_s or {}
    return with_parts(stored, effort.with_page(known, spent, runs))


def with_parts(stored: Any, parts_cpu_s: dict[str, float | None]) -> Any:
    """Return stored numbers with other processor times [s] of the parts of the run."""
    own = replace(stored.numbers.effort, parts_cpu_s=parts_cpu_s)
    return replace(stored, numbers=replace(stored.numbers, effort=own))
