"""Tables of text: Markdown, aligned columns for a terminal, and CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Mapping, Sequence
from typing import Any


def markdown(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    padded: bool = False,
    right: Collection[int] = (),
) -> str:
    """Write a table in Markdown.

    Parameters
    ----------
    head : sequence of str
        Titles of the columns.
    rows : sequence of sequences of str
        Cells. A row with fewer cells ends with a remark, which widens no column.
    padded : bool
        If true, all cells of a column have the same width. Default: false.
    right : collection of int
        Columns of numbers, which are aligned to the right where padded. Default: none.
    """
    if not padded:
        return "\n".join(f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *rows))
    count = len(head)
    widths = [max(3, len(title)) for title in head]
    for row in rows:
        cells = row if len(row) == count else row[:-1]
        widths[: len(cells)] = [
            max(width, len(cell)) for width, cell in zip(widths, cells, strict=False)
        ]
    rule = [
        "-" * (width - 1) + ":" if k in right else "-" * width for k, width in enumerate(widths)
    ]
    full = [head, rule, *([*row, *[""] * (count - len(row))] for row in rows)]
    lines = [
        [
            cell.rjust(width) if k in right else cell.ljust(width)
            for k, (cell, width) in enumerate(zip(line, widths, strict=True))
        ]
        for line in full
    ]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def columns(rows: Sequence[Sequence[str]]) -> str:
    """Write rows of equal length in aligned columns, two spaces apart, for a terminal."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        for row in rows
    ]
    return "\n".join(line.rstrip() for line in lines)


def csv_of(rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Write rows as CSV with the columns of all rows; a cell that a row lacks is empty."""
    stream = io.StringIO()
    names = list(dict.fromkeys(name for row in rows for name in row))
    writer = csv.DictWriter(stream, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue().encode()
