"""Sentences of a choice, made last from its numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES
from acoustics.numbers import rounded
from acoustics.pairs import SURE
from acoustics.texts import printable
from rolling.choice.choice_doubts import WITHOUT_SOLUTION, doubts
from rolling.choice.choice_numbers import ChoiceNumbers, Contender
from rolling.choice.difference import Difference, are_alike
from rolling.choice.heard_specimen import HeardQuantity
from rolling.numbers.doubt import Doubt, Severity
from rolling.numbers.quantity import uncertain
from rolling.results.notes import UNVALIDATED

PROBABLE = 0.8  # probability from which on a candidate is probably quieter
WHERE_SHARE = 0.8  # of the difference of the energies that lies between two named frequencies
_OVER = 0.999  # probabilities above are not told apart


def sentences(choice: ChoiceNumbers) -> list[str]:
    """Return the answer: who is quieter and how sure, where the difference lies, and one doubt."""
    limits = limiting_doubts(choice)
    of_pairs = [doubt.line for doubt in limits if doubt.key == WITHOUT_SOLUTION]
    others = [doubt.line for doubt in limits if doubt.key != WITHOUT_SOLUTION]
    return [*verdicts(choice), *of_pairs, *explanations(choice), *others, *advice(choice)]


def advice(choice: ChoiceNumbers) -> list[str]:
    """Return what would help the loudest one, a sentence or none."""
    if choice.advice is None or not choice.advice.changes:
        return []
    return [choice.advice.sentence]


def verdicts(choice: ChoiceNumbers) -> list[str]:
    """Return who is quieter, by how much and how sure, a sentence for each quantity."""
    if len(choice.quantities) == 1:
        return [_verdict(choice)]
    texts: list[str] = []
    for place in range(len(choice.by_quantity)):
        texts += _by_quantity(choice, place)
    return texts


def explanations(choice: ChoiceNumbers) -> list[str]:
    """Return where the difference lies, and whether it is heard in the room."""
    audible = [choice.audible[0].text] if choice.audible else []
    return [*_where(choice), *audible]


def methods(choice: ChoiceNumbers) -> str:
    """Return the paragraph on methods of a choice, for a report."""
    widest = choice.widest.difference
    compared = f"Candidates were compared on {counted(widest, choice.noun)}."
    if widest.uncertainty_db is not None:
        compared += (
            " The ± is one standard uncertainty of the mean difference by Student's t, with the"
            " scatter of the first six."
        )
    return choice.conditions.paragraph([compared, *verdicts(choice), UNVALIDATED])


def limiting_doubts(choice: ChoiceNumbers) -> list[Doubt]:
    """Return the doubts that limit the answer."""
    return [doubt for doubt in doubts(choice) if doubt.severity is not Severity.NOTE]


def in_short(choice: ChoiceNumbers) -> str:
    """Return the present answer for a line of progress."""
    quietest, other, difference = _first_two(choice)
    if len(choice.quantities) > 1:
        numbers = []
        for quantity in choice.quantities:
            numbers.append(f"{number(choice.by_quantity[0][quantity.name])} dB ({quantity.words})")
        names = f"{printable(other.label)} less {printable(quietest.label)}"
        return f"{names}: {', '.join(numbers)}"
    if difference.db is None:
        return _silence(choice)
    return (
        f"{quietest.label} is {uncertain(difference.db, difference.uncertainty_db)} dB(A)"
        f" quieter than {other.label}"
    )


# ---- the verdict by several quantities


def _by_quantity(choice: ChoiceNumbers, place: int) -> Iterator[str]:
    """Say in which quantities one of two candidates is quieter, and which ones stay open."""
    first = choice.contenders[0]
    second = choice.contenders[place + 1]
    still_open = []
    for quantity in choice.quantities:
        difference = choice.by_quantity[place][quantity.name]
        if difference.db is None:
            yield _of_rest(quantity, first, second)
        elif difference.sureness is not None and not difference.is_sure:
            still_open.append((quantity, difference))
        else:
            yield _of_quantity(quantity, difference, first, second, choice.noun)
    for quantity, difference in still_open:
        yield (
            f"{quantity.where} it stays open which one is quieter: {printable(second.label)} is"
            f" {number(difference)} dB above {printable(first.label)}"
            f" ({_specimens(difference, choice.noun)})."
        )


def _of_rest(quantity: HeardQuantity, first: Contender, second: Contender) -> str:
    """Say which of two candidates is at rest in a quantity, so that they have no difference."""
    resting = [
        contender for contender in (first, second) if not contender.rms_in(quantity.name).any()
    ]
    if len(resting) == 1:
        return f"{quantity.where}, {printable(resting[0].label)} is at rest and the other is not."
    return f"{quantity.where}, both are alike."


def _of_quantity(
    quantity: HeardQuantity, difference: Difference, first: Contender, second: Contender, noun: str
) -> str:
    """Say which of two candidates is quieter in a quantity, by how much and how sure that is."""
    assert difference.db is not None  # asked by the caller
    quiet, loud = (first, second) if difference.db > 0 else (second, first)
    size = uncertain(abs(difference.db), difference.uncertainty_db)
    if difference.db == 0 and difference.sureness is None:
        return f"{quantity.where}, both are alike."
    return (
        f"{quantity.where}, {printable(quiet.label)} {quantity.verb} {size} dB {quantity.adverb}"
        f" than {printable(loud.label)} ({_specimens(difference, noun)})."
    )


def _specimens(difference: Difference, noun: str) -> str:
    """Say on how many specimens a difference was heard, and how sure its sign is."""
    if difference.sureness is None:
        return "one specimen, so it has no ±"
    return f"{counted(difference, noun)}; {probability(difference.sureness)} sure"


def counted(difference: Difference, noun: str) -> str:
    """Say on how many specimens a difference was heard, and as how many independent ones."""
    return counted_places(difference.pairs, difference.independent, noun)


def counted_places(count: int, independent: float | None, noun: str) -> str:
    """Say how many specimens there are, and as how many independent ones they count."""
    if independent is None or not are_alike(count, independent):
        return f"{count} {noun}"
    return f"{count} {noun}, which count as {independent:.1f} independent ones"


def number(difference: Difference) -> str:
    """Write a difference with its ±, `-` where there is none."""
    return "-" if difference.db is None else uncertain(difference.db, difference.uncertainty_db)


# ---- the verdict by one quantity


class _FirstTwo(NamedTuple):
    """The quietest contender, the next one, and their difference."""

    quietest: Contender
    other: Contender
    difference: Difference


def _first_two(choice: ChoiceNumbers) -> _FirstTwo:
    """Return the two contenders between which a choice decides."""
    return _FirstTwo(choice.contenders[0], choice.contenders[1], choice.differences[0])


def _verdict(choice: ChoiceNumbers) -> str:
    """Say which candidate is quieter than the next one, by how much, and how sure that is."""
    quietest, other, difference = _first_two(choice)
    if difference.db is None:
        return f"{capital(_silence(choice))}."
    quiet = printable(quietest.label)
    loud = printable(other.label)
    count = counted(difference, choice.noun)
    if difference.pairs == 1:
        return (
            f"{capital(quiet)} is {difference.db:.1f} dB(A) quieter than {loud}. Nothing is random"
            " in these scenes, so they are compared once, and the difference has no ±."
        )
    if difference.uncertainty_db is None:
        return (
            f"{capital(quiet)} is {difference.db:.1f} dB(A) quieter than {loud} on these scans. All"
            f" {difference.pairs} {choice.noun} share their ridges and count as one, so the"
            " difference has no ±."
        )
    number = uncertain(difference.db, difference.uncertainty_db)
    sure = f"{probability(difference.sureness)} sure"
    if difference.is_sure:
        return (
            f"{capital(quiet)} is {number} dB(A) quieter than {loud} ({count}; {sure} that it is"
            " quieter)."
        )
    if difference.sureness is not None and difference.sureness >= PROBABLE:
        return (
            f"{capital(quiet)} is probably quieter than {loud}, by {number} dB(A) ({count};"
            f" {sure}, and {100 * SURE:.0f} % would decide)."
        )
    return (
        f"Which of {quiet} and {loud} is quieter stays open: they differ by {number} dB(A)"
        f" ({count}; {sure} that {quiet} is quieter)."
    )


def _silence(choice: ChoiceNumbers) -> str:
    """Say that a contender makes no sound, so that there is no difference of levels."""
    silent = [
        contender.label for contender in choice.contenders if not math.isfinite(contender.level_db)
    ]
    names = " and ".join(map(printable, silent))
    return f"{names} makes no sound within hearing, so there is no difference in decibels"


def probability(sureness: float | None) -> str:
    """Write a probability in whole percent, rounded down."""
    if sureness is None:
        return "un"
    if sureness > _OVER:
        return "over 99.9 %"
    return f"{math.floor(100 * sureness)} %"


def capital(text: str) -> str:
    """Return a text that begins with a capital letter."""
    return text[:1].upper() + text[1:]


# ---- where the difference lies


def _where(choice: ChoiceNumbers) -> Iterator[str]:
    """Say between which frequencies most of the difference lies."""
    quietest, other, difference = _first_two(choice)
    quiet_bands = quietest.third_octaves
    loud_bands = other.third_octaves
    if not difference.is_sure or quiet_bands is None or loud_bands is None:
        return
    edges = frequencies_of_difference(loud_bands - quiet_bands)
    if edges is not None:
        yield f"The difference lies {edges}."


def frequencies_of_difference(squares: Array) -> str | None:
    """Say in which third octaves most of a difference of energies lies; None without any.

    They are the fewest neighbouring bands that hold 80 % of it.
    """
    known = np.nan_to_num(squares)
    total = float(known.sum())
    if not total > 0:
        return None
    sums = np.append(0.0, np.cumsum(known))
    for width in range(1, len(known) + 1):
        held = sums[width:] - sums[:-width]
        first = int(np.argmax(held))
        if held[first] >= WHERE_SHARE * total:
            last = first + width - 1
            if width == 1:
                return f"in the third octave at {hertz(BAND_NAMES[first])}"
            return f"between {hertz(BAND_NAMES[first])} and {hertz(BAND_NAMES[last])}"
    return None


def hertz(name: str) -> str:
    """Write the nominal frequency of a third octave with its unit."""
    frequency = float(name)
    if frequency >= 1000:
        return f"{rounded(frequency / 1000, 3)} kHz"
    return f"{name} Hz"


def notes(choice: ChoiceNumbers) -> list[str]:
    """Return what was assumed, what the ± leaves out, and what the released power says."""
    return [doubt.line for doubt in doubts(choice) if doubt.severity is Severity.NOTE]


def parts(choice: ChoiceNumbers) -> list[str]:
    """Return where the ± of each difference comes from, for --verbose."""
    texts = []
    for other, of_one in zip(choice.contenders[1:], choice.by_quantity, strict=True):
        for quantity in choice.quantities:
            sizes = [
                f"{name.replace('_', ' ')} {size:.2f} dB"
                for name, size in of_one[quantity.name].parts_db.items()
                if size > 0
            ]
            place = f", {quantity.words}" if len(of_one) > 1 else ""
            if sizes:
                texts.append(f"± of {printable(other.label)}{place}: {', '.join(sizes)}")
    return texts
