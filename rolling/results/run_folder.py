"""A run of a scene and its folder, whose files tell whether it is done or failed."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from rolling.scene.bearing_scene import BearingScene
from rolling.scene.height_files import read_regular
from rolling.scene.scene import Scene
from rolling.scene.sweep import Value
from rolling.terminal.files import FolderError

RESULT = "result.h5"
NUMBERS = "numbers.json"  # unrounded, for the program
SUMMARY = "summary.json"  # their view for people
FAILED = "failed.json"
PAGE = "report.html"  # of all runs of a folder
TABLE = "runs.csv"
BANDS = "bands.csv"
MAX_FAILURE = 1_000_000  # bytes of a failed.json
MAX_NUMBERS = 10_000_000  # bytes of a numbers.json or summary.json


class RunPlace:
    """Swept values and folder of a run of any scene, whose files tell its state."""

    values: Mapping[str, Value]
    folder: Path
    format_of_0_8: ClassVar[int | None] = None  # of a summary.json

    @property
    def home(self) -> Path:
        """The folder that `rolling run` made: the folder of the sweep for a run of a sweep."""
        return self.folder.parent if self.values else self.folder

    @property
    def is_done(self) -> bool:
        """Whether the run is whole: its summary is written after its result."""
        return (self.folder / RESULT).is_file() and (self.folder / SUMMARY).is_file()

    @property
    def is_of_0_8(self) -> bool:
        """Whether version 0.8 wrote the numbers of the run, by the format of its summary."""
        if not is_former(self.folder):
            return False
        try:
            content = json.loads(read_regular(self.folder / SUMMARY, MAX_NUMBERS))
        except (OSError, ValueError, RecursionError):
            return False
        return isinstance(content, dict) and content.get("format") == self.format_of_0_8

    @property
    def failure(self) -> str | None:
        """The reason of the last failure, or None."""
        try:
            return str(json.loads(read_regular(self.folder / FAILED, MAX_FAILURE))["reason"])
        except (FileNotFoundError, NotADirectoryError):
            return None
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return "unknown"


def is_former(folder: Path) -> bool:
    """Tell whether a run folder lacks its numbers, as those of version 0.8 do."""
    return not (folder / NUMBERS).is_file() and (folder / SUMMARY).is_file()


@dataclass(frozen=True, eq=False)
class RunFolder(RunPlace):
    """A run of a scene and its folder.

    values : mapping. The swept values of the run, by dotted key.
    scene : Scene. The scene with these values, without a sweep.
    folder : Path. The folder of the run.
    """

    values: Mapping[str, Value]
    scene: Scene
    folder: Path


@dataclass(frozen=True, eq=False)
class BearingFolder(RunPlace):
    """A run of a bearing and its folder.

    values : mapping. The swept values of the run, by dotted key.
    scene : BearingScene. The scene with these values, without a sweep.
    folder : Path. The folder of the run.
    """

    format_of_0_8: ClassVar[int | None] = 1

    values: Mapping[str, Value]
    scene: BearingScene
    folder: Path


def refuse_former(runs: Iterable[RunPlace]) -> None:
    """Refuse to go on with runs of version 0.8, or to make their sound anew.

    Raises
    ------
    FolderError : one of the runs has the numbers of version 0.8.
    """
    for run in runs:
        if run.is_of_0_8:
            raise FolderError(
                f"{run.folder}: a run of version 0.8. This version shows it (`rolling report`,"
                " `table`), but does not go on with it or make its sound anew. Version 0.8.1 does;"
                " or solve its scene in a new folder, with another --out"
            )
