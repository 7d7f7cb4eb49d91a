"""The shapes of what an article states, such as "rises with load", each judged by the cases of a reading.

Depends on measures and checks; which roughnesses, loads and bounds a statement names is told by claims.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from rolling.lee2025.checks import GRID, NOT_RUN, RECORD, Check, Finding, concluded, doubt
from rolling.lee2025.measures import PLASTIC_RATIO, PRESSURE, Cases, Change, Measure, change
from rolling.lee2025.study import Case

LENGTHS = 10.0  # a verdict that stays in records up to so many times longer and shorter does not depend on it
LG_LENGTH_DB = 5.0  # a line of noise falls by so much as the record becomes ten times as long (10 lg of an amplitude)
NO_AREA = 0.005  # of the Hertz area: less than a mark in a figure from 0 to 1
LARGE_GAP_DB = 6.0
LARGEST_STEP = 1.5  # 20 to 50 N is 2.5 times the load, the other steps twice: 1.3 of them come without any jump


@dataclass(frozen=True)
class _Step:
    """A change at a load [N] from one roughness [um] to another; `base`: the mean that it starts from."""

    change: Change
    base: float
    over: float
    under: float
    load: float


def _step(study: Cases, measure: Measure, under: float, over: float, load: float) -> _Step | None:
    """Find the change from one roughness to another at a load; None where cases are missing."""
    first, then = study.at(under, load), study.at(over, load)
    found = change(measure, first, then, study.factor)
    base = measure.mean(first, study.factor)
    return None if found is None or base is None else _Step(found, base, over, under, load)


def _turns_on_grid(study: Cases, measure: Measure, step: _Step) -> bool:
    """Judge whether the grid may move a step against its sign."""
    mean = step.change.mean
    if measure.level:
        places = (step.over, step.load), (step.under, step.load)
        low, high = study.grid.shift_db(measure.grid, *places, study.factor)
    else:
        factors = study.grid.ratio(measure.grid, step.over, step.under, step.load)
        low, high = ((factor - 1) * (step.base + mean) for factor in factors)
    return 0 < mean <= -low or 0 < -mean <= high


def _sign(study: Cases, measure: Measure, steps: Sequence[_Step], rises: bool) -> tuple[bool, str]:
    """Judge whether all steps rise (or fall), and whether the grid may turn that."""
    holds = [step.change.rises if rises else step.change.falls for step in steps]
    turns = [_turns_on_grid(study, measure, step) for step in steps]
    at_best = all(held or turned for held, turned in zip(holds, turns, strict=True))
    at_worst = all(held and not turned for held, turned in zip(holds, turns, strict=True))
    return all(holds), GRID if at_best != at_worst else ""


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


def along_roughness(study: Cases, measure: Measure, roughnesses: Sequence[float], rises: bool = True) -> Finding:
    """Every step of roughness raises it (or lowers it) at every load; a part for each step."""
    checks = []
    for a, b in pairwise(roughnesses):
        steps = [step for load in study.loads if (step := _step(study, measure, a, b, load))]
        place = f"{ra(a)} to {b:g}"
        if not steps:
            checks.append(Check(place, None))
            continue
        holds, unsure = _sign(study, measure, steps, rises)
        loads = [newton(step.load) for step in steps]
        means = [step.change.mean for step in steps]
        told = f"{', '.join(measure.told(mean, '+') for mean in means)} {measure.unit} ({', '.join(loads)})"
        checks.append(Check(place, holds, told, dict(zip(loads, means, strict=True)), unsure=unsure))
    return concluded(checks)


def lowest_of_all(study: Cases, measure: Measure, roughness: float) -> Finding:
    """At each load less than on every other roughness."""
    checks = []
    for load in study.loads:
        others = [other for other in study.roughnesses if other != roughness]
        steps = [step for other in others if (step := _step(study, measure, other, roughness, load))]
        if not steps:
            checks.append(Check(newton(load), None))
            continue
        holds, unsure = _sign(study, measure, steps, rises=False)
        words, numbers = _series(study, measure, [(ra(one), study.at(one, load)) for one in study.roughnesses])
        checks.append(Check(newton(load), holds, words, numbers, unsure=unsure))
    return concluded(checks)


def ratio_at_each_load(study: Cases, measure: Measure, over: float, under: float, low: float, high: float) -> Finding:
    """Mean on one roughness over that on another, between two bounds at each load."""
    checks = []
    for load in study.loads:
        above, below = (measure.mean(study.at(one, load), study.factor) for one in (over, under))
        if above is None or below is None:
            checks.append(Check(newton(load), None))
            continue
        if not below:
            checks.append(Check(newton(load), False, f"nothing on {ra(under)}"))
            continue
        ratio = above / below
        least, most = study.grid.ratio(measure.grid, over, under, load)
        errors = [measure.relative_error(study.at(one, load), study.factor) for one in (over, under)]
        unsure = doubt(
            ratio, lambda x: low <= x <= high, ((least - 1) * ratio, (most - 1) * ratio), ratio * math.hypot(*errors)
        )
        told = f"{ratio:.2f}"
        if (least, most) != (1.0, 1.0):
            told += f" (fine grid: {least * ratio:.2f} to {most * ratio:.2f})"
        checks.append(Check(newton(load), low <= ratio <= high, told, ratio, unsure=unsure))
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
    """Above a level at some load; a part for each roughness. Says at what length of the record that would change."""
    if study.factor != 10:
        return Finding(NOT_RUN, f"{study.factor} lg of a power has no absolute value")
    checks = []
    for roughness in roughnesses:
        groups = [(newton(load), study.at(roughness, load)) for load in study.loads]
        words, numbers = _series(study, measure, groups)
        if not numbers:
            checks.append(Check(ra(roughness), None))
            continue
        greatest = max(one["mean"] for one in numbers.values())
        duration = max(case.duration_s for _, group in groups for case in group)
        times = 10 ** ((greatest - least_db) / LG_LENGTH_DB)
        words += f", turns at a record of {times * duration:.2g} s instead of {duration:.2g} s"
        unsure = RECORD if 1 / LENGTHS <= times <= LENGTHS else ""
        numbers |= {"turns at [s]": times * duration}
        checks.append(Check(ra(roughness), greatest > least_db, words, numbers, unsure=unsure))
    return concluded(checks)


def gap_over(
    study: Cases, measure: Measure, smooth: float, roughnesses: Sequence[float], low_db: float, high_db: float
) -> Finding:
    """How far each rougher surface lies above the smooth one, in the mean over the loads."""
    checks = []
    for roughness in roughnesses:
        gaps, loads = {}, []
        for load in study.loads:
            step = change(measure, study.at(smooth, load), study.at(roughness, load), study.factor)
            if step:
                gaps[newton(load)] = step
                loads.append(load)
        if not gaps:
            checks.append(Check(ra(roughness), None))
            continue
        mean = float(np.mean([step.mean for step in gaps.values()]))
        error = float(np.mean([step.error for step in gaps.values()]))  # the same surfaces under all loads
        each = ", ".join(measure.told(step.mean, "+") for step in gaps.values())
        told = f"{measure.told(mean, '+')} dB ({each} at {', '.join(gaps)})"
        grid = _mean_range(
            [study.grid.shift_db(measure.grid, (roughness, one), (smooth, one), study.factor) for one in loads]
        )
        unsure = doubt(mean, lambda x: low_db <= x <= high_db, grid, error)
        numbers = {"mean": mean} | {name: step.mean for name, step in gaps.items()}
        checks.append(Check(ra(roughness), low_db <= mean <= high_db, told, numbers, unsure=unsure))
    return concluded(checks)


def _mean_range(ranges: Sequence[tuple[float, float]]) -> tuple[float, float]:
    return float(np.mean([low for low, _ in ranges])), float(np.mean([high for _, high in ranges]))


def rise_over_loads(
    study: Cases, measure: Measure, least: float, greatest: float, low_db: float, high_db: float
) -> Finding:
    """From one load to another, in the mean over the roughnesses; near if one of them does."""
    steps = {}
    for roughness in study.roughnesses:
        step = change(measure, study.at(roughness, least), study.at(roughness, greatest), study.factor)
        if step:
            steps[roughness] = step
    place = f"{newton(least)} to {newton(greatest)}"
    if not steps:
        return concluded([Check(place, None)])
    mean = float(np.mean([step.mean for step in steps.values()]))
    error = math.hypot(*(step.error for step in steps.values())) / len(steps)
    grid = _mean_range(
        [study.grid.shift_db(measure.grid, (one, greatest), (one, least), study.factor) for one in steps]
    )
    unsure = doubt(mean, lambda x: low_db <= x <= high_db, grid, error)
    inside = [low_db <= step.mean <= high_db for step in steps.values()]
    each = ", ".join(f"{measure.told(step.mean, '+')} {ra(one)}" for one, step in steps.items())
    told = f"{measure.told(mean, '+')} dB ({each})"
    numbers = {"mean": mean} | {ra(one): step.mean for one, step in steps.items()}
    return concluded(
        [Check(place, low_db <= mean <= high_db, told, numbers, near=any(inside), unsure=unsure)],
    )


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
            Check(
                f"gap of {LARGE_GAP_DB:g} dB",
                gap >= LARGE_GAP_DB,
                f"{measure.told(gap, '+')} dB",
                gap,
                unsure=doubt(
                    gap,
                    lambda x: x >= LARGE_GAP_DB,
                    study.grid.shift_db(measure.grid, (roughness, high), (roughness, low), study.factor),
                    0.0,
                ),
            ),
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
        first, second = sorted(means, key=lambda one: -means[one])[:2]
        words, numbers = _series(study, measure, [(ra(one), group) for one, group in groups.items()])
        step = change(measure, groups[roughness], groups[first], study.factor)
        near = first != roughness and step is not None and not step.rises
        over, under = (roughness, second) if first == roughness else (first, roughness)
        lead = means[over] - means[under]
        least, _ = study.grid.shift_db(measure.grid, (over, load), (under, load), study.factor)
        unsure = GRID if least < 0 and lead <= -least else ""
        checks.append(Check(newton(load), first == roughness, f"{ra(first)} of {words}", numbers, near, unsure))
    return concluded(checks)


def within(study: Cases, measure: Measure, roughnesses: Sequence[float], most_db: float) -> Finding:
    """Highest less lowest mean of the roughnesses, at each load."""
    checks = []
    for load in study.loads:
        means = {one: measure.mean(study.at(one, load), study.factor) for one in roughnesses}
        known = {one: mean for one, mean in means.items() if mean is not None}
        if len(known) < 2:
            checks.append(Check(newton(load), None))
            continue
        top, bottom = max(known, key=lambda one: known[one]), min(known, key=lambda one: known[one])
        span = known[top] - known[bottom]
        step = change(measure, study.at(bottom, load), study.at(top, load), study.factor)
        grid = study.grid.shift_db(measure.grid, (top, load), (bottom, load), study.factor)
        unsure = doubt(span, lambda x: x <= most_db, grid, step.error if step else 0.0)
        checks.append(Check(newton(load), span <= most_db, f"{measure.told(span)} dB", span, unsure=unsure))
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
