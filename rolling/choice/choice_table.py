"""Table of a choice: a row for each candidate and quantity, the quietest first."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from acoustics.texts import printable
from rolling.choice.choice_numbers import ChoiceNumbers, Contender
from rolling.choice.choice_sentences import number, probability
from rolling.choice.difference import Difference
from rolling.choice.heard_specimen import HeardQuantity
from rolling.numbers.quantity import uncertain
from rolling.terminal.streams import columns

if TYPE_CHECKING:
    import pandas as pd


def rows(choice: ChoiceNumbers) -> list[dict[str, Any]]:
    """Return the numbers of each candidate and quantity by the names of their columns.

    The differences are those from the quietest candidate, and None in its own rows.
    """
    table_rows = []
    for place, contender in enumerate(choice.contenders):
        for quantity in choice.quantities:
            levels = contender.levels_in(quantity.name)
            scatter = None
            if len(levels) > 1 and np.all(np.isfinite(levels)):
                scatter = float(np.std(levels, ddof=1))
            row: dict[str, Any] = {"candidate": contender.label}
            if len(choice.quantities) > 1:
                row["quantity"] = quantity.words
            row[quantity.column] = contender.mean_in(quantity)
            row["scatter_db"] = scatter
            row |= _difference_columns(choice, place, quantity.name)
            row |= _room_columns(choice, place)
            row |= _released_columns(choice, place)
            row["specimens"] = len(contender.heard)
            row["left_out"] = len(choice.omitted)
            table_rows.append(row)
    return table_rows


def _difference_columns(choice: ChoiceNumbers, place: int, quantity: str) -> dict[str, Any]:
    """Return how much louder a candidate is than the quietest, with the parts of the ±."""
    if not place:
        return {"louder_db": None, "louder_uncertainty_db": None, "sureness": None}
    difference = choice.by_quantity[place - 1][quantity]
    columns_of_difference: dict[str, Any] = {
        "louder_db": difference.db,
        "louder_uncertainty_db": difference.uncertainty_db,
        "sureness": difference.sureness,
    }
    for part, size in difference.parts_db.items():
        columns_of_difference[f"{part}_part_db"] = size if math.isfinite(size) else None
    if difference.independent is not None:
        columns_of_difference["independent_places"] = difference.independent
        columns_of_difference["further_scan_uncertainty_db"] = difference.further_scan_db
    columns_of_difference["uncertainty_left_out"] = " ".join(difference.left_out_db)
    return columns_of_difference


def _room_columns(choice: ChoiceNumbers, place: int) -> dict[str, Any]:
    """Return whether the difference of a candidate is heard in a room; nothing if none is known."""
    if not choice.audible:
        return {}
    judged = choice.audible[place - 1].audibility if place else None
    return {
        "audible": judged and judged.verdict,
        "n5_difference_percent": judged and judged.difference_percent,
        "n5_difference_uncertainty_percent": judged and judged.uncertainty_percent,
    }


def _released_columns(choice: ChoiceNumbers, place: int) -> dict[str, Any]:
    """Return the released power of a candidate; nothing where no candidate has one."""
    if not has_released_power(choice):
        return {}
    difference = choice.differences[place - 1] if place else None
    return {
        "released_power_db": choice.contenders[place].released_power_db,
        "released_power_higher_db": difference and difference.released_db,
        "released_power_higher_uncertainty_db": difference and difference.released_uncertainty_db,
    }


def has_released_power(choice: ChoiceNumbers) -> bool:
    """Tell whether a candidate has a released power."""
    return any(contender.released_power_db is not None for contender in choice.contenders)


def frame(choice: ChoiceNumbers) -> pd.DataFrame:
    """Return the table as a DataFrame."""
    import pandas as pd

    return pd.DataFrame(rows(choice))


class Column(NamedTuple):
    """A column of the table in words.

    head, unit : str. Its head, in two lines on a terminal.
    cells : list of str. A cell for each candidate.
    """

    head: str
    unit: str
    cells: list[str]


def words_of(choice: ChoiceNumbers) -> list[Column]:
    """Return the columns of the table in words, those of the released power last."""
    table_columns = [Column("candidate", "", list(choice.labels))]
    is_single = len(choice.quantities) == 1
    for quantity in choice.quantities:
        of_others = [of_one[quantity.name] for of_one in choice.by_quantity]
        means = [_mean(contender, quantity) for contender in choice.contenders]
        kind = "mean, " if quantity.is_level else "rms, "
        table_columns.append(Column(quantity.words, f"{kind}{quantity.unit}", means))
        louder = ["-", *map(number, of_others)]
        if is_single:
            table_columns.append(
                Column("louder than", f"the quietest, {quantity.decibels}", louder)
            )
        else:  # the first one is the quietest in the leading quantity only
            table_columns.append(Column("more than", f"the first, {quantity.decibels}", louder))
    if is_single:
        table_columns.append(Column("sure", "", ["-", *map(_sure, choice.differences)]))
    if choice.audible:
        judged = [
            difference.audibility.verdict if difference.audibility else "-"
            for difference in choice.audible
        ]
        table_columns.append(Column("in the room", "", ["-", *judged]))
    if has_released_power(choice):
        means = [_uncertain(contender.released_power_db, None) for contender in choice.contenders]
        table_columns.append(Column("released power", "upper bound, dB(A)", means))
    return table_columns


def _mean(contender: Contender, quantity: HeardQuantity) -> str:
    """Write the mean of a quantity over the specimens of a candidate."""
    mean = contender.mean_in(quantity)
    if mean is None:
        return "silent"
    return _uncertain(mean, None) if quantity.is_level else f"{mean:.3g}"


def _sure(difference: Difference) -> str:
    """Write how sure the sign of a difference is."""
    return "-" if difference.sureness is None else probability(difference.sureness)


def cells(choice: ChoiceNumbers) -> list[list[str]]:
    """Return head and rows of the table in words, with the difference of released powers."""
    table_columns = words_of(choice)
    if has_released_power(choice):
        higher = [
            _uncertain(difference.released_db, difference.released_uncertainty_db)
            for difference in choice.differences
        ]
        table_columns.append(Column("higher than of", "the quietest, dB", ["-", *higher]))
    heads = []
    for column in table_columns:
        comma = "," if column.unit and not column.unit.startswith("the ") else ""
        heads.append(f"{column.head}{comma} {column.unit}".strip())
    rows_in_words = zip(*(column.cells for column in table_columns), strict=True)
    return [heads, *map(list, rows_in_words)]


def lines(choice: ChoiceNumbers) -> str:
    """Write the table in columns for a terminal, without the difference of released powers."""
    names, *others = words_of(choice)
    listed = [["", "", *map(printable, names.cells)]]
    listed += [[column.head, column.unit, *column.cells] for column in others]
    return columns(list(zip(*listed, strict=True)))


def _uncertain(db: float | None, uncertainty_db: float | None) -> str:
    """Write decibels with their ±, `-` where there are none."""
    return "-" if db is None else uncertain(db, uncertainty_db)
