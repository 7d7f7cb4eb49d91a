"""The declaration of a level in the form of ISO 4871: a level L, and its uncertainty K.

The text of ISO 4871 was not at hand. Its K of a single machine is the one that is usually quoted:
1.645 times a standard deviation, so that 95 % of normally distributed values lie below L + K.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from acoustics.numbers import rounded_up
from rolling.numbers.doubt import Severity
from rolling.numbers.quantity import PART_WORDS, Quantity, spread_text
from rolling.numbers.sheet import NONE, SheetCell, SheetRow, SheetTable

COVERAGE = 1.645  # standard deviations below which 95 % of a normal distribution lie above the mean
TITLE = "Noise declaration in the form of ISO 4871, of a calculated level"
NOTICE = (
    "This level was calculated. It is no measured noise emission value, and so no declaration by "
    "ISO 4871 or ISO 11201: it has their form, for a reader who compares."
)
_DEPARTURES = (
    "Nothing was measured, so the level has no grade of accuracy of ISO 11201.",
    "The field is free and has no reflecting plane but the plate itself; there is no background "
    "noise, and no correction for background or environment was needed or made.",
    "K has neither the spread between laboratories nor that between machines of a series, which "
    "ISO 4871 asks for: both are to be added by whoever declares a product.",
)
_NO_C = "The peak level has no C-weighting."
DEVIATION = (
    "K is 1.645 times the standard uncertainty s of this calculated level, so that L + K is an "
    "upper limit at 95 %. s is that of one machine exactly as described, by the parts below; it "
    "is neither a reproducibility nor a deviation of production."
)
_SYMBOLS = {"LAE": "LpE,A"}
_LEVEL = "LpA"


def departures(level: Quantity, has_peak: bool) -> list[str]:
    """Return what a declared level lacks, and the doubts that limit it, in sentences."""
    sentences = list(_DEPARTURES)
    if has_peak:
        sentences.append(_NO_C)
    limits = [doubt.line for doubt in level.doubts if doubt.severity > Severity.TRUST]
    sentences += [f"{line[0].upper()}{line[1:]}." for line in limits]
    return sentences


def expanded_db(uncertainty_db: float) -> float:
    """Return K [dB] of the standard uncertainty of a level."""
    return COVERAGE * uncertainty_db


def declared_table(level: Quantity) -> SheetTable:
    """Return the table of a declared level in both forms, and in whole decibels.

    A level that is not to be quoted, or that there is none of, is not declared, and the table says
    why.
    """
    symbol = _SYMBOLS.get(level.measure, _LEVEL)
    meaning = f"A-weighted emission sound pressure level, {level.measure}"
    if symbol != _LEVEL:
        meaning = "A-weighted single-event emission sound pressure level (re 1 s)"
    refused = why_not_declared(level)
    if refused:
        cell = SheetCell(value=None, unit="dB", text=f"not declared: {refused}")
        rows = [SheetRow(symbol=symbol, meaning=meaning, cells=(cell,))]
    else:
        rows = list(_declared_rows(symbol, meaning, level))
    return SheetTable(title="Declared value", heads=("value",), rows=tuple(rows))


def why_not_declared(level: Quantity) -> str:
    """Say why a level has no declared value; empty for one that has."""
    judged = level.judged
    if level.value is None or judged is None:
        return level.reason
    if judged.word == Severity.DO_NOT_QUOTE.word:
        return judged.sentence
    if level.uncertainty is None:
        return "its uncertainty is not known"
    return ""


def _declared_rows(symbol: str, meaning: str, level: Quantity) -> Iterator[SheetRow]:
    """Yield the rows of a level that is declared."""
    assert level.value is not None and level.uncertainty is not None  # as the caller has asked
    expanded = expanded_db(level.uncertainty)
    value, _, _ = level.number.partition(" ")
    yield _row(symbol, meaning, level.value, value, level.uncertainty)
    yield _row("K", "its uncertainty: dual-number form L and K", expanded, spread_text(expanded))
    upper = level.value + expanded
    text = f"{math.ceil(10 * upper - 1e-9) / 10:.1f}"
    yield _row("Ld", "single-number form L + K, an upper limit", upper, text)
    whole_level = math.floor(level.value + 0.5)
    whole_k = math.ceil(expanded)
    cell = SheetCell(value=None, text=f"L = {whole_level} dB, K = {whole_k} dB")
    yield SheetRow(symbol="L, K", meaning="the same in whole decibels, K rounded up", cells=(cell,))


def _row(
    symbol: str, meaning: str, value: float, text: str, uncertainty: float | None = None
) -> SheetRow:
    """Return the row of a level."""
    cell = SheetCell(value=value, unit="dB", text=f"{text} dB", uncertainty=uncertainty)
    return SheetRow(symbol=symbol, meaning=meaning, cells=(cell,))


def parts_table(level: Quantity) -> SheetTable | None:
    """Return the table of the parts of s by their source; None without any."""
    rows = []
    for source, words in PART_WORDS.items():  # whose words follow each other in this order
        part = level.parts.get(source)
        if part:
            rows.append(_part_row("", words, part))
    if not rows or level.uncertainty is None:
        return None
    whole = _part_row("s", "all parts, by the root of the sum of squares", level.uncertainty)
    title = "Standard uncertainty behind K, by its source"
    return SheetTable(title=title, heads=("standard uncertainty",), rows=(whole, *rows))


def _part_row(symbol: str, meaning: str, part: float) -> SheetRow:
    """Return the row of a part of an uncertainty, rounded up."""
    cell = SheetCell(value=part, unit="dB", text=f"{rounded_up(part)} dB")
    return SheetRow(symbol=symbol, meaning=meaning, cells=(cell,))


def beside_row(symbol: str, meaning: str, level_db: float | None, unit: str = "dB") -> SheetRow:
    """Return the row of a level that stands beside the declared one, and has no K."""
    text = NONE if level_db is None else f"{level_db:.1f} {unit}"
    cell = SheetCell(value=level_db, unit=unit, text=text)
    return SheetRow(symbol=symbol, meaning=meaning, cells=(cell,))
