"""Views of numbers: columns of tables, and variables with units, by code that knows no name."""

from __future__ import annotations

from typing import Any, NamedTuple

from rolling.numbers.fields import NumberField, leaves
from rolling.numbers.quantity import BandQuantity, Quantity

SPREADS = "spreads"  # group of the uncertainties of the levels beside it


class Cell(NamedTuple):
    """A value of a table, and what is said of it."""

    value: Any
    said: NumberField


def columns(numbers: Any) -> dict[str, Cell]:
    """Return the single numbers and texts of a data class of numbers by the names of their columns.

    A name joins subject and field, as in `contact_plastic_ratio`. A quantity has value,
    uncertainty, origin, verdict and measure. Bands, mappings and tuples are left out.
    """
    cells: dict[str, Cell] = {}
    for path, said, value in leaves(numbers):
        name = "_".join(path)
        if isinstance(value, Quantity):
            cells |= quantity_cells(name, said, value)
        elif not said.is_group and not isinstance(value, tuple):
            cells[name] = Cell(value, said)
    return cells


def quantity_cells(name: str, said: NumberField, quantity: Quantity) -> dict[str, Cell]:
    """Return the columns of a quantity."""
    unit = quantity.unit
    end = "db" if unit.startswith("dB") else unit.replace("/", "_")
    of_spread = "dB" if unit.startswith("dB") else unit
    meaning = said.meaning

    def cell(value: Any, words: str, cell_unit: str = "") -> Cell:
        """Return a cell that runs.csv has."""
        return Cell(value, NumberField(words, cell_unit, in_table=True))

    spread = f"{name}_uncertainty_db" if end == "db" else f"{name}_uncertainty"
    return {
        f"{name}_{end}": cell(quantity.value, meaning, unit),
        spread: cell(quantity.uncertainty, f"standard uncertainty: {meaning}", of_spread),
        f"{name}_verdict": cell(quantity.verdict, f"how far to trust it: {meaning}"),
        f"{name}_how": cell(quantity.how, f"how it was found: {meaning}"),
        f"{name}_measure": cell(quantity.measure, f"what it measures: {meaning}"),
        f"{name}_solved_share": Cell(
            quantity.solved_share, NumberField(f"share that was solved: {meaning}", "1")
        ),
    }


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
    for path, said, _ in leaves(numbers):
        name = "_".join(path)
        spread = "_".join((*path[:-1], SPREADS, path[-1]))
        if not said.is_group and spread in cells:
            pairs[name] = spread
    return pairs
