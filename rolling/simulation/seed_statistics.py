"""Statistics of runs that differ in their seed alone, beside the uncertainty that each states.

A sweep of seeds repeats an experiment. Its spread tests the uncertainty that one record states.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from acoustics.bands import BAND_NAMES
from rolling import tables
from rolling.simulation.runs_table import Row, numbers

SEED = "surface.seed"
# Levels of summary.json, with the columns of their stated standard uncertainty.
LEVELS = {
    "laeq_db": "laeq_uncertainty_db",
    "level_db": "level_uncertainty_db",
    "laf_max_db": "laf_max_uncertainty_db",
    "las_max_db": "las_max_uncertainty_db",
    "lz_peak_db": "lz_peak_uncertainty_db",
    "steady_level_db": "steady_uncertainty_db",
}
BANDS = ("third_octave_db", "third_octave_a_db")
_BAND_UNCERTAINTY = "third_octave_uncertainty_db"


@dataclass(frozen=True)
class Statistic:
    """A number of several runs that differ in their seed alone.

    runs : int. Number of runs that have it.
    mean : float.
    deviation : float. Standard deviation over the seeds; None for a single run.
    error : float. Standard error of the mean; None for a single run.
    stated : float. Root mean square of the standard uncertainties that the runs state; None
        without.
    """

    runs: int
    mean: float
    deviation: float | None
    error: float | None
    stated: float | None

    @property
    def ratio(self) -> float | None:
        """The deviation over the stated uncertainty: about 1 where the statement holds."""
        return self.deviation / self.stated if self.deviation is not None and self.stated else None


@dataclass(frozen=True)
class Group:
    """Runs of a sweep that share all swept values except the seed.

    values : dict. The shared values by dotted key.
    rows : list of Row. The runs.
    """

    values: dict[str, Any]
    rows: list[Row]

    def of(self, name: str, stated: str | None = None) -> Statistic | None:
        """Return the statistic of a column of runs.csv; None where no run has the number."""
        cells = [numbers(row.summary) for row in self.rows if row.summary is not None]
        return statistic((cell.get(name), cell.get(stated or "")) for cell in cells)

    def of_band(self, kind: str, band: str) -> Statistic | None:
        """Return the statistic of a third octave."""
        summaries = [row.summary for row in self.rows if row.summary is not None]
        return statistic(
            (summary[kind].get(band), summary[_BAND_UNCERTAINTY].get(band)) for summary in summaries
        )


def statistic(pairs: Iterable[tuple[Any, Any]]) -> Statistic | None:
    """Return mean and spread of numbers that stand with their stated uncertainty."""
    known = [(value, stated) for value, stated in pairs if _is_number(value)]
    if not known:
        return None
    values = np.array([value for value, _ in known], dtype=float)
    stated = np.array([spread for _, spread in known if _is_number(spread)], dtype=float)
    several = len(values) > 1
    deviation = float(values.std(ddof=1)) if several else None
    return Statistic(
        len(values),
        float(values.mean()),
        deviation,
        deviation / math.sqrt(len(values)) if deviation is not None else None,
        float(np.sqrt((stated**2).mean())) if len(stated) else None,
    )


def groups(rows: Sequence[Row], over: str = SEED) -> list[Group]:
    """Gather the runs that differ in the key `over` alone, in the order of the sweep."""
    made: dict[tuple[Any, ...], Group] = {}
    for row in rows:
        values = {key: value for key, value in row.values.items() if key != over}
        made.setdefault(tuple(values.items()), Group(values, [])).rows.append(row)
    return list(made.values())


def csv(of: Sequence[Group]) -> bytes:
    """Write the statistics of levels and third octaves: a row for each of them and each group."""
    rows = []
    for group in of:
        named = [(name, "", group.of(name, stated)) for name, stated in LEVELS.items()]
        named += [(kind, band, group.of_band(kind, band)) for kind in BANDS for band in BAND_NAMES]
        rows += [
            {**group.values, "level": name, "band_hz": band, **_cells(number)}
            for name, band, number in named
            if number is not None
        ]
    return tables.csv_of(rows)


def bands_csv(rows: Sequence[Row]) -> bytes:
    """Write the third octaves of all runs: a row for each band of each run."""
    lines = []
    for row in rows:
        if row.summary is None:
            continue
        for band in BAND_NAMES:
            cells = {kind: row.summary[kind].get(band) for kind in (*BANDS, _BAND_UNCERTAINTY)}
            lines.append({"run": row.label, **row.values, "band_hz": band, **cells})
    return tables.csv_of(lines)


def _cells(number: Statistic) -> dict[str, Any]:
    return {
        "runs": number.runs,
        "mean": number.mean,
        "standard_deviation": number.deviation,
        "standard_error": number.error,
        "stated_uncertainty": number.stated,
        "deviation_over_stated": number.ratio,
    }


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
