"""Runs of scenes, solved on all cores and kept as they go. Depends on simulate and store."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from rolling.check import cost
from rolling.folders.files import FolderError, Keeper
from rolling.scene import file
from rolling.scene.identity import Identity, changes, differences, said
from rolling.scene.scene import Scene
from rolling.simulation import labels, result_file, simulate
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.sound import ContactSound

RESULT = "result.h5"
BAR = "{desc} {percentage:3.0f}%|{bar}| {elapsed} passed, {remaining} left"


@dataclass(frozen=True)
class Run:
    """One run of a scene: the values its sweep gave it, the scene they make, its folder."""

    values: dict[str, float]
    scene: Scene
    folder: Path

    @property
    def label(self) -> str:
        """The name of the run alone: its swept values, or its load. Several are named together by `labels.labels`."""
        return labels.labels([self])[0]


def solve(
    runs: Sequence[Run],
    results: Sequence[Result],
    workers: int,
    name: str,
    mapped: bool = True,
    begun: Callable[[Run], object] = lambda run: None,
) -> Outcome:
    """Solve what is missing of runs; each result.h5 is written as it grows and once more in the end.

    Parameters
    ----------
    results : one per run, of which what is solved already is not solved again.
    workers : processes; 0: one per core.
    name : what the progress bar is of.
    mapped : keep pressure maps along the tracks, some megabytes a run.
    begun : gets a run as each of its pieces is handed to a process.
    """
    missing = [[*simulate.missing(result.solved_steps, result.series["release_energy"])] for result in results]
    step_seconds = [
        cost.expected_seconds(one.scene) / result.solved_steps for one, result in zip(runs, results, strict=True)
    ]
    # The longest first, so that no core is left with one of them in the end.
    order = sorted((k for k in range(len(runs)) if missing[k]), key=lambda k: -step_seconds[k])
    todo = [(k, first, last) for k in order for first, last in missing[k]]
    keepers = {k: Keeper() for k in order}

    def finished(number: int, piece: simulate.Piece) -> None:
        results[number].add(piece)
        if keepers[number].due() or results[number].complete:
            began = time.monotonic()
            keep(runs[number], results[number])
            keepers[number].wrote(time.monotonic() - began)

    for k in order:
        keep(runs[k], results[k])
    scenes = [one.scene for one in runs]
    orders = [
        simulate.Order(seconds, mapped, result.identity.heights_sha256 if result.identity else None)
        for seconds, result in zip(step_seconds, results, strict=True)
    ]
    total = sum((last - first) * step_seconds[k] for k, first, last in todo)
    with tqdm(total=total, disable=None, desc=name, bar_format=BAR) as bar:
        outcome = simulate.simulate(
            scenes,
            todo,
            workers or cost.cores(),
            finished,
            bar.update,
            orders,
            lambda number: begun(runs[number]),
        )
    for k in order:
        keep(runs[k], results[k])
        # What follows reads the heights once more, for numbers and pictures of the surface.
        if fault := other_surface(runs[k], results[k]):
            outcome.failures.setdefault(k, fault)
    return outcome


def keep(one: Run, result: Result, sound: ContactSound | None = None) -> None:
    """Write the result of a run into its folder, with its sound once that is known."""
    if result.identity is None:
        result.identity = simulate.identity_of(one.scene)
    text = file.dump(seen_from(one.folder, one.scene))
    result_file.save(one.folder / RESULT, result, one.scene, text, sound)


def stored(one: Run) -> Result | None:
    """Load the stored result of a run; None where nothing is solved yet.

    Raises
    ------
    FolderError : it is damaged, or it was solved for another scene or over another surface; all that differs is named.
    SceneError : the heights of the scene cannot be read.
    """
    path = one.folder / RESULT
    if not path.exists():
        return None
    result = result_file.load(path)
    if result.identity is None:  # as of version 0.1.0
        way = one.scene.track
        if (result.steps, result.solved_steps) != (way.steps, way.solved_steps):
            raise FolderError(f"{path}: has {result.steps} steps, the scene asks for {way.steps}")
        return result
    own = simulate.identity_of(one.scene)
    if found := differences(result.identity, own, RESULT, one.scene.height_path):
        lines = "\n".join(f"  {difference}" for difference in found)
        raise FolderError(f"{one.folder}: the result does not belong to the scene\n{lines}")
    return result


def refuse_other_scene(one: Run) -> None:
    """Hold a run of a sweep against the scene in its own folder, which a hand may have edited.

    Raises
    ------
    FolderError : their physics differs; the first key is named. SceneError : the scene in the folder cannot be used.
    """
    path = one.folder / "resolved.yaml"
    if not one.values or not path.is_file():
        return
    # Heights are compared with the result, by their digest.
    own, swept = (Identity.of(scene, None) for scene in (file.read_scene(path), one.scene))
    for key, (there, here) in changes(own, swept).items():
        raise FolderError(f"{path}: {key}: got {said(there)}, the sweep of the folder above makes {said(here)} of it")


def other_surface(one: Run, result: Result) -> str | None:
    """Say why the heights of a run are not the ones that were solved; None where they are."""
    return simulate.surface_fault(one.scene, result.identity.heights_sha256) if result.identity else None


def seen_from(folder: Path, scene: Scene) -> Scene:
    """The scene with its height file's path as it is from a run folder, from where it will be read again."""
    data = scene.to_dict()
    if scene.height_path is None or Path(data["surface"]["path"]).is_absolute():
        return scene
    # Links are followed first: ".." of a linked folder leads elsewhere.
    heights = scene.height_path.parent.resolve() / scene.height_path.name
    data["surface"]["path"] = Path(os.path.relpath(heights, folder.resolve())).as_posix()
    return Scene.from_dict(data, folder)
