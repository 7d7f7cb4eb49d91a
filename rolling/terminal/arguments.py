"""Arguments of the command line by name, and usage errors that name the nearest word."""

from __future__ import annotations

import argparse
import difflib
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from rolling.terminal import defaults

_LIKENESS = 0.5  # least likeness of a nearest name, between 0 and 1


def _path(text: str) -> Path:
    if not text.strip():
        raise argparse.ArgumentTypeError("empty; is a variable of the shell not set?")
    return Path(text)


def _count(text: str) -> int:
    if not text.isdecimal() or not 1 <= len(text.lstrip("0")) <= 20:
        raise argparse.ArgumentTypeError(f"got {text!r}, allowed: a whole number, at least 1")
    return int(text)


def _part(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text)
    number, count = map(int, match.groups()) if match else (0, 0)
    if not 1 <= number <= count:
        raise argparse.ArgumentTypeError(
            f"got {text!r}, allowed: K/N, such as 3/40, with K from 1 to N"
        )
    return number, count


def _power_of_two(text: str) -> int:
    value = _count(text)
    if value < 2 or value & (value - 1):
        raise argparse.ArgumentTypeError("2, 4, 8, ...")
    return value


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"got {text!r}, allowed: a number more than 0")
    return value


def _speed(text: str) -> float | tuple[float, float]:
    start, colon, end = text.partition(":")
    try:
        return (float(start), float(end)) if colon else float(start)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"got {text!r}, allowed: V or START:END in m/s") from error


def _whole(text: str) -> int:
    if not (text.isdecimal() and len(text) <= 20):
        raise argparse.ArgumentTypeError(f"got {text!r}, allowed: a whole number, at least 0")
    return int(text)


_FLAG: dict[str, Any] = {"action": "store_true"}
_LIST: dict[str, Any] = {"nargs": "+", "default": []}

ARGUMENTS: dict[str, dict[str, Any]] = {
    "scene": {
        "type": _path,
        "metavar": "SCENE",
        "help": "scene file (YAML), or a name of `rolling scenes`",
    },
    "folder": {"type": _path, "metavar": "RUN", "help": "run folder"},
    "folders": {"type": _path, "metavar": "RUN", "nargs": "+", "help": "run folders"},
    "source": {
        "type": _path,
        "metavar": "FILE",
        "help": "file of heights in any format, scene file (YAML), or a name of `rolling scenes`",
    },
    "--spacing-um": {"type": _positive, "metavar": "UM", "help": "node spacing, if FILE has none"},
    "--channel": {"metavar": "NAME", "help": "channel of FILE (default: the first)"},
    "--height-unit": {
        "choices": ("m", "mm", "um", "nm"),
        "default": "m",
        "help": "unit of the heights, if FILE has none (default: m)",
    },
    "--save": {"type": _path, "metavar": "OUT", "help": "new file for the heights, by its ending"},
    "--set": {
        "action": "append",
        "default": [],
        "metavar": "KEY=VALUE",
        "help": "override, such as rolling.load_n=50",
    },
    "--out": {"type": _path, "metavar": "FOLDER", "help": "run folder; again: goes on there"},
    "--part": {
        "type": _part,
        "metavar": "K/N",
        "help": "do every N-th march of a sweep from march K on, in a folder that the commands of"
        " all parts share: for array jobs",
    },
    "--workers": {
        "type": _count,
        "default": 0,
        "metavar": "N",
        "help": "processes (default: one per core)",
    },
    "--cluster": {
        "metavar": "ADDRESS",
        "help": "solve on the workers of a Dask scheduler: its address, or its scheduler file"
        " (.json)",
    },
    "--no-report": {**_FLAG, "help": "write no report page and no figures"},
    "--open": {**_FLAG, "help": "open the report page in a browser"},
    "--fast": {**_FLAG, "help": "solve no positions; use closed forms and estimates only"},
    "--watch": {
        **_FLAG,
        "help": "print the status again when it changes, until no run is waiting or running",
    },
    "--plot": {
        **_LIST,
        "metavar": "NUMBER",
        "help": "columns of runs.csv to plot (default: laeq_db)",
    },
    "--against": {
        **_LIST,
        "metavar": "KEY",
        "help": "a swept key for lines, or two for a map (default: the first swept key)",
    },
    "--over": {
        "metavar": "KEY",
        "default": "surface.seed",
        "help": "the swept key over which statistics are made (default: surface.seed)",
    },
    "--figure": {**_LIST, "metavar": "NAME", "help": "figures to draw (default: all)"},
    "--format": {
        "choices": ("png", "svg", "csv"),
        "default": "png",
        "help": "picture, or its numbers (default: png)",
    },
    "--seconds": {
        "type": _positive,
        "default": defaults.LISTENED_SECONDS,
        "metavar": "S",
        "help": f"length of the record to make (default {defaults.LISTENED_SECONDS:g}), up to"
        f" {defaults.MOST_LISTENED_SECONDS:g}",
    },
    "--speed": {
        "type": _speed,
        "metavar": "V",
        "help": "speed in m/s, or start:end for an even change (default: the scene's, which goes on"
        " at its last speed)",
    },
    "--seed": {
        "type": _whole,
        "default": 0,
        "metavar": "N",
        "help": "number of the random continuation (default 0)",
    },
    "--finest": {
        "type": _power_of_two,
        "default": defaults.FINEST,
        "metavar": "N",
        "help": f"divide the spacing by 2, 4, ... up to N (default {defaults.FINEST})",
    },
    "--duration": {
        "type": _positive,
        "default": defaults.ACCURACY_SECONDS,
        "metavar": "S",
        "help": f"seconds of rolling at most (default {defaults.ACCURACY_SECONDS:g}:"
        " no third octave from 100 Hz is empty)",
    },
    "study": {
        "choices": ("lee2025",),
        "metavar": "STUDY",
        "help": "lee2025: Lee, Kim & Kim, Inventions 10(1), 17",
    },
    "--readings": {**_LIST, "metavar": "NAME", "help": "readings to run (default: all)"},
    "--quick": {
        **_FLAG,
        "help": f"{defaults.QUICK_SEEDS} surface, loads of"
        f" {', '.join(map(str, defaults.QUICK_LOADS_N))} N, {defaults.QUICK_SECONDS:g} s in steps"
        f" {defaults.QUICK_STRIDES} times as long",
    },
    "--all": {**_FLAG, "help": "list the scenes of studies as well"},
    "name": {
        "nargs": "?",
        "default": "quickstart",
        "metavar": "NAME",
        "help": "name of the scene (default: quickstart)",
    },
}


def add(parser: argparse.ArgumentParser, names: Sequence[str], **changes: str) -> None:
    """Add arguments to the parser of a command; `changes` are help texts by destination."""
    for name in names:
        settings = dict(ARGUMENTS[name])
        settings["help"] = changes.get(name.lstrip("-"), settings["help"])
        parser.add_argument(name, **settings)


def add_volume(parser: argparse.ArgumentParser, default: Any) -> None:
    """Add the options that say more or less."""
    either = parser.add_mutually_exclusive_group()
    for short, name, text in (
        ("-q", "--quiet", "print refusals, errors and the folder (or page) only"),
        ("-v", "--verbose", "say more: steps and times"),
    ):
        either.add_argument(short, name, action="store_true", default=default, help=text)


def refuse_unknown_command(
    parser: argparse.ArgumentParser, words: Sequence[str], commands: Sequence[str]
) -> None:
    """Exit with a usage error if the first word that is no option is no command."""
    name = next((word for word in words if not word.startswith("-")), None)
    if name is not None and name not in commands:
        near = _nearest(name, commands)
        parser.error(f"COMMAND: got {name}{near}, allowed: {', '.join(commands)}")


def refuse_unknown_arguments(parser: argparse.ArgumentParser, unknown: Sequence[str]) -> NoReturn:
    """Exit with a usage error about arguments that a command does not take."""
    options = sorted(set(re.findall(r"--[a-z][a-z-]*", parser.format_help())))
    slips = [word.partition("=")[0] for word in unknown if word.startswith("--")]
    near = next(filter(None, (_nearest(slip, options) for slip in slips)), "")
    parser.error(f"got {' '.join(unknown)}{near}, allowed: {', '.join(options)}")


def _nearest(name: str, names: Sequence[str]) -> str:
    """Return ", nearest: NAME" with the name that is like a misspelt one, or nothing."""
    near = difflib.get_close_matches(name.lower(), names, 1, _LIKENESS)
    return f", nearest: {near[0]}" if near else ""
