"""A run of a scene and its folder, whose files tell whether it is done or failed."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from rolling.scene.sweep import Value
from rolling.terminal.whole_files import read_regular

RESULT = "result.h5"
NUMBERS = "numbers.json"  # unrounded, for the program
SUMMARY = "summary.json"  # their view for people
FAILED = "failed.json"
PAGE = "report.html"  # of all runs of a folder
TABLE = "runs.csv"
BANDS = "bands.csv"
LISTEN = "listen.wav"
RELEASED = "released.wav"
MAX_FAILURE = 1_000_000  # bytes of a failed.json
MAX_NUMBERS = 10_000_000  # bytes of a numbers.json or summary.json


@dataclass(frozen=True, eq=False)
class RunFolder:
    """A run of a scene and its folder.

    values : mapping. The swept values of the run, by dotted key.
    scene : scene of any kind. The scene with these values, without a sweep.
    folder : Path. The folder of the run.
    MADE_ONCE : tuple of str. Cached properties of a solved run that take long to make. Copies make
        them again when they are asked for; a command that keeps a run keeps them beside it.
    """

    MADE_ONCE: ClassVar[tuple[str, ...]] = ()

    values: Mapping[str, Value]
    scene: Any
    folder: Path

    @property
    def home(self) -> Path:
        """The folder that `rolling run` made: the folder of the sweep for a run of a sweep."""
        return self.folder.parent if self.values else self.folder

    @property
    def made(self) -> dict[str, Any]:
        """Properties of `MADE_ONCE` that are made already, by name."""
        return {name: vars(self)[name] for name in self.MADE_ONCE if name in vars(self)}

    @property
    def is_done(self) -> bool:
        """Whether the run is whole: its summary is written after its result."""
        return (self.folder / RESULT).is_file() and (self.folder / SUMMARY).is_file()

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
