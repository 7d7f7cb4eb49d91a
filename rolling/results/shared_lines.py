"""Lines that the terminal prints about runs of every kind: their doubts, and their sounds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from acoustics.texts import printable
from rolling.kinds.run_folder import SUMMARY, RunFolder
from rolling.numbers.doubt import Doubt
from rolling.results.labels import labels
from rolling.results.stored_numbers import numbers_of
from rolling.terminal import progress
from rolling.terminal.streams import folded

MOST_DOUBTS = 4  # that are printed unless all are asked for


def numbered_runs(runs: Sequence[RunFolder]) -> list[tuple[str, Any]]:
    """Return labels and numbers of the runs that are solved."""
    stored = zip(labels(runs), map(numbers_of, runs), strict=True)
    return [(label, numbers) for label, numbers in stored if numbers is not None]


def doubt_lines(done: Sequence[RunFolder]) -> list[str]:
    """Return each kind of doubt at its worst, the worst first; all of them if verbose."""
    every: list[Doubt] = []
    for run in done:
        numbers = numbers_of(run)
        every += () if numbers is None else numbers.doubts
    every.sort(key=lambda doubt: doubt.rank, reverse=True)
    by_key: dict[str, Doubt] = {}
    for doubt in every:
        by_key.setdefault(doubt.key, doubt)
    doubts = list(by_key.values())
    shown = doubts if progress.is_verbose() else doubts[:MOST_DOUBTS]
    lines = [folded(f"doubt: {doubt.line}.") for doubt in shown]
    if len(doubts) > len(shown):
        lines.append(f"{len(doubts) - len(shown)} more on the page and in {SUMMARY}")
    return lines


def listen_lines(done: Sequence[RunFolder], sounds: Sequence[tuple[str, str, str]]) -> list[str]:
    """Name the sounds of the first run that a person opens first.

    Parameters
    ----------
    done : sequence of RunFolder. Runs that are done.
    sounds : sequence of tuple. What to do, the name of a file, and what is heard, which may be
        empty. A sound without a file is left out; the label of the run stands beside the first one
        if there are several runs.
    """
    first = done[0]
    lines: list[str] = []
    for act, name, content in sounds:
        path = first.folder / name
        if not path.is_file():
            continue
        remarks = [content] if content else []
        if len(done) > 1 and not lines:
            remarks.insert(0, labels(done)[0])
        line = f"{act}: {printable(str(path))}"
        lines.append(f"{line} ({', '.join(remarks)})" if remarks else line)
    return lines
