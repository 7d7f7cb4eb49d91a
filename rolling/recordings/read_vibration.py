"""Figures of a vibration as makers and diagnosticians read them, of a run beside a recording.

They are velocities in bands, crest factor and kurtosis, and lines of the envelope. With records of
the same thing without a fault, the rise by the fault stands beside them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from acoustics.arrays import Array
from acoustics.impulsiveness import BandPulses, band_pulses, pulse_kurtogram
from acoustics.numbers import rounded
from acoustics.ring_velocity import (
    NarrowSpectrum,
    VelocityBands,
    squared_envelope_spectrum,
    velocity_bands,
)
from acoustics.vibration_level import velocity_of
from acoustics.wav import SAMPLE_RATE_HZ as RATE
from rolling.recordings.recorded import Recording

VELOCITY = "velocity"
RISE = "rise of the velocity"
KURTOSIS = "kurtosis"
KURTOSIS_RISE = "rise of the kurtosis"
CREST = "crest factor"
ENVELOPE = "line of the envelope"
DECIBELS = "dB"
UM_S = 1e6  # micrometres per second in a metre per second
SLIP = 0.02  # of a line that a recording may have it beside its place: slip, and another speed
LEAST_HEIGHT = 3.0  # of a peak beside its place, that noise has seldom
_BELOW = 0.999  # of the highest frequency of a record, where its last band ends
_LEAST_WIDTH_HZ = 50.0  # of a part of a band, less of which tells nothing


class VibrationMarks(NamedTuple):
    """What is read from a vibration beside its third octaves.

    bands_hz : mapping. Edges of the bands of velocity by their names [Hz].
    lines_hz : mapping. Frequencies of pulses by their names [Hz].
    velocity_db : mapping. Standard uncertainty of the velocity of the run by the channel, and by
        the band [dB].
    """

    bands_hz: Mapping[str, tuple[float, float]]
    lines_hz: Mapping[str, float]
    velocity_db: Mapping[str, Mapping[str, float]]


class ReadVibration(NamedTuple):
    """What is read from a record of vibration.

    velocity : VelocityBands or None. In m/s; None for a record whose unit is not known.
    pulses : dict of BandPulses by band, and of all bands together, in the quantity of the record.
    envelope : NarrowSpectrum. Spectrum of the squared envelope.
    """

    velocity: VelocityBands | None
    pulses: dict[str, BandPulses]
    envelope: NarrowSpectrum


class VibrationFigures(NamedTuple):
    """Figures of records that go together.

    table : DataFrame. A row for each figure: channel, figure, item, unit, values of run and
        recording, their difference, and their standard uncertainties with their unit.
    notes : list of str. Sentences on them.
    """

    table: pd.DataFrame
    notes: list[str]


def bands_up_to(
    bands_hz: Mapping[str, tuple[float, float]], highest_hz: float
) -> dict[str, tuple[float, float]]:
    """Return bands that end at a frequency, without those that are above it."""
    return {
        name: (low, min(high, highest_hz))
        for name, (low, high) in bands_hz.items()
        if highest_hz - low >= _LEAST_WIDTH_HZ
    }


def read_vibration(
    samples: Array,
    rate_hz: float,
    *,
    quantity: str,
    bands_hz: Mapping[str, tuple[float, float]],
    envelope_hz: tuple[float, float],
    envelope_samples: int | None = None,
    has_unit: bool = True,
) -> ReadVibration:
    """Read a record of acceleration or velocity.

    Parameters
    ----------
    samples : (n,) array, m/s2 or m/s, or any unit.
    rate_hz : float, Hz.
    quantity : str. acceleration or velocity.
    bands_hz : mapping. Edges of the bands by their names [Hz], within what the record resolves.
    envelope_hz : (float, float), Hz. Band of the envelope.
    envelope_samples : int. Samples of the envelope, from the first on. Default: all.
    has_unit : bool. Whether the unit is that of the quantity.
    """
    velocity = None
    if has_unit:
        own = velocity_of(samples, rate_hz) if quantity == "acceleration" else samples
        velocity = velocity_bands(own, rate_hz, bands_hz)
    whole = (min(low for low, _ in bands_hz.values()), max(high for _, high in bands_hz.values()))
    return ReadVibration(
        velocity=velocity,
        pulses=band_pulses(samples, rate_hz, {"all": whole, **bands_hz}),
        envelope=squared_envelope_spectrum(samples[:envelope_samples], rate_hz, envelope_hz),
    )


class FoundLine(NamedTuple):
    """A line of an envelope: its frequency [Hz], and its height over its surroundings."""

    hz: float
    height: float | None


def find_line(envelope: NarrowSpectrum, line_hz: float) -> FoundLine:
    """Find a line beside its place, where slip may have moved it; at its place if none stands out.

    The height is None where the record does not separate the line from a stronger one.
    """
    reach = max(SLIP * line_hz, 2 * envelope.line_width_hz)
    peaks = envelope.peaks_hz(1, line_hz - reach, line_hz + reach, LEAST_HEIGHT)
    at_hz = peaks[0] if peaks else line_hz
    return FoundLine(at_hz, envelope.read_line(at_hz).height)


# ---- a run beside a recording


class ComparedSides(NamedTuple):
    """The records of a pair, and of what is healthy.

    channel : str. Name of the channel of the run.
    run, recording : Recording. Both records.
    scale : float or None. Value of full scale of the recordings [SI]; None if it is not known.
    healthy_run, healthy_recording : Recording or None. The same without a fault.
    """

    channel: str
    run: Recording
    recording: Recording
    scale: float | None
    healthy_run: Recording | None = None
    healthy_recording: Recording | None = None

    @property
    def highest_hz(self) -> float:
        """Highest frequency that all records resolve [Hz]."""
        every = (self.run, self.recording, self.healthy_run, self.healthy_recording)
        return min(record.highest for record in every if record is not None)


def vibration_figures(sides: ComparedSides, marks: VibrationMarks) -> VibrationFigures:
    """Return the figures of a run beside those of a recording."""
    highest_hz = _BELOW * sides.highest_hz
    bands_hz = bands_up_to(marks.bands_hz, highest_hz)
    # The envelopes of records of one length have lines of one height over noise.
    count = min(len(record.samples) for record in (sides.run, sides.recording))
    shown = sides.recording.samples[:count]
    fastest_hz = max(marks.lines_hz.values())
    envelope_hz = pulse_kurtogram(shown, RATE, highest_hz, fastest_hz).band_hz

    def read(record: Recording | None, scale: float | None) -> ReadVibration | None:
        """Read a record; None without one."""
        if record is None:
            return None
        return read_vibration(
            record.samples * (scale or 1.0),
            RATE,
            quantity=record.quantity.name,
            bands_hz=bands_hz,
            envelope_hz=envelope_hz,
            envelope_samples=count,
            has_unit=scale is not None,
        )

    own = _ReadSide(read(sides.run, 1.0), read(sides.healthy_run, 1.0))
    recorded = _ReadSide(
        read(sides.recording, sides.scale), read(sides.healthy_recording, sides.scale)
    )
    spread_db = marks.velocity_db.get(sides.channel, {})
    rows = [
        *_velocity_rows(own, recorded, bands_hz, spread_db),
        *_pulse_rows(own, recorded, bands_hz),
        *_line_rows(own, recorded, marks.lines_hz),
    ]
    table = pd.DataFrame(rows, columns=list(_Row._fields))
    table.insert(0, "channel", sides.channel)
    notes = [
        f"envelope: of {band_in_words(envelope_hz)}, the band that the kurtogram of the recording"
        f" chooses, over {count / RATE:.3g} s of both"
    ]
    return VibrationFigures(table=table, notes=notes)


class _ReadSide(NamedTuple):
    """What is read from a record, and from one of the same thing without its fault."""

    faulty: ReadVibration | None
    healthy: ReadVibration | None


class _Row(NamedTuple):
    """A figure of a run beside that of a recording, with the difference and the uncertainties.

    Frequencies are those of a line of the envelope.
    """

    figure: str
    item: str
    unit: str
    run: float
    run_uncertainty: float
    recording: float
    recording_uncertainty: float
    difference: float
    difference_uncertainty: float
    uncertainty_unit: str
    run_hz: float = math.nan
    recording_hz: float = math.nan


def band_in_words(band_hz: tuple[float, float]) -> str:
    """Write a band."""
    return f"{band_hz[0]:,.0f} to {band_hz[1]:,.0f} Hz"


def _velocity_rows(
    own: _ReadSide,
    recorded: _ReadSide,
    bands_hz: Mapping[str, tuple[float, float]],
    run_db: Mapping[str, float],
) -> Iterator[_Row]:
    """Yield velocities by band, and what a fault adds to them."""
    for band, edges in bands_hz.items():
        values = [_velocity(side.faulty, band) for side in (own, recorded)]
        if values[0] is None or values[1] is None:
            continue
        run, recording = values[0], values[1]
        spread_db = max(run_db.get(band, 0.0), run.uncertainty_db)
        yield _Row(
            figure=VELOCITY,
            item=band_in_words(edges),
            unit="um/s",
            run=run.um_s,
            run_uncertainty=spread_db,
            recording=recording.um_s,
            recording_uncertainty=recording.uncertainty_db,
            difference=20 * math.log10(run.um_s / recording.um_s),
            difference_uncertainty=math.hypot(spread_db, recording.uncertainty_db),
            uncertainty_unit=DECIBELS,
        )
    for band, edges in bands_hz.items():
        rises = [_rise(side, band) for side in (own, recorded)]
        if rises[0] is None or rises[1] is None:
            continue
        yield _difference_row(RISE, band_in_words(edges), DECIBELS, rises[0], rises[1])


class _Number(NamedTuple):
    """A number with its standard uncertainty."""

    value: float
    uncertainty: float


class _Velocity(NamedTuple):
    """A velocity [um/s] with its standard uncertainty [dB]."""

    um_s: float
    uncertainty_db: float


def _velocity(read: ReadVibration | None, band: str) -> _Velocity | None:
    """Return the velocity of a band; None if it is not known, or nothing moves."""
    if read is None or read.velocity is None or read.velocity.rms_m_s[band] <= 0:
        return None
    return _Velocity(UM_S * read.velocity.rms_m_s[band], read.velocity.uncertainty_db[band])


def _rise(side: _ReadSide, band: str) -> _Number | None:
    """Return by how much a fault raises the velocity of a band [dB]; None if it is not known."""
    faulty, healthy = _velocity(side.faulty, band), _velocity(side.healthy, band)
    if faulty is None or healthy is None:
        return None
    spread = math.hypot(faulty.uncertainty_db, healthy.uncertainty_db)
    return _Number(20 * math.log10(faulty.um_s / healthy.um_s), spread)


def _difference_row(figure: str, item: str, unit: str, run: _Number, recording: _Number) -> _Row:
    """Return the row of two numbers whose difference has their unit."""
    return _Row(
        figure=figure,
        item=item,
        unit=unit,
        run=run.value,
        run_uncertainty=run.uncertainty,
        recording=recording.value,
        recording_uncertainty=recording.uncertainty,
        difference=run.value - recording.value,
        difference_uncertainty=math.hypot(run.uncertainty, recording.uncertainty),
        uncertainty_unit=unit,
    )


def _pulse_rows(
    own: _ReadSide, recorded: _ReadSide, bands_hz: Mapping[str, tuple[float, float]]
) -> Iterator[_Row]:
    """Yield kurtosis and crest factor of all bands together and of each, and the rise of the first.

    A crest factor has no uncertainty: it grows with the length of a record.
    """
    assert own.faulty is not None and recorded.faulty is not None
    for band in own.faulty.pulses:
        item = "all bands" if band == "all" else band_in_words(bands_hz[band])
        run, recording = own.faulty.pulses[band], recorded.faulty.pulses[band]
        if run.kurtosis is None or recording.kurtosis is None:
            continue
        yield _difference_row(KURTOSIS, item, "1", _kurtosis(run), _kurtosis(recording))
        crests = [_Number(pulses.crest_factor or 0.0, math.nan) for pulses in (run, recording)]
        yield _difference_row(CREST, item, "1", *crests)
    if own.healthy is None or recorded.healthy is None:
        return
    changes = []
    for faulty, healthy in ((own.faulty, own.healthy), (recorded.faulty, recorded.healthy)):
        before, after = _kurtosis(healthy.pulses["all"]), _kurtosis(faulty.pulses["all"])
        spread = math.hypot(before.uncertainty, after.uncertainty)
        changes.append(_Number(after.value - before.value, spread))
    yield _difference_row(KURTOSIS_RISE, "all bands", "1", *changes)


def _kurtosis(pulses: BandPulses) -> _Number:
    """Return the kurtosis of a record; NaN for silence."""
    if pulses.kurtosis is None or pulses.kurtosis_uncertainty is None:
        return _Number(math.nan, math.nan)
    return _Number(pulses.kurtosis, pulses.kurtosis_uncertainty)


def _line_rows(
    own: _ReadSide, recorded: _ReadSide, lines_hz: Mapping[str, float]
) -> Iterator[_Row]:
    """Yield the heights of lines of the envelope, each at its place in its record."""
    assert own.faulty is not None and recorded.faulty is not None
    for name, line_hz in lines_hz.items():
        run, recording = (
            find_line(side.envelope, line_hz) for side in (own.faulty, recorded.faulty)
        )
        heights = [math.nan if line.height is None else line.height for line in (run, recording)]
        yield _Row(
            figure=ENVELOPE,
            item=name,
            unit="1",
            run=heights[0],
            run_uncertainty=math.nan,
            recording=heights[1],
            recording_uncertainty=math.nan,
            difference=_decibels(heights[0], heights[1]),
            difference_uncertainty=math.nan,
            uncertainty_unit=DECIBELS,
            run_hz=run.hz,
            recording_hz=recording.hz,
        )


def _decibels(run: float, recording: float) -> float:
    """Return the ratio of two heights [dB]; NaN where one is nothing or unknown."""
    return 20 * math.log10(run / recording) if run > 0 and recording > 0 else math.nan


# ---- in words

_HEADS = {
    VELOCITY: ("band", "velocity, rms [um/s]", "[dB]"),
    RISE: ("band", "rise of the velocity by the fault [dB]", "[dB]"),
    KURTOSIS: ("band", "kurtosis", ""),
    KURTOSIS_RISE: ("band", "rise of the kurtosis by the fault", ""),
    CREST: ("band", "crest factor", ""),
    ENVELOPE: ("line", "height over its surroundings", "[dB]"),
}


def figure_words(table: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the figures of a channel as words, a table for each kind of figure."""
    tables = {}
    for figure, (item, heading, unit) in _HEADS.items():
        rows = table[table["figure"] == figure]
        if rows.empty:
            continue
        columns: dict[str, Sequence[str]] = {item: list(rows["item"])}
        for name in ("run", "recording"):
            columns[name] = [
                _with_spread(value, spread, of_unit)
                for value, spread, of_unit in zip(
                    rows[name], rows[f"{name}_uncertainty"], rows["uncertainty_unit"], strict=True
                )
            ]
            if figure == ENVELOPE:
                columns[f"{name}, at Hz"] = [f"{hz:.2f}" for hz in rows[f"{name}_hz"]]
        columns[f"difference {unit}".strip()] = [
            _with_spread(value, spread, "1")
            for value, spread in zip(
                rows["difference"], rows["difference_uncertainty"], strict=True
            )
        ]
        tables[heading] = pd.DataFrame(columns)
    return tables


def _with_spread(value: float, spread: float, unit: str) -> str:
    """Write a number with its ±, in the unit of the ±."""
    if math.isnan(value):
        return "not known"
    text = rounded(value, 3)
    if math.isnan(spread):
        return text
    return f"{text} ± {math.ceil(10 * spread) / 10:.1f}" + (" dB" if unit == DECIBELS else "")


def figure_sentences(table: pd.DataFrame) -> Iterator[str]:
    """Say how far the bands of a channel are from the recording, and what a fault adds to them."""
    bands = table[table["figure"] == VELOCITY]
    if len(bands):
        differences = np.array(bands["difference"])
        texts = [
            f"{value:+.1f} dB ({item})"
            for value, item in zip(differences, bands["item"], strict=True)
        ]
        yield f"The velocity of the run is {', '.join(texts)} against the recording."
    rises = table[table["figure"] == RISE]
    if len(rises):
        pairs = [
            f"{run:+.1f} dB where the recording has {recording:+.1f} ({item})"
            for run, recording, item in zip(
                rises["run"], rises["recording"], rises["item"], strict=True
            )
        ]
        yield f"The fault changes the run by {', '.join(pairs)}."
