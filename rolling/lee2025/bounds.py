"""Criteria that compare a number with bounds, such as a ratio, a level or a gap between levels.

The module `statements` gives the roughnesses, loads and bounds of each statement.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from rolling.lee2025.checks import NOT_RUN, RECORD, Check, Finding, concluded, doubt
from rolling.lee2025.measures import (
    PLASTIC_RATIO,
    PRESSURE,
    Cases,
    Measure,
    change,
    newton,
    ra,
    series,
)

# A verdict does not depend on the record if it holds for records this factor longer and shorter.
LENGTHS = 10.0
LG_LENGTH_DB = 5.0  # fall of a line of noise in a record ten times as long (10 lg of an amplitude)
NO_AREA = 0.005  # share of the Hertz area, less than a mark in a figure from 0 to 1
LARGE_GAP_DB = 6.0
# 20 to 50 N is 2.5 times the load, the other steps are twice: a level without jumps rises 1.3 steps
LARGEST_STEP = 1.5


def ratio_at_each_load(
    study: Cases, measure: Measure, over: float, under: float, low: float, high: float
) -> Finding:
    """Judge whether the ratio of the means on two roughnesses lies between two bounds.

    Each load is a part.
    """
    checks = []
    for load in study.loads:
        above, below = (measure.mean(study.at(each, load), study.factor) for each in (over, under))
        if above is None or below is None:
            checks.append(Check(newton(load), None))
            continue
        if not below:
            checks.append(Check(newton(load), False, f"nothing on {ra(under)}"))
            continue
        ratio = above / below
        factor_low, factor_high = study.grid.ratio(measure.grid, over, under, load)
        errors = [
            measure.relative_error(study.at(each, load), study.factor) for each in (over, under)
        ]
        unsure = doubt(
            ratio,
            lambda x: low <= x <= high,
            ((factor_low - 1) * ratio, (factor_high - 1) * ratio),
            ratio * math.hypot(*errors),
        )
        text = f"{ratio:.2f}"
        if (factor_low, factor_high) != (1.0, 1.0):
            text += f" (fine grid: {factor_low * ratio:.2f} to {factor_high * ratio:.2f})"
        places = (over, load), (under, load)
        checks.append(
            Check(newton(load), low <= ratio <= high, text, ratio, unsure=unsure, places=places)
        )
    return concluded(checks)


def below_limit(study: Cases, roughness: float, limit: float) -> Finding:
    """Judge whether the maximum pressure of all surfaces stays below a limit [Pa].

    Each load is a part.
    """
    checks = []
    for load in study.loads:
        reached = PRESSURE.by_seed(study.at(roughness, load), study.factor).values()
        maximum = max(reached, default=None)
        holds = None if maximum is None else maximum * 1e9 < limit
        checks.append(Check(newton(load), holds, f"{PRESSURE.text(maximum)} GPa", maximum))
    return concluded(checks)


def no_plastic_area(study: Cases, roughness: float) -> Finding:
    """Judge whether the plastic area is too small to be visible in a figure.

    Each load is a part.
    """
    checks = []
    for load in study.loads:
        mean = PLASTIC_RATIO.mean(study.at(roughness, load), study.factor)
        checks.append(
            Check(
                newton(load),
                None if mean is None else mean < NO_AREA,
                PLASTIC_RATIO.text(mean),
                mean,
            )
        )
    return concluded(checks)


def hardness_reached(study: Cases, roughnesses: Sequence[float]) -> Finding:
    """Judge whether a part of every surface is at the hardness.

    Each roughness and load is a part.
    """
    checks = []
    for roughness in roughnesses:
        for load in study.loads:
            ratios = PLASTIC_RATIO.by_seed(study.at(roughness, load), study.factor).values()
            minimum = min(ratios, default=None)
            place = f"{ra(roughness)}, {newton(load)}"
            checks.append(
                Check(
                    place,
                    None if minimum is None else minimum > 0,
                    PLASTIC_RATIO.text(minimum),
                    minimum,
                )
            )
    return concluded(checks)


def exceeds(
    study: Cases, measure: Measure, roughnesses: Sequence[float], least_db: float
) -> Finding:
    """Judge whether a level exceeds a bound at some load.

    Each roughness is a part. The text names the record length at which the verdict would turn.
    """
    if study.factor != 10:
        return Finding(NOT_RUN, f"{study.factor} lg of a power has no absolute value")
    checks = []
    for roughness in roughnesses:
        groups = [(newton(load), study.at(roughness, load)) for load in study.loads]
        words, numbers = series(study, measure, groups)
        if not numbers:
            checks.append(Check(ra(roughness), None))
            continue
        maximum = max(statistic.mean for statistic in numbers.values())
        duration = max(case.duration_s for _, group in groups for case in group)
        times = 10 ** ((maximum - least_db) / LG_LENGTH_DB)
        words += f", turns at a record of {times * duration:.2g} s instead of {duration:.2g} s"
        unsure = RECORD if 1 / LENGTHS <= times <= LENGTHS else ""
        values = {**numbers, "turns at [s]": times * duration}
        checks.append(Check(ra(roughness), maximum > least_db, words, values, unsure=unsure))
    return concluded(checks)


def gap_over(
    study: Cases,
    measure: Measure,
    smooth: float,
    roughnesses: Sequence[float],
    low_db: float,
    high_db: float,
) -> Finding:
    """Judge whether the gap from each rougher surface to the smooth surface is within bounds.

    The gap is the mean over the loads; each roughness is a part.
    """
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
        # all loads use the same surfaces
        error = float(np.mean([step.error for step in gaps.values()]))
        each = ", ".join(measure.text(step.mean, "+") for step in gaps.values())
        text = f"{measure.text(mean, '+')} dB ({each} at {', '.join(gaps)})"
        grid = _mean_range(
            [
                study.grid.shift_db(measure.grid, (roughness, load), (smooth, load), study.factor)
                for load in loads
            ]
        )
        unsure = doubt(mean, lambda x: low_db <= x <= high_db, grid, error)
        numbers = {"mean": mean} | {name: step.mean for name, step in gaps.items()}
        places = tuple((each, load) for load in loads for each in (smooth, roughness))
        holds = low_db <= mean <= high_db
        checks.append(Check(ra(roughness), holds, text, numbers, unsure=unsure, places=places))
    return concluded(checks)


def _mean_range(ranges: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Return the means of the lower ends and of the upper ends of ranges."""
    return float(np.mean([low for low, _ in ranges])), float(np.mean([high for _, high in ranges]))


def rise_over_loads(
    study: Cases, measure: Measure, lowest: float, highest: float, low_db: float, high_db: float
) -> Finding:
    """Judge whether the mean rise from one load to another lies between two bounds.

    The mean is taken over the roughnesses. The verdict is near if the rise on one roughness is
    within the bounds.
    """
    steps = {}
    for roughness in study.roughnesses:
        step = change(
            measure, study.at(roughness, lowest), study.at(roughness, highest), study.factor
        )
        if step:
            steps[roughness] = step
    place = f"{newton(lowest)} to {newton(highest)}"
    if not steps:
        return concluded([Check(place, None)])
    mean = float(np.mean([step.mean for step in steps.values()]))
    error = math.hypot(*(step.error for step in steps.values())) / len(steps)
    grid = _mean_range(
        [
            study.grid.shift_db(
                measure.grid, (roughness, highest), (roughness, lowest), study.factor
            )
            for roughness in steps
        ]
    )
    unsure = doubt(mean, lambda x: low_db <= x <= high_db, grid, error)
    inside = [low_db <= step.mean <= high_db for step in steps.values()]
    each = ", ".join(
        f"{measure.text(step.mean, '+')} {ra(roughness)}" for roughness, step in steps.items()
    )
    text = f"{measure.text(mean, '+')} dB ({each})"
    numbers = {"mean": mean} | {ra(roughness): step.mean for roughness, step in steps.items()}
    places = tuple((roughness, load) for roughness in steps for load in (lowest, highest))
    holds = low_db <= mean <= high_db
    return concluded([Check(place, holds, text, numbers, any(inside), unsure, places)])


def flattens(
    study: Cases, measure: Measure, lowest: float, knee: float, highest: float, most: float
) -> Finding:
    """Judge whether a level rises much less per doubling of the load beyond the knee.

    The rise beyond the knee may be at most a given share of the rise before it. Each roughness is a
    part.
    """
    checks = []
    for roughness in study.roughnesses:
        before = change(
            measure, study.at(roughness, lowest), study.at(roughness, knee), study.factor
        )
        after = change(
            measure, study.at(roughness, knee), study.at(roughness, highest), study.factor
        )
        if before is None or after is None:
            checks.append(Check(f"{ra(roughness)} at {newton(knee)}", None))
            continue
        slope = before.mean / math.log2(knee / lowest), after.mean / math.log2(highest / knee)
        text = f"{slope[1]:+.1f} dB per doubling after {slope[0]:+.1f} dB"
        numbers = {"before": slope[0], "beyond": slope[1]}
        checks.append(
            Check(ra(roughness), slope[0] > 0 and slope[1] <= most * slope[0], text, numbers)
        )
    return concluded(checks)


def stands_apart(
    study: Cases, measure: Measure, roughness: float, low: float, high: float
) -> Finding:
    """Judge whether the gap between two neighbouring loads is large.

    It must be large in itself and larger than any other step.
    """
    means = {load: measure.mean(study.at(roughness, load), study.factor) for load in study.loads}
    known = {load: mean for load, mean in means.items() if mean is not None}
    if low not in known or high not in known:
        return concluded([Check(newton(load), None) for load in (low, high) if load not in known])
    gap = min(mean for load, mean in known.items() if load >= high) - max(
        mean for load, mean in known.items() if load <= low
    )
    others = {
        f"{newton(a)} to {newton(b)}": known[b] - known[a] for a, b in pairwise(known) if a != low
    }
    text = ", ".join(f"{measure.text(value, '+')} dB {name}" for name, value in others.items())
    larger = (
        gap > 0 and all(gap >= LARGEST_STEP * value for value in others.values())
        if others
        else None
    )
    return concluded(
        [
            Check(
                f"gap of {LARGE_GAP_DB:g} dB",
                gap >= LARGE_GAP_DB,
                f"{measure.text(gap, '+')} dB",
                gap,
                places=((roughness, low), (roughness, high)),
                unsure=doubt(
                    gap,
                    lambda x: x >= LARGE_GAP_DB,
                    study.grid.shift_db(
                        measure.grid, (roughness, high), (roughness, low), study.factor
                    ),
                    0.0,
                ),
            ),
            Check("larger than other steps", larger, text, others),
        ]
    )


def within(study: Cases, measure: Measure, roughnesses: Sequence[float], most_db: float) -> Finding:
    """Judge whether the maximum and the minimum mean of the roughnesses lie close together.

    Each load is a part.
    """
    checks = []
    for load in study.loads:
        means = {each: measure.mean(study.at(each, load), study.factor) for each in roughnesses}
        known = {each: mean for each, mean in means.items() if mean is not None}
        if len(known) < 2:
            checks.append(Check(newton(load), None))
            continue
        top, bottom = (
            max(known, key=lambda each: known[each]),
            min(known, key=lambda each: known[each]),
        )
        span = known[top] - known[bottom]
        step = change(measure, study.at(bottom, load), study.at(top, load), study.factor)
        grid = study.grid.shift_db(measure.grid, (top, load), (bottom, load), study.factor)
        unsure = doubt(span, lambda x: x <= most_db, grid, step.error if step else 0.0)
        places = (top, load), (bottom, load)
        text = f"{measure.text(span)} dB"
        checks.append(
            Check(newton(load), span <= most_db, text, span, unsure=unsure, places=places)
        )
    return concluded(checks)
