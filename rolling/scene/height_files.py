"""Regular files, and the numbers in arrays of numpy and in texts, by the endings of their names."""

import hashlib
import io
import math
import warnings
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import IO, Any

import numpy as np

from acoustics.arrays import Array
from rolling.scene.height_format import MAX_BYTES, HeightFormatError
from rolling.scene.messages import TABLES, SceneError
from rolling.scene.text_heights import TRIPLES, text_heights
from rolling.terminal.whole_files import open_regular, read_regular

NAME = "heights.npy"  # of the array in an archive of several
ARRAYS = (".npy", ".npz")
TEXTS = (".csv", ".txt", ".tsv", ".asc", ".prf", TRIPLES)
INSTRUMENTS = (".x3p", ".sdf", *TABLES["formats"])
MAY_BE_TEXT = (".dat",)  # endings that instruments give to binary files and to texts
_PERIODS = (*ARRAYS, ".csv", ".txt")  # files that are taken for one period of a surface
_ENDINGS = (*ARRAYS, *TEXTS)
EXPORT = 'export it as a matrix of numbers, in Gwyddion "ASCII data matrix (.txt)"'  # remedy
_ARRAY = "one 2-D array of real heights, (along track, across), or a profile of one line"


def holds_heights(path: Path | str) -> bool:
    """Tell whether the ending of a name is of a format of heights."""
    return Path(path).suffix.lower() in (*_ENDINGS, *INSTRUMENTS, *MAY_BE_TEXT)


def is_text(path: Path | str) -> bool:
    """Tell whether the ending of a name is of a text with a table of numbers."""
    return Path(path).suffix.lower() in TEXTS


def takes_units(path: Path | str) -> bool:
    """Tell whether a file with this ending may be a text, whose units a person may have to say."""
    return Path(path).suffix.lower() in (*TEXTS, *MAY_BE_TEXT)


def is_array(path: Path | str) -> bool:
    """Tell whether the ending of a name is of an array, which holds neither spacing nor unit."""
    return Path(path).suffix.lower() in ARRAYS


def is_period(path: Path | str) -> bool:
    """Tell whether a file with this ending is taken for one period, unless a key says otherwise."""
    return Path(path).suffix.lower() in _PERIODS


def is_instrument(path: Path | str) -> bool:
    """Tell whether the ending of a name is of a format that holds its own spacing and unit."""
    return Path(path).suffix.lower() in INSTRUMENTS


def nodes(path: Path) -> tuple[int, int]:
    """Read the nodes along and across of a height file; a profile of one line is one column.

    Raises
    ------
    HeightFormatError
        The file is missing, of another format, damaged, shorter than its header says, or holds no
        heights.
    """
    if _ending(path) in TEXTS:
        return _rows_and_columns(_of_text(path).shape)
    with _opened(path) as (stream, size), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of headers by Python 2
        shape, dtype, begin = _array_header(stream)
    if any(count < 0 for count in shape):
        raise HeightFormatError("a damaged file: its header says a negative shape")
    if dtype.kind not in "fiu":
        raise HeightFormatError(f"got {len(shape)}-D {dtype}, allowed: {_ARRAY}")
    counts = _rows_and_columns(shape)
    needed = math.prod(shape) * dtype.itemsize
    there = max(size - begin, 0)
    if needed > there:
        count = f"{needed:,}"
        if needed >= 10**15:
            count = f"10^{len(str(needed)) - 1} or more"
        raise HeightFormatError(
            f"a file that is not whole: its header says {count} bytes of heights, it holds"
            f" {there:,}"
        )
    return counts


def numbers(path: Path) -> np.ndarray:
    """Read the numbers of a height file, shape (along, across); raise as `nodes` does."""
    shape = nodes(path)
    if is_text(path):
        return _of_text(path).reshape(shape)
    with _opened(path) as (stream, _):
        return np.asarray(np.lib.format.read_array(stream, allow_pickle=False)).reshape(shape)


def refuse_missing(path: Path) -> None:
    """Raise HeightFormatError for a path that is no readable regular file."""
    try:
        open_regular(path).close()
    except OSError as error:
        raise HeightFormatError(reason_of(error)) from error


def _ending(path: Path) -> str:
    """Return the ending of the name of an existing regular file; raise HeightFormatError else."""
    refuse_missing(path)
    ending = path.suffix.lower()
    if ending not in _ENDINGS:
        got = f"the ending {path.suffix}" if ending else "no ending"
        raise HeightFormatError(
            f"got {got}, allowed: .npy, .npz, .csv or .txt, of a plate .xyz and formats of"
            f" instruments such as .x3p, .sdf or .sur; {EXPORT}"
        )
    return ending


def _rows_and_columns(shape: tuple[int, ...]) -> tuple[int, int]:
    """Return the nodes along and across in an array of one or two dimensions."""
    if len(shape) not in (1, 2):
        raise HeightFormatError(f"got a {len(shape)}-D array, allowed: {_ARRAY}")
    if len(shape) == 1 or 1 in shape:
        return math.prod(shape), 1
    return shape[0], shape[1]


# ---- arrays of numpy


@contextmanager
def _opened(path: Path) -> Iterator[tuple[IO[bytes], int]]:
    """Open the array in a .npy or .npz file; yield the stream and its size [bytes].

    Damage that is met while the stream is read raises HeightFormatError as well.
    """
    ending = path.suffix.lower()
    try:
        with io.BufferedReader(open_regular(path)) as file:
            if ending == ".npy":
                yield file, path.stat().st_size
                return
            with zipfile.ZipFile(file) as archive:
                member = archive.getinfo(_member(archive.namelist()))
                if member.compress_type != zipfile.ZIP_STORED and member.file_size > MAX_BYTES:
                    raise HeightFormatError(
                        f"holds {member.file_size:,} bytes of packed heights, allowed:"
                        f" {MAX_BYTES:,}; a .npy file may be larger"
                    )
                with archive.open(member) as stream:
                    yield stream, member.file_size
    except HeightFormatError:
        raise
    except Exception as error:  # of numpy and zipfile, whose texts may advise to run its code
        reason = "damaged, or another format"
        if isinstance(error, OSError) and error.strerror:
            reason = error.strerror
        raise HeightFormatError(f"no readable {ending} file ({reason})") from error


def _member(names: list[str]) -> str:
    """Return the file of the heights within an archive: of the only array, or of the named one."""
    arrays = [name for name in names if name.endswith(".npy")]
    if NAME in arrays:
        return NAME
    if len(arrays) == 1:
        return arrays[0]
    got = "no array"
    if arrays:
        listed = [repr(name.removesuffix(".npy"))[:60] for name in arrays[:5]]
        if len(arrays) > 5:
            listed.append("...")
        got = f"{len(arrays)} arrays ({', '.join(listed)})"
    raise HeightFormatError(f'got {got}, allowed: one array, or one that is named "heights"')


def _array_header(stream: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any], int]:
    """Read shape and type of an array, and the bytes that its header takes."""
    version = np.lib.format.read_magic(stream)
    if version == (1, 0):
        shape, _, dtype = np.lib.format.read_array_header_1_0(stream)
    else:  # later versions have names that no heights need
        shape, _, dtype = np.lib.format.read_array_header_2_0(stream)
    return tuple(int(count) for count in shape), dtype, stream.tell()


# ---- text


def _of_text(path: Path) -> Array:
    """Return the heights in a text file in its own unit, shape (rows, columns)."""
    return text_heights(path).numbers


def doubts(path: Path) -> list[str]:
    """Return a sentence for each doubt about a text file that can be read: commas and places."""
    return list(text_heights(path).doubts) if is_text(path) else []


# ---- regular files


def reason_of(error: OSError) -> str:
    """Say why a file is not opened or read."""
    reason = error.strerror or str(error)
    if isinstance(error, FileNotFoundError):
        return "no such file"
    return reason if reason.startswith("is ") else f"not readable ({reason})"


def holds(path: Path, content: bytes) -> bool:
    """Tell whether a path is a regular file with this content."""
    try:
        return read_regular(path, len(content)) == content
    except OSError:
        return False


def file_digest(path: Path) -> str:
    """Return the SHA-256 of the bytes of a height file; raise SceneError if it is unreadable."""
    try:
        stamp = path.stat()
        return _file_digest(path, (stamp.st_mtime_ns, stamp.st_size, stamp.st_ino))
    except OSError as error:
        raise SceneError([f"surface.path: {path}: {reason_of(error)}"]) from error


@lru_cache(maxsize=1000)
def _file_digest(path: Path, stamp: tuple[int, ...]) -> str:
    with open_regular(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
