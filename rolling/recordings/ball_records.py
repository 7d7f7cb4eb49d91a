"""Records of the run of a sphere that recordings are compared with: its sound, and its channels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from acoustics.wav import SAMPLE_RATE_HZ as RATE
from rolling.recordings.compared_run import ComparedRecord, ComparedRun
from rolling.recordings.recorded import PRESSURE, MeasuredQuantity, Recording
from rolling.recordings.run_spread import run_spread
from rolling.results import listening
from rolling.results.run_result import Run
from rolling.terminal.whole_files import FolderError

if TYPE_CHECKING:
    from rolling.results.channels import Channel

# The body and the place of a channel that a scene lacks, by its quantity.
_LACKING = {
    "acceleration": "of: plate, quantity: acceleration, x_mm: 30, y_mm: 40",
    "velocity": "of: plate, quantity: velocity, x_mm: 30, y_mm: 40",
    "displacement": "of: plate, quantity: displacement, x_mm: 30, y_mm: 40",
    "force": "of: contact, quantity: force",
}
_OF_RELEASE = (
    "a recording holds what is heard, and the run its released power: compare the shape of the"
    " spectrum, not its level"
)


def records_of_ball(run: Run, quantity: MeasuredQuantity) -> ComparedRun:
    """Return the records of a run of a quantity.

    Raises
    ------
    FolderError : the run has none.
    """
    spread = run_spread(run, quantity)
    if quantity is not PRESSURE:
        own = [channel for channel in run.channels if channel.quantity == quantity.name]
        if not own:
            others = [f"{item.quantity} of {item.of}" for item in run.channels]
            raise FolderError(f"{run.folder}: {lacking_channels(quantity, others)}")
        records = [_of_channel(run, channel, quantity) for channel in own]
        return ComparedRun(
            tuple(ComparedRecord(record, record.seconds, spread) for record in records)
        )
    warnings = (_OF_RELEASE,) if run.numbers.record.source == "release" else ()
    lap_s = run.sound.duration / run.laps
    return ComparedRun(
        records=(ComparedRecord(of_run(run), lap_s, spread),),
        stated=_stated_level(run),
        warnings=warnings,
    )


def _stated_level(run: Run) -> str:
    """Name what the levels of a run are of, with the level that it states and the verdict on it."""
    quantity = run.numbers.quantity_of_record
    of = "vibration"
    if run.numbers.record.source == "release":
        q = run.numbers.record.q
        under = "under the gain of the scene" if q is None else f"with q = {q:g}"
        of = f"released power {under}"
    return f"levels of the {of}, which `rolling run` states as {quantity} ({quantity.verdict})"


def of_run(run: Run) -> Recording:
    """Return the long record of a run if its scene asks for one, otherwise its signal."""
    long = listening.long_record_of(run)
    if long is not None:
        return Recording(
            name="long record",
            samples=long.pressure,
            highest=run.sound.highest,
            seconds=len(long.pressure) / RATE,
            is_drop=run.scene.is_one_event,
        )
    return Recording(
        name="signal",
        samples=run.sound.pressure,
        highest=run.sound.highest,
        seconds=run.sound.duration / run.laps,
        is_drop=run.scene.is_one_event,
    )


def _of_channel(run: Run, channel: Channel, quantity: MeasuredQuantity) -> Recording:
    """Return the record of a channel of a run."""
    return Recording(
        name=channel.name,
        samples=np.asarray(channel.samples, dtype=float),
        highest=channel.highest_hz,
        seconds=len(channel.samples) / RATE / run.laps,
        is_drop=run.scene.is_one_event,
        quantity=quantity,
    )


def lacking_channels(quantity: MeasuredQuantity, others: Sequence[str]) -> str:
    """Say which lines of a scene ask for a channel of a quantity that a run, or a scene, lacks.

    The others are the channels that it has, in words.
    """
    has = f", only {', '.join(dict.fromkeys(others))}" if others else ""
    line = _LACKING[quantity.name]
    place = ", with your place on the plate," if "x_mm" in line else ""
    return (
        f"no channel of {quantity.name}{has}; add to the scene{place} and run it again:"
        f" sound: {{channels: [{{{line}}}]}}"
    )
