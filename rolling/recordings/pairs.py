"""Records of a run, the channels of a recording that go with them, and the stretch they share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from acoustics.wav import SAMPLE_RATE_HZ as RATE
from rolling.recordings.compared_run import ComparedRecord, ComparedRun
from rolling.recordings.recorded import (
    PRESSURE,
    SKIPPED,
    MeasuredQuantity,
    Recording,
    usable,
)
from rolling.recordings.run_spread import RunSpread
from rolling.recordings.stretch import Stretch, fitting_stretch
from rolling.scene.messages import nearest
from rolling.terminal.whole_files import FolderError


class RecordPair(NamedTuple):
    """A record of the run and the channel of the recording that goes with it.

    name : str. Name of the run's channel; empty for sound pressure.
    number : int. Number of the recording's channel, from 0 on.
    run, recording : Recording. Both records.
    lap_s : float, s. Length of the solved track in the record of the run.
    spread : RunSpread. What is uncertain of the levels of the run.
    """

    name: str
    number: int
    run: Recording
    recording: Recording
    lap_s: float
    spread: RunSpread

    @property
    def records(self) -> dict[str, Recording]:
        """Both records by their names."""
        return {"run": self.run, "recording": self.recording}

    def named(self, word: str) -> str:
        """Return a word with the name of the channel."""
        return f"{word}, {self.name}" if self.name else word


def pair_records(
    own: ComparedRun, path: Path, recorded: list[Recording], names: Sequence[str] = ()
) -> list[RecordPair]:
    """Return the records of a run, each with its channel of a recording.

    Parameters
    ----------
    own : ComparedRun. Records of the run.
    path : Path. Sound file.
    recorded : list of Recording. Its channels. Of sound pressure the first one is taken.
    names : sequence of str. Names of channels of the run in the order of the recording's channels;
        "-" leaves one out. Default: the channels of the quantity in their order.

    Raises
    ------
    FolderError : the run has no such channels, their numbers differ, or a record is no signal.
    """
    quantity = recorded[0].quantity
    if quantity is PRESSURE:
        if names:
            raise FolderError("--channel: only goes with --quantity; of sound a run has one record")
        (compared,) = own.records
        return [_pair("", 0, compared, usable(path, recorded, 0))]
    pairs = []
    for number, own_record in enumerate(_channels_of(own, quantity, names, len(recorded), path)):
        if own_record is not None:
            pairs.append(
                _pair(own_record.record.name, number, own_record, usable(path, recorded, number))
            )
    if not pairs:
        raise FolderError(f"--channel: got {SKIPPED} for all channels, allowed: at least one name")
    return pairs


def _pair(name: str, number: int, own: ComparedRecord, recording: Recording) -> RecordPair:
    """Return the pair of a record of a run and a recording, both of a drop or neither."""
    if name and not np.any(own.record.samples):
        raise FolderError(f"the channel {name} of the run is silent")
    return RecordPair(
        name=name,
        number=number,
        run=own.record,
        recording=recording._replace(is_drop=own.record.is_drop),
        lap_s=own.lap_s,
        spread=own.spread,
    )


def _channels_of(
    own: ComparedRun, quantity: MeasuredQuantity, names: Sequence[str], count: int, path: Path
) -> list[ComparedRecord | None]:
    """Return the record of a run for each channel of a recording; None where it is left out."""
    of_quantity = {own_record.record.name: own_record for own_record in own.records}
    listed = ", ".join(of_quantity)
    if not names and count == len(of_quantity):
        return list(of_quantity.values())
    if not names:
        raise FolderError(
            f"{path}: got {count} channels, and the run has {len(of_quantity)} of {quantity.name}"
            f" ({listed}); name the run's channel for each channel of the recording, in order, by"
            f" --channel NAME, and leave one out by --channel {SKIPPED}"
        )
    for name in names:
        if name not in of_quantity and name != SKIPPED:
            near = nearest(name, [*of_quantity])
            raise FolderError(f"--channel: got {name}{near}, allowed: {listed}, {SKIPPED}")
    if len(names) != count:
        raise FolderError(
            f"--channel: got {len(names)} names for {count} channels of {path}, allowed: one for"
            f" each, or {SKIPPED}"
        )
    return [of_quantity.get(name) for name in names]


# ---- the stretch that both records share


class PlacedPairs(NamedTuple):
    """Pairs of records whose longer ones are cut to the stretch that fits, and that stretch."""

    pairs: list[RecordPair]
    stretch: Stretch | None


def placed_pairs(pairs: Sequence[RecordPair]) -> PlacedPairs:
    """Cut the longer of two records to the stretch that fits the shorter one.

    All channels of a recording have one place in the run.
    """
    own = [pair.run.samples for pair in pairs]
    recorded = [pair.recording.samples for pair in pairs]
    highest = min(min(pair.run.highest, pair.recording.highest) for pair in pairs)
    recording_is_longer = len(recorded[0]) > len(own[0])
    if recording_is_longer:
        stretch = fitting_stretch(recorded, own, highest)
    else:
        stretch = fitting_stretch(own, recorded, highest)
    cut = [_cut(pair, stretch, recording_is_longer) for pair in pairs]
    return PlacedPairs(pairs=cut, stretch=stretch)


def _cut(pair: RecordPair, stretch: Stretch | None, recording_is_longer: bool) -> RecordPair:
    """Return a pair whose longer record is cut to a stretch, where there is one."""
    own = pair.run
    recording = pair.recording
    if stretch is None:
        return pair._replace(recording=recording.whole())
    if recording_is_longer:
        recording = recording.stretch(stretch.first, stretch.length)
        if stretch.coefficient is not None:  # the same waveform with the same fades
            own = own.stretch(0, stretch.length)
    else:
        own = own.stretch(stretch.first, stretch.length)
        recording = recording.whole()
    lap_s = min(pair.lap_s, len(own.samples) / RATE)
    return pair._replace(run=own, recording=recording, lap_s=lap_s)


def place_notes(pairs: Sequence[RecordPair], placed: PlacedPairs) -> list[str]:
    """Say which stretch of the longer record is compared, and why."""
    own_s = len(pairs[0].run.samples) / RATE
    recorded_s = len(pairs[0].recording.samples) / RATE
    lengths = f"the run has {own_s:.3g} s and the recording {recorded_s:.3g} s"
    longer = "recording" if recorded_s > own_s else "run"
    stretch = placed.stretch
    if stretch is None and longer == "run" and own_s > 2 * recorded_s:
        return [f"place: {lengths}; the run is steady, so all of it is compared"]
    if stretch is None and longer == "recording" and recorded_s > 2 * own_s:
        return [f"place: {lengths}; the recording is steady, so all of it is compared"]
    if stretch is None:
        return []
    first_s = stretch.first / RATE
    last_s = (stretch.first + stretch.length) / RATE
    span = f"the {longer} from {first_s:.3f} to {last_s:.3f} s"
    if stretch.coefficient is None:
        return [
            f"place: {lengths}; {span} fits best by the shape of its third octaves (the waveforms"
            " differ)"
        ]
    text = f"place: {lengths}; {span} has the waveform of the other ({stretch.coefficient:.2f}"
    notes = [f"{text} of full correlation)"]
    if any(stretch.is_reversed) and pairs[0].name:
        named = ", ".join(
            pair.name
            for pair, is_reversed in zip(pairs, stretch.is_reversed, strict=True)
            if is_reversed
        )
        notes.append(f"sign: reversed against the run in {named}")
    return notes
