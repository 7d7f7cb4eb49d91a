"""The runs of a scene, their folders and their inputs."""

from __future__ import annotations

from pathlib import Path

from rolling.folders import files, run_record
from rolling.folders.run_record import RunRecord
from rolling.scene import file
from rolling.scene.run_names import run_names
from rolling.scene.scene import Scene, expand
from rolling.simulation.batch import Run, seen_from


class Plan:
    """The runs of a scene and their inputs, before they have a folder.

    scene : Scene. A scene with or without a sweep.
    given : bytes. The text of the scene file; None for a scene that was made in memory.
    """

    def __init__(self, scene: Scene, given: bytes | None) -> None:
        self.scene, self.given = scene, given
        self.singles = expand(scene)
        self.names = run_names([values for values, _ in self.singles]) if scene.sweep else [""]

    @property
    def height_files(self) -> list[Path]:
        """The height file, if the scene reads one."""
        return [self.scene.height_path] if self.scene.height_path is not None else []

    def record(self) -> RunRecord:
        """Return the first run.json of the folder."""
        return run_record.new("sweep", self.names) if self.scene.sweep else run_record.new("run")

    def runs(self, folder: Path) -> list[Run]:
        """Return the runs, each with its folder."""
        return [
            Run(values, single, folder / name) for (values, single), name in zip(self.singles, self.names, strict=True)
        ]

    def write(self, folder: Path) -> None:
        """Write the inputs of each run into its folder, and the inputs of the sweep into the folder above."""
        for run in self.runs(folder):
            # A run of a sweep can be resumed and resounded on its own, so it has the inputs as well.
            if run.folder != folder:
                run.folder.mkdir(exist_ok=True)
                run_record.write(run.folder, run_record.new("run"))
                self._write_scene(run.folder, run.scene)
        self._write_scene(folder, self.scene)

    def _write_scene(self, folder: Path, scene: Scene) -> None:
        if self.given is not None:
            files.write_bytes(folder / "scene.yaml", self.given)
        files.write_bytes(folder / "resolved.yaml", file.dump(seen_from(folder, scene)).encode())
