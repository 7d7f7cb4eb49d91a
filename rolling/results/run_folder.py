"""A run of a scene and its folder, whose files tell whether it is done or failed.

summary.json is read with bounds on its size and on the kinds of its values.
"""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rolling.check.doubt import Severity
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.height_files import read_regular
from rolling.scene.scene import Scene
from rolling.scene.sweep import Value
from rolling.terminal.files import FolderError

RESULT = "result.h5"
SUMMARY = "summary.json"
FAILED = "failed.json"
PAGE = "report.html"  # of all runs of a folder
TABLE = "runs.csv"
MAX_FAILURE = 1_000_000  # bytes of a failed.json


class RunPlace:
    """Swept values and folder of a run of any scene, whose files tell its state."""

    values: Mapping[str, Value]
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
            return str(json.loads(read_regular(self.folder / FAILED, MAX_FAILURE))["reason"])
        except (FileNotFoundError, NotADirectoryError):
            return None
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return "unknown"


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

    values: Mapping[str, Value]
    scene: BearingScene
    folder: Path


# ---- summary


MAX_SUMMARY = 10_000_000  # bytes
# Keys of every summary. Those that are no text, mapping or list have a number or null.
_NEEDED = (
    "laeq_db",
    "level_db",
    "steady_level_db",
    "uncertainty_db",
    "source",
    "doubts",
    "surface",
    "third_octave_db",
    "levelling",
    "plastic_ratio",
    "steps",
    "step_ms",
)
_MAPPINGS = (
    "surface",
    "uncertainty_db",
    "third_octave_db",
    "third_octave_a_db",
    "provenance",
    "packages",
    "signal",
    "listen",
    "listening",
    "parts_cpu_s",
    "error_estimate",
    "levelling",
)
_TEXTS = (
    *("name", "label", "source", "text", "advice", "word", "reason"),
    "vibration_estimate_bodies",
)
_NUMBERS = ("q",)  # whose names do not end in a unit
# Keys of the estimate of the vibration, which a summary has together.
_ESTIMATE = ("vibration_estimate_force_ratio", "vibration_estimate_bodies")
# Numbers of the long record of what ends, whose level is read first.
_WHOLE = ("seconds", "solved_share")
_VERDICT = ("word", "reason", "decibels", "key")
_PREPARATION = ("step", "text")  # of each step
_DOUBT = ("key", "text", "advice", "severity", "decibels")
_SEVERITIES = {severity.word for severity in Severity}
_UNITS = "db|n|hz|s|ms|w|m|m2|pa|kg|sone|acum|ratio|share|mm|um|restitution"
# Keys of numbers, and of mappings of numbers.
_NUMBER = re.compile(rf"surface|steps|impacts|seconds|pascal_.*|.*_({_UNITS})")


def read_summary(path: Path) -> dict[str, Any]:
    """Read the numbers of a run.

    Raises
    ------
    FolderError : the file is damaged, or not written by this program.
    """
    advice = "delete it, and the same command solves the run again"
    try:
        summary = json.loads(read_regular(path, MAX_SUMMARY), parse_constant=_refuse_constant)
        _refuse_other_summary(summary)
    except OSError as error:
        reason = error.strerror or str(error)
        raise FolderError(f"{path}: not readable ({reason}); {advice}") from error
    except (ValueError, RecursionError) as error:
        raise FolderError(f"{path}: not readable ({error}); {advice}") from error
    return dict(summary)


def stored_summary(run: RunFolder) -> dict[str, Any] | None:
    """Return the summary of a run, from its file unless it is in memory; None without one."""
    summary: dict[str, Any] | None = getattr(run, "summary", None)
    path = run.folder / SUMMARY
    if summary is None and path.is_file():
        summary = read_summary(path)
    return summary


def _refuse_constant(constant: str) -> None:
    """Refuse NaN and infinity, which JSON does not have."""
    raise ValueError(f"{constant} is no number")


def _refuse_other_summary(summary: Any) -> None:
    """Raise ValueError unless a value is a summary, whose values are of the kinds of their keys."""
    if not isinstance(summary, dict):
        raise ValueError("no object of names and values")
    for key in _NEEDED:
        if key not in summary:
            raise ValueError(f"{key} is missing")
    for key in _ESTIMATE:
        if "vibration_estimate_laeq_db" in summary and key not in summary:
            raise ValueError(f"{key} is missing")
    for key, value in summary.items():
        if not _fits(key, value):
            raise ValueError(f"{key} is of another kind")
    long = summary.get("listening") or {}
    if long.get("ends") and any(long.get(key) is None for key in _WHOLE):
        raise ValueError("listening lacks a number")


def _fits(key: str, value: Any) -> bool:
    """Return whether a value is of the kind that its key says."""
    if key == "doubts":
        return isinstance(value, list) and all(_is_doubt(item) for item in value)
    if key == "verdict":
        return value is None or _has_fields(value, _VERDICT)
    if key == "preparation":
        return isinstance(value, list) and all(_has_fields(step, _PREPARATION) for step in value)
    if key in _TEXTS:
        return value is None or isinstance(value, str)
    if key in _MAPPINGS:
        if key == "levelling" and value is None:
            return True
        return isinstance(value, dict) and _fits_mapping(key, value)
    if key in _NEEDED or key in _NUMBERS:
        return _is_number(value)
    if isinstance(value, dict):
        return _fits_mapping(key, value)
    if isinstance(value, list):
        return all(_fits(key, item) for item in value)
    return _is_number(value) or not _NUMBER.fullmatch(key)


def _fits_mapping(key: str, mapping: dict[str, Any]) -> bool:
    """Return whether the values of a mapping fit; under the key of a number all are numbers."""
    if _NUMBER.fullmatch(key):
        return all(_is_number(value) for value in mapping.values())
    return all(_fits(name, value) for name, value in mapping.items())


def _has_fields(value: Any, fields: tuple[str, ...]) -> bool:
    """Return whether a value is a mapping with these names at least, whose values fit."""
    if not isinstance(value, dict) or not set(fields) <= value.keys():
        return False
    return _fits_mapping("", value)


def _is_doubt(value: Any) -> bool:
    """Return whether a value is a doubt, as `verdict.as_json` writes it."""
    if not isinstance(value, dict) or value.keys() != set(_DOUBT):
        return False
    if not all(isinstance(value[name], str) for name in ("key", "text", "advice", "severity")):
        return False
    return value["severity"] in _SEVERITIES and _is_number(value["decibels"])


def _is_number(value: Any) -> bool:
    """Return whether a value is a finite number, or None for an unknown one."""
    return value is None or (type(value) in (int, float) and abs(value) < 1e300)
