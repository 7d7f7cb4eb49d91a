"""Formats of height files by the endings of their names, and the faults of such files."""

from __future__ import annotations

import math
from pathlib import Path

from rolling.scene.yaml_text import kind_of_file

TEXT_ENDINGS = (".csv", ".txt")
ENDINGS = (".npy", ".npz", *TEXT_ENDINGS)
SHAPES = "one 2-D array of real heights, (along track, across), or a profile of one line"
UNITS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}  # of heights, in m


class HeightFormatError(Exception):
    """A reason why a file cannot be read as heights, with the line of a text file that has it."""

    def __init__(self, message: str, line: int | None = None) -> None:
        super().__init__(message)
        self.line = line

    def of(self, name: object) -> str:
        """Write the reason behind the name of the file and the line."""
        return f"{name}: {self}" if self.line is None else f"{name}:{self.line}: {self}"


def ending_of(path: Path) -> str:
    """Return the ending of the name of an existing regular file, one of ENDINGS.

    Raises
    ------
    HeightFormatError
        The file is missing, no regular file, or of a format that cannot be read.
    """
    try:
        kind = kind_of_file(path.stat().st_mode)
    except FileNotFoundError as error:
        raise HeightFormatError("no such file") from error
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        reason = getattr(error, "strerror", None) or error
        raise HeightFormatError(f"not readable ({reason})") from error
    if kind is not None:
        raise HeightFormatError(f"is {kind}")
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise HeightFormatError(
            f"got {f'the ending {path.suffix}' if ending else 'no ending'}, allowed: .npy, .npz,"
            " .csv or .txt; export the heights as a matrix of numbers, for example in Gwyddion with"
            ' "ASCII data matrix (.txt)"'
        )
    return ending


def rows_and_columns(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the nodes along and across in an array; a profile of one line is one column.

    Raises
    ------
    HeightFormatError
        The array has neither one dimension nor two.
    """
    if len(shape) not in (1, 2):
        raise HeightFormatError(f"got a {len(shape)}-D array, allowed: {SHAPES}")
    return (math.prod(shape), 1) if len(shape) == 1 or 1 in shape else (shape[0], shape[1])
