"""Claims of the article: on cases made by hand, of which the verdict is known, and in each of the
ways it can come out.
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from acoustics.bands import MID_HZ
from acoustics.spectrum import article_line_level_db
from rolling.lee2025 import bounds, claims, claims_text, grid_error, measures, standing
from rolling.lee2025.checks import (
    GRID,
    NOT,
    NOT_RUN,
    PARTLY,
    RECORD,
    REPRODUCED,
    SURFACES,
    UNDECIDED,
)
from rolling.lee2025.grid_error import GridError
from rolling.lee2025.measures import CENTROID
from rolling.lee2025.statements import CLAIMS, LOADS, OUTLOOK, ROUGHNESSES, Claim
from rolling.lee2025.study import Case

LINE_HZ = np.geomspace(100.0, 18000.0, 40)
# of the greatest line at Ra 0.01 um and 5 N: with 0.05 s, records of half a second still pass 70 dB
SMOOTH_DB = 72.0
ABOVE_SMOOTH = {0.01: 0.0, 0.1: 11.0, 1.0: 12.0, 5.0: 12.5}  # dB at all loads
OVER_5_N = {5.0: 0.0, 10.0: 2.0, 20.0: 4.0, 50.0: 13.0, 100.0: 14.0}
PLASTIC = {0.01: 0.0, 0.1: 0.2, 1.0: 0.3, 5.0: 0.31}

Change = Callable[[Case], dict[str, Any]]


def as_the_article_says(
    roughness: float, load: float, seed: int = 1, reading: str = "article"
) -> Case:
    """A case of a study in which each statement about roughness and load holds, with 10 lg."""
    level = SMOOTH_DB + ABOVE_SMOOTH[roughness] + OVER_5_N[load]
    if roughness == 1.0 and load < 100:
        level += 1.0
    audible = SMOOTH_DB + ABOVE_SMOOTH[roughness] + OVER_5_N[load]
    return Case(
        reading=reading,
        roughness_um=roughness,
        load_n=load,
        seed=seed,
        correlation_um=10.0,
        hardness_gpa=2.1,
        bodies="article",
        nodes_across=256,
        duration_s=0.05,
        plastic_ratio=PLASTIC[roughness] * (1.0 + load / 200.0),
        contact_ratio=0.9,
        max_pressure=2.1e9 if roughness > 0.01 else 0.4e9 * load ** (1 / 3),
        deflection=(0.2e-6 - 0.02e-6 * roughness) * load,
        laeq_db=audible,
        laeq_uncertainty_db=0.4,
        weighted_uncertainty_db=0.8,
        maximum_db=level,
        maximum_20_db=2 * level,
        line_hz=LINE_HZ,
        line_db=level - np.abs(np.log2(LINE_HZ / 1000.0)),
        band_w=np.full(31, 1e-5),
        a_weighted_w=1e-11 * 10 ** (audible / 10),
    )


def twin(case: Case) -> Case:
    """The same without hardness: 3 dB quieter, deflected a tenth more."""
    return dataclasses.replace(
        case,
        reading="elastic",
        hardness_gpa=None,
        plastic_ratio=0.0,
        deflection=1.1 * case.deflection,
        band_w=case.band_w / 2,
        **louder(lambda c: -3.0)(case),
    )


def twins(cases: Sequence[Case]) -> list[Case]:
    return [
        twin(case)
        for case in cases
        if case.roughness_um in (0.1, 1.0) and case.load_n in (5.0, 20.0, 100.0)
    ]


def study(
    seeds: int = 1, loads: Sequence[float] = LOADS, changed: Change | None = None
) -> list[Case]:
    found = [
        as_the_article_says(ra, load, seed + 1)
        for ra in ROUGHNESSES
        for load in loads
        for seed in range(seeds)
    ]
    without = twins(found)
    return (
        [dataclasses.replace(case, **changed(case)) for case in found] + without
        if changed
        else found + without
    )


def finding(key: str, cases: Sequence[Case], factor: int = 10) -> dict[str, Any]:
    claim = next(row for row in claims.table(cases).to_dict()["claims"] if row["key"] == key)
    return next(one for one in claim["findings"] if one["scale"] in (None, factor))


def verdict(key: str, cases: Sequence[Case], factor: int = 10) -> str:
    return finding(key, cases, factor)["verdict"]


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.key)
@pytest.mark.parametrize("seeds", [1, 3])
def test_a_study_as_the_article_says_reproduces_it(claim: Claim, seeds: int) -> None:
    assert verdict(claim.key, study(seeds)) == REPRODUCED


def louder(by: Callable[[Case], float]) -> Change:
    """All levels and curves of a case higher by so many dB."""

    def changed(case: Case) -> dict[str, Any]:
        db = by(case)
        return {
            "maximum_db": case.maximum_db + db,
            "maximum_20_db": case.maximum_20_db + 2 * db,
            "line_db": case.line_db + db,
            "laeq_db": None if case.laeq_db is None else case.laeq_db + db,
            "a_weighted_w": case.a_weighted_w * 10 ** (db / 10),
        }

    return changed


def put(name: str, value: Callable[[Case], float]) -> Change:
    return lambda case: {name: value(case)}


def when(holds: Callable[[Case], bool], changed: Change) -> Change:
    return lambda case: changed(case) if holds(case) else {}


def on(roughness: float) -> Callable[[Case], bool]:
    return lambda case: case.roughness_um == roughness


def against_trend(case: Case) -> float:
    """As much as the load adds, and 1 dB per doubling more."""
    return -OVER_5_N[case.load_n] - math.log2(case.load_n)


def by_load(values: Sequence[float]) -> Change:
    """Levels at SMOOTH_DB and so much more at each load."""
    return louder(
        lambda case: (
            SMOOTH_DB + dict(zip(LOADS, values, strict=True))[case.load_n] - case.maximum_db
        )
    )


def as_quiet_as_the_twin(case: Case) -> dict[str, Any]:
    return {**louder(lambda c: -3.0)(case), "band_w": case.band_w / 2}


FALLING_PLASTIC = put("plastic_ratio", lambda case: 0.3 / case.load_n)
# What is changed of the study in which a statement holds, so that it holds in part, and so that it
# does not hold.
OTHERWISE: dict[str, tuple[Change, Change]] = {
    "pressure-below-limit": (
        when(lambda c: c.load_n > 20, put("max_pressure", lambda c: 2.1e9)),
        put("max_pressure", lambda c: 4.9e9),
    ),
    "pressure-load": (
        when(lambda c: c.load_n > 20, put("max_pressure", lambda c: 2.1e9)),
        put("max_pressure", lambda c: 2.1e9),
    ),
    "contact-area-load": (
        when(lambda c: c.load_n == 10, put("contact_ratio", lambda c: 0.1)),
        put("contact_ratio", lambda c: 1 / c.load_n),
    ),
    "plastic-none": (
        when(lambda c: c.load_n > 20, put("plastic_ratio", lambda c: 0.1)),
        put("plastic_ratio", lambda c: 0.01),
    ),
    "hardness-reached": (
        when(lambda c: c.load_n == 5, put("plastic_ratio", lambda c: 0.0)),
        put("plastic_ratio", lambda c: 0.0),
    ),
    "plastic-area-load": (when(on(5.0), FALLING_PLASTIC), FALLING_PLASTIC),
    "plastic-area-roughness": (
        when(on(5.0), put("plastic_ratio", lambda c: 0.2)),
        put("plastic_ratio", lambda c: 0.5 - 0.1 * c.roughness_um),
    ),
    "plastic-ratio-load": (when(on(1.0), FALLING_PLASTIC), FALLING_PLASTIC),
    "plastic-ratio-1-over-0.1": (
        when(lambda c: c.roughness_um == 1 and c.load_n > 20, put("plastic_ratio", lambda c: 0.25)),
        when(on(1.0), put("plastic_ratio", lambda c: 0.55)),
    ),
    "plastic-ratio-5-like-1": (
        when(lambda c: c.roughness_um == 5 and c.load_n > 20, put("plastic_ratio", lambda c: 0.25)),
        when(on(5.0), put("plastic_ratio", lambda c: 0.6)),
    ),
    "deflection-roughest": (
        when(lambda c: c.roughness_um == 5 and c.load_n > 20, put("deflection", lambda c: 1e-4)),
        when(on(5.0), put("deflection", lambda c: 1e-4)),
    ),
    "deflection-roughness": (
        when(on(5.0), put("deflection", lambda c: 1e-4)),
        put("deflection", lambda c: 1e-6 * c.roughness_um),
    ),
    "yielding-deflection": (
        when(on(1.0), put("deflection", lambda c: 1e-4)),
        put("deflection", lambda c: 1e-4),
    ),
    "yielding-noise": (
        when(on(1.0), lambda c: as_quiet_as_the_twin(c)),
        lambda c: as_quiet_as_the_twin(c),
    ),
    "level-roughness": (
        when(on(5.0), louder(lambda c: -3.0)),
        louder(lambda c: -2 * ABOVE_SMOOTH[c.roughness_um]),
    ),
    "level-load": (when(on(0.1), louder(against_trend)), louder(against_trend)),
    "level-above-70": (when(on(5.0), louder(lambda c: -45.0)), louder(lambda c: -45.0)),
    # 6 dB but not apart from the rest; apart from the rest but less than 6 dB; neither
    "high-frequency-gap": (by_load([0, 6, 12, 19, 26]), by_load([0, 3, 6, 9, 12])),
    "maximum-over-smooth": (
        when(on(0.1), louder(lambda c: -4.0)),
        when(lambda c: c.roughness_um > 0.01, louder(lambda c: -6.0)),
    ),
    "maximum-load": (
        when(lambda c: c.roughness_um > 0.01 and c.load_n == 100, louder(lambda c: -5.0)),
        when(lambda c: c.load_n == 100, louder(lambda c: -5.0)),
    ),
    "maximum-flattens": (
        when(lambda c: c.roughness_um < 1 and c.load_n == 100, louder(lambda c: 3.0)),
        when(lambda c: c.load_n == 100, louder(lambda c: 3.0)),
    ),
    "loudest-20-50": (
        when(lambda c: c.roughness_um == 5 and c.load_n == 50, louder(lambda c: 2.0)),
        when(on(5.0), louder(lambda c: 2.0)),
    ),
    "loudest-100": (
        # two of three surfaces of Ra 0.1 um are much louder, one is not: no lead that is certain
        when(lambda c: c.roughness_um == 0.1, louder(lambda c: -4.0 if c.seed == 1 else 9.0)),
        when(on(0.1), louder(lambda c: 9.0)),
    ),
    "little-influence": (
        when(lambda c: c.roughness_um == 5 and c.load_n == 5, louder(lambda c: -8.0)),
        when(on(5.0), louder(lambda c: -8.0)),
    ),
}


@pytest.mark.parametrize("key", [claim.key for claim in CLAIMS])
def test_each_verdict_can_come_out(key: str) -> None:
    some, none = OTHERWISE[key]
    assert verdict(key, study(3, changed=some)) == PARTLY
    assert verdict(key, study(3, changed=none)) == NOT


def test_a_gap_that_is_apart_but_small_counts_in_part() -> None:
    cases = study(changed=by_load([0, 1, 2, 5, 6]))
    assert verdict("high-frequency-gap", cases) == PARTLY
    assert verdict("high-frequency-gap", cases, 20) == REPRODUCED  # twice 3 dB


def test_steps_are_certain_beyond_twice_their_standard_error() -> None:
    """Differences of 1, 1 and 4 dB of three surfaces: mean 2 dB, standard error 1 dB: at the limit;
    1, 1, 3.9 is beyond.
    """
    first = [as_the_article_says(0.1, 5.0, seed) for seed in (1, 2, 3)]

    def steps(*db: float) -> measures.Change | None:
        then = [
            dataclasses.replace(case, maximum_db=case.maximum_db + x)
            for case, x in zip(first, db, strict=True)
        ]
        return measures.change(measures.MAXIMUM, first, then, 10)

    inside, beyond, down = steps(1.0, 1.0, 4.1), steps(1.0, 1.0, 3.9), steps(-1.0, -1.0, -3.9)
    assert inside and beyond and down
    assert inside.mean == pytest.approx(6.1 / 3, rel=1e-9)  # rounding of levels about 70
    assert (inside.rises, beyond.rises, down.rises, down.falls) == (False, True, False, True)
    # no surface in common
    assert measures.change(measures.MAXIMUM, first[:1], first[1:], 10) is None


def test_20_lg_doubles_differences() -> None:
    assert (
        measures.MAXIMUM.of(as_the_article_says(1.0, 20.0), 20)
        == as_the_article_says(1.0, 20.0).maximum_20_db
    )
    over = finding("maximum-over-smooth", study(), 10)["numbers"]["values"]["Ra 0.1 µm"]
    twice = finding("maximum-over-smooth", study(), 20)["numbers"]["values"]["Ra 0.1 µm"]
    assert twice["mean"] == pytest.approx(2 * over["mean"], abs=1e-9)
    assert verdict("maximum-over-smooth", study(), 20) == NOT  # 22 dB and more
    assert verdict("maximum-load", study(), 20) == NOT
    assert verdict("level-above-70", study(), 20) == NOT_RUN
    assert "no absolute value" in finding("level-above-70", study(), 20)["measured"]


def test_measured_numbers_are_those_of_the_cases() -> None:
    """1.5 is 0.3 / 0.2, the levels above Ra 0.01 um and from 5 to 100 N are those put in."""
    ratios = finding("plastic-ratio-1-over-0.1", study())["numbers"]["values"]
    assert list(ratios) == ["5 N", "10 N", "20 N", "50 N", "100 N"]
    assert list(ratios.values()) == pytest.approx([1.5] * 5, rel=1e-12)  # rounding
    over = finding("maximum-over-smooth", study())["numbers"]["values"]
    # Ra 1 um: 13 dB at four loads, 12 dB at 100 N
    assert [over[f"Ra {ra} µm"]["mean"] for ra in ("0.1", "1", "5")] == pytest.approx(
        [11.0, 12.8, 12.5], abs=1e-9
    )
    rise = finding("maximum-load", study())["numbers"]["values"]["5 N to 100 N"]
    assert rise["mean"] == pytest.approx((14 + 14 + 13 + 14) / 4, abs=1e-9)


def test_what_was_not_run_is_not_judged() -> None:
    """Three loads of five and one surface: what needs 50 N is not run, what names it besides others
    says it lacks it.
    """
    cases = study(loads=(5.0, 20.0, 100.0))
    assert {key for key in OTHERWISE if verdict(key, cases) == NOT_RUN} == {
        "high-frequency-gap",
        "maximum-flattens",
    }
    assert finding("loudest-20-50", cases)["numbers"]["missing"] == ["50 N"]
    assert claims.table(cases).readings["article"].lacks == ("10 N", "50 N")
    assert "Lacks 10 N, 50 N" in claims_text.markdown(claims.table(cases))
    assert "reproduced\\*" in claims_text.markdown(claims.table(cases))


@pytest.mark.parametrize(
    "case",
    [one for one in study() if one.hardness_gpa],
    ids=lambda case: f"{case.roughness_um:g}-{case.load_n:g}",
)
def test_one_case_or_all_but_one(case: Case) -> None:
    """Neither breaks a judge; a single case shows no change, and all but one still reproduce
    nothing wrongly.
    """
    alone = claims.table([case])
    words = {row.claim.key: row.judgements[0].finding.verdict for row in alone.claims}
    assert {
        words[key] for key in ("level-load", "level-roughness", "maximum-load", "little-influence")
    } == {NOT_RUN}
    rest = claims.table(
        [
            one
            for one in study()
            if (one.roughness_um, one.load_n) != (case.roughness_um, case.load_n)
        ]
    )
    assert {row.judgements[0].finding.verdict for row in rest.claims} <= {REPRODUCED, NOT_RUN}
    assert rest.readings["article"].lacks == (f"Ra {case.roughness_um:g} µm at {case.load_n:g} N",)
    for table in (alone, rest):
        assert json.dumps(table.to_dict(), allow_nan=False) and claims_text.markdown(table)


def test_no_cases() -> None:
    table = claims.table([])
    assert table.scores == ()
    assert len(table.claims) == len(CLAIMS) + len(OUTLOOK)
    assert "No reading was run that could be judged." in claims_text.markdown(table)


def test_silent_cases_are_none_and_not_numbers() -> None:
    """Cases without sound, snapshot or plastic area put no NaN or infinity into the table."""

    def silent(case: Case) -> dict[str, Any]:
        return {
            "plastic_ratio": 0.0,
            "deflection": math.nan,
            "laeq_db": None,
            "maximum_db": -math.inf,
            "maximum_20_db": -math.inf,
            "line_db": np.full(len(LINE_HZ), -math.inf),
            "band_w": np.full(31, math.nan),
            "a_weighted_w": math.nan,
        }

    table = claims.table(study(3, changed=silent))
    plain = table.to_dict()
    levels = {claim.key for claim in (*CLAIMS, *OUTLOOK) if claim.level}
    levels |= {"deflection-roughest", "deflection-roughness", "yielding-deflection"}
    assert all(
        one["verdict"] == NOT_RUN
        for row in plain["claims"]
        if row["key"] in levels
        for one in row["findings"]
    )
    assert json.loads(json.dumps(plain, allow_nan=False)) == plain
    assert "nan" not in claims_text.markdown(table) and "inf " not in claims_text.markdown(table)


# ---- the outlook: autocorrelation length


def lengths(mid_hz: Sequence[float], levels_db: Sequence[float]) -> list[Case]:
    """Tones in one third octave each, of lengths 2, 5, 10, ... um."""
    found = []
    for length, hz, db in zip((2.0, 5.0, 10.0, 20.0, 40.0), mid_hz, levels_db, strict=True):
        band = np.where(np.isclose(MID_HZ, hz, rtol=0.05), 1e-4, np.nan)
        case = as_the_article_says(0.1, 20.0, reading="correlation-length")
        weighted = 1e-11 * 10 ** (db / 10)
        found.append(
            dataclasses.replace(
                case, correlation_um=length, band_w=band, laeq_db=db, a_weighted_w=weighted
            )
        )
    return found


@pytest.mark.parametrize(
    ("values", "expected"),
    [((5, 4, 3, 2, 1), REPRODUCED), ((5, 6, 3, 2, 1), PARTLY), ((1, 2, 3, 4, 5), NOT)],
)
def test_lengths(values: Sequence[float], expected: str) -> None:
    """A centroid is the frequency of its only band, so it falls as that does; the level as that put
    in.
    """
    cases = lengths(
        [1000.0 * value for value in (1, 1, 1, 1, 1)], [60.0 + value for value in values]
    )
    assert verdict("length-level", cases) == verdict("length-level", cases, 20) == expected
    cases = lengths(
        [{1: 1000, 2: 2000, 3: 3150, 4: 4000, 5: 5000, 6: 6300}[int(value)] for value in values],
        [60.0] * 5,
    )
    assert verdict("length-frequency", cases) == expected
    assert CENTROID.of(cases[2], 10) == pytest.approx(10**3.5, rel=1e-12)  # 3150 Hz, exact


def test_a_sweep_is_about_its_own_rows_only() -> None:
    cases = [*study(), *lengths([4000.0] * 5, [60.0] * 5)]
    table = claims.table(cases)
    for row in table.claims:
        words = {one.reading: one.finding.verdict for one in row.judgements}
        swept = row.claim.key.startswith("length-")
        assert words["article" if swept else "correlation-length"] == NOT_RUN
        assert (
            words["correlation-length" if swept else "article"] != NOT_RUN
            or row.claim.key == "level-above-70"
        )
    assert {one.reading for one in table.scores} == {"article"}
    kinds = {name: one.kind for name, one in table.readings.items()}
    assert kinds == {"article": "reading", "correlation-length": "sweep"} and table.twins == (
        "elastic",
    )


# ---- what decides a verdict besides the article


def with_grid(monkeypatch: pytest.MonkeyPatch, **ranges: Any) -> None:
    monkeypatch.setattr(grid_error, "MEASURED", {"article": GridError(**ranges)})


@pytest.mark.parametrize(
    ("fine", "expected"),
    [
        ((1.0, 1.1), REPRODUCED),  # 1.5 to 1.36: still within 1.3 to 1.7
        ((1.0, 1.3), UNDECIDED),  # 1.5 to 1.15
        ((0.8, 1.0), UNDECIDED),  # 1.5 to 1.88
    ],
)
def test_a_ratio_that_a_fine_grid_may_turn_is_undecided(
    monkeypatch: pytest.MonkeyPatch, fine: tuple[float, float], expected: str
) -> None:
    """The plastic ratio at Ra 0.1 um grows by these factors on a fine grid."""
    assert verdict("plastic-ratio-1-over-0.1", study()) == REPRODUCED
    with_grid(monkeypatch, plastic={0.1: {20: fine}})  # of one load: taken for all
    found = finding("plastic-ratio-1-over-0.1", study())
    assert found["verdict"] == expected
    if expected == UNDECIDED:
        assert found["decided_by"] == GRID and found["between"] == [NOT, REPRODUCED]
        assert (
            f"fine grid: {min(1.5, 1.5 / fine[1]):.2f} to {max(1.5, 1.5 / fine[0]):.2f}"
            in found["measured"]
        )
        assert f"{UNDECIDED} (the grid)" in claims_text.markdown(claims.table(study()))


def test_errors_of_loads_between_measured_ones_are_those_of_both() -> None:
    error = GridError(
        plastic={0.1: {5: (1.1, 1.6), 20: (1.0, 1.3)}}, level_db={1.0: {5: (-3.0, 0.1)}}
    )
    assert [error.factor("plastic", 0.1, w) for w in (1, 5, 10, 20, 100)] == [
        (1.1, 1.6), (1.1, 1.6), (1.0, 1.6), (1.0, 1.3), (1.0, 1.3)
    ]  # fmt: skip
    assert error.factor("plastic", 1.0, 5) == (1.0, 1.0) and error.factor("", 0.1, 5) == (1.0, 1.0)
    assert error.ratio("plastic", 1.0, 0.1, 5) == (1 / 1.6, 1.0)  # with the study's own grid in it
    assert error.shift_db("level_db", (1.0, 5), (0.1, 5), 20) == (-6.0, 0.2)
    assert error.shift_db("level_db", (0.1, 5), (1.0, 5), 10) == (-0.1, 3.0)


def test_a_failed_ratio_may_hold_on_a_fine_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    changed = when(on(1.0), put("plastic_ratio", lambda c: 0.38 * (1.0 + c.load_n / 200.0)))  # 1.9
    assert verdict("plastic-ratio-1-over-0.1", study(changed=changed)) == NOT
    with_grid(monkeypatch, plastic={0.1: {20: (1.0, 1.25)}})  # 1.9 to 1.52
    assert verdict("plastic-ratio-1-over-0.1", study(changed=changed)) == UNDECIDED
    with_grid(monkeypatch, plastic={0.1: {20: (1.0, 1.05)}})  # 1.9 to 1.81
    assert verdict("plastic-ratio-1-over-0.1", study(changed=changed)) == NOT


def test_steps_smaller_than_the_grids_error_are_undecided(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plastic area 0.30 to 0.31, deflection 0.18 to 0.1 per newton, levels by 0.5 dB from Ra 1 to 5
    um.
    """
    with_grid(
        monkeypatch,
        plastic={5: {5: (0.99, 1)}},
        deflection={5: {5: (1, 1.02)}},
        level_db={5: {5: (-0.4, 0)}},
    )
    keys = (
        "plastic-area-roughness",
        "deflection-roughness",
        "deflection-roughest",
        "level-roughness",
    )
    assert [verdict(key, study()) for key in keys] == [REPRODUCED] * 4
    with_grid(
        monkeypatch,
        plastic={5: {5: (0.96, 1)}},
        deflection={5: {5: (1, 1.9)}},
        level_db={5: {5: (-0.6, 0)}},
    )
    assert [verdict(key, study()) for key in keys] == [UNDECIDED] * 4
    assert verdict("level-roughness", study(), 20) == UNDECIDED  # both double
    assert finding("level-roughness", study())["between"] == [PARTLY, REPRODUCED]


def test_bounds_within_twice_the_standard_error_are_undecided() -> None:
    """Five surfaces, ratios 1.66 on average: with a spread of 0.1 the bound of 1.7 is no further
    than chance.
    """

    def spread(by: float) -> Change:
        return when(
            on(1.0),
            put("plastic_ratio", lambda c: (0.332 + by * (c.seed - 3)) * (1.0 + c.load_n / 200.0)),
        )

    assert verdict("plastic-ratio-1-over-0.1", study(5, changed=spread(0.0))) == REPRODUCED
    found = finding("plastic-ratio-1-over-0.1", study(5, changed=spread(0.02)))
    assert (found["verdict"], found["decided_by"]) == (UNDECIDED, SURFACES)


def test_level_above_70_turns_with_the_length_of_the_record() -> None:
    """A greatest line of 72 dB at 0.05 s falls to 70 at 10^(2/5) times that, 0.13 s; one of 76 dB
    at 16 times.
    """
    for above, expected in ((2.0, UNDECIDED), (-2.0, UNDECIDED), (6.0, REPRODUCED), (-6.0, NOT)):
        wanted = 70.0 + above
        cases = study(
            changed=lambda case, wanted=wanted: louder(lambda c: wanted - c.maximum_db)(case)
        )
        found = finding("level-above-70", cases)
        assert found["verdict"] == expected
        assert (
            f"turns at a record of {0.05 * 10 ** (above / 5):.2g} s instead of 0.05 s"
            in found["measured"]
        )
        assert found["decided_by"] == (RECORD if expected == UNDECIDED else "")


def test_lines_of_noise_fall_by_5_db_in_a_record_ten_times_as_long() -> None:
    """10 lg of an amplitude that goes with 1 / sqrt(T).

    The median of 3000 lines is known to 0.07 dB.
    """
    noise = np.random.default_rng(1).standard_normal(60000)
    short, long = (article_line_level_db(noise[:n], 48000, 1.0)[1][1:] for n in (6000, 60000))
    assert np.median(short) - np.median(long) == pytest.approx(bounds.LG_LENGTH_DB, abs=0.2)


# ---- twins without hardness


def test_without_twins_nothing_is_said_of_yielding() -> None:
    table = claims.table([case for case in study() if case.hardness_gpa])
    findings = [
        row.judgements[0].finding for row in table.claims if row.claim.key.startswith("yielding-")
    ]
    assert len(findings) == 3
    assert all(one.verdict == NOT_RUN and "no twin" in one.measured for one in findings)


def test_a_twin_is_the_same_scene_in_everything_but_hardness() -> None:
    cases = [case for case in study() if case.hardness_gpa]
    study_of = measures.Cases(tuple(cases), 10, tuple(twins(cases)))
    (case,) = study_of.at(0.1, 5.0)
    match = study_of.twin(case)
    assert match is not None and match.hardness_gpa is None
    for other in (
        {"bodies": "two bodies"},
        {"seed": 2},
        {"load_n": 10.0},
        {"duration_s": 0.5},
        {"correlation_um": 5.0},
    ):
        assert study_of.twin(dataclasses.replace(case, **other)) is None


def test_yielding_is_heard_by_the_level_or_by_the_bands(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 0.4 dB each the difference is uncertain by 0.57 dB: 1 dB is too little, unless a third of
    the bands differ.
    """

    def off(db: float, bands: int) -> list[Case]:
        """As loud as the twin and `db` more; so many of the ten third octaves from 500 Hz to 4 kHz
        6 dB above (10 lg).
        """
        reads = np.isin(np.arange(31), np.flatnonzero(MID_HZ > 450)[:bands])

        def changed(case: Case) -> dict[str, Any]:
            return {
                **louder(lambda c: db - 3.0)(case),
                "band_w": case.band_w / 2 * np.where(reads, 4.0, 1.0),
            }

        return study(changed=changed)

    expected = {
        (1.0, 0): NOT,
        (1.2, 0): REPRODUCED,
        (-1.2, 0): REPRODUCED,
        (0.0, 3): NOT,
        (0.0, 4): REPRODUCED,
    }
    for (db, bands), word in expected.items():
        assert verdict("yielding-noise", off(db, bands)) == word, (db, bands)
        assert verdict("yielding-noise", off(db, bands), 20) == word
    assert (
        verdict("yielding-louder", off(1.2, 0)) == REPRODUCED
        and verdict("yielding-louder", off(-1.2, 0)) == NOT
    )
    with_grid(monkeypatch, level_db={0.1: {5: (-0.2, 1.5)}, 1.0: {5: (-0.2, 1.5)}})
    assert finding("yielding-noise", off(1.2, 0))["decided_by"] == GRID
    assert verdict("yielding-noise", off(1.6, 0)) == REPRODUCED


# ---- what holds over the readings


def reading(name: str, cases: Sequence[Case]) -> list[Case]:
    return [
        dataclasses.replace(case, reading=name) if case.hardness_gpa else case for case in cases
    ]


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
    """Half a statement is no lead; two are, unless an undecided verdict could make up for it."""
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
    """A variation in which a statement fails leaves what the readings agree on as it is."""
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
    """It ends with tables.md of the whole study: a statement that is added or worded anew must be
    run.
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
