"""The readings of the article side by side on an HTML page that needs no network.

The claims come first, then a row for each figure with a column for each reading. The template is
`report/assets/article.html`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from rolling.figures.picture import Picture
from rolling.lee2025 import claims_text
from rolling.lee2025.results import READING, SWEEP, VARIATION, JudgedClaim, Judgement, Score, Table
from rolling.report import citation, templates
from rolling.report import page as report
from rolling.report.page import Exhibit

# Sign and word distinguish verdicts, not colour alone.
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
    """A verdict as a cell of the page shows it.

    Parameters
    ----------
    scale : str. "10 lg", "20 lg", or empty where no level is judged.
    word : str. The verdict.
    measured : str. The measured numbers, in words.
    decided_by : str. The cause of an undecided verdict. Default: empty.
    turns : bool. True if the verdict is another at half the spacing. Default: False.
    """

    scale: str
    word: str
    measured: str
    decided_by: str = ""
    turns: bool = False

    @property
    def sign(self) -> str:
        """The sign before the word."""
        return SIGNS.get(self.word, "")

    @property
    def style(self) -> str:
        """The class of the element on the page."""
        return self.word.replace(" ", "-") if self.word in SIGNS else "not-run"


@dataclass(frozen=True)
class Row:
    """A claim with the verdicts of each reading in the order of the columns."""

    where: str
    statement: str
    tolerance: str
    caution: str
    verdicts: list[list[Verdict]]


@dataclass(frozen=True)
class ScoreRow:
    """A line of the table of scores, in words; counts are empty if they are unknown."""

    reading: str
    kind: str
    scale: str
    score: str
    counts: dict[str, int]


@dataclass(frozen=True)
class Shelf:
    """A figure of the article, by the readings that have it."""

    heading: str
    exhibits: list[tuple[str, Exhibit]]


def ordered(names: Iterable[str], table: Table) -> list[str]:
    """Sort names of readings: readings first, then variations, then sweeps."""
    kinds = [READING, VARIATION, SWEEP]
    return sorted(names, key=lambda name: kinds.index(table.kind(name, SWEEP)))


def page(readings: Sequence[str], table: Table, pictures: Mapping[str, Sequence[Picture]]) -> bytes:
    """Render the page of a study.

    Parameters
    ----------
    readings : sequence of str. Names in the order of the columns.
    table : Table. The judged claims. Empty parts are left out of the page.
    pictures : mapping from str to sequence of Picture. The figures of each reading, as
        `figures.gallery` gives them. A reading without figures has no column among them.
    """
    extents = {name: table.readings[name] for name in readings if name in table.readings}
    rows = [_row(judged, readings) for judged in table.claims]
    html = (
        templates.environment()
        .get_template("article.html")
        .render(
            readings=list(readings),
            rows=rows,
            signs=SIGNS,
            mark=claims_text.TURNS,
            turned=any(
                verdict.turns for row in rows for verdicts in row.verdicts for verdict in verdicts
            ),
            scores=[_score(score, table) for score in table.scores],
            headline=claims_text.headline(table) if table.standing else "",
            kinds={name: table.kind(name) for name in readings},
            departs={
                name: ", ".join(extent.departs)
                for name, extent in extents.items()
                if extent.departs
            },
            assumptions=[
                (name, extent.assumptions) for name, extent in extents.items() if extent.assumptions
            ],
            lacks=[
                (name, ", ".join(extent.lacks)) for name, extent in extents.items() if extent.lacks
            ],
            shelves=_shelves(readings, pictures),
            citation=citation,
            css=templates.own_text("report.css"),
        )
    )
    return html.encode()


def _row(judged: JudgedClaim, readings: Sequence[str]) -> Row:
    """Return the row of a claim."""
    claim = judged.claim
    verdicts = [[_verdict(judgement) for judgement in judged.of(name)] for name in readings]
    return Row(claim.where, claim.statement, claim.tolerance, claim.caution, verdicts)


def _verdict(judgement: Judgement) -> Verdict:
    """Return the cell of a judgement."""
    finding = judgement.finding
    scale = f"{judgement.scale} lg" if judgement.scale else ""
    turns = finding.finer is not None and finding.finer.turns
    return Verdict(scale, finding.verdict, finding.measured, finding.decided_by, turns)


def _score(score: Score, table: Table) -> ScoreRow:
    """Return the row of a score."""
    counts = {word: score.counts.get(word, 0) for word in SIGNS} if score.counts else {}
    return ScoreRow(
        score.reading, table.kind(score.reading), f"{score.scale} lg", score.range, counts
    )


def _shelves(readings: Sequence[str], pictures: Mapping[str, Sequence[Picture]]) -> list[Shelf]:
    """Sort the figures of all readings by kind, in the order of the article."""
    named = [(name, picture) for name in readings for picture in pictures.get(name, [])]
    order = [*_HEADINGS, *(picture.name for _, picture in named)]
    shelves = []
    for kind in dict.fromkeys(order):
        exhibits = [
            (name, report.exhibit(picture)) for name, picture in named if picture.name == kind
        ]
        if exhibits:
            shelves.append(Shelf(_HEADINGS.get(kind, kind), exhibits))
    return shelves
