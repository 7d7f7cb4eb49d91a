"""The case of recorded bearings: housing, fit, and rises of made runs, without a march."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from bearing_runs import moved_as, turning

from rolling.bearing.linear_ring import linear_ring
from rolling.bearing_kind.bearing_run import BearingRun
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.file import read_as
from rolling.studies import recording_truths, validate

RATE = 48_000
FIGURES = pd.read_csv(validate.FOLDER / "recorded-6205.csv", comment="#")
SCENE = read_as(validate.FOLDER / "recorded-6205.yaml", BearingScene)


def made_run(acceleration: np.ndarray) -> BearingRun:
    """Return a run whose ring has an acceleration along all axes [m/s2]."""
    base = turning()
    rows = np.stack([acceleration] * 3, 1)
    loads = np.resize(base.record.ball_load_n, (len(acceleration), base.geometry.balls))
    record = replace(
        base.record, velocity_m_s=1e-4 * rows, acceleration_m_s2=rows, ball_load_n=loads
    )
    return moved_as(base, record)


@pytest.mark.law("Bearing in a seat: a rigid mass takes the free velocity down by both mobilities.")
def test_a_mass_takes_the_ring_down() -> None:
    """Below the resonance of the ring, its mobility is that of the spring of its balls."""
    hz, mass_kg = 200.0, 5.0
    time_s = np.arange(RATE) / RATE
    run = made_run(np.sin(2 * np.pi * hz * time_s))
    spring = linear_ring(run.model).stiffness_n_m[0, 0]
    wanted = 1 / abs(1 - (2 * np.pi * hz) ** 2 * mass_kg / spring)
    own = recording_truths.in_seat(run, mass_kg)
    assert np.sqrt(2) * own.std() == pytest.approx(wanted, rel=0.01)
    free = recording_truths.in_seat(run, 0.0)
    assert free == pytest.approx(run.record.acceleration_m_s2[:, 0], abs=1e-9)


def test_each_figure_of_the_recordings_has_one_of_ours(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run with pits that is ten times as strong as the healthy one rises by 20 dB."""
    healthy = made_run(np.random.default_rng(1).standard_normal(RATE))
    faulty = made_run(10 * healthy.record.acceleration_m_s2[:, 0])
    solved: list[BearingScene] = []

    def runs(scene: BearingScene) -> list[BearingRun]:
        solved.append(scene)
        surfaces = scene.bearing.surfaces
        return [faulty if surfaces.inner.faults or surfaces.outer.faults else healthy]

    monkeypatch.setattr(recording_truths, "_runs", runs)
    monkeypatch.setattr(recording_truths, "CLEARANCES_UM", (2.0, 100.0))
    monkeypatch.setattr(recording_truths, "AXIAL_LOADS_N", (50.0,))
    monkeypatch.setattr(recording_truths, "RADIAL_LOADS_N", (100.0, 200.0))
    rows = [
        validate.PublishedValue(rule, item, published, ours)
        for rule, item, published, ours in recording_truths.recording_rows(SCENE, FIGURES)
    ]
    pits = 2 * len(recording_truths.PITS_UM)
    tried = solved[: -1 - pits]  # in the fit
    least, most = recording_truths.ANGLE_DEG
    for scene in tried:
        assert least <= np.degrees(scene.model.rolling_angle) <= most
    # Balls with a clearance of 100 um would roll at other angles.
    assert len(tried) == 2 * len(recording_truths.SURFACES)
    alone = len(recording_truths.SURFACES) + 4  # fitted values
    assert len(rows) == alone + len(FIGURES) + pits  # of two records, outer over inner
    for row in rows:
        if row.rule == "rise":
            assert row.ours == pytest.approx(20.0, abs=1e-6)
        if row.rule == "outer over inner":
            assert row.ours == pytest.approx(0.0, abs=1e-6)
    fitted = {row.rule: row.ours for row in rows[:alone]}
    least, most = recording_truths.HOUSING_KG
    assert least <= fitted["fitted mass of the housing"] <= most
    case = validate.tomllib.loads((validate.FOLDER / "cases.toml").read_text("utf-8"))
    table = validate.rows_of(case["cases"]["recordings"], iter(rows))
    assert table["holds"][:alone].all()  # fitted values are shown only
    assert not table["holds"].all()
    assert "|fitted axial load|N|-|" in validate.case_table(table)


def test_the_lines_of_the_recordings_give_the_contact_angle() -> None:
    """BPFI and BPFO are Z/2 (1 +- D cos(alpha)/d_m) turns, whatever the speed is."""
    lines = FIGURES[FIGURES["quantity"] == "frequency of the line"].set_index("item")["value"]
    share = (lines["inner"] - lines["outer"]) / (lines["inner"] + lines["outer"])
    bearing = SCENE.bearing
    cosine = share * bearing.pitch_diameter_mm / bearing.ball_diameter_mm
    least, most = recording_truths.ANGLE_DEG
    assert least <= np.degrees(np.arccos(cosine)) <= most
