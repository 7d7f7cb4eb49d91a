"""Runs that were finished before, and the numbers that a verbose command adds."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rolling.check import cost, finding
from rolling.folders import claim, run_record
from rolling.scene.scene import Scene
from rolling.simulation import batch, labels, moving_release
from rolling.simulation.batch import Run
from rolling.simulation.lacking import lacks_marches
from rolling.simulation.result import Result
from rolling.simulation.stored_runs import is_begun
from rolling.terminal import progress

SUMMARY = "summary.json"


def numbers_of_finished(runs: Sequence[Run]) -> list[dict[str, Any]] | None:
    """Read the summaries of runs, None when a step or a summary is missing."""
    for run in runs:
        result = batch.stored(run)
        if result is None or not (run.folder / SUMMARY).is_file():
            return None
        if lacks_marches(run.scene, result):  # estimate or dynamics may be asked for afterwards
            return None
    return [json.loads((run.folder / SUMMARY).read_text(encoding="utf-8")) for run in runs]


def sweep_to_finish(folder: Path) -> Path | None:
    """Return the sweep of a run when all its runs are done and the sweep itself is not."""
    owner = claim.owner_of(folder)
    record = run_record.read(owner) if owner else None
    if owner is None or record is None or record.kind != "sweep" or record.state == "done":
        return None
    states = [run_record.read(owner / name) for name in record.runs]
    return owner if all(state and state.state == "done" for state in states) else None


def tell(runs: Sequence[Run], results: Sequence[Result]) -> None:
    """Say steps, window, iterations and time of each run that is begun, in a verbose command."""
    for label, result in zip(labels.labels(runs), results, strict=True):
        if progress.is_verbose() and is_begun(result):
            progress.detail(f"{label}: {_text(result)}")


def tell_releases(scenes: Sequence[Scene], results: Sequence[Result]) -> int:
    """Say how many releases under the moving load are missing, and what leaves them out.

    Returns
    -------
    missing : The number of them.
    """
    return tell_marches(
        [
            scene
            for scene, result in zip(scenes, results, strict=True)
            if moving_release.is_missing(scene, result)
        ]
    )


def tell_marches(scenes: Sequence[Scene]) -> int:
    """Say how many scenes that are to be solved ask for a release under the moving load.

    Returns
    -------
    missing : The number of them.
    """
    missing = [scene for scene in scenes if scene.moves_release]
    if missing:
        seconds = sum(map(cost.expected_seconds, missing)) / cost.cores()
        marches = "one march" if len(missing) == 1 else f"{len(missing)} marches"
        progress.line(
            f"release under the moving load: {marches}, about {finding.clock(seconds)} on"
            f" {finding.on_cores()}; --set dynamics.release=false leaves it out"
        )
    return len(missing)


def _text(result: Result) -> str:
    """Write steps, window, iterations and time of a run."""
    solved = int(np.isfinite(result.series["release_energy"]).sum())
    iterations = result.series["iterations"]
    window = ""
    if result.snapshot is not None:
        rows, columns = result.snapshot.pressure.shape
        window = f" window {rows} x {columns} nodes after the first piece,"
    return (
        f"{solved} of {result.solved_steps} steps solved,{window}"
        f" {np.nanmean(iterations):.1f} iterations per state ({np.nanmax(iterations):.0f} at most),"
        f" {np.nansum(result.series['step_time']):.2f} s on one core"
    )
