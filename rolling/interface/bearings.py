"""Runs of bearings for Python: simulated in memory, opened from their folders, saved."""

from __future__ import annotations

from pathlib import Path

from acoustics.arrays import instance
from acoustics.traps import ignoring_underflow
from rolling.bearing_run import command
from rolling.bearing_run.bearing_run import BearingRun
from rolling.bearing_run.simulation import bearing_stages
from rolling.run import folder as folders
from rolling.scene.bearing_scene import BearingScene
from rolling.terminal import progress as terminal
from rolling.terminal.notebook import interrupt_with_message


@ignoring_underflow
def simulate_bearing(
    scene: BearingScene,
    workers: int = 0,
    progress: bool | None = None,
    start_from: Path | str | None = None,
) -> BearingRun:
    """Simulate a bearing in memory: rough contacts, motion of the ring, bands and lines.

    Parameters
    ----------
    scene : BearingScene
        A scene without a sweep; `scene.runs()` lists those of a sweep.
    workers, progress : int, bool
        As in `simulate`.
    start_from : Path or str
        Run folder of another bearing, whose marches of equal contacts are taken, such as that of
        the same bearing without its faults. Default: none.

    Returns
    -------
    run : BearingRun
        Velocity in the three bands of ISO 15242-1, lines, loads of the balls, and the record.

    Raises
    ------
    SceneError
        The scene sweeps, or a contact of it cannot be marched.
    FolderError
        `start_from` is no run folder of a bearing.
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
    >>> print(run.numbers.below_bending.radial.low)
    81 um/s ± 0.1 dB, computed
    >>> run.numbers.lines[-1].name
    'inner 9'
    """
    instance("scene", scene, BearingScene)
    command.refuse_sweep(scene)
    source = None
    if start_from is not None:
        instance("start_from", start_from, str, Path)
        source = folders.bearing_home(Path(start_from))
    with terminal.shown(progress), interrupt_with_message():
        *_, last = bearing_stages(scene, workers=workers, shown=progress, start_from=source)
    assert last.run is not None  # all marches are done
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
        The run as `simulate_bearing` returns it, with the stored numbers; its series are in single
        precision.

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
    instance("folder", folder, str, Path)
    return command.read_run(folders.done_bearing_run(Path(folder), "open"))


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
    ['.csv', '.csv', '.csv', '.h5', '.json', '.json', '.wav', '.wav', '.yaml']
    """
    instance("run", run, BearingRun)
    instance("folder", folder, str, Path)
    return command.save_run(run, folders.new_folder(Path(folder)), report)
