"""Lists of the doubts of runs, for people."""

from collections.abc import Sequence

from rolling.numbers.ball_numbers import RunNumbers
from rolling.numbers.doubt import Doubt, Severity
from rolling.results import description
from rolling.results.notes import HEADLINE
from rolling.results.run_doubts import ERRORS

Runs = Sequence[tuple[str, RunNumbers]]  # label and numbers of each run


def listed(numbers: RunNumbers) -> list[Doubt]:
    """Return the doubts that a person reads; errors of the level have numbers of their own."""
    return [doubt for doubt in numbers.doubts if doubt.key not in ERRORS]


def gathered(runs: Runs) -> list[Doubt]:
    """Merge the doubts of runs that a person reads by key, in the words of the first run.

    The text of each is whole, with the labels of its runs unless it concerns all.
    """
    by_key: dict[str, dict[str, Doubt]] = {}
    for label, numbers in runs:
        for doubt in listed(numbers):
            by_key.setdefault(doubt.key, {})[label] = doubt
    merged = []
    for key, by_label in by_key.items():
        first, *others = by_label
        lines = [_sentence(doubt) for doubt in by_label.values()]
        text = lines[0]
        if len(set(lines)) > 1:
            text += f" (for {first}"
            if others:
                text += f"; similarly for {description.listed(others)}"
            text += ")"
        elif len(by_label) < len(runs):
            text += f" ({'; '.join(by_label)})"
        worst = max(by_label.values(), key=lambda doubt: doubt.rank)
        merged.append(Doubt(key, text, worst.severity, worst.decibels, about=worst.about))
    return merged


def _sentence(doubt: Doubt) -> str:
    """Return the line of a doubt; beside a level it is a whole sentence."""
    if doubt.key not in HEADLINE or doubt.line.endswith("."):
        return doubt.line
    return f"{doubt.line[0].upper()}{doubt.line[1:]}."


def headline(runs: Runs) -> str:
    """Join the doubts that stand beside every level."""
    return " ".join(doubt.text for doubt in gathered(runs) if doubt.key in HEADLINE)


def notes(runs: Runs) -> list[Doubt]:
    """Return the standing properties of the numbers that do not stand beside every level."""
    merged = [doubt for doubt in gathered(runs) if doubt.key not in HEADLINE]
    return [doubt for doubt in merged if doubt.severity is Severity.NOTE]


def warnings(runs: Runs) -> list[Doubt]:
    """Return the warnings of runs, the worst first."""
    merged = [doubt for doubt in gathered(runs) if doubt.key not in HEADLINE]
    limits = [doubt for doubt in merged if doubt.severity > Severity.NOTE]
    return sorted(limits, key=lambda doubt: doubt.rank, reverse=True)
