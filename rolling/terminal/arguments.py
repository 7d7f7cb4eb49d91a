"""Types of the arguments of commands, and usage errors that name the nearest word."""

import argparse
import difflib
import os
import re
import stat
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import NoReturn

from rolling.terminal.whole_files import kind_of

_LIKENESS = 0.5  # least likeness of a nearest name, between 0 and 1


def path(text: str) -> Path:
    """Return the path that a text names.

    An empty text, a path below a file, and a pipe or a device, which might never end, are refused.
    """
    if not text.strip():
        raise argparse.ArgumentTypeError("empty; is a variable of the shell not set?")
    with suppress(OSError, ValueError):  # there is nothing yet, or nothing that could be opened
        mode = os.stat(text).st_mode  # noqa: PTH116
        if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):
            raise argparse.ArgumentTypeError(
                f"got {text!r}, {kind_of(mode)}; allowed: a regular file, or a folder"
            )
    # `Path.is_file` would raise an error where a folder may not be searched.
    files = (above for above in Path(text).parents if os.path.isfile(above))  # noqa: PTH113
    if file := next(files, None):
        raise argparse.ArgumentTypeError(f"got {text!r}, but {str(file)!r} is a file")
    return Path(text)


def whole(text: str, least: int = 0) -> int:
    """Return a whole number, at least `least`."""
    if not (text.isdecimal() and len(text) <= 20 and int(text) >= least):
        raise argparse.ArgumentTypeError(f"got {text!r}, allowed: a whole number, at least {least}")
    return int(text)


def count(text: str) -> int:
    """Return a whole number, at least 1."""
    return whole(text, least=1)


def power_of_two(text: str) -> int:
    """Return 2, 4, 8, ..."""
    value = count(text)
    if value < 2 or value & (value - 1):
        raise argparse.ArgumentTypeError("2, 4, 8, ...")
    return value


def part(text: str) -> tuple[int, int]:
    """Return K and N of the text K/N."""
    match = re.fullmatch(r"(\d{1,9})/(\d{1,9})", text)
    if match:
        number = int(match[1])
        parts = int(match[2])
        if 1 <= number <= parts:
            return number, parts
    raise argparse.ArgumentTypeError(
        f"got {text!r}, allowed: K/N, such as 3/40, with K from 1 to N"
    )


def positive(text: str) -> float:
    """Return a number more than 0."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"got {text!r}, allowed: a number more than 0")
    return value


def number(text: str) -> float:
    """Return a finite number."""
    try:
        value = float(text)
    except ValueError:
        value = float("inf")
    if not abs(value) < float("inf"):
        raise argparse.ArgumentTypeError(f"got {text!r}, allowed: a number")
    return value


def speed(text: str) -> float | tuple[float, float]:
    """Return a speed, or the speeds at start and end of the text START:END."""
    start, colon, end = text.partition(":")
    try:
        if colon:
            return float(start), float(end)
        return float(start)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"got {text!r}, allowed: V or START:END in m/s") from error


def refuse_unknown_command(
    parser: argparse.ArgumentParser, words: Sequence[str], commands: Sequence[str]
) -> None:
    """Exit with a usage error if the first word that is no option is no command."""
    names = [word for word in words if not word.startswith("-")]
    if names and names[0] not in commands:
        allowed = ", ".join(commands)
        parser.error(f"COMMAND: got {names[0]}{_nearest(names[0], commands)}, allowed: {allowed}")


def refuse_unknown_arguments(parser: argparse.ArgumentParser, unknown: Sequence[str]) -> NoReturn:
    """Exit with a usage error about arguments that a command does not take; name the nearest."""
    options = sorted(set(re.findall(r"--[a-z][a-z-]*", parser.format_help())))
    groups: list[list[str]] = []  # each unknown option with its values
    for word in unknown:
        if word.startswith("--") or not groups:
            groups.append([word])
        else:
            groups[-1].append(word)
    texts = []
    for group in groups:
        text = " ".join(group)
        if text.startswith("--"):
            text += _nearest(group[0].partition("=")[0], options)
        texts.append(text)
    parser.error(f"got {'; '.join(texts)}; allowed: {', '.join(options)}")


def _nearest(name: str, names: Sequence[str]) -> str:
    """Return ", nearest: NAME" with the name that is like a misspelt one, or nothing."""
    near = difflib.get_close_matches(name.lower(), names, n=1, cutoff=_LIKENESS)
    if not near:
        return ""
    return f", nearest: {near[0]}"
