"""Shape and type of the heights in a .npy file, from its header alone."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from rolling.scene.messages import first_line
from rolling.scene.yaml_text import kind_of_file, open_at_once


class HeaderError(Exception):
    """Reason why a file is no whole .npy file."""


def header(path: Path) -> tuple[tuple[int, ...], np.dtype]:
    """Read shape and type of the array in a .npy file.

    Raises
    ------
    HeaderError
        The file is missing, no regular file, no .npy file, or shorter than its header says.
    """
    try:
        status = path.stat()
    except FileNotFoundError as error:
        raise HeaderError("no such file") from error
    except (OSError, ValueError) as error:  # ValueError: a zero byte in the name
        raise HeaderError(f"not readable ({getattr(error, 'strerror', None) or error})") from error
    kind = kind_of_file(status.st_mode)
    if kind is not None:
        raise HeaderError(f"is {kind}")
    try:
        with open_at_once(path) as stream:
            version = np.lib.format.read_magic(stream)
            if version not in ((1, 0), (2, 0)):
                raise HeaderError("no readable .npy file (of names that no heights need)")
            read = (
                np.lib.format.read_array_header_1_0
                if version == (1, 0)
                else np.lib.format.read_array_header_2_0
            )
            shape, _, dtype = read(stream)
            there = status.st_size - stream.tell()
    except (
        OSError,
        ValueError,
        EOFError,
        OverflowError,
        RecursionError,
        MemoryError,
        SyntaxError,
    ) as error:
        with open_at_once(path) as stream:
            archive = stream.read(4) == b"PK\x03\x04"
        raise HeaderError(
            "got an archive" if archive else f"no readable .npy file ({first_line(error)})"
        ) from error
    if any(count < 0 for count in shape):
        raise HeaderError("no readable .npy file (a negative shape)")
    needed = math.prod(shape) * dtype.itemsize
    if needed > there:
        raise HeaderError(
            f"no whole .npy file: its header says {needed:,} bytes of heights, it holds"
            f" {max(there, 0):,}"
        )
    return tuple(map(int, shape)), dtype
