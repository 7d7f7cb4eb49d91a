"""What a statement is judged by: the cases of a reading, the numbers of a case, and how they change from one group to another.

Depends on study; judges nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acoustics.bands import MID_HZ
from acoustics.weighting import a_weighting_db
from rolling.article.study import Case, power_level_db

Array = NDArray[np.float64]

HIGH_HZ = 5000.0


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
    the same seed is the same surface under another load, and of another roughness where both are as wide.
    """
    a, b = measure.by_seed(first, factor), measure.by_seed(then, factor)
    found = np.array([b[seed] - a[seed] for seed in a if seed in b])
    if not len(found):
        return None
    mean = float(found.mean())
    least = 2 * float(found.std(ddof=1)) / math.sqrt(len(found)) if len(found) > 1 else 0.0
    return Change(mean, mean > least, mean < -least)


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
