"""Regular files, and heights in them: .npy and .npz of numpy, and text with rows of numbers."""

import hashlib
import io
import itertools
import math
import re
import warnings
import zipfile
from array import array
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import IO, Any, cast

import numpy as np

from acoustics.arrays import Array
from rolling.scene.kept import Kept
from rolling.scene.messages import TABLES, SceneError, quoted
from rolling.terminal.whole_files import open_regular, read_regular

UNITS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}  # of heights, in m
MAX_BYTES = 500_000_000  # of a file, packed or not; reading takes long, and .npy may be larger
MAX_LINE = 20_000_000  # letters
MAX_KEPT = 64_000_000  # bytes of the numbers of text files that a process keeps
NAME = "heights.npy"  # of the array in an archive of several
_TEXT_ENDINGS = (".csv", ".txt")
_ENDINGS = (".npy", ".npz", *_TEXT_ENDINGS)
TRIPLES = ".xyz"
INSTRUMENTS = (TRIPLES, ".x3p", ".sdf", *TABLES["formats"])
_DECIMALS = re.compile(r"\s*-?0\d+\s*")  # no whole number begins with 0
_DECIMALS_IN_LINE = re.compile(r"(?:^|,)\s*-?0\d+\s*(?:,|$)")
_WHOLE = re.compile(r"[+-]?\d+")
# A number with a comma before its decimals, and perhaps points between its thousands.
_DECIMAL_COMMA = re.compile(r"[+-]?(\d{1,3}(\.\d{3})+|\d*),\d+([eE][+-]?\d+)?")
_MIN_OTHERS = 8  # whole numbers that no digits behind a comma can be, as many are no chance
_MIN_SHARE = 0.5  # of the numbers before commas; so many are no chance in a small file either
_EQUAL = 0.02  # of a step, by which places that are rounded may differ from equal steps
_MIN_POINTS = 16  # of triples; the grid of fewer may be chance
_MIN_LINES = 8  # of a matrix of heights or of a profile, in which a line may be places
_SPARSE = 2  # nodes of a grid for each triple, at most
_NUMBERS = "numbers by comma, semicolon, tab or whitespace"
_ARRAY = "one 2-D array of real heights, (along track, across), or a profile of one line"


class HeightFormatError(Exception):
    """A reason why a file cannot be read as heights, with the line of a text file that has it."""

    def __init__(self, message: str, line: int | None = None) -> None:
        super().__init__(message)
        self.line = line

    def of(self, name: object) -> str:
        """Write the reason behind the name of the file and the line."""
        return f"{name}: {self}" if self.line is None else f"{name}:{self.line}: {self}"


def is_instrument(path: Path | str) -> bool:
    """Tell whether the ending of a name is of a format that holds its own spacing."""
    return Path(path).suffix.lower() in INSTRUMENTS


def nodes(path: Path) -> tuple[int, int]:
    """Read the nodes along and across of a height file; a profile of one line is one column.

    Raises
    ------
    HeightFormatError
        The file is missing, of another format, damaged, shorter than its header says, or holds no
        heights.
    """
    if _ending(path) in _TEXT_ENDINGS:
        table, commas = _text(path)
        _refuse_places(table)
        if commas.is_refused:
            raise HeightFormatError(commas.words)
        return _rows_and_columns(table.shape)
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
    if path.suffix.lower() in _TEXT_ENDINGS:
        return numbers_of_text(path).reshape(shape)
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
            " instruments such as .x3p, .sdf or .sur; export others as a matrix of numbers, in"
            ' Gwyddion "ASCII data matrix (.txt)"'
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


def numbers_of_text(path: Path) -> Array:
    """Read the numbers of a text file, shape (rows, columns).

    Empty lines and lines that begin with # do not count. A separator at the end of a line adds no
    number. The array is read-only, because the last ones are kept.
    """
    return _text(path)[0]


def doubts(path: Path) -> list[str]:
    """Return a sentence for each doubt about a text file that can be read: commas and places."""
    if path.suffix.lower() not in _TEXT_ENDINGS:
        return []
    table, commas = _text(path)
    is_flat = bool(np.all(table == table[0, 0]))
    sentences = [commas.words] if commas.is_possible and not is_flat else []
    for lines, name, beside in ((table, "column", "row"), (table.T, "row", "column")):
        if len(lines) < _MIN_LINES or lines.shape[1] < _MIN_LINES:
            continue
        # The first number of all stands for nothing where a row and a column are places.
        step = _equal_step(lines[:, 0]) or _equal_step(lines[1:, 0])
        if step and not _equal_step(lines[1:, 1]):
            sentences.append(
                f"the first {name} changes in equal steps of {abs(step):.6g}, as numbers or places"
                f" of the {beside}s do: if these are no heights, remove that {name} from the file"
            )
    return sentences


def _text(path: Path) -> "tuple[Array, _Commas]":
    """Read the numbers of a text file, and what its commas may be."""
    status = path.stat()
    if status.st_size > MAX_BYTES:
        raise HeightFormatError(
            f"is larger than {MAX_BYTES:,} bytes of text; a .npy file may be larger"
        )
    stamp = status.st_mtime_ns, status.st_size, status.st_ino
    return _tables.value((path, stamp), lambda: _table(path))


_tables: Kept["tuple[Array, _Commas]"] = Kept(MAX_KEPT, lambda table: table[0].nbytes)


def _table(path: Path) -> "tuple[Array, _Commas]":
    """Read the numbers of a file, and what its commas may be."""
    table, commas = _fast_table(path) or _slow_table(path)
    table.flags.writeable = False
    return table, commas


def _fast_table(path: Path) -> "tuple[Array, _Commas] | None":
    """Read the numbers of a file by numpy; None where a person has to be told what is wrong."""
    commas = _Commas()
    lines = (line for _, line in _lines(path))
    first = next(lines, None)
    if first is None:
        return None
    separator = _separator(first)
    texts = _plain_lines(itertools.chain([first], lines), separator, commas)
    try:
        table = np.loadtxt(texts, dtype=float, comments=None, delimiter=separator, ndmin=2)
    except (ValueError, OverflowError):
        return None
    if np.isinf(table).any():
        return None
    return table, commas


def _plain_lines(lines: Iterator[str], separator: str | None, commas: "_Commas") -> Iterator[str]:
    """Yield lines without a separator at their ends; raise ValueError for doubtful commas."""
    for line in lines:
        if separator == ",":
            has_points = line.count(".") > line.count(",")  # in every number
            if not has_points and _DECIMALS_IN_LINE.search(line):
                raise ValueError("decimals behind a comma")
            commas.add(line)
        yield line.removesuffix(separator) if separator else line


def _separator(line: str) -> str | None:
    """Return what separates the numbers of a line; None for whitespace."""
    return next((sign for sign in (";", "\t", ",") if sign in line), None)


def _slow_table(path: Path) -> "tuple[Array, _Commas]":
    """Read the numbers of a file line by line, and say on which line one is wrong."""
    values = array("d")
    rows = 0
    width = 0
    separator: str | None = None
    commas = _Commas()
    for place, line in _lines(path):
        separator = separator or _separator(line)
        row = _row(line, separator, place)
        if separator == ",":
            commas.add(line)
        if width and len(row) != width:
            words = f"got {len(row)} numbers, allowed: {width}, as on the lines before"
            raise HeightFormatError(words, place)
        width = len(row)
        rows += 1
        values.extend(row)
    if not rows:
        raise HeightFormatError(f"holds no heights, allowed: {_NUMBERS}")
    return np.frombuffer(values, dtype=float).reshape(rows, width), commas


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Yield number and text of the lines that hold values.

    Numbers are ASCII. Read as Latin-1, comments may be in any encoding.
    """
    with io.TextIOWrapper(io.BufferedReader(open_regular(path)), encoding="latin-1") as stream:
        for number in itertools.count(1):
            line = stream.readline(MAX_LINE)
            if len(line) == MAX_LINE:
                raise HeightFormatError(f"a line of more than {MAX_LINE:,} letters", number)
            if not line:
                return
            if number == 1 and line.startswith(("\xff\xfe", "\xfe\xff")):
                raise HeightFormatError("a text in UTF-16, allowed: ASCII or UTF-8")
            # The mark of UTF-8 may stand before the first number.
            line = line.removeprefix("\xef\xbb\xbf").strip(" \t\r\n")
            if line and not line.startswith("#"):
                yield number, line


def _row(line: str, separator: str | None, place: int) -> list[float]:
    """Return the numbers of a line; raise HeightFormatError for the first that is no number."""
    fields = line.split(separator)
    if separator == ",":
        _refuse_decimal_commas(line, fields, place)
    if separator and not fields[-1].strip():
        fields.pop()
    row = [_number(field) for field in fields]
    if None not in row:
        return cast("list[float]", row)
    wrong = fields[row.index(None)].strip()
    advice = ""
    if separator != "," and _has_decimal_comma(wrong):
        advice = ", with a point before the decimals"
    # The letters were read as Latin-1, and are probably UTF-8.
    text = wrong.encode("latin-1").decode("utf-8", "backslashreplace")
    raise HeightFormatError(f"got {quoted(text)}, allowed: {_NUMBERS}{advice}", place)


def _refuse_decimal_commas(line: str, fields: list[str], place: int) -> None:
    """Refuse a line of numbers by comma whose commas also or only stand before decimals."""
    parts = line.split()
    if len(parts) > 1 and not line.endswith(","):
        begins_with_comma = any(part.startswith(",") for part in parts)
        is_decimal = all(_has_decimal_comma(part) or _WHOLE.fullmatch(part) for part in parts)
        if is_decimal and not begins_with_comma:
            wrong = next((part for part in parts if "," in part), line)
            words = f"got {quoted(wrong)}, allowed: {_NUMBERS}, with a point before the decimals"
            raise HeightFormatError(words, place)
    for field in fields:
        if _DECIMALS.fullmatch(field):
            got = quoted(f"...,{field.strip()}")
            raise HeightFormatError(
                f"got {got}, allowed: {_NUMBERS}; a comma is either before decimals or between"
                " numbers: write points or semicolons",
                place,
            )


def _has_decimal_comma(field: str) -> bool:
    """Tell whether a field is a number with a comma before its decimals."""
    return len(field) > 1 and _DECIMAL_COMMA.fullmatch(field) is not None


class _Commas:
    """Whole numbers between commas, which may be numbers with a comma before their decimals.

    Then every second field holds digits alone, equally many everywhere, while the fields before
    have signs or other numbers of digits. The fields of an honest table are all of one kind.
    """

    def __init__(self) -> None:
        self._are_whole = True
        self._digits = 0  # of every second field
        self._before = 0  # fields before such a field
        self._others = 0  # of them, with a sign or another number of digits

    def add(self, line: str) -> None:
        """Count the fields of a line, unless the lines before have ruled the doubt out."""
        if not self._are_whole:
            return
        fields = [field.strip() for field in line.removesuffix(",").split(",")]
        before = fields[::2]
        behind = fields[1::2]
        if not self._digits and behind:
            self._digits = len(behind[0])
        self._are_whole = (
            len(before) == len(behind)
            and all(_WHOLE.fullmatch(field) for field in before)
            and all(field.isdecimal() and len(field) == self._digits for field in behind)
        )
        self._before += len(before)
        for field in before:
            if not field.isdecimal() or len(field) != self._digits:
                self._others += 1

    @property
    def is_possible(self) -> bool:
        """Whether the commas may stand before decimals as well."""
        return self._are_whole and self._before > 0

    @property
    def is_refused(self) -> bool:
        """Whether they do: the fields before are of another kind, and not by chance."""
        many = self._others >= _MIN_OTHERS or self._others >= max(2, _MIN_SHARE * self._before)
        return self.is_possible and many

    @property
    def words(self) -> str:
        """The refusal or the doubt."""
        digits = "one digit" if self._digits == 1 else f"{self._digits} digits"
        advice = "write points before decimals, or semicolons between numbers"
        if self.is_refused:
            return (
                f"every second number has {digits} and no sign, unlike the numbers between: the"
                f" comma stands before decimals and between numbers; {advice}"
            )
        return (
            f"every second number is a whole one of {digits}, and all others are whole: if the"
            " comma stands before decimals as well,"
            f" the file has twice the columns of the measurement; {advice}"
        )


def _refuse_places(table: Array) -> None:
    """Refuse a table of places: triples x, y, z on a grid, or a profile with its places.

    Places may stand in columns, or in rows.
    """
    for lines, name in ((table, "column"), (table.T, "row")):
        count, width = lines.shape
        if count < _MIN_LINES or width > 3:
            continue
        if width == 3 and count >= _MIN_POINTS and _has_grid(lines):
            raise HeightFormatError(
                f"got three {name}s of which two are the places of a grid, allowed: a matrix of"
                " heights; write the triples as x, y, z on each line, and give the file the ending"
                " .xyz"
            )
        if width == 2 and _equal_step(lines[:, 0]) and not _equal_step(lines[:, 1]):
            raise HeightFormatError(
                f"got two {name}s of which the first rises in equal steps, as the places of a"
                " profile do, allowed: the heights alone, one on each line"
            )


def _has_grid(lines: Array) -> bool:
    """Tell whether two of three columns are the places of a grid."""
    return any(_is_grid(lines[:, i], lines[:, j]) for i, j in ((0, 1), (0, 2), (1, 2)))


def _is_grid(x: Array, y: Array) -> bool:
    """Tell whether pairs of numbers are the places of a grid, each place once."""
    if np.isnan(x).any() or np.isnan(y).any():
        return False
    x_axis = np.unique(x)
    y_axis = np.unique(y)
    is_full = len(x) <= len(x_axis) * len(y_axis) <= _SPARSE * len(x)
    is_line = min(len(x_axis), len(y_axis)) == 1
    is_diagonal = not is_line and max(len(x_axis), len(y_axis)) == len(x)
    if not is_full or is_diagonal:
        return False
    if not _is_regular(x_axis) or not _is_regular(y_axis):
        return False
    return len(np.unique(np.column_stack([x, y]), axis=0)) == len(x)


def _is_regular(axis: Array) -> bool:
    """Tell whether sorted places lie on nodes of equal distances, of which some may be missing."""
    if len(axis) == 1:
        return True
    steps = np.diff(axis) / np.median(np.diff(axis))
    off = np.abs(steps - np.rint(steps))
    return bool(off.max() <= _EQUAL * steps.max() and steps.sum() <= _SPARSE * len(axis))


def _equal_step(places: Array) -> float:
    """Return the step of numbers that rise or fall in equal steps, else 0.

    Two places have a step. Rounded places may differ from equal steps.
    """
    if len(places) < 2 or np.isnan(places).any():
        return 0.0
    step = float(places[-1] - places[0]) / (len(places) - 1)
    off = np.abs(places - (places[0] + step * np.arange(len(places))))
    return step if off.max() <= _EQUAL * abs(step) else 0.0


def _number(field: str) -> float | None:
    """Return the number in a field, nan for an unmeasured point; None for any other text."""
    try:
        value = float(field)
    except ValueError:
        return None
    return None if math.isinf(value) or "_" in field else value


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
