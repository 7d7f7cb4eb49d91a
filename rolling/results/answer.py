"""One sentence of what follows from the two numbers of runs.

`rolling.results.description` says in words what rolls on what, and what is special about a run.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from acoustics.numbers import rounded
from acoustics.texts import printable
from rolling.kinds.run_folder import RunFolder
from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.quantity import PART_WORDS, Quantity, QuantityDifference, difference, mean
from rolling.results.description import listed, material_word, number_word, special
from rolling.results.labels import SEED, labels, worded
from rolling.results.run_quantities import (
    above_vibration_db,
    heard_level_db,
    loses_contact_in_estimate,
    measure,
)
from rolling.results.stored_numbers import numbers_of
from rolling.scene.scene import Scene

DIFFERS = 2.0  # standard uncertainties of a difference of levels that is named
WHOLE_DB = 10.0  # a difference from which on tenths of a decibel say nothing
LEAST_DB = 0.05  # a smaller difference prints as 0.0 dB


def of_solved_part(runs: Iterable[RunNumbers]) -> str:
    """Say which part of the records whose levels lead is solved; empty where all of it is."""
    texts = dict.fromkeys(_of_solved_part(numbers) for numbers in runs)
    known = [text for text in texts if text]
    if len(known) <= 1:
        return "".join(known)
    return (
        "Each level is that of the whole record that plays, which goes on at random with the"
        " statistics of its solved part."
    )


def _of_solved_part(numbers: RunNumbers) -> str:
    """Say which part of the record whose level leads is solved; empty where all of it is."""
    long = numbers.heard_whole
    record = numbers.vibration.record
    if long is None or record is None or record.solved_share >= 1:
        return ""
    if heard_level_db(numbers) is None:
        return ""
    whole = "of the whole fall"
    if not numbers.record.single_event:
        whole = f"of the {rounded(record.heard_s, 3)} s that play"
    return (
        f"The level is that {whole}: the first {rounded(record.solved_s, 2)} s are solved, and the"
        " rest goes on at random with their statistics."
    )


# ---- what follows


def follows(runs: Sequence[RunFolder]) -> str:
    """Say in one sentence what follows from the two numbers of runs; empty without any level.

    A single run is described by what is special about it, or by the gap between its numbers. Runs
    that differ in one number are compared at its ends, others from the quietest to the loudest.
    Runs that differ in their seed are one side of the comparison, with the mean of their levels.
    "Louder" and "quieter" are said of the vibration only. Levels of records of which a part is
    solved say so.
    """
    solved = _solved(runs)
    sentences = (_follows(solved), of_solved_part(run.numbers for run in solved))
    return " ".join(filter(None, sentences))


class _NumberedPlace(NamedTuple):
    """A run with its numbers."""

    run: RunFolder
    numbers: RunNumbers


def _solved(runs: Sequence[RunFolder]) -> list[_NumberedPlace]:
    """Return the runs that have numbers, with these."""
    stored = [(run, numbers_of(run)) for run in runs]
    return [_NumberedPlace(run, numbers) for run, numbers in stored if numbers is not None]


def _follows(solved: Sequence[_NumberedPlace]) -> str:
    """Say in one sentence what follows from the two numbers of solved runs."""
    if not solved:
        return ""
    if len(solved) == 1:
        run, numbers = solved[0]
        return special(run.scene, numbers) or gap([numbers])
    swept = {key for place in solved for key in place.run.values}
    if swept == {SEED}:
        return _scatter_of_seeds(solved)
    ends = _ends(_sides(solved))
    if ends is None:
        return gap([place.numbers for place in solved])
    return _comparison(*ends)


def gap(runs: Sequence[RunNumbers]) -> str:
    """Say how far the released power lies above the vibration; empty where one of them lacks."""
    bounds = [
        numbers
        for numbers in runs
        if numbers.released_power.value is not None and numbers.released_power.how == "upper bound"
    ]
    above_db = [above_vibration_db(numbers) for numbers in bounds]
    gaps = sorted(decibels for decibels in above_db if decibels is not None)
    vibrations = [numbers.vibration for numbers in bounds]
    levels = sorted(vibration.value for vibration in vibrations if vibration.value is not None)
    if not gaps or not levels:
        return ""
    is_estimated = {vibration.how for vibration in vibrations} == {"estimated"}
    name = "estimated vibration" if is_estimated else "vibration"
    return f"Released power is {_range(gaps)} dB above the {name} ({_range(levels)} dB(A))."


def _range(values: Sequence[float]) -> str:
    """Write the lowest and the highest of sorted values in whole numbers."""
    ends = dict.fromkeys(f"{value:.0f}" for value in (values[0], values[-1]))
    return " to ".join(ends)


class _Side(NamedTuple):
    """One side of a comparison: runs that differ in their seed at most.

    runs : list of _NumberedPlace. The runs with their numbers.
    values : dict. Their swept values, but for the seed.
    words : str. Words that follow `the ball is louder`, such as `at 100 N`.
    """

    runs: list[_NumberedPlace]
    values: dict[str, Any]
    words: str

    @property
    def scene(self) -> Scene:
        """The scene of the first run."""
        scene: Scene = self.runs[0].run.scene
        return scene

    @property
    def numbers(self) -> list[RunNumbers]:
        """The numbers of the runs."""
        return [place.numbers for place in self.runs]

    @property
    def vibrations(self) -> list[Quantity]:
        """The vibrations of the runs."""
        return [place.numbers.vibration for place in self.runs]

    @property
    def released_powers(self) -> list[Quantity]:
        """The released powers of the runs."""
        return [place.numbers.released_power for place in self.runs]


def _sides(runs: Sequence[_NumberedPlace]) -> list[_Side]:
    """Gather runs that differ in their seed at most, with the words for each side."""
    by_values: dict[tuple[Any, ...], list[_NumberedPlace]] = {}
    for place in runs:
        values = {key: value for key, value in place.run.values.items() if key != SEED}
        by_values.setdefault((place.run.scene.name, *values.items()), []).append(place)
    firsts = [of_side[0].run for of_side in by_values.values()]
    names = Counter(run.scene.name for run in firsts)
    sides = []
    for of_side, label in zip(by_values.values(), labels(firsts), strict=True):
        first = of_side[0].run
        values = {key: value for key, value in first.values.items() if key != SEED}
        words = _words(values, label)
        if len(names) > 1:
            is_alone = names[first.scene.name] == 1 or not values
            words = f"in {first.scene.name}" + ("" if is_alone else f" {words}")
        sides.append(_Side(of_side, values, words))
    return sides


def _words(values: Mapping[str, Any], label: str) -> str:
    """Write what distinguishes a side: its only swept value, or its label."""
    if len(values) != 1:
        return f"with {label}"
    ((key, value),) = values.items()
    if key == "rolling.load_n":
        return f"at {value:g} N"
    if key == "rolling.speed_m_s" and not isinstance(value, str):
        return f"at {value:g} m/s"
    if key == "surface.finish":
        return f"on the {value} finish"
    if key == "plate.material":
        return f"on {material_word(str(value))}"
    if key == "surface.path":
        return f"on {printable(str(value))}"
    return f"with {worded(key, value)}"


def _ends(sides: Sequence[_Side]) -> tuple[_Side, _Side] | None:
    """Return the two sides that are compared, the first and the last; None where none compare."""
    if len({side.scene.name for side in sides}) == 1:
        numbers = [_only_number(side) for side in sides]
        known = [number for number in numbers if number is not None]
        if len(known) == len(sides) > 1:
            return sides[numbers.index(min(known))], sides[numbers.index(max(known))]
    levels = [mean(side.vibrations) for side in sides]
    if any(level is None for level in levels):
        levels = [mean(side.released_powers) for side in sides]
    sounding = [(level, number) for number, level in enumerate(levels) if level is not None]
    if len(sounding) < 2:
        return None
    return sides[min(sounding)[1]], sides[max(sounding)[1]]


def _only_number(side: _Side) -> float | None:
    """Return the only swept value of a side if it is a number."""
    if len(side.values) != 1:
        return None
    (value,) = side.values.values()
    return float(value) if isinstance(value, int | float) else None


def _comparison(first: _Side, last: _Side) -> str:
    """Compare two sides by vibration and released power."""
    every = [*first.numbers, *last.numbers]
    opening = last.words[0].upper() + last.words[1:]
    released = _released_difference(first, last)
    # Where the ball would lose contact, the chain is too loud by an unknown amount.
    loses_contact = any(map(loses_contact_in_estimate, every))
    of_vibrations = None
    if not loses_contact:
        of_vibrations = difference(first.vibrations, last.vibrations, _not_shared(every))
    if of_vibrations is None:
        if released is None:
            return _not_compared(every)
        sentence = f"{opening} the ball {_more_power(released)}"
        if _is_certain(released):
            sentence += f" than {first.words}"
        if loses_contact:
            sentence += "; the vibrations are not compared, because the ball would lose contact"
        return f"{sentence}."
    is_estimated = any(numbers.vibration.how == "estimated" for numbers in every)
    sentence = f"{opening} the ball is {_louder(of_vibrations, first.words, is_estimated)}"
    if released is None:
        return f"{sentence}.{_means(first, last)}"
    is_opposite = _is_certain(released) and of_vibrations.value * released.value < 0
    is_one_sided = _is_certain(released) and not _is_certain(of_vibrations)
    joint = "although" if is_opposite or is_one_sided else "and"
    return f"{sentence}, {joint} it {_more_power(released)}.{_means(first, last)}"


def _not_shared(runs: Sequence[RunNumbers]) -> tuple[str, ...]:
    """Name the sources of uncertainty that runs have, but not the same: baffles of other plates."""
    bands = [numbers.bands.vibration for numbers in runs]
    baffles = {band.parts.get("baffle") for band in bands if band is not None}
    return ("baffle",) if len(baffles) > 1 else ()


def _is_certain(difference: QuantityDifference) -> bool:
    """Tell whether a difference exceeds its uncertainty."""
    size = abs(difference.value)
    return size >= LEAST_DB and size > DIFFERS * difference.uncertainty


def _not_compared(runs: Sequence[RunNumbers]) -> str:
    """Say why runs are not compared, or how their two numbers compare."""
    if len({measure(numbers) for numbers in runs}) > 1:
        return "A single event has an LAE and a lasting sound an LAeq, so they are not compared."
    return gap(runs)


def _means(first: _Side, last: _Side) -> str:
    """Say that the levels of sides with several surfaces are means."""
    most = max(len(first.runs), len(last.runs))
    return f" Levels are means over {number_word(most)} surfaces." if most > 1 else ""


def _louder(difference: QuantityDifference, than: str, estimated: bool) -> str:
    """Write how much louder or quieter the ball is than in other words."""
    if not _is_certain(difference):
        return f"as loud as {than} within the uncertainty"
    word = "louder" if difference.value > 0 else "quieter"
    size = _decibels(difference.value)
    shared = ""
    if difference.left_out:
        both = listed([PART_WORDS[source] for source in difference.left_out])
        shared = f"an error by {both} would be in both"
    if not estimated:
        beside = f" ({shared})" if shared else ""
        return f"{size} {word} than {than}{beside}"
    spread = math.ceil(10 * difference.uncertainty) / 10
    doubt = "; ".join(filter(None, [f"± {spread:.1f} dB, estimated", shared]))
    return f"about {size} ({doubt}) {word} than {than}"


def _more_power(released: QuantityDifference) -> str:
    """Write how much more power the second of two runs releases."""
    if not _is_certain(released):
        return "releases the same power"
    word = "more" if released.value > 0 else "less"
    return f"releases {_decibels(released.value)} {word} power"


def _decibels(difference_db: float) -> str:
    """Write the size of a difference with its unit."""
    size = abs(difference_db)
    return f"{size:.0f} dB" if size >= WHOLE_DB else f"{size:.1f} dB"


def _released_difference(first: _Side, last: _Side) -> QuantityDifference | None:
    """Return the difference of released powers; None where the levels say nothing of power."""
    scenes = [place.run.scene for place in (*first.runs, *last.runs)]
    if any(scene.sound.gain_pa_per_w_m2 is not None for scene in scenes):
        return None
    if len({_conversion(scene) for scene in scenes}) > 1:
        return None
    return difference(first.released_powers, last.released_powers)


def _conversion(scene: Scene) -> tuple[float, ...]:
    """Return what turns a released power into a level: distances and the radiated share."""
    return scene.sound.distance_m, scene.vibration_distance_m, scene.sound.q


def _scatter_of_seeds(runs: Sequence[_NumberedPlace]) -> str:
    """Say how far the numbers scatter between surfaces that differ in their seed alone."""
    texts = []
    vibrations = [place.numbers.vibration.value for place in runs]
    released = [place.numbers.released_power.value for place in runs]
    for name, levels in (("vibration", vibrations), ("released power", released)):
        known = sorted(level for level in levels if level is not None)
        if len(known) > 1:
            ends = f"{known[0]:.1f} and {known[-1]:.1f} dB(A)"
            texts.append(f"the {name} lies between {ends}")
    if not texts:
        return ""
    return f"On {number_word(len(runs))} surfaces of the same statistics {listed(texts)}."
