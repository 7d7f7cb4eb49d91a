"""Doubts about a choice: rules, each with its sentence.

What limits the answer is told with it. What was assumed is a note, and so is what the ± leaves out.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from acoustics.numbers import rounded_up
from acoustics.texts import printable
from rolling.choice.choice_numbers import ChoiceNumbers
from rolling.choice.difference import LEFT_OUT, SCATTER, Difference
from rolling.numbers.doubt import Doubt, Severity
from rolling.numbers.quantity import PART_WORDS

WITHOUT_SOLUTION = "pairs_without_solution"  # key of the doubt that stands beside the verdict
ALIKE_PLACES = "alike_places"
FEW_SHARE = 0.6  # of the places, below which few independent ones limit the answer
LEAST_DB = 0.1  # smallest part that the ± leaves out and a note names
_LEFT_OUT_ADVICE = "the pairs that are left out; choose a wider surface"


def doubts(choice: ChoiceNumbers) -> list[Doubt]:
    """List the doubts about a choice, notes at the end."""
    listed = [doubt for rule in LIMITS for doubt in rule(choice)]
    listed += choice.audition.doubts(choice)
    return [*listed, *_left_out_parts(choice)]


# ---- what limits the answer


def _omissions(choice: ChoiceNumbers) -> Iterator[Doubt]:
    """Say which pairs are left out, why, and what that does to the sureness."""
    if not choice.omitted:
        return
    first = choice.omitted[0]
    numbers = " and ".join(str(pair.number) for pair in choice.omitted)
    verb = "is" if len(choice.omitted) == 1 else "are"
    each = "it counts" if len(choice.omitted) == 1 else "each counts"
    text = (
        f"Of {choice.tried} {choice.noun}, number {numbers} {verb} left out for all, because a"
        f" contact has no solution ({printable(first.label)}: {printable(first.reason)}); {each} as"
        " a pair that speaks against this answer."
    )
    yield Doubt(WITHOUT_SOLUTION, text, Severity.INDICATIVE)


def _equal(choice: ChoiceNumbers) -> Iterator[Doubt]:
    """Say that two candidates sound the same to the last digit, as files do that are equal."""
    first = choice.contenders[0]
    for other, of_one in zip(choice.contenders[1:], choice.by_quantity, strict=True):
        if all(_is_none(difference) for difference in of_one.values()):
            text = (
                f"{printable(first.label)} and {printable(other.label)} sound the same to the last"
                " digit: their files or scenes hold the same under two names."
            )
            yield Doubt("equal_candidates", text, Severity.DO_NOT_QUOTE)


def _is_none(difference: Difference) -> bool:
    """Tell whether the levels of all pairs are equal to the last digit."""
    return difference.db == 0 and difference.parts_db.get(SCATTER) == 0


def _alike_places(choice: ChoiceNumbers) -> Iterator[Doubt]:
    """Say that places of a scan share its ridges, and what a further scan would bring.

    Scans of equal heights have no ± that one could lower.
    """
    difference = choice.widest.difference
    if difference.independent is None:
        return
    if difference.uncertainty_db is None or difference.further_scan_db is None:
        text = (
            f"The {choice.noun} share their ridges and tell no more than one place: a further scan"
            " of each, elsewhere on the part, would give a ±."
        )
        yield Doubt(ALIKE_PLACES, text, Severity.DO_NOT_QUOTE)
        return
    if _is_none(difference):
        return
    spread = rounded_up(difference.uncertainty_db)
    less = rounded_up(difference.further_scan_db)
    gain = f"A further scan of each would lower the ± from {spread} to about {less} dB."
    if not difference.shares_places:
        yield Doubt(ALIKE_PLACES, gain, Severity.NOTE)
        return
    text = (
        f"The {choice.noun} are partly alike, so that {difference.independent:.1f} independent"
        f" places of each are in the ±, and not {difference.pairs}. {gain}"
    )
    is_few = difference.independent < FEW_SHARE * difference.pairs
    yield Doubt(ALIKE_PLACES, text, Severity.INDICATIVE if is_few else Severity.NOTE)


def _early(choice: ChoiceNumbers) -> Iterator[Doubt]:
    """Say that the limit of time ended a choice."""
    if not choice.is_early or choice.widest.difference.uncertainty_db is None:
        return
    text = (
        f"The choice ended early, because {choice.limit} after {choice.tried} {choice.noun};"
        " with more --minutes the same command goes on."
    )
    yield Doubt("ended_early", text, Severity.INDICATIVE)


def _wide(choice: ChoiceNumbers) -> Iterator[Doubt]:
    """Say what limits the ± where it is above the wanted one, with its size."""
    other, difference = choice.widest
    if difference.uncertainty_db is None or difference.uncertainty_db <= choice.within_db:
        return
    part, size_db = max(difference.parts_db.items(), key=lambda item: item[1])
    if part != SCATTER:
        advice = _LEFT_OUT_ADVICE if part == LEFT_OUT else choice.audition.advice[part]
        text = f"Of the ±, {size_db:.1f} dB come from {advice}."
        yield Doubt(f"uncertain_by_{part}", text, Severity.INDICATIVE, size_db)
    elif choice.limit and not choice.is_early:
        text = (
            f"The ± of {printable(other.label)} is above the wanted {choice.within_db:g} dB,"
            f" because {choice.limit}"
        )
        if difference.shares_places:
            text += "."
        else:
            text += f"; four times as many {choice.noun} would halve it."
        yield Doubt("uncertain_by_scatter", text, Severity.INDICATIVE, size_db)


# ---- notes


def _left_out_parts(choice: ChoiceNumbers) -> Iterator[Doubt]:
    """Say which parts of the ± of the runs the ± of their differences leave out."""
    text = left_out_text(
        difference for of_one in choice.by_quantity for difference in of_one.values()
    )
    if text:
        yield Doubt("left_out_parts", text, Severity.NOTE)


def left_out_text(differences: Iterable[Difference]) -> str:
    """Say which parts of the ± of the runs the ± of differences leave out; empty without any."""
    sizes: dict[str, float] = {}
    for difference in differences:
        for source, size_db in difference.left_out_db.items():
            sizes[source] = max(size_db, sizes.get(source, 0.0))
    named = [
        f"{PART_WORDS[source]} ({rounded_up(size_db)} dB)"
        for source, size_db in sorted(sizes.items(), key=lambda item: -item[1])
        if size_db >= LEAST_DB
    ]
    if not named:
        return ""
    return (
        "The ± of a difference leaves out what is taken to shift both levels alike:"
        f" {', '.join(named)}, with the size that it would have otherwise."
    )


LIMITS = (_omissions, _equal, _alike_places, _early, _wide)
RULES = (*LIMITS, _left_out_parts)
