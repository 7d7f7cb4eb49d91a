"""Page of a recording beside a run: third octaves, all numbers, and both records to listen to."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from acoustics import level, plots
from acoustics.bands import BAND_NAMES, NOMINAL_HZ
from acoustics.wav import PEAK
from acoustics.wav import SAMPLE_RATE_HZ as RATE
from rolling import __version__
from rolling.figures.picture import finish, picture
from rolling.figures.settings import left_out_if_it_fails
from rolling.recordings.recorded import FAINTEST, PRESSURE
from rolling.recordings.recording_comparison import THIRD_OCTAVE, RecordingComparison, words
from rolling.report import maps, page_sounds, text
from rolling.report.templates import environment
from rolling.results import labels

HEARD_S = 20.0  # of each sound on the page


def page(run: Any, comparison: RecordingComparison) -> bytes:
    """Write a page with the third octaves, all numbers, and the records at equal loudness."""
    title = labels.title(run.scene.name, run.label)
    drawn = {}
    for number, pair in enumerate(comparison.pairs):
        with left_out_if_it_fails("of the third octaves"):
            draw = partial(_third_octaves, title, comparison, number)
            content = picture("third_octaves", draw).file("svg")
            drawn[pair.named("third octaves")] = maps.uri("image/svg+xml", content or b"")
    tables = {}
    for heading, table in words(comparison).items():
        tables[heading] = Markup(table.to_html(index=False, border=0))
    template = environment().get_template("recording.html")
    return template.render(
        version=__version__,
        seconds=HEARD_S,
        title=title,
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
            beginning = record.samples[: round(HEARD_S * RATE)]
            sounds[pair.named(name)] = beginning / level.a_weighted_rms(record.samples, RATE)
    loudest = max(np.abs(samples).max() for samples in sounds.values())
    gain = PEAK / max(FAINTEST, loudest)
    return {name: page_sounds.compressed(gain * samples) for name, samples in sounds.items()}


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
