"""Texts and tables of the page as plain text, from the summaries and records of runs."""

import math
import tomllib
from collections.abc import Mapping, Sequence
from importlib.resources import files
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple

import numpy as np

from acoustics.numbers import rounded
from acoustics.texts import printable
from rolling.dynamics.smooth_contact import semi_axes
from rolling.results.answer import level_beside, level_key
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

NOTHING = "-"  # for a number that does not exist
Fact = tuple[str, list[tuple[str, str]]]  # quantity; labels of runs (empty: all runs) and value


def asset(name: str) -> str:
    """Read a file of the page, which is the program's own text."""
    return files("rolling.report").joinpath("assets", name).read_text(encoding="utf-8")


class Column(NamedTuple):
    """A column of the table of levels, which levels.toml explains."""

    head: str
    unit: str = ""
    factor: float = 1.0
    form: str = ".1f"
    always: bool = False


COLUMNS = {key: Column(**column) for key, column in tomllib.loads(asset("levels.toml")).items()}


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


def sentence(runs: Sequence[Run]) -> str:
    """State the result in one sentence, or in one each for steady sounds and single events."""
    sounding = [run for run in runs if main_level(run) is not None]
    if not sounding:
        reasons = dict.fromkeys(silence(run) for run in runs)
        return f"No sound: {'; '.join(reasons)}."
    sentences = []
    for key in dict.fromkeys(level_key(run.summary) for run in sounding):
        sentences.append(_range([run for run in sounding if level_key(run.summary) == key]))
    silent = len(runs) - len(sounding)
    if silent > 0:
        sentences.append(f"{silent} of {len(runs)} runs are silent.")
    return " ".join(sentences)


def _range(sounding: Sequence[Run]) -> str:
    """State between which levels runs of one kind lie."""
    ordered = sorted(sounding, key=_level_or_zero)
    quietest = ordered[0]
    loudest = ordered[-1]
    at = ""
    places = {run.scene.listener_place for run in sounding}
    if len(places) == 1:
        at = f" at {places.pop()}"
    name = level_head(sounding)
    if len(sounding) == 1:
        level = level_text(quietest.summary, level_key(quietest.summary))
        return f"{quietest.label}: {name} {level} dB(A) re 20 µPa{at}."
    name = _capitalized(name)
    low_db = _level_or_zero(quietest)
    high_db = _level_or_zero(loudest)
    if high_db - low_db < 0.05:
        return f"{name}{at} is {low_db:.1f} dB(A) in all {len(sounding)} runs that sound."
    ends = f"{low_db:.1f} dB(A) ({quietest.label}) and {high_db:.1f} dB(A) ({loudest.label})"
    return f"{name}{at} lies between {ends}, {high_db - low_db:.1f} dB apart."


def main_level(run: Run) -> float | None:
    """Return the level of a run that is read first [dB]; None for silence."""
    if run.sound.levels.laeq_db is None:
        return None
    level = run.summary.get(level_key(run.summary))
    return None if level is None else float(level)


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
    """Return heads and rows (label, cells) of the table of levels and contact numbers.

    A level without sound is `silent`, and one that was not computed or says nothing `-`. LAE and
    LAFmax of single events come first.
    """
    are_events = [bool(run.summary.get("single_event")) for run in runs]
    columns = _shown_columns(runs, are_events)
    heads = []
    for key, column in columns.items():
        head = column.head
        if key in ("lae_db", "laeq_db"):
            head = level_head([run for run in runs if level_key(run.summary) == key])
        elif all(are_events) and key in MEANS:
            head = f"LAE (re 1 s), {column.head}"
        heads.append(f"{head} [{column.unit}]" if column.unit else head)
    rows = []
    for run in runs:
        cells = [_cell(run, key, column, all(are_events)) for key, column in columns.items()]
        rows.append((run.label, cells))
    return heads, rows


def _shown_columns(runs: Sequence[Run], are_events: Sequence[bool]) -> dict[str, Column]:
    """Return the columns that say something of the runs, those of single events first."""
    keys = [*COLUMNS]
    if any(are_events):
        keys = [*dict.fromkeys(["lae_db", "laf_max_db", *COLUMNS])]
    else:
        keys.remove("lae_db")
    if all(are_events):
        keys = [key for key in keys if key not in OF_LENGTH]
    return {
        key: COLUMNS[key]
        for key in keys
        if COLUMNS[key].always or any(run.summary.get(key) is not None for run in runs)
    }


def _cell(run: Run, key: str, column: Column, only_events: bool) -> str:
    """Write a number of a run for a table, which may have runs of events only."""
    if key in LEVELS:
        return level_text(run.summary, key) if key in shown_levels(run.summary) else NOTHING
    if run.summary.get("single_event"):
        if key in OF_LENGTH:
            return NOTHING
        if key in MEANS and not only_events:
            return NOTHING
    value = level_beside(run.summary, key) if key in MEANS else run.summary.get(key)
    if value is None:
        return NOTHING
    number = value * column.factor
    return f"{number:{column.form}}" if column.form else rounded(number, 4)


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
            "command": f"rolling run {name}",
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
ALIKE = 0.05  # relative difference of pitch that is not named
MAINLY = 0.5  # share of the sound that is called most
DIFFERS = 2.0  # standard uncertainties of a difference of levels that is named


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


def headline(runs: Sequence[Run]) -> str:
    """State in one sentence how the loudest run differs from the quietest, or how one sounds.

    Only runs of one source are compared, because a release is an upper bound, and single events
    with each other, because their level is that of one second.
    """
    sounding = _by_level(runs)
    if not sounding:
        return sentence(runs)
    loud, loud_colour = sounding[-1]
    quiet, quiet_colour = next(pair for pair in sounding if _are_comparable(pair[0], loud))
    if loud is quiet:
        label = f"{loud.label}: " if len(runs) > 1 else ""
        if loud.sound.source == "vibration":
            return label + _motion_sentences(loud)[:2][-1]  # its fall, its flights, or its ringing
        return f"{label}{100 * MAIN:.0f} % of the sound lies between {_khz(loud_colour)}."
    key = level_key(loud.summary)
    louder_db = loud.summary[key] - quiet.summary[key]
    spread_db = math.hypot(
        loud.summary["uncertainty_db"]["laeq"] or 0.0,
        quiet.summary["uncertainty_db"]["laeq"] or 0.0,
    )
    if louder_db < DIFFERS * spread_db:
        level = f"as loud as {quiet.label} within the uncertainty"
    elif louder_db < 10:
        level = f"{louder_db:.1f} dB louder than {quiet.label}"
    else:
        level = f"{louder_db:.0f} dB louder than {quiet.label}"
    if abs(loud_colour.mean_hz / quiet_colour.mean_hz - 1.0) <= ALIKE:
        pitch = "of the same colour"
    elif loud_colour.mean_hz > quiet_colour.mean_hz:
        pitch = "brighter"
    else:
        pitch = "darker"
    return _capitalized(f"{loud.label} is {level} and {pitch}.")


def reason(runs: Sequence[Run]) -> str:
    """Explain the frequencies of the loudest run; empty if all are silent."""
    sounding = _by_level(runs)
    if not sounding:
        return ""
    run, its_colour = sounding[-1]
    return _capitalized(
        f"{run.label}: {100 * MAIN:.0f} % of the A-weighted power lies between "
        f"{_khz(its_colour)}. {_reason(run)}"
    )


def _khz(its_colour: Colour) -> str:
    """Write the ends of a colour in kHz."""
    return f"{rounded(its_colour.low_hz / 1e3)} kHz and {rounded(its_colour.high_hz / 1e3)} kHz"


def _by_level(runs: Sequence[Run]) -> list[tuple[Run, Colour]]:
    """Return the runs that sound with their colours, the quietest first."""
    sounding = []
    for run in sorted(runs, key=_level_or_zero):
        its_colour = colour(run)
        if its_colour is not None:
            sounding.append((run, its_colour))
    return sounding


def _are_comparable(run: Run, other: Run) -> bool:
    """Tell whether the levels of two runs can be compared: of one source, and both of an event."""
    same_source = run.sound.source == other.sound.source
    return same_source and level_key(run.summary) == level_key(other.summary)


def _capitalized(text: str) -> str:
    return text[0].upper() + text[1:]


def _reason(run: Run) -> str:
    """Give the rates at which the sphere passes its own contact width and the asperities."""
    scene = run.scene
    speed = mean_speed(scene, run.sound)
    width = 2 * semi_axes(scene)[0]
    width_words = f"The sphere rolls over its own contact width, {_rate(width, speed)}"
    if run.sound.source == "vibration":
        return " ".join([f"{width_words}.", *_motion_sentences(run)])
    if not scene.laws:
        return f"{width_words}."
    rougher = max(scene.laws, key=attrgetter("rq_m"))
    length = 1e-6 * rougher.lengths_um[0]
    frequency, _, power = weighted_lines(run.sound)
    within = (frequency >= speed / width) & (frequency <= speed / length)
    share = float(power[within].sum() / power.sum())
    percent = f"{100 * share:.0f} % of the A-weighted power"
    if share >= MAINLY:
        reason = (
            "Waves of the surface between these two lengths fit into the contact: "
            f"{percent} lies between the two rates."
        )
    else:
        reason = (
            f"Only {percent} lies between the two rates, where waves of the surface fit into the "
            "contact."
        )
    length_words = f"over a correlation length of the surface, {_rate(length, speed)}"
    return f"{width_words}, and {length_words}. {reason}"


def _motion_sentences(run: Run) -> list[str]:
    """State the frequency at which the ball rings on its contact, its fall, and its flights."""
    summary = run.summary
    khz = rounded(summary["resonance_hz"] / 1e3)
    wave_um = rounded(summary["resonance_wavelength_m"] * 1e6)
    sentences = [
        f"The ball rings on its contact at {khz} kHz, where waves of the surface of {wave_um} µm "
        "shake it."
    ]
    if "drop_mm" in summary:
        fall = f"The ball falls from {rounded(summary['drop_mm'])} mm above the surface"
        if summary["restitution"] is not None:
            percent = 100 * summary["restitution"]
            fall += f", and its first impact leaves {percent:.0f} % of its speed"
        sentences.append(f"{fall}.")
    share = summary["flight_share"]
    if share > 0:
        impacts = summary["impacts"]
        times = "1 time" if impacts == 1 else f"{impacts} times"
        sentences.append(
            f"The ball flies for {100 * share:.0f} % of the time, and hits the plate {times}."
        )
    return sentences


def _rate(length: float, speed: float) -> str:
    """Write a length [m] with the time to pass it and the rate."""
    ms = rounded(length / speed * 1e3)
    khz = rounded(speed / length / 1e3)
    return f"{rounded(length * 1e6, 3)} µm, once in {ms} ms ({khz} kHz)"


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
