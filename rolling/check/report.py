"""Findings as a table: for the terminal as text, for a notebook as HTML."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rolling.check.finding import Finding
    from rolling.check.findings import Findings

RUNS_ABREAST = 5  # columns of the table


def text(findings: Findings) -> str:
    """Write the values that all runs share, then a column per run, then the warnings."""
    shared, by_run = _rows(findings)
    blocks = [_table(shared)]
    if len(by_run) > 1:
        columns = range(1, len(findings.runs) + 1, RUNS_ABREAST)
        blocks += [_table([[row[0], *row[k : k + RUNS_ABREAST]] for row in by_run]) for k in columns]
    return "\n\n".join(filter(None, [*blocks, "\n".join(f"warning: {line}" for line in findings.warnings)]))


def html(findings: Findings) -> str:
    """Write the same tables and warnings as HTML."""
    shared, by_run = _rows(findings)
    tables = [shared, by_run] if len(by_run) > 1 else [shared]
    parts = []
    for rows in tables:
        lines = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
        parts.append("<table>" + "".join(f"<tr>{line}</tr>" for line in lines) + "</table>")
    if findings.warnings:
        parts.append("<ul>" + "".join(f"<li>{escape(line)}</li>" for line in findings.warnings) + "</ul>")
    return "".join(parts)


def warnings(findings: Findings) -> list[str]:
    """List the warnings, each once, with the runs that it is about unless it is about all."""
    names_of: dict[str, list[str]] = {}
    for quantity in _quantities(findings):
        for name, of_run in findings.runs:
            for finding in of_run:
                if finding.quantity == quantity and finding.warning:
                    names_of.setdefault(f"{quantity}: {finding.warning}", []).append(name)
    lines = []
    for warning, names in names_of.items():
        some = names if len(names) <= RUNS_ABREAST else [*names[:RUNS_ABREAST], f"{len(names)} runs in all"]
        lines.append(warning + ("" if len(names) == len(findings.runs) else f" ({', '.join(some)})"))
    return lines


def _rows(findings: Findings) -> tuple[list[list[str]], list[list[str]]]:
    """Return the rows that all runs share, and those with a column per run under a row of their names."""
    quantities = _quantities(findings)
    cells = {
        quantity: [next((_cell(f) for f in of_run if f.quantity == quantity), "") for _, of_run in findings.runs]
        for quantity in quantities
    }
    shared = [quantity for quantity in quantities if len(set(cells[quantity])) == 1]
    header = ["", *(name for name, _ in findings.runs)]
    by_run = [[quantity, *cells[quantity]] for quantity in quantities if quantity not in shared]
    of_all = [list(row) for row in findings.of_all]
    return [[quantity, cells[quantity][0]] for quantity in shared] + of_all, [header, *by_run]


def _quantities(findings: Findings) -> list[str]:
    return list(dict.fromkeys(finding.quantity for _, of_run in findings.runs for finding in of_run))


def _cell(finding: Finding) -> str:
    return finding.value + (" !" if finding.warning else "")


def _table(rows: Sequence[Sequence[str]]) -> str:
    """Write rows of cells, columns aligned."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows)
