"""Table of a choice: one row per candidate, the quietest first."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from rolling.choice.comparison import ChoiceNumbers
from rolling.choice.words import probability
from rolling.numbers.quantity import uncertain
from rolling.terminal.streams import columns

if TYPE_CHECKING:
    import pandas as pd


def rows(choice: ChoiceNumbers) -> list[dict[str, Any]]:
    """Return the numbers of each candidate by the names of their columns.

    The differences are those from the quietest candidate, and None in its own row.
    """
    found = []
    for number, contender in enumerate(choice.contenders):
        apart = choice.differences[number - 1] if number else None
        scatter = None
        if len(contender.heard) > 1 and math.isfinite(contender.level_db):
            scatter = float(np.std(contender.levels_db, ddof=1))
        row: dict[str, Any] = {
            "candidate": contender.label,
            "vibration_db": contender.level_db if math.isfinite(contender.level_db) else None,
            "scatter_db": scatter,
            "louder_db": None,
            "louder_uncertainty_db": None,
            "sureness": None,
            "audible": None,
            "n5_difference_percent": None,
            "n5_difference_uncertainty_percent": None,
            "released_power_db": contender.released_power_db,
            "released_power_higher_db": None,
            "released_power_higher_uncertainty_db": None,
        }
        if apart is not None:
            row["louder_db"] = apart.db
            row["louder_uncertainty_db"] = apart.uncertainty_db
            row["sureness"] = apart.sureness
            row["released_power_higher_db"] = apart.released_db
            row["released_power_higher_uncertainty_db"] = apart.released_uncertainty_db
            for part, size in apart.parts_db.items():
                row[f"{part}_part_db"] = size if math.isfinite(size) else None
            row["uncertainty_left_out"] = " ".join(apart.left_out_db)
        if number and choice.audible:
            judged = choice.audible[number - 1].audibility
            if judged is not None:
                row["audible"] = judged.verdict
                row["n5_difference_percent"] = judged.difference_percent
                row["n5_difference_uncertainty_percent"] = judged.uncertainty_percent
        row["specimens"] = len(contender.heard)
        row["left_out"] = len(choice.omitted)
        found.append(row)
    return found


def frame(choice: ChoiceNumbers) -> pd.DataFrame:
    """Return the table as a DataFrame."""
    import pandas as pd

    return pd.DataFrame(rows(choice))


HEADS = (
    "candidate",
    "vibration, mean, dB(A)",
    "louder than the quietest, dB(A)",
    "sure",
    "in the room",
    "released power, upper bound, dB(A)",
    "higher than of the quietest, dB",
)


def cells(choice: ChoiceNumbers) -> list[list[str]]:
    """Return head and rows of the table in words."""
    found = [[*HEADS]]
    for row in rows(choice):
        sure = "-"
        if row["sureness"] is not None:
            sure = probability(row["sureness"])
        found.append(
            [
                row["candidate"],
                _uncertain(row["vibration_db"], None),
                _uncertain(row["louder_db"], row["louder_uncertainty_db"]),
                sure,
                row["audible"] or "-",
                _uncertain(row["released_power_db"], None),
                _uncertain(
                    row["released_power_higher_db"], row["released_power_higher_uncertainty_db"]
                ),
            ]
        )
    return found


def lines(choice: ChoiceNumbers) -> str:
    """Write the table in columns for a terminal, without the difference of released powers."""
    _, *found = cells(choice)
    heads = [
        ["", "vibration", "louder than", "sure", "in the room", "released power"],
        ["", "mean, dB(A)", "the quietest, dB(A)", "", "", "upper bound, dB(A)"],
    ]
    return columns([*heads, *(row[:-1] for row in found)])


def _uncertain(db: float | None, uncertainty_db: float | None) -> str:
    """Write decibels with their ±, `-` where there are none."""
    return "-" if db is None else uncertain(db, uncertainty_db)
