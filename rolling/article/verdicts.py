"""The shapes of what an article states, such as "rises with load", each judged by the cases of a reading.

Depends on measures; which roughnesses, loads and bounds a statement names is told by claims.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from rolling.article.measures import PLASTIC_RATIO, PRESSURE, Cases, Change, Measure, change
from rolling.article.study import Case

REPRODUCED, PARTLY, NOT, NOT_RUN = "reproduced", "partly", "not", "not run"
NO_AREA = 0.005  # of the Hertz area: less than a mark in a figure from 0 to 1
LARGE_GAP_DB = 6.0
LARGEST_STEP = 1.5  # 20 to 50 N is 2.5 times the load, the other steps twice: 1.3 of them come without any jump


@dataclass(frozen=True)
class Check:
    """A part of a statement. holds : None where there are no cases to tell. near : it does not, but is not far from it."""

    place: str
    holds: bool | None
    measured: str = ""
    numbers: Any = None
    near: bool = False


@dataclass(frozen=True)
class Finding:
    """Verdict on a statement, what was measured in words, and in numbers: values by place, and which of these hold, fail, miss."""

    verdict: str
    measured: str
    numbers: dict[str, Any] = field(default_factory=dict)


def concluded(checks: Sequence[Check]) -> Finding:
    """Reproduced if all parts hold that can be told, partly if some hold or are near, not if none, else not run."""
    known = [check for check in checks if check.holds is not None]
    missing = [check.place for check in checks if check.holds is None]
    if not known:
        return Finding(NOT_RUN, f"no cases to tell: {', '.join(missing)}" if missing else "no cases to tell")
    kept = [check.place for check in known if check.holds]
    failed = [check.place for check in known if not check.holds]
    verdict = REPRODUCED if not failed else PARTLY if kept or any(check.near for check in known) else NOT
    words = ["; ".join(f"{check.place}: {check.measured}" for check in known)]
    if kept and failed:
        words.append(f"holds: {', '.join(kept)}; does not: {', '.join(failed)}")
    if missing:
        words.append(f"no cases to tell: {', '.join(missing)}")
    values = {check.place: check.numbers for check in known}
    numbers = {"values": values, "holds": kept, "fails": failed, "missing": missing}
    return Finding(verdict, ". ".join(words), numbers)


def _all(parts: Sequence[bool | None]) -> bool | None:
    """Whether all parts hold that can be told; None if none can."""
    known = [part for part in parts if part is not None]
    return all(known) if known else None


def ra(roughness_um: float) -> str:
    return f"Ra {roughness_um:g} µm"


def newton(load_n: float) -> str:
    return f"{load_n:g} N"


def _series(study: Cases, measure: Measure, groups: Sequence[tuple[str, Sequence[Case]]]) -> tuple[str, dict[str, Any]]:
    """Means and deviations of groups, in words and numbers; levels without an absolute value relative to the first."""
    found = [
        (name, measure.mean(group, study.factor), measure.deviation(group, study.factor)) for name, group in groups
    ]
    known = [(name, mean, deviation) for name, mean, deviation in found if mean is not None]
    relative = measure.level and study.factor != 10
    base, sign = (known[0][1], "+") if known and relative else (0.0, "")
    words = [
        measure.told(mean - base, sign) + ("" if deviation is None else f" ± {measure.told(deviation)}")
        for _, mean, deviation in known
    ]
    numbers = {name: {"mean": mean - base, "std": deviation} for name, mean, deviation in known}
    return f"{', '.join(words)} {measure.unit} ({', '.join(numbers)})", numbers


def _rises(step: Change | None) -> bool | None:
    return None if step is None else step.rises


def _falls(step: Change | None) -> bool | None:
    return None if step is None else step.falls


def rises_with_load(study: Cases, measure: Measure, roughnesses: Sequence[float]) -> Finding:
    """Every step of load raises it; a part for each roughness, or for each step if it is about one roughness only."""
    checks = []
    for roughness in roughnesses:
        groups = [(newton(load), study.at(roughness, load)) for load in study.loads]
        groups = [(name, group) for name, group in groups if measure.by_seed(group, study.factor)]
        steps = [(a, b, change(measure, x, y, study.factor)) for (a, x), (b, y) in pairwise(groups)]
        if len(roughnesses) == 1 and steps:
            for a, b, step in steps:
                told = "" if step is None else f"{measure.told(step.mean, '+')} {measure.unit}"
                checks.append(Check(f"{a} to {b}", _rises(step), told, step.mean if step else None))
            continue
        words, numbers = _series(study, measure, groups) if steps else ("", {})
        checks.append(Check(ra(roughness), _all([_rises(step) for *_, step in steps]), words, numbers))
    return concluded(checks)


def rises_with_roughness(study: Cases, measure: Measure, roughnesses: Sequence[float]) -> Finding:
    """Every step of roughness raises it at every load; a part for each step."""
    checks = []
    for a, b in pairwise(roughnesses):
        steps = {
            load: step
            for load in study.loads
            if (step := change(measure, study.at(a, load), study.at(b, load), study.factor))
        }
        told = ", ".join(measure.told(step.mean, "+") for step in steps.values())
        checks.append(
            Check(
                f"{ra(a)} to {b:g}",
                _all([step.rises for step in steps.values()]),
                f"{told} {measure.unit} ({', '.join(map(newton, steps))})",
                {newton(load): step.mean for load, step in steps.items()},
            )
        )
    return concluded(checks)


def lowest_of_all(study: Cases, measure: Measure, roughness: float) -> Finding:
    """At each load less than on every other roughness."""
    checks = []
    for load in study.loads:
        lowest = study.at(roughness, load)
        others = [study.at(other, load) for other in study.roughnesses if other != roughness]
        steps = [change(measure, group, lowest, study.factor) for group in others]
        words, numbers = _series(study, measure, [(ra(one), study.at(one, load)) for one in study.roughnesses])
        checks.append(Check(newton(load), _all([_falls(step) for step in steps]), words, numbers))
    return concluded(checks)


def ratio_at_each_load(study: Cases, measure: Measure, over: float, under: float, low: float, high: float) -> Finding:
    """Mean on one roughness over that on another, between two bounds at each load."""
    checks = []
    for load in study.loads:
        above, below = (measure.mean(study.at(one, load), study.factor) for one in (over, under))
        if above is None or below is None:
            checks.append(Check(newton(load), None))
        elif not below:
            checks.append(Check(newton(load), False, f"nothing on {ra(under)}"))
        else:
            ratio = above / below
            checks.append(Check(newton(load), low <= ratio <= high, f"{ratio:.2f}", ratio))
    return concluded(checks)


def below_limit(study: Cases, roughness: float, limit: float) -> Finding:
    """The greatest pressure [Pa] of any surface, at each load."""
    checks = []
    for load in study.loads:
        reached = PRESSURE.by_seed(study.at(roughness, load), study.factor).values()
        greatest = max(reached, default=None)
        holds = None if greatest is None else greatest * 1e9 < limit
        checks.append(Check(newton(load), holds, f"{PRESSURE.told(greatest)} GPa", greatest))
    return concluded(checks)


def no_plastic_area(study: Cases, roughness: float) -> Finding:
    checks = []
    for load in study.loads:
        mean = PLASTIC_RATIO.mean(study.at(roughness, load), study.factor)
        checks.append(Check(newton(load), None if mean is None else mean < NO_AREA, PLASTIC_RATIO.told(mean), mean))
    return concluded(checks)


def hardness_reached(study: Cases, roughnesses: Sequence[float]) -> Finding:
    """Some of every surface is at the hardness, at each load; a part for each roughness and load."""
    checks = []
    for roughness in roughnesses:
        for load in study.loads:
            ratios = PLASTIC_RATIO.by_seed(study.at(roughness, load), study.factor).values()
            least = min(ratios, default=None)
            place = f"{ra(roughness)}, {newton(load)}"
            checks.append(Check(place, None if least is None else least > 0, PLASTIC_RATIO.told(least), least))
    return concluded(checks)


def exceeds(study: Cases, measure: Measure, roughnesses: Sequence[float], least_db: float) -> Finding:
    """Above a level at some load; a part for each roughness."""
    if study.factor != 10:
        return Finding(NOT_RUN, f"{study.factor} lg of a power has no absolute value")
    checks = []
    for roughness in roughnesses:
        groups = [(newton(load), study.at(roughness, load)) for load in study.loads]
        words, numbers = _series(study, measure, groups)
        holds = any(one["mean"] > least_db for one in numbers.values()) if numbers else None
        checks.append(Check(ra(roughness), holds, words, numbers))
    return concluded(checks)


def gap_over(
    study: Cases, measure: Measure, smooth: float, roughnesses: Sequence[float], low_db: float, high_db: float
) -> Finding:
    """How far each rougher surface lies above the smooth one, in the mean over the loads."""
    checks = []
    for roughness in roughnesses:
        gaps = {}
        for load in study.loads:
            step = change(measure, study.at(smooth, load), study.at(roughness, load), study.factor)
            if step:
                gaps[newton(load)] = step.mean
        if not gaps:
            checks.append(Check(ra(roughness), None))
            continue
        mean = float(np.mean(list(gaps.values())))
        each = ", ".join(measure.told(gap, "+") for gap in gaps.values())
        told = f"{measure.told(mean, '+')} dB ({each} at {', '.join(gaps)})"
        checks.append(Check(ra(roughness), low_db <= mean <= high_db, told, {"mean": mean} | gaps))
    return concluded(checks)


def rise_over_loads(
    study: Cases, measure: Measure, least: float, greatest: float, low_db: float, high_db: float
) -> Finding:
    """From one load to another, in the mean over the roughnesses; near if one of them does."""
    rises = {}
    for roughness in study.roughnesses:
        step = change(measure, study.at(roughness, least), study.at(roughness, greatest), study.factor)
        if step:
            rises[ra(roughness)] = step.mean
    place = f"{newton(least)} to {newton(greatest)}"
    if not rises:
        return concluded([Check(place, None)])
    mean = float(np.mean(list(rises.values())))
    inside = [low_db <= value <= high_db for value in rises.values()]
    each = ", ".join(f"{measure.told(value, '+')} {name}" for name, value in rises.items())
    told = f"{measure.told(mean, '+')} dB ({each})"
    return concluded([Check(place, low_db <= mean <= high_db, told, {"mean": mean} | rises, near=any(inside))])


def flattens(study: Cases, measure: Measure, least: float, knee: float, greatest: float, most: float) -> Finding:
    """Per doubling of the load it rises beyond the knee at most that share of what it does before; per roughness."""
    checks = []
    for roughness in study.roughnesses:
        before = change(measure, study.at(roughness, least), study.at(roughness, knee), study.factor)
        after = change(measure, study.at(roughness, knee), study.at(roughness, greatest), study.factor)
        if before is None or after is None:
            checks.append(Check(f"{ra(roughness)} at {newton(knee)}", None))
            continue
        slope = before.mean / math.log2(knee / least), after.mean / math.log2(greatest / knee)
        told = f"{slope[1]:+.1f} dB per doubling after {slope[0]:+.1f} dB"
        numbers = {"before": slope[0], "beyond": slope[1]}
        checks.append(Check(ra(roughness), slope[0] > 0 and slope[1] <= most * slope[0], told, numbers))
    return concluded(checks)


def stands_apart(study: Cases, measure: Measure, roughness: float, low: float, high: float) -> Finding:
    """Between two neighbouring loads lies a gap: large in itself, and larger than any other step."""
    means = {load: measure.mean(study.at(roughness, load), study.factor) for load in study.loads}
    known = {load: mean for load, mean in means.items() if mean is not None}
    if low not in known or high not in known:
        return concluded([Check(newton(load), None) for load in (low, high) if load not in known])
    gap = min(mean for load, mean in known.items() if load >= high) - max(
        mean for load, mean in known.items() if load <= low
    )
    others = {f"{newton(a)} to {newton(b)}": known[b] - known[a] for a, b in pairwise(known) if a != low}
    told = ", ".join(f"{measure.told(value, '+')} dB {name}" for name, value in others.items())
    larger = gap > 0 and all(gap >= LARGEST_STEP * value for value in others.values()) if others else None
    return concluded(
        [
            Check(f"gap of {LARGE_GAP_DB:g} dB", gap >= LARGE_GAP_DB, f"{measure.told(gap, '+')} dB", gap),
            Check("larger than other steps", larger, told, others),
        ]
    )


def loudest(study: Cases, measure: Measure, roughness: float, loads: Sequence[float]) -> Finding:
    """The roughness of the highest mean; near where the highest is no higher for certain."""
    checks = []
    for load in loads:
        groups = {one: study.at(one, load) for one in study.roughnesses}
        means = {one: mean for one, group in groups.items() if (mean := measure.mean(group, study.factor)) is not None}
        if roughness not in means or len(means) < 2:
            checks.append(Check(newton(load), None))
            continue
        first = max(means, key=lambda one: means[one])
        words, numbers = _series(study, measure, [(ra(one), group) for one, group in groups.items()])
        step = change(measure, groups[roughness], groups[first], study.factor)
        near = first != roughness and step is not None and not step.rises
        checks.append(Check(newton(load), first == roughness, f"{ra(first)} of {words}", numbers, near))
    return concluded(checks)


def within(study: Cases, measure: Measure, roughnesses: Sequence[float], most_db: float) -> Finding:
    """Highest less lowest mean of the roughnesses, at each load."""
    checks = []
    for load in study.loads:
        means = [measure.mean(study.at(one, load), study.factor) for one in roughnesses]
        known = [mean for mean in means if mean is not None]
        if len(known) < 2:
            checks.append(Check(newton(load), None))
            continue
        span = max(known) - min(known)
        checks.append(Check(newton(load), span <= most_db, f"{measure.told(span)} dB", span))
    return concluded(checks)


def falls_along(study: Cases, measure: Measure, varied: str, unit: str) -> Finding:
    """Every step up of what a sweep varies lowers it."""
    groups = [
        (f"{value:g}{unit}", [case for case in study.cases if getattr(case, varied) == value])
        for value in study.values(varied)
    ]
    checks = []
    for (a, x), (b, y) in pairwise(groups):
        step = change(measure, x, y, study.factor)
        told = f"{measure.told(step.mean, '+')} {measure.unit}" if step else ""
        checks.append(Check(f"{a} to {b}", _falls(step), told, step.mean if step else None))
    return concluded(checks)
