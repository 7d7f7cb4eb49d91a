"""Each claim of the article comes out as it must on cases made by hand."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from claim_cases import (
    LINE_HZ,
    OTHERWISE,
    as_the_article_says,
    by_load,
    finding,
    study,
    verdict,
)

from acoustics.bands import MID_HZ
from rolling.lee2025 import claims, claims_text, measures
from rolling.lee2025.checks import (
    NOT,
    NOT_RUN,
    PARTLY,
    REPRODUCED,
)
from rolling.lee2025.measures import CENTROID
from rolling.lee2025.statements import CLAIMS, OUTLOOK, Claim
from rolling.lee2025.study import Case


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.key)
@pytest.mark.parametrize("seeds", [1, 3])
def test_a_study_as_the_article_says_reproduces_it(claim: Claim, seeds: int) -> None:
    assert verdict(claim.key, study(seeds)) == REPRODUCED


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
    """Differences of 1, 1 and 4 dB have a mean of 2 dB and a standard error of 1 dB.

    They are at the limit, and 1, 1, 3.9 is beyond it.
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
    """The measured ratio is 1.5 = 0.3 / 0.2, and the measured levels are those of the cases."""
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
    """A claim that needs 50 N is not run, and a claim that also names it lists it as lacking.

    The study has three loads of five and a single surface.
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
    """A single case shows no change, and a study without one case reproduces nothing wrongly."""
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


def lengths(mid_hz: Sequence[float], levels_db: Sequence[float]) -> list[Case]:
    """Return tones in a third octave each, for lengths of 2, 5, 10, ... um."""
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
    """The centroid falls with the frequency of its only band, and the level as it was set."""
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
