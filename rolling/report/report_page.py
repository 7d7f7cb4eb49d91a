"""The report page of runs of any kind: an HTML file without network access.

All pages have title, answer, doubts, numbers, and how to make the runs again. A kind gives what
its page has beside these: a drawing, charts, an instrument to play with, their scripts and styles.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from acoustics import wav
from acoustics.numbers import rounded
from acoustics.texts import printable
from rolling.figures.catalogue import picture_of
from rolling.figures.quantity_figures import has_sweep, quantities, quantity_table
from rolling.figures.settings import left_out_if_it_fails
from rolling.kinds.figure_kind import FigureKind
from rolling.kinds.heard_sound import HeardSound
from rolling.kinds.page_parts import PageParts, Part
from rolling.kinds.registry import kind_of, kind_of_runs
from rolling.report import leading_numbers, number_table, page_sounds, text
from rolling.report.charts import Chart
from rolling.report.machine_drawing import drawing_of
from rolling.report.page_of_parts import ChartList, PageOfParts, exhibit
from rolling.report.sheets import sheets_fold
from rolling.results import verdict
from rolling.terminal import defaults


def page(runs: Sequence[Any], unsolved: Sequence[str] = (), notice: str = "") -> bytes:
    """Write the page of one run or several of one kind of scene.

    Parameters
    ----------
    runs : sequence of runs, at least one, in the order of the page. Their labels differ.
    unsolved : sequence of str. Labels of runs that are not solved. Default: none.
    notice : str. What a reader has to know first. Default: nothing.

    Returns
    -------
    bytes
        The HTML file.

    Raises
    ------
    ValueError : the runs are of several kinds.
    """
    kind = kind_of_runs(runs)
    own = kind.page_parts(runs)
    parts = [*own.charts, _doubts(runs, own)]
    if own.has_number_table:
        parts.append(Part("numbers.html"))
    parts += [Part("again.html", {"recipes": text.recipes(runs)}), *_declared(runs), *own.more]
    made = PageOfParts(
        title=text.titles(runs),
        noise=kind.noise,
        notice=notice,
        unsolved=[printable(label) for label in unsolved],
        machine=drawing_of([run.scene for run in runs], [run.numbers for run in runs]),
        has_drawing_within=own.has_drawing_within,
        first=_plain_first(runs) if own.first is None else own.first,
        beside=own.beside,
        parts=parts,
        charted=own.charted or ChartList(),
        styles=own.styles,
        script=own.script,
        engine=own.engine,
        shared={
            "runs": runs,
            "labels": [printable(run.label or run.scene.name) for run in runs],
            "columns": leading_numbers.shown_columns(runs),
            "meanings": leading_numbers.meanings(runs),
            "verdict_words": leading_numbers.verdict_words(runs),
            "table": number_table.number_table(runs),
            "players": players(runs) if own.has_plain_players else [],
            **own.shared,
        },
        data=own.data,
        cited=own.cited,
    )
    return made.written()


def _declared(runs: Sequence[Any]) -> list[Part]:
    """Return the fold with the sheets of runs; none where they have no sheets, or are too many."""
    if len(runs) > defaults.MAX_RUNS_ON_PAGE:
        return []
    by_label = {run.label or run.scene.name: kind_of(run.scene).sheets(run) for run in runs}
    return [sheets_fold(by_label)] if any(by_label.values()) else []


def _plain_first(runs: Sequence[Any]) -> list[Part]:
    """Return the first view of runs of a kind that gives none of its own."""
    kind = FigureKind(quantities, quantity_table, is_shown=has_sweep)
    values = {
        "sentences": kind_of_runs(runs).sentences(runs),
        "curve": quantity_chart(runs, kind),
    }
    return [Part("plain_first.html", values)]


def quantity_chart(runs: Sequence[Any], kind: FigureKind) -> Chart | None:
    """Return the chart of the numbers that lead over the swept value; None where none is swept."""
    if not kind.is_shown(runs):
        return None
    with left_out_if_it_fails("of the numbers over the swept value"):
        return exhibit(picture_of("quantities", kind, runs))
    return None


def _doubts(runs: Sequence[Any], own: PageParts) -> Part:
    """Return the section on what to doubt."""
    solved = [(run.label, run.numbers) for run in runs]
    values = {
        "doubts": leading_numbers.doubts(runs),
        "headline": verdict.headline(solved),
        "notes": [note.text for note in verdict.notes(solved)],
        "doubted": own.doubted,
    }
    return Part("doubts.html", values)


# ---- sounds


class PlainPlayer(NamedTuple):
    """A player of a sound of a run: its place among the runs, words and sound in a data URI."""

    run: int
    words: str
    src: str | None


def page_gains(runs: Sequence[Any]) -> dict[str, float]:
    """Return the gain of the sounds of each group [full scale per unit], so that none clips.

    Runs of a page share it, so that a louder run sounds louder.
    """
    gains: dict[str, float] = {}
    for run in runs:
        for sound in kind_of(run.scene).sounds(run):
            gain = wav.listening_gain(sound.samples)
            gains[sound.group] = min(gain, gains.get(sound.group, gain))
    return gains


def players(runs: Sequence[Any]) -> list[PlainPlayer]:
    """Return players of the sounds of runs, with one gain for each group of sounds."""
    gains = page_gains(runs)
    shown = []
    for number, run in enumerate(runs):
        for sound in kind_of(run.scene).sounds(run):
            shown.append(_player(number, sound, gains[sound.group]))
    return shown


def _player(number: int, sound: HeardSound, gain: float) -> PlainPlayer:
    """Return the player of a sound at a gain; a silent one has no source."""
    seconds = len(sound.samples) / wav.SAMPLE_RATE_HZ
    words = f"{sound.words}, {seconds:.3g} s; full scale {rounded(1 / gain, 3)} {sound.unit}"
    src = page_sounds.compressed(gain * sound.samples) if np.any(sound.samples) else None
    return PlainPlayer(run=number, words=words, src=src)
