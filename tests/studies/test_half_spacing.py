"""Verdicts that twice the grid's error could turn are checked at half the spacing."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from claim_cases import as_the_article_says, study, with_grid
from scene_text import SMALL

from rolling.lee2025 import claims, claims_text, half_spacing, page
from rolling.lee2025 import study as lee_study
from rolling.lee2025.checks import NOT, REPRODUCED, UNDECIDED
from rolling.lee2025.grid_error import GridError
from rolling.lee2025.half_spacing import Key, Pair
from rolling.scene.scene import Scene
from rolling.simulation import simulate
from rolling.simulation.batch import Run
from rolling.simulation.result import Result

SCENE = SMALL | {
    "rolling": {"load_n": 0.3, "speed_m_s": 0.1, "duration_s": 0.008},
    "numerics": {"tolerance": 1e-4},
}


def as_pair(roughness: float, load: float, **changes: Any) -> Pair:
    own = as_the_article_says(roughness, load)
    return Pair(own, dataclasses.replace(own, **changes))


def judged(key: str, scale: int, table: Any) -> Any:
    claim = next(each for each in table.claims if each.claim.key == key)
    return next(each.finding for each in claim.judgements if each.scale in (None, scale))


def test_cases_are_checked_where_twice_the_grids_error_turns_a_verdict(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The plastic ratio of 1.5 may be 1.3 to 1.7; 1.36 is within, 1.25 at twice the error not."""
    cases = study()
    assert half_spacing.wanted(claims.table(cases), cases) == []  # nothing was measured
    with_grid(monkeypatch, plastic={0.1: {20: (1.0, 1.1)}})
    table = claims.table(cases)
    assert judged("plastic-ratio-1-over-0.1", 10, table).verdict == REPRODUCED
    keys = half_spacing.wanted(table, cases)
    assert {place for _, place in keys} == {
        (roughness, load) for roughness in (0.1, 1.0) for load in (5, 10, 20, 50, 100)
    }
    # a variation counts for nothing
    departs = {"article": ["a plate of cheese"]}
    assert half_spacing.wanted(claims.table(cases, None, departs), cases) == []
    with_grid(monkeypatch, plastic={0.1: {20: (1.0, 1.05)}})  # 1.36 at twice the error
    assert half_spacing.wanted(claims.table(cases), cases) == []


def test_only_the_steps_that_may_turn_are_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    """At 20 N Ra 1 um is 1 dB louder than Ra 0.1 um: an error of 0.6 dB may not turn that."""
    ranges = {1.0: {5: (0.0, 0.0), 10: (0.0, 0.0), 20: (-0.6, 0.0), 50: (0.0, 0.0)}}
    with_grid(monkeypatch, level_db=ranges)
    cases = study()
    table = claims.table(cases)
    assert judged("level-roughness", 10, table).verdict == REPRODUCED
    assert half_spacing.wanted(table, cases) == [("article", (0.1, 20)), ("article", (1.0, 20))]


def test_a_verdict_that_turns_is_marked_and_another_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    with_grid(monkeypatch, plastic={0.1: {20: (1.0, 1.1)}})
    cases = study()
    table = claims.table(cases)
    keys = half_spacing.wanted(table, cases)

    def at(factor: float) -> dict[Key, Pair]:
        def changed(roughness: float, load: float) -> Pair:
            ratio = as_the_article_says(roughness, load).plastic_ratio
            more = factor if roughness == 0.1 else 1.0
            return as_pair(roughness, load, plastic_ratio=more * ratio)

        return {key: changed(*key[1]) for key in keys}

    stands = half_spacing.judge(table, cases, at(1.02))
    finding = judged("plastic-ratio-1-over-0.1", 10, stands)
    assert finding.finer is not None and not finding.finer.turns
    assert "reproduced as before" in finding.measured and finding.verdict == REPRODUCED
    text = claims_text.markdown(stands)
    assert claims_text.TURNS not in text and "None of the verdicts change" in text
    turned = half_spacing.judge(table, cases, at(1.3))
    finding = judged("plastic-ratio-1-over-0.1", 10, turned)
    assert finding.finer is not None and (finding.finer.before, finding.finer.after) == (
        REPRODUCED,
        NOT,
    )
    text = claims_text.markdown(turned)
    assert f"reproduced{claims_text.TURNS}" in text and "not instead of reproduced" in text
    html = page.page(["article"], turned, {}).decode()
    assert f"{claims_text.TURNS}: another verdict" in html
    assert f"{claims_text.TURNS}:" not in page.page(["article"], stands, {}).decode()
    # other statements are as they were, and so is the whole where a case was not checked
    assert judged("level-load", 10, turned) == judged("level-load", 10, table)
    some = dict(list(at(1.3).items())[1:])
    assert half_spacing.judge(table, cases, some) == table


def test_corrections_add_the_change_between_the_grids(monkeypatch: pytest.MonkeyPatch) -> None:
    case = as_the_article_says(1.0, 20)
    own = dataclasses.replace(case, band_w=np.full(31, 2e-5), laeq_db=60.0, maximum_db=50.0)
    fine = dataclasses.replace(
        own,
        band_w=np.full(31, 1e-5),
        laeq_db=58.0,
        maximum_db=49.0,
        maximum_20_db=own.maximum_20_db - 2,
        deflection=own.deflection * 1.01,
        line_db=own.line_db - 3.0,
        a_weighted_w=own.a_weighted_w / 2,
    )
    new = half_spacing.corrected(case, Pair(own, fine))
    assert new.laeq_db == pytest.approx(case.laeq_db - 2)
    assert new.maximum_db == pytest.approx(case.maximum_db - 1)
    assert new.maximum_20_db == pytest.approx(case.maximum_20_db - 2)
    assert new.deflection == pytest.approx(1.01 * case.deflection)
    assert np.allclose(new.band_w, case.band_w / 2)
    assert new.a_weighted_w == pytest.approx(case.a_weighted_w / 2)
    high = case.line_hz >= 5000
    assert np.allclose((new.line_db - case.line_db)[high], -3) and not np.any(
        (new.line_db - case.line_db)[~high]
    )
    silent = dataclasses.replace(fine, laeq_db=None, band_w=np.full(31, np.nan), plastic_ratio=0.0)
    new = half_spacing.corrected(case, Pair(silent, silent))
    assert new.laeq_db == case.laeq_db and np.array_equal(new.band_w, case.band_w)


def test_errors_times_a_factor_hold_no_error() -> None:
    grid = GridError(
        plastic={0.1: {5: (1.1, 1.2)}}, level_db={1.0: {5: (-3.0, -1.0)}}, band_db={1.0: 2.0}
    ).times(2)
    assert grid.factor("plastic", 0.1, 5) == pytest.approx((1.0, 1.4))
    assert grid.change_db("level_db", 1.0, 5) == (-6.0, 0.0) and grid.band_db == {1.0: 4.0}


def test_every_part_that_the_grid_may_turn_names_its_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors large enough to turn everything leave no verdict without cases to check."""
    huge = {ra: {20.0: (-30.0, 30.0)} for ra in (0.01, 0.1, 1.0, 5.0)}
    factors = {ra: {20.0: (0.2, 5.0)} for ra in (0.1, 1.0, 5.0)}
    with_grid(
        monkeypatch,
        plastic=factors,
        deflection=factors,
        level_db=huge,
        line_db=huge,
        high_db=huge,
        band_db={0.1: 30.0, 1.0: 30.0},
    )
    table = claims.table(study())
    turned = [
        judgement.finding
        for claim in table.claims
        for judgement in claim.judgements
        if "the grid" in judgement.finding.decided_by
    ]
    assert len(turned) > 10
    assert all(finding.verdict == UNDECIDED and finding.grid_places for finding in turned)


def solved(run: Run) -> Result:
    result = Result.empty(run.scene.track, run.scene.start)
    for first, last in simulate.pieces(result.solved_steps):
        result.add(simulate.simulate_piece(run.scene, first, last))
    return result


def test_checks_are_solved_once_and_compare_the_same_stretch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = Run({}, Scene.from_dict(SCENE), tmp_path / "as-stated" / "case")
    folder = tmp_path / "checks"
    outcome, fine = half_spacing.solve(folder, [run], 1, "study")
    assert not outcome.failures and not outcome.interrupted
    digest = simulate.identity_of(run.scene).sha256[:12]
    assert [path.name for path in folder.iterdir()] == [
        f"as-stated_case_{digest}_spacing-over-2_step-1_5e-5_blended_single_0-50.npz"
    ]
    monkeypatch.setattr(simulate, "simulate_piece", None)  # nothing is marched again
    again = half_spacing.solve(folder, [run], 1, "study")[1]
    monkeypatch.undo()
    name = "release_energy"
    assert np.array_equal(again[run.folder].series[name], fine[run.folder].series[name])
    whole = solved(run)
    both = half_spacing.pair("as-stated", run, whole, fine[run.folder])
    assert both.own.duration_s == both.fine.duration_s == pytest.approx(0.001)
    own = whole.series[name][:50]
    off = fine[run.folder].series[name] - own
    assert 0 < np.std(off) < 0.3 * np.std(own)  # the same asperities
    assert both.fine.plastic_ratio == pytest.approx(both.own.plastic_ratio, rel=0.2)
    assert both.fine.plastic_ratio != both.own.plastic_ratio


def test_the_first_surface_of_a_case_is_checked_and_failures_leave_verdicts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    data = [SCENE | {"surface": SCENE["surface"] | {"seed": seed}} for seed in (2, 1, 3)]
    runs = lee_study.runs(tmp_path / "article", [Scene.from_dict(each) for each in data])
    run = half_spacing.run_of(("article", (0.1, 0.3)), {"article": runs})
    assert lee_study.varied(run.scene)[2] == 1
    with_grid(monkeypatch, plastic={0.1: {20: (1.0, 1.1)}})
    cases = study()
    table = claims.table(cases)
    monkeypatch.setattr(half_spacing, "run_of", lambda key, runs: run)
    keys = half_spacing.wanted(table, cases)
    failed = half_spacing.Outcome(dict.fromkeys(range(len(keys)), "no room"))
    new, outcome = half_spacing.checked(table, cases, {}, {}, lambda chosen: (failed, {}))
    assert new == table and outcome is failed
    assert "not checked at half the spacing" in capsys.readouterr().err


def test_the_whole_study_checks_and_the_quick_one_does_not() -> None:
    assert lee_study.WHOLE.finer and not lee_study.QUICK.finer
