"""Heights in text files: numbers by comma, semicolon, tab or whitespace, a row on each line."""

from __future__ import annotations

import io
from array import array
from collections.abc import Iterator
from functools import lru_cache
from math import isfinite
from pathlib import Path

import numpy as np

from rolling._typing import Array
from rolling.scene.height_format import HeightFormatError
from rolling.scene.messages import shown
from rolling.scene.yaml_text import open_at_once

MAX_BYTES = 500_000_000  # of a file: reading text takes long, and .npy holds the same in less
MAX_LINE = 20_000_000  # letters
MAX_FAULTS = 100  # lines with faults, after which reading stops
_NAMED = 5  # of these lines
_MARK = "\xef\xbb\xbf"  # of UTF-8, in the letters of Latin-1
_ALLOWED = "numbers by comma, semicolon, tab or whitespace"


def values(path: Path) -> Array:
    """Read the numbers of a text file, shape (lines, numbers on each).

    Empty lines and lines that begin with # do not count. A separator at the end of a line adds no
    number. The array is read-only, because the last one is kept.

    Raises
    ------
    HeightFormatError
        The file is not readable or too large, or lines hold anything but as many finite numbers as
        the first.
    """
    try:
        status = path.stat()
        if status.st_size > MAX_BYTES:
            raise HeightFormatError(
                f"is larger than {MAX_BYTES:,} bytes of text; a .npy file may be larger"
            )
        return _read(path, (status.st_mtime_ns, status.st_size, status.st_ino))
    except OSError as error:
        raise HeightFormatError(f"not readable ({error.strerror or error})") from error


@lru_cache(maxsize=1)
def _read(path: Path, stamp: tuple[int, ...]) -> Array:
    """Read the numbers of a file that was last written at a stamp."""
    numbers, rows, width = array("d"), 0, 0
    separator: str | None = None
    faults: list[tuple[int, str]] = []
    for place, line in _lines(path):
        separator = separator or _separator(line)
        row, fault = _row(line, separator)
        if not fault and width and len(row) != width:
            fault = f"got {len(row)} numbers, allowed: {width}, as on the lines before"
        if fault:
            faults.append((place, fault))
            if len(faults) == MAX_FAULTS:
                break
        elif not faults:
            width, rows = len(row), rows + 1
            numbers.extend(row)
    if faults:
        line_number, fault = faults[0]
        raise HeightFormatError(fault + _further([place for place, _ in faults[1:]]), line_number)
    if not rows:
        raise HeightFormatError(f"holds no heights, allowed: {_ALLOWED}")
    table = np.frombuffer(numbers, dtype=float).reshape(rows, width)
    table.flags.writeable = False
    return table


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield number and text of the lines that hold values.

    Numbers are ASCII. Read as Latin-1, comments may be in any encoding.
    """
    with io.TextIOWrapper(io.BufferedReader(open_at_once(path)), encoding="latin-1") as stream:
        for number in range(1, MAX_BYTES + 2):
            line = stream.readline(MAX_LINE)
            if not line:
                return
            if len(line) == MAX_LINE:
                raise HeightFormatError(f"a line of more than {MAX_LINE:,} letters", number)
            line = (line.removeprefix(_MARK) if number == 1 else line).strip(" \t\r\n")
            if line and not line.startswith("#"):
                yield number, line


def _separator(line: str) -> str | None:
    """Return the separator of the numbers on a line, None for whitespace or a single number."""
    return next((sign for sign in (";", "\t", ",") if sign in line), None)


def _row(line: str, separator: str | None) -> tuple[list[float], str]:
    """Return the numbers of a line, or none and the fault of the first that is no number."""
    fields = line.split(separator)
    if separator and not fields[-1].strip():
        fields.pop()
    try:
        row = [float(field) for field in fields]
        if all(map(isfinite, row)) and "_" not in line:
            return row, ""
    except ValueError:
        pass
    wrong = next((field for field in fields if not _is_number(field)), line)
    decimal = separator != "," and _is_number(wrong.replace(",", ".", 1))
    advice = ", with a point before the decimals" if decimal else ""
    return [], f"got {shown(_decoded(wrong.strip()))}, allowed: {_ALLOWED}{advice}"


def _is_number(field: str) -> bool:
    try:
        return isfinite(float(field)) and "_" not in field
    except ValueError:
        return False


def _decoded(text: str) -> str:
    """Return text that was read as Latin-1 as the UTF-8 that it probably is."""
    return text.encode("latin-1").decode("utf-8", "backslashreplace")


def _further(lines: list[int]) -> str:
    """Name further lines with faults."""
    if not lines:
        return ""
    named = ", ".join(map(str, lines[:_NAMED]))
    rest = f" and {len(lines) - _NAMED} more" if len(lines) > _NAMED else ""
    return f" (likewise line{'s' * (len(lines) > 1)} {named}{rest})"
