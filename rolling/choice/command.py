"""The command `rolling choose`: which of some scenes is quieter, into a folder and on the terminal.

A folder of a choice has choice.html, choice.csv, choice.png, choice.json, a WAV of each candidate
with one gain for all, and below runs/ a folder for each candidate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from acoustics.bands import BAND_NAMES
from rolling.choice import page, table, words
from rolling.choice.choice import Choice
from rolling.choice.choosing import FORMAT
from rolling.choice.difference import Difference
from rolling.figures.picture import csv_bytes
from rolling.numbers.stored import summary_of
from rolling.results import listening
from rolling.results.provenance import provenance
from rolling.results.run_result import Run
from rolling.run import folder as folders
from rolling.run.choice_folder import CHOICE, PAGE, PICTURE, RUNS, TABLE
from rolling.terminal import files, progress
from rolling.terminal.streams import folded


def print_choice(choice: Choice) -> None:
    """Print the answer of a choice, its table and its files; the folder if quiet."""
    if progress.is_quiet():
        print(choice.folder)
        return
    for sentence in choice.sentences:
        print(folded(sentence))
    print()
    print(table.lines(choice))
    print()
    for note in words.notes(choice):
        print(folded(note))
    if progress.is_verbose():
        for line in words.parts(choice):
            print(folded(line))
    quietest = choice.contenders[0].candidate
    print(f"listen: {choice.folder / quietest.folder_name}.wav")
    print(f"page: {choice.folder / PAGE}")
    if choice.command:
        print(f"the same answer again: {choice.command}")


def print_advice(
    folder: Path, sentences: Sequence[str], lines: Sequence[str], paths: Sequence[Path]
) -> None:
    """Print the answer to what would help, or how coarse a value may be; the folder if quiet."""
    if progress.is_quiet():
        print(folder)
        return
    for sentence in sentences:
        print(folded(sentence))
    if lines:
        print()
        for line in lines:
            print(line)
    print()
    for path in paths:
        print(f"{path.suffix.removeprefix('.')}: {path}")


def write_choice(choice: Choice) -> None:
    """Write the files of a choice into its folder, last choice.json."""
    from rolling.choice.picture import picture

    with progress.step("reading the runs, making their sound"):
        runs = page.first_runs(choice)
    with progress.step("drawing the picture"):
        png = picture(choice).file("png")
    if png is not None:
        files.write_bytes(choice.folder / PICTURE, png)
    files.write_bytes(choice.folder / TABLE, csv_bytes(choice.table()))
    _write_sounds(choice, runs)
    with progress.step("writing the page"):
        files.write_bytes(choice.folder / PAGE, page.page(choice, runs, png))
    files.write_json(choice.folder / CHOICE, as_json(choice))


def _write_sounds(choice: Choice, runs: Mapping[str, Run]) -> None:
    """Write a WAV of each candidate, all with one gain."""
    gain = page.common_gain(runs)
    for contender in choice.contenders:
        content = listening.ListenSound(runs[contender.label]).wav(gain)
        files.write_bytes(choice.folder / f"{contender.candidate.folder_name}.wav", content)


def as_json(choice: Choice) -> dict[str, Any]:
    """Return all numbers of a choice for JSON."""
    candidates = []
    for contender in choice.contenders:
        candidates.append(
            {
                "label": contender.label,
                "folder": f"{RUNS}/{contender.candidate.folder_name}",
                "loss_factors": list(contender.candidate.loss_factors),
                "specimens": choice.numbers,
                "vibration_db": _known(contender.levels_db.tolist()),
                "released_power_db": [one.released_power_db for one in contender.heard],
            }
        )
    scene = choice.contenders[0].specimens[0].scene
    return {
        "format": FORMAT,
        "program": folders.this_program(),
        "sentences": choice.sentences,
        "candidates": candidates,
        "differences": [_difference_as_json(apart) for apart in choice.differences],
        "audible": [heard.text for heard in choice.audible],
        "pairs": choice.pairs,
        "left_out": [pair._asdict() for pair in choice.omitted],
        "command": choice.command,
        "within_db": choice.within_db,
        "limit": choice.limit,
        "ended_early": choice.is_early,
        "specimens": choice.noun,
        "doubts": summary_of(choice.doubts),
        "provenance": summary_of(provenance(scene, choice.contenders[0].label)),
    }


def _difference_as_json(apart: Difference) -> dict[str, Any]:
    """Return the numbers of a difference for JSON."""
    return {
        "pairs": apart.pairs,
        "louder_db": apart.db,
        "uncertainty_db": apart.uncertainty_db,
        "sureness": apart.sureness,
        "parts_db": dict(zip(apart.parts_db, _known([*apart.parts_db.values()]), strict=True)),
        "left_out_db": apart.left_out_db,
        "released_power_higher_db": apart.released_db,
        "released_power_higher_uncertainty_db": apart.released_uncertainty_db,
        "bands_db": dict(zip(BAND_NAMES, _known(apart.band_db.tolist()), strict=True)),
        "bands_uncertainty_db": dict(
            zip(BAND_NAMES, _known(apart.band_uncertainty_db.tolist()), strict=True)
        ),
    }


def _known(values: list[float]) -> list[float | None]:
    """Return numbers for JSON, None for those that are not finite."""
    return [value if math.isfinite(value) else None for value in values]
