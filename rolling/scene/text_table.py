"""A table of numbers in a text file: `text_look` looks at it first, and numpy reads it then.

The numbers are read in blocks by numpy. A block that numpy refuses is read line by line, so that a
message names the line.
"""

import io
import itertools
import re
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from acoustics.arrays import Array
from rolling.scene.height_format import MAX_BYTES, HeightFormatError
from rolling.scene.messages import quoted
from rolling.scene.text_look import (
    COMMA,
    COMMENTS,
    DECIMALS_IN_LINE,
    NUMBERS,
    POINT,
    TWO_WORDS,
    WHOLE,
    Commas,
    Look,
    cells_of,
    cleaned,
    is_comment,
    look_at,
    plain,
    value_in,
    width_of,
)
from rolling.terminal.whole_files import open_regular

MAX_LINE = 20_000_000  # letters
_HEAD = 200_000  # letters that are looked at first, and at least _HEAD_LINES whole lines
_HEAD_LINES = 12
_BLOCK = 4_000_000  # letters that numpy reads at once
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
# A point that stands before no three digits, or behind a number that begins with 0.
_NO_GROUP = re.compile(r"\.(?!\d{3}(?!\d))|(?<!\d)0\.")
# No whole number begins with 0, so such a field between commas is the decimals of the one before.
_DECIMALS = re.compile(r"\s*-?0\d+\s*")


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
    commas: Commas
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
    look = look_at(_head(path, encoding))
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


def _head(path: Path, encoding: str) -> list[str]:
    """Return the first whole lines of a text."""
    lines: list[str] = []
    letters = 0
    with _opened(path, encoding) as stream:
        for number in itertools.count(1):
            line = stream.readline(MAX_LINE)
            if not line:
                return lines
            if len(line) >= MAX_LINE:
                raise HeightFormatError(f"a line of more than {MAX_LINE:,} letters", number)
            lines.append(line)
            letters += len(line)
            if letters > _HEAD and number >= _HEAD_LINES:
                return lines
    raise AssertionError("unreachable")


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
        raise HeightFormatError(f"holds no heights, allowed: {NUMBERS}")
    if len(parts) == 1:
        return parts[0]
    numbers = np.empty((rows, width))
    begin = 0
    for k, part in enumerate(parts):
        numbers[begin : begin + len(part)] = part
        begin += len(part)
        parts[k] = part[:0].copy()
    return numbers


def _fast(text: str, look: Look, commas: Commas) -> Array | None:
    """Read a block by numpy; None where it has to be read line by line."""
    signs = look.signs
    separator = signs.separator
    text = plain(text, look.has_quoted_commas)
    if any(sign in text for sign in COMMENTS):
        text = "\n".join(line for line in text.split("\n") if not is_comment(line.strip()))
    if separator is None and TWO_WORDS.search(text):
        text = TWO_WORDS.sub("nan", text)
    if separator == ",":
        # Numbers with a point each have no decimals behind a comma.
        is_plain = text.count(".") > text.count(",")
        if not is_plain and DECIMALS_IN_LINE.search(text):
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


def _slow(text: str, look: Look, commas: Commas, place: int) -> tuple[Array, int | None]:
    """Read a block line by line; raise HeightFormatError for the first line that is no row.

    The second value is the line at which the table ends, if text follows behind an empty line.
    """
    values = array("d")
    rows = 0
    is_behind_gap = False
    footer = None
    for number, raw in enumerate(text.split("\n"), place):
        line = cleaned(raw, look.has_quoted_commas)
        if not line or is_comment(line):
            is_behind_gap = is_behind_gap or not line
            continue
        if is_behind_gap and not width_of(line, look.signs):
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
    row = [value_in(cell, signs) for cell in cells]
    if None in row:
        wrong = cells[row.index(None)].strip()
        advice = ""
        if signs.decimal == "." and "," in wrong and COMMA.fullmatch(wrong):
            advice = ", with a point before the decimals as on the other lines"
        raise HeightFormatError(f"got {quoted(wrong)}, allowed: {NUMBERS}{advice}", place)
    if len(row) != look.width:
        words = f"got {len(row)} numbers, allowed: {look.width}, as on the lines before"
        raise HeightFormatError(words, place)
    return [value for value in row if value is not None]


def _refuse_decimals(line: str, cells: Sequence[str], place: int) -> None:
    """Refuse a line of numbers by comma whose commas also stand before decimals."""
    parts = line.split()
    if len(parts) > 1 and not line.endswith(","):
        begins_with_comma = any(part.startswith(",") for part in parts)
        is_decimal = all(COMMA.fullmatch(part) or WHOLE.fullmatch(part) for part in parts)
        if is_decimal and not begins_with_comma:
            wrong = next((part for part in parts if "," in part), line)
            words = f"got {quoted(wrong)}, allowed: {NUMBERS}, with a point before the decimals"
            raise HeightFormatError(words, place)
    for cell in cells:
        if _DECIMALS.fullmatch(cell):
            got = quoted(f"...,{cell.strip()}")
            raise HeightFormatError(
                f"got {got}, allowed: {NUMBERS}; a comma is either before decimals or between"
                " numbers: write points or semicolons",
                place,
            )


def _refuse_second_table(lines: Iterator[str]) -> None:
    """Refuse rows of numbers behind the text that ends the table."""
    for line in lines:
        if len(line.split()) > 3 and all(POINT.fullmatch(word) for word in line.split()):
            raise HeightFormatError(
                "holds several tables, allowed: one; export the heights alone",
            )
