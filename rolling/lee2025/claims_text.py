"""The table of claims in words: claims.md, and the tables of docs/lee2025.md. Depends on claims and standing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rolling.lee2025 import standing
from rolling.lee2025.checks import UNDECIDED
from rolling.lee2025.claims import READING, SWEEP, VARIATION

DOCS_MARK = "<!-- From here on: tables.md, as `rolling reproduce lee2025` writes it into its folder. -->"

_KINDS = {
    READING: ("Readings", "Each keeps to what the article states."),
    VARIATION: (
        "Variations",
        "Each changes something that the article states, to show what that does. It counts for nothing above.",
    ),
    SWEEP: ("The outlook", "What else the article expects, in a study of its own."),
}
_STANDING = {
    standing.EVERY: "in every reading",
    standing.PART: "in part in every reading",
    standing.NONE: "in no reading",
    standing.DIFFERS: "depends on the reading or on the scale of levels",
    standing.OPEN: "undecided in at least one reading",
    standing.UNKNOWN: "not run",
}


def markdown(table: dict[str, Any]) -> str:
    """Write down what `claims.table` found, also after JSON: the tables, what was run, each claim in full."""
    parts = [
        "# Claims of Lee, Kim & Kim (2025)",
        "Verdicts are computed from the cases of each reading; statements are in our own words. \\*: some of what the"
        " statement names was not run.",
        _tables(table),
        "## What was run",
        "\n".join(_extent(name, extent) for name, extent in table["readings"].items()) or "Nothing.",
        "## Claim by claim",
        *(_paragraph(claim) for claim in table["claims"]),
    ]
    return "\n\n".join(parts) + "\n"


def tables(table: dict[str, Any]) -> str:
    """Write the part of docs/lee2025.md that follows from the study, from its mark to the end of the page."""
    return f"{DOCS_MARK}\n\n{_tables(table)}\n"


def _tables(table: dict[str, Any]) -> str:
    parts = ["## What holds", f"**{headline(table)}**", *_standing(table), "## Verdicts"]
    parts.append(
        "Levels are judged with 10 lg of the release power, as the article's equation has it, and with 20 lg: one word where both"
        " agree, else that of 10 lg before that of 20 lg; with 20 lg only differences mean anything. *undecided*: what stands in"
        " brackets may turn the verdict."
    )
    for kind, (heading, words) in _KINDS.items():
        parts += _verdicts(table, kind, heading, words)
    parts += _cautions(table)
    return "\n\n".join([*parts, *_scores(table)])


def headline(table: Mapping[str, Any]) -> str:
    """Say how many statements hold in every reading, in none, and how many depend on it."""
    found = table["standing"]
    names = [name for name, one in table["readings"].items() if one["kind"] == READING]
    judged = sum(len(keys) for name, keys in found.items() if name != standing.UNKNOWN)
    if not names or not judged:
        return "No reading was run that tells."
    several = len(names) > 1
    counts = [
        f"{len(found[standing.EVERY])} hold in {f'each of {len(names)} readings' if several else names[0]}",
        f"{len(found[standing.PART])} in part",
        f"{len(found[standing.NONE])} {'in none' if several else 'not at all'}",
        f"{len(found[standing.DIFFERS])} depending on {'the reading or on ' if several else ''}the scale of levels",
        f"{len(found[standing.OPEN])} undecided",
    ]
    return f"Of {judged} judged statements {', '.join(counts)}."


def _standing(table: dict[str, Any]) -> list[str]:
    rows = [
        [words, f"{len(table['standing'][name])}", ", ".join(f"*{key}*" for key in table["standing"][name])]
        for name, words in _STANDING.items()
        if table["standing"][name]
    ]
    return [_table(["holds", "statements", "which"], rows)] if rows else []


def _verdicts(table: dict[str, Any], kind: str, heading: str, words: str) -> list[str]:
    """A table of the verdicts of the readings of a kind on the statements that such readings are about."""
    names = [name for name, one in table["readings"].items() if one["kind"] == kind]
    if not names:
        return []
    rows = [
        [f"*{claim['key']}*: {claim['statement']}", *(_cell(claim, name) for name in names)]
        for claim in table["claims"]
        if bool(claim["swept"]) == (kind == SWEEP)
    ]
    changes = [
        f"- {name} has {' and '.join(table['readings'][name]['departs'])}."
        for name in names
        if kind == VARIATION and table["readings"][name]["departs"]
    ]
    parts = [f"### {heading}", words, "\n".join(changes), _table(["claim", *names], rows)]
    return [part for part in parts if part]


def _cell(claim: dict[str, Any], reading: str) -> str:
    found = [one for one in claim["findings"] if one["reading"] == reading]
    words = [_word(one) + ("\\*" if one["numbers"].get("missing") else "") for one in found]
    return " / ".join(dict.fromkeys(words))


def _word(finding: dict[str, Any]) -> str:
    """A verdict, and what decides it where it is undecided."""
    return f"{UNDECIDED} ({finding['decided_by']})" if finding["verdict"] == UNDECIDED else str(finding["verdict"])


def _cautions(table: dict[str, Any]) -> list[str]:
    """What to know beside verdicts; the same words once, for all statements that they are about."""
    about: dict[str, list[str]] = {}
    for claim in table["claims"]:
        if claim["caution"]:
            about.setdefault(claim["caution"], []).append(f"*{claim['key']}*")
    lines = [f"- {', '.join(keys)}: {caution}" for caution, keys in about.items()]
    return ["### To be read beside them", "\n".join(lines)] if lines else []


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _extent(name: str, extent: dict[str, Any]) -> str:
    """A line about a reading: its cases, and what of the article's it lacks."""
    surfaces, cases = extent["surfaces"], extent["cases"]
    seconds = " and ".join(f"{duration:.3g}" for duration in extent["durations_s"])
    what = f"{extent['what']} " if extent["what"] else ""
    words = f"- {name} ({extent['kind']}): {what}{cases} case{'s'[: cases > 1]}"
    words += f", {surfaces} surface{'s'[: surfaces > 1]}, {seconds} s each"
    return words + (f". Lacks {', '.join(extent['lacks'])}" if extent["lacks"] else "") + "."


def _scores(table: dict[str, Any]) -> list[str]:
    if not table["scores"]:
        return []
    of_readings = [one for one in table["scores"] if table["readings"][one["reading"]]["kind"] == READING]
    first = standing.leader(of_readings)
    words = (
        "1 for each statement that is reproduced, half for partly; an undecided one counts from its less to its more favourable"
        " verdict. What was not run counts nothing, so readings compare only as far as the same was judged of them. "
    )
    if first:
        words += (
            f"**{first['reading']} with {first['scale']} lg explains more than the other readings, by {standing.LEAD:g} statements"
            " or more.**"
        )
    else:
        words += (
            f"**No reading leads by {standing.LEAD:g} statements or more: none is said to explain the article best.**"
        )
    parts = ["### How much each explains", words, _score_table(of_readings)]
    rest = [one for one in table["scores"] if one not in of_readings]
    return [*parts, "Variations, which take part in no comparison:", _score_table(rest)] if rest else parts


def _score_table(scores: Sequence[dict[str, Any]]) -> str:
    rows = [
        [one["reading"], f"{one['scale']} lg", _range(one), *(f"{count}" for count in one["counts"].values())]
        for one in scores
    ]
    return _table(["folder", "levels", "score", *standing.WORDS], rows)


def _range(score: dict[str, Any]) -> str:
    return " to ".join(dict.fromkeys(f"{score[end]:g}" for end in ("least", "most")))


def _paragraph(claim: dict[str, Any]) -> str:
    """A claim: the statement, where it stands, the tolerance, a caution, and what each reading measured."""
    head = [f"### {claim['key']}", f"{claim['statement']} ({claim['where']})", f"Tolerance: {claim['tolerance']}"]
    if claim["caution"]:
        head.append(f"Caution: {claim['caution']}")
    scales: dict[tuple[str, str, str], list[str]] = {}
    for one in claim["findings"]:
        same = scales.setdefault((one["reading"], _word(one), one["measured"]), [])
        same += [] if one["scale"] is None else [f"{one['scale']} lg"]
    found = [
        f"- {reading}{', ' if same else ''}{' and '.join(same)}: **{verdict}**. {measured}."
        for (reading, verdict, measured), same in scales.items()
    ]
    return "\n\n".join([*head, "\n".join(found)])
