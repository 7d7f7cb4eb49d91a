"""The judged claims in words: claims.md, and the tables of docs/lee2025.md."""

from __future__ import annotations

from collections.abc import Sequence

from rolling.lee2025 import standing
from rolling.lee2025.checks import UNDECIDED, Finding
from rolling.lee2025.results import (
    READING,
    SWEEP,
    VARIATION,
    Extent,
    JudgedClaim,
    Score,
    Standing,
    Table,
)
from rolling.tables import markdown as markdown_table

DOCS_MARK = (
    "<!-- From here on: tables.md, as `rolling reproduce lee2025` writes it into its folder. -->"
)

TURNS = "‡"  # mark of a verdict that is another at half the spacing

_KINDS = {
    READING: ("Readings", "Each keeps to the statements of the article."),
    VARIATION: (
        "Variations",
        "Each changes a statement of the article, to show the effect. It counts for nothing above.",
    ),
    SWEEP: (
        "The outlook",
        "These are further expectations of the article, in a study of their own.",
    ),
}


def markdown(table: Table) -> str:
    """Write claims.md: the tables, the extent of each reading, each claim in full."""
    parts = [
        "# Claims of Lee, Kim & Kim (2025)",
        "Verdicts are computed from the cases of each reading; statements are in our own words. "
        "\\*: some cases that the"
        " statement names were not run.",
        _tables(table),
        "## Cases that were run",
        "\n".join(_extent(name, extent) for name, extent in table.readings.items()) or "None.",
        "## Claim by claim",
        *(_paragraph(judged) for judged in table.claims),
    ]
    return "\n\n".join(parts) + "\n"


def tables(table: Table) -> str:
    """Write tables.md, the generated part of docs/lee2025.md from its mark to the end."""
    return f"{DOCS_MARK}\n\n{_tables(table)}\n"


def _tables(table: Table) -> str:
    """Write all tables: standing, verdicts, cautions and scores."""
    parts = [
        "## Statements that hold",
        f"**{headline(table)}**",
        *_standing(table.standing),
        "## Verdicts",
    ]
    parts.append(
        "Levels are judged with 10 lg of the release power, as in the article's equation, and with"
        " 20 lg. The verdicts read as one word where both agree, else the verdict with 10 lg stands"
        " before the verdict with 20 lg. With 20 lg only differences mean anything. *undecided*:"
        " the cause in brackets may turn the verdict."
    )
    for kind, (heading, words) in _KINDS.items():
        parts += _verdicts(table, kind, heading, words)
    parts += _finer(table)
    parts += _cautions(table)
    return "\n\n".join([*parts, *_scores(table)])


def headline(table: Table) -> str:
    """Count the statements that hold in every reading, in no reading, or depend on the reading."""
    names, state = table.of_kind(READING), table.standing
    if not names or state is None or not state.judged:
        return "No reading was run that could be judged."
    several = len(names) > 1
    counts = [
        f"{len(state.every)} hold in {f'each of {len(names)} readings' if several else names[0]}",
        f"{len(state.part)} in part",
        f"{len(state.none)} {'in none' if several else 'not at all'}",
        f"{len(state.differs)} depending on {'the reading or on ' if several else ''}the scale of "
        "levels",
        f"{len(state.undecided)} undecided",
    ]
    return f"Of {state.judged} judged statements {', '.join(counts)}."


def _standing(state: Standing | None) -> list[str]:
    """Write a table of the statements by their standing, or nothing without statements."""
    if state is None:
        return []
    keys_by_standing = {
        "in every reading": state.every,
        "in part in every reading": state.part,
        "in no reading": state.none,
        "depends on the reading or on the scale of levels": state.differs,
        "undecided in at least one reading": state.undecided,
        "not run": state.not_run,
    }
    rows = [
        [words, f"{len(keys)}", ", ".join(f"*{key}*" for key in keys)]
        for words, keys in keys_by_standing.items()
        if keys
    ]
    return [markdown_table(["holds", "statements", "which"], rows)] if rows else []


def _verdicts(table: Table, kind: str, heading: str, words: str) -> list[str]:
    """Write a table of the verdicts of all readings of a kind."""
    names = table.of_kind(kind)
    if not names:
        return []
    rows = [
        [
            f"*{judged.claim.key}*: {judged.claim.statement}",
            *(_cell(judged, name) for name in names),
        ]
        for judged in table.claims
        if bool(judged.claim.varied) == (kind == SWEEP)
    ]
    departures = {name: table.readings[name].departs for name in names if kind == VARIATION}
    changes = [
        f"- {name} has {' and '.join(departs)}." for name, departs in departures.items() if departs
    ]
    parts = [f"### {heading}", words, "\n".join(changes), markdown_table(["claim", *names], rows)]
    return [part for part in parts if part]


def _cell(judged: JudgedClaim, reading: str) -> str:
    """Write the verdicts of a reading on a claim, with a star where cases are missing."""
    findings = [judgement.finding for judgement in judged.of(reading)]
    words = [
        _word(finding)
        + ("\\*" if finding.numbers and finding.numbers.missing else "")
        + (TURNS if finding.finer and finding.finer.turns else "")
        for finding in findings
    ]
    return " / ".join(dict.fromkeys(words))


def _word(finding: Finding) -> str:
    """Return the verdict, with its cause if it is undecided."""
    return (
        f"{UNDECIDED} ({finding.decided_by})" if finding.verdict == UNDECIDED else finding.verdict
    )


def _finer(table: Table) -> list[str]:
    """List the verdicts that were checked at half the spacing; verdicts that turn are named."""
    checked = [
        (judged.claim.key, judgement, finer)
        for judged in table.claims
        for judgement in judged.judgements
        if (finer := judgement.finding.finer) is not None
    ]
    if not checked:
        return []
    places = {
        (judgement.reading, place) for _, judgement, finer in checked for place in finer.places
    }
    turned = [
        f"- *{key}*, {judgement.reading}{f', {judgement.scale} lg' if judgement.scale else ''}:"
        f" {finer.after} instead of {finer.before}"
        for key, judgement, finer in checked
        if finer.turns
    ]
    plural = "" if len(checked) == 1 else "s"
    words = (
        f"Twice the error of the grid could turn {len(checked)} verdict{plural}. The"
        f" {len(places)} cases that decide them were solved again at half the spacing, on an"
        f" eighth of the track of their first surface. {len(turned) or 'None'} of the verdicts"
        f" change{'s' if len(turned) == 1 else ''} with these numbers"
        f"{f' ({TURNS})' if turned else ''}."
    )
    return ["### At half the spacing", words, *(["\n".join(turned)] if turned else [])]


def _cautions(table: Table) -> list[str]:
    """List the cautions, each once with all its statements."""
    keys_by_caution: dict[str, list[str]] = {}
    for judged in table.claims:
        if judged.claim.caution:
            keys_by_caution.setdefault(judged.claim.caution, []).append(f"*{judged.claim.key}*")
    lines = [f"- {', '.join(keys)}: {caution}" for caution, keys in keys_by_caution.items()]
    return ["### To be read beside them", "\n".join(lines)] if lines else []


def _extent(name: str, extent: Extent) -> str:
    """Write a line about a reading: its cases, and the article's cases that it lacks."""
    seconds = " and ".join(f"{duration:.3g}" for duration in extent.durations_s)
    assumptions = f"{extent.assumptions} " if extent.assumptions else ""
    words = f"- {name} ({extent.kind}): {assumptions}{extent.cases} case{'s'[: extent.cases > 1]}"
    words += f", {extent.surfaces} surface{'s'[: extent.surfaces > 1]}, {seconds} s each"
    return words + (f". Lacks {', '.join(extent.lacks)}" if extent.lacks else "") + "."


def _scores(table: Table) -> list[str]:
    """Write the scores of the readings, then the scores of variations and sweeps.

    The leading reading is named if there is a clear lead.
    """
    if not table.scores:
        return []
    readings = [score for score in table.scores if table.kind(score.reading) == READING]
    first = standing.leader(readings)
    words = (
        "1 for each statement that is reproduced, half for partly; an undecided one counts from its"
        " less to its more favourable verdict. A statement that was not run counts nothing, so"
        " readings compare only as far as the same statements were judged. "
    )
    if first:
        words += (
            f"**{first.reading} with {first.scale} lg explains more than the other readings, "
            f"by {standing.LEAD:g} statements"
            " or more.**"
        )
    else:
        words += (
            f"**No reading leads by {standing.LEAD:g} statements or more: "
            "none explains the article best.**"
        )
    parts = ["### Statements that each explains", words, _score_table(readings)]
    rest = [score for score in table.scores if score not in readings]
    return (
        [*parts, "Variations, which take part in no comparison:", _score_table(rest)]
        if rest
        else parts
    )


def _score_table(scores: Sequence[Score]) -> str:
    """Write a table of scores."""
    rows = [
        [
            score.reading,
            f"{score.scale} lg",
            score.range,
            *(f"{count}" for count in score.counts.values()),
        ]
        for score in scores
    ]
    return markdown_table(["folder", "levels", "score", *standing.WORDS], rows)


def _paragraph(judged: JudgedClaim) -> str:
    """Write a claim in full: statement, place, tolerance, caution, and all measured numbers."""
    claim = judged.claim
    head = [
        f"### {claim.key}",
        f"{claim.statement} ({claim.where})",
        f"Tolerance: {claim.tolerance}",
    ]
    if claim.caution:
        head.append(f"Caution: {claim.caution}")
    scales: dict[tuple[str, str, str], list[str]] = {}
    for judgement in judged.judgements:
        finding = judgement.finding
        same = scales.setdefault((judgement.reading, _word(finding), finding.measured), [])
        same += [] if judgement.scale is None else [f"{judgement.scale} lg"]
    lines = [
        f"- {reading}{', ' if same else ''}{' and '.join(same)}: **{verdict}**. {measured}."
        for (reading, verdict, measured), same in scales.items()
    ]
    return "\n\n".join([*head, "\n".join(lines)])
