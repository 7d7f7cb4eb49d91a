"""The table of claims in words: claims.md. Depends on claims."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rolling.article.claims import NOT_RUN, WORTH


def markdown(table: dict[str, Any]) -> str:
    """What `claims.table` found, also after JSON: verdicts by reading, which explains the article best, each claim in full."""
    readings = list(table["readings"])
    head = ["claim", *readings]
    rows = [
        [f"*{claim['key']}*: {claim['statement']}", *(_cell(claim, reading) for reading in readings)]
        for claim in table["claims"]
    ]
    parts = [
        "# Claims of Lee, Kim & Kim (2025)",
        "Verdicts are computed from the cases of each reading; statements are in our own words. Levels are judged with"
        " 10 lg of the release power, as the article's equation has it, and with 20 lg: one word where both agree, else"
        " that of 10 lg before that of 20 lg. \\*: some of what the statement names was not run. With 20 lg only"
        " differences mean anything, and the weighting of a line is not doubled.",
        _table(head, rows),
        "## What was run",
        "\n".join(_extent(name, extent) for name, extent in table["readings"].items()),
        "## Which reading explains the article best",
        *_ranking(table),
        "## Claim by claim",
        *(_paragraph(claim) for claim in table["claims"]),
    ]
    return "\n\n".join(parts) + "\n"


def _cell(claim: dict[str, Any], reading: str) -> str:
    found = [one for one in claim["findings"] if one["reading"] == reading]
    words = [one["verdict"] + ("\\*" if one["numbers"].get("missing") else "") for one in found]
    return " / ".join(dict.fromkeys(words))


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _extent(name: str, extent: dict[str, Any]) -> str:
    """A line about a reading: its cases, and what of the article's it lacks."""
    surfaces, cases = extent["surfaces"], extent["cases"]
    seconds = " and ".join(f"{duration:.3g}" for duration in extent["durations_s"])
    what = f"{extent['what']} " if extent["what"] else ""
    words = f"- {name}: {what}{cases} case{'s'[: cases > 1]}, {surfaces} surface{'s'[: surfaces > 1]}, {seconds} s each"
    return words + (f". Lacks {', '.join(extent['lacks'])}" if extent["lacks"] else "") + "."


def headline(table: dict[str, Any]) -> str:
    """Which reading, or readings of equal score, explain most of the statements."""
    first = [one for one in table["scores"] if one["rank"] == 1]
    if not first:
        return "No reading was run that tells."
    named = " and ".join(f"{one['reading']} with {one['scale']} lg" for one in first)
    judged = " and ".join(f"{one['judged']}" for one in first)
    does = "share the first place" if len(first) > 1 else "comes first"
    return f"{named} {does}: {first[0]['score']:g} of {judged} judged statements"


def _ranking(table: dict[str, Any]) -> list[str]:
    scores = table["scores"]
    if not scores:
        return [headline(table)]
    words = (
        f"**{headline(table)}** (1 for each that is reproduced, half for partly). What was not run counts nothing,"
        " so readings compare only as far as the same was judged of them; 20 lg can never be judged on absolute levels."
    )
    rows = [
        [
            f"{one['rank']}",
            one["reading"],
            f"{one['scale']} lg",
            f"{one['score']:g}",
            *(f"{n}" for n in one["counts"].values()),
        ]
        for one in scores
    ]
    parts = [words, _table(["rank", "reading", "levels", "score", *WORTH], rows)]
    after = next((one for one in scores if one["rank"] > 1), None)
    return [*parts, _ahead(scores[0], after)] if after else parts


def _ahead(first: dict[str, Any], after: dict[str, Any]) -> str:
    """Where the best reading is better, and where worse, than the next of a lower rank."""

    def where(a: dict[str, str], b: dict[str, str]) -> str:
        keys = [key for key in a if WORTH[a[key]] > WORTH[b[key]]]
        return ", ".join(
            f"{key} ({a[key]}, not run there)" if b[key] == NOT_RUN else f"{key} ({a[key]}, {b[key]})" for key in keys
        )

    better, worse = where(first["verdicts"], after["verdicts"]), where(after["verdicts"], first["verdicts"])
    names = [f"{one['reading']} with {one['scale']} lg" for one in (first, after)]
    words = f"{names[0]} does better than {names[1]} on: {better}."
    return words + (f" Worse on: {worse}." if worse else "")


def _paragraph(claim: dict[str, Any]) -> str:
    """A claim: the statement, where it stands, the tolerance, and what each reading measured."""
    head = [f"### {claim['key']}", f"{claim['statement']} ({claim['where']})", f"Tolerance: {claim['tolerance']}"]
    scales: dict[tuple[str, str, str], list[str]] = {}
    for one in claim["findings"]:
        same = scales.setdefault((one["reading"], one["verdict"], one["measured"]), [])
        same += [] if one["scale"] is None else [f"{one['scale']} lg"]
    found = [
        f"- {reading}{', ' if same else ''}{' and '.join(same)}: **{verdict}**. {measured}."
        for (reading, verdict, measured), same in scales.items()
    ]
    return "\n\n".join([*head, "\n".join(found)])
