"""Texts and tables of the page as plain text, from the summaries and records of runs."""

import math
import tomllib
from collections.abc import Mapping, Sequence
from importlib.resources import files
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple

import numpy as np

from acoustics.numbers import bracketed, rounded
from acoustics.texts import printable
from rolling.dynamics.smooth_contact import semi_axes
from rolling.results import answer, description, verdict
from rolling.results.answer import level_beside, level_key, listener_level
from rolling.results.run_result import Run
from rolling.results.runs_table import (
    LEVELS,
    MEANS,
    level_name,
    level_text,
    shown_levels,
)
from rolling.scene import file
from rolling.sound.wavelengths import mean_speed, weighted_lines

INSTALL = "python3 -m venv .venv && .venv/bin/pip install -c constraints.txt -e ."
NOTHING = "-"  # for a number that does not exist
Fact = tuple[str, list[tuple[str, str]]]  # quantity; labels of runs (empty: all runs) and value


def asset(name: str) -> str:
    """Read a file of the page, which is the program's own text."""
    return files("rolling.report").joinpath("assets", name).read_text(encoding="utf-8")


class TableRow(NamedTuple):
    """A row of the table of numbers, which levels.toml explains."""

    head: str
    unit: str = ""
    factor: float = 1.0
    form: str = ".1f"


QUANTITIES = {key: TableRow(**row) for key, row in tomllib.loads(asset("levels.toml")).items()}


# ---- levels

# Levels that depend on the length of the record, which say nothing of a single event.
OF_LENGTH = {
    "laeq_db",
    "level_db",
    "vibration_laeq_db",
    "release_laeq_db",
    "plate_power_level_db",
    "ball_power_level_db",
}


def titles(runs: Sequence[Run]) -> str:
    """Join the titles of the scenes, or their names where they have none, in printable letters."""
    return printable(", ".join(dict.fromkeys(run.scene.title or run.scene.name for run in runs)))


class Number(NamedTuple):
    """One of the two numbers of a run with its verdict; None where its errors are not known."""

    answer: answer.Answer
    verdict: verdict.Verdict | None


class JudgedRun(NamedTuple):
    """A run with its two numbers, in the order in which they are read."""

    label: str
    vibration: Number
    released: Number


def judged(run: Run) -> JudgedRun:
    """Return a run with its two numbers and their verdicts."""
    summary = run.summary
    return JudgedRun(
        label=run.label,
        vibration=Number(answer.vibration(summary), verdict.of_vibration(summary)),
        released=Number(answer.released_power(summary), verdict.of_released_power(summary)),
    )


WORDS = {  # of verdicts
    "trust": "no error above 1 dB is known",
    "indicative": "good for comparing, because its error is up to 3 dB or of unknown size",
    "do not quote": "its error exceeds 3 dB",
}


def verdict_words(runs: Sequence[JudgedRun]) -> list[tuple[str, str]]:
    """Explain the words of the verdicts on the numbers of runs."""
    numbers = [number for run in runs for number in (run.vibration, run.released)]
    verdicts = [number.verdict for number in numbers if number.verdict is not None]
    words = {found.word for found in verdicts}
    explained = [(word, meaning) for word, meaning in WORDS.items() if word in words]
    if any(">" in found.short for found in verdicts):
        explained.append((">", "a part of the error has this size, and the rest is not known"))
    return explained


def doubts(runs: Sequence[Run]) -> list[str]:
    """Return the doubts about the numbers of runs as sentences, the worst of each number first."""
    all_judged = [judged(run) for run in runs]
    numbers = {
        "Vibration": [(run.label, run.vibration.verdict) for run in all_judged],
        "Released power": [(run.label, run.released.verdict) for run in all_judged],
    }
    sentences = []
    told = set[str]()
    for name, verdicts in numbers.items():
        by_reason: dict[str, dict[str, verdict.Verdict]] = {}
        for label, found in verdicts:
            if found is not None and found.word != "trust":
                by_reason.setdefault(found.worst.text, {})[label] = found
                told.add(found.worst.key)
        for by_label in by_reason.values():
            largest = max(by_label.values(), key=_size)
            of_some = "" if len(by_label) == len(runs) else f" of {description.listed(by_label)}"
            sentences.append(f"{name}{of_some} is {_ended(largest.sentence)}")
    for doubt in verdict.warnings([(run.label, run.summary) for run in runs]):
        if doubt.key not in told:
            sentences.append(_ended(_capitalized(doubt.text)))
    return sentences


def _size(found: verdict.Verdict) -> float:
    """Return the decibels of a verdict, by which verdicts of one reason are sorted."""
    return abs(found.worst.decibels or found.known_db or 0.0)


def _ended(sentence: str) -> str:
    """End a sentence with a full stop."""
    return sentence if sentence.endswith(".") else f"{sentence}."


def meanings(runs: Sequence[JudgedRun]) -> list[tuple[str, str]]:
    """Explain the numbers that runs have: name and the rest of the sentence, each meaning once."""
    explained = []
    for meaning in _unique_meanings([run.vibration.answer for run in runs]):
        explained.append(("Vibration", f": {meaning[0].lower()}{meaning[1:]}"))
    for meaning in _unique_meanings([run.released.answer for run in runs]):
        explained.append(("Released power", meaning.removeprefix("Released power")))
    return explained


def _unique_meanings(answers: Sequence[answer.Answer]) -> list[str]:
    """Return the different meanings of the levels that exist."""
    return [*dict.fromkeys(each.meaning for each in answers if each.level_db is not None)]


def units(runs: Sequence[Run]) -> str:
    """Say of what and where the levels of runs are."""
    are_events = [answer.vibration(run.summary).quantity == "LAE" for run in runs]
    mean = "Levels are A-weighted means over the record (LAeq)"
    if any(are_events):
        mean = "Levels are A-weighted"
    places = [*dict.fromkeys(run.scene.listener_place for run in runs)]
    at = f" at {places[0]}" if len(places) == 1 else ""
    return f"{mean}{at}, in dB re 20 µPa."


def heard(run: Run, is_alone: bool) -> str:
    """Say what one hears of a run, and what is special about it unless the page has it alone."""
    if main_level(run) is None:
        return f"{_capitalized(run.label)} is silent: {silence(run)}."
    if run.sound.source == "vibration":
        sound = "the vibration of ball and plate"
    else:
        sound = "the released power, as if all of it became sound"
    sentence = f"You hear {sound}."
    if not is_alone:
        sentence = f"{sentence} {description.special(run)}".rstrip()
    return sentence


def common_gain(runs: Sequence[Run]) -> str:
    """Say what the gain that runs share does to the ear; vibration and release have one each."""
    sources = {run.sound.source for run in runs}
    if sources == {"vibration"}:
        return "All runs play with one gain, so a louder run sounds louder."
    if sources == {"release"}:
        return (
            "All runs play with one gain, so a run that releases more power sounds louder here. "
            "Which ball is louder, only the vibration says."
        )
    return (
        "Runs that play their vibration share one gain, so the louder one sounds louder. Runs that "
        "play their released power share another; which of these balls is louder, only the "
        "vibration says."
    )


def main_level(run: Run) -> float | None:
    """Return the level of a run that is read first [dB]; None for silence."""
    if run.sound.levels.laeq_db is None:
        return None
    return answer.leading(run.summary, level_key(run.summary))


def lead_by_whole(runs: Sequence[Run]) -> bool:
    """Tell whether a run has the level of a long record that ends; those of 0.8.0 have none."""
    return any(answer.heard_whole(run.summary) for run in runs)


def _level_or_zero(run: Run) -> float:
    """Return the level of a run that is read first [dB], by which runs are sorted."""
    return main_level(run) or 0.0


def silence(run: Run) -> str:
    """State the reason of the silence of a run."""
    if run.summary.get("flight_share") == 1 and not run.summary["impacts"]:
        return f"the record of {rounded(run.sound.duration)} s ends before the ball hits the plate"
    return f"the {run.sound.source} does not fluctuate within hearing"


def level_head(runs: Sequence[Run]) -> str:
    """Name the level of runs: of the vibration, of the released power, or of both."""
    return " or ".join(dict.fromkeys(level_name(run.summary) for run in runs))


def levels(runs: Sequence[Run]) -> tuple[list[str], list[tuple[str, list[str]]]]:
    """Return the labels of runs, and rows (quantity, cells) of the table of all their numbers.

    A level without sound is `silent`, and one that was not computed or says nothing `-`. A row is
    shown if a run has its number. LAE and LAFmax of single events come first.
    """
    are_events = [bool(run.summary.get("single_event")) for run in runs]
    rows = []
    for key, quantity in _shown_quantities(runs, are_events).items():
        head = quantity.head
        if key in ("lae_db", "laeq_db"):
            head = level_head([run for run in runs if level_key(run.summary) == key])
        elif all(are_events) and key in MEANS:
            head = f"LAE (re 1 s), {quantity.head}"
        if quantity.unit:
            head = f"{head} [{quantity.unit}]"
        cells = [_cell(run, key, quantity, all(are_events)) for run in runs]
        if any(cell != NOTHING for cell in cells):
            rows.append((head, cells))
    return [run.label for run in runs], rows


def _shown_quantities(runs: Sequence[Run], are_events: Sequence[bool]) -> dict[str, TableRow]:
    """Return the quantities that say something of the runs, those of single events first."""
    keys = [*QUANTITIES]
    if any(are_events):
        keys = [*dict.fromkeys(["lae_db", "laf_max_db", *QUANTITIES])]
    else:
        keys.remove("lae_db")
    if all(are_events):
        keys = [key for key in keys if key not in OF_LENGTH]
    return {key: QUANTITIES[key] for key in keys if not _is_repeated(runs, key)}


def _is_repeated(runs: Sequence[Run], key: str) -> bool:
    """Tell whether a level of a source is LAeq itself, because all runs are of that source."""
    if key not in ("vibration_laeq_db", "release_laeq_db"):
        return False
    return all(run.summary.get(key) == run.summary.get("laeq_db") for run in runs)


def _cell(run: Run, key: str, quantity: TableRow, only_events: bool) -> str:
    """Write a number of a run for a table, which may have runs of events only."""
    if key in LEVELS:
        return level_text(run.summary, key) if key in shown_levels(run.summary) else NOTHING
    is_event = bool(run.summary.get("single_event"))
    if (is_event or answer.heard_whole(run.summary)) and key in OF_LENGTH:
        return NOTHING
    if is_event and key in MEANS and not only_events:
        return NOTHING
    value = level_beside(run.summary, key) if key in MEANS else run.summary.get(key)
    if value is None:
        return NOTHING
    number = value * quantity.factor
    return f"{number:{quantity.form}}" if quantity.form else rounded(number, 4)


class ListenerLevels(NamedTuple):
    """Levels of a run at one of several listeners, as text."""

    head: str
    place: str
    a_weighted: str
    unweighted: str


def listeners(runs: Sequence[Run]) -> list[ListenerLevels]:
    """Return the levels at the listeners of runs that have several."""
    rows = []
    for run in runs:
        own = run.summary.get("listeners") or []
        if len(own) < 2:
            continue
        for listener in own:
            place = f"{bracketed(listener['at_mm'])} mm"
            if len(runs) > 1:
                place = f"{run.label}: {place}"
            row = ListenerLevels(
                head="LAE (re 1 s)" if run.summary.get("single_event") else "LAeq",
                place=place,
                a_weighted=_level_or_silent(listener_level(run.summary, listener)),
                unweighted=_level_or_silent(listener["level_db"]),
            )
            rows.append(row)
    return rows


def _level_or_silent(level_db: float | None) -> str:
    """Write a level [dB], or that there is no sound."""
    return "silent" if level_db is None else f"{level_db:.1f}"


# ---- facts


def facts(runs: Sequence[Run], records: Sequence[Mapping[str, str]]) -> list[Fact]:
    """Merge facts of runs by name, each value once with the labels of its runs."""
    merged: list[Fact] = []
    for name in dict.fromkeys(name for record in records for name in record):
        labels_by_value: dict[str, list[str]] = {}
        for run, record in zip(runs, records, strict=True):
            labels_by_value.setdefault(record.get(name, NOTHING), []).append(run.label)
        if len(labels_by_value) == 1:
            values = [("", value) for value in labels_by_value]
        else:
            values = [("; ".join(labels), value) for value, labels in labels_by_value.items()]
        merged.append((name, values))
    return merged


def recipes(runs: Sequence[Run]) -> list[dict[str, str]]:
    """Return labels, file, scene and command that reproduce runs, once for the runs of a sweep."""
    members: dict[Path, list[Run]] = {}
    for run in runs:
        members.setdefault(run.home, []).append(run)
    written = []
    for home, siblings in members.items():
        first = siblings[0]
        path = home / "scene.yaml"
        # The folder of a run in memory is the working directory, whose scene.yaml is a stranger's.
        is_stored = "provenance" in first.summary and path.is_file()
        name = f"{first.scene.name}.yaml"
        recipe = {
            "labels": "; ".join(run.label for run in siblings),
            "file": name,
            "scene": path.read_text("utf-8") if is_stored else file.dump(first.scene),
            "command": f".venv/bin/rolling run {name}",
        }
        written.append(recipe)
    return written


def provenance(runs: Sequence[Run]) -> list[Fact]:
    """List program, packages and machine that made the numbers; empty for runs in memory."""
    records = []
    for run in runs:
        stored = dict(run.summary.get("provenance", {}))
        stored.pop("label", None)
        packages = stored.pop("packages", None)
        if packages:
            versions = [f"{name} {version}" for name, version in packages.items()]
            stored["packages"] = ", ".join(versions)
        record = {}
        for name, value in stored.items():
            record[name] = NOTHING if value is None else str(value)
        records.append(record)
    return facts(runs, records)


# ---- the sound and its reasons


MAIN = 0.8  # share of the A-weighted power that counts as most of it
MAINLY = 0.5  # share of the sound that is called most


class Colour(NamedTuple):
    """Mean of the A-weighted log frequency of a sound, and the ends of its inner 80 % [Hz]."""

    mean_hz: float
    low_hz: float
    high_hz: float


def colour(run: Run) -> Colour | None:
    """Return the colour of the sound of a run; None if it is silent."""
    if run.sound.levels.laeq_db is None:
        return None
    frequency, _, power = weighted_lines(run.sound)
    share = np.cumsum(power) / power.sum()
    outside = (1.0 - MAIN) / 2.0
    return Colour(
        mean_hz=math.exp(float(np.average(np.log(frequency), weights=power))),
        low_hz=float(frequency[np.searchsorted(share, outside)]),
        high_hz=float(frequency[np.searchsorted(share, 1.0 - outside)]),
    )


def reason(runs: Sequence[Run]) -> str:
    """State where the sound of the run with the highest level lies; empty if all are silent."""
    sounding = _by_level(runs)
    if not sounding:
        return ""
    run, its_colour = sounding[-1]
    of_run = f" of {run.label}" if len(runs) > 1 else ""
    low = rounded(its_colour.low_hz / 1e3)
    high = rounded(its_colour.high_hz / 1e3)
    return (
        f"{100 * MAIN:.0f} % of the A-weighted power{of_run} lies between {low} kHz and {high} kHz."
        f"{_rates(run)}"
    )


def _by_level(runs: Sequence[Run]) -> list[tuple[Run, Colour]]:
    """Return the runs that sound with their colours, the quietest first."""
    sounding = []
    for run in sorted(runs, key=_level_or_zero):
        its_colour = colour(run)
        if its_colour is not None:
            sounding.append((run, its_colour))
    return sounding


def _capitalized(text: str) -> str:
    return text[0].upper() + text[1:]


def _rates(run: Run) -> str:
    """Give the rates at which the ball passes its contact width and the asperities, if they tell.

    Waves of the surface between the two lengths fit into the contact, so a release lies mostly
    between the two rates. Empty where it does not, and for a vibration.
    """
    scene = run.scene
    if run.sound.source == "vibration" or not scene.laws:
        return ""
    speed = mean_speed(scene, run.sound)
    width = 2 * semi_axes(scene)[0]
    rougher = max(scene.laws, key=attrgetter("rq_m"))
    length = 1e-6 * rougher.lengths_um[0]
    frequency, _, power = weighted_lines(run.sound)
    within = (frequency >= speed / width) & (frequency <= speed / length)
    if float(power[within].sum() / power.sum()) < MAINLY:
        return ""
    return (
        f" The ball rolls over its own contact width ({rounded(width * 1e6, 3)} µm) "
        f"{_times(speed / width)} times a second, and over a correlation length of the surface "
        f"({rounded(length * 1e6, 3)} µm) {_times(speed / length)} times a second; waves in "
        "between fit into the contact."
    )


def _times(rate: float) -> str:
    """Write how often something happens in a second, with two digits."""
    return f"{float(rounded(rate)):,.0f}"


def explanations(runs: Sequence[Run]) -> list[tuple[str, str]]:
    """Explain the words of the table of levels at which a stranger stumbles."""
    is_event = any(run.summary.get("single_event") for run in runs)
    is_raised = any(_is_raised_by_a_weighting(run) for run in runs)
    explained = []
    for key, words in tomllib.loads(asset("words.toml")).items():
        if key == "event":
            is_shown = is_event
        elif key == "a_above_z":
            is_shown = is_raised
        else:
            is_shown = any(run.summary.get(key) is not None for run in runs)
        if is_shown:
            explained.append((words["word"], words["meaning"]))
    return explained


def _is_raised_by_a_weighting(run: Run) -> bool:
    """Tell whether the A-weighted level of a run lies above that without weighting."""
    a_weighted = run.record_laeq_db
    unweighted = run.summary["level_db"]
    return a_weighted is not None and unweighted is not None and a_weighted > unweighted
