"""What holds of the article over all its readings, and what each explains. Depends on checks; judges no single case.

A statement stands where every reading says the same of it. No reading is named as the best unless it leads by `LEAD` statements.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rolling.lee2025.checks import NOT, NOT_RUN, PARTLY, REPRODUCED, UNDECIDED

WORTH = {REPRODUCED: 1.0, PARTLY: 0.5, NOT: 0.0}
WORDS = (REPRODUCED, PARTLY, NOT, UNDECIDED, NOT_RUN)
LEAD = 2.0  # statements by which a reading must lead all others, whatever undecided verdicts turn out to be
EVERY, PART, NONE, OPEN, DIFFERS, UNKNOWN = "every", "part", "none", "undecided", "differs", "not run"


def standing(rows: Sequence[dict[str, Any]], readings: Sequence[str]) -> dict[str, list[str]]:
    """Sort the keys of all statements by their verdicts in these readings, with either scale of levels.

    Returns
    -------
    every, part, none : reproduced, partly or not in each reading. undecided : in one reading at least, while the rest would
    let it be any of these. differs : depends on the reading or on the scale of levels. not run : in no reading.
    """
    found: dict[str, list[str]] = {name: [] for name in (EVERY, PART, NONE, OPEN, DIFFERS, UNKNOWN)}
    same = {REPRODUCED: EVERY, PARTLY: PART, NOT: NONE}
    for row in rows:
        findings = [one for one in row["findings"] if one["reading"] in readings and one["verdict"] != NOT_RUN]
        firm = {one["verdict"] for one in findings if one["verdict"] != UNDECIDED}
        if not findings:
            found[UNKNOWN].append(row["key"])
        elif len(firm) > 1:
            found[DIFFERS].append(row["key"])
        elif len(firm) < len({one["verdict"] for one in findings}):
            found[OPEN].append(row["key"])
        else:
            found[same[firm.pop()]].append(row["key"])
    return found


def scores(rows: Sequence[dict[str, Any]], readings: Sequence[str], scales: Sequence[int]) -> list[dict[str, Any]]:
    """Score each reading and scale: 1 for a statement reproduced, half for partly, of those that were judged, highest first.

    An undecided verdict counts as its less and as its more favourable one: `least` and `most`.
    """
    found: list[dict[str, Any]] = []
    for reading in readings:
        for scale in scales:
            told = {
                row["key"]: one
                for row in rows
                for one in row["findings"]
                if not row["outlook"] and one["reading"] == reading and one["scale"] in (None, scale)
            }
            ends = [_worth(one) for one in told.values()]
            words = [one["verdict"] for one in told.values()]
            found.append(
                {
                    "reading": reading,
                    "scale": scale,
                    "least": sum(least for least, _ in ends),
                    "most": sum(most for _, most in ends),
                    "counts": {word: words.count(word) for word in WORDS},
                    "judged": len(words) - words.count(NOT_RUN),
                }
            )
    return sorted(found, key=lambda one: -one["least"] - one["most"])


def leader(table_scores: Sequence[dict[str, Any]]) -> dict[str, Any] | None:
    """Return the score that leads those of all other readings by `LEAD` statements or more; None: there is none."""
    for one in table_scores:
        others = [other for other in table_scores if other["reading"] != one["reading"]]
        if others and all(one["least"] - other["most"] >= LEAD for other in others):
            return one
    return None


def _worth(finding: dict[str, Any]) -> tuple[float, float]:
    if finding["between"]:
        least, most = finding["between"]
        return WORTH[least], WORTH[most]
    return (WORTH.get(finding["verdict"], 0.0),) * 2
