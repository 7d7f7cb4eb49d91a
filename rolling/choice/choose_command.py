"""The command `rolling choose`: which of some scenes is quieter, into a folder and on the terminal.

A folder of a choice has choice.html, choice.csv, choice.png, choice.json, a WAV of each candidate
with one gain for all, and below runs/ a folder for each candidate.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from acoustics.bands import BAND_NAMES
from rolling.choice import choice_page, choice_sentences, choice_table
from rolling.choice.choice import Choice
from rolling.choice.choice_numbers import Contender
from rolling.choice.choosing import FORMAT
from rolling.choice.difference import Difference
from rolling.kinds.stated_conditions import with_conditions
from rolling.numbers.conditions import Conditions
from rolling.numbers.number_files import summary_of
from rolling.results.runs_table import csv_bytes
from rolling.run import folder as folders
from rolling.run.choice_folder import CHOICE, PAGE, PICTURE, RUNS, TABLE
from rolling.terminal import progress, whole_files
from rolling.terminal.streams import folded


def print_choice(choice: Choice) -> None:
    """Print the answer of a choice, its table and its files; the folder if quiet."""
    if progress.is_quiet():
        print(choice.folder)
        return
    for line in [*choice.conditions.lines, *choice.sentences]:
        print(folded(line))
    print()
    print(choice_table.lines(choice))
    print()
    for note in choice_sentences.notes(choice):
        print(folded(note))
    if progress.is_verbose():
        for line in choice_sentences.parts(choice):
            print(folded(line))
    quietest = choice.contenders[0].candidate
    print(f"listen: {choice.folder / quietest.folder_name}.wav")
    print(f"page: {choice.folder / PAGE}")
    if choice.command:
        print(f"the same answer again: {choice.command}")


def print_advice(
    folder: Path,
    conditions: Conditions,
    sentences: Sequence[str],
    lines: Sequence[str],
    paths: Sequence[Path],
) -> None:
    """Print the answer to what would help, or how coarse a value may be; the folder if quiet."""
    if progress.is_quiet():
        print(folder)
        return
    for sentence in [*conditions.lines, *sentences]:
        print(folded(sentence))
    if lines:
        print()
        for line in lines:
            print(line)
    print()
    for path in paths:
        print(f"{path.suffix.removeprefix('.')}: {path}")


def write_answer(choice: Choice) -> None:
    """Write numbers and sentences of a choice that goes on, which outlast an interruption."""
    whole_files.write_bytes(choice.folder / TABLE, _table_file(choice))
    whole_files.write_json(choice.folder / CHOICE, as_json(choice))


def _table_file(choice: Choice) -> bytes:
    """Return the table of a choice as a file, with the conditions of each candidate."""
    table = choice.table()
    return csv_bytes(with_conditions(table, choice.conditions, table["candidate"]))


def write_choice(choice: Choice) -> None:
    """Write the files of a choice into its folder, last choice.json."""
    from rolling.choice.choice_picture import picture

    with progress.step("making the sound of each candidate"):
        sounds = choice_page.candidate_sounds(choice)
    with progress.step("drawing the picture"):
        png = picture(choice).file("png")
    if png is not None:
        whole_files.write_bytes(choice.folder / PICTURE, png)
    whole_files.write_bytes(choice.folder / TABLE, _table_file(choice))
    for contender, sound in zip(choice.contenders, sounds, strict=True):
        path = choice.folder / f"{contender.candidate.folder_name}.wav"
        whole_files.write_bytes(path, sound.wav)
    with progress.step("writing the page"):
        whole_files.write_bytes(choice.folder / PAGE, choice_page.page(choice, sounds))
    whole_files.write_json(choice.folder / CHOICE, as_json(choice))


def as_json(choice: Choice) -> dict[str, Any]:
    """Return all numbers of a choice for JSON."""
    candidates = []
    for contender in choice.contenders:
        candidates.append(
            {
                "label": contender.label,
                "folder": f"{RUNS}/{contender.candidate.folder_name}",
                "specimens": choice.numbers,
                **_heard_as_json(choice, contender),
                **choice.audition.facts(contender),
            }
        )
    differences = []
    for contender, of_one in zip(choice.contenders[1:], choice.by_quantity, strict=True):
        for difference in of_one.values():
            differences.append({"label": contender.label, **_difference_as_json(difference)})
    first = choice.contenders[0]
    provenance = choice.audition.provenance(first.specimens[0].scene, first.label)
    return {
        "format": FORMAT,
        "program": folders.this_program(),
        "conditions": choice.conditions.as_json(),
        "sentences": choice.sentences,
        "methods": choice.methods,
        "candidates": candidates,
        "differences": differences,
        "audible": [difference.text for difference in choice.audible],
        "what_would_help": _advice_as_json(choice),
        "pairs": choice.pairs,
        "left_out": [pair._asdict() for pair in choice.omitted],
        "command": choice.command,
        "within_db": choice.within_db,
        "limit": choice.limit,
        "ended_early": choice.is_early,
        "specimens": choice.noun,
        "doubts": summary_of(choice.doubts),
        "provenance": summary_of(provenance),
    }


def _heard_as_json(choice: Choice, contender: Contender) -> dict[str, list[float | None]]:
    """Return what is heard of each specimen of a candidate, by the column of its quantity."""
    by_column = {}
    for quantity in choice.quantities:
        values = contender.rms_in(quantity.name)
        if quantity.is_level:
            values = contender.levels_in(quantity.name)
        name = quantity.column if len(choice.quantities) == 1 else quantity.name
        by_column[name] = _known(values.tolist())
    return by_column


def _difference_as_json(difference: Difference) -> dict[str, Any]:
    """Return the numbers of a difference for JSON."""
    content: dict[str, Any] = {
        "quantity": difference.quantity,
        "pairs": difference.pairs,
        "louder_db": difference.db,
        "uncertainty_db": difference.uncertainty_db,
        "sureness": difference.sureness,
        "parts_db": dict(
            zip(difference.parts_db, _known([*difference.parts_db.values()]), strict=True)
        ),
        "left_out_db": difference.left_out_db,
    }
    if difference.independent is not None:
        content["independent_places"] = difference.independent
        content["further_scan_uncertainty_db"] = difference.further_scan_db
    if difference.released_db is not None:
        content["released_power_higher_db"] = difference.released_db
        content["released_power_higher_uncertainty_db"] = difference.released_uncertainty_db
    if difference.band_db is not None and difference.band_uncertainty_db is not None:
        content["bands_db"] = dict(
            zip(BAND_NAMES, _known(difference.band_db.tolist()), strict=True)
        )
        content["bands_uncertainty_db"] = dict(
            zip(BAND_NAMES, _known(difference.band_uncertainty_db.tolist()), strict=True)
        )
    return content


def _advice_as_json(choice: Choice) -> dict[str, Any] | None:
    """Return the values of the drawing that matter most for the loudest candidate, for JSON."""
    if choice.advice is None:
        return None
    changes = [change._asdict() for change in choice.advice.changes]
    return {"label": choice.advice.label, "changes": changes}


def _known(values: list[float]) -> list[float | None]:
    """Return numbers for JSON, None for those that are not finite."""
    return [value if math.isfinite(value) else None for value in values]
