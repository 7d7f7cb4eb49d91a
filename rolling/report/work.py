"""What more work would buy the number of a run, and what a run left out, for its page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from acoustics.numbers import clock, rounded
from acoustics.texts import printable
from rolling.kinds.page_parts import Part
from rolling.numbers.quantity import PART_WORDS, Quantity, joined, spread_text

MORE_STEPS = 10
FINER = 2
RECORD = "record"
GRID = "grid"


@dataclass(frozen=True)
class Omission:
    """Something that a run did not compute.

    what : str. What is left out.
    reason : str. What in the scene or in the run says that it is not needed.
    """

    what: str
    reason: str

    @property
    def sentence(self) -> str:
        """The omission as a line of a list."""
        return f"{self.what}: {self.reason}."


@dataclass(frozen=True)
class MoreWork:
    """A larger computation, its gain and its cost.

    what : str. What is more.
    number : str. The number that gains, in words.
    source : str. The part of ± that gets smaller, a key of PART_WORDS.
    part_db, new_part_db : float or None, dB. This part, and what would be left of it; None where
        the run does not know it.
    uncertainty_db, new_uncertainty_db : float or None, dB. The whole ±, and what would be left;
        None where the part is an estimate beside it.
    seconds, new_seconds : float or None, s. Processor time of the march as measured, and as it
        would be; None where another run did the march, or where its new time is not known.
    reason : str. Why there is no gain to state, or an empty text.
    """

    what: str
    number: str
    source: str
    part_db: float | None = None
    new_part_db: float | None = None
    uncertainty_db: float | None = None
    new_uncertainty_db: float | None = None
    seconds: float | None = None
    new_seconds: float | None = None
    reason: str = ""

    @property
    def sentence(self) -> str:
        """Gain and cost in a sentence."""
        return f"{self.what} {self._gain}{self._cost}."

    @property
    def _gain(self) -> str:
        if self.reason:
            return f"would buy no decibel that is known here, because {self.reason}"
        assert self.part_db is not None and self.new_part_db is not None
        text = (
            f"would lower what {PART_WORDS[self.source]} leaves uncertain from "
            f"{rounded(self.part_db)} to {rounded(self.new_part_db)} dB"
        )
        if self.uncertainty_db is not None and self.new_uncertainty_db is not None:
            spreads = [spread_text(self.uncertainty_db), spread_text(self.new_uncertainty_db)]
            text += f", and ± of the {self.number} from {spreads[0]} to {spreads[1]} dB"
        return text

    @property
    def _cost(self) -> str:
        if self.seconds is None or self.new_seconds is None:
            return ""
        return (
            f"; the march would take about {clock(self.new_seconds)} of processor time in place of "
            f"{clock(self.seconds)}"
        )


def with_gain(work: MoreWork, quantity: Quantity, ratio: float) -> MoreWork:
    """Return the work with its gain where its part of ± falls to a share of itself.

    A number without this part gains nothing that is known.
    """
    part_db = quantity.parts.get(work.source)
    if not part_db:
        words = f"± of the {work.number} has no part for {PART_WORDS[work.source]}"
        return replace(work, reason=words)
    new_part_db = ratio * part_db
    return replace(
        work,
        part_db=part_db,
        new_part_db=new_part_db,
        uncertainty_db=quantity.uncertainty,
        new_uncertainty_db=math.hypot(joined(quantity.parts, left_out=(work.source,)), new_part_db),
    )


def words_of(quantity: Quantity) -> str:
    """Return the name of a number as people say it."""
    return quantity.name.replace("_", " ")


def work_part(
    labels: Sequence[str],
    worked: Sequence[Sequence[MoreWork]],
    spared: Sequence[Sequence[Omission]],
    never: str,
) -> Part:
    """Return the part of a page with both lists of each run, below the doubts.

    `never` names what no run of the kind computes.
    """
    values = {
        "worked": _grouped(labels, [[work.sentence for work in of_run] for of_run in worked]),
        "spared": _grouped(labels, [[left.sentence for left in of_run] for of_run in spared]),
        "never": never,
    }
    return Part("work.html", values)


def _grouped(labels: Sequence[str], lists: Sequence[Sequence[str]]) -> list[dict[str, Any]]:
    """Return lists of sentences with the labels of the runs that have them; none if all have."""
    labels_of: dict[tuple[str, ...], list[str]] = {}
    for label, sentences in zip(labels, lists, strict=True):
        labels_of.setdefault(tuple(sentences), []).append(printable(label))
    alone = len(labels_of) == 1
    return [
        {"label": "" if alone else "; ".join(names), "sentences": sentences}
        for sentences, names in labels_of.items()
    ]
