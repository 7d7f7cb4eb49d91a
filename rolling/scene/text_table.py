"""A table of numbers in a text file: the file is looked at first, and then read by numpy.

The look decides what separates numbers, what stands before decimals, which lines are no numbers,
and which words mark points without a height. The numbers are read in blocks by numpy. A block that
numpy refuses is read line by line, so that a message names the line.
"""

import io
import itertools
import re
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from rolling.scene.height_format import MAX_BYTES, HeightFormatError
from rolling.scene.messages import quoted
from rolling.scene.text_words import is_missing
from rolling.terminal.whole_files import open_regular

MAX_LINE = 20_000_000  # letters
_HEAD = 200_000  # letters that are looked at first, and at least _HEAD_LINES whole lines
_HEAD_LINES = 12
_LOOKED_AT = 400  # lines of the head that are tried
_BLOCK = 4_000_000  # letters that numpy reads at once
_NUMBERS = "numbers by comma, semicolon, tab or whitespace"
_COMMENTS = ("#", "%", "//")
_BAR = "#"  # a line of this sign alone ends the heading of some instruments
_POINTS = 3  # numbers of a line of points
_BINARY = {
    b"\x1f\x8b": "a file that is packed by gzip: unpack it",
    b"PK\x03\x04": "a packed archive or a workbook: unpack it, or save the sheet as CSV",
    b"BZh": "a file that is packed by bzip2: unpack it",
    b"\xfd7zXZ": "a file that is packed by xz: unpack it",
    b"\xd0\xcf\x11\xe0": "an old Excel workbook: save the sheet as CSV",
    b"\x89HDF": "a file in HDF5: give it the ending of its instrument",
    b"\x89PNG": "a picture: export the heights as numbers",
    b"\xff\xd8\xff": "a picture: export the heights as numbers",
    b"%PDF": "a PDF: export the heights as numbers",
    b"\x93NUMPY": "an array of numpy: give it the ending .npy",
}
# Minus signs of typography, the wide signs of Japanese, and narrow blanks between thousands.
_SIGNS = str.maketrans(
    {"\u2212": "-", "\u2013": "-", "\uff0d": "-", "\uff0b": "+", "\u2009": "", "\u202f": ""}
)
_POINT = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?")
_COMMA = re.compile(r"[+-]?(?:[1-9]\d{0,2}(?:\.\d{3})+|\d*),\d+(?:[eEdD][+-]?\d+)?")
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(?:\.\d{3})+")  # points between thousands
_WHOLE = re.compile(r"[+-]?\d+")
# A point that stands before no three digits, or behind a number that begins with 0.
_NO_GROUP = re.compile(r"\.(?!\d{3}(?!\d))|(?<!\d)0\.")
_QUOTED_COMMA = re.compile(r'"[+-]?\d*,\d+"')
_TWO_WORDS = re.compile(r"no data|not measured|nicht gemessen|out of range", re.IGNORECASE)
# No whole number begins with 0, so such a field between commas is the decimals of the one before.
_DECIMALS = re.compile(r"\s*-?0\d+\s*")
_DECIMALS_IN_LINE = re.compile(r"(?:^|,)[ \t]*-?0\d+[ \t]*(?:,|$)", re.MULTILINE)
_MIN_OTHERS = 8  # whole numbers that no digits behind a comma can be, as many are no chance
_MIN_SHARE = 0.5  # of the numbers before commas; so many are no chance in a small file either


class Signs(NamedTuple):
    """What separates the numbers of a line, None for whitespace; and what precedes decimals."""

    separator: str | None
    decimal: str
    has_labels: bool = False  # whether a word stands before the numbers of each line

    @property
    def words(self) -> str:
        """The separator and the decimal sign in words."""
        names = {None: "whitespace", ";": "semicolon", "\t": "tab", ",": "comma"}
        text = f"numbers by {names[self.separator]}"
        return f"{text} with decimal commas" if self.decimal == "," else text


_CANDIDATES = (
    Signs(";", "."),
    Signs("\t", "."),
    Signs(",", "."),
    Signs(None, "."),
    Signs(";", ","),
    Signs("\t", ","),
    Signs(None, ","),
)


@dataclass(frozen=True)
class Look:
    """What the beginning of a file says about the rest.

    Attributes
    ----------
    signs : Signs. Separator and decimal sign.
    width : int. Numbers of a line.
    first : int. Line of the first numbers.
    header : sequence of (int, str). The other lines, with their numbers in the file.
    heading : str. The line directly above the numbers; empty where there is none.
    ends_with_separator : bool. Whether each line ends with a separator that adds no number.
    has_quoted_commas : bool. Whether numbers with decimal commas stand in quotes between commas.
    """

    signs: Signs
    width: int
    first: int
    header: tuple[tuple[int, str], ...]
    heading: str
    ends_with_separator: bool
    has_quoted_commas: bool


@dataclass(frozen=True, eq=False)
class TextTable:
    """Numbers of a text file as they stand there, and what was found out about them.

    Attributes
    ----------
    numbers : (rows, width) array. NaN where a cell is empty or marked.
    look : Look. What the file says about itself.
    commas : Commas. What its commas may be.
    footer : int or None. The line at which the numbers end, if text follows.
    """

    numbers: Array
    look: Look
    commas: "Commas"
    footer: int | None = None


def read_table(path: Path) -> TextTable:
    """Read the table of numbers in a text file.

    Raises
    ------
    HeightFormatError
        The file is missing, too large, no text, or some line is no row of the table.
    """
    if path.stat().st_size > MAX_BYTES:
        raise HeightFormatError(
            f"is larger than {MAX_BYTES:,} bytes of text; a .npy file may be larger"
        )
    encoding = _encoding(path)
    head, is_whole = _head(path, encoding)
    look = _look(head, is_whole)
    return _body(path, encoding, look)


# ---- letters


def _encoding(path: Path) -> str:
    """Return the encoding of a text; refuse bytes that are none."""
    with io.BufferedReader(open_regular(path)) as file:
        begin = file.read(_HEAD)
    for magic, words in _BINARY.items():
        if begin.startswith(magic):
            raise HeightFormatError(f"is no text but {words}")
    if begin.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    if begin.startswith(b"\xef\xbb\xbf"):
        return "utf-8-sig"
    zeros = begin.count(0)
    if zeros > len(begin) // 3:
        # Every second byte of ASCII in UTF-16 is zero; the first one tells the order.
        even = begin[::2].count(0)
        if even == 0:
            return "utf-16-le"
        if zeros == even:
            return "utf-16-be"
    controls = sum(begin.count(byte) for byte in range(32) if byte not in b"\t\n\r\f\x1a\x03")
    if controls > len(begin) // 100 + 2:
        raise HeightFormatError(
            "is no text; give a file of an instrument its own ending, or export the heights as text"
        )
    for encoding in ("utf-8", "cp932"):
        try:
            # The last letter may be cut.
            begin[: begin.rfind(b"\n") + 1].decode(encoding)
        except UnicodeDecodeError:
            continue
        if encoding == "utf-8" or _is_japanese(begin):
            return encoding
    return "latin-1"


def _is_japanese(begin: bytes) -> bool:
    """Tell whether bytes are probably in the code of Japanese Windows: several kana or kanji."""
    text = begin[: begin.rfind(b"\n") + 1].decode("cp932", "ignore")
    return len(re.findall("[ぁ-んァ-ヶ一-龠]{2,}", text)) >= 2


def _opened(path: Path, encoding: str) -> io.TextIOWrapper:
    """Open a text with line ends of any system."""
    file = io.BufferedReader(open_regular(path))
    return io.TextIOWrapper(file, encoding=encoding, errors="backslashreplace")


def _head(path: Path, encoding: str) -> tuple[list[str], bool]:
    """Return the first whole lines of a text, and whether they are all."""
    lines: list[str] = []
    letters = 0
    with _opened(path, encoding) as stream:
        for number in itertools.count(1):
            line = stream.readline(MAX_LINE)
            if not line:
                return lines, True
            if len(line) >= MAX_LINE:
                raise HeightFormatError(f"a line of more than {MAX_LINE:,} letters", number)
            lines.append(line)
            letters += len(line)
            if letters > _HEAD and number >= _HEAD_LINES:
                return lines, False
    raise AssertionError("unreachable")


def _is_comment(line: str) -> bool:
    """Tell whether a line is a comment."""
    return line.startswith(_COMMENTS)


# ---- look


class _RowsOfOneWidth(NamedTuple):
    """Lines one behind the other with equally many numbers."""

    first: int  # place in the list of lines
    last: int
    rows: int
    width: int

    @property
    def size(self) -> int:
        """How many numbers they have."""
        return self.rows * self.width


def _look(head: Sequence[str], is_whole: bool) -> Look:
    """Find out separator, decimal sign, and the first line of the numbers."""
    has_quoted_commas = any(_QUOTED_COMMA.search(line) for line in head[:_LOOKED_AT])
    lines = [_cleaned(line, has_quoted_commas) for line in head]
    signs, run, widths = _best(lines)
    if run is None or signs is None:
        raise _no_numbers(lines)
    first = _first_row(lines, widths, run)
    header = [
        (number, head[number - 1].strip().strip("\ufeff"))
        for number in range(1, len(lines) + 1)
        if lines[number - 1] and (number <= first or _is_comment(lines[number - 1]))
    ]
    _refuse_cut_rows(lines, widths, first, run.width, signs)
    heading = ""
    if header and header[-1][0] <= first:
        heading = next((text for number, text in reversed(header) if number <= first), "")
    separator = signs.separator
    ends = False
    if separator is not None:
        rows = [lines[k] for k in range(first, run.last + 1) if widths[k]]
        ends = all(row.endswith(separator) for row in rows) and run.width >= 1
    return Look(
        signs=signs,
        width=run.width,
        first=first + 1,
        header=tuple(header),
        heading=heading,
        ends_with_separator=ends,
        has_quoted_commas=has_quoted_commas,
    )


def _cleaned(line: str, has_quoted_commas: bool) -> str:
    """Return a line with plain signs, and without quotes and blanks at its ends."""
    text = _plain(line.removeprefix("\ufeff"), has_quoted_commas)
    return text.strip(" \r\n\f\x1a")


def _plain(text: str, has_quoted_commas: bool) -> str:
    """Return a text with plain minus signs, and without quotes and narrow blanks."""
    if not text.isascii():
        text = text.translate(_SIGNS)
    if '"' in text:
        if has_quoted_commas:
            text = text.replace('","', '";"')
        text = text.replace('"', "")
    return text


def _best(lines: Sequence[str]) -> tuple[Signs | None, _RowsOfOneWidth | None, list[int]]:
    """Return the signs by which most numbers stand in lines one behind the other."""
    best: tuple[Signs | None, _RowsOfOneWidth | None, list[int]] = (None, None, [])
    tried = lines
    if len(lines) > _LOOKED_AT:
        tried = lines[:_LOOKED_AT]
    for has_labels in (False, True):
        for candidate in _CANDIDATES:
            signs = candidate._replace(has_labels=has_labels)
            widths = [_width(line, signs) for line in tried]
            run = _longest(tried, widths)
            if run is not None and (best[1] is None or run.size > best[1].size):
                best = signs, run, widths
        if best[1] is not None:
            break
    if best[0] == Signs(",", ".") and best[1] is not None and best[1].width == 2:
        best = _with_decimal_commas(tried, best[2]) or best
    return best


def _with_decimal_commas(
    lines: Sequence[str], widths: Sequence[int]
) -> tuple[Signs, _RowsOfOneWidth, list[int]] | None:
    """Read lines with one comma each as one column, if the comma stands before decimals for sure.

    Else None: two columns of whole numbers look the same.
    """
    commas = Commas()
    has_zeros = False
    for line, width in zip(lines, widths, strict=True):
        if width:
            commas.add(line)
            has_zeros = has_zeros or _DECIMALS_IN_LINE.search(line) is not None
    if not commas.is_possible or not (commas.is_refused or has_zeros):
        return None
    signs = Signs(";", ",")
    own = [_width(line, signs) for line in lines]
    run = _longest(lines, own)
    return None if run is None else (signs, run, own)


def _longest(lines: Sequence[str], widths: Sequence[int]) -> _RowsOfOneWidth | None:
    """Return the longest run of rows; empty lines and comments do not end one."""
    runs: list[_RowsOfOneWidth] = []
    run: _RowsOfOneWidth | None = None
    for k, width in enumerate(widths):
        if width and run is not None and width == run.width:
            run = run._replace(last=k, rows=run.rows + 1)
            runs[-1] = run
        elif width:
            run = _RowsOfOneWidth(first=k, last=k, rows=1, width=width)
            runs.append(run)
        elif lines[k] == _BAR or (lines[k] and not _is_comment(lines[k])):
            run = None
    return max(runs, key=lambda run: run.size, default=None)


def _width(line: str, signs: Signs) -> int:
    """Return how many numbers a line has; 0 for a line that is no row of numbers."""
    if not line or _is_comment(line):
        return 0
    cells = cells_of(line, signs.separator)
    if signs.separator is not None and not cells[-1].strip():
        cells = cells[:-1]
    if signs.has_labels:
        if not cells or _value(cells[0], signs) is not None:
            return 0
        cells = cells[1:]
    values = [_value(cell, signs) for cell in cells]
    if None in values or not any(value == value for value in values):
        return 0
    return len(values)


def cells_of(line: str, separator: str | None) -> list[str]:
    """Split a line; two words that mark a point without a height stay together."""
    if separator is None and _TWO_WORDS.search(line):
        line = _TWO_WORDS.sub("nan", line)
    return line.split(separator)


def _value(cell: str, signs: Signs) -> float | None:
    """Return the number in a cell, NaN for an empty or a marked one, None for any other text."""
    text = cell.strip().replace("\xa0", "")
    if not text or is_missing(text) or _TWO_WORDS.fullmatch(text):
        return float("nan")
    if signs.decimal == "," and ("," in text or "." in text):
        is_number = _COMMA.fullmatch(text) or _GROUPED.fullmatch(text)
        return _finite(text.replace(".", "").replace(",", ".")) if is_number else None
    return _finite(text) if _POINT.fullmatch(text) else None


def _finite(text: str) -> float | None:
    """Return the number of a text, None beyond all numbers."""
    value = float(text.replace("d", "e").replace("D", "e"))
    return None if value in (float("inf"), float("-inf")) else value


def _first_row(lines: Sequence[str], widths: Sequence[int], run: _RowsOfOneWidth) -> int:
    """Return the place of the first row: of the run, or of an earlier row of the same table.

    Rows before a faulty line belong to the table, so that the fault is named. A heading may hold
    a line with as few numbers as a table of points has.
    """
    first = run.first
    for k in range(run.first - 1, -1, -1):
        if lines[k] == _BAR:
            break
        if widths[k] != run.width:
            continue
        is_second = k > 0 and widths[k - 1] == run.width
        is_next = all(not line or _has_number(line) for line in lines[k + 1 : first])
        if run.width > _POINTS or is_second or is_next:
            first = k
    return first


def _has_number(line: str) -> bool:
    """Tell whether a number stands in a line."""
    return re.search(r"(?<![^\W\d])\d", line) is not None


def _refuse_cut_rows(
    lines: Sequence[str], widths: Sequence[int], first: int, width: int, signs: Signs
) -> None:
    """Refuse rows of other lengths directly above the table, with no word between."""
    for k in range(first - 1, -1, -1):
        if lines[k] == _BAR:
            return
        if not lines[k] or _is_comment(lines[k]):
            continue
        _refuse_faulty_row(lines[k], width, signs, k + 1)
        is_heading = widths[k] in (width - 1, width + 1) and k == first - 1
        if not widths[k] or is_heading:
            return
        has_words = any(lines[j] and not widths[j] for j in range(k))
        if has_words and width > _POINTS and widths[k] <= _POINTS:
            return
        raise HeightFormatError(
            f"got {widths[k]} {signs.words}, allowed: {width}, as on the lines behind; put # before"
            " a line that is no row",
            k + 1,
        )


def _refuse_faulty_row(line: str, width: int, signs: Signs, place: int) -> None:
    """Refuse a line above the table that would be its first row but for some of its cells.

    The first cell of a heading may be a word without digits beside the places of the columns.
    """
    cells = cells_of(line, signs.separator)
    if len(cells) != width or width <= _POINTS:
        return
    wrong = [cell.strip() for cell in cells if _value(cell, signs) is None]
    if wrong and wrong[0] == cells[0].strip() and not _has_number(wrong[0]):
        del wrong[0]
    if 0 < len(wrong) < width / 2:
        raise HeightFormatError(f"got {quoted(wrong[0])}, allowed: {_NUMBERS}", place)


def _no_numbers(lines: Sequence[str]) -> HeightFormatError:
    """Name the line that is nearest to a row of numbers in a file that has none."""
    held = [(k, line) for k, line in enumerate(lines, 1) if line and not _is_comment(line)]
    if not held:
        return HeightFormatError(f"holds no heights, allowed: {_NUMBERS}")
    place, line = max(held, key=lambda numbered: len(re.findall(r"\d", numbered[1])))
    for cell in line.replace(";", " ").replace("\t", " ").split():
        if not _POINT.fullmatch(cell) and not _COMMA.fullmatch(cell) and not is_missing(cell):
            words = f"got {quoted(cell)}, allowed: {_NUMBERS}"
            return HeightFormatError(f"{words}; no line is a row of numbers", place)
    return HeightFormatError(f"got {quoted(line)}, allowed: {_NUMBERS}", place)


# ---- numbers


def _body(path: Path, encoding: str, look: Look) -> TextTable:
    """Read all rows from the first one on."""
    parts = []
    commas = Commas()
    footer = None
    with _opened(path, encoding) as stream:
        for _ in range(look.first - 1):
            stream.readline()
        place = look.first
        while text := _block(stream, place):
            part = _fast(text, look, commas)
            if part is None:
                part, footer = _slow(text, look, commas, place)
            parts.append(part)
            place += text.count("\n")
            if footer is not None:
                _refuse_second_table(itertools.chain(text.splitlines()[footer - place :], stream))
                break
    numbers = _joined(parts, look.width)
    return TextTable(numbers=numbers, look=look, commas=commas, footer=footer)


def _block(stream: io.TextIOWrapper, place: int) -> str:
    """Return the next letters up to the end of a line; raise for a line that is too long."""
    text = stream.read(_BLOCK)
    if text and not text.endswith("\n"):
        text += stream.readline(MAX_LINE)
    longest = 0
    if len(text) > MAX_LINE or len(text) - text.rfind("\n", 0, -1) > MAX_LINE:
        longest = max(map(len, text.split("\n")))
    if longest >= MAX_LINE:
        raise HeightFormatError(f"a line of more than {MAX_LINE:,} letters", place)
    return text


def _joined(parts: list[Array], width: int) -> Array:
    """Put blocks of rows into one array, and let each block go as it is copied."""
    rows = sum(len(part) for part in parts)
    if not rows:
        raise HeightFormatError(f"holds no heights, allowed: {_NUMBERS}")
    if len(parts) == 1:
        return parts[0]
    numbers = np.empty((rows, width))
    begin = 0
    for k, part in enumerate(parts):
        numbers[begin : begin + len(part)] = part
        begin += len(part)
        parts[k] = part[:0].copy()
    return numbers


def _fast(text: str, look: Look, commas: "Commas") -> Array | None:
    """Read a block by numpy; None where it has to be read line by line."""
    signs = look.signs
    separator = signs.separator
    text = _plain(text, look.has_quoted_commas)
    if any(sign in text for sign in _COMMENTS):
        text = "\n".join(line for line in text.split("\n") if not _is_comment(line.strip()))
    if separator is None and _TWO_WORDS.search(text):
        text = _TWO_WORDS.sub("nan", text)
    if separator == ",":
        # Numbers with a point each have no decimals behind a comma.
        is_plain = text.count(".") > text.count(",")
        if not is_plain and _DECIMALS_IN_LINE.search(text):
            return None
        commas.add_lines(text)
    if signs.decimal == ",":
        if "." in text:
            if _NO_GROUP.search(text):
                return None
            text = text.replace(".", "")
        text = text.replace(",", ".")
    if separator is not None:
        text = _with_words_for_empty_cells(text, separator, look.ends_with_separator)
    columns = range(1, look.width + 1) if signs.has_labels else None
    try:
        part = np.loadtxt(
            text.split("\n"),
            dtype=float,
            comments=None,
            delimiter=separator,
            ndmin=2,
            usecols=columns,
        )
    except (ValueError, OverflowError):
        return None
    if part.shape[1] != look.width or np.isinf(part).any():
        return None
    return np.asarray(part)


def _with_words_for_empty_cells(text: str, separator: str, ends_with_separator: bool) -> str:
    """Write nan into empty cells, or drop a separator at the end of all lines."""
    if ends_with_separator:
        text = text.replace(f"{separator}\n", "\n").removesuffix(separator)
    two = 2 * separator
    if two in text:
        filled = f"{separator}nan{separator}"
        text = text.replace(two, filled).replace(two, filled)
    if f"\n{separator}" in text:
        text = text.replace(f"\n{separator}", f"\nnan{separator}")
    if text.startswith(separator):
        text = f"nan{text}"
    if f"{separator}\n" in text:
        text = text.replace(f"{separator}\n", f"{separator}nan\n")
    if text.endswith(separator):
        text = f"{text}nan"
    return text


def _slow(text: str, look: Look, commas: "Commas", place: int) -> tuple[Array, int | None]:
    """Read a block line by line; raise HeightFormatError for the first line that is no row.

    The second value is the line at which the table ends, if text follows behind an empty line.
    """
    values = array("d")
    rows = 0
    is_behind_gap = False
    footer = None
    for number, raw in enumerate(text.split("\n"), place):
        line = _cleaned(raw, look.has_quoted_commas)
        if not line or _is_comment(line):
            is_behind_gap = is_behind_gap or not line
            continue
        if is_behind_gap and not _width(line, look.signs):
            footer = number
            break
        is_behind_gap = False
        row = _row(line, look, number)
        if look.signs.separator == ",":
            commas.add(line)
        values.extend(row)
        rows += 1
    return np.frombuffer(values, dtype=float).reshape(rows, look.width), footer


def _row(line: str, look: Look, place: int) -> list[float]:
    """Return the numbers of a line; raise HeightFormatError for the first that is no number."""
    signs = look.signs
    cells = cells_of(line, signs.separator)
    if signs.separator == ",":
        _refuse_decimals(line, cells, place)
    if signs.has_labels:
        cells = cells[1:]
    is_longer = look.ends_with_separator or len(cells) == look.width + 1
    if signs.separator is not None and is_longer and not cells[-1].strip():
        cells.pop()
    row = [_value(cell, signs) for cell in cells]
    if None in row:
        wrong = cells[row.index(None)].strip()
        advice = ""
        if signs.decimal == "." and "," in wrong and _COMMA.fullmatch(wrong):
            advice = ", with a point before the decimals as on the other lines"
        raise HeightFormatError(f"got {quoted(wrong)}, allowed: {_NUMBERS}{advice}", place)
    if len(row) != look.width:
        words = f"got {len(row)} numbers, allowed: {look.width}, as on the lines before"
        raise HeightFormatError(words, place)
    return [value for value in row if value is not None]


def _refuse_decimals(line: str, cells: Sequence[str], place: int) -> None:
    """Refuse a line of numbers by comma whose commas also stand before decimals."""
    parts = line.split()
    if len(parts) > 1 and not line.endswith(","):
        begins_with_comma = any(part.startswith(",") for part in parts)
        is_decimal = all(_COMMA.fullmatch(part) or _WHOLE.fullmatch(part) for part in parts)
        if is_decimal and not begins_with_comma:
            wrong = next((part for part in parts if "," in part), line)
            words = f"got {quoted(wrong)}, allowed: {_NUMBERS}, with a point before the decimals"
            raise HeightFormatError(words, place)
    for cell in cells:
        if _DECIMALS.fullmatch(cell):
            got = quoted(f"...,{cell.strip()}")
            raise HeightFormatError(
                f"got {got}, allowed: {_NUMBERS}; a comma is either before decimals or between"
                " numbers: write points or semicolons",
                place,
            )


def _refuse_second_table(lines: Iterator[str]) -> None:
    """Refuse rows of numbers behind the text that ends the table."""
    for line in lines:
        if len(line.split()) > 3 and all(_POINT.fullmatch(word) for word in line.split()):
            raise HeightFormatError(
                "holds several tables, allowed: one; export the heights alone",
            )


@dataclass
class Commas:
    """Whole numbers between commas, which may be numbers with a comma before their decimals.

    Then every second cell holds digits alone, equally many everywhere, while the cells before
    have signs or other numbers of digits. The cells of an honest table are all of one kind.
    """

    _are_whole: bool = field(default=True)
    _digits: int = field(default=0)  # of every second cell
    _before: int = field(default=0)  # cells before such a cell
    _others: int = field(default=0)  # of them, with a sign or another number of digits

    def add_lines(self, text: str) -> None:
        """Count the cells of lines, until one of them has ruled the doubt out."""
        begin = 0
        while self._are_whole and begin < len(text):
            end = text.find("\n", begin)
            end = len(text) if end < 0 else end
            if line := text[begin:end].strip():
                self.add(line)
            begin = end + 1

    def add(self, line: str) -> None:
        """Count the cells of a line, unless the lines before have ruled the doubt out."""
        if not self._are_whole:
            return
        cells = [cell.strip() for cell in line.removesuffix(",").split(",")]
        before = cells[::2]
        behind = cells[1::2]
        if not self._digits and behind:
            self._digits = len(behind[0])
        self._are_whole = (
            len(before) == len(behind)
            and all(_WHOLE.fullmatch(cell) for cell in before)
            and all(cell.isdecimal() and len(cell) == self._digits for cell in behind)
        )
        self._before += len(before)
        for cell in before:
            if not cell.isdecimal() or len(cell) != self._digits:
                self._others += 1

    @property
    def is_possible(self) -> bool:
        """Whether the commas may stand before decimals as well."""
        return self._are_whole and self._before > 0

    @property
    def is_refused(self) -> bool:
        """Whether they do: the cells before are of another kind, and not by chance."""
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
