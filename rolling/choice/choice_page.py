"""Page of a choice: its sentences, a sound of each candidate, the picture and all numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from markupsafe import Markup

from acoustics import wav
from acoustics.arrays import Array
from acoustics.texts import printable
from rolling import __version__
from rolling.choice import choice_sentences, choice_table
from rolling.choice.choice import Choice
from rolling.report import maps, page_sounds, text
from rolling.report.templates import environment
from rolling.results.notes import UNVALIDATED

STYLE = """
.wide { width: 100%; height: auto; background: white; }
.scroll { overflow-x: auto; }
"""


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


def page(choice: Choice, sounds: Sequence[CandidateSound], picture: bytes | None) -> bytes:
    """Write the page of a choice.

    Parameters
    ----------
    choice : Choice. The answer.
    sounds : sequence of CandidateSound. Sound of the first specimen of each candidate.
    picture : bytes or None. Its picture, a PNG file; None if none could be drawn.
    """
    heads, *rows = choice_table.cells(choice)
    template = environment().get_template("choice.html")
    return template.render(
        version=__version__,
        title="Which one is quieter?",
        sentences=choice.sentences,
        tried=choice.tried,
        numbers=choice.numbers,
        sounds=[_shown(sound) for sound in sounds],
        picture=None if picture is None else maps.uri("image/png", picture),
        has_bands=choice.contenders[0].third_octaves is not None,
        heads=heads,
        rows=rows,
        notes=[*choice_sentences.notes(choice), *_again(choice), UNVALIDATED],
        css=Markup(text.asset("report.css") + text.asset("gallery.css") + STYLE),
    ).encode()


def _again(choice: Choice) -> list[str]:
    """Name the command that gives the same answer again; a choice in Python has none."""
    return [f"The same answer again: {choice.command}"] if choice.command else []


def _shown(sound: CandidateSound) -> dict[str, Any]:
    """Return what the page shows of a sound."""
    return {
        "label": printable(sound.label),
        "text": sound.text,
        "src": None if sound.samples is None else page_sounds.compressed(sound.samples),
    }
