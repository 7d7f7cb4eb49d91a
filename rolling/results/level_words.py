"""Levels of a run in words: their names, values and uncertainties."""

from __future__ import annotations

from dataclasses import fields
from typing import NamedTuple

from rolling.numbers.ball_numbers import RunNumbers, SourceLevels
from rolling.numbers.fields import NumberField, said_of
from rolling.numbers.quantity import uncertain
from rolling.results.answer import of_solved_part
from rolling.results.quantities import LAE, heard_levels, measure

NOTHING = "-"  # for a number that does not exist


class LevelText(NamedTuple):
    """A level of the sound that plays: what is said of it, and its value with its uncertainty."""

    said: NumberField
    text: str


def level_texts(numbers: RunNumbers) -> list[LevelText]:
    """Return the levels of the sound that plays, or of the whole of what ends, that say something.

    A level of a silent record is `silent`, and one that the record is too short for is `-`.
    """
    levels = heard_levels(numbers)
    skipped = "event" if not numbers.record.single_event else "lasting"
    texts = []
    for one in fields(SourceLevels):
        said = said_of(one)
        if said is None or said.is_group or said.holds_for == skipped:
            continue
        value = getattr(levels, one.name)
        spread = None if levels.spreads is None else getattr(levels.spreads, one.name)
        if value is not None:
            text = uncertain(value, spread)
        else:
            text = "silent" if levels.laeq_db is None else NOTHING
        texts.append(LevelText(said, text))
    return texts


def level_name(numbers: RunNumbers) -> str:
    """Name the level of a run: LAeq of the vibration, or of the released power with its q.

    A single event has the sound exposure level LAE.
    """
    of = measure(numbers)
    reference = " (re 1 s)" if of == LAE else ""
    if numbers.record.source == "vibration":
        place = "at the listener" if numbers.levels.listeners else "on the axis"
        return f"{of} {place}{reference}"
    if numbers.record.q is None:
        return f"{of} under the fixed gain{reference}"
    q = f"q = {numbers.record.q:g}"
    if of == LAE:
        return f"LAE of the released power (re 1 s, {q})"
    return f"level of the released power ({q})"


def level_rows(numbers: RunNumbers) -> dict[str, str]:
    """Return the two numbers of a run in words, the verdicts on them, and the other levels."""
    rows = {}
    for name, quantity in (
        ("vibration", numbers.vibration),
        ("released power", numbers.released_power),
    ):
        rows[name] = str(quantity)
        if quantity.judged is not None:
            rows[f"verdict on the {name}"] = quantity.judged.sentence
    source = "vibration" if numbers.record.source == "vibration" else "released power"
    for level in level_texts(numbers)[1:]:  # the first one is a number above
        if level.text != NOTHING:
            unit = level.said.shown_unit or level.said.unit
            rows[f"{level.said.word} of the {source}"] = f"{level.text} {unit}"
    part = of_solved_part([numbers])
    if part:
        rows["record"] = part
    return rows
