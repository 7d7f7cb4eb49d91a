"""Scene to the runs that it makes, their folders and their inputs. Depends on scene files and run.json."""

from __future__ import annotations

from pathlib import Path

from rolling.folders import files, run_record
from rolling.folders.run_record import RunRecord
from rolling.scene import file
from rolling.scene.run_names import run_names
from rolling.scene.scene import Scene
from rolling.simulation.batch import Run, seen_from


class Plan:
    """The runs of a scene and their inputs, before they have a folder."""

    def __init__(self, scene: Scene, given: bytes | None) -> None:
        self.scene, self.given = scene, given
        self.singles = scene.runs()
        self.names = run_names([values for values, _ in self.singles]) if scene.sweep else [""]

    @property
    def height_files(self) -> list[Path]:
        """The file of heights, if the scene reads one."""
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
        """Write the inputs of each run into its folder, and those of the sweep into the one above."""
        for one in self.runs(folder):
            # A single run can be resumed and resounded on its own: it says what it was given, too.
            if one.folder != folder:
                one.folder.mkdir(exist_ok=True)
                run_record.write(one.folder, run_record.new("run"))
                self._write_scene(one.folder, one.scene)
        self._write_scene(folder, self.scene)

    def _write_scene(self, folder: Path, scene: Scene) -> None:
        if self.given is not None:
            files.write_bytes(folder / "scene.yaml", self.given)
        files.write_bytes(folder / "resolved.yaml", file.dump(seen_from(folder, scene)).encode())
