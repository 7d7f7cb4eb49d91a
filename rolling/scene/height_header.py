"""Nodes and type of the heights in a file, from the header alone where the format has one."""

from __future__ import annotations

import lzma
import math
import struct
import tokenize
import warnings
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from rolling.scene import height_text
from rolling.scene.height_format import (
    SHAPES,
    TEXT_ENDINGS,
    HeightFormatError,
    ending_of,
    rows_and_columns,
)
from rolling.scene.yaml_text import open_at_once

NAME = "heights"  # of the array in an archive of several
_NPY, _MAGIC = ".npy", b"\x93NUMPY"
# Errors of numpy and zipfile for damaged files. Their texts are not repeated: some of them advise
# to load objects, which would run code of the file.
DAMAGE = (
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    NotImplementedError,  # zipfile: an unknown compression or a newer version of the format
    OSError,
    RuntimeError,
    SyntaxError,
    TypeError,
    ValueError,
    lzma.LZMAError,
    struct.error,
    tokenize.TokenError,
    zipfile.BadZipFile,
    zlib.error,
)


@dataclass(frozen=True)
class Header:
    """Nodes along and across in a height file, and the type of its heights."""

    nodes: tuple[int, int]
    dtype: np.dtype[Any]


def header(path: Path) -> Header:
    """Read the nodes and the type of the heights in a file.

    Raises
    ------
    HeightFormatError
        The file is missing, of another format, damaged, shorter than its header says, or holds no
        heights.
    """
    if ending_of(path) in TEXT_ENDINGS:
        table = height_text.values(path)
        return Header(rows_and_columns(table.shape), table.dtype)
    with opened(path) as (stream, size), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of headers by Python 2
        shape, dtype, begin = _array_header(stream)
    if any(count < 0 for count in shape):
        raise HeightFormatError("a damaged file: its header says a negative shape")
    if dtype.kind not in "fiu":
        raise HeightFormatError(f"got {len(shape)}-D {dtype}, allowed: {SHAPES}")
    nodes = rows_and_columns(shape)
    needed, there = math.prod(shape) * dtype.itemsize, max(size - begin, 0)
    if needed > there:
        raise HeightFormatError(
            f"a file that is not whole: its header says {_count(needed)} bytes of heights, it holds"
            f" {there:,}"
        )
    return Header(nodes, dtype)


@contextmanager
def opened(path: Path) -> Iterator[tuple[IO[bytes], int]]:
    """Open the array in a .npy or .npz file for reading; give the stream and its size [bytes].

    Damage that is met while the stream is read raises HeightFormatError as well.

    Raises
    ------
    HeightFormatError
        The file is not readable, no archive, or an archive of several arrays without a name.
    """
    try:
        with open_at_once(path) as file:
            if path.suffix.lower() == _NPY:
                _refuse_foreign(file)
                yield file, path.stat().st_size
                return
            with zipfile.ZipFile(file) as archive:
                member = archive.getinfo(_member(archive.namelist()))
                with archive.open(member) as stream:
                    yield stream, member.file_size
    except zipfile.BadZipFile as error:
        raise HeightFormatError("no readable .npz file") from error
    except DAMAGE as error:
        reason = error.strerror if isinstance(error, OSError) else None
        raise HeightFormatError(
            f"no readable {path.suffix.lower()} file ({reason or 'damaged'})"
        ) from error


def _refuse_foreign(file: IO[bytes]) -> None:
    """Refuse a file without the signature of .npy, and go back to its beginning."""
    begin = file.read(len(_MAGIC))
    file.seek(0)
    if begin.startswith(b"PK\x03\x04"):
        raise HeightFormatError("no .npy file but an archive; rename it to .npz")
    if begin != _MAGIC:
        raise HeightFormatError(
            "no readable .npy file (its signature is missing); text must be named .csv or .txt"
        )


def _member(names: list[str]) -> str:
    """Return the file of the heights within an archive: of the only array, or of the named one."""
    arrays = [name for name in names if name.endswith(_NPY)]
    if NAME + _NPY in arrays:
        return NAME + _NPY
    if len(arrays) == 1:
        return arrays[0]
    listed = ", ".join(repr(name.removesuffix(_NPY))[:60] for name in arrays[:5])
    got = f"{len(arrays)} arrays ({listed}{', ...' * (len(arrays) > 5)})" if arrays else "no array"
    raise HeightFormatError(f'got {got}, allowed: one array, or one that is named "{NAME}"')


def _array_header(stream: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any], int]:
    """Read shape and type of an array, and the bytes that its header takes."""
    version = np.lib.format.read_magic(stream)
    if version not in ((1, 0), (2, 0)):
        raise HeightFormatError("no readable .npy file (of names that no heights need)")
    read = (
        np.lib.format.read_array_header_1_0
        if version == (1, 0)
        else np.lib.format.read_array_header_2_0
    )
    shape, _, dtype = read(stream)
    return tuple(int(count) for count in shape), dtype, stream.tell()


def _count(number: int) -> str:
    """Write a whole number with separators, a very long one in powers of ten."""
    return f"{number:,}" if number < 10**15 else f"10^{len(str(number)) - 1} or more"
