"""Readings are compared, variations stand apart, and the text holds every statement."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from claim_cases import (
    OTHERWISE,
    reading,
    study,
)

from rolling.lee2025 import claims, claims_text, standing
from rolling.lee2025.checks import (
    NOT,
    NOT_RUN,
    PARTLY,
    REPRODUCED,
    UNDECIDED,
)
from rolling.lee2025.statements import CLAIMS, OUTLOOK
from rolling.lee2025.study import Case


def test_statements_are_sorted_by_what_the_readings_agree_on() -> None:
    partly, none = OTHERWISE["deflection-roughest"], OTHERWISE["pressure-load"]
    same = study(changed=none[1])
    other = study(changed=lambda case: none[1](case) | partly[0](case))
    table = claims.table([*reading("a", same), *reading("b", other)])
    assert table.standing is not None
    found = table.standing.to_dict()
    assert "pressure-load" in found["none"] and "deflection-roughest" in found["differs"]
    assert "plastic-none" in found["every"]
    assert sorted(key for keys in found.values() for key in keys) == sorted(
        c.key for c in (*CLAIMS, *OUTLOOK)
    )
    assert set(found["not run"]) == {"length-frequency", "length-level"}
    text = claims_text.headline(table)
    assert text.startswith(
        f"Of {len(CLAIMS) + 1} judged statements {len(found['every'])} hold in each of 2 readings, "
    )
    assert (
        f", {len(found['none'])} in none, {len(found['differs'])} depending on the reading" in text
    )


def test_no_reading_is_said_to_be_best_by_less_than_two_statements() -> None:
    """Half a statement is no lead, and two are unless an undecided verdict could make up for it."""
    half = study(changed=OTHERWISE["deflection-roughest"][0])
    text = claims_text.markdown(claims.table([*reading("good", study()), *reading("worse", half)]))
    assert "No reading leads by 2 statements" in text
    keys = ("contact-area-load", "plastic-none", "plastic-ratio-load", "deflection-roughest")

    def bad(case: Case) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for key in keys:
            found |= OTHERWISE[key][1](case)
        return found

    table = claims.table([*reading("good", study()), *reading("worse", study(changed=bad))])
    assert "good with 10 lg explains more than the other readings" in claims_text.markdown(table)
    scores = {(one.reading, one.scale): one for one in table.scores}
    good, worse = scores["good", 10], scores["worse", 10]
    assert good.least - worse.most >= standing.LEAD
    scores["worse", 10] = dataclasses.replace(worse, most=good.least - 1.5)
    assert standing.leader([*scores.values()]) is None


def test_variations_are_listed_apart_and_count_for_nothing() -> None:
    """A variation in which a statement fails does not change the agreement of the readings."""
    cases = [
        *reading("stated", study()),
        *reading("bigger", study(changed=OTHERWISE["pressure-load"][1])),
    ]
    table = claims.table(
        cases, departures={"bigger": ["a radius of 10 mm (stated: a diameter of 10 mm)"]}
    )
    assert table.readings["bigger"].kind == "variation"
    assert table.standing is not None and "pressure-load" in table.standing.every
    text = claims_text.tables(table)
    assert text.startswith(claims_text.DOCS_MARK)
    assert (
        text.index("### Readings")
        < text.index("### Variations")
        < text.index("### Statements that each explains")
    )
    assert "| claim | stated |" in text and "| claim | bigger |" in text
    assert "- bigger has a radius of 10 mm (stated: a diameter of 10 mm)." in text
    scores = text.partition("### Statements that each explains")[2]
    assert (
        scores.index("| stated | 10 lg |")
        < scores.index("Variations, which take part")
        < scores.index("| bigger | 20 lg |")
    )


def test_markdown_holds_every_claim_and_reading() -> None:
    table = claims.table(study(3))
    text = claims_text.markdown(table)
    for claim in (*CLAIMS, *OUTLOOK):
        assert f"### {claim.key}" in text
        assert claim.statement in text
        assert claim.caution in text
    widths = {
        line.count("|") for line in text.splitlines() if line.startswith(("| claim", "| *pressure"))
    }
    assert widths == {3}  # a claim and one reading
    assert len({claim.key for claim in (*CLAIMS, *OUTLOOK)}) == len(CLAIMS) + len(OUTLOOK) == 27


def test_the_page_in_docs_answers_for_every_statement() -> None:
    """The page ends with tables.md of the whole study.

    A statement that is added or reworded must be run.
    """
    page = (Path(__file__).parents[2] / "docs" / "lee2025.md").read_text(encoding="utf-8")
    assert page.count(claims_text.DOCS_MARK) == 1
    lines = page.partition(claims_text.DOCS_MARK)[2].splitlines()
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in lines
        if line.startswith("| *")
    ]
    stated = [f"*{claim.key}*: {claim.statement}" for claim in (*CLAIMS, *OUTLOOK)]
    assert set(stated) == {row[0] for row in rows}
    heads = [line.strip("|").split("|")[1:] for line in lines if line.startswith("| claim")]
    scenes = Path(__file__).parents[2] / "scenarios" / "lee2025"
    named = {cell.strip() for head in heads for cell in head}
    assert named == {one.name for one in scenes.iterdir() if not one.name.startswith("elastic-")}
    for row in rows:
        words = {
            word.partition("(")[0].strip(" \\*") for cell in row[1:] for word in cell.split("/")
        }
        assert words <= {REPRODUCED, PARTLY, NOT, NOT_RUN, UNDECIDED}
    for claim in (*CLAIMS, *OUTLOOK):
        assert claim.caution in page
