"""The verdicts of all readings taken together, and a score for each reading.

A statement stands if every reading gives the same verdict. No reading is named as the best unless
it leads by `LEAD` statements.
"""

from __future__ import annotations

from collections.abc import Sequence

from rolling.lee2025.checks import NOT, NOT_RUN, PARTLY, REPRODUCED, UNDECIDED, Finding
from rolling.lee2025.results import JudgedClaim, Score, Standing

WORTH = {REPRODUCED: 1.0, PARTLY: 0.5, NOT: 0.0}
WORDS = (REPRODUCED, PARTLY, NOT, UNDECIDED, NOT_RUN)
# number of statements by which the best reading must lead, whatever the undecided verdicts become
LEAD = 2.0


def standing(claims: Sequence[JudgedClaim], readings: Sequence[str]) -> Standing:
    """Sort the keys of all claims by their verdicts in these readings, with either scale."""
    sorted_keys = Standing()
    agreed = {REPRODUCED: sorted_keys.every, PARTLY: sorted_keys.part, NOT: sorted_keys.none}
    for judged in claims:
        verdicts = {
            judgement.finding.verdict
            for judgement in judged.judgements
            if judgement.reading in readings
        } - {NOT_RUN}
        firm = verdicts - {UNDECIDED}
        if not verdicts:
            keys = sorted_keys.not_run
        elif len(firm) > 1:
            keys = sorted_keys.differs
        elif UNDECIDED in verdicts:
            keys = sorted_keys.undecided
        else:
            keys = agreed[firm.pop()]
        keys.append(judged.claim.key)
    return sorted_keys


def scores(
    claims: Sequence[JudgedClaim], readings: Sequence[str], scales: Sequence[int]
) -> list[Score]:
    """Score each reading with each scale, highest first; the outlook does not count.

    A reproduced statement counts 1, a partly reproduced one 0.5. An undecided verdict counts with
    both of its ends.
    """
    table = []
    for reading in readings:
        for scale in scales:
            findings = [
                next(each.finding for each in judged.of(reading) if each.scale in (None, scale))
                for judged in claims
                if not judged.outlook
            ]
            ends = [_worth(finding) for finding in findings]
            verdicts = [finding.verdict for finding in findings]
            table.append(
                Score(
                    reading=reading,
                    scale=scale,
                    least=sum(least for least, _ in ends),
                    most=sum(most for _, most in ends),
                    counts={word: verdicts.count(word) for word in WORDS},
                    judged=len(verdicts) - verdicts.count(NOT_RUN),
                )
            )
    return sorted(table, key=lambda score: -score.least - score.most)


def leader(table: Sequence[Score]) -> Score | None:
    """Return the score that leads all other readings by `LEAD` statements or more, if any does."""
    for score in table:
        others = [other for other in table if other.reading != score.reading]
        if others and all(score.least - other.most >= LEAD for other in others):
            return score
    return None


def _worth(finding: Finding) -> tuple[float, float]:
    """Return the lowest and the highest worth of a verdict."""
    if finding.between:
        least, most = finding.between
        return WORTH[least], WORTH[most]
    return (WORTH.get(finding.verdict, 0.0),) * 2
