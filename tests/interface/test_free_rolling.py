"""A sphere under its own weight, that rolls out, or that is let go from a height: its keys."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from checked import checked

from rolling.check.findings import check_run
from rolling.numbers.quantity import worst_of
from rolling.scene.file import loads, resound
from rolling.scene.identity import contact_keys
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import middle_speeds

TEXT = """\
name: marble
sphere: {radius_mm: 8, density_kg_m3: 2500}
plate: {youngs_modulus_gpa: 70, poissons_ratio: 0.22, density_kg_m3: 2500, thickness_mm: 8}
surface:
  {kind: gaussian, roughness_ra_um: 0.05, correlation_length_um: 20, spacing_um: 4, width_um: 256,
   seed: 1}
rolling: {speed_m_s: 0.1, distance_mm: 1}
dynamics: {}
"""


def scene(*changes: str) -> Scene:
    return loads(TEXT, changes)


@pytest.mark.parametrize(
    ("changes", "numbers"),
    [
        (["rolling.resistance=1"], "after 0.713801 mm"),
        (
            ["rolling.resistance=0.1", "rolling.distance_mm=", "rolling.duration_s=1"],
            "after 0.14276 s",
        ),
    ],
)
def test_a_track_beyond_the_rest_of_the_sphere_is_refused(changes: list[str], numbers: str) -> None:
    """A solid sphere rolls 7/10 v^2/(mu g), for 7/5 v/(mu g)."""
    with pytest.raises(SceneError, match=numbers):
        scene(*changes)


@pytest.mark.parametrize(
    "changes",
    [
        ["rolling.load_n=heavy"],
        ["rolling.resistance=-1"],
        ["rolling.resistance=0.01", "rolling.speed_m_s=[[0, 1], [1, 0.5]]"],
        ["rolling.drop_mm=0"],
        ["rolling.drop_mm=1", "dynamics=", "plate.thickness_mm="],
        ["rolling.drop_mm=1", "sound.source=release"],
        ["rolling.drop_mm=1", "dynamics.release=true"],
    ],
)
def test_keys_that_do_not_go_together_are_one_fault(changes: list[str]) -> None:
    with pytest.raises(SceneError) as caught:
        scene(*changes)
    assert len(caught.value.mistakes) == 1


def test_the_load_is_the_weight() -> None:
    """The march knows the load in newtons: a density changes the weight, and with it the march."""
    weight = 9.80665 * 2500 * 4 / 3 * 3.14159265 * 8e-3**3
    assert scene().load == pytest.approx(weight, rel=1e-8)
    assert scene("rolling.load_n=weight") == scene() == Scene.from_dict(scene().to_dict())
    assert contact_keys(scene()) == contact_keys(scene(f"rolling.load_n={scene().load!r}"))
    assert contact_keys(scene()) != contact_keys(scene("sphere.density_kg_m3=2600"))
    swept = scene("sweep.rolling.load_n=[weight, 1]").runs()
    assert [run.scene.load for run in swept] == [scene().load, 1]
    with pytest.raises(SceneError, match=r"sphere\.density_kg_m3: needs a new run"):
        resound(scene(), ["sphere.density_kg_m3=2600"])
    assert resound(scene("rolling.load_n=1"), ["sphere.density_kg_m3=2600"]).mass > scene().mass


@pytest.mark.parametrize("load", ["weight", "0.2"])
def test_a_sphere_rolls_out(load: str) -> None:
    """A solid sphere that rolls has 7/5 of its mass, so c W slows it by 5/7 c W/m."""
    given = scene("rolling.resistance=0.2", "rolling.distance_mm=", f"rolling.load_n={load}")
    deceleration = 5 / 7 * 0.2 * given.load / given.mass
    # The track is a whole number of nodes of 4 um, and the last one takes the longest.
    rest = 0.1**2 / 2 / deceleration
    assert 0 <= rest - given.track.distance < 4e-6
    assert given.duration == pytest.approx(0.1 / deceleration, rel=0.08)
    assert not given.motion.is_constant(given.duration)
    _, speed = middle_speeds(given.motion, given.track.steps, given.step)
    half = len(speed) // 2
    assert speed[half] == pytest.approx(0.1 * 0.5**0.5, rel=0.01)
    assert contact_keys(given.with_(resistance=0.1, distance_mm=given.track.distance * 1e3)) == (
        contact_keys(given)
    )
    with pytest.raises(SceneError, match=r"rolling\.speed_m_s: needs a new run"):
        resound(given, ["rolling.speed_m_s=0.2"])


def test_a_sphere_rolls_out_over_a_height_file(tmp_path: Path) -> None:
    """It passes the file several times, and the march is that of one passage."""
    np.save(tmp_path / "heights.npy", np.zeros((32, 16)))
    surface = {"kind": "file", "path": "heights.npy", "spacing_um": 4}
    data = scene().to_dict() | {"surface": surface}
    data["rolling"] = {"speed_m_s": 0.1, "resistance": 0.2}
    track = Scene.from_dict(data, tmp_path).track
    assert (track.lap_steps, track.steps) == (32, int(0.1**2 * 0.7 / 0.2 / 9.80665 / 4e-6))


def test_no_resistance_keeps_the_speed() -> None:
    assert scene("rolling.resistance=0").motion.is_constant(10.0)


@pytest.mark.parametrize(
    ("changes", "key", "words"),
    [
        (["rolling.drop_mm=1"], "drop", "before the sphere hits the plate"),
        (["rolling.drop_mm=300"], "drop_width", "choose a surface.width_um of at least 970"),
        (["rolling.drop_mm=0.01", "rolling.resistance=0.2", "rolling.distance_mm=3"], "", ""),
        (["sphere.radius_mm=80"], "ball_modes", "sphere.radius_mm of at most 67"),
        (
            [
                *("rolling.drop_mm=300", "plate.youngs_modulus_gpa=0.001"),
                *("surface.width_um=12000", "rolling.distance_mm=40"),
            ],
            "drop_width",
            "choose a lower rolling.drop_mm",
        ),
    ],
)
def test_check(changes: list[str], key: str, words: str) -> None:
    warnings = {
        row.key: row.warning
        for row in checked(scene(*changes))
        if row.key in ("drop", "drop_width", "ball_modes", "impacts_yield")
    }
    assert words in (warnings.pop(key) or "") if key else not any(warnings.values())


@pytest.mark.parametrize(("modulus", "elastic_mm"), [("", 0.23), ("210", 3.6)])
def test_check_says_from_which_height_an_impact_yields(modulus: str, elastic_mm: float) -> None:
    """A steel ball of 10 mm on 2.1 GPa yields from 0.23 mm if it is rigid, and from 3.6 mm."""
    ball = [f"sphere.youngs_modulus_gpa={modulus}", "sphere.poissons_ratio=0.3"] if modulus else []
    steel = scene(
        *("sphere.radius_mm=5", "sphere.density_kg_m3=7850", "plate.youngs_modulus_gpa=210"),
        *("plate.poissons_ratio=0.3", "plate.hardness_gpa=2.1", "plate.density_kg_m3=7850", *ball),
    )
    for height, yields in ((0.97 * elastic_mm, False), (1.03 * elastic_mm, True)):
        _, doubts = check_run(steel.with_({"rolling.drop_mm": height}))
        assert ("impacts_yield" in [doubt.key for doubt in doubts]) == yields
        worst = worst_of(doubts)
        assert (worst.severity.word == "do not quote" and "elastic drop" in worst.text) == yields
