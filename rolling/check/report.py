"""Findings of all runs of a scene as a sequence, as text and as HTML."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from typing import NamedTuple, overload

from rolling import tables
from rolling.check.finding import Finding

RUNS_ABREAST = 5  # columns of the table


class RunFindings(NamedTuple):
    """Findings of one run and its name: the swept values, or the name of the scene."""

    name: str
    findings: list[Finding]


@dataclass(frozen=True, repr=False)
class Findings(Sequence[Finding]):
    """Findings of all runs of a scene, one run after the other; printed, they are a table.

    Attributes
    ----------
    runs : tuple of RunFindings
        Findings by run.
    of_all : tuple of (str, str)
        Time, memory and disk of all runs together; empty for a single run.
    excess : tuple of str
        Warnings where all runs together need too much memory or disk.
    """

    runs: tuple[RunFindings, ...]
    of_all: tuple[tuple[str, str], ...] = ()
    excess: tuple[str, ...] = ()

    @property
    def warnings(self) -> list[str]:
        """Warnings in words, each once; empty where nothing is doubtful."""
        return [*self.excess, *warnings(self)]

    def __len__(self) -> int:
        return sum(len(run.findings) for run in self.runs)

    def __iter__(self) -> Iterator[Finding]:
        return (finding for run in self.runs for finding in run.findings)

    @overload
    def __getitem__(self, index: int) -> Finding: ...
    @overload
    def __getitem__(self, index: slice) -> list[Finding]: ...
    def __getitem__(self, index: int | slice) -> Finding | list[Finding]:
        return list(self)[index]

    def __str__(self) -> str:
        return text(self)

    __repr__ = __str__  # the table at a prompt

    def _repr_html_(self) -> str:
        return html(self)


def text(findings: Findings) -> str:
    """Write the shared values, then a column per run, then the warnings."""
    shared, by_run = _rows(findings)
    blocks = [tables.columns(shared)]
    if len(by_run) > 1:
        columns = range(1, len(findings.runs) + 1, RUNS_ABREAST)
        blocks += [
            tables.columns([[row[0], *row[k : k + RUNS_ABREAST]] for row in by_run])
            for k in columns
        ]
    return "\n\n".join(
        filter(None, [*blocks, "\n".join(f"warning: {line}" for line in findings.warnings)])
    )


def html(findings: Findings) -> str:
    """Write the same tables and warnings as HTML."""
    shared, by_run = _rows(findings)
    tables = [shared, by_run] if len(by_run) > 1 else [shared]
    parts = []
    for rows in tables:
        lines = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
        parts.append("<table>" + "".join(f"<tr>{line}</tr>" for line in lines) + "</table>")
    if findings.warnings:
        parts.append(
            "<ul>" + "".join(f"<li>{escape(line)}</li>" for line in findings.warnings) + "</ul>"
        )
    return "".join(parts)


def warnings(findings: Findings) -> list[str]:
    """List each warning once, with the runs that it concerns unless it concerns all."""
    names_of: dict[str, list[str]] = {}
    for quantity in _quantities(findings):
        for name, of_run in findings.runs:
            for finding in of_run:
                if finding.quantity == quantity and finding.warning:
                    names_of.setdefault(f"{quantity}: {finding.warning}", []).append(name)
    lines = []
    for warning, names in names_of.items():
        listed = (
            names
            if len(names) <= RUNS_ABREAST
            else [*names[:RUNS_ABREAST], f"{len(names)} runs in all"]
        )
        lines.append(
            warning + ("" if len(names) == len(findings.runs) else f" ({', '.join(listed)})")
        )
    return lines


def _rows(findings: Findings) -> tuple[list[list[str]], list[list[str]]]:
    """Return the rows that all runs share, and the rows with a column per run.

    A row of the names of the runs heads the latter.
    """
    quantities = _quantities(findings)
    cells = {
        quantity: [
            next((_cell(f) for f in of_run if f.quantity == quantity), "")
            for _, of_run in findings.runs
        ]
        for quantity in quantities
    }
    shared = [quantity for quantity in quantities if len(set(cells[quantity])) == 1]
    header = ["", *(name for name, _ in findings.runs)]
    by_run = [[quantity, *cells[quantity]] for quantity in quantities if quantity not in shared]
    of_all = [list(row) for row in findings.of_all]
    return [[quantity, cells[quantity][0]] for quantity in shared] + of_all, [header, *by_run]


def _quantities(findings: Findings) -> list[str]:
    return list(
        dict.fromkeys(finding.quantity for _, of_run in findings.runs for finding in of_run)
    )


def _cell(finding: Finding) -> str:
    return finding.value + (" !" if finding.warning else "")
