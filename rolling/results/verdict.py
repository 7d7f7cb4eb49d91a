"""Verdict on the level of a run, and lists of its doubts: all are views of its list of doubts."""

from collections.abc import Mapping, Sequence
from typing import Any

from rolling.check import level
from rolling.check.doubt import Doubt, Severity
from rolling.results.doubts import ERRORS
from rolling.results.notes import HEADLINE

Runs = Sequence[tuple[str, Mapping[str, Any]]]  # label and summary of each run


def as_json(doubts: Sequence[Doubt]) -> list[dict[str, Any]]:
    """Return doubts as summary.json has them."""
    return [
        {
            "key": doubt.key,
            "text": doubt.text,
            "advice": doubt.advice,
            "severity": doubt.severity.word,
            "decibels": doubt.decibels,
        }
        for doubt in doubts
    ]


def of_summary(summary: Mapping[str, Any]) -> list[Doubt]:
    """Return the doubts of a summary."""
    severities = {severity.word: severity for severity in Severity}
    return [
        Doubt(**doubt | {"severity": severities[doubt["severity"]]}) for doubt in summary["doubts"]
    ]


def verdict(doubts: Sequence[Doubt]) -> dict[str, Any]:
    """Return word, reason, decibels and key of the worst doubt about a level."""
    worst = level.worst_of(doubts)
    return {
        "word": worst.severity.word,
        "reason": worst.text,
        "decibels": worst.decibels,
        "key": worst.key,
    }


def listed(summary: Mapping[str, Any]) -> list[Doubt]:
    """Return the doubts that a person reads; errors of the level have numbers of their own."""
    return [doubt for doubt in of_summary(summary) if doubt.key not in ERRORS]


def gathered(runs: Runs) -> list[Doubt]:
    """Merge the doubts of runs that a person reads by key, in the words of the first run.

    The text of each is whole, with the labels of its runs unless it concerns all.
    """
    by_key: dict[str, dict[str, Doubt]] = {}
    for label, summary in runs:
        for doubt in listed(summary):
            by_key.setdefault(doubt.key, {})[label] = doubt
    merged = []
    for key, by_label in by_key.items():
        first, *others = by_label
        lines = [_sentence(doubt) for doubt in by_label.values()]
        text = lines[0]
        if len(set(lines)) > 1:
            likewise = f"; likewise {', '.join(others)}" if others else ""
            text += f" (in the numbers of {first}{likewise})"
        elif len(by_label) < len(runs):
            text += f" ({'; '.join(by_label)})"
        worst = max(by_label.values(), key=lambda doubt: doubt.rank)
        merged.append(Doubt(key, text, worst.severity, worst.decibels))
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


def verdicts(runs: Runs) -> list[tuple[str, str]]:
    """Return words and reasons of the verdicts, each once with the labels of its runs."""
    merged: dict[tuple[str, str], list[str]] = {}
    for label, summary in runs:
        judged = summary.get("verdict")
        if judged:
            merged.setdefault((judged["word"], judged["reason"]), []).append(label)
    lines = []
    for (word, reason), labels in merged.items():
        of_some = "" if len(labels) == len(runs) else f" ({'; '.join(labels)})"
        lines.append((word, reason + of_some))
    return lines
