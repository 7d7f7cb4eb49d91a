"""Sheets that people hand on: values by the names of a profession, with what they rest on.

A sheet is data. Pages, CSV and JSON are views of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

NONE = "-"  # of a cell without a value


@dataclass(frozen=True, kw_only=True)
class SheetCell:
    """A value of a sheet.

    Attributes
    ----------
    value : float or None
        The value, unrounded; None where there is none.
    unit : str
        Its unit, as it is printed.
    text : str
        The value as it is printed, with its unit, or why there is none.
    uncertainty : float or None
        Its standard uncertainty, unrounded; None where it is not known.
    uncertainty_unit : str
        Unit of the uncertainty. Default: that of the value.
    """

    value: float | None
    unit: str = ""
    text: str
    uncertainty: float | None = None
    uncertainty_unit: str = ""

    @property
    def unit_of_uncertainty(self) -> str:
        """Unit of the uncertainty; empty without one."""
        return "" if self.uncertainty is None else self.uncertainty_unit or self.unit

    @property
    def number(self) -> float | None:
        """The value where it is finite, for files that hold no other."""
        if self.value is None or not math.isfinite(self.value):
            return None
        return self.value


@dataclass(frozen=True, kw_only=True)
class SheetRow:
    """A row of a table of a sheet: symbol, meaning, and a cell below each head."""

    symbol: str
    meaning: str
    cells: tuple[SheetCell, ...]


@dataclass(frozen=True, kw_only=True)
class SheetTable:
    """A table of a sheet: its title, the heads of its cells, and its rows."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[SheetRow, ...]


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """A sheet of one run, or of one surface.

    Attributes
    ----------
    name : str
        Name for programs, such as noise.
    title : str
        What it is, and after which standards.
    subject : str
        What it is about.
    notice : str
        What a reader has to know before all values.
    tables : tuple of SheetTable
        The values.
    facts : tuple of pairs of str
        What the values rest on: a name, and words.
    departures : tuple of str
        What the standards ask for and this sheet does not have, in sentences.
    """

    name: str
    title: str
    subject: str
    notice: str
    tables: tuple[SheetTable, ...]
    facts: tuple[tuple[str, str], ...]
    departures: tuple[str, ...]
