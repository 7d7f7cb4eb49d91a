"""The table runs.csv of a sweep: a row per run, with its swept values and its numbers."""

from __future__ import annotations

import csv as tables
import io
from collections.abc import Mapping, Sequence
from typing import Any

Row = tuple[str, Mapping[str, float], Mapping[str, Any] | None]  # folder, values, summary


def csv(runs: Sequence[Row]) -> bytes:
    """Write the table of runs.

    The columns are the folder, the swept keys, and every single number of summary.json; a number of
    a group, such as an uncertainty, has the group's name before its own. The column `caveats` has
    their keys. A run of which too little is solved, and a number that does not exist, leave their
    cells empty.

    Parameters
    ----------
    runs : Folder, swept values by dotted key, and summary of each run; None: too little is solved.
    """
    rows = [
        {"folder": folder, **values, **(_numbers(summary) if summary is not None else {})}
        for folder, values, summary in runs
    ]
    stream = io.StringIO()
    columns = list(dict.fromkeys(name for row in rows for name in row))
    writer = tables.DictWriter(stream, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return stream.getvalue().encode()


def _numbers(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of a summary by the names of their columns."""
    numbers: dict[str, Any] = {}
    for key, value in summary.items():
        if key == "caveats":
            numbers[key] = " ".join(caveat["key"] for caveat in value)
        elif isinstance(value, Mapping):
            numbers |= {f"{key}.{name}": _cell(inner) for name, inner in value.items()}
        else:
            numbers[key] = _cell(value)
    return numbers


def _cell(value: Any) -> Any:
    """Return a value as the table writes it: nothing for None, true or false as in JSON."""
    return str(value).lower() if isinstance(value, bool) else value
