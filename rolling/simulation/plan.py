"""The runs of a scene, their folders and their inputs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rolling.check import long_steps, refusals, tolerance
from rolling.contact import of_scene
from rolling.folders import files, run_record
from rolling.folders.run_record import RunRecord
from rolling.scene import file
from rolling.scene.messages import SceneError
from rolling.scene.run_names import run_names
from rolling.scene.scene import Scene, SweepRun
from rolling.simulation.batch import Run, seen_from


def refuse(scene: Scene, workers: int, folder: Path | None) -> None:
    """Refuse a scene that cannot be run, before anything is computed or written.

    Parameters
    ----------
    scene : Scene. A scene with or without a sweep.
    workers : int. Number of processes; 0: one per core.
    folder : Path. The folder of the files; None: nothing is written.

    Raises
    ------
    SceneError : a package is missing, steps are too long, or memory or disk do not suffice.
    """
    refusals.refuse_unavailable(scene)
    long_steps.refuse_long_steps(scene)
    try:
        refusals.refuse_what_cannot_fit(scene, workers, folder or refusals.OUTPUTS)
    except SceneError as error:
        # A run in memory needs no disk.
        faults = [
            fault for fault in error.faults if folder is not None or not fault.startswith("disk:")
        ]
        if faults:
            raise SceneError(faults) from error
    for _, single in scene.runs():
        of_scene.rolling_contact(single)  # reads the surface


class Plan:
    """The runs of a scene and their inputs, before they have a folder.

    scene : Scene. A scene with or without a sweep.
    given : bytes. The text of the scene file; None for a scene that was made in memory.
    whole : bool. Whether each run of a sweep has the inputs in its own folder. Otherwise they are
        in the folder of the sweep and in result.h5. Default: true.
    """

    def __init__(self, scene: Scene, given: bytes | None, whole: bool = True) -> None:
        self.scene, self.given, self.whole = scene, given, whole
        self.singles = scene.runs()
        self.names = run_names([values for values, _ in self.singles]) if scene.sweep else [""]

    @property
    def height_files(self) -> list[Path]:
        """The height files that the runs read."""
        paths = [single.height_path for _, single in self.singles]
        return [path for path in dict.fromkeys(paths) if path is not None]

    def take_tolerances(self, runs: Sequence[Run]) -> None:
        """Take the tolerances of stored runs with the same swept values."""
        self.singles = [
            SweepRun(values, single.with_({"numerics.tolerance": run.scene.numerics.tolerance}))
            if tolerance.is_open(single)
            else SweepRun(values, single)
            for (values, single), run in zip(self.singles, runs, strict=True)
        ]

    def record(self) -> RunRecord:
        """Return the first run.json of the folder."""
        return run_record.new("sweep", self.names) if self.scene.sweep else run_record.new("run")

    def runs(self, folder: Path) -> list[Run]:
        """Return the runs with their folders."""
        return [
            Run(values, single, folder / name)
            for (values, single), name in zip(self.singles, self.names, strict=True)
        ]

    def write(self, folder: Path) -> None:
        """Write the inputs of each run and of the sweep into their folders."""
        for run in self.runs(folder):
            # A run of a sweep can be resumed and resounded on its own, so it also has the inputs.
            if run.folder != folder:
                run.folder.mkdir(exist_ok=True)
            if run.folder != folder and self.whole:
                run_record.write(run.folder, run_record.new("run"))
                self._write_scene(run.folder, run.scene)
        self._write_scene(folder, self.scene)

    def _write_scene(self, folder: Path, scene: Scene) -> None:
        if self.given is not None:
            files.write_bytes(folder / "scene.yaml", self.given)
        files.write_bytes(folder / "resolved.yaml", file.dump(seen_from(folder, scene)).encode())
