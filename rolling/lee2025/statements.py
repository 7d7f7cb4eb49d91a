"""Verdicts on the statements of Lee, Kim & Kim (2025), which statements.toml lists in our words."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from typing import Any

import pandas as pd

from rolling.lee2025 import conditions
from rolling.lee2025.conditions import NOT_RUN, OUTLOOK, ROUGHNESS

Statement = dict[str, Any]  # a table of statements.toml, whose head explains its keys

STATEMENTS: list[Statement] = tomllib.loads(
    files("rolling.lee2025").joinpath("statements.toml").read_text(encoding="utf-8")
)["statement"]
SCALES = (10, 20)  # factors of the logarithm in the level of a release power
WORDS = ["key", "source", "sentence", "criterion"]
COLUMNS = ["key", "source", "statement", "criterion", "reading", "scale", "verdict", "measured"]


def outlook(statement: Statement) -> str | None:
    """Return the column of the article's outlook that a statement concerns."""
    return next((name for name in OUTLOOK if name in statement["condition"].values()), None)


def judge(statement: Statement, cases: pd.DataFrame, scale: int) -> tuple[str, str]:
    """Return the verdict of a reading's cases on a statement, and the measured numbers."""
    if conditions.swept(cases) != outlook(statement):
        return NOT_RUN, ""
    if "roughnesses_um" in statement:
        cases = cases[cases[ROUGHNESS].isin(statement["roughnesses_um"])]
    arguments = dict(statement["condition"])
    condition = getattr(conditions, arguments.pop("name"))
    comparisons = [*condition(cases, statement["column"].format(scale=scale), **arguments)]
    measured = "; ".join(f"{place.place}: {place.measured}" for place in comparisons)
    return conditions.verdict(comparisons), measured


def verdicts(readings: dict[str, pd.DataFrame]) -> pd.DataFrame:
    """Judge all statements by the cases of each reading, with each scale of levels.

    Returns a row for each statement, reading and scale; the scale is 0 without levels.
    """
    rows = [
        (*(statement[word] for word in WORDS), reading, scale, *judge(statement, cases, scale))
        for statement in STATEMENTS
        for reading, cases in readings.items()
        for scale in (SCALES if "{scale}" in statement["column"] else (0,))
    ]
    return pd.DataFrame(rows, columns=COLUMNS)
