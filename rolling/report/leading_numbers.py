"""The numbers of runs that lead as pages show them: value, uncertainty, verdict, and their words.

A bound or an assumption has a word and a look of its own, and its numerical error beside it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from rolling.kinds.registry import kind_of
from rolling.numbers.doubt import Severity
from rolling.numbers.quantity import ASSUMED, BOUND, Quantity, Verdict, spread_text
from rolling.results import description, verdict
from rolling.results.run_quantities import LAE
from rolling.results.run_result import Run

WORDS = {  # of verdicts
    "trust": "no error above 1 dB is known",
    "indicative": "good for comparing, because its error is up to 3 dB or of unknown size",
    "do not quote": "its error exceeds 3 dB",
    BOUND: "what one would hear lies below it; its numerical error stands beside it",
    ASSUMED: "a share q or a gain is assumed; its numerical error stands beside it",
}
AT_LEAST = (">", "a part of the error has this size, and the rest is not known")


class ShownQuantity(NamedTuple):
    """A quantity as the page shows it.

    Attributes
    ----------
    value, spread : str
        The number, such as `11.0`, and its uncertainty, such as `± 1.2`.
    measure : str
        LAE or LAeq where the page has both.
    missing : str
        Why there is no number.
    verdict : str
        Word of the verdict.
    error : str
        Size of its numerical error; how good a bound or an assumed number is as a number.
    leads : bool
        Whether it is the number that is read first.
    """

    value: str = ""
    spread: str = ""
    measure: str = ""
    missing: str = ""
    verdict: str = ""
    error: str = ""
    leads: bool = False


class ShownColumn(NamedTuple):
    """A column of a number: its name, how it was found and its unit, its cells."""

    name: str
    remark: str
    cells: list[ShownQuantity]


def shown_columns(runs: Sequence[Any]) -> list[ShownColumn]:
    """Return the quantities of runs of one kind as the page shows them.

    Where they have different meanings, as vibration and released power, the first one that a run
    has leads, and all others stand in its shadow.
    """
    by_name = _quantities(runs)
    first = next(iter(by_name.values()))
    is_mixed = len({quantity.measure for quantity in first}) > 1
    columns = []
    is_led = False
    for name, quantities in by_name.items():
        has_number = any(quantity.value is not None for quantity in quantities)
        leads = has_number and not is_led
        column = ShownColumn(
            name=name,
            remark=_remark(quantities, is_mixed),
            cells=[_shown(quantity, is_mixed, leads) for quantity in quantities],
        )
        columns.append(column)
        is_led = is_led or leads
    return columns


def _quantities(runs: Sequence[Any]) -> dict[str, list[Quantity]]:
    """Return the quantities of runs of one kind by their names, one of each run."""
    kind = kind_of(runs[0].scene)
    of_runs = [kind.quantities(run.numbers) for run in runs]
    names = dict.fromkeys(name for quantities in of_runs for name in quantities)
    return {
        name: [quantities.get(name, Quantity(name, None)) for quantities in of_runs]
        for name in names
    }


def _remark(quantities: Sequence[Quantity], is_mixed: bool) -> str:
    """Say how quantities were found, and in which unit they are."""
    hows = dict.fromkeys(number.how for number in quantities if number.value is not None)
    of_event = not is_mixed and quantities[0].measure == LAE
    unit = quantities[0].unit.replace("um/", "µm/")
    if of_event:
        unit = f"LAE {unit}"
    return ", ".join(filter(None, (" or ".join(hows), unit)))


def _shown(quantity: Quantity, is_mixed: bool, leads: bool) -> ShownQuantity:
    """Return a quantity as the page shows it."""
    judged = quantity.judged
    if judged is None:
        return ShownQuantity(missing=quantity.reason, leads=leads)
    value, _, spread = quantity.number.partition(" ± ")
    if quantity.uncertainty_unit and quantity.uncertainty is not None:
        spread = f"{spread_text(quantity.uncertainty)} {quantity.uncertainty_unit}"
    return ShownQuantity(
        value=value,
        spread=f"± {spread}" if spread else "",
        measure=quantity.measure if is_mixed else "",
        verdict=judged.word,
        error=_beside(_error(judged), spread),
        leads=leads,
    )


def _beside(error: str, spread: str) -> str:
    """Return the error of a verdict; nothing where the number stands beside it with the same ±."""
    is_same = bool(spread) and error.removesuffix(" dB") == f"± {spread.removesuffix(' dB')}"
    return "" if is_same else error


def _error(judged: Verdict) -> str:
    """Write the numerical error of a number; of a bound or an assumption how good it is, too."""
    severity = judged.worst.severity
    if judged.word == severity.word or severity <= Severity.TRUST:
        return judged.error
    return ", ".join(filter(None, (f"numerically {severity.word}", judged.error)))


# ---- words


def verdict_words(runs: Sequence[Any]) -> list[tuple[str, str]]:
    """Explain the words of the verdicts on the numbers of runs."""
    verdicts = [*_judged(runs)]
    words = {judged.word for judged in verdicts}
    explained = [(word, meaning) for word, meaning in WORDS.items() if word in words]
    if any(judged.error.startswith(">") for judged in verdicts):
        explained.append(AT_LEAST)
    return explained


def _judged(runs: Sequence[Any]) -> Iterator[Verdict]:
    """Yield the verdicts on the numbers of runs."""
    for quantities in _quantities(runs).values():
        for quantity in quantities:
            if quantity.judged is not None:
                yield quantity.judged


def meanings(runs: Sequence[Any]) -> list[tuple[str, str]]:
    """Explain the numbers that runs have: name and the rest of the sentence, each meaning once."""
    explained = []
    for name, quantities in _quantities(runs).items():
        known = [number.meaning for number in quantities if number.value is not None]
        for meaning in dict.fromkeys(filter(None, known)):
            rest = meaning.removeprefix(name)
            if rest == meaning:
                rest = f": {meaning[0].lower()}{meaning[1:]}"
            explained.append((name, rest))
    return explained


def units(runs: Sequence[Run]) -> str:
    """Say of what and where the levels of runs are."""
    mean = "Levels are A-weighted means over the record (LAeq)"
    if any(run.vibration.measure == LAE for run in runs):
        mean = "Levels are A-weighted"
    places = [*dict.fromkeys(run.scene.listener_place for run in runs)]
    at = f" at {places[0]}" if len(places) == 1 else ""
    return f"{mean}{at}, in dB re 20 µPa."


# ---- doubts


def doubts(runs: Sequence[Any]) -> list[str]:
    """Return the doubts about the numbers of runs as sentences, the worst of each number first."""
    names_by_words: dict[tuple[str, str, str], list[str]] = {}  # by what is said of them
    shown_keys = set[str]()
    for name, quantities in _quantities(runs).items():
        by_reason: dict[str, dict[str, Verdict]] = {}
        for run, quantity in zip(runs, quantities, strict=True):
            judged = quantity.judged
            if judged is not None and judged.worst.severity > Severity.TRUST:
                by_reason.setdefault(judged.worst.text, {})[run.label] = judged
                shown_keys.add(judged.worst.key)
        for reason, by_label in by_reason.items():
            largest = max(by_label.values(), key=_size)
            of_some = "" if len(by_label) == len(runs) else f" of {description.listed(by_label)}"
            words = (
                largest.short if largest.word == largest.worst.severity.word else _error(largest)
            )
            names_by_words.setdefault((of_some, words, reason), []).append(name)
    sentences = []
    for (of_some, words, reason), names in names_by_words.items():
        verb = "is" if len(names) == 1 else "are"
        sentences.append(_ended(f"{description.listed(names)}{of_some} {verb} {words}: {reason}"))
    for doubt in verdict.warnings([(run.label, run.numbers) for run in runs]):
        if doubt.key not in shown_keys:
            sentences.append(_ended(f"{doubt.text[0].upper()}{doubt.text[1:]}"))
    return sentences


def _size(judged: Verdict) -> float:
    """Return the decibels of a verdict, by which verdicts of one reason are sorted."""
    return abs(judged.worst.decibels or judged.known_db or 0.0)


def _ended(sentence: str) -> str:
    """End a sentence with a full stop."""
    return sentence if sentence.endswith(".") else f"{sentence}."
