"""Verdicts on statements, which follow from parts that hold or fail.

A part is unsure if the grid, the number of surfaces or the length of the record could turn it. The
verdict may then be unsure, too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

REPRODUCED, PARTLY, NOT, NOT_RUN = "reproduced", "partly", "not", "not run"
# The grid's error, the number of surfaces or the length of the record may turn this verdict into
# another verdict.
UNDECIDED = "undecided"
Place = tuple[float, float]  # roughness Ra [um] and load [N] of a case
GRID, SURFACES, RECORD = "the grid", "the number of surfaces", "the length of the record"


@dataclass(frozen=True)
class Check:
    """A part of a statement.

    Parameters
    ----------
    place : str. The loads or roughnesses of the part.
    holds : bool or None. None without suitable cases.
    measured : str. The measured numbers, in words. Default: empty.
    numbers : any. The measured numbers. Default: None.
    near : bool. True if it nearly holds. Default: False.
    unsure : str. GRID, SURFACES or RECORD if that may turn it. Default: empty.
    places : tuple of Place. The cases that it compares, if the grid may turn it. Default: none.
    """

    place: str
    holds: bool | None
    measured: str = ""
    numbers: Any = None
    near: bool = False
    unsure: str = ""
    places: tuple[Place, ...] = ()


@dataclass(frozen=True)
class Numbers:
    """The measured values of a finding by place.

    It also lists the places that hold, fail or have no cases.
    """

    values: dict[str, Any]
    holds: list[str]
    fails: list[str]
    missing: list[str]


@dataclass(frozen=True)
class FinerGrid:
    """The verdict at half the spacing, where the grid might turn it.

    Parameters
    ----------
    before, after : str. Verdicts with the study's own numbers and with the changes at half the
        spacing, both without the grid's error.
    places : tuple of Place. The cases that were solved at half the spacing.
    """

    before: str
    after: str
    places: tuple[Place, ...]

    @property
    def turns(self) -> bool:
        """True if the verdict changes."""
        return self.before != self.after


@dataclass(frozen=True)
class Finding:
    """The verdict on a statement, with the measured numbers.

    Parameters
    ----------
    verdict : str. REPRODUCED, PARTLY, NOT, UNDECIDED or NOT_RUN.
    measured : str. The measured numbers, in words.
    numbers : Numbers or None. The same as data. Default: None.
    between : list of str or None. The less and the more favourable end of an undecided verdict.
        Default: None.
    decided_by : str. The cause of an undecided verdict. Default: empty.
    grid_places : tuple of Place. The cases of the parts that the grid may turn. Default: none.
    finer : FinerGrid or None. The verdict at half the spacing. Default: None, if not checked.
    """

    verdict: str
    measured: str
    numbers: Numbers | None = None
    between: list[str] | None = None
    decided_by: str = ""
    grid_places: tuple[Place, ...] = ()
    finer: FinerGrid | None = None


def concluded(checks: Sequence[Check]) -> Finding:
    """Derive the verdict from all parts of a statement.

    It is reproduced if all known parts hold, partly if some hold or are near, else not. Without
    known parts it is not run. It is undecided if unsure parts could turn it into another verdict.
    """
    known = [check for check in checks if check.holds is not None]
    missing = [check.place for check in checks if check.holds is None]
    if not known:
        return Finding(NOT_RUN, f"no cases for {', '.join(missing)}" if missing else "no cases")
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
        words.append(f"no cases for {', '.join(missing)}")
    values = {check.place: check.numbers for check in known}
    numbers = Numbers(values, kept, failed, missing)
    if least == most:
        return Finding(verdict, ". ".join(words), numbers)
    causes = " and ".join(dict.fromkeys(check.unsure for check in unsure))
    places = ", ".join(check.place for check in unsure)
    words.append(
        f"As measured: {verdict}; {causes} may turn it ({places}): between {least} and {most}"
    )
    turned_by_grid = dict.fromkeys(
        place for check in unsure if check.unsure == GRID for place in check.places
    )
    return Finding(
        UNDECIDED, ". ".join(words), numbers, [least, most], causes, tuple(turned_by_grid)
    )


def _verdict(known: Sequence[Check]) -> str:
    """Return the verdict from all known parts."""
    if all(check.holds for check in known):
        return REPRODUCED
    return PARTLY if any(check.holds or check.near for check in known) else NOT


def doubt(
    value: float, holds: Callable[[float], bool], grid: tuple[float, float], error: float
) -> str:
    """Return the cause for which the result of a test on a value may be wrong.

    Parameters
    ----------
    value : float. The tested value.
    holds : function from a value to bool. The test.
    grid : pair of float. The lowest and the highest change that a fine grid may bring.
    error : float. Standard error of the value over the surfaces.

    Returns
    -------
    GRID, SURFACES, or an empty string without a cause.
    """
    for cause, (low, high) in (
        (GRID, grid),
        (SURFACES, (grid[0] - 2 * error, grid[1] + 2 * error)),
    ):
        if any(holds(float(value + more)) != holds(value) for more in np.linspace(low, high, 41)):
            return cause
    return ""
