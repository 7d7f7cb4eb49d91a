"""Refusals to replace a folder: nothing foreign, in use or still needed is lost."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from rolling.folders import claim, own_files, run_record
from rolling.folders.files import FolderError
from rolling.folders.run_record import Kind, RunRecord


@dataclass(frozen=True)
class Target:
    """Folder that may be made.

    Attributes
    ----------
    folder : Path
        Folder itself, or its parent if `stamped`.
    stamped : bool
        If true, the folder is named after the time.
    replaces : bool
        If true, the new folder replaces a folder of this program.
    kinds : tuple of Kind
        Kinds of folders that the command makes, and may replace.
    inputs : tuple of Path
        Files and folders that the command reads.
    """

    folder: Path
    stamped: bool
    replaces: bool
    kinds: tuple[Kind, ...]
    inputs: tuple[Path, ...]


def marked(folder: Path, kinds: Sequence[Kind]) -> RunRecord:
    """Read the record of a folder of this program.

    Raises
    ------
    FolderError
        The folder belongs to another program, or is of another kind.
    """
    record = run_record.read(folder)
    if record is None:
        if (folder / "resolved.yaml").is_file() or (folder / "accuracy.json").is_file():
            raise FolderError(
                f"{folder}: holds a run of version 0.1.0 (no run.json), which is never replaced;"
                " take another --out, or remove it yourself"
            )
        raise FolderError(
            f"{folder}: holds something that is no {named(kinds)} of this program; take another"
            " --out"
        )
    if record.kind not in kinds:
        raise FolderError(
            f"{folder}: is the folder of another command ({record.kind}); take another --out"
        )
    return record


def named(kinds: Sequence[Kind]) -> str:
    """Return the word for a folder of the first of these kinds."""
    return {"accuracy": "study of accuracy", "hard-cases": "table of hard cases"}.get(
        kinds[0], kinds[0]
    )


def refuse_losses(target: Target, old: Path, record: RunRecord) -> None:
    """Raise FolderError if replacing the folder would lose data or disturb other work.

    `old` is the folder of an earlier run beside it, which would be removed.
    """
    out = target.folder
    if out.is_symlink():
        raise FolderError(
            f"{out}: a symbolic link, which is not replaced; give --out the folder {out.resolve()}"
        )
    if owner := claim.owner_of(out):
        raise FolderError(
            f"{out}: a run of the sweep in {owner}, which would hold two scenes; take another --out"
        )
    _refuse_loss(out, record, target.inputs)
    if os.path.lexists(old):
        if old.is_symlink() or not old.is_dir():
            raise FolderError(f"{old}: the name for the replaced folder is taken; move it away")
        _refuse_loss(old, marked(old, target.kinds), target.inputs)


def _refuse_loss(folder: Path, record: RunRecord, inputs: Sequence[Path]) -> None:
    """Raise FolderError if removing a folder would lose data."""
    if record.adopted:
        raise FolderError(
            f"{folder}: made by version 0.1.0 and never replaced; take another --out, or remove it"
            " yourself"
        )
    for path in inputs:
        if contains(folder, path):
            raise FolderError(
                f"{folder}: {path}, which this command reads, lies in it; take another --out"
            )
    if contains(folder, Path.cwd()):
        raise FolderError(f"{folder}: holds the working directory; take another --out")
    claim.refuse_folder_in_use(folder, record)
    if others := own_files.foreign(folder, record):
        names = ", ".join(str(path.relative_to(folder)) for path in others[:3])
        more = f" and {len(others) - 3} more" if len(others) > 3 else ""
        raise FolderError(
            f"{folder}: not replaced, because this program did not write {names}{more} in it;"
            " move that away, or take another --out"
        )


def contains(folder: Path, path: Path) -> bool:
    """Tell whether a folder is the path or holds it, however both are written."""
    own = path.resolve()
    for above in (own, *own.parents):
        with suppress(OSError):
            if above.samefile(folder):
                return True
    return False
