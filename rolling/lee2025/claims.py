"""Judge the statements of Lee, Kim & Kim (2025) by the cases of a study, under each reading."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rolling.lee2025 import grid_error, standing
from rolling.lee2025.checks import NOT_RUN, Finding
from rolling.lee2025.grid_error import GridError
from rolling.lee2025.measures import Cases, newton, ra
from rolling.lee2025.results import (
    READING,
    SWEEP,
    VARIATION,
    Extent,
    JudgedClaim,
    Judgement,
    Score,
    Table,
)
from rolling.lee2025.statements import CLAIMS, LOADS, OUTLOOK, ROUGHNESSES, SCALES, Claim
from rolling.lee2025.study import Case


def table(
    cases: Sequence[Case],
    assumptions: Mapping[str, str] | None = None,
    departures: Mapping[str, Sequence[str]] | None = None,
) -> Table:
    """Judge all statements under all readings and variations.

    Parameters
    ----------
    cases : sequence of Case. The cases of all readings. A reading whose cases have no hardness
        holds twins.
    assumptions : mapping from str to str. The choices that each reading takes for granted, in
        words. Default: none.
    departures : mapping from str to sequence of str. Differences of each reading from the article's
        statements; a reading with any is a variation. Default: none.
    """
    judged, without, elastic = _groups(cases)
    claims = tuple(
        JudgedClaim(claim, tuple(_judgements(claim, judged, without)), claim in OUTLOOK)
        for claim in (*CLAIMS, *OUTLOOK)
    )
    readings = {
        name: _extent(
            Cases(group), (assumptions or {}).get(name, ""), tuple((departures or {}).get(name, ()))
        )
        for name, group in judged.items()
    }
    made = Table(readings, elastic, claims)
    scores: list[Score] = []
    for kind in (READING, VARIATION):
        scores += standing.scores(claims, made.of_kind(kind), SCALES)
    return Table(
        readings,
        elastic,
        claims,
        standing.standing(claims, made.of_kind(READING)),
        tuple(scores),
    )


def _names(cases: Sequence[Case]) -> list[str]:
    """Return the names of all readings in the order in which they come."""
    return list(dict.fromkeys(case.reading for case in cases))


def _groups(
    cases: Sequence[Case],
) -> tuple[dict[str, tuple[Case, ...]], tuple[Case, ...], tuple[str, ...]]:
    """Return the cases of each reading, all twins, and the names of the twins' scenes."""
    groups = {name: tuple(case for case in cases if case.reading == name) for name in _names(cases)}
    elastic = tuple(
        name for name, group in groups.items() if all(case.hardness_gpa is None for case in group)
    )
    without = tuple(case for name in elastic for case in groups[name])
    return {name: group for name, group in groups.items() if name not in elastic}, without, elastic


def study_of(cases: Sequence[Case], judgement: Judgement, grid: GridError) -> Cases:
    """Return the cases that a judgement stands on, with an error of their grid."""
    judged, without, _ = _groups(cases)
    return Cases(judged[judgement.reading], judgement.scale or SCALES[0], without, grid)


def _judgements(
    claim: Claim, judged: Mapping[str, tuple[Case, ...]], twins: tuple[Case, ...]
) -> list[Judgement]:
    """Judge a claim under all readings, and for each scale of levels if it concerns levels."""
    return [
        Judgement(
            name,
            scale if claim.level else None,
            finding(
                claim, Cases(group, scale, twins, grid_error.MEASURED.get(name, grid_error.NONE))
            ),
        )
        for name, group in judged.items()
        for scale in (SCALES if claim.level else SCALES[:1])
    ]


def finding(claim: Claim, study: Cases) -> Finding:
    """Judge a claim by the cases of a reading.

    A sweep judges only the claims about its own variable.
    """
    if claim.varied == _swept(study):
        return claim.judge(study)
    return Finding(
        NOT_RUN,
        "this reading does not vary it" if claim.varied else "this reading varies something else",
    )


def _swept(study: Cases) -> str | None:
    """Return the field that a reading varies besides roughness and load.

    Such a reading serves for claims about that field alone.
    """
    fields = (claim.varied for claim in OUTLOOK if claim.varied)
    return next((name for name in fields if len(study.values(name)) > 1), None)


def _extent(study: Cases, assumptions: str, departs: tuple[str, ...]) -> Extent:
    """Compare the cases of a reading with the roughnesses, loads and cases of the article."""
    swept = _swept(study)
    lacks: list[str] = []
    if swept is None:
        lacks = [ra(roughness) for roughness in ROUGHNESSES if roughness not in study.roughnesses]
        lacks += [newton(load) for load in LOADS if load not in study.loads]
        roughnesses = [roughness for roughness in ROUGHNESSES if roughness in study.roughnesses]
        pairs = [
            (roughness, load) for roughness in roughnesses for load in LOADS if load in study.loads
        ]
        lacks += [
            f"{ra(roughness)} at {newton(load)}"
            for roughness, load in pairs
            if not study.at(roughness, load)
        ]
    return Extent(
        kind=SWEEP if swept else VARIATION if departs else READING,
        assumptions=assumptions,
        departs=departs,
        cases=len(study.cases),
        roughnesses_um=tuple(study.roughnesses),
        loads_n=tuple(study.loads),
        surfaces=len({case.seed for case in study.cases}),
        durations_s=tuple(study.values("duration_s")),
        swept=swept,
        lacks=tuple(lacks),
    )
