"""What ten times the steps, or half the spacing, would buy a run of a ball, by its own numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from acoustics.numbers import clock, rounded
from rolling.check import forecast, resolution
from rolling.marches import effort
from rolling.numbers.quantity import PART_WORDS, Quantity, joined, spread_text
from rolling.results.run_result import Run
from rolling.scene.messages import SceneError
from rolling.sound.error_estimate import DEFAULT_ORDER

MORE_STEPS = 10
FINER = 2
RECORD = "record"
GRID = "grid"
# Parts of the processor time that grow with the track.
ALONG_TRACK = (effort.MARCH, effort.LOAD_MARCHES, effort.MOVING_RELEASE)


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


def more_work(run: Run) -> list[MoreWork]:
    """Return what ten times the steps and half the spacing would buy the number that leads.

    That is the vibration where it has a ±, and otherwise the released power.
    """
    quantity = leading(run)
    return [_more_steps(run, quantity), _finer_grid(run, quantity)]


def leading(run: Run) -> Quantity:
    """Return the number of a run whose ± is known: its vibration, or its released power."""
    for quantity in (run.numbers.vibration, run.numbers.released_power):
        if quantity.value is not None and quantity.uncertainty is not None:
            return quantity
    return run.numbers.vibration


def _more_steps(run: Run, quantity: Quantity) -> MoreWork:
    """Return the gain of a record that is ten times as long: its noise is independent."""
    seconds = _march_seconds(run)
    more = MoreWork(
        what="Ten times the steps",
        number=_words(quantity),
        source=RECORD,
        seconds=seconds,
        new_seconds=None if seconds is None else MORE_STEPS * seconds,
    )
    if run.scene.is_one_event:
        return replace(more, reason="the record is one event")
    if not quantity.parts.get(RECORD):
        return replace(
            more, reason=_without_part(quantity, RECORD)
        )
    return _with_gain(more, quantity, 1 / math.sqrt(MORE_STEPS))


def _finer_grid(run: Run, quantity: Quantity) -> MoreWork:
    """Return the gain of half the spacing: as measured, or by the rule that the doubt states."""
    seconds = _march_seconds(run)
    finer = MoreWork(
        what="Half the spacing",
        number=_words(quantity),
        source=GRID,
        seconds=seconds,
        new_seconds=_finer_seconds(run, seconds),
    )
    order = run.numbers.errors.order
    if order is not None and quantity.parts.get(GRID):
        return _with_gain(finer, quantity, FINER**-order)
    doubt = next((doubt for doubt in quantity.doubts if doubt.key == resolution.LEVEL_KEY), None)
    if doubt is None:
        return replace(
            finer, reason=_without_part(quantity, GRID)
        )
    if not doubt.decibels:
        return replace(finer, reason=doubt.text)
    estimate_db = doubt.decibels
    return replace(finer, part_db=estimate_db, new_part_db=estimate_db * FINER**-DEFAULT_ORDER)


def _with_gain(work: MoreWork, quantity: Quantity, ratio: float) -> MoreWork:
    """Return the work with its gain where its part of ± falls to a share of itself."""
    part_db = quantity.parts[work.source]
    new_part_db = ratio * part_db
    return replace(
        work,
        part_db=part_db,
        new_part_db=new_part_db,
        uncertainty_db=quantity.uncertainty,
        new_uncertainty_db=math.hypot(joined(quantity.parts, left_out=(work.source,)), new_part_db),
    )


def _without_part(quantity: Quantity, source: str) -> str:
    """Say that a number has no part of ± from a source."""
    return f"± of the {_words(quantity)} has no part for {PART_WORDS[source]}"


def _words(quantity: Quantity) -> str:
    """Return the name of a number as people say it."""
    return quantity.name.replace("_", " ")


def _march_seconds(run: Run) -> float | None:
    """Return the measured processor time [s] of all marches along the track; None if unknown.

    It is unknown where the march was done for another run.
    """
    if not run.numbers.effort.march_cpu_s:
        return None
    parts = run.numbers.effort.parts_cpu_s or {}
    return sum(parts.get(part) or 0.0 for part in ALONG_TRACK)


def _finer_seconds(run: Run, seconds: float | None) -> float | None:
    """Return the measured time times the ratio of the forecasts of both grids."""
    scene = run.scene
    if seconds is None or scene.height_paths:  # the grid of a file is that of its points
        return None
    try:
        finer = scene.with_({"surface.spacing_um": 1e6 * scene.spacing / FINER})
        return seconds * forecast.march_seconds(finer) / forecast.march_seconds(scene)
    except SceneError:
        return None
