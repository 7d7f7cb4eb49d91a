"""Runs of scenes with their folders: solved on all cores, written as they grow."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rolling.check import tolerance
from rolling.folders.files import FolderError, Keeper, Unwritable, writing
from rolling.scene import file
from rolling.scene import sweep as sweeps
from rolling.scene.identity import Identity, changes, said
from rolling.scene.identity import identity_differences as differences
from rolling.scene.scene import Scene
from rolling.scene.sweep import Value
from rolling.simulation import (
    labels,
    result_file,
    shared,
    simulate,
    slow_march,
    solving,
)
from rolling.simulation.lacking import lacks_marches
from rolling.simulation.pool import Outcome, Workers
from rolling.simulation.result import Result
from rolling.sound.contact_sound import ContactSound
from rolling.sound.vibration_sound import Vibration

__all__ = [
    "RESULT",
    "Run",
    "keep",
    "other_surface",
    "refuse_other_scene",
    "seen_from",
    "solve",
    "stored",
]

RESULT, RESOLVED = "result.h5", "resolved.yaml"


@dataclass(frozen=True)
class Run:
    """A run of a scene and its folder.

    values : dict. The swept values of the run, by dotted key.
    scene : Scene. The scene with these values, without a sweep.
    folder : Path. The run folder.
    """

    values: Mapping[str, Value]
    scene: Scene
    folder: Path

    @property
    def label(self) -> str:
        """The name of the run alone: its swept values, or its load.

        `labels.labels` names several runs together.
        """
        return labels.labels([self])[0]


def solve(
    runs: Sequence[Run],
    results: list[Result],
    workers: Workers,
    name: str,
    mapped: bool = True,
    begun: Callable[[Run], object] = lambda run: None,
    complete: Callable[[int], object] | None = None,
    filmed: bool = False,
) -> Outcome:
    """Solve the missing steps of runs, and write each result.h5 as it grows.

    Parameters
    ----------
    runs : sequence of Run.
    results : list of Result. Their solved steps are not solved again. Runs with the same march
        share a result afterwards, which the folder of the first of them holds as it grows.
    workers : int or Cluster. Number of processes; 0: one per core.
    name : str. Name of the progress bar.
    mapped : bool. Whether pressure maps along the tracks are kept, some megabytes per run.
        Default: true.
    begun : callable. It receives a run when one of its pieces is handed to a process.
    complete : callable. It receives the number of a run when all of it is solved, and writes its
        result. Default: the result is written without its sound.
    filmed : bool. Whether complete runs get a slow motion. Default: false.
    """
    work = _Work(runs, results, filmed, complete)
    outcome = solving.solve(
        work.scenes,
        results,
        workers,
        name,
        mapped,
        begun=lambda leader: work.each(leader, lambda number: begun(runs[number])),
        added=work.added,
        filmed=filmed,
    )
    work.end(outcome)
    return outcome


class _Work:
    """Runs that are solved, and the state of their files.

    Runs with the same march share a result, which belongs to the first of them, the leader.

    Attributes
    ----------
    scenes : list of Scene. One per run.
    members : dict. Numbers of the runs that share a result, by their leader.
    keepers : dict. The time of writing of each result that is not complete, by its leader.
    unkept : set. Leaders of results that have steps which are not written.
    unwritable : dict. Errors of runs whose folder cannot be written, by their number.
    """

    def __init__(
        self,
        runs: Sequence[Run],
        results: list[Result],
        filmed: bool,
        complete: Callable[[int], object] | None,
    ) -> None:
        """Share the results of runs with the same march; `filmed` and `complete` as in `solve`."""
        for run, result in zip(runs, results, strict=True):
            identify(run, result)
        self.runs, self.results, self.filmed, self.complete = runs, results, filmed, complete
        self.scenes = [run.scene for run in runs]
        shared.share(self.scenes, results)
        self.members = shared.members(results)
        self.keepers = {leader: Keeper() for leader in self.members if self.lacks(leader)}
        self.unkept: set[int] = set()
        self.unwritable: dict[int, Unwritable] = {}

    def each(self, leader: int, write: Callable[[int], object]) -> None:
        """Write into the folder of each run that shares a result, unless it cannot be written.

        Raises
        ------
        Unwritable : none of them can be written, or no folder at all.
        """
        members = self.members[leader]
        for number in members:
            if number not in self.unwritable:
                self._write(number, write)
        if all(number in self.unwritable for number in members):
            raise self.unwritable[leader]

    def _write(self, number: int, write: Callable[[int], object]) -> None:
        """Write into the folder of a run; note that it cannot be written alone."""
        try:
            with writing(self.runs[number].folder):
                write(number)
        except Unwritable as error:
            if error.everywhere or not self.runs[number].values:
                raise
            self.unwritable[number] = error

    def lacks(self, leader: int) -> bool:
        """Return whether a result lacks a march of one of its runs, or its slow motion."""
        result, numbers = self.results[leader], self.members[leader]
        if any(lacks_marches(self.scenes[number], result) for number in numbers):
            return True
        scenes = [self.scenes[number] for number in numbers]
        return self.filmed and slow_march.missing(scenes, result)

    def added(self, leader: int) -> None:
        """Write a result that has grown, if it is due, and complete its runs after the last."""
        result = self.results[leader]
        self.unkept.add(leader)
        last = not self.lacks(leader)
        # A result of one piece is written once, with its sound.
        at_once = self.complete is not None and last and result.solved_steps <= simulate.PIECE_STEPS
        if not at_once and (self.keepers[leader].due() or last):
            start = time.monotonic()
            self._keep(leader)
            self.keepers[leader].wrote(time.monotonic() - start)
            self.unkept.discard(leader)
        if last:
            self.each(
                leader, lambda number: self._end_run(number, number == leader and not at_once)
            )
            self.unkept.discard(leader)

    def _keep(self, leader: int) -> None:
        """Write the result of a run, unless its folder cannot be written."""
        if leader not in self.unwritable:
            self._write(leader, lambda number: keep(self.runs[number], self.results[number]))

    def _end_run(self, number: int, kept: bool) -> None:
        """Complete a run, or keep its result where nobody completes it or that fails."""
        if self.complete is not None:
            try:
                self.complete(number)
            except BaseException:
                if not kept:
                    keep(self.runs[number], self.results[number])
                raise
        elif not kept:
            keep(self.runs[number], self.results[number])

    def end(self, outcome: Outcome) -> None:
        """Write the results that are not written, and note runs that failed by their files."""
        for leader in self.keepers:
            if leader in self.unkept:
                self._keep(leader)
            # Statistics and figures of the surface read the heights once more.
            for number in self.members[leader]:
                if fault := other_surface(self.runs[number], self.results[number]):
                    outcome.failures.setdefault(number, fault)
        outcome.failures |= {number: str(error) for number, error in self.unwritable.items()}


def keep(
    run: Run,
    result: Result,
    sound: ContactSound | None = None,
    vibration: Vibration | None = None,
) -> None:
    """Write the result of a run into its folder, together with sound and vibration if it has."""
    identify(run, result)
    text = file.dump(seen_from(run.folder, run.scene))
    result_file.save(run.folder / RESULT, result, run.scene, text, sound, vibration)


def identify(run: Run, result: Result) -> None:
    """Note scene and surface in a result, unless it has them from its file."""
    if result.identity is None:
        result.identity = simulate.identity_of(run.scene)


def stored(run: Run) -> Result | None:
    """Load the stored result of a run, or return None if the run has none.

    Raises
    ------
    FolderError : the result is damaged, or another scene or surface was solved. The message names
        all differences.
    SceneError : the heights of the scene cannot be read.
    """
    path = run.folder / RESULT
    if not path.exists():
        return None
    result = result_file.load(path)
    if result.identity is None:  # version 0.1.0 wrote no identity
        rolled = run.scene.track
        if (result.steps, result.solved_steps) != (rolled.steps, rolled.solved_steps):
            raise FolderError(
                f"{path}: has {result.steps} steps, the scene asks for {rolled.steps}"
            )
        return result
    own = simulate.identity_of(run.scene)
    if faults := differences(result.identity, own, RESULT, run.scene.height_path):
        lines = "\n".join(f"  {fault}" for fault in faults)
        raise FolderError(f"{run.folder}: the result does not belong to the scene\n{lines}")
    return result


def refuse_other_scene(run: Run) -> None:
    """Compare a run of a sweep with the scene in its own folder, which may have been edited.

    Raises
    ------
    FolderError : their physics differs. The message names the first key.
    SceneError : the scene in the folder cannot be used.
    """
    path = run.folder / RESOLVED
    if not run.values or not path.is_file():
        return
    # Heights are compared with the result, by their digest.
    there = file.read_scene(path)
    scene = run.scene
    if tolerance.is_open(there):  # a kill came before the number was written into it
        there = there.with_({"numerics.tolerance": scene.numerics.tolerance})
    if tolerance.is_open(scene):  # another process may just have chosen it
        scene = scene.with_({"numerics.tolerance": there.numerics.tolerance})
    own, swept = (Identity.of(each, None) for each in (there, scene))
    for key, (there, here) in changes(own, swept).items():
        raise FolderError(
            f"{path}: {key}: got {said(there)}, the sweep of the folder above makes {said(here)} "
            "of it"
        )


def other_surface(run: Run, result: Result) -> str | None:
    """Return the reason why the heights of a run differ from the solved heights, or None."""
    return (
        simulate.surface_fault(run.scene, result.identity.heights_sha256)
        if result.identity
        else None
    )


def seen_from(folder: Path, scene: Scene) -> Scene:
    """Return a scene whose paths to height files are relative to a run folder.

    The scene is read from that folder later. Swept paths keep their text as labels.
    """

    def moved(path: str) -> str:
        if Path(path).is_absolute():
            return path
        # Links are resolved first, because ".." of a linked folder leads elsewhere.
        heights = (scene.folder / path).parent.resolve() / Path(path).name
        return Path(os.path.relpath(heights, folder.resolve())).as_posix()

    before = scene.to_dict()
    data = sweeps.with_paths(before, moved)
    return scene if data == before else Scene.from_dict(data, folder)
