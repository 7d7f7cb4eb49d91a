"""The table runs.csv of a sweep: a row per run, with its swept values and its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rolling import tables
from rolling.scene.sweep import Value

_METRES = ("ra", "rq", "highest", "lowest")  # statistics of a surface that are lengths
# Numbers of a summary whose key is already the column of another number.
_COLUMNS = {"laeq_uncertainty_db": "laeq_total_uncertainty_db"}


@dataclass(frozen=True)
class Row:
    """A run of a sweep: label, folder, swept values by dotted key, and summary.

    summary : None where too little is solved.
    """

    label: str
    folder: str
    values: Mapping[str, Value]
    summary: Mapping[str, Any] | None


def csv(runs: Sequence[Row]) -> bytes:
    """Write the table of runs.

    The columns are label and folder, the swept keys, and every single number of summary.json with
    its unit; `caveats` has their keys. Third octaves have a table of their own. A run of which too
    little is solved, and a number that does not exist, leave their cells empty.
    """
    rows = [
        {"run": run.label, "folder": run.folder, **run.values, **numbers(run.summary or {})}
        for run in runs
    ]
    return tables.csv_of(rows)


def numbers(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of a summary by the names of their columns.

    The uncertainty of LAeq from the length of the record has the column `laeq_uncertainty_db`, like
    that of any other level; the one with grid and solver has `laeq_total_uncertainty_db`.
    """
    cells: dict[str, Any] = {}
    for key, value in summary.items():
        if key == "caveats":
            cells[key] = " ".join(caveat["key"] for caveat in value)
        elif key == "uncertainty_db":
            cells |= {f"{name}_uncertainty_db": spread for name, spread in value.items()}
        elif key == "surface":
            cells |= {
                f"surface_{name}{'_m' if name in _METRES else ''}": number
                for name, number in value.items()
            }
        elif isinstance(value, Mapping):
            if key == "levelling":
                cells |= {f"levelling_{name}": _cell(inner) for name, inner in value.items()}
        elif key not in ("name", "levelling"):
            cells[_COLUMNS.get(key, key)] = _cell(value)
    return cells


def _cell(value: Any) -> Any:
    """Return a value as the table writes it: nothing for None, true or false as in JSON."""
    return str(value).lower() if isinstance(value, bool) else value
