"""Refusals that need no solver: they come before its import, which takes seconds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rolling.check import long_steps, refusals
from rolling.folders import new_folder, run_folder
from rolling.folders.run_record import Kind
from rolling.scene import file


def refuse_scene(
    path: Path, overrides: Sequence[str], out: Path | None, force: bool, kinds: Sequence[Kind]
) -> None:
    """Refuse a scene for its text, or the folder that it would be run in.

    Parameters
    ----------
    path : Path. The scene file.
    overrides : sequence of str. Values of keys, as after --set.
    out : Path or None. The folder to make.
    force : bool. Whether an older folder may be replaced.
    kinds : sequence of Kind. The kinds of folders that the command makes.

    Raises
    ------
    SceneError, FolderError : the scene or the folder cannot be used.
    """
    scene = file.read_scene(path, overrides)
    refusals.refuse_unavailable(scene)
    long_steps.refuse_long_steps(scene)
    if out is not None:
        new_folder.aim(out, out, force, kinds)


def refuse_folders(folders: Sequence[Path]) -> None:
    """Refuse folders that hold no runs.

    Raises
    ------
    FolderError : a folder is no run folder.
    """
    for folder in folders:
        run_folder.record_of_runs(folder)
