"""What a statement is judged by: the cases of a reading, the numbers of a case, and how they change from one group to another.

Depends on study and grid_error; judges nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from acoustics.bands import MID_HZ
from acoustics.weighting import a_weighting_db
from rolling.lee2025.grid_error import GridError
from rolling.lee2025.study import Case, power_level_db

Array = NDArray[np.float64]

HIGH_HZ = 5000.0


@dataclass(frozen=True)
class Cases:
    """Cases of one reading; the levels of them are `factor` lg of a release power.

    twins : the cases without hardness of all readings.  grid : error of the reading's grid, as far as it was measured.
    """

    cases: tuple[Case, ...]
    factor: int = 10
    twins: tuple[Case, ...] = ()
    grid: GridError = field(default_factory=GridError)

    def at(self, roughness_um: float, load_n: float) -> list[Case]:
        """The surfaces of one roughness under one load."""
        return [c for c in self.cases if math.isclose(c.roughness_um, roughness_um) and math.isclose(c.load_n, load_n)]

    def twin(self, case: Case) -> Case | None:
        """Find the same scene without hardness: same bodies, surface, load and record."""

        def key(one: Case) -> tuple[object, ...]:
            return one.bodies, one.roughness_um, one.correlation_um, one.load_n, one.seed, one.duration_s

        return next((one for one in self.twins if key(one) == key(case)), None)

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
    """A number of a case with 10 or 20 lg, and how it is told; NaN where there is none.

    grid : name of its error in `GridError`; empty: not known. Of levels it is a difference [dB], of the rest a factor.
    """

    of: Callable[[Case, int], float]
    unit: str = ""
    digits: str = ".2f"
    level: bool = False
    grid: str = ""

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

    def relative_error(self, group: Sequence[Case], factor: int) -> float:
        """Compute the standard error of the mean over surfaces divided by that mean; 0 with one surface."""
        found = list(self.by_seed(group, factor).values())
        mean = float(np.mean(found)) if found else 0.0
        return float(np.std(found, ddof=1)) / math.sqrt(len(found)) / mean if len(found) > 1 and mean else 0.0

    def told(self, value: float | None, sign: str = "") -> str:
        return "-" if value is None else f"{value:{sign}{self.digits}}"


@dataclass(frozen=True)
class Change:
    """From one group of cases to another, over the seeds they share; `error`: standard error of the mean, 0 with one seed."""

    mean: float
    error: float

    @property
    def rises(self) -> bool:
        """Whether it rises by more than twice its standard error."""
        return self.mean > 2 * self.error

    @property
    def falls(self) -> bool:
        """Whether it falls by more than twice its standard error."""
        return self.mean < -2 * self.error


def change(measure: Measure, first: Sequence[Case], then: Sequence[Case], factor: int) -> Change | None:
    """What changes between two groups; None if they share no seed.

    Certain is what exceeds twice its standard error, with one seed what exceeds 0. Differences are taken seed by seed:
    the same seed is the same surface under another load, and of another roughness where both are as wide.
    """
    a, b = measure.by_seed(first, factor), measure.by_seed(then, factor)
    found = np.array([b[seed] - a[seed] for seed in a if seed in b])
    if not len(found):
        return None
    return Change(float(found.mean()), float(found.std(ddof=1)) / math.sqrt(len(found)) if len(found) > 1 else 0.0)


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
PLASTIC_RATIO = Measure(lambda case, factor: case.plastic_ratio, "of the Hertz area", ".3f", grid="plastic")
# The Hertz area grows with load^(2/3) (Johnson, Contact Mechanics 1985, 4.2), and is the same for all roughnesses.
PLASTIC_AREA = Measure(
    lambda case, factor: case.plastic_ratio * case.load_n ** (2 / 3), "Hertz areas of 1 N", grid="plastic"
)
CONTACT_AREA = Measure(lambda case, factor: case.contact_ratio * case.load_n ** (2 / 3), "Hertz areas of 1 N")
DEFLECTION = Measure(lambda case, factor: case.deflection * 1e6, "µm", ".3f", grid="deflection")
MAXIMUM = Measure(_maximum_db, "dB", ".1f", level=True, grid="line_db")
AUDIBLE = Measure(_audible_db, "dB", ".1f", level=True, grid="level_db")
HIGH_BAND = Measure(_high_band_db, "dB", ".1f", level=True, grid="high_db")
CENTROID = Measure(_centroid_hz, "Hz", ".0f")
