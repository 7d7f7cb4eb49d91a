"""Conditions of statements: each compares a column of a reading's cases at several places.

A place is a load, a roughness, or a step between two of them. A change counts if it exceeds twice
its standard error over the surfaces; with one surface any change counts.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd

from acoustics.bands import BAND_NAMES, MID_HZ, band_uncertainty_db, reliable
from acoustics.numbers import rounded
from rolling.studies.lee2025_cases import band_columns

ROUGHNESS = "roughness_um"
LOAD = "load_n"
LENGTH = "correlation_um"
SKEWNESS = "skewness"
FORMS = {ROUGHNESS: "Ra {:g} µm", LOAD: "{:g} N", LENGTH: "{:g} µm", SKEWNESS: "skewness {:g}"}
OUTLOOK = {LENGTH: "correlation_length", SKEWNESS: "skewness"}  # columns and their figures
HOLDS = "holds"
IN_PART = "in part"
FAILS = "does not hold"
NOT_RUN = "not run"

LG_LENGTH_DB = 5.0  # fall of a line of noise in a record ten times as long (10 lg of an amplitude)
LARGE_GAP_DB = 6.0
# From 20 to 50 N the load grows 2.5 times and in the other steps twice, so that a level without
# jumps rises by 1.3 steps.
LARGEST_STEP = 1.5
# Above it a grid of 2 um reads too high where the plate yields.
HIGHEST_BAND_HZ = 4500.0
# By chance every twentieth third octave differs by more than twice its uncertainty.
MIN_SHARE = 1 / 3


@dataclass(frozen=True)
class Comparison:
    """The result of a condition at one place: whether it holds or nearly holds, and its number."""

    place: str
    holds: bool
    measured: str
    near: bool = False


@dataclass(frozen=True)
class Change:
    """The mean change of a column over the surfaces, and twice its standard error."""

    mean: float
    margin: float


def verdict(comparisons: Sequence[Comparison]) -> str:
    """Return the verdict on a statement from its comparisons at all places."""
    if not comparisons:
        return NOT_RUN
    if all(comparison.holds for comparison in comparisons):
        return HOLDS
    partly = any(comparison.holds or comparison.near for comparison in comparisons)
    if partly:
        return IN_PART
    return FAILS


def swept(cases: pd.DataFrame) -> str | None:
    """Return the column of the article's outlook that cases sweep."""
    for column in OUTLOOK:
        if cases[column].nunique() > 1:
            return column
    return None


def label(column: str, value: float) -> str:
    """Write a roughness, a load or a correlation length with its name or unit."""
    return FORMS[column].format(value)


def _place(roughness: float, load: float) -> str:
    """Write a roughness and a load."""
    return f"{label(ROUGHNESS, roughness)}, {label(LOAD, load)}"


def change(
    cases: pd.DataFrame, column: str, start: dict[str, float], end: dict[str, float]
) -> Change | None:
    """Compute the change between two settings, surface by surface; None without common surfaces."""

    def by_surface(settings: dict[str, float]) -> pd.Series:
        """Return the column of the cases with some settings, by surface."""
        chosen = np.logical_and.reduce([cases[name] == value for name, value in settings.items()])
        return cases[chosen].set_index("seed")[column]

    changes = (by_surface(end) - by_surface(start)).dropna()
    count = len(changes)
    if not count:
        return None
    margin = 0.0
    if count > 1:
        margin = 2 * float(changes.std(ddof=1)) / math.sqrt(count)
    return Change(float(changes.mean()), margin)


def _means(cases: pd.DataFrame, column: str, statistic: str = "mean") -> pd.DataFrame:
    """Return a statistic over the surfaces: a row for each roughness, a column for each load."""
    return cases.groupby([ROUGHNESS, LOAD])[column].agg(statistic).dropna().unstack(LOAD)


# ---- trends


def monotonic(
    cases: pd.DataFrame, column: str, along: str, across: str, sign: int = 1, by_step: bool = False
) -> Iterator[Comparison]:
    """Compare each step of `along` at each value of `across`; every step must rise (or fall).

    A place is a value of `across`, or with `by_step` a step. With a sign of -1 the steps must fall.
    """
    changes: dict[str, list[Change]] = {}
    known = cases.dropna(subset=[column])
    for other, group in known.groupby(across):
        for start, end in pairwise(sorted(group[along].unique())):
            step = change(group, column, {along: start}, {along: end})
            if step is None:
                continue
            place = label(across, other)
            if by_step:
                place = f"{label(along, start)} to {end:g}"
            changes.setdefault(place, []).append(step)
    for place, steps in changes.items():
        yield _steps(place, steps, sign)


def _steps(place: str, steps: Sequence[Change], sign: int) -> Comparison:
    """Compare the steps at a place, which must all rise, or fall with a sign of -1."""
    holds = all(sign * step.mean > step.margin for step in steps)
    return Comparison(place, holds, ", ".join(f"{step.mean:+.3g}" for step in steps))


def lowest(cases: pd.DataFrame, column: str, roughness: float) -> Iterator[Comparison]:
    """Compare one roughness with all others at each load; the column must be lowest there."""
    for load, group in cases.groupby(LOAD):
        others = sorted(set(group[ROUGHNESS]) - {roughness})
        changes = [change(group, column, {ROUGHNESS: ra}, {ROUGHNESS: roughness}) for ra in others]
        steps = [step for step in changes if step is not None]
        if steps:
            yield _steps(label(LOAD, load), steps, -1)


def highest_level(
    cases: pd.DataFrame, column: str, roughness: float, loads: Sequence[float]
) -> Iterator[Comparison]:
    """Compare the means of all roughnesses; one must be highest, or nearly so at some loads.

    It is nearly highest if the lead of the highest does not exceed its margin.
    """
    means = _means(cases, column)
    for load in means.columns.intersection(list(loads)):
        known = means[load].dropna()
        if roughness not in known or len(known) < 2:
            continue
        first = known.idxmax()
        group = cases[cases[LOAD] == load]
        lead = change(group, column, {ROUGHNESS: roughness}, {ROUGHNESS: first})
        near = lead is not None and lead.mean <= lead.margin
        measured = f"{label(ROUGHNESS, first)} leads by {known[first] - known[roughness]:.1f} dB"
        yield Comparison(label(LOAD, load), first == roughness, measured, near)


# ---- bounds


def bounded(
    cases: pd.DataFrame, column: str, statistic: str, low: float = -math.inf, high: float = math.inf
) -> list[Comparison]:
    """Compare a statistic over the surfaces with bounds at each roughness and load."""
    values = _means(cases, column, statistic).stack()
    return [
        Comparison(_place(roughness, load), low < value < high, rounded(value, 3))
        for (roughness, load), value in values.items()
    ]


def ratio(
    cases: pd.DataFrame, column: str, over: float, under: float, low: float, high: float
) -> list[Comparison]:
    """Compare the ratio of the means on two roughnesses with bounds at each load."""
    means = _means(cases, column).reindex([over, under])
    ratios = (means.loc[over] / means.loc[under]).dropna()
    return [
        Comparison(label(LOAD, load), low <= value <= high, f"{value:.2f}")
        for load, value in ratios.items()
    ]


def exceeds(cases: pd.DataFrame, column: str, level_db: float) -> Iterator[Comparison]:
    """Compare the highest level of each roughness with a bound, for any length of the record.

    It holds if a record ten times as long exceeds the bound, too, and nearly holds if one a tenth
    as long does.
    """
    duration = float(cases["duration_s"].max())
    for roughness, highest in _means(cases, column).max(axis=1).dropna().items():
        beyond = highest - level_db
        turns = duration * 10 ** (beyond / LG_LENGTH_DB)
        measured = f"{highest:.1f} dB in {duration:g} s, at the bound in {rounded(turns)} s"
        holds = beyond > LG_LENGTH_DB
        near = beyond > -LG_LENGTH_DB
        yield Comparison(label(ROUGHNESS, roughness), holds, measured, near)


def mean_change(
    cases: pd.DataFrame,
    column: str,
    along: str,
    start: float,
    ends: Sequence[float],
    bounds: tuple[float, float],
    any_is_near: bool = False,
) -> Iterator[Comparison]:
    """Compare changes of a level along one axis, averaged over the other axis, with bounds.

    With `any_is_near`, a change within the bounds anywhere on the other axis nearly holds.
    """
    across = LOAD if along == ROUGHNESS else ROUGHNESS
    low, high = bounds
    for end in ends:
        steps = [
            change(group, column, {along: start}, {along: end})
            for _, group in cases.groupby(across)
        ]
        known = [step.mean for step in steps if step is not None]
        if known:
            mean = float(np.mean(known))
            near = any_is_near and any(low <= step <= high for step in known)
            measured = f"{mean:+.1f} dB ({', '.join(f'{step:+.1f}' for step in known)})"
            place = f"{label(along, start)} to {end:g}"
            yield Comparison(place, low <= mean <= high, measured, near)


def flattens(
    cases: pd.DataFrame, column: str, start: float, knee: float, end: float, share: float
) -> Iterator[Comparison]:
    """Compare the rise per doubling of the load beyond a knee with a share of the rise before."""
    for roughness, group in cases.groupby(ROUGHNESS):
        before = change(group, column, {LOAD: start}, {LOAD: knee})
        beyond = change(group, column, {LOAD: knee}, {LOAD: end})
        if before is None or beyond is None:
            continue
        slope = before.mean / math.log2(knee / start)
        flat = beyond.mean / math.log2(end / knee)
        measured = f"{flat:+.1f} dB per doubling after {slope:+.1f} dB"
        holds = slope > 0 and flat <= share * slope
        yield Comparison(label(ROUGHNESS, roughness), holds, measured)


def stands_apart(cases: pd.DataFrame, column: str, low: float, high: float) -> list[Comparison]:
    """Compare the gap between two neighbouring loads with 6 dB and with all other steps."""
    means = cases.groupby(LOAD)[column].mean().dropna()
    if low not in means or high not in means:
        return []
    gap = float(means.loc[high:].min() - means.loc[:low].max())
    steps = means.diff().drop(high).dropna()
    others = ", ".join(f"{step:+.1f}" for step in steps)
    larger = gap > 0 and all(gap >= LARGEST_STEP * step for step in steps)
    return [
        Comparison(f"{low:g} to {label(LOAD, high)}", gap >= LARGE_GAP_DB, f"{gap:+.1f} dB"),
        Comparison("other steps", larger, f"{others} dB"),
    ]


def within(cases: pd.DataFrame, column: str, span_db: float) -> list[Comparison]:
    """Compare the span of the means over the roughnesses with a bound at each load."""
    means = _means(cases, column)
    means = means.loc[:, means.count() > 1]
    return [
        Comparison(label(LOAD, load), span <= span_db, f"{span:.1f} dB")
        for load, span in (means.max() - means.min()).items()
    ]


# ---- twins without hardness


def _pairs(cases: pd.DataFrame, column: str) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield the cases with a twin by roughness and load."""
    pairs = cases.dropna(subset=[column, f"{column}_elastic"])
    for (roughness, load), group in pairs.groupby([ROUGHNESS, LOAD]):
        yield _place(roughness, load), group


def less_than_twin(cases: pd.DataFrame, column: str) -> Iterator[Comparison]:
    """Compare the column with its twin without hardness; it must be lower on every surface."""
    for place, group in _pairs(cases, column):
        ratios = group[column] / group[f"{column}_elastic"]
        yield Comparison(place, bool((ratios < 1).all()), f"{ratios.mean():.3f} of the twin")


def beside_twin(cases: pd.DataFrame, column: str, higher: bool) -> Iterator[Comparison]:
    """Compare level and third octaves with the twin without hardness.

    The level must rise by more than twice the uncertainty of the difference. Unless `higher`, it
    may fall as well, or a third of the resolved third octaves may differ in its place.
    """
    error = column.replace("_db", "_uncertainty_db")
    for place, group in _pairs(cases, column):
        step = float((group[column] - group[f"{column}_elastic"]).mean())
        square = (group[[error, f"{error}_elastic"]] ** 2).to_numpy().sum()
        margin = 2 * math.sqrt(square) / len(group)
        measured = f"{step:+.1f} ± {margin / 2:.1f} dB"
        holds = step > margin
        if not higher:
            beyond = _bands_beside_twin(group)
            holds = abs(step) > margin or (len(beyond) > 0 and beyond.mean() >= MIN_SHARE)
            measured += f", {beyond.sum()} of {len(beyond)} third octaves"
        yield Comparison(place, bool(holds), measured)


def _bands_beside_twin(group: pd.DataFrame) -> np.ndarray:
    """Return whether each resolved third octave differs by more than twice its uncertainty."""
    names = band_columns(BAND_NAMES)
    duration = float(group["duration_s"].min())
    twins = group[[f"{name}_elastic" for name in names]].to_numpy()
    changes = (group[names].to_numpy() - twins).mean(axis=0)
    resolved = reliable(duration) & (MID_HZ < HIGHEST_BAND_HZ) & np.isfinite(changes)
    uncertainty = band_uncertainty_db(duration) * math.sqrt(2 / len(group))
    beyond: np.ndarray = np.abs(changes[resolved]) > 2 * uncertainty[resolved]
    return beyond
