"""Lines about runs of any kind for a terminal: sentences, quantities, all numbers."""

from __future__ import annotations

from collections.abc import Sequence

from rolling.kinds.run_folder import RunFolder
from rolling.numbers import views
from rolling.numbers.fields import walk
from rolling.numbers.quantity import Quantity
from rolling.results.shared_lines import numbered_runs
from rolling.terminal.streams import columns, folded


def answer_lines(runs: Sequence[RunFolder]) -> list[str]:
    """Return the sentences of a run, or the quantities of several in aligned columns."""
    solved = numbered_runs(runs)
    if len(solved) == 1:
        ((_, numbers),) = solved
        return [folded(sentence) for sentence in numbers.sentences]
    return [columns(quantity_rows(runs))]


def quantity_rows(runs: Sequence[RunFolder]) -> list[list[str]]:
    """Return the quantities of runs as cells, first the heads, then a row for each run."""
    by_run = {}
    for label, numbers in numbered_runs(runs):
        by_run[label] = {
            leaf.name: str(leaf.value) for leaf in walk(numbers) if isinstance(leaf.value, Quantity)
        }
    heads = list(dict.fromkeys(head for cells in by_run.values() for head in cells))
    rows = [["run", *heads]]
    for label, cells in by_run.items():
        rows.append([label, *(cells.get(head, "-") for head in heads)])
    return rows


def number_lines(runs: Sequence[RunFolder]) -> list[str]:
    """Return all numbers of runs that people read, in aligned columns below the label."""
    lines = []
    for label, numbers in numbered_runs(runs):
        rows = []
        for leaf in views.rows(numbers):
            value = leaf.value
            text = "-" if value is None else leaf.number_field.text(value)
            rows.append([leaf.name, str(value) if isinstance(value, Quantity) else text])
        lines += ["", label]
        if rows:
            lines.append(columns(rows))
    return lines
