"""Search for the coarsest value of a key whose level stays below a limit.

The search computes both ends of a range and some values between, looks whether the level rises with
the value, and halves the interval in which the limit is crossed. All values meet the same
specimens.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from acoustics.texts import printable
from rolling.choice import drawing
from rolling.choice.advice import write_advice
from rolling.choice.audition import Specimens, audition_of
from rolling.choice.candidate import Candidate
from rolling.choice.choosing import OpenChoice, default_folder, open_choice
from rolling.choice.heard_specimen import HeardQuantity
from rolling.choice.limit import (
    FEWEST,
    FINISH,
    GRADE,
    SHARE,
    Limit,
    Point,
    Value,
    falls,
    from_quiet,
    names_of,
    percent,
    tolerance_limit,
)
from rolling.choice.sensitivity import quantity_of, refuse_sweep
from rolling.contact.solver import ContactError
from rolling.results import labels
from rolling.scene.messages import SceneError, is_number, nearest, plain_number, quoted
from rolling.scene.models import full_key
from rolling.terminal import defaults, progress

TIMES = 5.0  # usual range: the value over this number to the value times it
RESOLUTION = 1.05  # ratio of the last two values of the search
BETWEEN = 3  # values between the ends that are computed before the search
DIGITS = 4  # of a value of the search
CUTS = 4  # of a range whose ends are refused


def coarsest_value(
    scene: Any,
    key: str,
    level_db: float,
    between: tuple[Value, Value] | None = None,
    seeds: int = defaults.LIMIT_SEEDS,
    folder: Path | None = None,
    workers: int = 0,
    quantity: str | None = None,
) -> Limit:
    """Find the coarsest value of a key whose level stays below a limit.

    Parameters
    ----------
    scene : scene. A scene without a sweep, on a random or a measured surface.
    key : str. Key of a number above 0, of the finish, or of the grade of the ball.
    level_db : float. The limit, dB(A) at the listener of a scene, dB re 1 um/s of a ring.
    between : pair of float or str. Range of the search. Default: a fifth of the value of the scene
        to five times it, as far as scenes are allowed, or all finishes or grades.
    seeds : int. Number of specimens, from 3 to 60.
    folder : Path. Folder of the specimens. Default: outputs/below-DIGITS.
    workers : int. Number of processes; 0: one per core.
    quantity : str. Name of the quantity whose level is limited. Default: the leading one.

    Raises
    ------
    SceneError : the scene sweeps or cannot run, the key is unknown or has no such value, the range
        is not allowed, or nothing is random in the scene.
    FolderError : the folder holds something else.
    ContactError : a contact has no solution.
    OSError, KeyboardInterrupt : finished pieces are kept.
    """
    refuse_sweep(scene)
    key = _known_key(scene, key)
    if not (is_number(level_db) and math.isfinite(level_db)):
        raise SceneError([f"below: got {quoted(level_db)}, allowed: a level in dB(A)"])
    if not (isinstance(seeds, int) and FEWEST <= seeds <= 60):
        raise SceneError(
            [f"seeds: got {quoted(seeds)}, allowed: a whole number from {FEWEST} to 60"]
        )
    audition = audition_of(scene)
    unsettled = audition.with_free_steps(scene)
    asked = quantity_of(audition.quantities([unsettled]), quantity)
    target = folder or default_folder("below", [unsettled.scene])
    names = names_of(key)
    notes: list[str] = []
    if names:
        values = _range_of_names(names, between, key)
    else:
        values, notes = _range_of_numbers(unsettled, key, between, workers, target)
    ends = [_changed(unsettled, key, value) for value in (values[0], values[-1])]
    base = audition.with_shared_steps(unsettled, ends)
    with open_choice([base], target, workers) as work:
        count = _count(work, scene, seeds)
        search = LimitSearch(
            work=work,
            base=base,
            key=key,
            quantity=asked,
            level_db=float(level_db),
            count=count,
            is_given=between is not None,
        )
        return search.run(values, bool(names), notes)


# ---- key and range


def _known_key(scene: Any, key: str) -> str:
    """Return a dotted key whose value can be searched; refuse any other."""
    key = full_key(key, type(scene))
    value = labels.value_at(scene, key)
    place = f"{scene.place(key)}: {key}"
    last = key.rpartition(".")[2]
    if last in (FINISH, GRADE):
        if value is None:
            raise SceneError([f"{place}: the scene has none; give it one from which to start"])
        return key
    if last == "seed":
        raise SceneError([f"{place}: a seed has no size; allowed: a number that has one"])
    if not is_number(value) or not value > 0 or isinstance(value, int):
        raise SceneError(
            [
                f"{place}: got {quoted(value)}, allowed: a key with a number above 0,"
                " a finish or a grade"
            ]
        )
    return key


def _range_of_names(names: Sequence[str], between: Any, key: str) -> list[Value]:
    """Return the names of a range, both ends included."""
    if between is None:
        return [*names]
    for name in between:
        if name not in names:
            raise SceneError(
                [
                    f"between: {key}: got {quoted(name)}, allowed: {', '.join(names)}"
                    f"{nearest(str(name), names)}"
                ]
            )
    first, last = sorted(map(names.index, between))
    if first == last:
        raise SceneError([f"between: {key}: got {quoted(between[0])} twice, allowed: two names"])
    return [*names[first : last + 1]]


def _range_of_numbers(
    base: Candidate, key: str, between: Any, workers: int, folder: Path
) -> tuple[list[Value], list[str]]:
    """Return both ends of a range, and notes on a usual range that is cut."""
    if between is not None:
        if not all(is_number(value) and value > 0 for value in between):
            raise SceneError(
                [f"between: {key}: got {quoted([*between])}, allowed: two numbers above 0"]
            )
        low, high = sorted(map(float, between))
        if high < low * RESOLUTION:
            raise SceneError(
                [
                    f"between: {key}: got {plain_number(low)} and {plain_number(high)}, allowed:"
                    f" numbers that differ by more than {RESOLUTION - 1:.0%}"
                ]
            )
        for value in (low, high):
            drawing.refuse(_changed(base, key, value), workers, folder)
        return [low, high], []
    own = float(labels.value_at(base.scene, key))
    ends: list[Value] = []
    notes = []
    for wanted in (own / TIMES, own * TIMES):
        end, reason = _allowed_end(base, key, own, wanted, workers, folder)
        ends.append(end)
        if reason:
            notes.append(
                f"The range ends at {printable(labels.worded(key, end))}, because"
                f" {plain_number(_short(wanted))} is refused ({printable(reason)})."
            )
    return ends, notes


def _allowed_end(
    base: Candidate, key: str, own: float, wanted: float, workers: int, folder: Path
) -> tuple[float, str]:
    """Return the end of a range, cut where scenes are refused, and the reason of the refusal."""
    value = _short(wanted)
    first_reason = ""
    for _ in range(CUTS):
        try:
            drawing.refuse(_changed(base, key, value), workers, folder)
            return value, first_reason
        except SceneError as error:
            first_reason = first_reason or error.mistakes[0]
        value = _short(math.sqrt(own * value))
    return own, first_reason


def _changed(base: Candidate, key: str, value: Value) -> Candidate:
    """Return the candidate of a value."""
    audition = audition_of(base.scene)
    return audition.with_value(base, key, value, labels.worded(key, value))


def _short(value: float) -> float:
    """Return a number with the digits of the search."""
    return float(f"{value:.{DIGITS}g}")


def _count(work: OpenChoice, scene: Any, seeds: int) -> int:
    """Return the number of specimens; refuse a scene in which nothing is random."""
    count = min(seeds, work.specimens.count)
    if count < FEWEST:
        has = work.specimens.shortage_words(FEWEST)
        raise SceneError(
            [
                f"{scene.place('surface')}: surface: {scene.name} has {has}, so that no limit holds"
                " for 95 % of specimens; allowed: a surface with a seed, or a larger scan"
            ]
        )
    return count


def _refuse_alike(candidate: Candidate, specimens: Specimens, count: int) -> None:
    """Refuse a scan whose places are as good as one, before any is marched."""
    correlation = specimens.correlation(candidate, candidate, range(count))
    if not math.isinf(tolerance_limit(np.arange(float(count)), correlation)):
        return
    scene = candidate.scene
    raise SceneError(
        [
            f"{scene.place('surface')}: surface: the {count} {specimens.noun} of {scene.name} share"
            f" their ridges and tell no more than one place, so that no limit holds for"
            f" {percent(SHARE)} of specimens; allowed: a surface with a seed, or a wider or longer"
            " scan"
        ]
    )


# ---- search


@dataclass
class LimitSearch:
    """Computes levels over a value until the crossing of a limit is known.

    work, base, key, quantity : The open folder, the candidate, the key and what is heard.
    level_db : float. The limit.
    count : int. Number of specimens.
    is_given : bool. Whether the range was given, so that its ends are not moved.
    """

    work: OpenChoice
    base: Candidate
    key: str
    quantity: HeardQuantity
    level_db: float
    count: int
    is_given: bool
    points: list[Point] = field(default_factory=list)

    def run(self, values: Sequence[Value], are_names: bool, notes: Sequence[str]) -> Limit:
        """Return the answer over a range: the ends of numbers, or all names."""
        notes = [*notes]
        first = self._end(values[0], notes)
        last = self._end(values[-1], notes)
        rises = bool(last.mean_db >= first.mean_db)
        if are_names:
            left = [*values[values.index(first.value) : values.index(last.value) + 1]]
            places = np.linspace(0, len(left) - 1, BETWEEN + 2)[1:-1]
            between = [left[round(float(place))] for place in places]
        else:
            left = []
            ends = float(first.value), float(last.value)
            between = [_short(float(value)) for value in np.geomspace(*ends, BETWEEN + 2)[1:-1]]
        for value in between:
            self._point(value)
        answer = self._crossing(rises, left)
        return Limit(
            name=self.base.scene.name,
            key=self.key,
            quantity=self.quantity,
            level_db=self.level_db,
            points=self.points,
            value=answer,
            rises=rises,
            falls=falls(from_quiet(self.points, rises, self.key)),
            noun=self.work.specimens.noun,
            notes=notes,
            folder=self.work.folder,
            scene=self.base.scene,
        )

    def _end(self, value: Value, notes: list[str]) -> Point:
        """Return the point of an end; a usual range is cut where its contact has no solution."""
        wanted = value
        own = labels.value_at(self.base.scene, self.key)
        for _ in range(CUTS):
            try:
                point = self._point(value)
            except ContactError as error:
                if self.is_given or isinstance(value, str):
                    raise
                reason = printable(str(error).splitlines()[0])
                note = f"{labels.worded(self.key, wanted)} has no solution ({reason})"
                value = _short(math.sqrt(float(own) * float(value)))
                continue
            if value != wanted:
                notes.append(f"The range ends at {labels.worded(self.key, value)}, because {note}.")
            return point
        return self._point(own)

    def _point(self, value: Value) -> Point:
        """Return the point of a value, computed if it is new."""
        for point in self.points:
            if point.value == value:
                return point
        changed = _changed(self.base, self.key, value)
        _refuse_alike(changed, self.work.specimens, self.count)
        (contender,), omitted = self.work.hear([changed], self.count)
        if omitted:  # nothing is known of 95 % of specimens where one of few has no level
            first = omitted[0]
            raise ContactError(f"{first.label}, specimen {first.number}: {first.reason}")
        levels = [
            of_specimen.highest_level_db(self.quantity.name) for of_specimen in contender.heard
        ]
        point = Point(
            value=value,
            levels_db=np.array(levels),
            correlation=self.work.correlation(contender, contender),
        )
        self.points.append(point)
        noun = self.work.specimens.noun
        progress.line(
            f"{labels.worded(self.key, value)}: {percent(SHARE)} of {noun} lie"
            f" below {point.upper_db:.1f} {self.quantity.level_unit}"
        )
        return point

    def _crossing(self, rises: bool, names: Sequence[Value]) -> Value | None:
        """Halve the first interval, from the quiet end, in which the limit is crossed."""
        while True:
            ordered = from_quiet(self.points, rises, self.key)
            below = [point.upper_db <= self.level_db for point in ordered]
            if True not in below:
                return None
            first = below.index(True)
            if False not in below[first:]:
                return ordered[-1].value
            above = first + below[first:].index(False)
            middle = _middle(ordered[above - 1].value, ordered[above].value, names)
            if middle is None:
                return ordered[above - 1].value
            self._point(middle)


def _middle(quieter: Value, louder: Value, names: Sequence[Value]) -> Value | None:
    """Return the value between two values; None where they are near enough."""
    if isinstance(quieter, str) or isinstance(louder, str):
        at, to = sorted((names.index(quieter), names.index(louder)))
        return names[(at + to) // 2] if to - at > 1 else None
    low, high = sorted((quieter, louder))
    if high <= low * RESOLUTION:
        return None
    middle = _short(math.sqrt(low * high))
    return middle if low < middle < high else None


# ---- files


def write_limit(result: Limit) -> list[Path]:
    """Write table, answer, picture and page of the search, and return the files."""
    from rolling.choice.advice_page import limit_page
    from rolling.choice.advice_pictures import limit_picture

    return write_advice(result, "below", limit_picture, limit_page)
