"""Sentences and facts of the page as plain text, from the numbers and records of runs."""

import math
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from acoustics.numbers import rounded
from acoustics.texts import printable
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.kinds.registry import kind_of
from rolling.numbers.quantity import Quantity
from rolling.numbers.views import NOTHING
from rolling.results import description
from rolling.results.run_quantities import heard_level_db
from rolling.results.run_result import Run
from rolling.results.stated_sound import StatedSound
from rolling.scene import file
from rolling.sound.wavelengths import mean_speed, weighted_lines
from rolling.terminal.whole_files import read_regular

INSTALL = "python3 -m venv .venv && .venv/bin/pip install -c constraints.txt -e ."
MAX_SCENE = 1_000_000  # bytes of a scene file on a page
Fact = tuple[str, list[tuple[str, str]]]  # quantity; labels of runs (empty: all runs) and value


def asset(name: str) -> str:
    """Read a file of the page, which is the program's own text."""
    return files("rolling.report").joinpath("assets", name).read_text(encoding="utf-8")


# ---- levels


def titles(runs: Sequence[Any]) -> str:
    """Join the titles of the scenes in printable letters, where they lack one their subjects."""
    by_scene: dict[str, list[Any]] = {}
    for run in runs:
        by_scene.setdefault(run.scene.title or run.scene.name, []).append(run)
    names = []
    for name, of_scene in by_scene.items():
        scene = of_scene[0].scene
        names.append(name if scene.title else kind_of(scene).subject(of_scene))
    return printable(", ".join(dict.fromkeys(names)))


def heard(
    run: Run, is_alone: bool, stated: StatedSound | None = None, is_beside_levels: bool = False
) -> str:
    """Say what one hears of a run, and what is special about it unless the page has it alone.

    `stated` is the sound. Default: what plays. Its level is left out beside the levels of runs that
    have the same one.
    """
    stated = stated or run.stated()
    if stated.level.level_db is None:
        return f"{_capitalized(run.label)} is silent: {silence(run, stated)}."
    q = run.scene.sound.q
    if stated.source == "vibration":
        sound = f"the vibration of ball and plate, {stated.how}"
    elif run.scene.sound.gain_pa_per_w_m2 is not None:
        sound = "the released power under the gain that the scene fixes"
    elif q != 1:
        sound = f"the released power, as if a share of {q:g} became sound"
    else:
        sound = "the released power, as if all of it became sound"
    level = stated.level.words
    if is_beside_levels:
        level = level.removeprefix(_level_words(run.vibration)).removeprefix("; ")
    sentence = f"You hear {sound}: {level}." if level else f"You hear {sound}."
    reason = run.numbers.vibration.reason
    if stated.source == "release" and reason:
        sentence += f" No vibration plays: {reason}."
    if not is_alone:
        sentence = f"{sentence} {description.special(run.scene, run.numbers)}".rstrip()
    return sentence


def _level_words(quantity: Quantity) -> str:
    """Write a level as a sound that plays at it does."""
    if quantity.value is None:
        return ""
    return f"{quantity.measure} {quantity.value:.1f} {quantity.unit}"


def released(run: Run, stated: StatedSound) -> str:
    """Say what the second button plays, with its level unless the levels of runs have it."""
    if stated.level.level_db is None:
        return "The released power does not fluctuate within hearing."
    if stated.level.words == _level_words(run.released_power):
        return "An upper bound."
    return f"An upper bound: {stated.level.words}."


def common_gain(sounds: Iterable[StatedSound]) -> str:
    """Say what the gain that runs share does to the ear; vibration and release have one each."""
    sources = {stated.source for stated in sounds}
    if sources == {"vibration"}:
        return "All runs play with one gain, so a louder run sounds louder."
    if sources == {"release"}:
        return (
            "All runs play with one gain, so a run that releases more power sounds louder here. "
            "Which ball is louder, only the vibration says."
        )
    return (
        "Vibrations share one gain, so the louder one sounds louder. Released powers share "
        "another; which of these balls is louder, only the vibration says."
    )


def main_level(run: Run) -> float | None:
    """Return the level of what plays of a run [dB]; None for silence."""
    played = run.numbers.heard
    if played is not None:
        return played.level_db
    if run.sound.levels.laeq_db is None:
        return None
    return heard_level_db(run.numbers)


def lead_by_whole(runs: Sequence[Run]) -> bool:
    """Tell whether a run has the level of a long record that ends; those of 0.8.0 have none."""
    return any(run.numbers.heard_whole is not None for run in runs)


def _level_or_zero(run: Run) -> float:
    """Return the level of a run that is read first [dB], by which runs are sorted."""
    return main_level(run) or 0.0


def silence(run: Run, stated: StatedSound | None = None) -> str:
    """State the reason of the silence of a sound of a run, by default of what plays."""
    motion = run.numbers.motion
    if motion is not None and motion.flight_share == 1 and not motion.impacts:
        return f"the record of {rounded(run.sound.duration)} s ends before the ball hits the plate"
    source = (stated or run.stated()).source_words
    return f"the {source} does not fluctuate within hearing"


def level_head(sounds: Iterable[StatedSound]) -> str:
    """Name the level of what plays: of the vibration, of the released power, or of both."""
    return " or ".join(dict.fromkeys(f"{stated.measure} of the {stated.name}" for stated in sounds))


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


def recipes(runs: Sequence[Any]) -> list[dict[str, str]]:
    """Return labels, file, scene and command that reproduce runs, once for the runs of a sweep."""
    members: dict[Path, list[Any]] = {}
    for run in runs:
        members.setdefault(run.home, []).append(run)
    written = []
    for home, siblings in members.items():
        first = siblings[0]
        path = home / "scene.yaml"
        # The folder of a run in memory is the working directory, whose scene.yaml is a stranger's.
        is_stored = first.stored is not None and path.is_file()
        name = f"{first.scene.name}.yaml"
        recipe = {
            "labels": "; ".join(run.label or run.scene.name for run in siblings),
            "file": name,
            "scene": _scene_text(path) if is_stored else file.dump(first.scene),
            "command": f".venv/bin/rolling run {name}",
        }
        written.append(recipe)
    return written


def _scene_text(path: Path) -> str:
    """Return the text of a stored scene file."""
    return read_regular(path, MAX_SCENE).decode("utf-8", "replace")


def provenance(runs: Sequence[Run]) -> list[Fact]:
    """List program, packages and machine that made the numbers; empty for runs in memory."""
    records = []
    for run in runs:
        record = {}
        if run.stored is not None:
            made_by = run.stored.provenance
            versions = [f"{name} {version}" for name, version in made_by.packages.items()]
            record = {
                "program": made_by.program,
                "sources": made_by.sources,
                "source": made_by.source or NOTHING,
                "python": made_by.python,
                "machine": made_by.machine,
                "written": made_by.written,
                "seed": NOTHING if made_by.seed is None else str(made_by.seed),
                "packages": ", ".join(versions),
            }
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
    """Return the colour of what plays of a run; None if it is silent."""
    sound = run.stated().along_track
    if sound.levels.laeq_db is None:
        return None
    frequency, _, power = weighted_lines(sound)
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
    between the two rates. Empty where it does not, and where a vibration plays.
    """
    scene = run.scene
    sound = run.stated().along_track
    if sound.source == "vibration" or not scene.laws:
        return ""
    speed = mean_speed(scene.motion, sound)
    width = 2 * smooth_contact_of(scene).semi_axes_m()[0]
    rougher = max(scene.laws, key=attrgetter("rq_m"))
    length = 1e-6 * rougher.lengths_um[0]
    frequency, _, power = weighted_lines(sound)
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
