"""The table of all numbers of runs, a view over the fields of the numbers, with its words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from acoustics.numbers import bracketed
from rolling.kinds.registry import kind_of
from rolling.results.level_words import SILENT
from rolling.results.run_quantities import LAE, level_beside, measure
from rolling.results.run_result import Run

A_ABOVE_Z = (
    "LAeq above LZeq",
    "the A-weighting follows the ear, which is most sensitive between 1 and 6 kHz, and raises "
    "sound there by up to 1.3 dB.",
)


class TableRow(NamedTuple):
    """A number of each run, as text, below the name and unit of the number."""

    head: str
    cells: list[str]


class NumberTable(NamedTuple):
    """The table of all numbers of runs: their labels, a row for each number, words explained."""

    labels: list[str]
    rows: list[TableRow]
    explained: list[tuple[str, str]]


def number_table(runs: Sequence[Any]) -> NumberTable:
    """Return the table of all numbers of runs, and the words in it at which a stranger stumbles."""
    numbers = [run.numbers for run in runs]
    labels = [run.label or run.scene.name for run in runs]
    rows = kind_of(runs[0].scene).number_rows(numbers)
    words = [
        (row.number_field.word, row.number_field.explained)
        for row in rows
        if row.number_field.explained
    ]
    words = list(dict.fromkeys(words))
    if any(map(_is_raised_by_a_weighting, runs)):
        words.append(A_ABOVE_Z)
    return NumberTable(labels, [TableRow(row.head, row.cells) for row in rows], words)


def _is_raised_by_a_weighting(run: Any) -> bool:
    """Tell whether the A-weighted level of a run lies above that without weighting."""
    a_weighted = getattr(run, "record_laeq_db", None)  # a kind need not have any
    if a_weighted is None or run.numbers.of_record.level_db is None:
        return False
    return bool(a_weighted > run.numbers.of_record.level_db)


# ---- several listeners


class ListenerRow(NamedTuple):
    """Levels of a run at one of several listeners, as text."""

    head: str
    place: str
    a_weighted: str
    unweighted: str


def listeners(runs: Sequence[Run]) -> list[ListenerRow]:
    """Return the levels at the listeners of runs that have several."""
    rows = []
    for run in runs:
        own = run.numbers.levels.listeners or ()
        if len(own) < 2:
            continue
        for listener in own:
            place = f"{bracketed(listener.at_mm)} mm"
            if len(runs) > 1:
                place = f"{run.label}: {place}"
            row = ListenerRow(
                head="LAE (re 1 s)" if measure(run.numbers) == LAE else "LAeq",
                place=place,
                a_weighted=_level_or_silent(level_beside(run.numbers, listener.laeq_db)),
                unweighted=_level_or_silent(listener.level_db),
            )
            rows.append(row)
    return rows


def _level_or_silent(level_db: float | None) -> str:
    """Write a level [dB], or that there is no sound."""
    return SILENT if level_db is None else f"{level_db:.1f}"
