"""The check of a bearing in sentences: how long it takes, what a designer asks for, the doubts."""

from collections.abc import Iterator, Mapping

from rolling.bearing_kind.bearing_check import AXIAL_DOUBT
from rolling.check import forecast
from rolling.check.findings import Findings
from rolling.numbers.doubt import Doubt, Severity
from rolling.terminal.streams import folded


def conclusion(findings: Findings) -> str:
    """State in a sentence how long a scene takes, and with which verdict at best."""
    if findings.refusal is not None:
        return f"It does not run: {findings.refusal.text}."
    doubts = [doubt for of_run in findings.doubts.values() for doubt in of_run]
    radial = [doubt.severity for doubt in doubts if doubt.key != AXIAL_DOUBT]
    worst = max(radial, default=Severity.NOTE)
    time = f"It runs in {forecast.takes(findings.seconds)}."
    of_what = "velocities"
    axial = ""
    if len(radial) < len(doubts):
        of_what = "radial velocities"
        axial = f" Its axial velocities are under the verdict {Severity.DO_NOT_QUOTE.word}."
    if worst <= Severity.TRUST:
        return f"{time} Nothing speaks against its {of_what}.{axial}"
    if worst is Severity.DO_NOT_QUOTE:
        return f"{time} Its {of_what} will be under the verdict {worst.word}.{axial}"
    return f"{time} The verdict on its {of_what} will at best be {worst.word}.{axial}"


def lines_in_short(findings: Findings) -> list[str]:
    """Return the conclusion of a check, the numbers that a designer asks for, and the doubts."""
    texts: dict[str, list[str]] = {}  # with the runs that have them
    for name, rows in findings.runs.items():
        for text in _sentences({row.key: row.value for row in rows}):
            texts.setdefault(text, []).append(name)
    lines = [folded(conclusion(findings), "")]
    for text, names in texts.items():
        prefix = ""
        if len(names) < len(findings.runs):
            prefix = f"{', '.join(names)}: "
        lines.append(folded(f"{prefix}{text}", ""))
    lines += [folded(f"- {text[0].upper()}{text[1:]}.") for text in _doubts(findings)]
    return [*lines, "-v shows all quantities."]


def _sentences(values: Mapping[str, str]) -> Iterator[str]:
    """Yield sentences on the lines, the loads, the ring and the standard from the rows of a run."""
    lines = ("cage", "BPFO", "BPFI", "2 x ball spin")
    frequencies = ", ".join(f"{line} {values[line]}" for line in lines)
    yield f"{values['bearing']}: {frequencies}."
    yield (
        f"Balls bear {values['ball_loads']}, Hertz pressure {values['inner_pressure']} inner and"
        f" {values['outer_pressure']} outer."
    )
    bending, left_out = (values[key].partition(",")[0] for key in ("ring_bending", "ring_left_out"))
    text = f"The ring resonates at {values['ring_resonances']}, and bends from {bending} on"
    if "elastic_resonances" in values:
        text += f"; what it lacks begins at {left_out}"
    yield f"{text}."
    if "not met" not in values["iso_15242"]:
        yield f"ISO 15242: {values['iso_15242']}."


def _doubts(findings: Findings) -> list[str]:
    """Return the doubts of all runs, the worst first, each once with the runs that have it."""
    runs: dict[Doubt, list[str]] = {}
    for name, doubts in findings.doubts.items():
        for doubt in doubts:
            runs.setdefault(doubt, []).append(name)
    texts = []
    for doubt in sorted(runs, key=lambda doubt: doubt.rank, reverse=True):
        text = doubt.line
        if len(runs[doubt]) < len(findings.runs):
            text += f" ({', '.join(runs[doubt])})"
        texts.append(text)
    return texts
