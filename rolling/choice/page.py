"""Page of a choice: its sentences, a sound of each candidate, the picture and all numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from markupsafe import Markup

from acoustics.texts import printable
from rolling import __version__
from rolling.choice import table, words
from rolling.choice.choice import Choice
from rolling.report import maps, records, text
from rolling.report.templates import environment
from rolling.results import listening
from rolling.results.notes import UNVALIDATED
from rolling.results.run_result import Run, read_run

STYLE = """
.wide { width: 100%; height: auto; background: white; }
.scroll { overflow-x: auto; }
"""


def first_runs(choice: Choice) -> dict[str, Run]:
    """Return the run of the first specimen of each candidate by its label, as it is heard.

    A short track goes on with a random continuation, as on the page of a run, and does not repeat.
    """
    runs = {}
    for contender in choice.contenders:
        run = read_run(contender.specimens[0], contender.label)
        ends = run.sound.once  # a fall is heard once, and a longer record as it is
        if not ends and run.sound.duration < listening.MIN_S:
            longer = run.scene.with_({"sound.listen_s": listening.MIN_S})
            run = replace(run, scene=longer)
        runs[contender.label] = run
    return runs


def common_gain(runs: Mapping[str, Run]) -> float | None:
    """Return the gain [full scale per Pa] at which all records sound and none clips."""
    own = [listening.own_gain(listening.record_for_ear(run)) for run in runs.values()]
    gains = [one.full_scale_per_pa for one in own if one.full_scale_per_pa > 0]
    return min(gains, default=None)


def page(choice: Choice, runs: Mapping[str, Run], picture: bytes | None) -> bytes:
    """Write the page of a choice.

    Parameters
    ----------
    choice : Choice. The answer.
    runs : mapping. Run of the first specimen of each candidate by its label.
    picture : bytes or None. Its picture, a PNG file; None if none could be drawn.
    """
    gain = common_gain(runs)
    heads, *rows = table.cells(choice)
    template = environment().get_template("choice.html")
    return template.render(
        version=__version__,
        title="Which one is quieter?",
        sentences=choice.sentences,
        tried=choice.tried,
        numbers=choice.numbers,
        sounds=[_sound(label, run, gain) for label, run in runs.items()],
        picture=None if picture is None else maps.uri("image/png", picture),
        heads=heads,
        rows=rows,
        notes=[*words.notes(choice), *_again(choice), UNVALIDATED],
        css=Markup(text.asset("report.css") + text.asset("gallery.css") + STYLE),
    ).encode()


def _again(choice: Choice) -> list[str]:
    """Name the command that gives the same answer again; a choice in Python has none."""
    return [f"The same answer again: {choice.command}"] if choice.command else []


def _sound(label: str, run: Run, gain: float | None) -> dict[str, Any]:
    """Return label, level and sound of a run at a gain [full scale per Pa]."""
    record = listening.record_for_ear(run)
    src = None
    if gain is not None and record.pressure.any():
        src = records.compressed(gain * record.pressure)
    return {
        "label": printable(label),
        "level": str(run.vibration),
        "src": src,
    }
