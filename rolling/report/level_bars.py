"""Bars of a page, each with its value and its ± in words: levels of bands, changes of a level."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

_DECADES = 4  # of a logarithmic scale, at most; smaller values have no bar
_LEAST_DB = 0.5  # half of a scale of changes, at least


class Row(NamedTuple):
    """A value to be drawn as a bar, with the ends of its ± and its words.

    name : str. What the value belongs to.
    value : float or None. None where there is none.
    low, high : float or None. Ends of its ±; None without one.
    words : str. The value as it is written, with its unit.
    spread : str. Its ± as it is written; empty without one.
    beside : float or None. The same by another model, which has a mark of its own.
    """

    name: str
    value: float | None
    low: float | None
    high: float | None
    words: str
    spread: str = ""
    beside: float | None = None


class LevelBar(NamedTuple):
    """A row with its places in thousandths of the width.

    `begin` and `end` are None where there is no value; `spread_ends` are those of the ±.
    """

    row: Row
    begin: float | None
    end: float | None
    spread_ends: tuple[float, float] | None
    beside: float | None


class Bars(NamedTuple):
    """Bars on a common scale.

    label : str. What they are of, with the unit.
    bars : list of LevelBar.
    ticks : list of pairs. Place in thousandths of the width, and its text.
    zero : float or None. Place of zero where bars stand on both sides of it.
    """

    label: str
    bars: list[LevelBar]
    ticks: list[tuple[float, str]]
    zero: float | None = None


def bars_over_decades(label: str, rows: Sequence[Row]) -> Bars:
    """Return bars of positive values on a logarithmic scale of whole decades."""
    positive = [value for value in _ends(rows) if value > 0]
    first = math.floor(math.log10(min(positive))) if positive else 0
    last = math.ceil(math.log10(max(positive))) if positive else 1
    last = max(last, first + 1)
    first = max(first, last - _DECADES)

    def place(value: float) -> float:
        """Return the place of a value in thousandths of the width."""
        decades = math.log10(value) if value > 0 else first
        return _within(1000 * (decades - first) / (last - first))

    ticks = [(place(10.0**power), f"{10.0**power:g}") for power in range(first, last + 1)]
    bars = [_bar(row, place, 0.0) for row in rows]
    return Bars(label=label, bars=bars, ticks=ticks)


def bars_around_zero(label: str, rows: Sequence[Row]) -> Bars:
    """Return bars of changes on a linear scale with zero in its middle."""
    largest = max([_LEAST_DB, *map(abs, _ends(rows))])
    power = 10.0 ** math.floor(math.log10(largest))
    half = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= largest)

    def place(value: float) -> float:
        """Return the place of a value in thousandths of the width."""
        return _within(500 + 500 * value / half)

    ticks = [(place(share * half), f"{share * half:+g}") for share in (-1, -0.5, 0.5, 1)]
    ticks.insert(2, (500.0, "0"))
    bars = [_bar(row, place, 500.0) for row in rows]
    return Bars(label=label, bars=bars, ticks=ticks, zero=500.0)


def _ends(rows: Sequence[Row]) -> Iterable[float]:
    """Yield all values of rows, and the ends of their ±."""
    for row in rows:
        for value in (row.value, row.low, row.high, row.beside):
            if value is not None:
                yield value


def _bar(row: Row, place: Callable[[float], float], base: float) -> LevelBar:
    """Return the bar of a row, from a base to its value."""
    begin = end = spread_ends = None
    if row.value is not None:
        begin, end = sorted((base, place(row.value)))
    if row.low is not None and row.high is not None:
        spread_ends = place(row.low), place(row.high)
    beside = None if row.beside is None else place(row.beside)
    return LevelBar(row=row, begin=begin, end=end, spread_ends=spread_ends, beside=beside)


def _within(place: float) -> float:
    """Return a place within the width, with one decimal."""
    return round(min(1000.0, max(0.0, place)), 1)
