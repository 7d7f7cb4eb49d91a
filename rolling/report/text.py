"""Texts and tables of the page as plain text, from the summaries of runs."""

import tomllib
from collections.abc import Mapping, Sequence
from importlib.resources import files
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

from acoustics.numbers import rounded
from rolling.results.labels import printable
from rolling.results.run_result import Run
from rolling.results.runs_table import LEVELS, level_name, level_text, uncertain
from rolling.scene import file

NOTHING = "-"  # for a number that does not exist
Fact = tuple[str, list[tuple[str, str]]]  # quantity; labels of runs (empty: all runs) and value


def asset(name: str) -> str:
    """Read a file of the page, which is the program's own text."""
    return files("rolling.report").joinpath("assets", name).read_text(encoding="utf-8")


class Column(NamedTuple):
    """A column of the table of levels, which levels.toml explains."""

    head: str
    unit: str = ""
    factor: float = 1.0
    form: str = ".1f"
    always: bool = False


COLUMNS = {key: Column(**column) for key, column in tomllib.loads(asset("levels.toml")).items()}


# ---- levels


def titles(runs: Sequence[Run]) -> str:
    """Join the titles of the scenes, or their names where they have none, in printable letters."""
    return printable(", ".join(dict.fromkeys(run.scene.title or run.scene.name for run in runs)))


def sentence(runs: Sequence[Run]) -> str:
    """State the result in one sentence."""
    levels = ((run.sound.levels.laeq_db, run) for run in runs)
    sounding = sorted(((db, run) for db, run in levels if db is not None), key=itemgetter(0))
    if not sounding:
        return f"No sound: {'; '.join(dict.fromkeys(map(silence, runs)))}."
    (low_db, quietest), (high_db, loudest) = sounding[0], sounding[-1]
    distances = {run.scene.listener_place for run in runs}
    at = f" at {distances.pop()}" if len(distances) == 1 else ""
    silent = len(runs) - len(sounding)
    also = f" {silent} of {len(runs)} runs are silent." if silent else ""
    name = level_head(runs)
    if len(sounding) == 1:
        laeq = uncertain(low_db, quietest.summary["uncertainty_db"]["laeq"])
        return f"{quietest.label}: {name} {laeq} dB(A) re 20 µPa{at}.{also}"
    name = name[0].upper() + name[1:]
    if high_db - low_db < 0.05:
        return f"{name}{at} is {low_db:.1f} dB(A) in all {len(sounding)} runs that sound.{also}"
    return (
        f"{name}{at} lies between {low_db:.1f} dB(A) ({quietest.label}) and {high_db:.1f} dB(A)"
        f" ({loudest.label}), {high_db - low_db:.1f} dB apart.{also}"
    )


def silence(run: Run) -> str:
    """State the reason of the silence of a run."""
    if run.summary.get("flight_share") == 1 and not run.summary["impacts"]:
        return f"the record of {rounded(run.sound.duration)} s ends before the ball hits the plate"
    return f"the {run.sound.source} does not fluctuate within hearing"


def level_head(runs: Sequence[Run]) -> str:
    """Name the level of runs: of the vibration, of the released power, or of both."""
    names = dict.fromkeys(level_name(run.summary) for run in runs)
    return " or ".join(names)


def levels(runs: Sequence[Run]) -> tuple[list[str], list[tuple[str, list[str]]]]:
    """Return heads and rows (label, cells) of the table of levels and contact numbers.

    A level without sound is `silent`, and one that was not computed `-`.
    """
    columns = {
        key: column
        for key, column in COLUMNS.items()
        if column.always or any(run.summary.get(key) is not None for run in runs)
    }
    names = {key: column.head for key, column in columns.items()} | {"laeq_db": level_head(runs)}
    units = (f" [{column.unit}]" if column.unit else "" for column in columns.values())
    heads = [name + unit for name, unit in zip(names.values(), units, strict=True)]
    return heads, [(run.label, [_cell(run, *item) for item in columns.items()]) for run in runs]


def _cell(run: Run, key: str, column: Column) -> str:
    """Write a number of a run for a table."""
    if key in LEVELS and key in run.summary:
        return level_text(run.summary, key)
    if (value := run.summary.get(key)) is None:
        return NOTHING
    number = value * column.factor
    return f"{number:{column.form}}" if column.form else rounded(number, 4)


# ---- facts


def facts(runs: Sequence[Run], records: Sequence[Mapping[str, str]]) -> list[Fact]:
    """Merge facts of runs by name, each value once with the labels of its runs."""
    merged: list[Fact] = []
    for name in dict.fromkeys(name for record in records for name in record):
        labels_by_value: dict[str, list[str]] = {}
        for run, record in zip(runs, records, strict=True):
            labels_by_value.setdefault(record.get(name, NOTHING), []).append(run.label)
        several = len(labels_by_value) > 1
        values = [("; ".join(names * several), x) for x, names in labels_by_value.items()]
        merged.append((name, values))
    return merged


def recipes(runs: Sequence[Run]) -> list[dict[str, str]]:
    """Return labels, file, scene and command that reproduce runs, once for the runs of a sweep."""
    members: dict[Path, list[Run]] = {}
    for run in runs:
        members.setdefault(run.home, []).append(run)
    written = []
    for home, (first, *others) in members.items():
        name, path = f"{first.scene.name}.yaml", home / "scene.yaml"
        # The folder of a run in memory is the working directory, whose scene.yaml is a stranger's.
        is_stored = "provenance" in first.summary and path.is_file()
        scene = path.read_text("utf-8") if is_stored else file.dump(first.scene)
        names = "; ".join(run.label for run in (first, *others))
        command = f"rolling run {name}"
        written.append({"labels": names, "file": name, "scene": scene, "command": command})
    return written


def provenance(runs: Sequence[Run]) -> list[Fact]:
    """List program, packages and machine that made the numbers; empty for runs in memory."""
    records = []
    for run in runs:
        stored = dict(run.summary.get("provenance", {}))
        stored.pop("label", None)
        if packages := stored.pop("packages", None):
            stored["packages"] = ", ".join(f"{name} {v}" for name, v in packages.items())
        records.append({name: NOTHING if x is None else str(x) for name, x in stored.items()})
    return facts(runs, records)
