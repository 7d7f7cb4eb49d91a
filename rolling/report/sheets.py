"""Sheets as a page on paper size, as CSV and as JSON, and as a fold of the page of runs."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from pandas import DataFrame

from acoustics.texts import printable
from rolling import __version__
from rolling.kinds.page_parts import Part
from rolling.numbers.sheet import Sheet
from rolling.report.page_of_parts import PageOfParts
from rolling.results.runs_table import csv_bytes

FORMAT = 1  # of the JSON
Sheets = Mapping[str, Sequence[Sheet]]  # of each run, by its label


def sheets_page(title: str, sheets: Sheets, source: str) -> bytes:
    """Write sheets as a page of paper size, which needs no script."""
    made = PageOfParts(
        title=title,
        noise="declared values",
        source=source,
        first=[],
        parts=[Part("sheets.html", {"sheets": _shown(sheets)})],
        styles=("sheet.css",),
    )
    return made.written()


def sheets_fold(sheets: Sheets) -> Part:
    """Return the fold of a page that has the sheets of its runs."""
    return Part("declared.html", {"sheets": _shown(sheets)})


def _shown(sheets: Sheets) -> list[tuple[str, Sequence[Sheet]]]:
    """Return the sheets of each run with its label in printable letters."""
    return [(printable(label), of_run) for label, of_run in sheets.items()]


def sheets_csv(sheets: Sheets, source: str) -> bytes:
    """Write the values of sheets as CSV, a row for each value, as a number and as printed."""
    rows = []
    for label, of_run in sheets.items():
        for sheet in of_run:
            rows += [{"run": label, "sheet": sheet.name, **value} for value in _values(sheet)]
    return csv_bytes(DataFrame(rows).assign(source=source))


def sheets_json(sheets: Sheets, source: str) -> bytes:
    """Write sheets as JSON: values, what they rest on, and what they lack."""
    content = {
        "format": FORMAT,
        "program": f"rolling-contact-noise {__version__}",
        "source": source,
        "runs": [
            {"run": label, "sheets": [_sheet(sheet) for sheet in of_run]}
            for label, of_run in sheets.items()
        ],
    }
    return (json.dumps(content, indent=2, allow_nan=False) + "\n").encode()


def _sheet(sheet: Sheet) -> dict[str, Any]:
    """Return a sheet as JSON has it."""
    return {
        "sheet": sheet.name,
        "title": sheet.title,
        "subject": sheet.subject,
        "notice": sheet.notice,
        "values": _values(sheet),
        "facts": dict(sheet.facts),
        "departures": list(sheet.departures),
    }


def _values(sheet: Sheet) -> list[dict[str, Any]]:
    """Return all values of a sheet with their places in it."""
    values = []
    for table in sheet.tables:
        for row in table.rows:
            for head, cell in zip(table.heads, row.cells, strict=True):
                entry = {
                    "table": table.title,
                    "symbol": row.symbol,
                    "meaning": row.meaning,
                    "column": head,
                    "value": cell.number,
                    "unit": cell.unit,
                    "uncertainty": cell.uncertainty,
                    "uncertainty_unit": cell.unit_of_uncertainty,
                    "printed": cell.text,
                }
                values.append(entry)
    return values
