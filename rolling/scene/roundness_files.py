"""Files of measured roundness: amplitude and phase of the waves around a ring, by their order."""

import math
import re
from pathlib import Path

from rolling.scene.height_files import reason_of
from rolling.scene.height_format import UNITS, HeightFormatError
from rolling.scene.messages import quoted
from rolling.scene.surfaces import LARGEST_UM
from rolling.terminal.whole_files import read_regular

MAX_BYTES = 2_000_000  # instruments write some 500 orders, of 40 bytes each
MAX_ORDER = 50_000
_ENDINGS = (".csv", ".txt")
_SEPARATORS = re.compile(r"[,\s]+")
_LINE = "order, amplitude and phase [degrees], as in 8, 0.05, 120"
Waves = tuple[tuple[int, float, float], ...]


def read_waves(path: Path, unit: str) -> Waves:
    """Read measured waves: order, amplitude [m] and phase [rad], by ascending order.

    The orders 0 and 1, mean radius and eccentricity, are left out. Lines that are empty or begin
    with #, and a first line of words, are passed over.

    Parameters
    ----------
    path : Path
        File of text.
    unit : str
        Unit of the amplitudes: m, mm, um or nm.

    Raises
    ------
    HeightFormatError
        The file is missing, too large or no text, or a line holds no wave; the error has its line.
    """
    waves: dict[int, tuple[float, float]] = {}
    is_first = True
    for number, line in enumerate(_text(path).splitlines(), 1):
        words = _words(line)
        if not words or words[0].startswith("#"):
            continue
        may_be_words = is_first
        is_first = False
        values = [_number(word) for word in words]
        if may_be_words and all(value is None for value in values):
            continue
        order, amplitude, phase = _wave(words, values, number)
        if order in waves:
            raise HeightFormatError(f"the order {order} stands twice", number)
        largest = LARGEST_UM * UNITS["um"] / UNITS[unit]
        if not 0 <= amplitude <= largest:
            allowed = f"an amplitude from 0 to {largest:g} {unit}"
            raise HeightFormatError(f"got {quoted(words[1])}, allowed: {allowed}", number)
        waves[order] = (amplitude * UNITS[unit], math.radians(phase))
    ordered = tuple((order, *waves[order]) for order in sorted(waves) if order > 1)
    if not ordered:
        raise HeightFormatError(f"holds no waves; allowed: a line for each order: {_LINE}")
    return ordered


def _text(path: Path) -> str:
    """Read a file of text of a bounded size."""
    if path.suffix.lower() not in _ENDINGS:
        raise HeightFormatError(
            f"got the ending {quoted(path.suffix)}, allowed: .csv or .txt with a line for each"
            f" order: {_LINE}"
        )
    try:
        return read_regular(path, MAX_BYTES).decode("utf-8-sig")
    except OSError as error:
        raise HeightFormatError(reason_of(error)) from error
    except UnicodeDecodeError as error:
        raise HeightFormatError("is no text in UTF-8") from error


def _words(line: str) -> list[str]:
    """Return the words of a line; between semicolons a comma stands before decimals."""
    if ";" in line:
        return [word.strip().replace(",", ".") for word in line.split(";") if word.strip()]
    return [word for word in _SEPARATORS.split(line.strip()) if word]


def _number(word: str) -> float | None:
    """Return a word as a finite number, None where it is none."""
    try:
        value = float(word)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _wave(words: list[str], values: list[float | None], line: int) -> tuple[int, float, float]:
    """Return order, amplitude and phase of a line."""
    if len(values) == 3:
        order, amplitude, phase = values
        if order is not None and amplitude is not None and phase is not None:
            if order != int(order) or not 0 <= order <= MAX_ORDER:
                allowed = f"a whole order from 0 to {MAX_ORDER}"
                raise HeightFormatError(f"got {quoted(words[0])}, allowed: {allowed}", line)
            return int(order), amplitude, phase
    raise HeightFormatError(f"got {quoted(' '.join(words))}, allowed: {_LINE}", line)
