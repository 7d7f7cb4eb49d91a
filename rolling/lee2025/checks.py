"""A statement is judged part by part: parts that hold or fail, and the verdict that follows from them. Depends on nothing.

A part may be unsure, where the grid, the number of surfaces or the length of the record could turn it: then so may the verdict.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

REPRODUCED, PARTLY, NOT, NOT_RUN = "reproduced", "partly", "not", "not run"
# A verdict that the grid's error, the number of surfaces or the length of the record may turn into another one.
UNDECIDED = "undecided"
GRID, SURFACES, RECORD = "the grid", "the number of surfaces", "the length of the record"


@dataclass(frozen=True)
class Check:
    """A part of a statement. holds : None where there are no cases to tell. near : it does not, but is not far from it.

    unsure : GRID, SURFACES or RECORD where that may turn it into its contrary; empty: nothing known does.
    """

    place: str
    holds: bool | None
    measured: str = ""
    numbers: Any = None
    near: bool = False
    unsure: str = ""


@dataclass(frozen=True)
class Numbers:
    """The measured values of a finding by place, and the places that hold, fail or have no cases."""

    values: dict[str, Any]
    holds: list[str]
    fails: list[str]
    missing: list[str]


@dataclass(frozen=True)
class Finding:
    """Verdict on a statement, what was measured in words, and in numbers: values by place, and which of these hold, fail, miss.

    between : an undecided verdict's least and most favourable one.  decided_by : what decides between these.
    """

    verdict: str
    measured: str
    numbers: Numbers | None = None
    between: list[str] | None = None
    decided_by: str = ""


def concluded(checks: Sequence[Check]) -> Finding:
    """Reproduced if all parts hold that can be told, partly if some hold or are near, not if none, else not run.

    Undecided if parts that are unsure could turn that into another verdict.
    """
    known = [check for check in checks if check.holds is not None]
    missing = [check.place for check in checks if check.holds is None]
    if not known:
        return Finding(NOT_RUN, f"no cases to tell: {', '.join(missing)}" if missing else "no cases to tell")
    kept = [check.place for check in known if check.holds]
    failed = [check.place for check in known if not check.holds]
    verdict = _verdict(known)
    unsure = [check for check in known if check.unsure]
    least, most = (
        _verdict([replace(check, holds=all_hold) if check.unsure else check for check in known])
        for all_hold in (False, True)
    )
    words = ["; ".join(f"{check.place}: {check.measured}" for check in known)]
    if kept and failed:
        words.append(f"holds: {', '.join(kept)}; does not: {', '.join(failed)}")
    if missing:
        words.append(f"no cases to tell: {', '.join(missing)}")
    values = {check.place: check.numbers for check in known}
    numbers = Numbers(values, kept, failed, missing)
    if least == most:
        return Finding(verdict, ". ".join(words), numbers)
    causes = " and ".join(dict.fromkeys(check.unsure for check in unsure))
    places = ", ".join(check.place for check in unsure)
    words.append(f"As measured: {verdict}; {causes} may turn it ({places}): between {least} and {most}")
    return Finding(UNDECIDED, ". ".join(words), numbers, [least, most], causes)


def _verdict(known: Sequence[Check]) -> str:
    if all(check.holds for check in known):
        return REPRODUCED
    return PARTLY if any(check.holds or check.near for check in known) else NOT


def doubt(value: float, holds: Callable[[float], bool], grid: tuple[float, float], error: float) -> str:
    """Return the cause for which a value may fail a test that it passes, or pass one that it fails; empty: there is none.

    grid : what the grid may add to the value, from the least to the most.  error : its standard error over the surfaces.
    """
    for cause, (low, high) in ((GRID, grid), (SURFACES, (grid[0] - 2 * error, grid[1] + 2 * error))):
        if any(holds(float(value + more)) != holds(value) for more in np.linspace(low, high, 41)):
            return cause
    return ""
