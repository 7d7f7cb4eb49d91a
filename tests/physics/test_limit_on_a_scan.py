"""The coarsest value below a level on one scan: its places count as they are alike."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

import rolling as rc
from acoustics.bands import BAND_NAMES
from acoustics.pairs import independent_pairs
from rolling import cli
from rolling.ball_kinds import linear_response
from rolling.ball_kinds.ball_candidates import candidate
from rolling.ball_kinds.ball_heard import HeardBall
from rolling.choice.audition import audition_of
from rolling.choice.choice_numbers import Contender
from rolling.choice.choosing import HeardPairs, OpenChoice
from rolling.choice.heard_specimen import HeardQuantity
from rolling.choice.limit import Limit, Point, falls, tolerance_limit
from rolling.choice.limit_search import LimitSearch

PLACES = np.arange(12.0)
SCENE = """\
name: scan
sphere: {radius_mm: 3, material: steel-100cr6}
plate: {material: steel-100cr6, thickness_mm: 3, contact_loss_factor: 0.01}
surface: {kind: file, path: scan.npy, spacing_um: 4, periodic: blend}
rolling: {load_n: 1, speed_m_s: 0.1}
dynamics: {}
"""


@pytest.mark.law("Tolerance limit: it holds for places whose levels are correlated, too.")
@pytest.mark.parametrize("length", [1.4, 5.0])
def test_the_limit_of_correlated_places_holds(length: float) -> None:
    """95 % of all values lie below it in at least 95 % of samples, but not if each counts as one.

    At 1.4 places the values count as 4.6 independent ones, at 5 places as 1.9.
    """
    correlation = np.exp(-np.abs(PLACES[:, None] - PLACES) / length)
    draws = np.random.default_rng(5).normal(size=(1500, 12)) @ np.linalg.cholesky(correlation).T
    limits = np.array([tolerance_limit(values, correlation) for values in draws])
    as_single = np.array([tolerance_limit(values) for values in draws])
    true_limit = norm.ppf(0.95)
    error = math.sqrt(0.95 * 0.05 / 1500)
    assert np.mean(limits >= true_limit) >= 0.95 - 2 * error
    assert np.mean(as_single >= true_limit) < 0.95 - 10 * error


def test_places_without_correlation_have_the_limit_of_the_standard() -> None:
    levels = np.array([20.0, 21.5, 19.0, 22.0, 20.5, -math.inf])
    assert tolerance_limit(levels, np.eye(6)) == pytest.approx(tolerance_limit(levels))
    assert tolerance_limit(levels, np.ones((6, 6))) == math.inf


def test_a_fall_of_alike_places_is_less_sure() -> None:
    fall = -0.5 + 0.4 * np.array([-1.0, 1.0, -1.0, 1.0, 0.0, 0.0])
    levels = np.linspace(20, 21, 6)
    single = [Point(1.0, levels), Point(2.0, levels + fall)]
    assert len(falls(single)) == 1
    alike = 0.9 + 0.1 * np.eye(6)
    of_scan = [Point(point.value, point.levels_db, alike) for point in single]
    assert falls(of_scan) == []


class LinearWork(OpenChoice):
    """Places of a scan, heard by their linear response in place of a march."""

    def hear(self, candidates, count, are_all=True):  # type: ignore[no-untyped-def]
        """Return what is heard of the first places of a candidate."""
        (one,) = candidates
        heard = linear_response.heard_places(one.scene)
        specimens = [self._specimen(one, number) for number in range(count)]
        balls = []
        for specimen in specimens:
            rolling = specimen.scene.rolling
            column = round(1e-6 * rolling.across_um / specimen.scene.track.spacing)
            square = float(np.mean(np.square(heard[:, column])))
            balls.append(
                HeardBall(
                    loss_factors=(0.01,),
                    squares=np.array([square]),
                    bands=np.zeros((1, len(BAND_NAMES))),
                    released_power_db=None,
                    errors={},
                )
            )
        return HeardPairs([Contender(one, balls, specimens, self._leading)], [])


def write_scan(path: Path, across_um: float) -> None:
    """Write heights of 1.28 x 0.6 mm with ridges of 16 um along and a length across."""
    x = 2 * np.pi * np.fft.fftfreq(320, 4.0) * 16
    y = 2 * np.pi * np.fft.rfftfreq(600, 4.0) * across_um
    noise = np.random.default_rng(2).normal(size=(320, 600))
    heights = np.fft.irfft2(np.fft.rfft2(noise) * np.exp(-(x[:, None] ** 2 + y**2) / 8), (320, 600))
    np.save(path, 2e-8 * (heights / heights.std())[:, :150])


def search(folder: Path, across_um: float) -> Limit:
    """Search the speed below -5 dB(A) on a scan, by its linear response."""
    write_scan(folder / "scan.npy", across_um)
    (folder / "scan.yaml").write_text(SCENE)
    scene = rc.read_scene(folder / "scan.yaml")
    base = candidate("as it is", scene)
    quantity: HeardQuantity = audition_of(scene).quantities([base])[0]
    work = LinearWork([base], folder, solver=None)  # type: ignore[arg-type]
    found = LimitSearch(
        work=work,
        base=base,
        key="rolling.speed_m_s",
        quantity=quantity,
        level_db=-5.0,
        count=6,
        is_given=True,
    )
    return found.run([0.02, 0.3], are_names=False, notes=[])


def test_a_search_on_a_scan_counts_its_independent_places(tmp_path: Path) -> None:
    """Ridges of 16 um leave six places what they are; of ridges of 300 um there are about two."""
    for across_um, fewest, most in ((16, 4.0, 6.0), (300, 1.0, 3.0)):
        limit = search(tmp_path, across_um)
        for point in limit.points:
            assert point.correlation is not None
            assert fewest < independent_pairs(point.correlation) < most
            assert point.upper_db >= tolerance_limit(point.levels_db)
        assert isinstance(limit.value, float)
        answer = limit.at(limit.value)
        places = answer.independent
        assert places is not None
        assert answer.upper_db <= -5.0 < limit.next_louder.upper_db  # type: ignore[union-attr]
        counts = f"6 places of the scan, which count as {places:.1f} independent ones"
        assert counts in limit.sentences[0]
        assert "twice as many independent places" in limit.sentences[1]
        assert "independent ones that the correlation" in limit.methods
        assert (limit.table()["independent_places"] <= 6).all()


def test_a_scan_whose_places_are_as_good_as_one_has_no_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is refused before anything is marched."""
    write_scan(tmp_path / "scan.npy", 16)
    profile = np.load(tmp_path / "scan.npy")[:, :1]
    np.save(tmp_path / "scan.npy", np.repeat(profile, 150, axis=1))
    (tmp_path / "scan.yaml").write_text(SCENE)
    monkeypatch.chdir(tmp_path)
    assert cli.main(["choose", "scan.yaml", "--below", "14", "--key", "rolling.speed_m_s"]) == 2
    said = capsys.readouterr().err
    assert "tell no more than one place" in said and "wider or longer scan" in said
