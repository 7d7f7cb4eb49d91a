"""The report on hard cases: its table, and its files hard.json and hard.md."""

from __future__ import annotations

from pathlib import Path

from rolling import tables
from rolling.folders import files
from rolling.terminal import defaults, progress
from rolling.verification import hard_cases, judge
from rolling.verification.hard_cases import CASES
from rolling.verification.judge import Group, Report
from rolling.verification.random_cases import found_cases


def table(report: Report) -> str:
    """Write hard.md: the conditions, the tallies of all groups, and the failures."""
    head = [
        "group",
        "surface",
        "plate",
        "scenes",
        "solved",
        *(f"refused: {reason}" for reason in report.total.refused),
    ]
    head += ["failed", "held %", "iterations 50 %", "95 %", "most"]
    rows = [
        _cells(group) for group in (*report.groups, Group("all but found", "", "", report.total))
    ]
    text = [
        "# Hard cases",
        "",
        "Each scene must hold these conditions, or it counts as failed:",
        "",
    ]
    text += [f"- {condition}" for condition in judge.MUST_HOLD]
    text += ["", tables.markdown(head, rows, padded=True, right=range(3, len(head))), ""]
    text += [
        f"{report.total.states} states; {report.seconds:.1f} s, "
        f"{report.total.solving_seconds:.1f} s of it solving.",
        "",
    ]
    text += [f"## Failures: {len(report.failed)}", ""]
    text += [f"- {outcome.name}: {'; '.join(outcome.violated[:3])}" for outcome in report.failed]
    return "\n".join(text).rstrip() + "\n"


def _cells(group: Group) -> list[str]:
    """Return the cells of a group's row."""
    tally, iterations = group.tally, group.tally.iterations
    counts = [tally.scenes, tally.solved, *tally.refused.values(), tally.failed]
    rate = f"{100 * tally.success_rate:.2f}"
    numbers = [
        *map(str, counts),
        rate,
        str(iterations.median),
        str(iterations.high),
        str(iterations.most),
    ]
    return [group.group, group.surface, group.plate, *numbers]


def main_report(out: Path, random: int, workers: int = 1, long: bool = False) -> int:
    """Judge all cases, print the table, and write hard.json and hard.md.

    Parameters
    ----------
    out : Path. Folder of the files.
    random : int. Number of random scenes. The numbers of odd scenes, of blended scenes and of
        scenes on sub-cells are each a quarter of it.
    workers : int. Number of processes. Default: 1.
    long : bool. If true, add the march of 1e5 steps, which takes minutes. Default: False.

    Returns
    -------
    code : int. 0 without a failure, else 1.
    """
    cases = [*CASES, *found_cases(), *([hard_cases.LONG] if long else [])]
    others = random // defaults.OTHER_SCENES
    total = len(cases) + random + 3 * others
    with progress.bar(total, f"{total} scenes", unit="scene") as bar:
        report = judge.judge_all(cases, random, others, others, others, workers, bar.update)
    text = table(report)
    if not progress.is_quiet():
        print(text)
    out.mkdir(parents=True, exist_ok=True)
    files.write_json(out / "hard.json", report.to_dict())
    files.write_bytes(out / "hard.md", text.encode())
    return 1 if report.failed else 0
