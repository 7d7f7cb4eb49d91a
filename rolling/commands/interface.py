"""Runs in memory, for Python. Nothing is written, and errors are raised."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rolling.commands import save_run
from rolling.contact.solver import ContactError
from rolling.folders.files import FolderError
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.sweep import Value
from rolling.simulation import batch, labels, solving, tolerance_trial
from rolling.simulation import simulate as pieces
from rolling.simulation.plan import refuse
from rolling.simulation.pool import Outcome
from rolling.simulation.result import Result
from rolling.simulation.run_result import RunResult, hear
from rolling.simulation.stored_runs import read_runs

Values = Value | tuple[Value, ...]
_HERE = Path()  # folder of a run in memory


class SweepError(ContactError):
    """Runs of a sweep that failed, beside the successful runs.

    failures : dict. Reasons by the label of the run.
    runs : dict. The successful runs, as `simulate_sweep` returns them.
    """

    def __init__(self, failures: dict[str, str], runs: dict[Values, RunResult]) -> None:
        super().__init__("\n".join(f"{label}: {reason}" for label, reason in failures.items()))
        self.failures, self.runs = failures, runs


def simulate(scene: Scene, workers: int = 0, progress: bool | None = None) -> RunResult:
    """Simulate a scene in memory: contact, released energy, sound and levels.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    workers : int. Processes; 0: one per core. The numbers do not depend on it. Default: 0.
    progress : bool. Whether a progress bar is shown. Default: on a terminal and in a notebook.

    Returns
    -------
    run : the series in SI units, the sound and its levels.

    Raises
    ------
    SceneError : the scene sweeps, does not fit into memory, or its surface cannot be read.
    ContactError : a contact has no solution, for instance because the load exceeds the capacity of
        the surface.
    KeyboardInterrupt : Ctrl-C was pressed; the current step was completed.

    Examples
    --------
    >>> import rolling
    >>> scene = rolling.Scene.from_dict({
    ...     "name": "small",
    ...     "sphere": {"radius_mm": 5},
    ...     "plate": {"youngs_modulus_gpa": 210, "poissons_ratio": 0.3},
    ...     "surface": {"kind": "gaussian", "roughness_ra_um": 0.1, "correlation_length_um": 10,
    ...                 "spacing_um": 2, "width_um": 128, "seed": 3},
    ...     "rolling": {"load_n": 0.1, "speed_m_s": 0.1, "duration_s": 0.002},
    ... })
    >>> run = rolling.simulate(scene, workers=1, progress=False)
    >>> run.series["contact_area"].shape, run.release_power.shape
    ((101,), (100,))
    """
    if scene.sweep:
        raise SceneError(
            [f"sweep: the scene sweeps {', '.join(scene.sweep)}; simulate_sweep runs all of them"]
        )
    (run,) = _simulated(scene, [_Single({}, scene)], workers, progress).values()
    return run


def simulate_sweep(
    scene: Scene, workers: int = 0, progress: bool | None = None
) -> dict[Values, RunResult]:
    """Simulate every run of a scene that sweeps, in memory.

    Parameters
    ----------
    scene : Scene. A scene with a sweep.
    workers, progress : as in `simulate`.

    Returns
    -------
    runs : dict. Runs by their swept value, or by a tuple of values if several keys are swept.

    Raises
    ------
    SceneError : the scene does not sweep, or as in `simulate`.
    SweepError : a run failed; the error holds the other runs. It is a ContactError.
    KeyboardInterrupt : Ctrl-C was pressed; the current step was completed.
    """
    if not scene.sweep:
        raise SceneError(["sweep: the scene has no sweep; simulate runs it"])
    return _simulated(
        scene, [_Single(values, single) for values, single in scene.runs()], workers, progress
    )


def open_run(folder: Path | str) -> RunResult:
    """Read a stored run and make its sound again, without solving.

    Parameters
    ----------
    folder : Path or str. A run folder, or the folder of one run in a sweep.

    Returns
    -------
    run : RunResult. The run as `simulate` returns it, or its solved part.

    Raises
    ------
    FolderError : the folder is not a run folder, belongs to a whole sweep, or has too few solved
        steps.
    SceneError : the surface of the run cannot be read.
    """
    runs = read_runs(Path(folder))
    if len(runs) > 1:
        names = ", ".join(run.folder.name for run in runs[:3])
        raise FolderError(
            f"{folder}: holds {len(runs)} runs; open one of the folders in it ({names}, ...)"
        )
    result = batch.stored(runs[0])
    run = (
        hear(runs[0].label, runs[0].values, runs[0].folder, runs[0].scene, result)
        if result
        else None
    )
    if run is None:
        raise FolderError(
            f"{folder}: too little is solved for a sound; `rolling resume {folder}` goes on with it"
        )
    return _with_stored_time(replace(run, writer=save_run))


@dataclass(frozen=True)
class _Single:
    """A run in memory: the values of its sweep and the scene with them."""

    values: Mapping[str, Value]
    scene: Scene
    folder: Path = _HERE


def _simulated(
    scene: Scene, singles: Sequence[_Single], workers: int, progress: bool | None
) -> dict[Values, RunResult]:
    """Simulate the runs of a scene and return them by their swept values."""
    refuse(scene, workers, None)
    results = [Result.empty(single.scene.track, single.scene.start) for single in singles]
    choices = tolerance_trial.choose(
        [single.scene for single in singles], results, workers, progress
    )
    if choices.interrupted:
        raise KeyboardInterrupt
    scenes = choices.scenes
    singles = [replace(each, scene=scene) for each, scene in zip(singles, scenes, strict=True)]
    for each, result in zip(singles, results, strict=True):
        result.identity = pieces.identity_of(each.scene)
    outcome = solving.solve(scenes, results, workers, scene.name, progress=progress)
    if outcome.interrupted:
        raise KeyboardInterrupt
    runs: dict[Values, RunResult] = {}
    names = labels.labels(singles)
    for number, (single, label, result) in enumerate(zip(singles, names, results, strict=True)):
        if number not in outcome.failures:
            run = hear(label, single.values, _HERE, single.scene, result)
            if run is None:
                outcome.failures[number] = "less than two steps, too few for a sound"
            else:
                runs[_key(single.values)] = replace(run, writer=save_run)
    _raise_failures(outcome, names, runs, bool(scene.sweep))
    return runs


def _raise_failures(
    outcome: Outcome, names: Sequence[str], runs: dict[Values, RunResult], swept: bool
) -> None:
    """Raise an error if a run failed."""
    if outcome.failures and swept:
        raise SweepError(
            {names[number]: reason for number, reason in outcome.failures.items()}, runs
        )
    if outcome.failures:
        raise ContactError(next(iter(outcome.failures.values())))


def _key(values: Mapping[str, Value]) -> Values:
    """Return the key of a run in a sweep: its swept value, or the tuple of its values."""
    return next(iter(values.values())) if len(values) == 1 else tuple(values.values())


def _with_stored_time(run: RunResult) -> RunResult:
    """Take the time that the sound took from summary.json.

    The summary then equals the stored summary.
    """
    path = run.folder / "summary.json"
    if not path.is_file():
        return run
    seconds = json.loads(path.read_text()).get("sound_seconds", run.summary["sound_seconds"])
    return replace(run, summary=run.summary | {"sound_seconds": seconds})
