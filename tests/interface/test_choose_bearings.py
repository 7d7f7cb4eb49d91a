"""Bearings are chosen between by the bands of their rings: laws, draws, and what is refused."""

from __future__ import annotations

import math
from concurrent.futures import BrokenExecutor, Future
from pathlib import Path

import numpy as np
import pytest

import rolling as rc
from acoustics.pairs import LOOKS
from rolling.bearing_kind import bearing_heard
from rolling.bearing_kind.bearing_audition import BearingAudition
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.choice.choosing import choose_scenes
from rolling.run import pools
from rolling.run.budget import Budget
from rolling.scene.messages import SceneError

SMOOTH = [
    "bearing.surfaces.balls={kind: smooth, waviness: {4: 0.02}}",
    "bearing.surfaces.inner=",
    "bearing.surfaces.outer=",
    "sound.duration_s=0.05",
    "bearing.tilt=held",  # without the slow rocking of the ring its run-in is a fifth as long
]


def scene() -> rc.BearingScene:
    return rc.read_scene("bearing-6204", SMOOTH)


def waves(amplitude_um: float, name: str = "waves") -> rc.BearingScene:
    return scene().with_({"name": name, "bearing.surfaces.balls.waviness": {4: amplitude_um}})


@pytest.mark.law("Choice of bearings: twice the waviness of the balls is 6 dB more in each band.")
def test_twice_the_waviness_is_six_decibels_more() -> None:
    choice = rc.choose([scene(), waves(0.04, "twice")], workers=1, progress=False)
    for apart in choice.by_quantity[0].values():
        assert apart.db == pytest.approx(6.02, abs=0.1)
    assert choice.leading.name == "medium"
    assert choice.differences == [choice.by_quantity[0]["medium"]]


@pytest.mark.law("Bearing: twice a fine roughness of balls is 6 dB more in the high band.")
def test_twice_the_roughness_of_balls_is_six_decibels_more() -> None:
    """Between smooth raceways, by the linear response of the contacts.

    That marches of fine roughness double, too, is a law of tests/physics/test_bearing_contacts.py.
    """
    balls = "{kind: gaussian, roughness_ra_um: 0.005, correlation_length_um: 15, seed: 1}"
    rough = rc.read_scene("bearing-6204", [f"bearing.surfaces.balls={balls}", *SMOOTH[1:]])
    swept = rough.with_(sweep={"bearing.surfaces.balls.roughness_ra_um": [0.005, 0.01]})
    one, two = BearingAudition().candidates([swept])
    assert [one.label, two.label] == ["Ra of balls 0.005 µm", "Ra of balls 0.01 µm"]
    for draw in (0, 3):
        high = [
            bearing_heard.heard_specimen(each.scene, contact_plan(each.scene), {}, draw)["high"]
            for each in (one, two)
        ]
        assert 20 * math.log10(high[1] / high[0]) == pytest.approx(6.02, abs=0.05)


@pytest.mark.slow
def test_two_processes_hear_the_same(tmp_path: Path) -> None:
    scenes = [scene(), waves(0.04)]
    budget = Budget(pairs=2)
    one, two = (
        choose_scenes(scenes, tmp_path / str(workers), budget, workers=workers)
        for workers in (1, 2)
    )
    for band, rms in one.rms.items():
        assert np.array_equal(two.rms[band], rms)


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

    monkeypatch.setattr(bearing_heard, "pool_for_tasks", lambda workers, tasks: Broken())
    choice = choose_scenes([scene(), waves(0.04)], tmp_path / "out")
    assert choice.pairs >= LOOKS[0]


def test_what_leaves_nothing_to_choose_is_refused() -> None:
    with pytest.raises(SceneError, match="nothing to choose"):
        BearingAudition().candidates([scene()])
    other = scene().with_({"bearing.turning": "outer"})
    with pytest.raises(SceneError, match=r"bearing\.turning"):
        BearingAudition().candidates([scene(), other])


def test_bearings_at_rest_are_alike() -> None:
    """What rounding leaves of a smooth ring has no level, nor does its housing."""
    plate = "{material: steel-s235, thickness_mm: 8, length_mm: 120, width_mm: 90}"
    words = [*SMOOTH, "bearing.surfaces.balls=", "bearing.tilt=held", f"plate={plate}"]
    still = rc.read_scene("bearing-6204", words)
    swept = still.with_(sweep={"bearing.density_kg_m3": [7800, 7801]})
    choice = rc.choose(swept, workers=1, progress=False)
    assert set(choice.rms) == {"low", "medium", "high", "housing"}
    for of_band in choice.rms.values():
        np.testing.assert_array_equal(of_band, 0.0)
    assert all("alike" in sentence for sentence in choice.sentences)
    assert "silent" in str(choice)
    assert choice.table()["housing_laeq_db"].isna().all()


# ---- what would help


@pytest.mark.law("Sensitivity of a bearing: a tenth more of a waviness is 20 lg 1.1 in its band.")
def test_a_tenth_more_waviness_is_a_closed_form() -> None:
    key = "bearing.surfaces.balls.waviness.4"
    for quantity in ("low", None):
        found = rc.sensitivities(
            scene(), [key], pairs=2, workers=1, progress=False, quantity=quantity
        )
        (row,) = found.rows
        assert row.db == pytest.approx(20 * math.log10(1.1), abs=0.02)
        assert row.change.shares_march and row.chain_db is None
    assert "from 300 to 1800 Hz" in found.sentences[0]
    assert "medium_db" in found.table() and "chain_db" not in found.table()
    found.plot()


def test_the_values_of_a_drawing_of_a_bearing_can_be_changed() -> None:
    audition = BearingAudition()
    given = rc.read_scene("bearing-6204")
    keys = {wanted.key.removeprefix("bearing.") for wanted in audition.drawing_values(given)}
    assert keys >= {
        "axial_load_n",
        "radial_clearance_um",
        "conformity_inner",
        "conformity_outer",
        "surfaces.balls.grade",
        "surfaces.inner.roughness_ra_um",
        "surfaces.outer.roughness_ra_um",
    }
    assert "radial_load_n" not in keys  # it has none
    base = audition.unchanged(given)
    for wanted in audition.drawing_values(given):
        changed = audition.with_value(base, wanted.set_key, wanted.larger, "larger")
        assert changed.scene != given


def test_a_quantity_that_a_scene_has_not_is_refused() -> None:
    with pytest.raises(SceneError, match="allowed for this scene: low, medium, high"):
        rc.sensitivities(scene(), workers=1, progress=False, quantity="housing")


def test_a_speed_below_a_level_of_a_band_obeys_it() -> None:
    limit = rc.coarsest_below(
        scene(),
        "speed_rpm",
        26.0,
        between=(1500, 1600),
        seeds=3,
        workers=1,
        progress=False,
        quantity="low",
    )
    assert limit.quantity.name == "low" and limit.noun == "specimens"
    assert all(point.levels_db.shape == (3,) for point in limit.points)
    below = [point for point in limit.points if point.upper_db <= 26.0]
    assert (limit.value is None) == (not below)
    assert "dB re 1 um/s" in limit.sentences[0]
