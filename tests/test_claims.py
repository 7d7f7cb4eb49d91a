"""Claims of the article: on cases made by hand, of which the verdict is known, and in each of the ways it can come out."""

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
from rolling.article import claims, claims_text, measures
from rolling.article.claims import CLAIMS, LOADS, NOT, NOT_RUN, OUTLOOK, PARTLY, REPRODUCED, ROUGHNESSES
from rolling.article.study import Case

LINE_HZ = np.geomspace(100.0, 18000.0, 40)
ABOVE_SMOOTH = {0.01: 0.0, 0.1: 11.0, 1.0: 12.0, 5.0: 12.5}  # dB at all loads
OVER_5_N = {5.0: 0.0, 10.0: 2.0, 20.0: 4.0, 50.0: 13.0, 100.0: 14.0}
PLASTIC = {0.01: 0.0, 0.1: 0.2, 1.0: 0.3, 5.0: 0.31}

Change = Callable[[Case], dict[str, Any]]


def as_the_article_says(roughness: float, load: float, seed: int = 1, reading: str = "article") -> Case:
    """A case of a study in which each statement about roughness and load holds, with 10 lg."""
    level = 62.0 + ABOVE_SMOOTH[roughness] + OVER_5_N[load]
    if roughness == 1.0 and load < 100:
        level += 1.0
    audible = 62.0 + ABOVE_SMOOTH[roughness] + OVER_5_N[load]
    return Case(
        reading=reading,
        roughness_um=roughness,
        load_n=load,
        seed=seed,
        correlation_um=10.0,
        nodes_across=256,
        duration_s=0.05,
        plastic_ratio=PLASTIC[roughness] * (1.0 + load / 200.0),
        contact_ratio=0.9,
        max_pressure=2.1e9 if roughness > 0.01 else 0.4e9 * load ** (1 / 3),
        deflection=(0.2e-6 - 0.02e-6 * roughness) * load,
        laeq_db=audible,
        maximum_db=level,
        maximum_20_db=2 * level,
        line_hz=LINE_HZ,
        line_db=level - np.abs(np.log2(LINE_HZ / 1000.0)),
        band_w=np.full(31, 1e-5),
        a_weighted_w=1e-11 * 10 ** (audible / 10),
    )


def study(seeds: int = 1, loads: Sequence[float] = LOADS, changed: Change | None = None) -> list[Case]:
    found = [as_the_article_says(ra, load, seed + 1) for ra in ROUGHNESSES for load in loads for seed in range(seeds)]
    return [dataclasses.replace(case, **changed(case)) for case in found] if changed else found


def finding(key: str, cases: Sequence[Case], factor: int = 10) -> dict[str, Any]:
    claim = next(row for row in claims.table(cases)["claims"] if row["key"] == key)
    return next(one for one in claim["findings"] if one["scale"] in (None, factor))


def verdict(key: str, cases: Sequence[Case], factor: int = 10) -> str:
    return finding(key, cases, factor)["verdict"]


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.key)
@pytest.mark.parametrize("seeds", [1, 3])
def test_a_study_as_the_article_says_reproduces_it(claim: claims.Claim, seeds: int) -> None:
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
    """Levels at 62 dB and so much more at each load."""
    return louder(lambda case: 62.0 + dict(zip(LOADS, values, strict=True))[case.load_n] - case.maximum_db)


FALLING_PLASTIC = put("plastic_ratio", lambda case: 0.3 / case.load_n)
# What is changed of the study in which a statement holds, so that it holds in part, and so that it does not hold.
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
    "level-roughness": (
        when(on(5.0), louder(lambda c: -3.0)),
        louder(lambda c: -2 * ABOVE_SMOOTH[c.roughness_um]),
    ),
    "level-load": (when(on(0.1), louder(against_trend)), louder(against_trend)),
    "level-above-70": (when(on(5.0), louder(lambda c: -25.0)), louder(lambda c: -25.0)),
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
    """Differences of 1, 1 and 4 dB of three surfaces: mean 2 dB, standard error 1 dB: at the limit; 1, 1, 3.9 is beyond."""
    first = [as_the_article_says(0.1, 5.0, seed) for seed in (1, 2, 3)]

    def steps(*db: float) -> measures.Change | None:
        then = [dataclasses.replace(case, maximum_db=case.maximum_db + x) for case, x in zip(first, db, strict=True)]
        return measures.change(measures.MAXIMUM, first, then, 10)

    inside, beyond, down = steps(1.0, 1.0, 4.1), steps(1.0, 1.0, 3.9), steps(-1.0, -1.0, -3.9)
    assert inside and beyond and down
    assert inside.mean == pytest.approx(6.1 / 3, rel=1e-9)  # rounding of levels about 70
    assert (inside.rises, beyond.rises, down.rises, down.falls) == (False, True, False, True)
    assert measures.change(measures.MAXIMUM, first[:1], first[1:], 10) is None  # no surface in common


def test_20_lg_doubles_differences() -> None:
    assert measures.MAXIMUM.of(as_the_article_says(1.0, 20.0), 20) == as_the_article_says(1.0, 20.0).maximum_20_db
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
    assert [over[f"Ra {ra} µm"]["mean"] for ra in ("0.1", "1", "5")] == pytest.approx([11.0, 12.8, 12.5], abs=1e-9)
    rise = finding("maximum-load", study())["numbers"]["values"]["5 N to 100 N"]
    assert rise["mean"] == pytest.approx((14 + 14 + 13 + 14) / 4, abs=1e-9)


def test_what_was_not_run_is_not_judged() -> None:
    """Three loads of five and one surface: what needs 50 N is not run, what names it besides others says it lacks it."""
    cases = study(loads=(5.0, 20.0, 100.0))
    assert {key for key in OTHERWISE if verdict(key, cases) == NOT_RUN} == {"high-frequency-gap", "maximum-flattens"}
    assert finding("loudest-20-50", cases)["numbers"]["missing"] == ["50 N"]
    extent = claims.table(cases)["readings"]["article"]
    assert extent["lacks"] == ["10 N", "50 N"]
    assert "Lacks 10 N, 50 N" in claims_text.markdown(claims.table(cases))
    assert "reproduced\\*" in claims_text.markdown(claims.table(cases))


@pytest.mark.parametrize("case", study(), ids=lambda case: f"{case.roughness_um:g}-{case.load_n:g}")
def test_one_case_or_all_but_one(case: Case) -> None:
    """Neither breaks a judge; a single case shows no change, and all but one still reproduce nothing wrongly."""
    alone = claims.table([case])
    words = {row["key"]: row["findings"][0]["verdict"] for row in alone["claims"]}
    assert {words[key] for key in ("level-load", "level-roughness", "maximum-load", "little-influence")} == {NOT_RUN}
    rest = claims.table([one for one in study() if (one.roughness_um, one.load_n) != (case.roughness_um, case.load_n)])
    assert {row["findings"][0]["verdict"] for row in rest["claims"]} <= {REPRODUCED, NOT_RUN}
    assert rest["readings"]["article"]["lacks"] == [f"Ra {case.roughness_um:g} µm at {case.load_n:g} N"]
    for table in (alone, rest):
        assert claims_text.markdown(json.loads(json.dumps(table, allow_nan=False)))


def test_no_cases() -> None:
    table = claims.table([])
    assert table["scores"] == []
    assert len(table["claims"]) == len(CLAIMS) + len(OUTLOOK)
    assert "No reading" in claims_text.markdown(table)


def test_silent_cases_are_none_and_not_numbers() -> None:
    """No sound, no snapshot, no plastic area: nothing of it becomes NaN or infinite in the table."""

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
    text = json.dumps(table, allow_nan=False)
    levels = {claim.key for claim in CLAIMS if claim.level} | {"deflection-roughest"}
    assert all(one["verdict"] == NOT_RUN for row in table["claims"] if row["key"] in levels for one in row["findings"])
    assert json.loads(text) == table
    assert claims_text.markdown(json.loads(text)) == claims_text.markdown(table)


# ---- the outlook: autocorrelation length -----------------------------------------------------------------------------


def lengths(mid_hz: Sequence[float], levels_db: Sequence[float]) -> list[Case]:
    """Tones in one third octave each, of lengths 2, 5, 10, ... um."""
    found = []
    for length, hz, db in zip((2.0, 5.0, 10.0, 20.0, 40.0), mid_hz, levels_db, strict=True):
        band = np.where(np.isclose(MID_HZ, hz, rtol=0.05), 1e-4, np.nan)
        case = as_the_article_says(0.1, 20.0, reading="correlation-length")
        weighted = 1e-11 * 10 ** (db / 10)
        found.append(dataclasses.replace(case, correlation_um=length, band_w=band, laeq_db=db, a_weighted_w=weighted))
    return found


@pytest.mark.parametrize(
    ("values", "expected"), [((5, 4, 3, 2, 1), REPRODUCED), ((5, 6, 3, 2, 1), PARTLY), ((1, 2, 3, 4, 5), NOT)]
)
def test_lengths(values: Sequence[float], expected: str) -> None:
    """A centroid is the frequency of its only band, so it falls as that does; the level as that put in."""
    cases = lengths([1000.0 * value for value in (1, 1, 1, 1, 1)], [60.0 + value for value in values])
    assert verdict("length-level", cases) == verdict("length-level", cases, 20) == expected
    cases = lengths(
        [{1: 1000, 2: 2000, 3: 3150, 4: 4000, 5: 5000, 6: 6300}[int(value)] for value in values], [60.0] * 5
    )
    assert verdict("length-frequency", cases) == expected
    assert claims.CENTROID.of(cases[2], 10) == pytest.approx(10**3.5, rel=1e-12)  # 3150 Hz, exact


def test_a_sweep_is_about_its_own_rows_only() -> None:
    cases = [*study(), *lengths([4000.0] * 5, [60.0] * 5)]
    table = claims.table(cases)
    for row in table["claims"]:
        words = {one["reading"]: one["verdict"] for one in row["findings"]}
        swept = row["outlook"]
        assert words["article" if swept else "correlation-length"] == NOT_RUN
        assert words["correlation-length" if swept else "article"] != NOT_RUN or row["key"] == "level-above-70"
    assert {one["reading"] for one in table["scores"]} == {"article"}


# ---- which reading explains the article best -------------------------------------------------------------------------


def test_scores_rank_readings_and_say_ties() -> None:
    """1 for each statement reproduced: all of them with 10 lg, twice the same; half less where one holds in part."""
    good = study()
    twin = [dataclasses.replace(case, reading="twin") for case in good]
    worse = [dataclasses.replace(case, reading="worse") for case in study(changed=OTHERWISE["deflection-roughest"][0])]
    table = claims.table([*worse, *good, *twin])
    first = [(one["rank"], one["reading"], one["scale"], one["score"]) for one in table["scores"]][:3]
    whole = float(len(CLAIMS))
    assert first == [(1, "article", 10, whole), (1, "twin", 10, whole), (3, "worse", 10, whole - 0.5)]
    text = claims_text.markdown(table)
    assert "article with 10 lg and twin with 10 lg share the first place" in text
    assert "does better than worse with 10 lg on: deflection-roughest (reproduced, partly)." in text


def test_markdown_holds_every_claim_and_reading() -> None:
    table = claims.table(study(3))
    text = claims_text.markdown(table)
    for claim in (*CLAIMS, *OUTLOOK):
        assert f"### {claim.key}" in text
        assert claim.statement in text
    widths = {line.count("|") for line in text.splitlines() if line.startswith(("| claim", "| *pressure", "| *length"))}
    assert widths == {3}  # a claim and one reading
    assert len({claim.key for claim in (*CLAIMS, *OUTLOOK)}) == len(CLAIMS) + len(OUTLOOK) == 23


def test_the_page_in_docs_answers_for_every_statement() -> None:
    """Its table is that of claims.md from the whole study: a statement that is added or worded anew must be run."""
    lines = (Path(__file__).parent.parent / "docs" / "lee2025.md").read_text(encoding="utf-8").splitlines()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| *")]
    assert [row[0] for row in rows] == [f"*{claim.key}*: {claim.statement}" for claim in (*CLAIMS, *OUTLOOK)]
    head = next(line for line in lines if line.startswith("| claim"))
    scenes = Path(__file__).parent.parent / "scenarios" / "lee2025"
    assert [cell.strip() for cell in head.strip("|").split("|")][1:] == sorted(one.name for one in scenes.iterdir())
    for row in rows:
        words = {word.strip(" \\*") for cell in row[1:] for word in cell.split("/")}
        assert words <= {REPRODUCED, PARTLY, NOT, NOT_RUN}
