"""Run folders of this version and of version 0.1.0, told from all others by their names alone."""

from __future__ import annotations

from pathlib import Path

from rolling.folders import claim, new_folder, run_record
from rolling.folders.files import FolderError
from rolling.folders.run_record import RunRecord

KINDS = ("run", "sweep")
SCENE = "resolved.yaml"
RESULT = "result.h5"


def record_of_runs(folder: Path) -> RunRecord | None:
    """Read the record of a run folder; None for one of version 0.1.0.

    Raises
    ------
    FolderError : the folder is no run folder.
    """
    record = run_record.read(folder)
    if record is not None and record.kind not in KINDS:
        raise FolderError(
            f"{folder}: not a run folder, but that of another command ({record.kind})"
        )
    if not (folder / SCENE).is_file() and not is_brief(folder):
        raise FolderError(f"{folder}: not a run folder (no {SCENE} in it){_hint(folder, record)}")
    return record


def is_brief(folder: Path) -> bool:
    """Return whether a folder belongs to a run whose scene stands in its result alone."""
    record = run_record.read(folder)
    return (
        record is not None
        and record.kind == "run"
        and not (folder / SCENE).exists()
        and (folder / RESULT).is_file()
    )


def _hint(folder: Path, record: RunRecord | None) -> str:
    """Say why a folder may hold no run, if that can be told."""
    old = new_folder.previous(folder) if folder.name not in ("", "..") else folder
    if owner := claim.owner_of(folder):
        return f"; nothing is solved in it yet, `rolling resume {owner}` goes on with its sweep"
    if not folder.exists() and run_record.read(old) is not None:
        return f"; a command was killed while it replaced the folder, {old} holds the run before it"
    if record is not None:
        return "; a command was killed while it made the folder, give it again with --force"
    return ""
