"""Runs for Python: simulated in memory, opened from their folders, saved into new ones, rolled.

Choices are in `choices`.
"""

from __future__ import annotations

import base64
import sys
import webbrowser
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, overload

from acoustics.arrays import instance
from acoustics.traps import ignoring_underflow
from rolling.bearing_kind.bearing_run import BearingRun
from rolling.commands.derived import write_derived
from rolling.contact.solver import ContactError
from rolling.kinds.registry import kind_of
from rolling.kinds.run_folder import PAGE, RunFolder
from rolling.results import labels
from rolling.results.run_result import Run
from rolling.run import folder as folders
from rolling.run.ending import Ending
from rolling.run.solving import Values, open_runs, refuse_other_kind, simulate_runs
from rolling.run.sweep_runs import Runs, SweepError
from rolling.scene import sweep as sweeps
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.swept import SweptScene
from rolling.terminal import defaults
from rolling.terminal import progress as terminal
from rolling.terminal.notebook import interrupt_with_message
from rolling.terminal.whole_files import write_temporary

PLAY_IT = "play-it"  # the section of the page where the ball is rolled by hand


@overload
def simulate(
    scene: Scene,
    workers: int = 0,
    progress: bool | None = None,
    heights: Any = None,
    start_from: Path | str | None = None,
) -> Run: ...
@overload
def simulate(
    scene: BearingScene,
    workers: int = 0,
    progress: bool | None = None,
    heights: None = None,
    start_from: Path | str | None = None,
) -> BearingRun: ...
@ignoring_underflow
def simulate(
    scene: SweptScene,
    workers: int = 0,
    progress: bool | None = None,
    heights: Any = None,
    start_from: Path | str | None = None,
) -> Any:
    """Simulate a scene in memory: contacts, motion, sound and numbers.

    Parameters
    ----------
    scene : Scene or BearingScene
        A scene without a sweep.
    workers : int
        Processes; 0: one per core. The numbers do not depend on it. A process of
        `multiprocessing.Pool` and a worker of Dask solve in their own process. Default: 0.
    progress : bool
        Whether a progress bar is shown. Default: on a terminal and in a notebook.
    heights : (m, n) array_like, m, or HeightArray
        The surface in place of that of a scene of a sphere; an array has the scene's node spacing.
        Default: the surface of the scene.
    start_from : Path or str
        Run folder whose marches of equal contacts are taken, such as that of the same bearing
        without its faults. Default: none.

    Returns
    -------
    run : Run or BearingRun
        Series, sound and numbers; of a bearing the velocity of its ring in the three bands of
        ISO 15242-1, its lines, and the loads of the balls.

    Raises
    ------
    ValueError
        The heights are no real, finite array along and across.
    SceneError
        The scene sweeps, does not fit into memory, or its surface cannot be read.
    FolderError
        `start_from` is no run folder.
    ContactError
        A contact has no solution, for instance because the load exceeds the capacity of the
        surface.
    KeyboardInterrupt
        Ctrl-C was pressed.

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

    >>> waves = {"inner": {"kind": "smooth", "waviness": {9: 0.1}}}  # 0.1 um high, 9 on a turn
    >>> scene = rolling.BearingScene(
    ...     bearing={"named": "6204", "speed_rpm": 1800, "axial_load_n": 70, "surfaces": waves},
    ...     sound={"duration_s": 0.5, "listen_s": 0.5},
    ... )
    >>> run = rolling.simulate(scene, progress=False)
    >>> print(run.numbers.below_bending.radial.low)
    81 um/s ± 0.1 dB, computed
    >>> run.numbers.lines[-1].name
    'inner 9'
    """
    instance("scene", scene, SweptScene)
    if heights is not None:
        scene = kind_of(scene).with_heights(scene, heights)
    if scene.sweep:
        keys = ", ".join(scene.sweep)
        raise SceneError([f"sweep: the scene sweeps {keys}; simulate_sweep runs all of them"])
    runs, failures = _simulated(scene, workers, progress, start_from)
    if failures:
        raise ContactError(next(iter(failures.values())))
    (run,) = runs.values()
    return run


@ignoring_underflow
def simulate_sweep(scene: SweptScene, workers: int = 0, progress: bool | None = None) -> Runs:
    """Simulate every run of a scene that sweeps, in memory.

    Parameters
    ----------
    scene : Scene or BearingScene
        A scene with a sweep.
    workers, progress : int, bool
        As in `simulate`.

    Returns
    -------
    runs : Runs
        Dictionary of runs by their swept value, with a table of their numbers.

    Raises
    ------
    SceneError
        The scene does not sweep, or as in `simulate`.
    SweepError
        A run failed; the error holds the other runs. It is a ContactError.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> import rolling
    >>> words = ["sweep.rolling.load_n=[1, 2]", "rolling.duration_s=0.002"]
    >>> scene = rolling.read_scene("quickstart", words)
    >>> [run.label for run in rolling.simulate_sweep(scene, workers=1, progress=False).values()]
    ['load 1 N', 'load 2 N']
    """
    instance("scene", scene, SweptScene)
    if not scene.sweep:
        raise SceneError(["sweep: the scene has no sweep; simulate runs it"])
    runs, failures = _simulated(scene, workers, progress)
    values = {
        key: [value for value, _ in sweeps.choices(listed)] for key, listed in scene.sweep.items()
    }
    if failures:
        raise SweepError(failures, Runs(runs, values))
    return Runs(runs, values)


def _simulated(
    scene: SweptScene,
    workers: int,
    progress: bool | None,
    start_from: Path | str | None = None,
) -> tuple[dict[Values, Any], dict[str, str]]:
    """Simulate the runs of a scene; an interrupt says what is left, also in a notebook."""
    sources: Sequence[RunFolder] = ()
    with terminal.shown(progress), interrupt_with_message():
        if start_from is not None:
            instance("start_from", start_from, str, Path)
            elsewhere = folders.stored_runs(Path(start_from))
            own = folders.runs_in(Path(), scene)
            kind = kind_of(scene)
            refuse_other_kind(Path(start_from), elsewhere, kind)
            sources = kind.take_marches(Path(start_from), elsewhere, own)
        return simulate_runs(scene, workers, progress, sources)


@ignoring_underflow
def open_run(folder: Path | str) -> Any:
    """Read a stored run and make its sound again, without solving.

    Parameters
    ----------
    folder : Path or str
        A run folder, or the folder of one run in a sweep.

    Returns
    -------
    run : Run or BearingRun
        The run as `simulate` returns it, with the stored numbers. The series of a bearing are in
        single precision.

    Raises
    ------
    FolderError
        The folder is not a run folder, belongs to a whole sweep, or is not done.
    SceneError
        The surface of the run cannot be read.

    Examples
    --------
    >>> import rolling
    >>> scene = rolling.read_scene("quickstart", ["rolling.load_n=1", "rolling.duration_s=0.005"])
    >>> run = rolling.simulate(scene, workers=1, progress=False)
    >>> rolling.open_run(run.save("mine", report=False)).series["contact_area"].shape
    (251,)
    """
    instance("folder", folder, str, Path)
    (run,) = open_runs([folders.done_run(Path(folder), "open")])
    return run


@ignoring_underflow
def save_run(run: Any, folder: Path | str, report: bool = True) -> Path:
    """Write a run that is in memory into a new folder, with the files that `rolling run` writes.

    Parameters
    ----------
    run : Run or BearingRun
        The run.
    folder : Path or str
        The folder to make.
    report : bool
        Write the report page as well. Default: true.

    Returns
    -------
    folder : Path
        The new folder, for `open_run`.

    Raises
    ------
    FolderError
        The folder holds files already, or is a file.

    Examples
    --------
    >>> import rolling
    >>> scene = rolling.read_scene("quickstart", ["rolling.load_n=1", "rolling.duration_s=0.005"])
    >>> run = rolling.simulate(scene, workers=1, progress=False)
    >>> sorted(path.name for path in rolling.save_run(run, "kept", report=False).iterdir())
    ['bands.csv', 'listen.wav', 'numbers.json', ..., 'signal.wav', 'summary.json']
    """
    instance("run", run, RunFolder)
    instance("folder", folder, str, Path)
    kind = kind_of(run.scene)
    folder = folders.new_folder(Path(folder))
    with folders.locked(folder):
        scene = kind.kept_scene(run.scene, folder)
        folders.write_scene(folder, scene)
        (alone,) = folders.stored_runs(folder)
        kind.write_run(replace(run, scene=scene, folder=folder, values={}))
        with Ending(folder) as ending:
            write_derived(ending, [alone], report)
    return folder


@ignoring_underflow
def live(runs: Run | BearingRun | Sequence[Run | BearingRun]) -> Any:
    """Open the page of a run, or of several, where the ball or the bearing is turned by hand.

    The page is the report.html of a stored run, otherwise a temporary file. In a notebook the page
    is a part of its output, of about 2 MB per run.

    Parameters
    ----------
    runs : Run, BearingRun or sequence of them
        The runs of the page, 24 at most, of one kind.

    Returns
    -------
    frame : IPython.display.IFrame in a notebook, otherwise None

    Raises
    ------
    ValueError
        There is no run, or there are too many.

    Examples
    --------
    >>> import rolling
    >>> scene = rolling.read_scene("quickstart", ["rolling.load_n=1", "rolling.duration_s=0.005"])
    >>> rolling.live(rolling.simulate(scene, workers=1, progress=False))
    live: ...quickstart-live-....html
    """
    shown = _listed(runs)
    if not 1 <= len(shown) <= defaults.MAX_RUNS_ON_PAGE:
        raise ValueError(
            f"runs: got {len(shown)}, allowed: 1 to {defaults.MAX_RUNS_ON_PAGE} with players on a"
            " page"
        )
    for run in shown:
        instance("runs", run, RunFolder)
    path = shown[0].home / PAGE
    is_stored = shown[0].stored is not None and path.is_file()
    if len(shown) > 1 or not is_stored:
        path = _temporary_page(shown)
    if terminal.in_notebook():
        from IPython.display import IFrame

        content = base64.b64encode(path.read_bytes()).decode()
        return IFrame(f"data:text/html;base64,{content}#{PLAY_IT}", width="100%", height=900)
    print(f"live: {path}")
    if sys.stdout.isatty():
        webbrowser.open(f"{path.resolve().as_uri()}#{PLAY_IT}")
    return None


def _listed(runs: Any) -> list[Any]:
    """Return one or several runs as a list; a dictionary gives its values."""
    if isinstance(runs, RunFolder):
        return [runs]
    return list(runs.values()) if isinstance(runs, dict) else list(runs)


def _temporary_page(runs: Sequence[Any]) -> Path:
    """Write the page of runs into a temporary file."""
    from rolling.report import report_page

    if len(runs) > 1:
        names = labels.labels(runs)
        runs = [replace(run, label=label) for run, label in zip(runs, names, strict=True)]
    content = report_page.page(runs)
    return write_temporary(f"{runs[0].scene.name}-live-", ".html", content)
