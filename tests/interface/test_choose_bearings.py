"""Bearings are chosen between on the terminal and in Python, and work that is done is kept."""

from __future__ import annotations

import json
import math
from concurrent.futures import BrokenExecutor, Future
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import rolling as rc
from acoustics.pairs import LOOKS
from rolling.bearing_run import choosing
from rolling.cli import main
from rolling.run import pools
from rolling.run.budget import Budget, Clock
from rolling.scene.messages import SceneError

SMOOTH = [
    "bearing.surfaces.balls={kind: smooth, waviness: {4: 0.02}}",
    "bearing.surfaces.inner=",
    "bearing.surfaces.outer=",
    "sound.duration_s=0.05",
]


def scene() -> rc.BearingScene:
    return rc.read_scene("bearing-6204", SMOOTH)


@pytest.mark.law("Choice of bearings: twice the waviness of the balls is 6 dB more in each band.")
def test_twice_the_waviness_is_six_decibels_more(tmp_path: Path) -> None:
    twice = scene().with_({"name": "twice", "bearing.surfaces.balls.waviness": {4: 0.04}})
    choice = rc.choose([scene(), twice], folder=tmp_path / "out", workers=1, progress=False)
    for apart in choice.differences[0]:
        assert apart.db == pytest.approx(6.02, abs=0.1)
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"choice.csv", "choice.png"}


@pytest.mark.law("Bearing: twice a fine roughness of balls is 6 dB more in the high band.")
def test_twice_the_roughness_of_balls_is_six_decibels_more() -> None:
    """Between smooth raceways, by the linear response of the contacts.

    That marches of fine roughness double, too, is a law of tests/physics/test_bearing_contacts.py.
    """
    balls = "{kind: gaussian, roughness_ra_um: 0.005, correlation_length_um: 15, seed: 1}"
    rough = rc.read_scene("bearing-6204", [f"bearing.surfaces.balls={balls}", *SMOOTH[1:]])
    swept = rough.with_(sweep={"bearing.surfaces.balls.roughness_ra_um": [0.005, 0.01]})
    one, two = choosing.candidates_of([swept])
    for draw in (0, 3):
        ratio = (
            choosing.heard_specimen(two.scene, two.plan, {}, draw).high
            / choosing.heard_specimen(one.scene, one.plan, {}, draw).high
        )
        assert 20 * math.log10(ratio) == pytest.approx(6.02, abs=0.05)


def test_a_choice_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    grades = {"bearing.surfaces.balls.waviness": {4: 0.04}}
    scenes = [scene(), scene().with_({"name": "twice", **grades})]
    heard = []
    move = choosing.heard_specimen

    def counted(*given):
        if len(heard) == 3:
            raise KeyboardInterrupt
        heard.append(given)
        return move(*given)

    monkeypatch.setattr(choosing, "heard_specimen", counted)
    with pytest.raises(KeyboardInterrupt):
        choosing.choose_bearings(scenes, tmp_path / "out", workers=1)
    kept = json.loads((tmp_path / "out" / "choice.json").read_text())["heard"]
    assert [len(of_one) for of_one in kept] == [2, 1]
    again = []
    monkeypatch.setattr(choosing, "heard_specimen", lambda *given: again.append(0) or move(*given))
    choice = choosing.choose_bearings(scenes, tmp_path / "out", workers=1)
    assert len(again) == 2 * choice.pairs - 3
    of_two_processes = choosing.choose_bearings(scenes, tmp_path / "other", workers=2)
    for band, rms in choice.rms.items():
        assert np.array_equal(of_two_processes.rms[band], rms)


def test_a_killed_process_costs_no_specimen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The rest is then moved in the process of the choice."""

    class Broken(pools.Pool):
        """A pool whose process is killed at its second task."""

        taken = 0

        def submit(self, task: pools.Task, team: object = 0) -> Future:
            self.taken += 1
            if self.taken == 2:
                raise BrokenExecutor
            return super().submit(task)

    monkeypatch.setattr(choosing, "pool_for_tasks", lambda workers, tasks: Broken())
    twice = scene().with_({"name": "twice", "bearing.surfaces.balls.waviness": {4: 0.04}})
    choice = choosing.choose_bearings([scene(), twice], tmp_path / "out")
    assert choice.pairs >= LOOKS[0]


def waves(amplitude_um: float) -> rc.BearingScene:
    return scene().with_({"name": "waves", "bearing.surfaces.balls.waviness": {4: amplitude_um}})


def test_the_number_of_specimens_may_be_given(tmp_path: Path) -> None:
    budget = Budget(pairs=2)
    choice = choosing.choose_bearings([scene(), waves(0.04)], tmp_path / "out", budget, workers=1)
    assert choice.pairs == 2
    stored = json.loads((tmp_path / "out" / "choice.json").read_text())
    assert stored["pairs"] == 2 and stored["sentences"] == choice.sentences
    assert choice.differences[0][0].uncertainty_db < choice.within_db
    assert "above the wanted" not in " ".join(choice.sentences)
    assert "above the wanted 0.001 dB" in replace(choice, within_db=0.001).sentences[-1]


def test_a_wrong_number_of_specimens_is_refused_before_marches(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="allowed: a whole number from 2 to 60"):
        choosing.choose_bearings([scene(), waves(0.04)], tmp_path / "out", Budget(pairs=61))
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("heard", [[], [[{"low": 1.0}], []], [[1], [1]], [5, 5]])
def test_damaged_specimens_are_told(tmp_path: Path, heard: list[object]) -> None:
    scenes = [scene(), waves(0.04)]
    out = tmp_path / "out"
    choosing.choose_bearings(scenes, out, Budget(pairs=2), workers=1)
    stored = json.loads((out / "choice.json").read_text())
    (out / "choice.json").write_text(json.dumps({**stored, "heard": heard}))
    with pytest.raises(rc.FolderError, match="damaged"):
        choosing.choose_bearings(scenes, out, Budget(pairs=2), workers=1)


def test_other_numbers_of_specimens_are_refused_before_a_march(tmp_path: Path) -> None:
    budget = Budget(pairs=61)
    with pytest.raises(SceneError, match="allowed: a whole number from 2 to 60"):
        choosing.choose_bearings([scene(), waves(0.04)], tmp_path / "out", budget, workers=1)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("heard", [[], [[]], [[1], [2]], [[{"low": "much"}], []], {"a": 1}])
def test_a_choice_that_a_stranger_wrote_is_refused(tmp_path: Path, heard: object) -> None:
    candidates = choosing.candidates_of([scene(), waves(0.04)])
    kept = choosing._as_json(candidates) | {"heard": heard}
    (tmp_path / "choice.json").write_text(json.dumps(kept))
    with pytest.raises(rc.FolderError, match=r"choice\.json: it is damaged"):
        choosing._take_heard(tmp_path, candidates)


def test_the_limit_of_time_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Clock, "is_over", True)
    monkeypatch.setattr(choosing, "specimens_needed", lambda choice: 60)
    choice = choosing.choose_bearings([scene(), waves(0.04)], tmp_path / "out", workers=1)
    assert choice.pairs == LOOKS[0] and choice.is_early
    assert "ended early, because the limit of 10 min" in choice.sentences[-1]


def test_a_choice_of_an_older_version_is_kept_or_starts_anew(tmp_path: Path) -> None:
    """It did not write which program it was of, and numbers of two programs are not mixed."""
    out = tmp_path / "out"
    out.mkdir()
    scenes = [scene(), waves(0.04)]
    old = {"format": choosing.FORMATS[1], "identity": "", "labels": [], "heard": []}
    (out / "choice.json").write_text(json.dumps(old))
    (out / "choice.csv").touch()
    with pytest.raises(rc.FolderError, match="an older version"):
        choosing.choose_bearings(scenes, out, workers=1)
    (out / "choice.csv").unlink()
    choice = choosing.choose_bearings(scenes, out, Budget(pairs=2), workers=1)
    assert choice.pairs == 2
    assert json.loads((out / "choice.json").read_text())["format"] == choosing.FORMAT


def test_what_leaves_nothing_to_choose_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="nothing to choose"):
        choosing.candidates_of([scene()])
    other = scene().with_({"bearing.turning": "outer"})
    with pytest.raises(SceneError, match=r"bearing\.turning"):
        choosing.candidates_of([scene(), other])


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "notes.txt").write_text("mine")
    twice = scene().with_({"bearing.surfaces.balls.waviness": {4: 0.04}})
    with pytest.raises(rc.FolderError, match="other files"):
        choosing.choose_bearings([scene(), twice], tmp_path / "out")
    assert (tmp_path / "out" / "notes.txt").read_text() == "mine"


def test_a_bearing_and_a_sphere_are_not_compared(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["choose", "bearing-6204", "quickstart"])
    assert ended.value.code == 2
    assert "one kind" in capsys.readouterr().err


def test_bearings_at_rest_are_alike(tmp_path: Path) -> None:
    """What rounding leaves of a smooth ring has no level, nor does its housing."""
    plate = "{material: steel-s235, thickness_mm: 8, length_mm: 120, width_mm: 90}"
    still = rc.read_scene("bearing-6204", [*SMOOTH, "bearing.surfaces.balls=", f"plate={plate}"])
    swept = still.with_(sweep={"bearing.density_kg_m3": [7800, 7801]})
    choice = rc.choose(swept, folder=tmp_path / "out", workers=1, progress=False)
    assert set(choice.rms) == {"low", "medium", "high", "housing"}
    for of_band in choice.rms.values():
        np.testing.assert_array_equal(of_band, 0.0)
    assert all("alike" in sentence for sentence in choice.sentences)
