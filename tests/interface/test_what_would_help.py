"""What would help, and the coarsest value below a limit: laws, marches, refusals."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

import rolling as rc
from rolling import cli
from rolling.ball_kinds import ball_drawing
from rolling.ball_kinds.ball_audition import BallAudition
from rolling.choice import drawing, specimen_solving
from rolling.choice.limit import Point, falls, from_quiet, tolerance_factor
from rolling.choice.limit_search import LimitSearch, coarsest_value
from rolling.choice.sensitivity import improve_scene
from rolling.marches.piece import contact_identity
from rolling.run.budget import Budget

SMALL = """\
name: small
sphere: {radius_mm: 1.5, material: steel-100cr6}
plate: {material: steel-100cr6, thickness_mm: 3, contact_loss_factor: 0.01}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 15, spacing_um: 3,
          width_um: 192, seed: 1}
rolling: {load_n: 1, speed_m_s: 0.2, distance_mm: 1.2}
dynamics: {}
"""


@pytest.fixture
def scene(tmp_path: Path) -> rc.Scene:
    path = tmp_path / "small.yaml"
    path.write_text(SMALL)
    return rc.read_scene(path)


@pytest.fixture
def marched(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Count the pieces that each finished march has left."""
    counts: list[int] = []
    drop = specimen_solving.folders.drop_pieces

    def counted(folder: Path, identity: str) -> None:
        counts.append(len([*(folder / "pieces" / identity[:16]).glob("*.npz")]))
        drop(folder, identity)

    monkeypatch.setattr(specimen_solving.folders, "drop_pieces", counted)
    return counts


@pytest.mark.slow
@pytest.mark.law("Choice: the level falls by 20 lg 1.1 for a tenth more distance.")
def test_distance_is_a_closed_form_and_costs_no_march(
    scene: rc.Scene, tmp_path: Path, marched: list[int]
) -> None:
    folder = tmp_path / "help"
    keys = ["sound.distance_m", "plate.thickness_mm", "plate.contact_loss_factor", "speed_m_s"]
    found = improve_scene(scene, folder, keys=keys, workers=1, budget=Budget(pairs=2))
    by_key = {row.change.key: row for row in found.rows}
    exact = -20 * math.log10(1.1)
    # rounding of the sums of squares only
    assert by_key["sound.distance_m"].db == pytest.approx(exact, abs=1e-9)
    assert by_key["sound.distance_m"].chain_db == pytest.approx(exact, abs=1e-9)
    assert all(row.change.shares_march for row in found.rows)
    # Two surfaces are marched for the scene itself, and none for the changed scenes.
    assert min(marched[:2]) > 0
    assert len(marched) == 2 * (1 + len(keys)) and max(marched[2:]) == 0
    # a thin plate gives way with the square of its thickness, a thicker one is quieter
    assert by_key["plate.thickness_mm"].db < 0
    assert "thicker plate" in " ".join(found.sentences)
    others = [abs(row.db) for row in found.rows if row.change.key != "sound.distance_m"]
    distance_is_more = abs(exact) > max(others)
    assert ("apart from a greater distance" in found.sentences[0]) is distance_is_more
    assert set(found.table().columns) >= {"key", "vibration_db", "chain_db", "specimens"}


def test_speed_keeps_the_track(scene: rc.Scene) -> None:
    """A duration would give a faster sphere a longer track, and so another contact."""
    timed = scene.with_(distance_mm=None, duration_s=0.006)
    base = ball_drawing.unchanged(timed)
    faster = ball_drawing.with_value(base, "rolling.speed_m_s", 0.22, "faster")
    assert contact_identity(faster.scene) == contact_identity(base.scene)
    assert base.scene.track.steps == timed.track.steps


def test_each_value_of_a_drawing_has_a_change(scene: rc.Scene, tmp_path: Path) -> None:
    ball = rc.GradedBall(grade="G200", seed=7, waviness={5: 0.01})
    made = scene.with_(
        {
            "sphere.surface": ball,
            "surface.finish": "lapped",
            "surface.skewness": -0.5,
            "rolling.load_n": "weight",
        }
    )
    changes, left_out = drawing.changes_of(
        BallAudition(), made, ball_drawing.unchanged(made), 1, tmp_path
    )
    by_key = {change.key: change for change in changes}
    assert len(left_out) == 1, left_out
    finish = by_key["surface.roughness_ra_um"]  # of the library
    assert (finish.old, finish.new) == (0.14, pytest.approx(0.154))
    assert by_key["surface.skewness"].new == pytest.approx(-0.4)
    grade = by_key["sphere.surface.grade"]  # the coarsest: the next finer one has the other sign
    assert (grade.new, grade.is_upwards) == ("G100", False)
    assert by_key["sphere.surface.waviness.5"].new == pytest.approx(0.011)
    assert [left.key for left in left_out] == ["rolling.load_n"]


@pytest.mark.law("Tolerance limit: 95 % of values lie below it in 95 % of samples.")
def test_tolerance_factor_is_that_of_the_standard() -> None:
    # ISO 16269-6:2014, one-sided, unknown mean and deviation, 95 % and 95 %
    assert tolerance_factor(12) == pytest.approx(2.736, abs=1e-3)
    assert tolerance_factor(5) == pytest.approx(4.203, abs=1e-3)
    samples = np.random.default_rng(1).normal(size=(4000, 12))
    limits = samples.mean(axis=1) + tolerance_factor(12) * samples.std(axis=1, ddof=1)
    assert np.mean(limits >= norm.ppf(0.95)) == pytest.approx(0.95, abs=0.012)  # 3.5 sigma


def _searched(law, low: float, high: float, level_db: float) -> tuple[float | None, bool, int]:  # type: ignore[no-untyped-def]
    """Search a law of levels over a value, without any scene."""
    scatter = np.array([-0.1, 0.0, 0.1])

    class Lawful(LimitSearch):
        def _point(self, value):  # type: ignore[no-untyped-def]
            known = [point for point in self.points if point.value == value]
            if not known:
                known = [Point(value, law(value) + scatter)]
                self.points.append(known[0])
            return known[0]

    search = Lawful.__new__(Lawful)
    search.points = []
    search.level_db = level_db
    search.key = "surface.roughness_ra_um"
    first, last = search._point(low), search._point(high)
    rises = last.mean_db >= first.mean_db
    for value in np.geomspace(low, high, 5)[1:-1]:
        search._point(float(value))
    value = search._crossing(rises, [])
    ordered = from_quiet(search.points, rises, search.key)
    return value, rises, len(falls(ordered))


def test_search_finds_the_crossing_of_a_known_law() -> None:
    upper = tolerance_factor(3) * 0.1
    value, rises, others = _searched(lambda x: 20 * math.log10(x), 0.1, 10.0, 0.0)
    exact = 10 ** (-upper / 20)
    assert rises and others == 0
    assert value is not None and exact / 1.05 <= value <= exact
    value, rises, others = _searched(lambda x: -20 * math.log10(x), 0.1, 10.0, 0.0)
    assert not rises and others == 0
    assert value is not None and 1 / exact <= value <= 1.05 / exact


def test_search_says_where_a_level_does_not_rise() -> None:
    """A hump in the middle: the answer is the first crossing from the quiet end."""

    def hump(x: float) -> float:
        return 3 * math.log(x) + 12 * math.exp(-((math.log(x)) ** 2))

    value, rises, others = _searched(hump, 0.05, 20.0, 3.0)
    assert rises and others >= 1
    assert value is not None and value < 1
    upper = tolerance_factor(3) * 0.1
    assert hump(value) + upper <= 3.0 < hump(value * 1.06) + upper


def test_search_says_where_all_or_nothing_is_below() -> None:
    assert _searched(math.log, 1.0, 9.0, 50.0)[0] == 9.0
    assert _searched(math.log, 1.0, 9.0, -50.0)[0] is None


@pytest.mark.slow
def test_thickness_below_a_level(scene: rc.Scene, tmp_path: Path) -> None:
    """All thicknesses share the marches of the specimens, and the answer obeys the limit."""
    limit = coarsest_value(
        scene, "thickness_mm", 0.0, between=(2.5, 4.0), seeds=3, folder=tmp_path / "b", workers=1
    )
    assert not limit.rises and limit.falls == []
    assert limit.value is not None
    assert limit.at(limit.value).upper_db <= 0.0
    louder = limit.next_louder
    if louder is not None:
        assert louder.upper_db > 0.0
        assert float(limit.value) / float(louder.value) <= 1.05
    table = limit.table()
    assert list(table["order"]) == list(range(1, len(limit.points) + 1))
    assert table["is_answer"].sum() == 1


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--below", "30", "--key", "surface.roughnes_ra_um"], "surface.roughness_ra_um"),
        (["--below", "30", "--key", "surface.seed"], "a seed has no size"),
        (["--below", "30", "--key", "surface.autocorrelation"], "a number above 0"),
        (["--below", "30"], "needs --key"),
        (["--below", "x", "--key", "rolling.load_n"], "a number"),
        (["--key", "rolling.load_n"], "only goes with --below"),
        (["--quantity", "low"], "only goes with --below"),
        (["--improve", "--quantity", "low"], "allowed for this scene: vibration"),
        (["--improve", "--key", "surface.hurst"], "allowed: "),
        (["--improve", "--set", "sweep.rolling.load_n=[1, 2]"], "without a sweep"),
        (["--improve", "--below", "3"], "not allowed with"),
        (["--below", "3", "--key", "rolling.load_n", "--within", "1"], "does not go with"),
        (
            ["--below", "30", "--key", "rolling.load_n", "--between", "3", "3"],
            "differ by more than",
        ),
        (["--below", "30", "--key", "rolling.load_n", "--between", "a", "3"], "two numbers above"),
        (
            [
                "--below",
                "30",
                "--key",
                "load_n",
                "--set",
                "surface={kind: smooth, spacing_um: 3, width_um: 192}",
            ],
            "no random surface",
        ),
    ],
)
def test_bad_input_gets_one_sentence(
    words: list[str],
    told: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = tmp_path / "small.yaml"
    path.write_text(SMALL)
    monkeypatch.chdir(tmp_path)
    try:
        code = cli.main(["choose", str(path), *words, "--workers", "1"])
    except SystemExit as error:  # of argparse
        code = int(error.code or 0)
    said = capsys.readouterr().err
    assert code == 2
    assert told in said, said
