"""A run of a scene and its folder, whose files tell whether it is done or failed."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from rolling.scene.height_files import read_regular
from rolling.scene.scene import Scene
from rolling.scene.sweep import Value

RESULT, SUMMARY, FAILED = "result.h5", "summary.json", "failed.json"
PAGE = "report.html"  # of all runs of a folder
MOST_FAILURE = 1_000_000  # bytes of a failed.json


@dataclass(frozen=True, eq=False)
class RunFolder:
    """A run of a scene and its folder.

    values : mapping. The swept values of the run, by dotted key.
    scene : Scene. The scene with these values, without a sweep.
    folder : Path. The folder of the run.
    """

    values: Mapping[str, Value]
    scene: Scene
    folder: Path

    @property
    def home(self) -> Path:
        """The folder that `rolling run` made: the folder of the sweep for a run of a sweep."""
        return self.folder.parent if self.values else self.folder

    @property
    def is_done(self) -> bool:
        """Whether the run is whole: its summary is written after its result."""
        return (self.folder / RESULT).is_file() and (self.folder / SUMMARY).is_file()

    @property
    def failure(self) -> str | None:
        """The reason of the last failure, or None."""
        try:
            content = read_regular(self.folder / FAILED, MOST_FAILURE)
            return str(json.loads(content)["reason"])
        except (FileNotFoundError, NotADirectoryError):
            return None
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return "unknown"
