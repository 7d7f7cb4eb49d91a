"""Verdicts on the two numbers of a run, and lists of its doubts: views of its list of doubts."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rolling.check import level
from rolling.check.doubt import Doubt, Severity, sized
from rolling.results import description
from rolling.results.answer import loses_contact_in_estimate, released_power, vibration
from rolling.results.doubts import ERRORS, instrument
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
    return _as_verdict(level.worst_of(doubts))


def _as_verdict(worst: Doubt) -> dict[str, Any]:
    """Return a verdict as summary.json has it."""
    return {
        "word": worst.severity.word,
        "reason": worst.text,
        "decibels": worst.decibels,
        "key": worst.key,
    }


# ---- verdicts on the two numbers


# Doubts about a released power alone; those of ERRORS belong to the level of the sound files.
OF_RELEASE = (*level.SOURCES, "resonance", "solver", "band_errors", "no_moving_release")


class Verdict(NamedTuple):
    """The worst doubt about one of the two numbers of a run.

    worst : Doubt. The doubt, which gives word and reason.
    known_db : float or None. The largest error that is known [dB], where that of the worst is not.
    """

    worst: Doubt
    known_db: float | None

    @property
    def word(self) -> str:
        """How far to trust the number: trust, indicative or do not quote."""
        return self.worst.severity.word

    @property
    def short(self) -> str:
        """Word and decibels: `indicative, ± 1.2 dB`, or `indicative, > 0.3 dB` at least."""
        if self.worst.decibels:
            return f"{self.word}, ± {_rounded_up(self.worst.decibels)} dB"
        if self.known_db:
            return f"{self.word}, > {self.known_db:.1f} dB"
        return self.word

    @property
    def sentence(self) -> str:
        """Word, decibels and reason: `indicative, ± 1.2 dB: the grid leaves up to 1.2 dB`."""
        return f"{self.short}: {self.worst.text}"


def _rounded_up(decibels: float) -> str:
    """Write decibels with one decimal, rounded up: no error prints as 0.0 dB."""
    return f"{math.ceil(10 * decibels) / 10:.1f}"


def _judged(doubts: Sequence[Doubt]) -> Verdict:
    """Return the verdict of doubts about a number."""
    worst = level.worst_of(doubts)
    known = [doubt.decibels for doubt in doubts if doubt.decibels]
    largest_db = round(max(known, default=0.0), 1)
    return Verdict(worst, None if worst.decibels or not largest_db else largest_db)


def of_vibration(summary: Mapping[str, Any]) -> Verdict | None:
    """Return the verdict on the vibration of a run; None where it has no level."""
    answer = vibration(summary)
    if answer.level_db is None:
        return None
    doubts = of_summary(summary)
    if summary["source"] == "vibration":
        return _judged(doubts)
    shared = [doubt for doubt in doubts if doubt.key not in (*OF_RELEASE, *ERRORS)]
    if answer.how == "estimated":
        shared.append(_estimate(summary))
    if "instrument" in summary:
        shared.append(instrument(summary, "vibration"))
    return _judged(shared)


def _estimate(summary: Mapping[str, Any]) -> Doubt:
    """Return the doubt about a vibration that a linear chain estimates."""
    bodies = summary["vibration_estimate_bodies"]
    if loses_contact_in_estimate(summary):
        text = "it is estimated too high, because the ball would lose contact"
        return Doubt("vibration_estimate", text, Severity.DO_NOT_QUOTE)
    text = f"a linear chain estimates it for {bodies}"
    spread = summary.get("vibration_estimate_uncertainty_db")
    if spread is None:
        return Doubt("vibration_estimate", text, Severity.INDICATIVE)
    return sized("vibration_estimate", text, spread, least=Severity.INDICATIVE)


def of_released_power(summary: Mapping[str, Any]) -> Verdict | None:
    """Return the verdict on a released power; None where its errors are not computed.

    A run whose sound files hold the vibration computes the errors of the vibration only.
    """
    if summary["source"] != "release" or released_power(summary).level_db is None:
        return None
    doubts = of_summary(summary)
    return _judged([doubt for doubt in doubts if doubt.key != "upper_bound"])


def answers_as_json(summary: Mapping[str, Any], sentence: str) -> dict[str, Any]:
    """Return the sentence of a run, and its two numbers with their verdicts, for summary.json."""
    block: dict[str, Any] = {"sentence": sentence}
    for name, answer, judged in (
        ("vibration", vibration(summary), of_vibration(summary)),
        ("released_power", released_power(summary), of_released_power(summary)),
    ):
        block[name] = {
            "level_db": answer.level_db,
            "standard_uncertainty_db": answer.uncertainty_db,
            "how": answer.how,
            "quantity": answer.quantity,
            "solved_share": answer.solved_share,
            "where": answer.where,
            "meaning": answer.meaning,
            "reason": answer.reason,
            "verdict": None if judged is None else _as_verdict(judged.worst),
        }
    return block


# ---- lists


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
            text += f" (for {first}"
            if others:
                text += f"; similarly for {description.listed(others)}"
            text += ")"
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
