"""The look at the beginning of a text file: what its lines of numbers are written in.

The look decides what separates numbers, what stands before decimals, which lines are no numbers,
and which words mark points without a height.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from rolling.scene.height_format import HeightFormatError
from rolling.scene.messages import quoted
from rolling.scene.text_words import is_missing

_LOOKED_AT = 400  # lines of the head that are tried
NUMBERS = "numbers by comma, semicolon, tab or whitespace"
COMMENTS = ("#", "%", "//")
_BAR = "#"  # a line of this sign alone ends the heading of some instruments
_POINTS = 3  # numbers of a line of points
# Minus signs of typography, the wide signs of Japanese, and narrow blanks between thousands.
_SIGNS = str.maketrans(
    {"\u2212": "-", "\u2013": "-", "\uff0d": "-", "\uff0b": "+", "\u2009": "", "\u202f": ""}
)
POINT = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?")
COMMA = re.compile(r"[+-]?(?:[1-9]\d{0,2}(?:\.\d{3})+|\d*),\d+(?:[eEdD][+-]?\d+)?")
_GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}(?:\.\d{3})+")  # points between thousands
WHOLE = re.compile(r"[+-]?\d+")
_QUOTED_COMMA = re.compile(r'"[+-]?\d*,\d+"')
TWO_WORDS = re.compile(r"no data|not measured|nicht gemessen|out of range", re.IGNORECASE)
DECIMALS_IN_LINE = re.compile(r"(?:^|,)[ \t]*-?0\d+[ \t]*(?:,|$)", re.MULTILINE)
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


def is_comment(line: str) -> bool:
    """Tell whether a line is a comment."""
    return line.startswith(COMMENTS)


# ---- rows


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


def look_at(head: Sequence[str]) -> Look:
    """Return separator, decimal sign and the first line of the numbers, of the first lines."""
    has_quoted_commas = any(_QUOTED_COMMA.search(line) for line in head[:_LOOKED_AT])
    lines = [cleaned(line, has_quoted_commas) for line in head]
    signs, run, widths = _best(lines)
    if run is None or signs is None:
        raise _no_numbers(lines)
    first = _first_row(lines, widths, run)
    header = [
        (number, head[number - 1].strip().strip("\ufeff"))
        for number in range(1, len(lines) + 1)
        if lines[number - 1] and (number <= first or is_comment(lines[number - 1]))
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


def cleaned(line: str, has_quoted_commas: bool) -> str:
    """Return a line with plain signs, and without quotes and blanks at its ends."""
    text = plain(line.removeprefix("\ufeff"), has_quoted_commas)
    return text.strip(" \r\n\f\x1a")


def plain(text: str, has_quoted_commas: bool) -> str:
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
            widths = [width_of(line, signs) for line in tried]
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
            has_zeros = has_zeros or DECIMALS_IN_LINE.search(line) is not None
    if not commas.is_possible or not (commas.is_refused or has_zeros):
        return None
    signs = Signs(";", ",")
    own = [width_of(line, signs) for line in lines]
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
        elif lines[k] == _BAR or (lines[k] and not is_comment(lines[k])):
            run = None
    return max(runs, key=lambda run: run.size, default=None)


def width_of(line: str, signs: Signs) -> int:
    """Return how many numbers a line has; 0 for a line that is no row of numbers."""
    if not line or is_comment(line):
        return 0
    cells = cells_of(line, signs.separator)
    if signs.separator is not None and not cells[-1].strip():
        cells = cells[:-1]
    if signs.has_labels:
        if not cells or value_in(cells[0], signs) is not None:
            return 0
        cells = cells[1:]
    values = [value_in(cell, signs) for cell in cells]
    if None in values or not any(value == value for value in values):
        return 0
    return len(values)


def cells_of(line: str, separator: str | None) -> list[str]:
    """Split a line; two words that mark a point without a height stay together."""
    if separator is None and TWO_WORDS.search(line):
        line = TWO_WORDS.sub("nan", line)
    return line.split(separator)


def value_in(cell: str, signs: Signs) -> float | None:
    """Return the number in a cell, NaN for an empty or a marked one, None for any other text."""
    text = cell.strip().replace("\xa0", "")
    if not text or is_missing(text) or TWO_WORDS.fullmatch(text):
        return float("nan")
    if signs.decimal == "," and ("," in text or "." in text):
        is_number = COMMA.fullmatch(text) or _GROUPED.fullmatch(text)
        return _finite(text.replace(".", "").replace(",", ".")) if is_number else None
    return _finite(text) if POINT.fullmatch(text) else None


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
        if not lines[k] or is_comment(lines[k]):
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
    wrong = [cell.strip() for cell in cells if value_in(cell, signs) is None]
    if wrong and wrong[0] == cells[0].strip() and not _has_number(wrong[0]):
        del wrong[0]
    if 0 < len(wrong) < width / 2:
        raise HeightFormatError(f"got {quoted(wrong[0])}, allowed: {NUMBERS}", place)


def _no_numbers(lines: Sequence[str]) -> HeightFormatError:
    """Name the line that is nearest to a row of numbers in a file that has none."""
    held = [(k, line) for k, line in enumerate(lines, 1) if line and not is_comment(line)]
    if not held:
        return HeightFormatError(f"holds no heights, allowed: {NUMBERS}")
    place, line = max(held, key=lambda numbered: len(re.findall(r"\d", numbered[1])))
    for cell in line.replace(";", " ").replace("\t", " ").split():
        if not POINT.fullmatch(cell) and not COMMA.fullmatch(cell) and not is_missing(cell):
            words = f"got {quoted(cell)}, allowed: {NUMBERS}"
            return HeightFormatError(f"{words}; no line is a row of numbers", place)
    return HeightFormatError(f"got {quoted(line)}, allowed: {NUMBERS}", place)


# ---- commas


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
            and all(WHOLE.fullmatch(cell) for cell in before)
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
