"""A recording of the real thing compared with a run, pair by pair of their records.

Third octaves, total levels and modulation are compared. Levels have the reference values of
ISO 1683, their uncertainties are standard uncertainties.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, EDGES_HZ, MID_HZ, NOMINAL_HZ
from acoustics.numbers import rounded_up
from acoustics.wav import SAMPLE_RATE_HZ as RATE
from rolling.kinds.registry import kind_of
from rolling.numbers.quantity import PART_WORDS, uncertain
from rolling.recordings.compared_run import ComparedRun
from rolling.recordings.pairs import RecordPair, pair_records, place_notes, placed_pairs
from rolling.recordings.read_vibration import (
    ComparedSides,
    VibrationFigures,
    figure_words,
    vibration_figures,
)
from rolling.recordings.record_levels import (
    MODULATION_HZ,
    Bands,
    ComparedLevels,
    Total,
    all_levels,
    third_octave_levels,
    totals_of,
    without_background,
)
from rolling.recordings.recorded import (
    PRESSURE,
    FullScale,
    MeasuredQuantity,
    Recording,
    full_scales,
    quantity_of,
    read_channels,
    usable,
)
from rolling.recordings.run_spread import (
    RECORD,
    WHY_LEFT_OUT,
    RunSpread,
    TotalSpread,
)
from rolling.recordings.series_files import FileLayout
from rolling.terminal.whole_files import FolderError

MAX_DB = 10.0  # least uncertainty by its record of a band that tells nothing
NAMED_DB = 0.1  # smallest part of a ± that a sentence names
THIRD_OCTAVE = "third octave"
MODULATION = "modulation"
FULL_MODULATION = "full modulation"  # the reference of a modulation


class RecordingComparison(NamedTuple):
    """Table of levels and differences, sentences on them, and the records pair by pair.

    Differences are the run less the recording. `figures` has those of a vibration beside its third
    octaves, or is empty.
    """

    table: pd.DataFrame
    notes: list[str]
    pairs: list[RecordPair]
    figures: pd.DataFrame

    @property
    def quantity(self) -> MeasuredQuantity:
        """The quantity that is compared."""
        return self.pairs[0].recording.quantity


class Healthy(NamedTuple):
    """What is healthy: a run, and a recording of it, beside those with a fault.

    run : run of any kind.
    path : Path. Recording with the unit of the other one.
    layout : FileLayout. What its file does not say.
    """

    run: Any
    path: Path
    layout: FileLayout = FileLayout()


def compare(
    run: Any,
    path: Path,
    calibration: str | Sequence[str] | None = None,
    background: Path | None = None,
    quantity: str = PRESSURE.name,
    channels: Sequence[str] = (),
    layout: FileLayout | None = None,
    healthy: Healthy | None = None,
) -> RecordingComparison:
    """Compare a run with a recording; raise FolderError where nothing can be compared.

    Parameters
    ----------
    run : run of any kind. The run.
    path : Path. The recording.
    calibration : str. As in `full_scales`. Default: the total levels are made equal.
    background : Path. Recording of the background alone, with one channel or as many as the
        recording. Default: none.
    quantity : str. A name of QUANTITIES. Default: pressure.
    channels : sequence of str. Names of the run's channels, as in `pair_records`.
    layout : FileLayout. What the file of the recording does not say. Default: nothing.
    healthy : Healthy. The same without a fault, over which the rise is stated. Default: nothing.
    """
    measured = quantity_of(quantity)
    recorded = read_channels(path, measured, layout)
    own = kind_of(run.scene).compared(run, measured)
    pairs = pair_records(own, path, recorded, channels)
    count = len(recorded)
    scales: list[FullScale | None] = [None] * count
    if calibration is not None:
        scales = [*full_scales(calibration, measured, count)]
    placed = placed_pairs(pairs)
    tables = []
    notes = [_run_note(own, pairs), *place_notes(pairs, placed)]
    for pair, whole in zip(placed.pairs, pairs, strict=True):
        noise = None
        if background is not None:
            noise = _background(background, measured, pair.number, count)
        of_pair = pair.spread.of_stretch(pair.lap_s / whole.lap_s)
        compared = _compare_pair(pair, of_pair, path, scales[pair.number], noise)
        tables.append(compared.table)
        notes += compared.notes
    figures = _figures(own, placed.pairs, scales, _healthy_pairs(healthy, measured, channels))
    notes += [note for of_pair in figures for note in of_pair.notes]
    notes += own.warnings
    clipped = [pair.named("the recording") for pair in pairs if pair.recording.is_clipped]
    notes += [f"{name} is clipped: repeat it with less gain" for name in clipped]
    return RecordingComparison(
        table=pd.concat(tables),
        notes=notes,
        pairs=placed.pairs,
        figures=pd.concat([of_pair.table for of_pair in figures]) if figures else pd.DataFrame(),
    )


def _healthy_pairs(
    healthy: Healthy | None, quantity: MeasuredQuantity, channels: Sequence[str]
) -> list[RecordPair]:
    """Return the pairs of records without a fault; none where none are given."""
    if healthy is None:
        return []
    own = kind_of(healthy.run.scene).compared(healthy.run, quantity)
    if own.marks is None:
        raise FolderError(
            f"--healthy: goes with acceleration and velocity of a bearing, not with {quantity.name}"
        )
    recorded = read_channels(healthy.path, quantity, healthy.layout)
    return pair_records(own, healthy.path, recorded, channels)


def _figures(
    own: ComparedRun,
    pairs: Sequence[RecordPair],
    scales: Sequence[FullScale | None],
    healthy: Sequence[RecordPair],
) -> list[VibrationFigures]:
    """Return the figures of vibrations, pair by pair; none where none are marked."""
    if own.marks is None:
        return []
    by_name = {pair.name: pair for pair in healthy}
    figures = []
    for pair in pairs:
        scale = scales[pair.number]
        without = by_name.get(pair.name)
        sides = ComparedSides(
            channel=pair.name,
            run=pair.run,
            recording=pair.recording,
            scale=None if scale is None else scale.value,
            healthy_run=None if without is None else without.run,
            healthy_recording=None if without is None else without.recording.whole(),
        )
        figures.append(vibration_figures(sides, own.marks))
    return figures


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
    pair: RecordPair,
    spread: RunSpread,
    path: Path,
    full_scale: FullScale | None,
    noise: Recording | None,
) -> _PairComparison:
    """Compare a record of a run with a channel of a recording.

    Without the value of full scale the total levels are made equal.
    """
    quantity = pair.recording.quantity
    bands = _common_bands(pair, spread, noise)
    if not np.isfinite(bands.run.level_db).any():
        problem = pair.named("no third octave can be compared")
        raise FolderError("; ".join([f"{path}: {problem}", *bands.left_out]))
    loudest = int(np.nanargmax(bands.run.weighted(quantity.weighting)))
    octave = EDGES_HZ[max(loudest - 1, 0)], EDGES_HZ[min(loudest + 2, len(BAND_NAMES))]
    own = all_levels(pair.run, bands.run, octave)
    recorded = all_levels(pair.recording, bands.recording, octave)
    totals = totals_of(quantity)
    first_total = len(BAND_NAMES)  # the totals stand behind the bands
    calibration_db = 0.0
    if full_scale is None:
        shift_db = own.levels_db[first_total] - recorded.levels_db[first_total]
        scale = f"not calibrated: its {totals[0].name} is made equal"
    else:
        shift_db = 20 * math.log10(full_scale.value)
        scale = f"full scale is {full_scale.value:.4g} {quantity.unit}"
        calibration_db = full_scale.uncertainty_db
    levels = slice(0, first_total + len(totals))  # the modulation behind them is no level
    recorded.levels_db[levels] += shift_db
    of_bands = spread.of_bands(own.uncertainties_db[:first_total])
    of_totals = _total_spreads(spread, own, bands.run, quantity)
    own_records_db = own.uncertainties_db.copy()
    own_records_db[levels] = [*of_bands.record_db, *(of_total.record_db for of_total in of_totals)]
    records_db = np.hypot(own_records_db, recorded.uncertainties_db)
    recorded.uncertainties_db[levels] = np.hypot(recorded.uncertainties_db[levels], calibration_db)
    own.uncertainties_db[levels] = [
        *of_bands.whole_db,
        *(of_total.whole_db for of_total in of_totals),
    ]
    a_weighting_db = bands.run.a_weighted_db - bands.run.level_db
    table = _pair_table(pair, own, recorded, records_db, a_weighting_db)
    table["left_out"] = ""
    for total, of_total in zip(totals, of_totals, strict=True):
        table.loc[table["quantity"] == total.name, "left_out"] = " ".join(of_total.left_out)
    which = "first channel" if pair.number == 0 else f"channel {pair.number + 1}"
    with_run = f" with the run's {pair.name}" if pair.name else ""
    loudest_of = f", where the run{f' ({pair.name})' if pair.name else ''} is loudest"
    notes = [
        f"recording: {pair.recording.name}, {which}{with_run}, {pair.recording.seconds:.3g} s;"
        f" {scale}",
        f"modulation: from {octave[0]:.0f} to {octave[1]:.0f} Hz{loudest_of}",
        *_spread_notes(of_totals[0], totals[0]),
        *bands.left_out,
    ]
    return _PairComparison(table=table, notes=notes)


def _total_spreads(
    spread: RunSpread, own: ComparedLevels, bands: Bands, quantity: MeasuredQuantity
) -> list[TotalSpread]:
    """Return the uncertainties of the totals of a run's third octaves that are compared.

    `own` has those of the compared record.
    """
    first_total = len(BAND_NAMES)
    return [
        spread.of_total(
            total=total,
            compared=np.isfinite(bands.level_db),
            powers=np.asarray(10 ** (bands.weighted(total.weighting) / 10)),
            record_db=float(own.uncertainties_db[first_total + number]),
        )
        for number, total in enumerate(totals_of(quantity))
    ]


def _spread_notes(of_total: TotalSpread, total: Total) -> Iterator[str]:
    """Say what the ± of a run's total holds beside the length of its record, and what it lacks.

    Nothing is left out because a run shared it with the recording: they share nothing.
    """
    large = [
        f"{rounded_up(part)} dB by {PART_WORDS[source]}"
        for source, part in sorted(of_total.parts.items(), key=lambda item: -item[1])
        if part >= NAMED_DB and source != RECORD
    ]
    if large:
        yield f"± of the run's {total.name}, beside the length of its record: {', '.join(large)}"
    if of_total.left_out:
        named = [f"{PART_WORDS[source]}, {WHY_LEFT_OUT[source]}" for source in of_total.left_out]
        yield f"left out of the ± of the run's {total.name}: {'; '.join(named)}"


class _CommonBands(NamedTuple):
    """Third octaves that both records of a pair tell, NaN in all others, and which are left out."""

    run: Bands
    recording: Bands
    left_out: list[str]


def _common_bands(pair: RecordPair, spread: RunSpread, noise: Recording | None) -> _CommonBands:
    """Return the third octaves of both records, the recording's without its background."""
    # A long record tells no more about its bands than the solved track that it continues.
    computed = third_octave_levels(pair.run, pair.lap_s, spread.excess)
    recorded = third_octave_levels(pair.recording)
    is_known = np.isfinite(computed.a_weighted_db + recorded.a_weighted_db)
    if noise is not None:
        recorded = without_background(third_octave_levels(noise), recorded)
    is_clear = is_known & np.isfinite(recorded.a_weighted_db)
    spread_db = np.hypot(computed.uncertainty_db, recorded.uncertainty_db)
    is_common = is_clear & (spread_db < MAX_DB)
    left_out = [
        *_left_out("not clearly above the background", is_known & ~is_clear),
        *_left_out(f"uncertain by {MAX_DB:g} dB or more", is_clear & ~is_common),
    ]
    if pair.name:
        left_out = [f"{pair.name}: {text}" for text in left_out]
    return _CommonBands(
        run=computed.only(is_common), recording=recorded.only(is_common), left_out=left_out
    )


def _left_out(problem: str, bands: NDArray[np.bool_]) -> list[str]:
    """Name the bands that are left out for a problem; nothing if there are none."""
    if not bands.any():
        return []
    return [f"{problem}, left out: {', '.join(np.array(BAND_NAMES)[bands])} Hz"]


def _pair_table(
    pair: RecordPair,
    own: ComparedLevels,
    recorded: ComparedLevels,
    records_db: Array,
    a_weighting_db: Array,
) -> pd.DataFrame:
    """Tabulate the levels of both records: third octaves, total levels, octaves of modulation.

    `records_db` are the uncertainties of the differences [dB] by the lengths of the records alone.
    """
    quantity = pair.recording.quantity
    totals = totals_of(quantity)
    bands = len(BAND_NAMES)
    octaves = len(MODULATION_HZ)
    no_frequency = [math.nan] * len(totals)
    names = [THIRD_OCTAVE] * bands + [total.name for total in totals] + [MODULATION] * octaves
    weightings = ["Z"] * bands + [total.weighting for total in totals] + ["-"] * octaves
    references = [quantity.reference_text] * (bands + len(totals)) + [FULL_MODULATION] * octaves
    columns = {
        "channel": pair.name,
        "quantity": names,
        "weighting": weightings,
        "reference": references,
        "frequency_hz": [*NOMINAL_HZ, *no_frequency, *MODULATION_HZ],
        "mid_frequency_hz": [*MID_HZ, *no_frequency, *MODULATION_HZ],
        "run_db": own.levels_db,
        "run_uncertainty_db": own.uncertainties_db,
        "recording_db": recorded.levels_db,
        "recording_uncertainty_db": recorded.uncertainties_db,
        "difference_db": own.levels_db - recorded.levels_db,
        "difference_uncertainty_db": np.hypot(own.uncertainties_db, recorded.uncertainties_db),
        "records_uncertainty_db": records_db,
    }
    if quantity is PRESSURE:
        # Only third octaves are A-weighted beside; a total names its own weighting.
        weighting_db = np.full(len(names), np.nan)
        weighting_db[:bands] = a_weighting_db
        columns["run_a_weighted_db"] = own.levels_db + weighting_db
        columns["recording_a_weighted_db"] = recorded.levels_db + weighting_db
    return pd.DataFrame(columns).dropna(subset="difference_db")


def _run_note(own: ComparedRun, pairs: Sequence[RecordPair]) -> str:
    """Say what the levels of a run are of."""
    first = pairs[0]
    if first.recording.quantity is PRESSURE:
        return f"run: {own.stated}; {first.run.name} of {first.run.seconds:.3g} s"
    quantity = first.recording.quantity
    places = ", ".join(pair.name for pair in pairs)
    return (
        f"run: levels of the {quantity.name} in dB re {quantity.reference_text}, of {places},"
        f" {len(first.run.samples) / RATE:.3g} s"
    )


# ---- tables in words


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
        if len(comparison.figures):
            of_pair = comparison.figures[comparison.figures["channel"] == pair.name]
            for heading, table in figure_words(of_pair).items():
                tables[pair.named(heading)] = table
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
        frame[column] = [uncertain(db, u) for db, u in pairs]
    return frame
