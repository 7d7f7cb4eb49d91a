"""Refusals that need no solver: they come before its import, which takes seconds.

Each refusal is checked before the modules of the next one are imported, so that a misspelt file
name is answered at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rolling.folders.run_record import Kind
    from rolling.scene.scene import Scene


def read_scene(path: Path, overrides: Sequence[str]) -> Scene:
    """Read a scene, whose file is looked for before the scene's models are built.

    Raises
    ------
    SceneError : the file cannot be read, or has faults.
    """
    from rolling.scene import library, messages, yaml_text

    try:
        yaml_text.read_text(library.find(path))
    except yaml_text.TextError as error:
        raise messages.SceneError([str(error)]) from error
    from rolling.scene import file

    return file.read_scene(path, overrides)


def refuse_scene(
    path: Path,
    overrides: Sequence[str],
    out: Path | None,
    force: bool,
    kinds: Sequence[Kind],
    first: bool = False,
) -> None:
    """Refuse a scene for its text, or the folder that it would be run in.

    Parameters
    ----------
    path : Path. The scene file.
    overrides : sequence of str. Values of keys, as after --set.
    out : Path or None. The folder to make.
    force : bool. Whether an older folder may be replaced.
    kinds : sequence of Kind. The kinds of folders that the command makes.
    first : bool. Whether the first run of a sweep is run alone. Default: false.

    Raises
    ------
    SceneError, FolderError : the scene or the folder cannot be used.
    """
    scene = read_scene(path, overrides)
    from rolling.check import long_steps, refusals

    refusals.refuse_unavailable(scene)
    long_steps.refuse_long_steps(scene.runs()[0].scene if first else scene)
    if out is not None:
        from rolling.folders import new_folder

        heights = [scene.height_path] if scene.height_path is not None else []
        new_folder.aim(out, out, force, kinds, [path, *heights])


def refuse_folders(folders: Sequence[Path]) -> None:
    """Refuse folders that hold no runs.

    Raises
    ------
    FolderError : a folder is no run folder.
    """
    from rolling.folders import run_folder

    for folder in folders:
        run_folder.record_of_runs(folder)
