"""Commands and their arguments by name, and usage errors that name the nearest word.

commands.toml lists commands and arguments, with their texts.
"""

import argparse
import difflib
import os
import re
import tomllib
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

from rolling.terminal import defaults

_TABLE = tomllib.loads(Path(__file__).with_name("commands.toml").read_text(encoding="utf-8"))
COMMANDS: dict[str, dict[str, Any]] = _TABLE["commands"]
_ARGUMENTS: dict[str, dict[str, Any]] = _TABLE["arguments"]
_LIKENESS = 0.5  # least likeness of a nearest name, between 0 and 1


def _path(text: str) -> Path:
    if not text.strip():
        raise argparse.ArgumentTypeError("empty; is a variable of the shell not set?")
    # `Path.is_file` would raise an error where a folder may not be searched.
    files = (above for above in Path(text).parents if os.path.isfile(above))  # noqa: PTH113
    if file := next(files, None):
        raise argparse.ArgumentTypeError(f"got {text!r}, but {str(file)!r} is a file")
    return Path(text)


def _whole(text: str, least: int = 0) -> int:
    if not (text.isdecimal() and len(text) <= 20 and int(text) >= least):
        raise argparse.ArgumentTypeError(f"got {text!r}, allowed: a whole number, at least {least}")
    return int(text)


def _power_of_two(text: str) -> int:
    value = _whole(text, 1)
    if value < 2 or value & (value - 1):
        raise argparse.ArgumentTypeError("2, 4, 8, ...")
    return value


def _part(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text)
    number, count = map(int, match.groups()) if match else (0, 0)
    if not 1 <= number <= count:
        raise argparse.ArgumentTypeError(
            f"got {text!r}, allowed: K/N, such as 3/40, with K from 1 to N"
        )
    return number, count


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


_TYPES = {
    "path": _path,
    "whole": _whole,
    "count": partial(_whole, least=1),
    "power of two": _power_of_two,
    "part": _part,
    "positive": _positive,
    "speed": _speed,
}


def add(parser: argparse.ArgumentParser, command: str) -> None:
    """Add the arguments of a command to its parser."""
    texts, places = (COMMANDS[command].get(key, {}) for key in ("texts", "metavars"))
    for name in COMMANDS[command]["arguments"]:
        settings = _ARGUMENTS[name] | ({"help": texts[name]} if name in texts else {})
        settings |= {"metavar": places[name]} if name in places else {}
        for key, value in settings.items():
            if isinstance(value, str):
                settings[key] = value.format_map(vars(defaults))
        if "type" in settings:
            settings["type"] = _TYPES[settings["type"]]
        parser.add_argument(name, **settings)


def add_volume(parser: argparse.ArgumentParser, default: Any) -> None:
    """Add the options that say more or less."""
    either = parser.add_mutually_exclusive_group()
    for short, name, text in (
        ("-q", "--quiet", "print refusals, errors and the folder (or page) only"),
        ("-v", "--verbose", "say more: steps and times"),
    ):
        either.add_argument(short, name, action="store_true", default=default, help=text)


def refuse_unknown_command(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Exit with a usage error if the first word that is no option is no command."""
    name = next((word for word in words if not word.startswith("-")), None)
    if name is not None and name not in COMMANDS:
        parser.error(
            f"COMMAND: got {name}{_nearest(name, [*COMMANDS])}, allowed: {', '.join(COMMANDS)}"
        )


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
