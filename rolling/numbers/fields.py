"""Fields of data classes of numbers: what a number means, its unit, and how it is written."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import MISSING, dataclass, field
from typing import Any

from acoustics.numbers import rounded


@dataclass(frozen=True)
class NumberField:
    """What is said of a field beside its value.

    meaning : str. What the number is, as a half sentence.
    unit : str. Unit of the stored value, "1" for a pure number, "" for a text or a group.
    word : str. Name in tables for people; empty for a number that only programs read.
    shown_unit : str. Unit in tables for people. Default: `unit`.
    factor : float. Factor from the stored value to that unit.
    form : str. Format in tables for people. Default: four digits.
    in_table : bool. Whether runs.csv has it.
    holds_for : str. `event` or `lasting` for a level that says nothing of the other kind of record.
    is_group : bool. Whether it is a group of numbers: a data class, a tuple of them, a mapping.
    """

    meaning: str
    unit: str = ""
    word: str = ""
    shown_unit: str = ""
    factor: float = 1.0
    form: str = ""
    in_table: bool = False
    holds_for: str = ""
    is_group: bool = False

    @property
    def head(self) -> str:
        """Name and unit, for the head of a row or a column."""
        unit = self.shown_unit or self.unit
        return f"{self.word} [{unit}]" if unit not in ("", "1") else self.word

    def text(self, value: float) -> str:
        """Write a value in the unit that people read."""
        number = value * self.factor
        return f"{number:{self.form}}" if self.form else rounded(number, 4)


def number(
    meaning: str,
    unit: str = "1",
    *,
    word: str = "",
    shown_unit: str = "",
    factor: float = 1.0,
    form: str = "",
    in_table: bool = False,
    holds_for: str = "",
    default: Any = MISSING,
) -> Any:
    """Return the field of a number, or of a text with the unit "", in a data class of numbers.

    Parameters
    ----------
    meaning, unit, word, shown_unit, factor, form, in_table, holds_for
        As in `NumberField`.
    default
        The value of a run that does not have the number. Default: every run has it.
    """
    said = NumberField(
        meaning=meaning,
        unit=unit,
        word=word,
        shown_unit=shown_unit,
        factor=factor,
        form=form,
        in_table=in_table,
        holds_for=holds_for,
    )
    return field(default=default, metadata={"number": said})


def group(meaning: str, default: Any = MISSING) -> Any:
    """Return the field of a group of numbers: a data class, a tuple of them, or a mapping."""
    return field(default=default, metadata={"number": NumberField(meaning, is_group=True)})


def said_of(one: dataclasses.Field[Any]) -> NumberField | None:
    """Return what is said of a field; None for a field of no number."""
    said: NumberField | None = one.metadata.get("number")
    return said


def leaves(numbers: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any, Any]]:
    """Yield the path, what is said, and the value of each field of numbers that is no group.

    Groups that a run does not have are left out.
    """
    for one in dataclasses.fields(numbers):
        said = said_of(one)
        if said is None:
            continue
        value = getattr(numbers, one.name)
        place = (*path, one.name)
        is_group = dataclasses.is_dataclass(value) and any(
            said_of(inner) is not None for inner in dataclasses.fields(value)
        )
        if is_group:
            yield from leaves(value, place)
        else:
            yield place, said, value
