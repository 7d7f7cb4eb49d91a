"""Titles, notes and remarks of the pictures of runs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from rolling._typing import Array
from rolling.simulation.run_result import RunResult

_NAMED_SCENES = 4  # scenes named in a title; more scenes are counted


def subject(runs: Sequence[RunResult]) -> str:
    """Name the scenes of runs, or count the scenes if there are many.

    A single run is named by its title.
    """
    if len(runs) == 1:
        return runs[0].title
    names = dict.fromkeys(run.scene.name for run in runs)
    return ", ".join(names) if len(names) <= _NAMED_SCENES else f"{len(names)} scenes"


def distance(runs: Iterable[RunResult]) -> str:
    """Write the distance of the listener."""
    return common("at", [run.scene.sound.distance_m for run in runs], "m")


def duration(runs: Iterable[RunResult]) -> str:
    """Write the duration of the records."""
    return common("T =", [run.sound.duration for run in runs], "s")


def common(word: str, values: Sequence[float], unit: str = "") -> str:
    """Write the value that all runs share, or its range: at 1 m, at 1 to 2 m."""
    ends = dict.fromkeys(number(value) for value in (min(values), max(values)))
    return f"{word} {' to '.join(ends)} {unit}".rstrip()


def number(value: float) -> str:
    """Write a number with three digits, or with all digits before the decimal point."""
    return f"{value:,.0f}" if value >= 1000 else f"{value:.3g}"


def note(facts: Iterable[str]) -> str:
    """Join facts to the line below a title."""
    return "; ".join(facts)


def gaps(values: Iterable[float | None]) -> Array:
    """Return values as a column of a table, with NaN in place of None."""
    return np.array([np.nan if value is None else value for value in values])
