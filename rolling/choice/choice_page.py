"""Page of a choice: its answer, a sound of each candidate, charts and all numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from acoustics import wav
from acoustics.arrays import Array
from acoustics.texts import printable
from rolling.choice import choice_picture, choice_sentences, choice_table
from rolling.choice.choice import Choice
from rolling.choice.difference import Difference
from rolling.figures.settings import left_out_if_it_fails
from rolling.kinds.page_parts import Part
from rolling.report import page_sounds
from rolling.report.charts import Chart
from rolling.report.condition_parts import conditions_part, methods_part
from rolling.report.level_bars import Bars, Row, bars_around_zero
from rolling.report.machine_drawing import drawing_of
from rolling.report.page_of_parts import PageOfParts, exhibit
from rolling.results.notes import UNVALIDATED

MOST_NAMED = 3  # candidates that a title names


class CandidateSound(NamedTuple):
    """Sound of the first specimen of a candidate, at the gain that all candidates share.

    label, text : str. What it is called, and its numbers in words.
    samples : array or None. Samples of full scale 1; None where nothing sounds.
    wav : bytes. The content of its file.
    """

    label: str
    text: str
    samples: Array | None
    wav: bytes


def candidate_sounds(choice: Choice) -> list[CandidateSound]:
    """Return the sounds of all candidates, at the largest gain at which none clips."""
    firsts = [choice.audition.first_sound(choice, contender) for contender in choice.contenders]
    own = [wav.listening_gain(first.sound.samples) for first in firsts if first.sound.samples.any()]
    gain = min(own, default=1.0)
    sounds = []
    for contender, (sound, text_of_sound) in zip(choice.contenders, firsts, strict=True):
        sounds.append(
            CandidateSound(
                label=contender.label,
                text=text_of_sound,
                samples=gain * sound.samples if sound.samples.any() else None,
                wav=sound.wav(gain),
            )
        )
    return sounds


def page(choice: Choice, sounds: Sequence[CandidateSound]) -> bytes:
    """Write the page of a choice.

    Parameters
    ----------
    choice : Choice. The answer.
    sounds : sequence of CandidateSound. Sound of the first specimen of each candidate.
    """
    first, *others = choice_sentences.verdicts(choice)
    explained = choice_sentences.explanations(choice)
    further = [*others, *explained, *choice_sentences.advice(choice)]
    heads, *rows = [[*map(_on_page, cells)] for cells in choice_table.cells(choice)]
    counted = {"tried": choice.tried, "numbers": choice.numbers}
    own_sounds = [_shown(sound) for sound in sounds]
    again = [f"The same answer again: {choice.command}"] if choice.command else []
    parts = [
        Part("charts.html", {"heading": _heading(choice), "charts": _charts(choice)}),
        Part("sentences.html", {"sentences": further}),
        Part(
            "doubts.html",
            {
                "doubts": [doubt.line for doubt in choice_sentences.limiting_doubts(choice)],
                "headline": "",
                "notes": [*choice_sentences.notes(choice), UNVALIDATED],
                "doubted": [],
            },
        ),
        Part(
            "choice_numbers.html",
            {"heads": heads, "rows": rows, "sounds": own_sounds, "again": again, **counted},
        ),
        methods_part(choice.methods),
    ]
    made = PageOfParts(
        title=_title(choice),
        machine=drawing_of([contender.candidate.scene for contender in choice.contenders]),
        first=[
            conditions_part(choice.conditions),
            Part(
                "choice_first.html",
                {"sentence": first, "bars": _bars(choice), "sounds": own_sounds},
            ),
        ],
        parts=parts,
    )
    return made.written()


def _title(choice: Choice) -> str:
    """Ask which candidate is quieter, by their names where these are few."""
    names = [printable(contender.label) for contender in choice.contenders]
    if len(names) > MOST_NAMED:
        return f"Which of {len(names)} is quieter?"
    return f"Which is quieter: {', '.join(names[:-1])} or {names[-1]}?"


def _heading(choice: Choice) -> str:
    """Return the heading of the charts."""
    if choice.contenders[0].third_octaves is None:
        return "All specimens"
    return "At which frequencies"


def _charts(choice: Choice) -> list[Chart]:
    """Return the difference and the levels by third octave, or all specimens as points."""
    charts = []
    for drawn in choice_picture.pictures(choice):
        with left_out_if_it_fails(drawn.name):
            charts.append(exhibit(drawn))
    return charts


def _bars(choice: Choice) -> list[Bars]:
    """Return how much more is heard of each candidate than of the quietest, as bars.

    Two candidates have a bar for each quantity, several have bars of their own in each.
    """
    quietest = printable(choice.contenders[0].label)
    others = choice.contenders[1:]
    by_quantity = {
        quantity.words: [of_one[quantity.name] for of_one in choice.by_quantity]
        for quantity in choice.quantities
    }
    unit = choice.leading.decibels
    if len(others) == 1 and len(by_quantity) > 1:
        rows = [_row(words, difference) for words, (difference,) in by_quantity.items()]
        label = f"{printable(others[0].label)} over {quietest} [{unit}]"
        return [bars_around_zero(label, rows)]
    drawn = []
    for words, differences in by_quantity.items():
        rows = [
            _row(printable(contender.label), difference)
            for contender, difference in zip(others, differences, strict=True)
        ]
        label = f"Over {quietest}, {words} [{unit}]"
        if len(by_quantity) == 1:
            label = f"Louder than {quietest} [{unit}]"
        drawn.append(bars_around_zero(label, rows))
    return drawn


def _row(label: str, difference: Difference) -> Row:
    """Return a difference with its ± as a row of bars."""
    value, _, spread = choice_sentences.number(difference).partition(" ± ")
    low = high = None
    if difference.db is not None and difference.uncertainty_db is not None:
        low = difference.db - difference.uncertainty_db
        high = difference.db + difference.uncertainty_db
    return Row(
        name=label,
        value=difference.db,
        low=low,
        high=high,
        words=f"{value} dB" if difference.db is not None else "no difference in decibels",
        spread=f"± {spread}" if spread else "",
    )


def _shown(sound: CandidateSound) -> dict[str, Any]:
    """Return what the page shows of a sound."""
    return {
        "label": printable(sound.label),
        "text": _on_page(sound.text),
        "src": None if sound.samples is None else page_sounds.compressed(sound.samples),
    }


def _on_page(text: str) -> str:
    """Return a text with the sign of micrometres."""
    return text.replace("um/s", "µm/s")
