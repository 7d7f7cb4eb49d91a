"""Quantities: values with unit, standard uncertainty and its parts, origin, record and doubts."""

from __future__ import annotations

import html
import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, NamedTuple

from acoustics.bands import NOMINAL_HZ
from acoustics.numbers import rounded
from rolling.numbers.doubt import Doubt, Severity

How = Literal["computed", "estimated", "upper bound", "assumed", "forecast"]
"""How a value was found: from the motion, by a linear chain, as a released power that counts whole
as sound, with an assumed share or gain, or before the run."""

VIBRATION = "vibration"
RELEASED_POWER = "released_power"
SERIES = "series"  # what a doubt is about that touches the release along the track, and no level

BOUND = "bound"  # verdict of a number that is an upper bound
ASSUMED = "assumed"  # verdict of a number that rests on a share or a gain of the scene
_BANDS_HZ = frozenset(map(float, NOMINAL_HZ))
_OF_ORIGIN: Mapping[How, str] = {"upper bound": BOUND, "assumed": ASSUMED}

_NOT_SOLVED = Doubt("not_solved", "its errors are not computed", Severity.TRUST)

# Sources of uncertainty, with the words that name them.
PART_WORDS: Mapping[str, str] = {
    "record": "the length of the record",
    "comb": "a resonance on or between the lines of the lap",
    "impacts": "the scatter of the impacts",
    "time_step": "the time steps of the motion",
    "contact_loss": "the unknown loss of the contact",
    "baffle": "the baffle that a free plate does not have",
    "chain": "the linear chain",
    "stiffness": "the stiffness of the contact",
    "stiffness_changes": "its changes along the track",
    "force_law": "the force law",
    "grid": "the grid",
    "solver": "the solver",
    "subgrid": "detail below the spacing",
    "band": "the end of the simulated band",
    "instrument": "the instrument of the scan",
    "window": "the stretch of track that stands for the turn",
    "linear": "rough contacts that are linear",
    "one_load": "faults that are marched at one load",
    "gain": "the gain of rough contacts",
    "loss_factor": "the assumed loss factor of the contacts",
    "film": "what films of oil leave of waves",
    "film_damping": "the damping by films of oil",
    "surfaces": "the assumed waves and roughness of balls and raceways",
}
# Parts that two runs of this program share: a wrong one shifts both levels by nearly the same.
SHARED = ("chain", "baffle")
HALF = 0.5  # uncertainty of an effect of known sense over its largest size


@dataclass(frozen=True)
class RecordOfNumber:
    """The record that a number describes.

    Attributes
    ----------
    heard_s : float, s
        Length of the record whose level it is.
    solved_s : float, s
        Length of the part that was solved. The rest goes on with the statistics of this part.
    repeats : bool
        Whether the record repeats; otherwise it is heard once.
    """

    heard_s: float
    solved_s: float
    repeats: bool

    @property
    def solved_share(self) -> float:
        """Share of the record, in time, that was solved."""
        return self.solved_s / self.heard_s if self.solved_s < self.heard_s else 1.0


class Verdict(NamedTuple):
    """The verdict on a number.

    word : str. trust, indicative, do not quote, bound or assumed.
    worst : Doubt. The worst doubt about its numerical error, which gives decibels and reason.
    known_db : float or None. The largest error that is known [dB], where that of the worst is not.
    """

    word: str
    worst: Doubt
    known_db: float | None

    @property
    def error(self) -> str:
        """Size of the error: `± 1.2 dB`, `> 0.3 dB` at least, or an empty text."""
        if self.worst.decibels:
            return f"± {spread_text(self.worst.decibels)} dB"
        if self.known_db:
            return f"> {self.known_db:.1f} dB"
        return ""

    @property
    def short(self) -> str:
        """Word and decibels, such as `indicative, ± 1.2 dB`."""
        return f"{self.word}, {self.error}" if self.error else self.word

    @property
    def sentence(self) -> str:
        """Word, decibels and reason: `indicative, ± 1.2 dB: the grid leaves up to 1.2 dB`."""
        return f"{self.short}: {self.worst.text}"


@dataclass(frozen=True)
class Quantity:
    """A number with its unit, its standard uncertainty and what is known of both.

    Attributes
    ----------
    name : str
        Name for programs, such as `vibration`.
    value : float or None
        The value; None where there is none, and `reason` says why.
    unit : str
        Unit of the value, such as `dB(A)`.
    measure : str
        What the value measures, such as LAeq, or LAE (re 1 s) of a single event.
    how : str
        computed, estimated, upper bound, assumed or forecast.
    uncertainty : float or None
        Standard uncertainty in the unit of the value, dB for a level; None where it is unknown.
    uncertainty_unit : str
        Unit of the uncertainty and its parts where it is another one: dB for a velocity. Default:
        that of the value.
    parts : dict
        Parts of the uncertainty by their source, such as `record` or `grid`; the uncertainty is the
        root of the sum of their squares.
    signed : dict
        Parts that change the value in a known sense, by their source: the change for the largest
        effect, half of which is the part. Two numbers with the same cause change together.
    record : RecordOfNumber or None
        The record that it describes.
    where : str
        Where it is heard.
    meaning : str
        One sentence that explains it.
    reason : str
        Why there is no value, or an empty text.
    coming : str or None
        How a run will find a value that is a forecast; None for a run that will have none.
    is_solved : bool
        Whether its errors were computed; if not, its origin is all that is known of them.
    doubts : tuple of Doubt
        The doubts that touch it.

    Examples
    --------
    >>> from rolling import Quantity
    >>> level = Quantity("vibration", 11.04, unit="dB(A)", how="estimated", uncertainty=1.13)
    >>> print(level)
    11.0 ± 1.2 dB(A), estimated
    """

    name: str
    value: float | None
    unit: str = ""
    measure: str = ""
    how: How = "computed"
    uncertainty: float | None = None
    uncertainty_unit: str = ""
    parts: dict[str, float] = field(default_factory=dict)
    signed: dict[str, float] = field(default_factory=dict)
    record: RecordOfNumber | None = None
    where: str = ""
    meaning: str = ""
    reason: str = ""
    coming: How | None = None
    is_solved: bool = True
    doubts: tuple[Doubt, ...] = ()

    @property
    def number(self) -> str:
        """The value with its uncertainty, such as `14.5 ± 0.6`; `-` where there is none.

        A value whose uncertainty has another unit stands alone.
        """
        if self.value is None:
            return "-"
        if self.uncertainty_unit:
            return rounded(self.value, 2)
        return uncertain(self.value, self.uncertainty)

    def __str__(self) -> str:
        if self.coming is not None:
            return f"a run will tell: {self.coming}"
        if self.value is None:
            return f"none, because {self.reason}"
        words = f"{self.number} {self.unit}".rstrip()
        if self.uncertainty_unit and self.uncertainty is not None:
            words += f" ± {spread_text(self.uncertainty)} {self.uncertainty_unit}"
        if self.measure == "LAE":
            words = f"LAE {words}"
        return f"{words}, {self.how}"

    def __repr__(self) -> str:
        return f"Quantity({self.name}: {self})"

    def _repr_html_(self) -> str:
        """Write value, origin and verdict for a notebook."""
        text = f"<b>{html.escape(str(self))}</b>"
        judged = self.judged
        if judged is not None:
            text += f" <small>({html.escape(judged.sentence)})</small>"
        if self.meaning:
            text += f"<br>{html.escape(self.meaning)}"
        return text

    @property
    def unit_of_uncertainty(self) -> str:
        """Unit of the uncertainty and its parts: dB for every level."""
        if self.uncertainty_unit:
            return self.uncertainty_unit
        return "dB" if self.unit.startswith("dB") else self.unit

    @property
    def solved_share(self) -> float:
        """Share of the record, in time, that was solved."""
        return 1.0 if self.record is None else self.record.solved_share

    @property
    def judged(self) -> Verdict | None:
        """The verdict with its reason; None without a value, but for that of a forecast."""
        if self.value is None and self.coming is None:
            return None
        worst = worst_of(self.doubts) if self.is_solved else _NOT_SOLVED
        known = [doubt.decibels for doubt in self.doubts if doubt.decibels]
        largest_db = round(max(known, default=0.0), 1)
        return Verdict(
            word=_OF_ORIGIN.get(self.coming or self.how, worst.severity.word),
            worst=worst,
            known_db=None if worst.decibels or not largest_db else largest_db,
        )

    @property
    def verdict(self) -> str | None:
        """How far to trust it: trust, indicative, do not quote, bound or assumed; None without."""
        judged = self.judged
        return None if judged is None else judged.word

    def with_doubts(self, doubts: Iterable[Doubt]) -> Quantity:
        """Return the quantity with those of some doubts that touch it; none if it is not solved."""
        if not self.is_solved:
            return self
        return replace(self, doubts=tuple(doubt for doubt in doubts if doubt.touches(self.name)))


def uncertain(value: float, uncertainty: float | None) -> str:
    """Write a value with its standard uncertainty, rounded up to a tenth.

    The uncertainty never prints as 0.0, because no level is known exactly. A value that rounds to
    -0.0 is written as 0.0.
    """
    spread = "" if uncertainty is None else f" ± {spread_text(uncertainty)}"
    return f"{round(value, 1) + 0.0:.1f}{spread}"


def joined(parts: Mapping[str, float], left_out: Iterable[str] = ()) -> float:
    """Return the root of the sum of squares of parts, but for those of some sources."""
    without = {*left_out}
    return math.hypot(*(part for source, part in parts.items() if source not in without))


class QuantityDifference(NamedTuple):
    """The difference of two numbers or means of numbers, and its standard uncertainty.

    left_out : tuple of str. Parts of the uncertainty that both share, and which it leaves out.
    """

    value: float
    uncertainty: float
    left_out: tuple[str, ...] = ()


def difference(
    before: Sequence[Quantity], after: Sequence[Quantity], not_shared: Iterable[str] = ()
) -> QuantityDifference | None:
    """Return the mean of some quantities less that of others; None where they do not compare.

    Several quantities are those of surfaces that differ by chance. What both sides share, such as
    the error of the linear chain, shifts both by nearly the same and is left out. The other parts
    are taken as independent, which is on the safe side. A cause that changes both in a known sense
    counts by half the change of the difference. `not_shared` names sources that both have, but not
    the same, such as the baffles of different plates.
    """
    every = [*before, *after]
    if any(quantity.value is None for quantity in every):
        return None
    if len({quantity.measure for quantity in every}) > 1:
        return None
    not_common = {*not_shared}
    shared = tuple(
        source
        for source in SHARED
        if source not in not_common
        and all(any(quantity.parts.get(source) for quantity in side) for side in (before, after))
    )
    signed = {source for quantity in every for source in quantity.signed}
    without = (*shared, *signed)
    low, low_spread = _mean(before, without)
    high, high_spread = _mean(after, without)
    changes = [
        HALF * (_mean_change(after, source) - _mean_change(before, source)) for source in signed
    ]
    return QuantityDifference(
        value=high - low,
        uncertainty=math.hypot(low_spread, high_spread, *changes),
        left_out=shared,
    )


def spread_text(uncertainty: float) -> str:
    """Write an uncertainty in tenths, rounded up, so that it promises no more than is known."""
    return f"{math.ceil(10 * uncertainty) / 10:.1f}"


def mean(quantities: Sequence[Quantity]) -> float | None:
    """Return the mean value of quantities; None if one of them has none."""
    values = [quantity.value for quantity in quantities if quantity.value is not None]
    return statistics.fmean(values) if len(values) == len(quantities) else None


def _mean(quantities: Sequence[Quantity], left_out: Iterable[str]) -> tuple[float, float]:
    """Return the mean value of quantities and its uncertainty, without some parts.

    The uncertainty joins the scatter between several surfaces with that of a single value, which
    the surfaces may have in common.
    """
    values = [quantity.value for quantity in quantities if quantity.value is not None]
    own = max(joined(quantity.parts, left_out) for quantity in quantities)
    scatter = 0.0
    if len(values) > 1:
        scatter = statistics.stdev(values) / math.sqrt(len(values))
    return statistics.fmean(values), math.hypot(own, scatter)


def _mean_change(quantities: Sequence[Quantity], source: str) -> float:
    """Return the mean change of quantities by a cause of known sense."""
    return statistics.fmean(quantity.signed.get(source, 0.0) for quantity in quantities)


def worst_of(doubts: Iterable[Doubt]) -> Doubt:
    """Return the worst of the doubts about a number, which is its verdict."""
    nothing = Doubt("none", "no limit is broken", Severity.TRUST)
    limiting = [doubt for doubt in doubts if doubt.severity > Severity.NOTE]
    worst = max(limiting, key=lambda doubt: doubt.rank, default=nothing)
    if worst.severity is Severity.TRUST and worst.decibels is None:
        return nothing
    return worst


@dataclass(frozen=True)
class BandQuantity:
    """Values in frequency bands: an array quantity.

    Attributes
    ----------
    unit : str
        Unit of the values.
    frequency_hz : tuple of float, Hz
        Nominal mid frequencies of the bands (IEC 61260-1).
    value : tuple of float or None
        The values; None where there is none.
    uncertainty : tuple of float or None, or None
        Standard uncertainties of the values; None where they are unknown.
    how : str
        computed, estimated, upper bound or assumed.
    parts : dict of tuples of float
        Parts of the uncertainties by their source, 0 in bands where one is unknown; an uncertainty
        is the root of the sum of their squares. Empty where the sources are unknown.

    Examples
    --------
    >>> from rolling import BandQuantity
    >>> levels = BandQuantity.of({"63": 31.2, "80": None}, "dB", {"63": 0.8, "80": None})
    >>> levels.by_name["63"], levels.uncertainty_by_name["63"]
    (31.2, 0.8)
    """

    unit: str
    frequency_hz: tuple[float, ...]
    value: tuple[float | None, ...]
    uncertainty: tuple[float | None, ...] | None = None
    how: How = "computed"
    parts: dict[str, tuple[float, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse frequencies that are no bands, and values that do not belong to them.

        Raises
        ------
        ValueError : a frequency is none of a third octave, or a count differs.
        """
        unknown = [frequency for frequency in self.frequency_hz if frequency not in _BANDS_HZ]
        if unknown:
            raise ValueError(f"{unknown[0]:g} Hz is no nominal mid frequency of a third octave")
        count = len(self.frequency_hz)
        for values in (self.value, self.uncertainty, *self.parts.values()):
            if values is not None and len(values) != count:
                raise ValueError(f"{count} bands have {len(values)} values")

    def __repr__(self) -> str:
        return f"BandQuantity({len(self.value)} bands, {self.unit}, {self.how})"

    @classmethod
    def of(
        cls,
        values: Mapping[str, float | None],
        unit: str,
        uncertainty: Mapping[str, float | None] | None = None,
        how: How = "computed",
    ) -> BandQuantity:
        """Return values by the names of their bands, such as "31.5", as a quantity."""
        spreads = None
        if uncertainty is not None:
            spreads = tuple(uncertainty[name] for name in values)
        return cls(
            unit=unit,
            frequency_hz=tuple(float(name) for name in values),
            value=tuple(values.values()),
            uncertainty=spreads,
            how=how,
        )

    @property
    def by_name(self) -> dict[str, float | None]:
        """Values by the names of their bands, such as "31.5"."""
        return dict(zip(self._names, self.value, strict=True))

    @property
    def uncertainty_by_name(self) -> dict[str, float | None]:
        """Standard uncertainties by the names of the bands; None where they are unknown."""
        spreads = self.uncertainty or (None,) * len(self.value)
        return dict(zip(self._names, spreads, strict=True))

    @property
    def _names(self) -> list[str]:
        """Names of the bands."""
        return [f"{frequency:g}" for frequency in self.frequency_hz]
