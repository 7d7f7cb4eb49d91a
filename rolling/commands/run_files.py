"""The files of a run folder: the files of each run, the tables of a sweep, and the page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rolling.check import cost, demand
from rolling.folders import files
from rolling.simulation import batch, cluster, runs_table, sound_files, summary
from rolling.simulation.batch import Run
from rolling.simulation.cluster import Cluster
from rolling.simulation.pool import Workers
from rolling.simulation.result import Result
from rolling.simulation.run_result import RunResult


def ignore(folder: Path) -> None:
    """Do nothing with a folder."""


@dataclass(frozen=True)
class Wanted:
    """The files that a command is asked for besides results and sound, and who makes them.

    page : bool. Whether the report page is wanted. Default: true.
    pictures : bool. Whether pictures are wanted of each run; None: of each of up to 24 runs.
        Pictures of all runs together and the page need more than false. Default: None.
    workers : int. Number of processes; 0: one per core. Default: 0.
    begun : callable. It receives the run folder before anything is solved in it. Default: none.
    cluster : Cluster. A Dask scheduler whose workers solve. Default: local processes.
    cluster_workers : int. Number of its workers at the start. Default: 1.
    """

    page: bool = True
    pictures: bool | None = None
    workers: int = 0
    begun: Callable[[Path], object] = ignore
    cluster: Cluster | None = None
    cluster_workers: int = 1

    @property
    def solvers(self) -> Workers:
        """The cluster or the number of processes that solve."""
        return self.cluster or self.workers or cost.cores()

    def counted(self) -> Wanted:
        """Return the same with the present number of workers of the cluster, if there is one."""
        if self.cluster is None:
            return self
        return replace(self, cluster_workers=cluster.workers(self.cluster))

    def whole_folders(self, runs: int) -> bool:
        """Return whether each of so many runs has all files in its folder, not four only."""
        return self.pictures is True or runs <= demand.PAGE_RUNS

    def shows_each(self, runs: int) -> bool:
        """Return whether each of so many runs is heard and seen on the page."""
        return self.page and self.pictures is not False and runs <= demand.PAGE_RUNS


ALL_FILES = Wanted()  # on all cores


def write_run(finished: RunResult, result: Result, whole: bool) -> None:
    """Write result, sound files, numbers and provenance of one run into its folder.

    Parameters
    ----------
    whole : Whether all of them have files of their own. Otherwise the provenance is in
        summary.json, and signal.wav is the only sound file.
    """
    folder, scene = finished.folder, finished.scene
    run = Run(finished.values, scene, folder)
    batch.keep(run, result, finished.sound, finished.vibration)
    if not whole:
        sound_files.write_signal(folder, scene, finished.label, finished.sound)
        numbers = finished.summary | {"provenance": summary.provenance(scene)}
        files.write_json(folder / "summary.json", numbers)
        return
    sound_files.write(folder, scene, finished.label, finished.sound, finished.summary["caveats"])
    files.write_json(folder / "summary.json", finished.summary)
    files.write_json(folder / "provenance.json", summary.provenance(scene))


def write_sweep(
    folder: Path,
    runs: Sequence[Run],
    names: Sequence[str],
    summaries: Sequence[dict[str, Any] | None],
) -> list[runs_table.Row]:
    """Write the tables of the runs of a sweep, and return their rows."""
    table = [
        {"values": each.values, "folder": each.folder.name, "label": label, "summary": numbers}
        for each, label, numbers in zip(runs, names, summaries, strict=True)
    ]
    files.write_json(folder / "sweep.json", table)
    rows = [
        runs_table.Row(label, each.folder.name, each.values, numbers)
        for each, label, numbers in zip(runs, names, summaries, strict=True)
    ]
    files.write_bytes(folder / "runs.csv", runs_table.csv(rows))
    return rows
