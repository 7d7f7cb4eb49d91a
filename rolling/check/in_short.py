"""The check of a scene in few lines: whether it runs, its cost, and the largest doubts about it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from acoustics.numbers import byte_size
from rolling.check import cost, memory_and_disk, narrow_surface
from rolling.check.findings import BESIDE_LEVELS, Findings, conclusion
from rolling.check.run_size import run_size
from rolling.numbers.doubt import Doubt, Severity
from rolling.scene.scene import Scene
from rolling.terminal.streams import folded

MAX_LINES = 10  # after the conclusion


def lines_in_short(scene: Scene, findings: Findings) -> list[str]:
    """Return the conclusion of a check, and at most MAX_LINES on cost and the largest doubts."""
    first = conclusion(scene, findings)
    for doubt in _doubts(findings):  # its reason follows in the list
        first = first.replace(f": {doubt.text}.", ".")
    if findings.refusal is not None:
        first = conclusion(scene, findings)
    beside = f"{_cost(scene)} {_estimated(scene)}".rstrip()
    lines = [*folded(f"{beside} {_of_choice(findings)}".rstrip(), "").splitlines()]
    doubts = list(_ranked(findings))
    shown = 0
    for text in doubts:
        paragraph = folded(f"- {text}").splitlines()
        if shown and len(lines) + len(paragraph) + 1 > MAX_LINES:
            break
        lines += paragraph[: MAX_LINES - len(lines) - 1]
        shown += 1
    left = len(doubts) - shown
    more = "-v shows all quantities."
    if left == 1:
        more = "-v shows 1 more doubt, and all quantities."
    elif left:
        more = f"-v shows {left} more doubts, and all quantities."
    return [folded(first, ""), *lines, more]


def _estimated(scene: Scene) -> str:
    """Say that the vibration is estimated only, where a run is heard by its release."""
    is_estimated = scene.dynamics is None and "dynamics" not in scene.sweep
    if not is_estimated or scene.is_permanent or scene.is_smooth:
        return ""
    return "The vibration is estimated only; `dynamics: {}`, with both densities, computes it."


def _cost(scene: Scene) -> str:
    """Write memory and disk of all runs."""
    sizes = [run_size(run.scene) for run in scene.runs()]
    memory = byte_size(sum(memory_and_disk.memory(sizes, cost.cores()).values()))
    disk = byte_size(memory_and_disk.disk(sizes))
    runs = "1 run" if len(sizes) == 1 else f"{len(sizes)} runs"
    return f"{runs}: about {memory} of memory and {disk} of disk."


def _of_choice(findings: Findings) -> str:
    """Say which surfaces a choice leaves out, which no number of the run tells; the first run's."""
    for doubts in findings.doubts.values():
        for doubt in doubts:
            if doubt.key == narrow_surface.OF_CHOICE:
                return f"{doubt.text[:1].upper()}{doubt.text[1:]}: {doubt.advice}."
    return ""


def _is_listed(doubt: Doubt) -> bool:
    """Tell whether a doubt stands in the list: not beside every level, in the refusal or above."""
    is_above = doubt.key in BESIDE_LEVELS or doubt.key == narrow_surface.OF_CHOICE
    return not is_above and doubt.severity is not Severity.REFUSED


def _doubts(findings: Findings) -> list[Doubt]:
    """Return the doubts of all runs that are listed."""
    return [doubt for of_run in findings.doubts.values() for doubt in of_run if _is_listed(doubt)]


def _ranked(findings: Findings) -> Iterator[str]:
    """Yield the doubts in whole sentences, the largest first, each once for all its runs."""
    by_key: dict[str, dict[str, Doubt]] = {}
    for run, doubts in findings.doubts.items():
        for doubt in doubts:
            if _is_listed(doubt):
                by_key.setdefault(doubt.key, {})[run] = doubt
    largest = {key: _largest(by_run) for key, by_run in by_key.items()}
    for key in sorted(largest, key=lambda key: by_key[key][largest[key]].rank, reverse=True):
        yield _sentence(by_key[key], largest[key], findings)


def _largest(by_run: Mapping[str, Doubt]) -> str:
    """Return the run with the largest doubt of a kind."""
    return max(by_run, key=lambda run: by_run[run].rank)


def _sentence(by_run: Mapping[str, Doubt], run: str, findings: Findings) -> str:
    """Write the largest doubt of a kind with its decibels, and the runs that have it."""
    doubt = by_run[run]
    text = doubt.line.rstrip(".")
    text = text[0].upper() + text[1:]
    if doubt.decibels and "dB" not in doubt.text:
        text += f" (up to {doubt.decibels:.1f} dB)"
    return f"{text}{_runs(by_run, run, [*findings.runs])}."


def _runs(by_run: Mapping[str, Doubt], run: str, runs: Sequence[str]) -> str:
    """Name the run of the numbers, and how many others have the doubt too."""
    is_of_all = len(by_run) == len(runs)
    is_the_same = len({doubt.line for doubt in by_run.values()}) == 1
    if len(runs) == 1 or (is_of_all and is_the_same):
        return ""
    others = len(by_run) - 1
    if not others:
        return f" ({run})"
    noun = "run" if others == 1 else "runs"
    return f" ({run}; likewise {others} other {noun})"
