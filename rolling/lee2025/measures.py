"""The cases of a reading, the numbers of a case, and the change between groups of cases."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from acoustics.bands import MID_HZ
from acoustics.weighting import a_weighting_db
from rolling._typing import Array
from rolling.lee2025.grid_error import GridError
from rolling.lee2025.study import Case, power_level_db

HIGH_HZ = 5000.0


@dataclass(frozen=True)
class Cases:
    """The cases of one reading.

    Parameters
    ----------
    cases : tuple of Case. Cases of the reading.
    factor : int. Factor of lg in the level of a release power, 10 or 20. Default: 10.
    twins : tuple of Case. Cases without hardness of all readings. Default: none.
    grid : GridError. Error of the reading's grid, as far as it was measured. Default: none known.
    """

    cases: tuple[Case, ...]
    factor: int = 10
    twins: tuple[Case, ...] = ()
    grid: GridError = field(default_factory=GridError)

    def at(self, roughness_um: float, load_n: float) -> list[Case]:
        """Return all surfaces of a roughness under a load."""
        return [
            case
            for case in self.cases
            if math.isclose(case.roughness_um, roughness_um) and math.isclose(case.load_n, load_n)
        ]

    def twin(self, case: Case) -> Case | None:
        """Find the same scene without hardness: equal bodies, surface, load and record."""

        def key(scene: Case) -> tuple[object, ...]:
            return (
                scene.bodies,
                scene.roughness_um,
                scene.correlation_um,
                scene.load_n,
                scene.seed,
                scene.duration_s,
            )

        return next((twin for twin in self.twins if key(twin) == key(case)), None)

    def values(self, name: str) -> list[float]:
        """Return the values of a field of Case that occur, rising."""
        return sorted({float(getattr(case, name)) for case in self.cases})

    @property
    def loads(self) -> list[float]:
        """The loads [N], rising."""
        return self.values("load_n")

    @property
    def roughnesses(self) -> list[float]:
        """The roughnesses Ra [um], rising."""
        return self.values("roughness_um")


@dataclass(frozen=True)
class Measure:
    """A number of a case with 10 or 20 lg, with its unit and format; NaN if it is unknown.

    Parameters
    ----------
    of : function. It takes a case and the factor of lg.
    grid : str. Name of its error in `GridError`: a difference [dB] for levels, else a factor.
        Default: empty, for unknown.
    """

    of: Callable[[Case, int], float]
    unit: str = ""
    digits: str = ".2f"
    level: bool = False
    grid: str = ""

    def by_seed(self, group: Sequence[Case], factor: int) -> dict[int, float]:
        """Return the value of each surface that has the measure."""
        values = {case.seed: float(self.of(case, factor)) for case in group}
        return {seed: value for seed, value in values.items() if math.isfinite(value)}

    def mean(self, group: Sequence[Case], factor: int) -> float | None:
        """Return the mean over surfaces, None without a value."""
        values = self.by_seed(group, factor)
        return float(np.mean(list(values.values()))) if values else None

    def deviation(self, group: Sequence[Case], factor: int) -> float | None:
        """Return the standard deviation over surfaces, or None with fewer than two surfaces."""
        values = self.by_seed(group, factor)
        return float(np.std(list(values.values()), ddof=1)) if len(values) > 1 else None

    def relative_error(self, group: Sequence[Case], factor: int) -> float:
        """Compute the relative standard error of the mean over surfaces.

        It is 0 with a single surface.
        """
        values = list(self.by_seed(group, factor).values())
        mean = float(np.mean(values)) if values else 0.0
        return (
            float(np.std(values, ddof=1)) / math.sqrt(len(values)) / mean
            if len(values) > 1 and mean
            else 0.0
        )

    def text(self, value: float | None, sign: str = "") -> str:
        """Write a value without its unit, or a dash for None."""
        return "-" if value is None else f"{value:{sign}{self.digits}}"


@dataclass(frozen=True)
class Statistic:
    """The mean of a measure over surfaces and its standard deviation, None with one surface."""

    mean: float
    std: float | None


@dataclass(frozen=True)
class Change:
    """The change from one group of cases to another, over the seeds that they share.

    Parameters
    ----------
    mean : float. Mean of the change, in the unit of the measure.
    error : float. Its standard error, 0 with one seed.
    """

    mean: float
    error: float

    @property
    def rises(self) -> bool:
        """True if the measure rises by more than twice its standard error."""
        return self.mean > 2 * self.error

    @property
    def falls(self) -> bool:
        """True if the measure falls by more than twice its standard error."""
        return self.mean < -2 * self.error


def change(
    measure: Measure, first: Sequence[Case], then: Sequence[Case], factor: int
) -> Change | None:
    """Compute the change between two groups of cases, or return None if they share no seed.

    A change is certain when it exceeds twice its standard error, with one seed when it exceeds 0.
    Differences are taken seed by seed: the same seed is the same surface under another load, and
    with another roughness where both surfaces are equally wide.
    """
    a, b = measure.by_seed(first, factor), measure.by_seed(then, factor)
    changes = np.array([b[seed] - a[seed] for seed in a if seed in b])
    if not len(changes):
        return None
    return Change(
        float(changes.mean()),
        float(changes.std(ddof=1)) / math.sqrt(len(changes)) if len(changes) > 1 else 0.0,
    )


def _curve_db(case: Case, factor: int) -> Array:
    """Return the article's curve; with 20 lg its levels double, but not their weighting."""
    weighting = a_weighting_db(case.line_hz)
    return factor / 10 * (case.line_db - weighting) + weighting


def _maximum_db(case: Case, factor: int) -> float:
    """Return the maximum line level, which with 20 lg may occur at another frequency."""
    return case.maximum_db if factor == 10 else case.maximum_20_db


def _high_band_db(case: Case, factor: int) -> float:
    """Return the mean height of the article's curve above HIGH_HZ [dB]."""
    curve = _curve_db(case, factor)
    high = curve[(case.line_hz >= HIGH_HZ) & np.isfinite(curve)]
    return float(high.mean()) if len(high) else math.nan


def _audible_db(case: Case, factor: int) -> float:
    """Return the A-weighted level of the whole sound.

    With 10 lg it is LAeq, which is 10 lg of the fully weighted fluctuation.
    """
    if factor == 10:
        return math.nan if case.laeq_db is None else case.laeq_db
    return float(power_level_db(case.a_weighted_w, factor))


def _centroid_hz(case: Case, factor: int) -> float:
    """Return the spectral centroid of the squared fluctuation [Hz]."""
    square = np.nan_to_num(case.band_w) ** 2
    return float(square @ MID_HZ / square.sum()) if square.sum() > 0 else math.nan


PRESSURE = Measure(lambda case, factor: case.max_pressure * 1e-9, "GPa", ".3f")
PLASTIC_RATIO = Measure(
    lambda case, factor: case.plastic_ratio, "of the Hertz area", ".3f", grid="plastic"
)
# The Hertz area grows with load^(2/3) (Johnson, Contact Mechanics 1985, 4.2), and is the same for
# all roughnesses.
PLASTIC_AREA = Measure(
    lambda case, factor: case.plastic_ratio * case.load_n ** (2 / 3),
    "Hertz areas of 1 N",
    grid="plastic",
)
CONTACT_AREA = Measure(
    lambda case, factor: case.contact_ratio * case.load_n ** (2 / 3), "Hertz areas of 1 N"
)
DEFLECTION = Measure(lambda case, factor: case.deflection * 1e6, "µm", ".3f", grid="deflection")
MAXIMUM = Measure(_maximum_db, "dB", ".1f", level=True, grid="line_db")
AUDIBLE = Measure(_audible_db, "dB", ".1f", level=True, grid="level_db")
HIGH_BAND = Measure(_high_band_db, "dB", ".1f", level=True, grid="high_db")
CENTROID = Measure(_centroid_hz, "Hz", ".0f")


def ra(roughness_um: float) -> str:
    """Write a roughness, such as "Ra 0.1 µm"."""
    return f"Ra {roughness_um:g} µm"


def newton(load_n: float) -> str:
    """Write a load, such as "5 N"."""
    return f"{load_n:g} N"


def series(
    study: Cases, measure: Measure, groups: Sequence[tuple[str, Sequence[Case]]]
) -> tuple[str, dict[str, Statistic]]:
    """Return means and deviations of groups, in words and as data.

    Levels without an absolute value are relative to the first group.
    """
    statistics = [
        (name, measure.mean(group, study.factor), measure.deviation(group, study.factor))
        for name, group in groups
    ]
    known = [(name, mean, deviation) for name, mean, deviation in statistics if mean is not None]
    relative = measure.level and study.factor != 10
    base, sign = (known[0][1], "+") if known and relative else (0.0, "")
    words = [
        measure.text(mean - base, sign)
        + ("" if deviation is None else f" ± {measure.text(deviation)}")
        for _, mean, deviation in known
    ]
    numbers = {name: Statistic(mean - base, deviation) for name, mean, deviation in known}
    return f"{', '.join(words)} {measure.unit} ({', '.join(numbers)})", numbers
