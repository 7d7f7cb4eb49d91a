"""Conditions of scenes by their kind, and the file that has them beside an answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rolling.kinds.registry import kind_of
from rolling.numbers.conditions import Conditions, Method
from rolling.terminal import whole_files

if TYPE_CHECKING:
    from pandas import DataFrame


def conditions_of(scenes: Mapping[str, Any]) -> Conditions:
    """Return the conditions of scenes without a sweep, by their labels; none of a missing scene."""
    known = {label: scene for label, scene in scenes.items() if scene is not None}
    method = Method(motion="", computed="")
    for scene in known.values():
        method = kind_of(scene).method(scene)
    by_label = {label: [*kind_of(scene).conditions(scene)] for label, scene in known.items()}
    return Conditions(by_label=by_label, method=method)


def with_conditions(table: DataFrame, conditions: Conditions, labels: Sequence[str]) -> DataFrame:
    """Return a table with a column for each condition at its end, as a file has it.

    Without conditions it stays as it is.

    Parameters
    ----------
    table : DataFrame
        The table.
    conditions : Conditions
        The conditions.
    labels : sequence of str
        Label of the scene of each row.
    """
    if not conditions.by_label:
        return table
    rows = [conditions.columns(label) for label in labels]
    names = dict.fromkeys(name for row in rows for name in row)
    columns = {name: [row.get(name, "") for row in rows] for name in names}
    return table.assign(**columns)


def write_answer_file(
    path: Path, sentences: Sequence[str], conditions: Conditions, methods: str
) -> None:
    """Write an answer with its conditions and the paragraph on methods as JSON."""
    content = {
        "program": conditions.program,
        "sentences": [*sentences],
        "conditions": conditions.as_json(),
        "methods": methods,
    }
    whole_files.write_json(path, content)
