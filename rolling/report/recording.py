"""A recording of the real thing beside a run: third octaves, total level, modulation, and a page.

Levels have the reference values of ISO 1683, their uncertainties are standard uncertainties.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pandas as pd
from markupsafe import Markup
from matplotlib.axes import Axes
from numpy.typing import NDArray

from acoustics import level, plots, spectrum, uncertainty
from acoustics.arrays import Array
from acoustics.bands import (
    BAND_NAMES,
    EDGES_HZ,
    MID_HZ,
    NOMINAL_HZ,
    band_uncertainty_db,
    third_octave_mean_square,
)
from acoustics.modulation import envelope_spectrum
from acoustics.radiation import P_REF_PA
from acoustics.wav import PEAK
from acoustics.wav import SAMPLE_RATE_HZ as RATE
from rolling import __version__
from rolling.figures.picture import finish, picture
from rolling.figures.settings import left_out_if_it_fails
from rolling.report import maps, records, text
from rolling.report.recorded import (
    FAINTEST,
    PRESSURE,
    SKIPPED,
    MeasuredQuantity,
    Recording,
    full_scales,
    quantity_of,
    read_channels,
    usable,
)
from rolling.report.stretch import Stretch, fitting_stretch
from rolling.report.templates import environment
from rolling.results import listening
from rolling.results.run_result import Run
from rolling.scene.messages import nearest
from rolling.terminal.files import FolderError

if TYPE_CHECKING:
    from rolling.results.channels import Channel

HEARD_S = 20.0  # of each sound on the page
CLEAR_DB = 3.0  # least level of a recording above its background
MAX_DB = 10.0  # least uncertainty of a band that tells nothing
MODULATION_HZ = 2.0 ** np.arange(8)  # mid frequencies of octaves of modulation
THIRD_OCTAVE = "third octave"
MODULATION = "modulation"
TOTALS = ("LAeq", "LZeq", "all bands")  # names of total levels, of which the first counts
FULL_MODULATION = "full modulation"  # the reference of a modulation
_HANN = 1.5  # sum of the squared lines of a tone in a Hann window
_DB = 10.0 / math.log(10.0)
# The body and the place of a channel that a scene lacks, by its quantity.
_LACKING = {
    "acceleration": "of: plate, quantity: acceleration, x_mm: 30, y_mm: 40",
    "velocity": "of: plate, quantity: velocity, x_mm: 30, y_mm: 40",
    "displacement": "of: plate, quantity: displacement, x_mm: 30, y_mm: 40",
    "force": "of: contact, quantity: force",
}


class RecordPair(NamedTuple):
    """A record of the run and the channel of the recording that goes with it.

    name : str. Name of the run's channel; empty for sound pressure.
    number : int. Number of the recording's channel, from 0 on.
    run, recording : Recording. Both records.
    lap_s : float, s. Length of the solved track in the record of the run.
    """

    name: str
    number: int
    run: Recording
    recording: Recording
    lap_s: float

    @property
    def records(self) -> dict[str, Recording]:
        """Both records by their names."""
        return {"run": self.run, "recording": self.recording}

    def named(self, word: str) -> str:
        """Return a word with the name of the channel."""
        return f"{word}, {self.name}" if self.name else word


class Bands(NamedTuple):
    """Levels of third octaves and their standard uncertainty [dB], (31,); NaN is unknown."""

    level_db: Array
    a_weighted_db: Array
    uncertainty_db: Array

    def only(self, known: NDArray[np.bool_]) -> Bands:
        """Return the bands of a mask, all others NaN."""
        return Bands(
            level_db=np.where(known, self.level_db, np.nan),
            a_weighted_db=np.where(known, self.a_weighted_db, np.nan),
            uncertainty_db=np.where(known, self.uncertainty_db, np.nan),
        )

    def weighted(self, weighting: str) -> Array:
        """Return the levels with a weighting, A or Z."""
        return self.a_weighted_db if weighting == "A" else self.level_db


class RecordingComparison(NamedTuple):
    """Table of levels and differences, sentences on them, and the records pair by pair.

    Differences are the run less the recording.
    """

    table: pd.DataFrame
    notes: list[str]
    pairs: list[RecordPair]

    @property
    def quantity(self) -> MeasuredQuantity:
        """The quantity that is compared."""
        return self.pairs[0].recording.quantity


# ---- records of a run, and the channels that go with them


def of_run(run: Run) -> Recording:
    """Return the long record of a run if its scene asks for one, otherwise its signal."""
    is_drop = run.scene.rolling.drop_mm is not None
    long = listening.long_record_of(run)
    if long is not None:
        return Recording(
            name="long record",
            samples=long.pressure,
            highest=run.sound.highest,
            seconds=len(long.pressure) / RATE,
            is_drop=is_drop,
        )
    return Recording(
        name="signal",
        samples=run.sound.pressure,
        highest=run.sound.highest,
        seconds=run.sound.duration / run.laps,
        is_drop=is_drop,
    )


def _of_channel(run: Run, channel: Channel, quantity: MeasuredQuantity) -> Recording:
    """Return the record of a channel of a run."""
    if not np.any(channel.samples):
        raise FolderError(f"{run.folder}: its channel {channel.name} is silent")
    return Recording(
        name=channel.name,
        samples=np.asarray(channel.samples, dtype=float),
        highest=channel.highest_hz,
        seconds=len(channel.samples) / RATE / run.laps,
        is_drop=run.scene.rolling.drop_mm is not None,
        quantity=quantity,
    )


def pair_records(
    run: Run, path: Path, quantity: MeasuredQuantity, names: Sequence[str] = ()
) -> list[RecordPair]:
    """Return the records of a run, each with its channel of a recording.

    Parameters
    ----------
    run : Run. The run.
    path : Path. Sound file. Of sound pressure its first channel is taken.
    quantity : MeasuredQuantity. What it holds.
    names : sequence of str. Names of channels of the run in the order of the recording's channels;
        "-" leaves one out. Default: the channels of the quantity in their order.

    Raises
    ------
    FolderError : the run has no such channels, their numbers differ, or a record is no signal.
    """
    recorded = read_channels(path, quantity)
    if quantity is PRESSURE:
        if names:
            raise FolderError("--channel: only goes with --quantity; of sound a run has one record")
        own = of_run(run)
        recording = usable(path, recorded, 0)._replace(is_drop=own.is_drop)
        lap_s = run.sound.duration / run.laps
        return [RecordPair(name="", number=0, run=own, recording=recording, lap_s=lap_s)]
    channels = _channels_of(run, quantity, names, len(recorded), path)
    pairs = []
    for number, channel in enumerate(channels):
        if channel is None:
            continue
        own = _of_channel(run, channel, quantity)
        recording = usable(path, recorded, number)._replace(is_drop=own.is_drop)
        pairs.append(
            RecordPair(
                name=channel.name,
                number=number,
                run=own,
                recording=recording,
                lap_s=own.seconds,
            )
        )
    if not pairs:
        raise FolderError(f"--channel: got {SKIPPED} for all channels, allowed: at least one name")
    return pairs


def _channels_of(
    run: Run, quantity: MeasuredQuantity, names: Sequence[str], count: int, path: Path
) -> list[Channel | None]:
    """Return the channel of a run for each channel of a recording; None where it is left out."""
    of_quantity = {item.name: item for item in run.channels if item.quantity == quantity.name}
    if not of_quantity:
        others = [f"{item.quantity} of {item.of}" for item in run.channels]
        raise FolderError(f"{run.folder}: {lacking_channels(quantity, others)}")
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


# ---- levels


def compare(
    run: Run,
    path: Path,
    calibration: str | Sequence[str] | None = None,
    background: Path | None = None,
    quantity: str = PRESSURE.name,
    channels: Sequence[str] = (),
) -> RecordingComparison:
    """Compare a run with a recording; raise FolderError where nothing can be compared.

    Parameters
    ----------
    run : Run. The run.
    path : Path. The recording.
    calibration : str. As in `full_scales`. Default: the total levels are made equal.
    background : Path. Recording of the background alone, with one channel or as many as the
        recording. Default: none.
    quantity : str. A name of QUANTITIES. Default: pressure.
    channels : sequence of str. Names of the run's channels, as in `pair_records`.
    """
    measured = quantity_of(quantity)
    pairs = pair_records(run, path, measured, channels)
    count = len(read_channels(path, measured))
    scales: list[float | None] = [None] * count
    if calibration is not None:
        scales = [*full_scales(calibration, measured, count)]
    placed = _placed(pairs)
    tables = []
    notes = [_run_note(run, pairs), *_place_notes(pairs, placed)]
    for pair in placed.pairs:
        noise = None
        if background is not None:
            noise = _background(background, measured, pair.number, count)
        compared = _compare_pair(pair, path, scales[pair.number], noise)
        tables.append(compared.table)
        notes += compared.notes
    if measured is PRESSURE and run.summary["source"] == "release":
        notes.append(
            "a recording holds what is heard, and the run its released power: compare the shape of"
            " the spectrum, not its level"
        )
    clipped = [pair.named("the recording") for pair in pairs if pair.recording.is_clipped]
    notes += [f"{name} is clipped: repeat it with less gain" for name in clipped]
    return RecordingComparison(table=pd.concat(tables), notes=notes, pairs=placed.pairs)


class _Placed(NamedTuple):
    """Pairs of records whose longer ones are cut to the stretch that fits, and that stretch."""

    pairs: list[RecordPair]
    stretch: Stretch | None


def _placed(pairs: Sequence[RecordPair]) -> _Placed:
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
    return _Placed(pairs=cut, stretch=stretch)


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


def _place_notes(pairs: Sequence[RecordPair], placed: _Placed) -> list[str]:
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


def _background(path: Path, quantity: MeasuredQuantity, number: int, count: int) -> Recording:
    """Return the channel of a recording of the background that goes with a channel."""
    channels = read_channels(path, quantity)
    if quantity is PRESSURE or len(channels) == 1:
        number = 0
    elif len(channels) != count:
        raise FolderError(
            f"{path}: got a background with {len(channels)} channels, allowed: 1, or {count} as in"
            " the recording"
        )
    return usable(path, channels, number).whole()


class _PairComparison(NamedTuple):
    """Rows of the table of a pair of records, and sentences on them."""

    table: pd.DataFrame
    notes: list[str]


def _compare_pair(
    pair: RecordPair, path: Path, full_scale: float | None, noise: Recording | None
) -> _PairComparison:
    """Compare a record of a run with a channel of a recording.

    Without the value of full scale [SI unit] the total levels are made equal.
    """
    own = pair.run
    recording = pair.recording
    quantity = recording.quantity
    # A long record tells no more about its bands than the solved track that it continues.
    computed = _bands(own, pair.lap_s)
    recorded = _bands(recording)
    is_known = np.isfinite(computed.a_weighted_db + recorded.a_weighted_db)
    if noise is not None:
        recorded = _without(_bands(noise), recorded)
    is_clear = is_known & np.isfinite(recorded.a_weighted_db)
    spread_db = np.hypot(computed.uncertainty_db, recorded.uncertainty_db)
    is_common = is_clear & (spread_db < MAX_DB)
    left_out = [
        *_left_out("not clearly above the background", is_known & ~is_clear),
        *_left_out(f"uncertain by {MAX_DB:g} dB or more", is_clear & ~is_common),
    ]
    if pair.name:
        left_out = [f"{pair.name}: {text}" for text in left_out]
    if not is_common.any():
        fault = pair.named("no third octave can be compared")
        raise FolderError("; ".join([f"{path}: {fault}", *left_out]))
    computed = computed.only(is_common)
    recorded = recorded.only(is_common)
    loudest = int(np.nanargmax(computed.weighted(quantity.weighting)))
    octave = EDGES_HZ[max(loudest - 1, 0)], EDGES_HZ[min(loudest + 2, len(BAND_NAMES))]
    run_db, run_uncertainty_db = _levels(own, computed, octave)
    recording_db, recording_uncertainty_db = _levels(recording, recorded, octave)
    totals = _totals(quantity)
    first_total = len(BAND_NAMES)  # the totals stand behind the bands
    if full_scale is None:
        shift_db = run_db[first_total] - recording_db[first_total]
        scale = f"not calibrated: its {totals[0].name} is made equal"
    else:
        shift_db = 20 * math.log10(full_scale)
        scale = f"full scale is {full_scale:.4g} {quantity.unit}"
    levels = first_total + len(totals)
    recording_db[:levels] += shift_db
    a_weighting_db = np.full(len(run_db), np.nan)
    a_weighting_db[:first_total] = computed.a_weighted_db - computed.level_db
    names = [THIRD_OCTAVE] * first_total + [total.name for total in totals]
    weightings = ["Z"] * first_total + [total.weighting for total in totals]
    no_frequency = [math.nan] * len(totals)
    octaves = len(MODULATION_HZ)
    table = pd.DataFrame(
        {
            "channel": pair.name,
            "quantity": names + [MODULATION] * octaves,
            "weighting": weightings + ["-"] * octaves,
            "reference": [quantity.reference_text] * levels + [FULL_MODULATION] * octaves,
            "frequency_hz": [*NOMINAL_HZ, *no_frequency, *MODULATION_HZ],
            "mid_frequency_hz": [*MID_HZ, *no_frequency, *MODULATION_HZ],
            "run_db": run_db,
            "run_uncertainty_db": run_uncertainty_db,
            "recording_db": recording_db,
            "recording_uncertainty_db": recording_uncertainty_db,
            "difference_db": run_db - recording_db,
            "difference_uncertainty_db": np.hypot(run_uncertainty_db, recording_uncertainty_db),
            "run_a_weighted_db": run_db + a_weighting_db,
            "recording_a_weighted_db": recording_db + a_weighting_db,
        }
    )
    if quantity is not PRESSURE:
        table = table.drop(columns=["run_a_weighted_db", "recording_a_weighted_db"])
    which = "first channel" if pair.number == 0 else f"channel {pair.number + 1}"
    with_run = f" with the run's {pair.name}" if pair.name else ""
    loudest_of = f", where the run{f' ({pair.name})' if pair.name else ''} is loudest"
    notes = [
        f"recording: {recording.name}, {which}{with_run}, {recording.seconds:.3g} s; {scale}",
        f"modulation: from {octave[0]:.0f} to {octave[1]:.0f} Hz{loudest_of}",
        *left_out,
    ]
    return _PairComparison(table=table.dropna(subset="difference_db"), notes=notes)


class _Total(NamedTuple):
    """Total level of the third octaves that are compared, and its weighting."""

    name: str
    weighting: str


def _totals(quantity: MeasuredQuantity) -> list[_Total]:
    """Return the total levels of a quantity; the first is made equal without a calibration."""
    if quantity is PRESSURE:
        return [_Total(TOTALS[0], "A"), _Total(TOTALS[1], "Z")]
    return [_Total(TOTALS[2], "Z")]


def _run_note(run: Run, pairs: Sequence[RecordPair]) -> str:
    """Say what the levels of a run are of."""
    first = pairs[0]
    if first.recording.quantity is PRESSURE:
        return f"run: {_quantity(run)}, {first.run.name} of {first.run.seconds:.3g} s"
    quantity = first.recording.quantity
    places = ", ".join(pair.name for pair in pairs)
    return (
        f"run: levels of the {quantity.name} in dB re {quantity.reference_text}, of {places},"
        f" {len(first.run.samples) / RATE:.3g} s"
    )


def _quantity(run: Run) -> str:
    """Name what the levels of a run are of, with the verdict on them."""
    verdict = run.summary.get("verdict") or {}
    word = verdict.get("word", "-")
    if run.summary["source"] == "vibration":
        return f"levels of the vibration (verdict: {word})"
    if run.summary.get("q", 1) is None:
        return f"levels of the released power under the gain of the scene (verdict: {word})"
    q = run.summary.get("q") or 1
    bound = ", an upper bound" if q == 1 else ""
    return f"levels of the released power with q = {q:g}{bound} (verdict: {word})"


def _left_out(fault: str, bands: NDArray[np.bool_]) -> list[str]:
    """Name the bands that are left out for a fault; nothing if there are none."""
    if not bands.any():
        return []
    return [f"{fault}, left out: {', '.join(np.array(BAND_NAMES)[bands])} Hz"]


def _bands(record: Recording, seconds: float | None = None) -> Bands:
    """Return the levels of third octaves of a record, NaN if silent.

    The uncertainty is that of Gaussian noise of a duration [s], by default of a lap, joined with
    the part of the scatter of the total level between thirds that noise rarely has: all bands rise
    and fall.
    """
    samples = record.samples
    laps = len(samples) / RATE / (seconds or record.seconds)
    levels = level.sound_levels(samples, RATE, record.highest, closed=False)
    noise = uncertainty.level_uncertainty(samples, RATE, levels, False, laps)
    # A sharp resonance leaves fewer independent lines in a band than its width does.
    frequency, square = spectrum.line_spectrum(samples, RATE)
    sums = third_octave_mean_square(frequency, square)
    squares = third_octave_mean_square(frequency, square**2)
    with np.errstate(under="ignore"):
        of_lines = _DB * np.sqrt(laps * squares / 2) / np.where(sums > 0, sums, np.nan)
    # A level that rises and falls couples neighbouring lines: a band has no more than its B T.
    of_length = band_uncertainty_db(len(samples) / RATE / laps)
    of_noise = np.maximum(np.fmax(_by_band(noise.third_octave_db), of_lines), of_length)
    total_db = noise.laeq_db if record.quantity.weighting == "A" else noise.level_db
    beyond = max(0.0, record.scatter_db**2 - 9 * (total_db or 0.0) ** 2)
    # Levels of sound have the reference value of sound pressure.
    shift_db = 20 * math.log10(P_REF_PA / record.quantity.reference)
    return Bands(
        level_db=_by_band(levels.third_octave_db) + shift_db,
        a_weighted_db=_by_band(levels.third_octave_a_db) + shift_db,
        uncertainty_db=np.sqrt(of_noise**2 + beyond),
    )


def _by_band(levels: Mapping[str, float | None]) -> Array:
    """Return levels of third octaves by name as an array, NaN in place of None."""
    return np.array([levels[name] for name in BAND_NAMES], dtype=float)


def _without(noise: Bands, recorded: Bands) -> Bands:
    """Subtract the background from a recording; bands that are not clearly above become NaN.

    They are 3 dB above it, and by twice the standard uncertainty of the distance: in a band of few
    lines one noise is easily 3 dB above another.
    """
    noise_db = np.nan_to_num(noise.level_db, nan=-400.0)
    spread_db = np.hypot(recorded.uncertainty_db, np.nan_to_num(noise.uncertainty_db))
    clear_db = np.maximum(CLEAR_DB, 2 * spread_db)
    share = 10 ** ((noise_db - recorded.level_db) / 10)
    net = np.where(recorded.level_db - noise_db >= clear_db, 1 - share, np.nan)
    of_noise = share * np.nan_to_num(noise.uncertainty_db)
    return Bands(
        level_db=recorded.level_db + 10 * np.log10(net),
        a_weighted_db=recorded.a_weighted_db + 10 * np.log10(net),
        uncertainty_db=np.hypot(recorded.uncertainty_db, of_noise) / net,
    )


def _levels(record: Recording, bands: Bands, octave: tuple[float, float]) -> tuple[Array, Array]:
    """Return levels and uncertainties [dB] of third octaves, total levels and modulation."""
    totals_db = []
    totals_uncertainty_db = []
    for total in _totals(record.quantity):
        power = 10 ** (bands.weighted(total.weighting) / 10)
        whole = np.nansum(power)
        spread = np.sqrt(np.nansum(np.square(power * bands.uncertainty_db)))
        totals_db.append(10 * np.log10(whole))
        # The bands of impacts rise and fall together.
        totals_uncertainty_db.append(max(spread / whole, record.scatter_db))
    modulation_db, modulation_uncertainty_db = _modulation(record, octave)
    levels_db = np.hstack([bands.level_db, totals_db, modulation_db])
    uncertainties_db = np.hstack(
        [bands.uncertainty_db, totals_uncertainty_db, modulation_uncertainty_db]
    )
    return levels_db, uncertainties_db


def _modulation(record: Recording, band: tuple[float, float]) -> tuple[Array, Array]:
    """Return octaves of the modulation of a band, re full modulation, and their uncertainty [dB].

    They are NaN where the record is too short, or the band too narrow.
    """
    envelope = envelope_spectrum(record.samples, RATE, band)
    low = MODULATION_HZ / 2**0.5
    octaves = np.searchsorted(low, envelope.frequency_hz)  # 0 below the first
    squares = np.bincount(octaves, np.square(envelope.modulation), len(low) + 1)[1:] / _HANN
    levels_db = 10 * np.log10(np.maximum(squares, FAINTEST))
    uncertainties_db = _DB / np.sqrt(low * record.seconds)
    is_known = (low * record.seconds >= 2) & (4 * low <= band[1] - band[0])
    return np.where(is_known, levels_db, np.nan), np.where(is_known, uncertainties_db, np.nan)


# ---- text and page


def words(comparison: RecordingComparison) -> dict[str, pd.DataFrame]:
    """Return levels and differences with their uncertainties as words, a table for each heading.

    Each column names the weighting and the reference value of its levels.
    """
    tables = {}
    quantity = comparison.quantity
    for pair in comparison.pairs:
        rows = comparison.table[comparison.table["channel"] == pair.name]
        is_band = rows["quantity"] == THIRD_OCTAVE
        is_modulation = rows["quantity"] == MODULATION
        bands = _in_words(rows[is_band], f"Z-weighted [dB re {quantity.reference_text}]")
        bands.insert(0, "Hz", rows[is_band]["frequency_hz"].map("{:g}".format))
        if quantity is PRESSURE:
            for name in ("run", "recording"):
                levels = rows[is_band][f"{name}_a_weighted_db"].map("{:.1f}".format)
                bands[f"{name}, A-weighted [dB re {quantity.reference_text}]"] = levels
        tables[pair.named("third octaves")] = bands
        totals = rows[~is_band & ~is_modulation]
        summed = _in_words(totals, f"[dB re {quantity.reference_text}]")
        weighted = totals["quantity"] + ", " + totals["weighting"] + "-weighted"
        summed.insert(0, "total of these bands", weighted)
        tables[pair.named("total levels")] = summed
        if is_modulation.any():
            modulation = _in_words(rows[is_modulation], "[dB re full modulation]")
            octaves = rows[is_modulation]["frequency_hz"].map("{:g}".format)
            modulation.insert(0, "octave of modulation, Hz", octaves)
            tables[pair.named("modulation")] = modulation
    return tables


def _in_words(rows: pd.DataFrame, unit: str) -> pd.DataFrame:
    """Write levels in a unit, and differences, with their uncertainties."""
    columns = {"run": f"run, {unit}", "recording": f"recording, {unit}"}
    if unit.startswith("["):
        columns = {"run": f"run {unit}", "recording": f"recording {unit}"}
    columns["difference"] = "difference [dB]"
    frame = pd.DataFrame(index=rows.index)
    for name, column in columns.items():
        pairs = zip(rows[f"{name}_db"], rows[f"{name}_uncertainty_db"], strict=True)
        # A level that rounds to -0.0 is written as 0.0.
        frame[column] = [f"{round(db, 1) + 0.0:.1f} ± {u:.1f}" for db, u in pairs]
    return frame


def page(run: Run, comparison: RecordingComparison) -> bytes:
    """Write a page with the third octaves, all numbers, and the records at equal loudness."""
    drawn = {}
    for number, pair in enumerate(comparison.pairs):
        with left_out_if_it_fails("of the third octaves"):
            draw = partial(_third_octaves, run, comparison, number)
            content = picture("third_octaves", draw).file("svg")
            drawn[pair.named("third octaves")] = maps.uri("image/svg+xml", content or b"")
    tables = {}
    for heading, table in words(comparison).items():
        tables[heading] = Markup(table.to_html(index=False, border=0))
    template = environment().get_template("recording.html")
    return template.render(
        version=__version__,
        seconds=HEARD_S,
        title=run.title,
        notes=comparison.notes,
        tables=tables,
        pictures=drawn,
        sounds=_sounds(comparison),
        is_sound=comparison.quantity is PRESSURE,
        quantity=comparison.quantity.name,
        css=Markup(text.asset("report.css")),
    ).encode()


def _sounds(comparison: RecordingComparison) -> dict[str, str]:
    """Return the records of the pairs as sources of audio, all with the same A-weighted level."""
    sounds = {}
    for pair in comparison.pairs:
        for name, record in pair.records.items():
            heard = record.samples[: round(HEARD_S * RATE)]
            sounds[pair.named(name)] = heard / level.a_weighted_rms(record.samples, RATE)
    loudest = max(np.abs(samples).max() for samples in sounds.values())
    gain = PEAK / max(FAINTEST, loudest)
    return {name: records.compressed(gain * samples) for name, samples in sounds.items()}


def _third_octaves(run: Run, comparison: RecordingComparison, number: int, ax: Axes) -> Axes:
    """Plot the third octaves of a pair of records, by its number."""
    pair = comparison.pairs[number]
    rows = comparison.table[comparison.table["channel"] == pair.name]
    bands = rows[rows["quantity"] == THIRD_OCTAVE].set_index("frequency_hz")
    bands = bands.reindex(NOMINAL_HZ).set_axis(BAND_NAMES)
    curves = [
        (f"{name}, Z", bands[f"{name}_db"], bands[f"{name}_uncertainty_db"])
        for name in pair.records
    ]
    duration_s = min(record.seconds for record in pair.records.values())
    plots.third_octaves(ax, curves, duration_s)
    quantity = comparison.quantity
    if quantity is not PRESSURE:
        ax.set_ylabel(f"{quantity.name} level [dB re {quantity.reference_text}]")
    title = pair.named(f"Third octaves: {run.title}")
    of_recordings = [note for note in comparison.notes if note.startswith("recording: ")]
    return finish(ax, title, of_recordings[number : number + 1])
