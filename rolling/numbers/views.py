"""Views of numbers: columns of tables, and variables with units, by code that knows no name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from acoustics.numbers import rounded
from rolling.numbers.fields import Leaf, NumberField, leaves, walk
from rolling.numbers.quantity import BandQuantity, Quantity

NOTHING = "-"  # in the place of a number that a run does not have
SPREADS = "spreads"  # group of the uncertainties of the levels beside it


class Cell(NamedTuple):
    """A value of a table, what is said of it, and its name for people."""

    value: Any
    number_field: NumberField
    name: str

    @property
    def head(self) -> str:
        """Name and unit, for the head of a column or an axis."""
        return self.number_field.headed(self.name)


def rows(numbers: Any) -> Iterator[Leaf]:
    """Yield the numbers that have a word, which people read in tables, also those that are None."""
    for leaf in walk(numbers):
        if leaf.number_field.word and (
            isinstance(leaf.value, Quantity) or not leaf.number_field.is_group
        ):
            yield leaf


def spread_of(leaf: Leaf) -> float | None:
    """Return the standard uncertainty of a number that its group has; None without."""
    spread: float | None = getattr(getattr(leaf.group, SPREADS, None), leaf.path[-1], None)
    return spread


def columns(numbers: Any) -> dict[str, Cell]:
    """Return the single numbers and texts of a data class of numbers by the names of their columns.

    A name joins subject and field, as in `contact_plastic_ratio`. A quantity has value,
    uncertainty, origin, verdict and measure. Bands, mappings and tuples are left out.
    """
    cells: dict[str, Cell] = {}
    for leaf in walk(numbers):
        name = "_".join(leaf.path)
        if isinstance(leaf.value, Quantity):
            cells |= quantity_cells(name, leaf.number_field, leaf.value)
        elif not leaf.number_field.is_group and not isinstance(leaf.value, tuple):
            cells[name] = Cell(leaf.value, leaf.number_field, leaf.name)
    return cells


def quantity_cells(name: str, number_field: NumberField, quantity: Quantity) -> dict[str, Cell]:
    """Return the columns of a quantity."""
    unit = quantity.unit
    end = "db" if unit.startswith("dB") else unit.replace("/", "_")
    of_spread = quantity.unit_of_uncertainty
    meaning = number_field.meaning
    word = number_field.word or name.replace("_", " ")

    def cell(value: Any, what: str, words: str, cell_unit: str = "", shown: bool = True) -> Cell:
        """Return a cell, which runs.csv has unless it is told otherwise."""
        return Cell(value, NumberField(words, cell_unit, in_table=shown), what)

    spread = f"{name}_uncertainty_db" if of_spread == "dB" else f"{name}_uncertainty"
    has_origin = number_field.origin_in_table
    return {
        f"{name}_{end}": cell(quantity.value, word, meaning, unit),
        spread: cell(
            quantity.uncertainty,
            f"standard uncertainty of the {word}",
            f"standard uncertainty: {meaning}",
            of_spread,
        ),
        f"{name}_verdict": cell(
            quantity.verdict, f"verdict on the {word}", f"how far to trust it: {meaning}"
        ),
        f"{name}_how": cell(
            quantity.how,
            f"origin of the {word}",
            f"how it was found: {meaning}",
            shown=has_origin,
        ),
        f"{name}_measure": cell(
            quantity.measure,
            f"measure of the {word}",
            f"what it measures: {meaning}",
            shown=has_origin,
        ),
        f"{name}_solved_share": Cell(
            quantity.solved_share,
            NumberField(f"share that was solved: {meaning}", "1"),
            f"solved share of the {word}",
        ),
    }


def quantities(numbers: Any) -> dict[str, Quantity]:
    """Return all quantities in a data class of numbers by their words, or by their paths."""
    named = {}
    for leaf in walk(numbers):
        if isinstance(leaf.value, Quantity):
            named[_words(leaf)] = leaf.value
    return named


def quantity_columns(numbers: Any) -> list[str]:
    """Return the columns of the values of all quantities in a data class of numbers."""
    columns = []
    for path, number_field, value in leaves(numbers):
        if isinstance(value, Quantity):
            columns.append(next(iter(quantity_cells("_".join(path), number_field, value))))
    return columns


class NumberRow(NamedTuple):
    """A number of each run, as text, below its name and unit."""

    head: str
    cells: list[str]
    number_field: NumberField


def table_rows(every: Sequence[Any]) -> list[NumberRow]:
    """Return the rows of a table of runs: quantities with ± and verdict, and numbers of runs.csv.

    A row is there if a run has its number.
    """
    of_runs = [_table_texts(numbers) for numbers in every]
    rows = []
    for head in dict.fromkeys(head for texts in of_runs for head in texts):
        known = [texts[head] for texts in of_runs if head in texts]
        cells = [texts[head].text if head in texts else NOTHING for texts in of_runs]
        if any(number.text != NOTHING for number in known):
            rows.append(NumberRow(head, cells, known[0].number_field))
    return rows


class _TableText(NamedTuple):
    """A number as text, with what is said of it."""

    text: str
    number_field: NumberField


def _table_texts(numbers: Any) -> dict[str, _TableText]:
    """Return the numbers of a run that a table has, by name and unit."""
    texts = {}
    for leaf in walk(numbers):
        value = leaf.value
        if isinstance(value, Quantity):
            text = NOTHING if value.value is None else f"{value} ({value.verdict})"
            texts[_words(leaf)] = _TableText(text, leaf.number_field)
        elif leaf.number_field.in_table and isinstance(value, str):
            texts[leaf.number_field.headed(leaf.name)] = _TableText(value, leaf.number_field)
        elif leaf.number_field.in_table and isinstance(value, float | int):
            text = rounded(leaf.number_field.factor * value, 4)
            texts[leaf.number_field.headed(leaf.name)] = _TableText(text, leaf.number_field)
    return texts


def _words(leaf: Leaf) -> str:
    """Return the words for a quantity: its own, or those of its place among the numbers."""
    words = leaf.number_field.word or " ".join(leaf.path).replace("_", " ")
    return words[:1].upper() + words[1:]


def bands_of(numbers: Any) -> dict[str, BandQuantity]:
    """Return the band quantities of a data class of numbers by the names of their columns."""
    return {
        "_".join(path): value
        for path, _, value in leaves(numbers)
        if isinstance(value, BandQuantity)
    }


def spread_columns(numbers: Any) -> dict[str, str]:
    """Return the columns of standard uncertainties by the columns of their values."""
    cells = columns(numbers)
    pairs = {}
    for name in cells:
        spread = f"{name.removesuffix('_db')}_uncertainty_db"
        if name.endswith("_db") and spread in cells:
            pairs[name] = spread
    for path, number_field, _ in leaves(numbers):
        name = "_".join(path)
        spread = "_".join((*path[:-1], SPREADS, path[-1]))
        if not number_field.is_group and spread in cells:
            pairs[name] = spread
    return pairs
