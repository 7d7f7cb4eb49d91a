"""Fields of data classes of numbers: what a number means, its unit, and how it is written."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import MISSING, dataclass, field
from typing import Any, NamedTuple

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
    as_measured : bool. Whether people read it as LAE for an event, like the level that leads.
    explained : str. What a stranger must know of the word, as a sentence. Default: nothing.
    is_group : bool. Whether it is a group of numbers: a data class, a tuple of them, a mapping.
    origin_in_table : bool. Whether runs.csv has origin and measure of a quantity, because they
        differ between runs.
    """

    meaning: str
    unit: str = ""
    word: str = ""
    shown_unit: str = ""
    factor: float = 1.0
    form: str = ""
    in_table: bool = False
    holds_for: str = ""
    as_measured: bool = False
    explained: str = ""
    is_group: bool = False
    origin_in_table: bool = True

    @property
    def head(self) -> str:
        """Word and unit, for the head of a row or a column."""
        return self.headed(self.word)

    def headed(self, name: str) -> str:
        """Return a name with the unit that people read."""
        unit = self.shown_unit or self.unit
        return f"{name} [{unit}]" if unit not in ("", "1") else name

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
    as_measured: bool = False,
    explained: str = "",
    default: Any = MISSING,
) -> Any:
    """Return the field of a number, or of a text with the unit "", in a data class of numbers.

    Parameters
    ----------
    meaning, unit, word, shown_unit, factor, form, in_table, holds_for, as_measured, explained
        As in `NumberField`.
    default
        The value of a run that does not have the number. Default: every run has it.
    """
    number_field = NumberField(
        meaning=meaning,
        unit=unit,
        word=word,
        shown_unit=shown_unit,
        factor=factor,
        form=form,
        in_table=in_table,
        holds_for=holds_for,
        as_measured=as_measured,
        explained=explained,
    )
    return field(default=default, metadata={"number": number_field})


def group(
    meaning: str, *, word: str = "", origin_in_table: bool = True, default: Any = MISSING
) -> Any:
    """Return the field of a group of numbers: a data class, a tuple of them, or a mapping.

    A word names a quantity, or the source to which the numbers of the group belong.
    """
    number_field = NumberField(meaning, word=word, is_group=True, origin_in_table=origin_in_table)
    return field(default=default, metadata={"number": number_field})


def number_field_of(data_field: dataclasses.Field[Any]) -> NumberField | None:
    """Return what is said of a field; None for a field of no number."""
    number_field: NumberField | None = data_field.metadata.get("number")
    return number_field


class Leaf(NamedTuple):
    """A field of numbers that is no group, with its value.

    Attributes
    ----------
    path : tuple of str
        Names of its groups and its own.
    place : tuple of int
        Where it and its groups stand among the fields, by which tables are sorted.
    number_field : NumberField
        What is said of it.
    value : Any
        A quantity, a number, a text, or None.
    group : Any
        The data class that holds it.
    source : str
        Word of the source to which its group belongs, or an empty text.
    """

    path: tuple[str, ...]
    place: tuple[int, ...]
    number_field: NumberField
    value: Any
    group: Any
    source: str

    @property
    def name(self) -> str:
        """Its word, or its meaning, with that of its source, as in `LAFmax of the vibration`."""
        word = self.number_field.word or self.number_field.meaning
        return f"{word} of the {self.source}" if self.source else word


def walk(
    numbers: Any, path: tuple[str, ...] = (), place: tuple[int, ...] = (), source: str = ""
) -> Iterator[Leaf]:
    """Yield the fields of numbers that are no groups, subject by subject.

    Groups that a run does not have are left out.
    """
    for k, data_field in enumerate(dataclasses.fields(numbers)):
        number_field = number_field_of(data_field)
        if number_field is None:
            continue
        value = getattr(numbers, data_field.name)
        is_group = dataclasses.is_dataclass(value) and any(
            number_field_of(inner) is not None for inner in dataclasses.fields(value)
        )
        if is_group:
            yield from walk(
                value, (*path, data_field.name), (*place, k), number_field.word or source
            )
        else:
            yield Leaf(
                path=(*path, data_field.name),
                place=(*place, k),
                number_field=number_field,
                value=value,
                group=numbers,
                source=source,
            )


def leaves(numbers: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any, Any]]:
    """Yield the path, what is said, and the value of each field of numbers that is no group.

    Groups that a run does not have are left out.
    """
    for leaf in walk(numbers, path):
        yield leaf.path, leaf.number_field, leaf.value
