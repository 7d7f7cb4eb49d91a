"""The runs that are stored in run folders of this version and of version 0.1.0."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from rolling.check import tolerance
from rolling.folders import program, run_folder, run_record
from rolling.folders.files import FolderError
from rolling.folders.run_record import RunRecord
from rolling.scene import file
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.scene.sweep import run_name
from rolling.simulation import batch, chosen_tolerances, result_file
from rolling.simulation.batch import Run
from rolling.simulation.result import Result


def read_runs(folder: Path) -> list[Run]:
    """Return the runs of a run folder.

    Raises
    ------
    FolderError : the folder is not a run folder, two of its runs share a folder, or a run in it has
        another scene than the sweep.
    SceneError : the scene of the folder cannot be read.
    """
    record = run_folder.record_of_runs(folder)
    singles = resolved_scene(folder).runs()
    short = [run_name(values) for values, _ in singles]  # as version 0.1.0 named them
    names = list(record.runs) if record is not None and record.kind == "sweep" else short
    if len(names) != len(singles) or (
        record is not None and (record.kind == "run") != (singles[0][0] == {})
    ):
        raise FolderError(
            f"{folder}: run.json and resolved.yaml do not fit each other; "
            "one of them is of another scene"
        )
    if shared := [name for name, count in Counter(names).items() if count > 1]:
        raise FolderError(
            f"{folder}: several runs share the folder {shared[0]}, because version 0.1.0 gave "
            "values that print alike one name;"
            " all but the last of them are lost: run the scene again"
        )
    runs = [
        with_chosen_tolerance(Run(values, single, folder / name))
        for (values, single), name in zip(singles, names, strict=True)
    ]
    for run in runs:
        batch.refuse_other_scene(run)
    return runs


def with_chosen_tolerance(run: Run) -> Run:
    """Return a run with the tolerance that was chosen for it, if its folder has one.

    The scene of a sweep leaves the tolerance open, and each of its runs has its own.
    """
    if not tolerance.is_open(run.scene):
        return run
    resolved, result = run.folder / batch.RESOLVED, run.folder / batch.RESULT
    chosen: Any = None
    if run.values and resolved.is_file():
        chosen = file.read_scene(resolved).numerics.tolerance
    elif result.is_file():
        chosen = result_file.physics(result).get("numerics.tolerance")
    if chosen in (None, "auto"):  # a kill came before they were written
        trial = chosen_tolerances.recorded_trial(run.folder)
        chosen = None if trial is None else trial.tolerance
    if chosen is None:
        return run
    return replace(run, scene=run.scene.with_({"numerics.tolerance": chosen}))


def resolved_scene(folder: Path) -> Scene:
    """Read the resolved scene of a run folder.

    A run of a large sweep has its scene in result.h5. Version 0.1.0 did not write `surface.level`
    and did not level the heights of a file.

    Raises
    ------
    SceneError : the scene cannot be read.
    """
    path = folder / "resolved.yaml"
    if run_folder.is_brief(folder):
        result = folder / batch.RESULT
        return file.loads(result_file.scene_text(result), [], str(result), folder)
    scene = file.read_scene(path)
    if isinstance(scene.surface, HeightFile) and "level" not in scene.surface.model_fields_set:
        return file.read_scene(path, ["surface.level=none"])
    return scene


def is_kept(run: Run) -> bool:
    """Return whether the folder of a run holds a solved step."""
    try:
        return (run.folder / batch.RESULT).is_file() and is_begun(
            result_file.load(run.folder / batch.RESULT)
        )
    except (FolderError, OSError):
        return False


def is_begun(result: Result) -> bool:
    """Return whether at least one step of a result is solved."""
    return bool(np.isfinite(result.series["release_energy"]).any())


def records_of(folders: Sequence[Path]) -> list[RunRecord | None]:
    """Read the records of folders, and warn about folders that have none."""
    records = [run_record.read(folder) for folder in folders]
    if old := [
        str(folder) for folder, record in zip(folders, records, strict=True) if record is None
    ]:
        print(
            f"warning: {', '.join(old)}: made by version 0.1.0 (no run.json), which recorded"
            " neither the state of a run nor the program that made it",
            file=sys.stderr,
        )
    return records


def warn_of_other_program(folder: Path, before: RunRecord, partly: bool) -> None:
    """Warn if the results of a folder are partly solved, by another version of the program."""
    ours = program.identity()
    if before.sources != ours.sources and partly:
        print(
            f"warning: {folder}: begun by version {before.version} (sources "
            f"{before.sources[:12]}), goes on with"
            f" version {ours.version} (sources {ours.sources[:12]})",
            file=sys.stderr,
        )
