"""Page of a recording beside a run: where they agree, charts, both records, and all numbers."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from acoustics import level, plots
from acoustics.bands import BAND_NAMES, MID_HZ, NOMINAL_HZ
from acoustics.plot_style import COLOURS, band_ticks
from acoustics.wav import PEAK
from acoustics.wav import SAMPLE_RATE_HZ as RATE
from rolling.figures.picture import finish, picture
from rolling.figures.settings import left_out_if_it_fails
from rolling.kinds.page_parts import Part
from rolling.numbers.conditions import Conditions
from rolling.numbers.quantity import uncertain
from rolling.recordings import agreement
from rolling.recordings.read_vibration import RISE, VELOCITY
from rolling.recordings.recorded import FAINTEST, PRESSURE
from rolling.recordings.recording_comparison import (
    MODULATION,
    THIRD_OCTAVE,
    RecordingComparison,
    words,
)
from rolling.report import page_sounds, text
from rolling.report.charts import Chart
from rolling.report.condition_parts import conditions_part, methods_part
from rolling.report.level_bars import Bars, Row, bars_around_zero
from rolling.report.machine_drawing import drawing_of
from rolling.report.page_of_parts import PageOfParts, exhibit
from rolling.results import labels

HEARD_S = 20.0  # of each sound on the page
_EQUAL_DB = 1e-9  # difference of totals that were made equal


def page(run: Any, comparison: RecordingComparison, conditions: Conditions, methods: str) -> bytes:
    """Write a page with the agreement, the differences, and the records at equal loudness.

    Parameters
    ----------
    run : run of any kind. The run.
    comparison : RecordingComparison. The run beside its recording.
    conditions, methods : Conditions, str. What the run rests on, and the paragraph for a report.
    """
    tables = []
    for heading, table in words(comparison).items():
        rows = [[str(cell) for cell in row] for row in table.itertuples(index=False)]
        tables.append((f"{heading[0].upper()}{heading[1:]}", [*table.columns], rows))
    first = {
        "sentences": agreement.sentences(comparison),
        "bars": [*_total_bars(comparison), *_figure_bars(comparison)],
        "sounds": _sounds(comparison),
        "seconds": HEARD_S,
        "is_sound": comparison.quantity is PRESSURE,
        "quantity": comparison.quantity.name,
    }
    made = PageOfParts(
        title=f"{text.titles([run])}, beside a recording",
        machine=drawing_of([run.scene], [run.numbers]),
        first=[conditions_part(conditions), Part("recording_first.html", first)],
        parts=[
            Part("charts.html", {"heading": "Levels", "charts": _charts(run, comparison)}),
            Part("recording_notes.html", {"notes": comparison.notes}),
            Part("recording_numbers.html", {"tables": tables}),
            methods_part(methods),
        ],
    )
    return made.written()


def _total_bars(comparison: RecordingComparison) -> list[Bars]:
    """Return the differences of total levels as bars; none where all were made equal."""
    rows = []
    table = comparison.table
    totals = table[~table["quantity"].isin([THIRD_OCTAVE, MODULATION])]
    for total in totals.itertuples():
        difference_db = float(total.difference_db)
        if abs(difference_db) < _EQUAL_DB:
            continue
        name = ", ".join(filter(None, (str(total.quantity), str(total.channel))))
        rows.append(_bar(name, difference_db, float(total.difference_uncertainty_db)))
    return [bars_around_zero("Total level, run less recording [dB]", rows)] if rows else []


def _figure_bars(comparison: RecordingComparison) -> list[Bars]:
    """Return velocities of bands, run less recording, and the rise by a fault of both, as bars."""
    table = comparison.figures
    if table.empty:
        return []
    bars = []
    velocities = [
        _bar(f"{row.item}, {row.channel}", float(row.difference), float(row.difference_uncertainty))
        for row in table[table["figure"] == VELOCITY].itertuples()
    ]
    if velocities:
        bars.append(bars_around_zero("Velocity in bands, run less recording [dB]", velocities))
    rises = []
    for row in table[table["figure"] == RISE].itertuples():
        of = f"{row.item}, {row.channel}"
        rises.append(_bar(f"run, {of}", float(row.run), float(row.run_uncertainty)))
        recorded_db = float(row.recording)
        rises.append(_bar(f"recording, {of}", recorded_db, float(row.recording_uncertainty)))
    if rises:
        bars.append(bars_around_zero("Rise of the velocity by the fault [dB]", rises))
    return bars


def _bar(name: str, value_db: float, spread_db: float) -> Row:
    """Return a number of decibels with its ± as a row of bars."""
    value, _, spread = uncertain(value_db, spread_db).partition(" ± ")
    return Row(
        name=name,
        value=value_db,
        low=value_db - spread_db,
        high=value_db + spread_db,
        words=f"{value} dB",
        spread=f"± {spread}" if spread else "",
    )


def _charts(run: Any, comparison: RecordingComparison) -> list[Chart]:
    """Return the difference and the third octaves of each pair of records."""
    title = labels.title(run.scene.name, run.label)
    charts = []
    for number in range(len(comparison.pairs)):
        for name, draw in (("difference", _difference), ("third_octaves", _third_octaves)):
            with left_out_if_it_fails(f"of the {name}"):
                drawn = picture(name, partial(draw, title, comparison, number))
                charts.append(exhibit(drawn))
    return charts


def _sounds(comparison: RecordingComparison) -> dict[str, str]:
    """Return the records of the pairs as sources of audio, all with the same A-weighted level."""
    sounds = {}
    for pair in comparison.pairs:
        for name, record in pair.records.items():
            beginning = record.samples[: round(HEARD_S * RATE)]
            sounds[pair.named(name)] = beginning / level.a_weighted_rms(record.samples, RATE)
    loudest = max(np.abs(samples).max() for samples in sounds.values())
    gain = PEAK / max(FAINTEST, loudest)
    return {name: page_sounds.compressed(gain * samples) for name, samples in sounds.items()}


def _difference(run_title: str, comparison: RecordingComparison, number: int, ax: Axes) -> Axes:
    """Plot the difference of the third octaves of a pair of records with its ±, by its number."""
    bands = agreement.band_differences(comparison, number)
    known = bands.difference_db
    spread = bands.uncertainty_db
    ax.fill_between(
        MID_HZ, known - spread, known + spread, color=COLOURS[0], alpha=0.2, linewidth=0
    )
    ax.plot(MID_HZ, known, color=COLOURS[0], marker="o", markersize=3.5, label="run less recording")
    ax.axhline(0.0, color="0.3", linewidth=0.8)
    ax.set_xscale("log")
    band_ticks(ax)
    ax.minorticks_off()
    ax.set(xlabel="frequency [Hz]", ylabel="run less recording [dB]")
    title = comparison.pairs[number].named(f"Difference of the third octaves: {run_title}")
    return finish(ax, title, ["the band is ± one standard uncertainty of the difference"])


def _third_octaves(run_title: str, comparison: RecordingComparison, number: int, ax: Axes) -> Axes:
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
    title = pair.named(f"Third octaves: {run_title}")
    of_recordings = [note for note in comparison.notes if note.startswith("recording: ")]
    return finish(ax, title, of_recordings[number : number + 1])
