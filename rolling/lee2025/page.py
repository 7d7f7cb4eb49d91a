"""The readings of the article side by side on one HTML page that needs no network. Depends on report and claims_text.

The claims come first, then a row for each figure with a column for each reading; how it looks is in `page/article.html`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rolling.figures.picture import Picture
from rolling.lee2025 import claims_text
from rolling.lee2025.claims import READING, SWEEP, VARIATION
from rolling.report import citation
from rolling.report import page as report
from rolling.report.page import Exhibit

# Told apart by sign and word, not by colour alone.
SIGNS = {"reproduced": "✓", "partly": "◐", "not": "✗", "undecided": "?", "not run": "○"}
_HEADINGS = {
    "fig1_surfaces": "Fig. 1: surfaces",
    "fig5_contact_pressure": "Fig. 5: contact pressure",
    "fig6_deflection": "Fig. 6: deflection",
    "fig7_plastic_ratio": "Fig. 7: plastic ratio against load",
    "fig8_spectra": "Fig. 8: A-weighted spectra",
    "fig9_maximum_level": "Fig. 9: maximum A-weighted level against load",
    "correlation_length": "Correlation length, the article's outlook",
}


@dataclass(frozen=True)
class Verdict:
    """What a reading makes of a claim; scale is `10 lg`, `20 lg` or empty where no level is judged.

    decided_by : what decides an undecided verdict; else empty.
    """

    scale: str
    word: str
    measured: str
    decided_by: str = ""

    @property
    def sign(self) -> str:
        return SIGNS.get(self.word, "")

    @property
    def style(self) -> str:
        """Class on the page."""
        return self.word.replace(" ", "-") if self.word in SIGNS else "not-run"


@dataclass(frozen=True)
class Row:
    """A claim with the verdicts of each reading, in the order of the page; none where there is nothing to judge."""

    where: str
    statement: str
    tolerance: str
    caution: str
    verdicts: list[list[Verdict]]


@dataclass(frozen=True)
class Shelf:
    """A figure of the article, by the readings that have it."""

    heading: str
    exhibits: list[tuple[str, Exhibit]]


def ordered(names: Iterable[str], table: Mapping[str, Any]) -> list[str]:
    """Sort names of readings: readings first, then variations and what sweeps something else."""
    kinds = [READING, VARIATION, SWEEP]
    return sorted(names, key=lambda name: kinds.index(table["readings"].get(name, {}).get("kind", SWEEP)))


def page(readings: Sequence[str], table: Mapping[str, Any], pictures: Mapping[str, Sequence[Picture]]) -> bytes:
    """The page of a study.

    Parameters
    ----------
    readings : their names, in the order of the columns.
    table : `claims`, each with key, where, statement, tolerance and `findings` (reading, scale, verdict, measured);
        `scores` (reading, scale, least, most and, where given, counts), highest first; `readings`, with the `kind` of each,
        `what` it takes for granted, how it `departs` from the article and what it `lacks`; `standing`. What is missing is
        left out.
    pictures : of each reading, as `figures.gallery` gives them; readings without any have no column.
    """
    rows = [_row(claim, readings) for claim in table.get("claims", [])]
    html = (
        report.environment()
        .get_template("article.html")
        .render(
            readings=list(readings),
            rows=rows,
            signs=SIGNS,
            scores=[_score(one, table) for one in table.get("scores", [])],
            headline=claims_text.headline(table) if "standing" in table else "",
            kinds={name: table.get("readings", {}).get(name, {}).get("kind", READING) for name in readings},
            departs=dict(_of_each(table, readings, "departs")),
            what=_of_each(table, readings, "what"),
            lacks=_of_each(table, readings, "lacks"),
            shelves=_shelves(readings, pictures),
            citation=citation,
            css=report.own_text("report.css"),
        )
    )
    return html.encode()


def _row(claim: Mapping[str, Any], readings: Sequence[str]) -> Row:
    findings = claim.get("findings", [])
    return Row(
        str(claim.get("where", "")),
        str(claim.get("statement", claim.get("key", ""))),
        str(claim.get("tolerance", "")),
        str(claim.get("caution", "")),
        [[_verdict(one) for one in findings if one.get("reading") == name] for name in readings],
    )


def _verdict(finding: Mapping[str, Any]) -> Verdict:
    return Verdict(
        _scale(finding.get("scale")),
        str(finding.get("verdict", "not run")),
        str(finding.get("measured") or ""),
        str(finding.get("decided_by") or ""),
    )


def _scale(scale: object) -> str:
    return f"{scale} lg" if scale else ""


def _score(one: Mapping[str, Any], table: Mapping[str, Any]) -> dict[str, Any]:
    counts = {word: one["counts"].get(word, 0) for word in SIGNS} if "counts" in one else {}
    name = one.get("reading", "")
    return {
        "reading": name,
        "kind": table.get("readings", {}).get(name, {}).get("kind", READING),
        "scale": _scale(one.get("scale")),
        "score": " to ".join(dict.fromkeys(f"{one[end]:g}" for end in ("least", "most") if end in one)),
        "counts": counts,
    }


def _of_each(table: Mapping[str, Any], readings: Sequence[str], key: str) -> list[tuple[str, str]]:
    """What the table says of each reading under a key, in words; without those of which it says nothing."""
    found = [(name, table.get("readings", {}).get(name, {}).get(key) or "") for name in readings]
    return [(name, said if isinstance(said, str) else ", ".join(said)) for name, said in found if said]


def _shelves(readings: Sequence[str], pictures: Mapping[str, Sequence[Picture]]) -> list[Shelf]:
    named = [(name, picture) for name in readings for picture in pictures.get(name, [])]
    order = [*_HEADINGS, *(picture.name for _, picture in named)]
    shelves = []
    for kind in dict.fromkeys(order):
        exhibits = [(name, report.exhibit(picture)) for name, picture in named if picture.name == kind]
        if exhibits:
            shelves.append(Shelf(_HEADINGS.get(kind, kind), exhibits))
    return shelves
