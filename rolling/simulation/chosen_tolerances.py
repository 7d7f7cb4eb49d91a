"""Tolerances that scenes leave open: chosen by trials, and kept in the folders of the runs."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from rolling.folders import run_record
from rolling.folders.files import FolderError, Unwritable, write_bytes, writing
from rolling.scene import file
from rolling.scene.scene import Scene
from rolling.simulation import batch, tolerance_trial
from rolling.simulation.batch import Run
from rolling.simulation.pool import Workers
from rolling.simulation.result import Result
from rolling.simulation.stretches import Trial

_TRIAL = TypeAdapter(Trial)


def choose_tolerances(
    runs: list[Run],
    results: Sequence[Result],
    workers: Workers,
    noted: Callable[[Path, dict[str, Any]], object],
) -> bool:
    """Choose the tolerances that scenes leave open, and keep each in the folder of its run.

    Parameters
    ----------
    runs : list of Run. Runs that are open get scenes with their tolerances.
    results : sequence of Result. One result per run, which gets the trial.
    workers : int or Cluster. Number of processes; 0: one per core.
    noted : callable. It keeps the choice of the run in a folder, before anything else is written.

    Returns
    -------
    interrupted : Whether the trials were interrupted, so that some runs are still open.
    """

    def chosen(number: int, scene: Scene) -> None:
        runs[number] = replace(runs[number], scene=scene)
        try:
            with writing(runs[number].folder):
                _keep_choice(runs[number], results[number], noted)
        except Unwritable as error:  # which its solving says of a run of a sweep
            if error.everywhere or not runs[number].values:
                raise

    scenes = [run.scene for run in runs]
    return tolerance_trial.choose(scenes, results, workers, chosen=chosen).interrupted


def choose_tolerance(
    run: Run,
    result: Result,
    stopped: Callable[[], bool],
    noted: Callable[[Path, dict[str, Any]], object],
) -> Run:
    """Choose the tolerance of a run in this process, and keep it in the folder of the run.

    `noted` keeps the choice, as in `choose_tolerances`.

    Raises
    ------
    ContactError, Interrupted : as in the tasks of the run.
    """
    scene = tolerance_trial.choose_here(run.scene, result, stopped)
    if scene is run.scene:
        return run
    chosen = replace(run, scene=scene)
    _keep_choice(chosen, result, noted)
    return chosen


def _keep_choice(run: Run, result: Result, noted: Callable[[Path, dict[str, Any]], object]) -> None:
    """Keep the tolerance that was chosen for a run in its folder."""
    resolved = run.folder / batch.RESOLVED
    assert result.trial is not None
    noted(run.folder, vars(result.trial))
    if resolved.is_file():
        write_bytes(resolved, file.dump(batch.seen_from(run.folder, run.scene)).encode())
    if result.trial.stretches:
        batch.keep(run, result)


def stored_or_empty(run: Run) -> Result:
    """Load the stored result of a run, or return an empty one with the choice of its tolerance.

    Raises
    ------
    FolderError, SceneError : as in `stored`, or the record of the run is damaged.
    """
    result = batch.stored(run)
    if result is None:
        result = Result.empty(run.scene.track, run.scene.start)
        trial = recorded_trial(run.folder)
        if trial is not None and trial.tolerance == run.scene.numerics.tolerance:
            result.trial = trial
    return result


def recorded_trial(folder: Path) -> Trial | None:
    """Return the choice of a tolerance in the record of a run, or None.

    Raises
    ------
    FolderError : the record is damaged.
    """
    record = run_record.read(folder)
    if record is None or record.trial is None:
        return None
    try:
        return _TRIAL.validate_json(json.dumps(record.trial), strict=True)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        raise FolderError(
            f"{folder / run_record.FILE}: damaged: trial.{fault['loc'][0]}: {fault['msg']}"
        ) from error
