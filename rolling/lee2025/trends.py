"""Criteria of the form "rises with load", which the sign of changes decides.

The module `statements` gives the roughnesses and loads of each statement.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from rolling.lee2025.checks import GRID, Check, Finding, Place, concluded
from rolling.lee2025.measures import Cases, Change, Measure, change, newton, ra, series


@dataclass(frozen=True)
class _Step:
    """A change at one load from one roughness to another.

    Parameters
    ----------
    change : Change. The change over the surfaces.
    base : float. The mean before the change.
    over, under : float, um. The roughness after and before the change.
    load : float, N. The load.
    """

    change: Change
    base: float
    over: float
    under: float
    load: float


def _step(study: Cases, measure: Measure, under: float, over: float, load: float) -> _Step | None:
    """Compute the change between two roughnesses at a load, or return None if cases are missing."""
    first, then = study.at(under, load), study.at(over, load)
    step = change(measure, first, then, study.factor)
    base = measure.mean(first, study.factor)
    return None if step is None or base is None else _Step(step, base, over, under, load)


def _turns_on_grid(study: Cases, measure: Measure, step: _Step) -> bool:
    """Judge whether the grid may turn the sign of a step."""
    mean = step.change.mean
    if measure.level:
        places = (step.over, step.load), (step.under, step.load)
        low, high = study.grid.shift_db(measure.grid, *places, study.factor)
    else:
        factors = study.grid.ratio(measure.grid, step.over, step.under, step.load)
        low, high = ((factor - 1) * (step.base + mean) for factor in factors)
    return 0 < mean <= -low or 0 < -mean <= high


def _places(study: Cases, measure: Measure, steps: Sequence[_Step]) -> tuple[Place, ...]:
    """Return the cases of the steps whose sign the grid may turn."""
    turned = [step for step in steps if _turns_on_grid(study, measure, step)]
    return tuple((each, step.load) for step in turned for each in (step.under, step.over))


def _sign(study: Cases, measure: Measure, steps: Sequence[_Step], rises: bool) -> tuple[bool, str]:
    """Judge whether all steps rise (or fall), and whether the grid may change the answer."""
    holds = [step.change.rises if rises else step.change.falls for step in steps]
    turns = [_turns_on_grid(study, measure, step) for step in steps]
    at_best = all(held or turned for held, turned in zip(holds, turns, strict=True))
    at_worst = all(held and not turned for held, turned in zip(holds, turns, strict=True))
    return all(holds), GRID if at_best != at_worst else ""


def _all(parts: Sequence[bool | None]) -> bool | None:
    """Return whether all known parts hold, or None if no part is known."""
    known = [part for part in parts if part is not None]
    return all(known) if known else None


def _rises(step: Change | None) -> bool | None:
    """Return whether a step rises for certain, or None without a step."""
    return None if step is None else step.rises


def _falls(step: Change | None) -> bool | None:
    """Return whether a step falls for certain, or None without a step."""
    return None if step is None else step.falls


def rises_with_load(study: Cases, measure: Measure, roughnesses: Sequence[float]) -> Finding:
    """Judge whether every step of load raises a measure.

    Each roughness is a part, or each step if the statement concerns one roughness only.
    """
    checks = []
    for roughness in roughnesses:
        groups = [(newton(load), study.at(roughness, load)) for load in study.loads]
        groups = [(name, group) for name, group in groups if measure.by_seed(group, study.factor)]
        steps = [(a, b, change(measure, x, y, study.factor)) for (a, x), (b, y) in pairwise(groups)]
        if len(roughnesses) == 1 and steps:
            for a, b, step in steps:
                text = "" if step is None else f"{measure.text(step.mean, '+')} {measure.unit}"
                checks.append(Check(f"{a} to {b}", _rises(step), text, step.mean if step else None))
            continue
        words, numbers = series(study, measure, groups) if steps else ("", {})
        checks.append(
            Check(ra(roughness), _all([_rises(step) for *_, step in steps]), words, numbers)
        )
    return concluded(checks)


def along_roughness(
    study: Cases, measure: Measure, roughnesses: Sequence[float], rises: bool = True
) -> Finding:
    """Judge whether every step of roughness raises (or lowers) a measure at every load.

    Each step is a part.
    """
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
        text = (
            f"{', '.join(measure.text(mean, '+') for mean in means)} {measure.unit} "
            f"({', '.join(loads)})"
        )
        numbers = dict(zip(loads, means, strict=True))
        places = _places(study, measure, steps)
        checks.append(Check(place, holds, text, numbers, unsure=unsure, places=places))
    return concluded(checks)


def lowest_of_all(study: Cases, measure: Measure, roughness: float) -> Finding:
    """Judge whether a measure is lowest on one roughness; each load is a part."""
    checks = []
    for load in study.loads:
        others = [other for other in study.roughnesses if other != roughness]
        steps = [
            step for other in others if (step := _step(study, measure, other, roughness, load))
        ]
        if not steps:
            checks.append(Check(newton(load), None))
            continue
        holds, unsure = _sign(study, measure, steps, rises=False)
        groups = [(ra(each), study.at(each, load)) for each in study.roughnesses]
        words, numbers = series(study, measure, groups)
        places = _places(study, measure, steps)
        checks.append(Check(newton(load), holds, words, numbers, unsure=unsure, places=places))
    return concluded(checks)


def loudest(study: Cases, measure: Measure, roughness: float, loads: Sequence[float]) -> Finding:
    """Judge whether one roughness has the highest mean; each load is a part.

    It is near where the lead of another roughness is not certain.
    """
    checks = []
    for load in loads:
        groups = {each: study.at(each, load) for each in study.roughnesses}
        means = {
            each: mean
            for each, group in groups.items()
            if (mean := measure.mean(group, study.factor)) is not None
        }
        if roughness not in means or len(means) < 2:
            checks.append(Check(newton(load), None))
            continue
        first, second = sorted(means, key=lambda each: -means[each])[:2]
        words, numbers = series(
            study, measure, [(ra(each), group) for each, group in groups.items()]
        )
        step = change(measure, groups[roughness], groups[first], study.factor)
        near = first != roughness and step is not None and not step.rises
        over, under = (roughness, second) if first == roughness else (first, roughness)
        lead = means[over] - means[under]
        least, _ = study.grid.shift_db(measure.grid, (over, load), (under, load), study.factor)
        unsure = GRID if least < 0 and lead <= -least else ""
        text, places = f"{ra(first)} of {words}", ((over, load), (under, load))
        checks.append(Check(newton(load), first == roughness, text, numbers, near, unsure, places))
    return concluded(checks)


def falls_along(study: Cases, measure: Measure, varied: str, unit: str) -> Finding:
    """Judge whether every step up of a sweep's variable lowers a measure."""
    groups = [
        (f"{value:g}{unit}", [case for case in study.cases if getattr(case, varied) == value])
        for value in study.values(varied)
    ]
    checks = []
    for (a, x), (b, y) in pairwise(groups):
        step = change(measure, x, y, study.factor)
        text = f"{measure.text(step.mean, '+')} {measure.unit}" if step else ""
        checks.append(Check(f"{a} to {b}", _falls(step), text, step.mean if step else None))
    return concluded(checks)
