"""Runs for Python: simulated in memory, opened from their folders, saved into new ones, rolled.

Those of bearings are in `bearings`, choices in `choices`.
"""

from __future__ import annotations

import base64
import sys
import webbrowser
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from acoustics.arrays import instance
from acoustics.traps import ignoring_underflow
from rolling.commands.derived import write_derived
from rolling.contact.solver import ContactError
from rolling.results import labels
from rolling.results.run_folder import PAGE
from rolling.results.run_result import Run, write_run
from rolling.run import folder as folders
from rolling.run.ending import Ending
from rolling.run.solving import Values, open_runs, simulate_runs
from rolling.run.sweep_runs import Runs, SweepError
from rolling.scene import sweep as sweeps
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.surface.measured import HeightArray, with_copy
from rolling.terminal import defaults
from rolling.terminal import progress as terminal
from rolling.terminal.files import write_temporary
from rolling.terminal.notebook import interrupt_with_message

PLAY_IT = "play-it"  # the section of the page where the ball is rolled by hand


@ignoring_underflow
def simulate(
    scene: Scene, workers: int = 0, progress: bool | None = None, heights: Any = None
) -> Run:
    """Simulate a scene in memory: contact, released energy, sound and levels.

    Parameters
    ----------
    scene : Scene
        A scene without a sweep.
    workers : int
        Processes; 0: one per core. The numbers do not depend on it. A process of
        `multiprocessing.Pool` and a worker of Dask solve in their own process. Default: 0.
    progress : bool
        Whether a progress bar is shown. Default: on a terminal and in a notebook.
    heights : (m, n) array_like, m, or HeightArray
        The surface in place of that of the scene; an array has the scene's node spacing. Default:
        the surface of the scene.

    Returns
    -------
    run : Run
        The series in SI units, the sound and its levels.

    Raises
    ------
    ValueError
        The heights are no real, finite array along and across.
    SceneError
        The scene sweeps, does not fit into memory, or its surface cannot be read.
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
    """
    instance("scene", scene, Scene)
    if isinstance(heights, HeightFile):
        scene = scene.with_(surface=heights)
    elif heights is not None:
        scene = scene.with_(surface=HeightArray(heights, spacing_um=scene.spacing_um))
    if scene.sweep:
        keys = ", ".join(scene.sweep)
        raise SceneError([f"sweep: the scene sweeps {keys}; simulate_sweep runs all of them"])
    runs, failures = _simulated(scene, workers, progress)
    if failures:
        raise ContactError(next(iter(failures.values())))
    (run,) = runs.values()
    return run


@ignoring_underflow
def simulate_sweep(scene: Scene, workers: int = 0, progress: bool | None = None) -> Runs:
    """Simulate every run of a scene that sweeps, in memory.

    Parameters
    ----------
    scene : Scene
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
    instance("scene", scene, Scene)
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
    scene: Scene, workers: int, progress: bool | None
) -> tuple[dict[Values, Run], dict[str, str]]:
    """Simulate the runs of a scene; an interrupt says what is left, also in a notebook."""
    with interrupt_with_message():
        return simulate_runs(scene, workers, progress)


@ignoring_underflow
def open_run(folder: Path | str) -> Run:
    """Read a stored run and make its sound again, without solving.

    Parameters
    ----------
    folder : Path or str
        A run folder, or the folder of one run in a sweep.

    Returns
    -------
    run : Run
        The run as `simulate` returns it.

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
def save_run(run: Run, folder: Path | str, report: bool = True) -> Path:
    """Write a run that is in memory into a new folder, with the files that `rolling run` writes.

    Parameters
    ----------
    run : Run
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
    instance("run", run, Run)
    instance("folder", folder, str, Path)
    folder = folders.new_folder(Path(folder))
    with folders.locked(folder):
        scene = with_copy(run.scene.with_auto_steps(), folder)
        folders.write_scene(folder, scene)
        (alone,) = folders.stored_runs(folder)
        write_run(replace(run, scene=scene, folder=folder, values={}))
        with Ending(folder) as ending:
            write_derived(ending, [alone], report)
    return folder


Run.save = save_run


@ignoring_underflow
def live(runs: Run | Sequence[Run]) -> Any:
    """Open the page of a run, or of several, where the ball is rolled by hand.

    The page is the report.html of a stored run, otherwise a temporary file. In a notebook the page
    is a part of its output, of about 2 MB per run.

    Parameters
    ----------
    runs : Run or sequence of Run
        The runs of the page, 24 at most.

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
    from rolling.figures.picture import listed

    shown = listed(runs)
    if not 1 <= len(shown) <= defaults.MAX_RUNS_ON_PAGE:
        raise ValueError(
            f"runs: got {len(shown)}, allowed: 1 to {defaults.MAX_RUNS_ON_PAGE} with players on a"
            " page"
        )
    for run in shown:
        instance("runs", run, Run)
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


def _temporary_page(runs: Sequence[Run]) -> Path:
    """Write the page of runs into a temporary file."""
    from rolling.report.page import page

    if len(runs) > 1:
        names = labels.labels(runs)
        runs = [replace(run, label=label) for run, label in zip(runs, names, strict=True)]
    return write_temporary(f"{runs[0].scene.name}-live-", ".html", page(runs))
