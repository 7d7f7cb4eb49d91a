"""Runs for Python: simulated in memory, opened from their folders, saved into new ones."""

from __future__ import annotations

import base64
import sys
import tempfile
import webbrowser
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acoustics.arrays import instance
from acoustics.traps import ignoring_underflow
from rolling.commands import write_derived
from rolling.contact.solver import ContactError
from rolling.results import labels
from rolling.results.run_folder import PAGE
from rolling.results.run_lines import answer_lines, html_table
from rolling.results.run_result import Run, write_run
from rolling.results.runs_table import runs_table
from rolling.run import folder as folders
from rolling.run.solving import Values, open_runs, simulate_runs
from rolling.scene import sweep as sweeps
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.scene.sweep import Value
from rolling.surface.measured import HeightArray, with_copy
from rolling.terminal import defaults
from rolling.terminal import progress as terminal
from rolling.terminal.files import FolderError, write_temporary
from rolling.terminal.notebook import Interrupted

if TYPE_CHECKING:
    import pandas as pd
    import xarray

    from rolling.bearing_run.bearing_choice import BearingChoice
    from rolling.bearing_run.bearing_run import BearingRun
    from rolling.choice.choice import Choice
    from rolling.choice.limit import Limit
    from rolling.choice.sensitivity import Sensitivities

__all__ = [
    "Runs",
    "SweepError",
    "choose",
    "choose_bearings",
    "coarsest_below",
    "live",
    "open_bearing",
    "open_run",
    "save_bearing",
    "save_run",
    "sensitivities",
    "simulate",
    "simulate_bearing",
    "simulate_sweep",
]

PLAY_IT = "play-it"  # the section of the page where the ball is rolled by hand


@ignoring_underflow
class Runs(dict[Values, Run]):
    """Runs of a sweep by their swept value, or by a tuple of values if several keys are swept.

    Parameters
    ----------
    runs : mapping
        Runs by their swept values. Default: none.
    sweep : mapping
        Lists of the swept values by dotted key, with those of runs that failed. Default: the values
        of the runs.

    Examples
    --------
    >>> import rolling
    >>> words = ["sweep.rolling.load_n=[1, 2]", "rolling.duration_s=0.002"]
    >>> scene = rolling.read_scene("quickstart", words)
    >>> runs = rolling.simulate_sweep(scene, workers=1, progress=False)
    >>> runs[2.0].label
    'load 2 N'
    >>> runs.table().index.get_level_values("rolling.load_n").to_list()
    [1, 2]
    >>> runs.to_xarray().released_power_db.sel(load_n=2).item() == runs[2].sound.levels.laeq_db
    True
    """

    def __init__(
        self,
        runs: Mapping[Values, Run] | None = None,
        sweep: Mapping[str, Sequence[Value]] | None = None,
    ) -> None:
        super().__init__(runs or {})
        self._sweep = dict(sweep or {})

    def __missing__(self, values: Values) -> Run:
        """Refuse values that no run has, and name those of the runs."""
        raise KeyError(f"{values!r} is no run; the runs are {', '.join(map(repr, self))}")

    def __repr__(self) -> str:
        runs = [*self.values()]
        return "\n".join(answer_lines(runs)) if runs else "no run"

    def _repr_html_(self) -> str:
        """Write what rolls, the two numbers of each run, and what follows for a notebook."""
        return html_table([*self.values()])

    def table(self) -> pd.DataFrame:
        """Tabulate the numbers of the runs, one row per run, as `rolling run` writes runs.csv.

        Returns
        -------
        table : pandas.DataFrame
            Numbers of summary.json by label, folder and swept keys. Names end in their units.
        """
        return runs_table([*self.values()])

    def to_xarray(self) -> xarray.Dataset:
        """Return the numbers and series of all runs in one Dataset.

        Each swept key is a dimension, named by its last part (`load_n`), or by the whole key where
        two share it (`plate.material`). Values without a run, such as those of a run that failed,
        have NaN.

        Returns
        -------
        dataset : xarray.Dataset
            `vibration_db` and `released_power_db` with their uncertainties, and in `vibration_how`
            and `released_power_how` whether they are computed, estimated or an upper bound; the
            numbers of runs.csv; third octaves by `band`, the nominal mid frequency; the series of
            `run.series` by `position` and `step` [m]. Runs with places of their own, as under
            different speeds, are padded with NaN, and `position` and `step` have a row per run.
            Every variable has `units` and `long_name` in `attrs`, and the Dataset has the version
            of the program.

        Raises
        ------
        ValueError
            There is no run, or the runs are not of one sweep.
        """
        from rolling.results.runs_dataset import runs_dataset

        return runs_dataset([*self.values()], self._sweep)


class SweepError(ContactError):
    """Runs of a sweep that failed, beside the successful runs.

    Attributes
    ----------
    failures : dict
        Reasons by the label of the run.
    runs : Runs
        The successful runs, as `simulate_sweep` returns them.

    Examples
    --------
    >>> import rolling
    >>> words = ["sweep.rolling.load_n=[1, 1e7]", "rolling.duration_s=0.002"]
    >>> try:
    ...     rolling.simulate_sweep(rolling.read_scene("quickstart", words), 1, progress=False)
    ... except rolling.SweepError as error:
    ...     print([*error.failures], [*error.runs])
    ['load 1e+07 N'] [1]
    """

    def __init__(self, failures: dict[str, str], runs: Runs) -> None:
        super().__init__("\n".join(f"{label}: {reason}" for label, reason in failures.items()))
        self.failures = failures
        self.runs = runs


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
    try:
        return simulate_runs(scene, workers, progress)
    except KeyboardInterrupt:
        raise Interrupted("the simulation was interrupted, and nothing of it is kept") from None


@ignoring_underflow
def choose(
    scenes: Scene | Sequence[Scene],
    within_db: float = defaults.WITHIN_DB,
    minutes: float = defaults.CHOICE_MINUTES,
    folder: Path | str | None = None,
    workers: int = 0,
    progress: bool | None = None,
) -> Choice:
    """Choose the quietest of some scenes, and say by how much and how sure that is.

    All scenes are heard on the same random surfaces, or at several places of their scans, and each
    difference has its scatter over these pairs as a ±. Pairs are added until it is the wanted one.

    Parameters
    ----------
    scenes : Scene or sequence of Scene
        The candidates. One scene with a sweep has a candidate for each run, one with single faults
        is compared with itself without them.
    within_db : float, dB
        Wanted standard uncertainty of the differences. Default: 1.
    minutes : float
        Time after which no more pairs begin; four are always heard. Default: 10.
    folder : Path or str
        Folder that keeps the runs of all specimens; a choice that was interrupted goes on there.
        Default: none, and only the numbers are kept.
    workers, progress : int, bool
        As in `simulate`.

    Returns
    -------
    choice : Choice
        Candidates in order, differences, sentences, table and plot.

    Raises
    ------
    SceneError
        The scenes are not comparable, or one of them cannot run.
    FolderError
        The folder holds something else.
    ContactError
        A contact has no solution.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> import rolling
    >>> words = ["sweep.surface.roughness_ra_um=[0.05, 0.2]", "rolling.duration_s=0.005"]
    >>> scene = rolling.read_scene("quickstart", [*words, "rolling.load_n=1"])
    >>> choice = rolling.choose(scene, within_db=3, workers=1, progress=False)
    >>> choice.contenders[0].label, choice.differences[0].pairs >= 6
    ('Ra 0.05 µm', True)

    References
    ----------
    C. Stein, Annals of Mathematical Statistics 16, 1945, 243-258, for the number of pairs.
    """
    from rolling.choice.choosing import Budget, choose_scenes

    listed = [scenes] if isinstance(scenes, Scene) else list(scenes)
    for scene in listed:
        instance("scenes", scene, Scene)
    budget = Budget(within_db=within_db, minutes=minutes)
    with _kept_in(folder, progress) as kept:
        return choose_scenes(listed, kept, budget, workers)


@ignoring_underflow
def choose_bearings(
    scenes: BearingScene | Sequence[BearingScene],
    within_db: float = defaults.WITHIN_DB,
    minutes: float = defaults.CHOICE_MINUTES,
    folder: Path | str | None = None,
    workers: int = 0,
    progress: bool | None = None,
) -> BearingChoice:
    """Choose between bearings by the three bands of ISO 15242, and say how sure that is.

    All bearings are heard on specimens with the same random numbers, and each difference has its
    scatter over these pairs as a ±. Specimens are added until it is the wanted one.

    Parameters
    ----------
    scenes : BearingScene or sequence of BearingScene
        The bearings. One scene with a sweep has a bearing for each run, one with single faults is
        compared with itself without them.
    within_db, minutes, folder, workers, progress
        As in `choose`.

    Returns
    -------
    choice : BearingChoice
        Differences by band, sentences, table and plot.

    Raises
    ------
    SceneError
        The bearings are not comparable, or one of them cannot run.
    FolderError
        The folder holds something else.
    ContactError
        A contact has no solution.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> import rolling
    >>> words = ["bearing.surfaces.balls={kind: smooth, waviness: {4: 0.02}}"]
    >>> words += ["bearing.surfaces.inner=", "bearing.surfaces.outer=", "sound.duration_s=0.1"]
    >>> scene = rolling.read_bearing("bearing-6204", words)
    >>> twice = scene.with_({"name": "twice", "bearing.surfaces.balls.waviness": {4: 0.04}})
    >>> choice = rolling.choose_bearings([scene, twice], progress=False)
    >>> round(choice.differences[0][0].db)
    6
    """
    from rolling.bearing_run import choosing

    listed = [scenes] if isinstance(scenes, BearingScene) else list(scenes)
    for scene in listed:
        instance("scenes", scene, BearingScene)
    with _kept_in(folder, progress) as kept:
        return choosing.choose_bearings(listed, kept, within_db, minutes, workers)


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
    ['listen.wav', 'result.h5', 'runs.csv', 'scene.yaml', 'signal.wav', 'summary.json']
    """
    instance("run", run, Run)
    instance("folder", folder, str, Path)
    folder = _new_folder(Path(folder))
    with folders.locked(folder):
        scene = with_copy(run.scene.with_auto_steps(), folder)
        folders.write_scene(folder, scene)
        (alone,) = folders.stored_runs(folder)
        write_run(replace(run, scene=scene, folder=folder, values={}))
        write_derived(folder, [alone], report)
    return folder


Run.save = save_run


def _new_folder(folder: Path) -> Path:
    """Make a folder for a run that is saved; refuse one that holds files."""
    if folder.exists() and not folder.is_dir():
        raise FolderError(f"{folder}: is a file; take another name for the folder")
    if folder.exists() and any(folder.iterdir()):
        raise FolderError(f"{folder}: holds files; take another, as {folders.free_name(folder)}")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


@ignoring_underflow
def simulate_bearing(
    scene: BearingScene, workers: int = 0, progress: bool | None = None
) -> BearingRun:
    """Simulate a bearing in memory: rough contacts, motion of the ring, bands and lines.

    Parameters
    ----------
    scene : BearingScene
        A scene without a sweep; `scene.runs()` lists those of a sweep.
    workers, progress : int, bool
        As in `simulate`.

    Returns
    -------
    run : BearingRun
        Velocity in the three bands of ISO 15242-1, lines, loads of the balls, and the record.

    Raises
    ------
    SceneError
        The scene sweeps, or a contact of it cannot be marched.
    ContactError
        A contact has no solution.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> import rolling
    >>> waves = {"inner": {"kind": "smooth", "waviness": {9: 0.1}}}  # 0.1 um high, 9 on a turn
    >>> scene = rolling.BearingScene(
    ...     bearing={"named": "6204", "speed_rpm": 1800, "axial_load_n": 70, "surfaces": waves},
    ...     sound={"duration_s": 0.5, "listen_s": 0.5},
    ... )
    >>> run = rolling.simulate_bearing(scene, progress=False)
    >>> run.bands_um_s["radial"]["low"] > 50, run.summary["lines"][-1]["name"]
    (True, 'inner 9')
    """
    from rolling.bearing_run.command import refuse_sweep
    from rolling.bearing_run.simulation import bearing_stages

    instance("scene", scene, BearingScene)
    refuse_sweep(scene)
    with ExitStack() as stack:
        if progress is False:
            stack.enter_context(terminal.begin(terminal.Level.QUIET))
        try:
            *_, last = bearing_stages(scene, workers=workers, shown=progress)
        except KeyboardInterrupt:
            raise Interrupted("the simulation was interrupted, and nothing of it is kept") from None
    return last.run


@ignoring_underflow
def open_bearing(folder: Path | str) -> BearingRun:
    """Read a stored run of a bearing.

    Parameters
    ----------
    folder : Path or str
        A run folder, or the folder of one run in a sweep.

    Returns
    -------
    run : BearingRun
        The run as `simulate_bearing` returns it, in single precision.

    Raises
    ------
    FolderError
        The folder holds no run of a bearing, several of them, or one that is not done or damaged.

    Examples
    --------
    >>> import rolling
    >>> waves = {"outer": {"kind": "smooth", "waviness": {8: 0.1}}}
    >>> scene = rolling.BearingScene(
    ...     bearing={"named": "608", "speed_rpm": 1800, "axial_load_n": 20, "surfaces": waves},
    ...     sound={"duration_s": 0.2, "listen_s": 0.2},
    ... )
    >>> run = rolling.simulate_bearing(scene, progress=False)
    >>> rolling.open_bearing(rolling.save_bearing(run, "my-bearing", report=False)).scene.name
    'scene'
    """
    from rolling.bearing_run.command import only_place, read_run

    instance("folder", folder, str, Path)
    return read_run(only_place(Path(folder), "open"))


@ignoring_underflow
def save_bearing(run: BearingRun, folder: Path | str, report: bool = True) -> Path:
    """Write a run of a bearing into a new folder, with the files that `rolling run` writes.

    Parameters
    ----------
    run : BearingRun
        The run.
    folder : Path or str
        The folder to make.
    report : bool
        Write page and figures as well. Default: true.

    Returns
    -------
    folder : Path
        The new folder, for `open_bearing`.

    Raises
    ------
    FolderError
        The folder holds files already, or is a file.

    Examples
    --------
    >>> import rolling
    >>> waves = {"inner": {"kind": "smooth", "waviness": {8: 0.1}}}
    >>> scene = rolling.BearingScene(
    ...     bearing={"named": "608", "speed_rpm": 1800, "axial_load_n": 20, "surfaces": waves},
    ...     sound={"duration_s": 0.2, "listen_s": 0.2},
    ... )
    >>> run = rolling.simulate_bearing(scene, progress=False)
    >>> folder = rolling.save_bearing(run, "kept-bearing", report=False)
    >>> sorted(path.suffix for path in folder.iterdir())
    ['.csv', '.csv', '.csv', '.h5', '.json', '.wav', '.wav', '.yaml']
    """
    from rolling.bearing_run.bearing_run import BearingRun
    from rolling.bearing_run.command import save_run as save

    instance("run", run, BearingRun)
    instance("folder", folder, str, Path)
    return save(run, _new_folder(Path(folder)), report)


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
    is_stored = "provenance" in shown[0].summary and path.is_file()
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


@ignoring_underflow
def sensitivities(
    scene: Scene,
    keys: Sequence[str] | None = None,
    within_db: float = defaults.IMPROVED_WITHIN_DB,
    minutes: float = defaults.CHOICE_MINUTES,
    folder: Path | str | None = None,
    workers: int = 0,
    progress: bool | None = None,
) -> Sensitivities:
    """Find how much louder a scene becomes when a value of its drawing is a little larger.

    Every value is changed by a tenth, a ball by a grade, and a skewness by 0.1. The scene and the
    changed scene are heard on the same specimens, at least six. Where a larger value is not
    allowed, the value is divided by 1.1. The linear chain gives every change a second time.

    Parameters
    ----------
    scene : Scene
        A scene without a sweep.
    keys : sequence of str
        Keys of the values. Default: all that stand on a drawing and that the scene has.
    within_db : float, dB
        Wanted standard uncertainty of every change. Default: 0.1.
    minutes : float
        Time after which no more specimens begin; the first six are always heard. Default: 10.
    folder : Path or str
        Folder that keeps the specimens, so that the same call goes on. Default: none, and only the
        numbers are kept.
    workers, progress : int, bool
        As in `simulate`.

    Returns
    -------
    sensitivities : Sensitivities
        Changes of the level, the largest first, with `table()`, `plot(ax)` and `sentences`.

    Raises
    ------
    SceneError
        The scene sweeps, cannot run, makes no sound, or has no value of a key.
    FolderError
        The folder holds something else.
    ContactError
        The contact of the scene has no solution.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> import rolling
    >>> words = ["rolling.load_n=1", "rolling.duration_s=0.003"]
    >>> scene = rolling.read_scene("quickstart", words)
    >>> found = rolling.sensitivities(scene, ["distance_m"], workers=1, progress=False)
    >>> round(found.rows[0].db, 2)
    -0.83
    """
    from rolling.choice.sensitivity import improve_scene

    instance("scene", scene, Scene)
    if isinstance(keys, str):
        raise TypeError(f"keys: got {keys!r}, allowed: a list of keys, as in [{keys!r}]")
    with _kept_in(folder, progress) as kept:
        return improve_scene(
            scene=scene,
            folder=kept,
            keys=keys,
            within_db=within_db,
            minutes=minutes,
            workers=workers,
        )


@ignoring_underflow
def coarsest_below(
    scene: Scene,
    key: str,
    level_db: float,
    between: tuple[float | str, float | str] | None = None,
    seeds: int = defaults.LIMIT_SEEDS,
    folder: Path | str | None = None,
    workers: int = 0,
    progress: bool | None = None,
) -> Limit:
    """Find the coarsest value of a key with which a scene stays below a level.

    Below means that 95 % of specimens lie below the level, with a confidence of 95 %. Where a
    larger value is quieter, the smallest value that stays below is found.

    Parameters
    ----------
    scene : Scene
        A scene without a sweep, on a random or a measured surface.
    key : str
        Key of a number above 0, of the finish, or of the grade of the ball.
    level_db : float, dB(A)
        The level of the vibration at the listener of the scene.
    between : pair of float or str
        Range of the search. Default: a fifth of the value of the scene to five times it, as far as
        scenes are allowed, or all finishes or grades.
    seeds : int
        Number of specimens, from 3 to 60. Default: 12.
    folder : Path or str
        Folder that keeps the specimens, so that the same call goes on. Default: none, and only the
        numbers are kept.
    workers, progress : int, bool
        As in `simulate`.

    Returns
    -------
    limit : Limit
        The answer, with `value`, `table()`, `plot(ax)` and `sentences`.

    Raises
    ------
    SceneError
        The scene sweeps or cannot run, the key is unknown or has no such value, the range is not
        allowed, or nothing is random in the scene.
    FolderError
        The folder holds something else.
    ContactError
        A contact has no solution.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> import rolling
    >>> words = ["rolling.load_n=1", "rolling.duration_s=0.003"]
    >>> scene = rolling.read_scene("quickstart", words)
    >>> limit = rolling.coarsest_below(
    ...     scene, "distance_m", 200, between=(1, 1.1), seeds=3, workers=1, progress=False
    ... )
    >>> limit.value, limit.rises
    (1.0, False)

    References
    ----------
    ISO 16269-6:2014, for the tolerance limit.
    """
    from rolling.choice.limit import coarsest_value

    instance("scene", scene, Scene)
    with _kept_in(folder, progress) as kept:
        return coarsest_value(
            scene=scene,
            key=key,
            level_db=level_db,
            between=between,
            seeds=seeds,
            folder=kept,
            workers=workers,
        )


@contextmanager
def _kept_in(folder: Path | str | None, progress: bool | None) -> Iterator[Path]:
    """Give a folder of specimens, a temporary one without a name, and be silent if asked to."""
    with ExitStack() as stack:
        if progress is False:
            stack.enter_context(terminal.begin(terminal.Level.QUIET))
        if folder is None:
            yield Path(stack.enter_context(tempfile.TemporaryDirectory())) / "choice"
        else:
            yield Path(folder)
