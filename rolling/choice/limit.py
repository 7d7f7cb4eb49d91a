"""Answer to the inverse question: which value of a key stays below a level, and how it was found.

The limit holds for a single specimen: 95 % of specimens lie below it, with a confidence of 95 %, by
the one-sided tolerance limit of a normal distribution over specimens. `limit_search` computes it.

Places of a scan share its ridges. Their mean has the variance of n_e independent places, and their
standard deviation has fewer degrees of freedom f (`acoustics.pairs`). Both stand in the limit in
place of the number of places n and of n - 1. It is rather too high than too low then, because the
mean and the deviation of correlated values are taken to be independent.

References
----------
ISO 16269-6:2014, Determination of statistical tolerance intervals. Its factors for an unknown mean
and standard deviation follow from the noncentral t distribution.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.special import nctdtrit, ndtri

from acoustics.arrays import Array
from acoustics.numbers import rounded
from acoustics.pairs import SURE, PairedMean, paired_mean, sureness
from acoustics.texts import printable
from rolling.choice.advice import Advice
from rolling.choice.choice_sentences import counted_places
from rolling.choice.heard_specimen import HeardQuantity
from rolling.results import labels
from rolling.scene import library
from rolling.scene.surfaces import GRADES

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

Value = float | str

LEAST_TOLD_DB = 0.1  # by which a wider scan lowers a limit, and a sentence says so
FEWEST = 3  # specimens for which a tolerance limit is stated
SHARE = 0.95  # of specimens that lie below a tolerance limit
CONFIDENCE = 0.95
GRADE = "grade"  # last name of a key that takes the name of a grade of balls
FINISH = "finish"  # and of a finish


@dataclass(frozen=True, eq=False)
class Point:
    """A value of the search, and what is heard of its specimens.

    Attributes
    ----------
    value : float or str
        The value.
    levels_db : (specimens,) array, dB(A)
        What a listener would hear of each specimen, at the louder of the loss factors.
    correlation : (specimens, specimens) array or None
        Correlation of the levels of places of a scan; None, the default, where each specimen has a
        surface of its own.
    """

    value: Value
    levels_db: Array
    correlation: Array | None = None

    @property
    def mean_db(self) -> float:
        """Mean level, dB(A)."""
        return float(np.mean(self.levels_db))

    @property
    def upper_db(self) -> float:
        """Tolerance limit, dB(A): 95 % of specimens lie below, with 95 % confidence."""
        return tolerance_limit(self.levels_db, self.correlation)

    @property
    def deviation_db(self) -> float:
        """Standard deviation of the levels [dB], that of independent places."""
        of_levels = _mean_of(self.levels_db, self.correlation)
        return of_levels.error * math.sqrt(of_levels.independent)

    @property
    def independent(self) -> float | None:
        """Number of independent places that the places of a scan count as; None without a scan."""
        if self.correlation is None:
            return None
        return _mean_of(self.levels_db, self.correlation).independent

    @property
    def wider_db(self) -> float:
        """By how much [dB] a scan with twice as many independent places would lower the limit."""
        of_levels = _mean_of(self.levels_db, self.correlation)
        factor = tolerance_factor(2 * of_levels.independent, 2 * of_levels.freedom + 1)
        return self.upper_db - (self.mean_db + factor * self.deviation_db)

    def words(self, noun: str) -> str:
        """Say how many specimens there are, and as how many independent ones they count."""
        return counted_places(len(self.levels_db), self.independent, noun)


class Fall(NamedTuple):
    """Two neighbouring values between which the level falls where it should rise."""

    quieter: Value
    louder: Value


@dataclass(frozen=True, eq=False, repr=False)
class Limit(Advice):
    """Answer to the question which value of a key stays below a level.

    Attributes
    ----------
    name, key : str
        Name of the scene, and the dotted key.
    quantity : HeardQuantity
        The quantity whose level stays below: the vibration of a ball, a band of a bearing.
    level_db : float
        The limit, dB(A) or dB re 1 um/s.
    points : list of Point
        Computed values, in the order of the search.
    value : float or str, or None
        The coarsest value below the limit; None where no value is.
    rises : bool
        Whether the level rises with the value, so that the coarsest value is the largest one.
    falls : list of Fall
        Where the level does not follow that direction.
    noun : str
        What the specimens are: surfaces, or places of the scan.
    notes : list of str
        What became of the range.
    folder : Path
        Folder of the specimens.
    scene : scene, optional
        The scene whose key is searched, which the page draws. Default: none.

    Examples
    --------
    >>> from pathlib import Path
    >>> import numpy as np, rolling
    >>> from rolling.choice.audition import SOUND
    >>> from rolling.choice.limit import Point
    >>> points = [Point(1.0, np.array([28.0, 29.0, 28.5])), Point(1.04, np.array([30.0, 31, 30]))]
    >>> limit = rolling.Limit(
    ...     name="scene", key="plate.thickness_mm", quantity=SOUND, level_db=33.0, points=points,
    ...     value=1.0, rises=True, falls=[], noun="surfaces", notes=[], folder=Path(),
    ... )
    >>> limit.next_louder.value
    1.04
    """

    name: str
    key: str
    quantity: HeardQuantity
    level_db: float
    points: list[Point]
    value: Value | None
    rises: bool
    falls: list[Fall]
    noun: str
    notes: list[str]
    folder: Path
    scene: Any = None

    @property
    def ordered(self) -> list[Point]:
        """Computed values from the quiet end to the loud end."""
        return from_quiet(self.points, self.rises, self.key)

    @property
    def next_louder(self) -> Point | None:
        """The computed value after the answer; None at the end of the range."""
        ordered = self.ordered
        for point, louder in pairwise(ordered):
            if point.value == self.value:
                return louder
        return None

    def at(self, value: Value) -> Point:
        """Return the computed point of a value."""
        return next(point for point in self.points if point.value == value)

    def table(self) -> pd.DataFrame:
        """Tabulate the search.

        Returns
        -------
        table : pandas.DataFrame
            One row per computed value in the order of the search: order, value, vibration_db (mean
            over specimens; medium_db of a bearing), vibration_deviation_db (their standard
            deviation), tolerance_limit_db, specimens, independent_places (only of a scan: as how
            many they count), is_below, is_answer.
        """
        import pandas as pd  # slow to import, for tables only

        rows: list[dict[str, Any]] = []
        for number, point in enumerate(self.points, start=1):
            row = {
                "order": number,
                self.key: point.value,
                f"{self.quantity.name}_db": point.mean_db,
                f"{self.quantity.name}_deviation_db": point.deviation_db,
                "tolerance_limit_db": point.upper_db,
                "specimens": len(point.levels_db),
            }
            if point.independent is not None:
                row["independent_places"] = point.independent
            row["is_below"] = point.upper_db <= self.level_db
            row["is_answer"] = point.value == self.value
            rows.append(row)
        return pd.DataFrame(rows)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the path of the search: levels with their tolerance limits over the value."""
        from rolling.choice.advice_pictures import plot_limit

        return plot_limit(self, ax)

    @property
    def found_by(self) -> list[str]:
        """Sentences on how the answer was found."""
        searched = [
            f"The value of {self.key} was searched on the same {self.noun} at each value. A value"
            " counts as below the level where the one-sided tolerance limit of ISO 16269-6 lies"
            " below it: of 95 % of specimens, with 95 % confidence."
        ]
        if any(point.independent is not None for point in self.points):
            searched.append(
                "Places of a scan count as the number of independent ones that the correlation of"
                " their levels leaves."
            )
        return searched

    @property
    def sentences(self) -> list[str]:
        """The answer in words, and what to doubt."""
        return [*_sentences(self)]


# ---- the tolerance limit


def tolerance_factor(
    count: float,
    freedom: float | None = None,
    share: float = SHARE,
    confidence: float = CONFIDENCE,
) -> float:
    """Return the factor of a one-sided normal tolerance limit over the standard deviation.

    Mean plus factor times deviation of a number of values is above a share of all values, with the
    confidence (ISO 16269-6, unknown mean and deviation).

    Parameters
    ----------
    count : float
        Number of independent values.
    freedom : float, optional
        Degrees of freedom of the deviation. Default: one less than the values.
    share, confidence : float
        Share of all values, and how sure it is.
    """
    root = math.sqrt(count)
    of_deviation = count - 1 if freedom is None else freedom
    return float(nctdtrit(of_deviation, ndtri(share) * root, confidence)) / root


def tolerance_limit(levels_db: Array, correlation: Array | None = None) -> float:
    """Return the one-sided tolerance limit of levels.

    Silence is minus infinity. The limit is infinite where nothing is known of the scatter, because
    all places of a scan are as good as one.

    Parameters
    ----------
    levels_db : (specimens,) array, dB
        Level of each specimen.
    correlation : (specimens, specimens) array, optional
        Correlation of the levels of places of a scan. Default: they are independent.
    """
    is_finite = np.isfinite(levels_db)
    finite = levels_db[is_finite]
    if not len(finite):
        return -math.inf
    if len(finite) < FEWEST:
        return float(finite.max())
    if correlation is not None:
        correlation = correlation[np.ix_(is_finite, is_finite)]
    of_levels = _mean_of(finite, correlation)
    if not math.isfinite(of_levels.error):
        return math.inf
    factor = tolerance_factor(of_levels.independent, of_levels.freedom)
    return of_levels.mean + factor * of_levels.error * math.sqrt(of_levels.independent)


def _mean_of(values: Array, correlation: Array | None) -> PairedMean:
    """Return the mean of values with the scatter of all of them."""
    return paired_mean(values, correlation, first_pairs=len(values))


def percent(share: float) -> str:
    """Write a share in whole percent."""
    return f"{100 * share:.0f} %"


# ---- order


def names_of(key: str) -> list[str]:
    """Return the names that a key takes, sorted by their roughness; none for a number."""
    last = key.rpartition(".")[2]
    if last == GRADE:
        return sorted(GRADES, key=lambda name: GRADES[name].roughness_ra_um)
    if last == FINISH:
        finishes = library.data("finishes")["finishes"]
        return sorted(finishes, key=lambda name: float(finishes[name]["roughness_ra_um"][0]))
    return []


def from_quiet(points: Sequence[Point], rises: bool, key: str) -> list[Point]:
    """Return points ordered by their values, from the quiet end of the range to the loud one."""
    names: list[str] = []
    if any(isinstance(point.value, str) for point in points):
        names = names_of(key)

    def place(point: Point) -> float:
        return names.index(point.value) if isinstance(point.value, str) else point.value

    return sorted(points, key=place, reverse=not rises)


def falls(ordered: Sequence[Point]) -> list[Fall]:
    """Return the neighbouring points between which the mean level surely falls.

    All points have the same specimens, so the differences are those of pairs. On a scan they are
    taken to be correlated as the levels of both points are on average.
    """
    sure_falls = []
    for quieter, louder in pairwise(ordered):
        rise = louder.levels_db - quieter.levels_db
        if not np.all(np.isfinite(rise)) or rise.mean() >= 0:
            continue
        correlation = None
        if quieter.correlation is not None and louder.correlation is not None:
            correlation = (quieter.correlation + louder.correlation) / 2
        of_rise = _mean_of(rise, correlation)
        if not math.isfinite(of_rise.error):
            continue
        if sureness(of_rise.mean, of_rise.error, of_rise.freedom) >= SURE:
            sure_falls.append(Fall(quieter.value, louder.value))
    return sure_falls


# ---- sentences


def _sentences(result: Limit) -> Iterator[str]:
    """Yield the answer, where the level does not rise, and what became of the range."""
    ordered = result.ordered
    unit = result.quantity.level_unit
    limit = f"{result.level_db:g} {unit}"
    quietest = min(ordered, key=lambda point: point.upper_db)
    if result.value is None:
        yield (
            f"No value of the range stays below {limit}. Even at {_worded(result, quietest)} the"
            f" level below which {percent(SHARE)} of {result.noun} lie is"
            f" {quietest.upper_db:.1f} {unit} ({quietest.words(result.noun)})."
        )
    else:
        answer = result.at(result.value)
        holds = f"{percent(SHARE)} of {result.noun} lie below {answer.upper_db:.1f} {unit}"
        count = answer.words(result.noun)
        louder = result.next_louder
        if louder is None:
            yield (
                f"The whole range stays below {limit}, up to {_worded(result, answer)}: there"
                f" {holds} ({count}; {percent(CONFIDENCE)} confidence)."
            )
        else:
            extreme = "coarsest" if isinstance(result.value, str) else "largest"
            if not result.rises:
                extreme = "finest" if isinstance(result.value, str) else "smallest"
            yield (
                f"{_worded(result, answer)} is the {extreme} that stays below {limit}: {holds},"
                f" with {percent(CONFIDENCE)} confidence ({count}); at"
                f" {_worded(result, louder)} it is {louder.upper_db:.1f} {unit}."
            )
        if ordered[0].upper_db > result.level_db:
            yield (
                f"Values from {_worded(result, ordered[0])} on are above the limit as well, so the"
                " answer holds from the first computed value below it on."
            )
    point = quietest if result.value is None else result.at(result.value)
    if point.independent is not None and point.wider_db >= LEAST_TOLD_DB:
        yield (
            f"A scan with twice as many independent places, such as one of twice the width, would"
            f" lower the level below which {percent(SHARE)} lie by about"
            f" {rounded(point.wider_db, 2)} dB."
        )
    if result.falls:
        places = [
            f"from {labels.worded(result.key, fall.quieter)} to"
            f" {labels.worded(result.key, fall.louder)}"
            for fall in result.falls
        ]
        direction = "rise" if result.rises else "fall"
        yield (
            f"The level does not {direction} all the way: it goes the other way"
            f" {printable(' and '.join(places))}, so the answer is the first crossing from the"
            " quiet end."
        )
    yield from result.notes


def _worded(result: Limit, point: Point) -> str:
    """Write the value of a point with its word and unit."""
    return printable(labels.worded(result.key, point.value))
