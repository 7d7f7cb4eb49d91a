"""Levels of a run in words: their names, values and uncertainties."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rolling.numbers import views
from rolling.numbers.ball_numbers import DB, DB_A, RunNumbers
from rolling.numbers.fields import Leaf, NumberField
from rolling.numbers.quantity import Quantity, uncertain
from rolling.numbers.views import NOTHING, NumberRow
from rolling.results.answer import of_solved_part
from rolling.results.run_quantities import LAE, as_heard, measure

SILENT = "silent"


class NumberText(NamedTuple):
    """A number of a run as people read it.

    Attributes
    ----------
    place : tuple of int
        Where it stands among the fields, by which rows are sorted.
    head : str
        Its name and unit.
    text : str
        The number with its uncertainty, `silent` without sound, or `-` where there is none.
    number_field : NumberField
        What is said of it.
    is_of_record : bool
        Whether it is a level of the record that is measured.
    is_repeated : bool
        Whether it is one of the two numbers of the run again.
    """

    place: tuple[int, ...]
    head: str
    text: str
    number_field: NumberField
    is_of_record: bool
    is_repeated: bool


def number_texts(numbers: RunNumbers) -> list[NumberText]:
    """Return the numbers of a run that have a word, but for levels that say nothing of its record.

    The levels of what ends are those of the whole record.
    """
    shown = as_heard(numbers)
    of_record = shown.of_record
    answers = (numbers.vibration.value, numbers.released_power.value)
    skipped = "lasting" if numbers.record.single_event else "event"
    texts = []
    for row in views.rows(shown):
        if row.number_field.holds_for == skipped:
            continue
        number_text = NumberText(
            place=row.place,
            head=_head(row, numbers),
            text=_text(row, is_silent=row.group is of_record and of_record.laeq_db is None),
            number_field=row.number_field,
            is_of_record=row.group is of_record,
            is_repeated=row.value is not None and row.value in answers,
        )
        texts.append(number_text)
    return texts


def number_rows(every: Sequence[RunNumbers]) -> list[NumberRow]:
    """Return the rows of a table of the numbers of runs that have a word, in the order of fields.

    A row is there if a run has its number. A row that only repeats the two numbers of the runs is
    left out.
    """
    columns = [{text.head: text for text in number_texts(numbers)} for numbers in every]
    by_head: dict[str, list[NumberText]] = {}
    for column in columns:
        for head, text in column.items():
            by_head.setdefault(head, []).append(text)
    rows = []
    for head in sorted(by_head, key=lambda head: min(text.place for text in by_head[head])):
        known = [text for text in by_head[head] if text.text != NOTHING]
        if not known or all(text.is_repeated for text in known):
            continue
        cells = [column[head].text if head in column else NOTHING for column in columns]
        rows.append(NumberRow(head, cells, known[0].number_field))
    return rows


def _head(row: Leaf, numbers: RunNumbers) -> str:
    """Return name and unit of a row: of a quantity with its origin, of an event with LAE."""
    if isinstance(row.value, Quantity):
        name = f"{row.name}, {row.value.how}"
        return f"{name}{_reference(numbers)} [{row.value.unit}]"
    name = row.name
    if row.number_field.as_measured:
        name += _reference(numbers)
    return row.number_field.headed(name)


def _reference(numbers: RunNumbers) -> str:
    """Say of a level of an event that it is an LAE; nothing for LAeq."""
    return ", LAE (re 1 s)" if measure(numbers) == LAE else ""


def _text(row: Leaf, is_silent: bool) -> str:
    """Write a number with its uncertainty; a level of sound pressure is silent without sound."""
    if isinstance(row.value, Quantity):
        return row.value.number
    if row.value is None:
        return SILENT if is_silent and row.number_field.unit in (DB, DB_A) else NOTHING
    spread = views.spread_of(row)
    if spread is not None:
        return uncertain(row.value, spread)
    return row.number_field.text(row.value)


def level_rows(numbers: RunNumbers) -> dict[str, str]:
    """Return the two numbers of a run in words, the verdicts on them, and the other levels."""
    rows = {}
    for name, quantity in (
        ("vibration", numbers.vibration),
        ("released power", numbers.released_power),
    ):
        rows[name] = str(quantity)
        if quantity.judged is not None:
            rows[f"verdict on the {name}"] = quantity.judged.sentence
    for level in number_texts(numbers):
        if level.is_of_record and not level.is_repeated and level.text != NOTHING:
            rows[level.head] = level.text
    part = of_solved_part([numbers])
    if part:
        rows["record"] = part
    return rows
