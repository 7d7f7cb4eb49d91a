"""What Lee, Kim & Kim (2025) state, judged by the cases of a study: measured under each reading, with verdict and tolerance.

Numbers only: claims_text writes them down. Depends on study; solves nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acoustics.bands import MID_HZ
from acoustics.weighting import a_weighting_db
from rolling.study import Case, power_level_db

Array = NDArray[np.float64]

REPRODUCED, PARTLY, NOT, NOT_RUN = "reproduced", "partly", "not", "not run"
WORTH = {REPRODUCED: 1.0, PARTLY: 0.5, NOT: 0.0, NOT_RUN: 0.0}

SMOOTH, MIDDLE, ROUGH, ROUGHEST = 0.01, 0.1, 1.0, 5.0  # Ra [um] of the article
ROUGHNESSES = (SMOOTH, MIDDLE, ROUGH, ROUGHEST)
YIELDING = (MIDDLE, ROUGH, ROUGHEST)
LOADS = (5.0, 10.0, 20.0, 50.0, 100.0)  # [N]
SCALES = (10, 20)  # a level is that many times the logarithm of a release power

LIMIT = 2.1e9  # [Pa] where the article's plate yields
NO_AREA = 0.005  # of the Hertz area: less than a mark in a figure from 0 to 1
SQUEAL_DB = 70.0
HIGH_HZ = 5000.0
LARGE_GAP_DB = 6.0
LARGEST_STEP = 1.5  # 20 to 50 N is 2.5 times the load, the other steps twice: 1.3 of them come without any jump


# ---- the cases of a reading ------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Cases:
    """Cases of one reading; the levels of them are `factor` lg of a release power."""

    cases: tuple[Case, ...]
    factor: int = 10

    def at(self, roughness_um: float, load_n: float) -> list[Case]:
        """The surfaces of one roughness under one load."""
        return [c for c in self.cases if math.isclose(c.roughness_um, roughness_um) and math.isclose(c.load_n, load_n)]

    def values(self, name: str) -> list[float]:
        """The values there are of what a study varies, a field of Case, rising."""
        return sorted({float(getattr(case, name)) for case in self.cases})

    @property
    def loads(self) -> list[float]:
        return self.values("load_n")

    @property
    def roughnesses(self) -> list[float]:
        return self.values("roughness_um")


@dataclass(frozen=True)
class Measure:
    """A number of a case with 10 or 20 lg, and how it is told; NaN where there is none."""

    of: Callable[[Case, int], float]
    unit: str = ""
    digits: str = ".2f"
    level: bool = False

    def by_seed(self, group: Sequence[Case], factor: int) -> dict[int, float]:
        """The value of each surface that has one."""
        found = {case.seed: float(self.of(case, factor)) for case in group}
        return {seed: value for seed, value in found.items() if math.isfinite(value)}

    def mean(self, group: Sequence[Case], factor: int) -> float | None:
        found = self.by_seed(group, factor)
        return float(np.mean(list(found.values()))) if found else None

    def deviation(self, group: Sequence[Case], factor: int) -> float | None:
        """Standard deviation of the surfaces, if there are several."""
        found = self.by_seed(group, factor)
        return float(np.std(list(found.values()), ddof=1)) if len(found) > 1 else None

    def told(self, value: float | None, sign: str = "") -> str:
        return "-" if value is None else f"{value:{sign}{self.digits}}"


@dataclass(frozen=True)
class Change:
    """From one group of cases to another: mean over the seeds they share, and whether it rises or falls for certain."""

    mean: float
    rises: bool
    falls: bool


def change(measure: Measure, first: Sequence[Case], then: Sequence[Case], factor: int) -> Change | None:
    """What changes between two groups; None if they share no seed.

    Certain is what exceeds twice its standard error, with one seed what exceeds 0. Differences are taken seed by seed:
    the same seed is the same surface under another load, and its neighbour in roughness.
    """
    a, b = measure.by_seed(first, factor), measure.by_seed(then, factor)
    found = np.array([b[seed] - a[seed] for seed in a if seed in b])
    if not len(found):
        return None
    mean = float(found.mean())
    least = 2 * float(found.std(ddof=1)) / math.sqrt(len(found)) if len(found) > 1 else 0.0
    return Change(mean, mean > least, mean < -least)


def _rises(step: Change | None) -> bool | None:
    return None if step is None else step.rises


def _falls(step: Change | None) -> bool | None:
    return None if step is None else step.falls


def _curve_db(case: Case, factor: int) -> Array:
    """The article's curve as it is with 10 lg; with 20 lg its levels double, but not their weighting."""
    weighting = a_weighting_db(case.line_hz)
    return factor / 10 * (case.line_db - weighting) + weighting


def _maximum_db(case: Case, factor: int) -> float:
    """The greatest line, which with 20 lg may be at another frequency."""
    return case.maximum_db if factor == 10 else case.maximum_20_db


def _high_band_db(case: Case, factor: int) -> float:
    """Mean height of the article's curve above HIGH_HZ [dB]."""
    curve = _curve_db(case, factor)
    high = curve[(case.line_hz >= HIGH_HZ) & np.isfinite(curve)]
    return float(high.mean()) if len(high) else math.nan


def _audible_db(case: Case, factor: int) -> float:
    """A-weighted level of the whole: LAeq is 10 lg of the fluctuation, weighted in full."""
    if factor == 10:
        return math.nan if case.laeq_db is None else case.laeq_db
    return float(power_level_db(case.a_weighted_w, factor))


def _centroid_hz(case: Case, factor: int) -> float:
    """Spectral centroid of the squared fluctuation [Hz]."""
    square = np.nan_to_num(case.band_w) ** 2
    return float(square @ MID_HZ / square.sum()) if square.sum() > 0 else math.nan


PRESSURE = Measure(lambda case, factor: case.max_pressure * 1e-9, "GPa", ".3f")
PLASTIC_RATIO = Measure(lambda case, factor: case.plastic_ratio, "of the Hertz area", ".3f")
# The Hertz area grows with load^(2/3) (Johnson, Contact Mechanics 1985, 4.2), and is the same for all roughnesses.
PLASTIC_AREA = Measure(lambda case, factor: case.plastic_ratio * case.load_n ** (2 / 3), "Hertz areas of 1 N")
CONTACT_AREA = Measure(lambda case, factor: case.contact_ratio * case.load_n ** (2 / 3), "Hertz areas of 1 N")
DEFLECTION = Measure(lambda case, factor: case.deflection * 1e6, "µm")
MAXIMUM = Measure(_maximum_db, "dB", ".1f", level=True)
AUDIBLE = Measure(_audible_db, "dB", ".1f", level=True)
HIGH_BAND = Measure(_high_band_db, "dB", ".1f", level=True)
CENTROID = Measure(_centroid_hz, "Hz", ".0f")


# ---- what is found ---------------------------------------------------------------------------------------------------


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


# ---- shapes of statements --------------------------------------------------------------------------------------------


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


def gap_over_smooth(study: Cases, measure: Measure, low_db: float, high_db: float) -> Finding:
    """How far each rougher surface lies above the smoothest, in the mean over the loads."""
    checks = []
    for roughness in YIELDING:
        gaps = {}
        for load in study.loads:
            step = change(measure, study.at(SMOOTH, load), study.at(roughness, load), study.factor)
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


def rise_over_loads(study: Cases, measure: Measure, low_db: float, high_db: float) -> Finding:
    """From the least to the greatest load of the article, in the mean over the roughnesses; near if one of them does."""
    least, greatest = LOADS[0], LOADS[-1]
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


def flattens(study: Cases, measure: Measure, knee: float, most: float) -> Finding:
    """Per doubling of the load it rises beyond the knee at most that share of what it does before; per roughness."""
    least, greatest = LOADS[0], LOADS[-1]
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


# ---- the statements --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Claim:
    """A statement of the article in our words: where it stands, when it counts as reproduced, and what judges it.

    level : judged with 10 lg and with 20 lg. varied : the field of Case that a sweep must vary for it; None for the
    study of roughness and load.
    """

    key: str
    where: str
    statement: str
    tolerance: str
    judge: Callable[[Cases], Finding]
    level: bool = False
    varied: str | None = None


_WHOLE = "A-weighted level of the whole: LAeq, or 20 lg of the weighted fluctuation."
_UP = "Every step up by more than twice its standard error over the surfaces, with one surface by more than 0"

CLAIMS = (
    Claim(
        "pressure-below-limit",
        "section 3, Fig. 5a",
        "On the smoothest surface (Ra 0.01 µm) pressure never gets to the 2.1 GPa where the plate yields, not even at 100 N.",
        "Greatest pressure of all surfaces below 2.1 GPa at each load; partly: at some loads.",
        partial(below_limit, roughness=SMOOTH, limit=LIMIT),
    ),
    Claim(
        "pressure-load",
        "section 3, Fig. 5a",
        "At Ra 0.01 µm the contact pressure grows with the load.",
        f"{_UP}; partly: some steps.",
        partial(rises_with_load, measure=PRESSURE, roughnesses=(SMOOTH,)),
    ),
    Claim(
        "contact-area-load",
        "section 3, Fig. 5a",
        "At Ra 0.01 µm the contact area grows with the load.",
        f"{_UP}; partly: some steps.",
        partial(rises_with_load, measure=CONTACT_AREA, roughnesses=(SMOOTH,)),
    ),
    Claim(
        "plastic-none",
        "section 3, Fig. 7",
        "At Ra 0.01 µm nothing yields at any load.",
        f"Plastic area below {NO_AREA:g} of the Hertz area at each load, less than a mark in the figure; partly: some loads.",
        partial(no_plastic_area, roughness=SMOOTH),
    ),
    Claim(
        "hardness-reached",
        "section 3, Fig. 5b to d",
        "From Ra 0.1 µm on the greatest pressure is the one at which the plate yields.",
        "Some plastic area on every surface at each load, whatever pressure the reading caps at; partly: some of them.",
        partial(hardness_reached, roughnesses=YIELDING),
    ),
    Claim(
        "plastic-area-load",
        "section 3, Fig. 5",
        "From Ra 0.1 µm on a higher load makes the area larger that yields.",
        f"{_UP}, on each roughness; partly: some roughnesses.",
        partial(rises_with_load, measure=PLASTIC_AREA, roughnesses=YIELDING),
    ),
    Claim(
        "plastic-area-roughness",
        "section 3, Fig. 5",
        "The rougher the surface, the larger the area that yields.",
        f"{_UP}, at each load; partly: some steps of roughness.",
        partial(rises_with_roughness, measure=PLASTIC_AREA, roughnesses=ROUGHNESSES),
    ),
    Claim(
        "plastic-ratio-load",
        "section 3, Fig. 7",
        "From Ra 0.1 µm on the plastic area grows faster with the load than the Hertz area does.",
        f"{_UP}, on each roughness; partly: some roughnesses.",
        partial(rises_with_load, measure=PLASTIC_RATIO, roughnesses=YIELDING),
    ),
    Claim(
        "plastic-ratio-1-over-0.1",
        "section 3, Fig. 7; conclusions",
        "At any load about half as much again yields at Ra 1 µm as at Ra 0.1 µm.",
        "Ratio of the means 1.3 to 1.7 at each load; partly: at some loads.",
        partial(ratio_at_each_load, measure=PLASTIC_RATIO, over=ROUGH, under=MIDDLE, low=1.3, high=1.7),
    ),
    Claim(
        "plastic-ratio-5-like-1",
        "section 3, Fig. 7; conclusions",
        "About as much yields at Ra 5 µm as at Ra 1 µm.",
        "Ratio of the means 0.85 to 1.15 at each load; partly: at some loads.",
        partial(ratio_at_each_load, measure=PLASTIC_RATIO, over=ROUGHEST, under=ROUGH, low=0.85, high=1.15),
    ),
    Claim(
        "deflection-roughest",
        "section 3, Fig. 6",
        "The roughest plate (Ra 5 µm) is deflected least.",
        "Greatest deflection lower than on each other roughness by more than twice the standard error, with one surface by"
        " more than 0, at each load; partly: at some loads.",
        partial(lowest_of_all, measure=DEFLECTION, roughness=ROUGHEST),
    ),
    Claim(
        "level-roughness",
        "abstract; section 3, Fig. 8",
        "Within hearing, a rougher surface is louder.",
        f"{_WHOLE} {_UP}, at each load; partly: some steps of roughness.",
        partial(rises_with_roughness, measure=AUDIBLE, roughnesses=ROUGHNESSES),
        level=True,
    ),
    Claim(
        "level-load",
        "abstract; section 3, Fig. 8; conclusions",
        "Within hearing, a higher load is louder.",
        f"{_WHOLE} {_UP}, on each roughness; partly: some roughnesses.",
        partial(rises_with_load, measure=AUDIBLE, roughnesses=ROUGHNESSES),
        level=True,
    ),
    Claim(
        "level-above-70",
        "abstract; section 3, Fig. 8; conclusions",
        "From Ra 0.1 µm on levels pass the 70 dB of a squeal.",
        "Greatest line above 70 dB at some load (the article does not say at which) on each roughness; partly: some"
        " roughnesses. Lines depend on the length of the record, which the article does not give: 5 dB less for one ten"
        " times as long.",
        partial(exceeds, measure=MAXIMUM, roughnesses=YIELDING, least_db=SQUEAL_DB),
        level=True,
    ),
    Claim(
        "high-frequency-gap",
        "section 3, Fig. 8a",
        "At Ra 0.01 µm the high-frequency spectra of 50 N and more lie far above those of 20 N and less.",
        f"Mean height of the curve above {HIGH_HZ / 1000:g} kHz: from the highest to 20 N to the lowest from 50 N at least"
        f" {LARGE_GAP_DB:g} dB, and {LARGEST_STEP:g} times any other step between loads; partly: one of the two.",
        partial(stands_apart, measure=HIGH_BAND, roughness=SMOOTH, low=20.0, high=50.0),
        level=True,
    ),
    Claim(
        "maximum-over-smooth",
        "abstract; section 3, Fig. 9; conclusions",
        "The greatest line from Ra 0.1 µm on lies some 10 to 15 dB above that of Ra 0.01 µm.",
        "Mean over the loads 8 to 17 dB on each roughness; partly: some roughnesses.",
        partial(gap_over_smooth, measure=MAXIMUM, low_db=8.0, high_db=17.0),
        level=True,
    ),
    Claim(
        "maximum-load",
        "section 3, Fig. 9",
        "From 5 to 100 N the greatest line gains some 14 dB, averaged over the four surfaces.",
        "Average 12 to 16 dB; partly: not the average, but some roughness.",
        partial(rise_over_loads, measure=MAXIMUM, low_db=12.0, high_db=16.0),
        level=True,
    ),
    Claim(
        "maximum-flattens",
        "section 3, Fig. 9",
        "Beyond 50 N the greatest line gains little.",
        "Per doubling of the load at most half of the gain per doubling from 5 to 50 N, on each roughness; partly: some"
        " roughnesses.",
        partial(flattens, measure=MAXIMUM, knee=50.0, most=0.5),
        level=True,
    ),
    Claim(
        "loudest-20-50",
        "section 3, Fig. 9",
        "At 20 and at 50 N, Ra 1 µm is the loudest.",
        "Highest mean of the greatest line at both loads; partly: at one, or another's lead is within twice its standard"
        " error.",
        partial(loudest, measure=MAXIMUM, roughness=ROUGH, loads=(20.0, 50.0)),
        level=True,
    ),
    Claim(
        "loudest-100",
        "section 3, Fig. 9",
        "At 100 N, Ra 5 µm is the loudest.",
        "Highest mean of the greatest line; partly: another's lead is within twice its standard error.",
        partial(loudest, measure=MAXIMUM, roughness=ROUGHEST, loads=(100.0,)),
        level=True,
    ),
    Claim(
        "little-influence",
        "section 3, Fig. 9",
        "From Ra 0.1 µm on roughness hardly matters to the greatest line.",
        "At each load the three lie within 5 dB, the width of the article's own 10 to 15 dB; partly: at some loads.",
        partial(within, measure=MAXIMUM, roughnesses=YIELDING, most_db=5.0),
        level=True,
    ),
)

_DOWN = "Every step up of the length lowers it by more than twice the standard error, with one surface by more than 0"

OUTLOOK = (
    Claim(
        "length-frequency",
        "section 3, outlook",
        "A short autocorrelation length makes for high-frequency noise, a long one for low.",
        f"Spectral centroid of the fluctuation. {_DOWN}; partly: some steps.",
        partial(falls_along, measure=CENTROID, varied="correlation_um", unit=" µm"),
        varied="correlation_um",
    ),
    Claim(
        "length-level",
        "section 3, outlook",
        "A short autocorrelation length makes for intense noise, a long one for quiet.",
        f"{_WHOLE} {_DOWN}; partly: some steps.",
        partial(falls_along, measure=AUDIBLE, varied="correlation_um", unit=" µm"),
        level=True,
        varied="correlation_um",
    ),
)


# ---- the table -------------------------------------------------------------------------------------------------------


def table(cases: Sequence[Case]) -> dict[str, Any]:
    """All statements judged under all readings, for JSON: numbers are finite or None.

    Returns
    -------
    claims : each with key, where, statement, tolerance, and findings of each reading and scale (10 or 20 lg; None where
    no level is judged). readings : what there is of each and what of the article's it lacks. scores : the readings and
    scales from best to worst, without those that are about the outlook only.
    """
    readings = {name: tuple(c for c in cases if c.reading == name) for name in dict.fromkeys(c.reading for c in cases)}
    rows = [
        {
            "key": claim.key,
            "where": claim.where,
            "statement": claim.statement,
            "tolerance": claim.tolerance,
            "outlook": claim.varied is not None,
            "findings": [
                {"reading": name, "scale": scale if claim.level else None} | asdict(_judged(claim, Cases(group, scale)))
                for name, group in readings.items()
                for scale in (SCALES if claim.level else SCALES[:1])
            ],
        }
        for claim in (*CLAIMS, *OUTLOOK)
    ]
    return {
        "readings": {name: _extent(Cases(group)) for name, group in readings.items()},
        "claims": rows,
        "scores": _scores(rows, [name for name, group in readings.items() if _swept(Cases(group)) is None]),
    }


def _swept(study: Cases) -> str | None:
    """What a reading varies besides roughness and load: a reading that does is about that alone."""
    return next((c.varied for c in OUTLOOK if c.varied and len(study.values(c.varied)) > 1), None)


def _judged(claim: Claim, study: Cases) -> Finding:
    swept = _swept(study)
    if claim.varied == swept:
        return claim.judge(study)
    return Finding(NOT_RUN, "this reading does not vary it" if claim.varied else "this reading varies something else")


def _extent(study: Cases) -> dict[str, Any]:
    """What there is of a reading, and the article's roughnesses, loads and single cases that it lacks."""
    swept = _swept(study)
    lacks = []
    if swept is None:
        lacks = [ra(one) for one in ROUGHNESSES if one not in study.roughnesses]
        lacks += [newton(one) for one in LOADS if one not in study.loads]
        both = [(a, b) for a in ROUGHNESSES for b in LOADS if a in study.roughnesses and b in study.loads]
        lacks += [f"{ra(a)} at {newton(b)}" for a, b in both if not study.at(a, b)]
    return {
        "cases": len(study.cases),
        "roughnesses_um": study.roughnesses,
        "loads_n": study.loads,
        "surfaces": len({case.seed for case in study.cases}),
        "durations_s": study.values("duration_s"),
        "swept": swept,
        "lacks": lacks,
    }


def _scores(rows: Sequence[dict[str, Any]], readings: Sequence[str]) -> list[dict[str, Any]]:
    """1 for each statement reproduced, half for partly, of those that were judged; equal scores share a rank."""
    scores: list[dict[str, Any]] = []
    for reading in readings:
        for scale in SCALES:
            verdicts = {
                row["key"]: one["verdict"]
                for row in rows
                for one in row["findings"]
                if not row["outlook"] and one["reading"] == reading and one["scale"] in (None, scale)
            }
            score = {"reading": reading, "scale": scale, "score": sum(WORTH[word] for word in verdicts.values())}
            counts = {word: list(verdicts.values()).count(word) for word in WORTH}
            scores.append(score | {"counts": counts, "judged": len(verdicts) - counts[NOT_RUN], "verdicts": verdicts})
    scores.sort(key=lambda one: -one["score"])
    for one in scores:
        one["rank"] = 1 + sum(other["score"] > one["score"] for other in scores)
    return scores
