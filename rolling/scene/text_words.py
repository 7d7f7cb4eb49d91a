"""Words that instruments write around their numbers: units, headings, and lines of metadata.

The words are English and German, and Japanese where an instrument writes them. What no rule knows
is left alone: a line that says nothing here never changes a number.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple


class Unit(NamedTuple):
    """A unit of UNITS, and the factor that brings numbers to it."""

    name: str
    factor: float = 1.0


_UNIT_WORDS = {
    "m": Unit("m"),
    "meter": Unit("m"),
    "metre": Unit("m"),
    "cm": Unit("mm", 10.0),
    "mm": Unit("mm"),
    "millimeter": Unit("mm"),
    "millimetre": Unit("mm"),
    "um": Unit("um"),
    "micron": Unit("um"),
    "mikrometer": Unit("um"),
    "micrometer": Unit("um"),
    "micrometre": Unit("um"),
    "nm": Unit("nm"),
    "nanometer": Unit("nm"),
    "nanometre": Unit("nm"),
    "pm": Unit("nm", 1e-3),
    "angstrom": Unit("nm", 0.1),
    "å": Unit("nm", 0.1),
    "inch": Unit("mm", 25.4),
    "in": Unit("mm", 25.4),
    "mil": Unit("um", 25.4),
    "uin": Unit("nm", 25.4),
}
_MISSING_WORDS = frozenset(
    {
        *("nan", "-nan", "nan(ind)", "-nan(ind)", "1.#qnan", "1.#ind", "-1.#ind"),
        *("bad", "invalid", "missing", "nodata", "void", "masked", "undefined", "undef"),
        *("na", "n/a", "#n/a", "#nv", "null", "none", "-", "--", "---"),
        *("#value!", "#wert!", "#num!", "#zahl!", "ungültig", "ungueltig", "fehlt"),
    }
)
_STARS = re.compile(r"\*+")


def unit_of(word: str) -> Unit | None:
    """Return the unit that a word names, in any of its spellings; None for any other word."""
    text = word.strip().strip("[]()<>\"'").strip()
    plain = text.replace("µ", "u").replace("μ", "u").replace("㎛", "um")
    if plain.lower() == "m" and plain != "m":
        return None
    lower = plain.lower()
    return _UNIT_WORDS.get(lower) or _UNIT_WORDS.get(lower.removesuffix("s"))


def is_missing(word: str) -> bool:
    """Tell whether a word stands for a point that was not measured."""
    text = word.strip().lower()
    return text in _MISSING_WORDS or _STARS.fullmatch(text) is not None


# ---- headings of columns


@dataclass(frozen=True)
class Heading:
    """What a column holds: "x", "y", "z", or "" for anything else; and the unit, if it is named."""

    axis: str
    unit: Unit | None = None


_AXIS_WORDS = {
    "x": (
        r"x|pos|position|places?|ort|weg|strecke|distance|abstand|lateral|laenge|length|abszisse"
    ),
    "y": r"y",
    "z": (
        r"z|heights?|hoehen?|profile?|amplitude|topography|topographie|ordinate|raw|roughness|高さ"
    ),
}
_AXES = {name: re.compile(rf"(?:{words})(?![^\W_\d])") for name, words in _AXIS_WORDS.items()}
_BRACKETED = re.compile(r"[\[(<]([^\])>]*)[\])>]")
_LAST_WORD = re.compile(r"(?:[\s_,/;:]|\bin\s)\s*([^\s_,/;:]+)\s*$")


def heading_of(cell: str) -> Heading:
    """Read the heading of a column."""
    text = _plain_key(cell)
    for name, pattern in _AXES.items():
        if pattern.match(text):
            return Heading(name, unit_in(cell))
    return Heading("", unit_in(cell))


def unit_in(text: str) -> Unit | None:
    """Return the unit that stands in brackets or behind the last blank, comma or underscore."""
    for bracket in _BRACKETED.findall(text):
        if unit := unit_of(bracket):
            return unit
    last = _LAST_WORD.search(text)
    if last is None or last[1].lower() == "in":
        return None
    return unit_of(last[1])


# ---- lines of metadata


class Named(NamedTuple):
    """A number that a line of metadata names, with its unit, if there is one."""

    value: float
    unit: Unit | None
    line: int


@dataclass
class Metadata:
    """What the lines before the numbers say.

    Attributes
    ----------
    steps, sizes : dict of Named. Spacings and lengths of the sides, by "x", "y" or "both".
    counts : dict of Named. Numbers of points by "x" and "y".
    height_unit, xy_unit : Unit or None, and the line of the former.
    missing : list of float. Numbers that mark points without a height.
    scale : Named or None. What a height of 1 is, if that is stated.
    """

    steps: dict[str, Named] = field(default_factory=dict)
    sizes: dict[str, Named] = field(default_factory=dict)
    counts: dict[str, Named] = field(default_factory=dict)
    height_unit: Unit | None = None
    height_unit_line: int = 0
    xy_unit: Unit | None = None
    missing: list[float] = field(default_factory=list)
    scale: Named | None = None


_NUMBER = re.compile(r"[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?")
# Keys of metadata, as `_plain_key` writes them.
_SPACING = re.compile(
    r"spacing|step|pitch|interval|increment|pixel ?size|point size|pixel width|cell ?size"
    r"|lateral resolution|(xy|lateral|x|y) calibration|sampling distance"
    r"|abstand|schrittweite|pixelgroesse|intervall|rasterweite|laterale aufloesung"
    r"|(xy|x|y) kalibrierung|xy ?キャリブレーション|xy較正"
    r"|^d[xy]$|^delta ?[xy]$|^[xy] ?(scale|inc|resolution|aufloesung)$"
)
_NO_SPACING = re.compile(
    r"height|hoehe|vertical|vertikal|time|zeit|date|speed|geschw|working|arbeits|number|anzahl"
    r"|filter|cut"
)
_SIZE = re.compile(
    r"^(scan |image |field |bild)?(width|breite|height|hoehe|size|groesse)$"
    r"|^[xy] ?(size|length|range|laenge|bereich)$|^(length|laenge) (in )?[xy]$"
    r"|^(traverse|evaluation|profile) length$|^(mess|taststrecken?)laenge$"
)
_COUNT_X = re.compile(
    r"^(number of |anzahl )?(x ?(pixels?|points?|size|count|punkte|dim)|columns?|cols|ncols"
    r"|spalten|pixels? (in )?x|points per line|horizontal|width|breite)$"
)
_COUNT_Y = re.compile(
    r"^(number of |anzahl )?(y ?(pixels?|points?|size|count|punkte|dim)|rows?|nrows|lines|zeilen"
    r"|pixels? (in )?y|vertical|height|hoehe)$"
)
_UNIT_Z = re.compile(
    r"^((heights?|hoehen?|z|values?|data|wert|messwert|z ?achse|z ?axis) ?)?"
    r"(units?|einheit(en)?|unité|単位)( ?(of |der |in )?(z|heights?|hoehen?|data|values?))?$"
)
_UNIT_XY = re.compile(
    r"^(xy|x|y|lateral|[xy] ?achse|[xy] ?axis) ?(units?|einheit)"
    r"|^(units?|einheit) (xy|x|y|lateral)$"
)
_HEIGHTS_IN = re.compile(r"^(heights?|hoehen?|z|z ?values?)( in)?$")
_MISSING_KEY = re.compile(
    r"no ?data|missing|invalid|undefined|bad (value|data|point|pixel)|void|fehl(wert|end)"
    r"|ungueltig|nicht ?(gemessen|messbar)"
)
_SCALE_KEY = re.compile(r"^z ?(scale|factor|faktor|calibration|kalibrierung)$")
_PLAIN = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "_": " ", "-": " "})


def _plain_key(text: str) -> str:
    """Write a key or a heading in small letters, without brackets, umlauts, strokes and quotes."""
    bare = _BRACKETED.sub(" ", text).strip().strip("\"':=.").strip().lower()
    return " ".join(bare.translate(_PLAIN).split())


def metadata(lines: Sequence[tuple[int, str]], separator: str | None) -> Metadata:
    """Read the lines before the numbers.

    Parameters
    ----------
    lines : sequence of (int, str)
        Numbers and texts of the lines.
    separator : str or None
        What separates the numbers below; None for whitespace.
    """
    result = Metadata()
    for number, line in lines:
        text = line.strip().lstrip("#%*;/!").strip()
        if text.startswith("Wyko ASCII Data File"):
            _wyko(result, lines)
            return result
        if text.startswith("Zygo XYZ Data File"):
            _zygo(result, lines)
            return result
        key, cells = _key_and_cells(text, separator)
        if key:
            _read_entry(result, key, cells, number)
    return result


def _key_and_cells(text: str, separator: str | None) -> tuple[str, list[str]]:
    """Split a line of metadata into its key and the cells behind it."""
    for sign in (separator, "=", ":", "\uff1a", "\t", ";", ","):
        if sign and sign in text.strip(sign):
            key, _, rest = text.strip(sign).partition(sign)
            if key.strip():
                between = sign if sign in ";\t," else separator
                return key, [cell.strip().strip('"') for cell in rest.split(between)]
    words = text.split()
    numbers = [i for i, word in enumerate(words) if i and _NUMBER.fullmatch(word)]
    if numbers:
        return " ".join(words[: numbers[0]]), [" ".join(words[numbers[0] :])]
    if len(words) > 1 and unit_of(words[-1]):
        return " ".join(words[:-1]), [words[-1]]
    return "", []


def _read_entry(result: Metadata, key: str, cells: list[str], line: int) -> None:
    """Take what a line of metadata says, if any rule knows it."""
    unit = unit_in(key) if _BRACKETED.search(key) else None
    name = _plain_key(key)
    value, own_unit = _value_and_unit(cells)
    unit = own_unit or unit
    if _UNIT_XY.search(name):
        result.xy_unit = result.xy_unit or unit
    elif _UNIT_Z.search(name) or (_HEIGHTS_IN.search(name) and value is None):
        if result.height_unit is None and unit is not None:
            result.height_unit = unit
            result.height_unit_line = line
    elif _MISSING_KEY.search(name):
        if value is not None:
            result.missing.append(value)
    elif value is None:
        return
    elif _SCALE_KEY.search(name):
        result.scale = Named(value, unit, line)
    elif _SPACING.search(name) and not _NO_SPACING.search(name):
        axis = _axis_in(name)
        if axis:
            result.steps.setdefault(axis, Named(value, unit, line))
            _second_value(result, cells, unit, line)
    elif unit is not None and _SIZE.search(name):
        result.sizes.setdefault(_side_in(name), Named(value, unit, line))
    elif unit is None and value == int(value) > 0:
        if _COUNT_X.search(name):
            result.counts.setdefault("x", Named(value, None, line))
        elif _COUNT_Y.search(name):
            result.counts.setdefault("y", Named(value, None, line))


def _second_value(result: Metadata, cells: list[str], unit: Unit | None, line: int) -> None:
    """Take the spacings along x and along y of one line, such as "2.0 x 1.5 um"."""
    numbers = _NUMBER.findall(" ".join(cells))
    if len(numbers) == 2 and "both" in result.steps and result.steps["both"].line == line:
        del result.steps["both"]
        for axis, text in zip("xy", numbers, strict=True):
            result.steps[axis] = Named(float(text.replace(",", ".")), unit, line)


def _value_and_unit(cells: list[str]) -> tuple[float | None, Unit | None]:
    """Return the number in the cells of a line of metadata, and the unit behind it."""
    text = " ".join(cell for cell in cells if cell)
    number = _NUMBER.search(text)
    if number is None:
        return None, unit_of(text) or unit_in(text)
    before = text[: number.start()].strip()
    if before and before not in ("=", ":", "~"):
        return None, unit_in(text)
    value = float(number[0].replace(",", "."))
    if math.isinf(value):
        return None, None
    behind = text[number.end() :].split()
    for word in behind:
        if unit := unit_of(word.removesuffix("/pixel").removesuffix("/px").removesuffix("/Pixel")):
            return value, unit
    return value, None


def _axis_in(name: str) -> str:
    """Return the axis of a spacing that a key names: "x", "y", "both", or "" for one of heights."""
    letters = re.findall(r"(?<![^\W_\d])(?:d|delta)?(xy|x|y|z)(?![^\W_\d])", name)
    if not letters:
        squeezed = re.match(r"^(x|y|z)(?:inc|scale|step|pitch|spacing)", name)
        letters = [squeezed[1]] if squeezed else ["xy"]
    if "z" in letters:
        return ""
    if len(letters) == 1 and letters[0] != "xy":
        return str(letters[0])
    return "both"


def _side_in(name: str) -> str:
    """Return the axis along which a size is measured."""
    if re.search(r"(?<![^\W_\d])y(?![^\W_\d])|height|hoehe", name):
        return "y"
    if re.search(r"(?<![^\W_\d])x(?![^\W_\d])|width|breite|length|laenge", name):
        return "x"
    return "both"


def _entries(lines: Sequence[tuple[int, str]]) -> Iterator[tuple[int, str, list[str]]]:
    """Yield number, first word and all words of lines of metadata."""
    for number, line in lines:
        words = line.split()
        if words:
            yield number, words[0], words


def _wyko(result: Metadata, lines: Sequence[tuple[int, str]]) -> None:
    """Read the header of an ASCII file of Vision: X Size lines of Y Size numbers.

    The second flag of its first line says whether heights are in nm, or in wavelengths.
    """
    in_nm = False
    wavelength = None
    for number, first, words in _entries(lines):
        value, _ = _value_and_unit(words[-1:])
        if first == "Wyko":
            in_nm = words[-2:-1] == ["1"]
        elif value is None:
            continue
        elif first == "Pixel_size":
            result.steps["both"] = Named(value, Unit("mm"), number)
        elif first == "Wavelength":
            wavelength = Named(value, Unit("nm"), number)
        elif first in ("X", "Y") and words[1:2] == ["Size"]:
            result.counts[first.lower()] = Named(value, None, number)
    result.height_unit = Unit("nm")
    result.height_unit_line = lines[0][0]
    if not in_nm:
        result.scale = wavelength
        if wavelength is None:
            result.height_unit = None


def _zygo(result: Metadata, lines: Sequence[tuple[int, str]]) -> None:
    """Read the header of an XYZ file of MetroPro: places in pixels, heights in um.

    The last but one number of the eighth line is the size of a pixel in m.
    """
    result.height_unit = Unit("um")
    result.height_unit_line = lines[0][0]
    for number, line in lines:
        words = line.split()
        value, _ = _value_and_unit(words[-2:-1])
        if number == lines[0][0] + 7 and len(words) >= 7 and value is not None:
            result.steps["both"] = Named(value, Unit("m"), number)


_WORD_WITH_UNIT = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?")


def words_with_units(text: str) -> list[str]:
    """Split a heading at blanks, each word with the unit in brackets behind it."""
    return _WORD_WITH_UNIT.findall(text)
