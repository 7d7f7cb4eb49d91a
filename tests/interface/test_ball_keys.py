"""Keys of a ball's surface and of faults: messages, round trips, sweeps and words."""

from __future__ import annotations

import json
from typing import Any

import pytest
from ball_scenes import SMALL_BALL, small_ball
from checked import checked

import rolling
from rolling.report.assumed import surface_words
from rolling.scene.file import dump, loads
from rolling.scene.messages import SceneError

PIT = "{kind: pit, at_mm: [0.1, 0], size_um: 10, depth_um: 1}"
BALL = "sphere.surface"


def rimmed(**keys: object) -> str:
    """Return the pit with further keys."""
    pit = {"kind": "pit", "at_mm": [0.1, 0], "size_um": 10, "depth_um": 1} | keys
    return json.dumps(pit)


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (f"{BALL}={{kind: graded, grade: G15}}", '.grade: got "G15", allowed: G3, G5'),
        (f"{BALL}={{kind: grade}}", '.kind: got "grade", allowed: gaussian, smooth, file, graded'),
        (f"{BALL}={{kind: smooth, waviness: {{3.5: 0.1}}}}", 'waviness: got the order "3.5"'),
        (f"{BALL}={{kind: smooth, waviness: {{3: -1}}}}", "order 3: got -1, allowed: an amplitude"),
        (f"{BALL}={{kind: smooth, waviness: {{79: 0.1}}}}", "allowed: up to 78, waves of at least"),
        (f"{BALL}={{kind: smooth, seed: 1}}", f"{BALL}.seed: unknown key of kind smooth"),
        (f"{BALL}={{kind: file, path: x.npy, spacing_um: 1}}", "spacing_um: got 1, allowed: 2"),
        (f"{BALL}.wavines={{3: 1}}", f"{BALL}.wavines: unknown key, nearest: {BALL}.waviness"),
        ("surface.faults=3", "surface.faults: got 3, allowed: a list"),
        (f"surface.faults=[{PIT.replace('0.1, 0', '9, 0')}]", "which is beyond the surface"),
        (f"surface.faults=[{PIT.replace('10', '100')}]", "size_um: got 100, allowed: at most 32"),
        (f"surface.faults=[{PIT.replace('10', '1')}]", "size_um: got 1, allowed: at least a node"),
        (f"surface.faults=[{PIT.replace('at_mm: [0.1, 0]', 'count: 3')}]", "count and seed"),
        (f"surface.faults=[{PIT.replace('pit', 'scratch')}]", "a scratch has a length"),
        (f"surface.faults=[{PIT.replace('kind', 'knd')}]", "faults[0].knd: unknown key"),
        (f"surface.faults=[{rimmed(rim_height_um=0.1)}]", "rim_width_um: missing; a rim has a"),
        (f"surface.faults=[{rimmed(rim_width_um=4)}]", "rim_height_um: missing; a rim has a"),
        (f"surface.faults=[{rimmed(rim_height_um=-1, rim_width_um=4)}]", "rim_height_um: got -1"),
        (f"surface.faults=[{rimmed(rim_height_um=1, rim_width_um=4)}]", "allowed: at most 0.44"),
        (f"surface.faults=[{rimmed(rim_height_um=0.1, rim_width_um=1)}]", "rim_width_um: got 1"),
        (
            f"surface.faults=[{rimmed(kind='bump', rim_height_um=0.1, rim_width_um=4)}]",
            "only a pit",
        ),
        (f"{BALL}={{kind: smooth, faults: [{PIT.replace('0.1', '0.7')}]}}", "0 to 0.628 mm"),
        ("sphere={radius_mm: 0.001, surface: {kind: smooth}}", "nodes of 2 um around the sphere"),
    ],
)
def test_a_wrong_key_has_one_message(override: str, message: str) -> None:
    with pytest.raises(SceneError) as caught:
        loads(SMALL_BALL, [override])
    assert any(message in fault for fault in caught.value.mistakes), caught.value.mistakes
    assert all(fault.startswith("--set: ") or "s:" in fault for fault in caught.value.mistakes)


def test_scenes_of_balls_survive_files_and_python() -> None:
    """Orders are whole numbers in Python and in YAML, and text in JSON."""
    ball = rolling.GradedBall(
        grade="G10",
        waviness={"7": 0.02},
        faults=[rolling.SurfaceFault(kind="bump", count=3, seed=1, size_um=8, depth_um=0.1)],
    )
    scene = small_ball().with_({"sphere.surface": ball})
    assert loads(dump(scene)) == scene == type(scene).from_dict(scene.to_dict())
    assert scene.to_dict()["sphere"]["surface"]["waviness"] == {7: 0.02}
    assert scene == loads(SMALL_BALL, [f"{BALL}={scene.sphere.surface.model_dump_json()}"])
    assert scene.with_({f"{BALL}.grade": "G5"}).sphere.surface.grade == "G5"
    assert scene.with_({BALL: None}) == small_ball()


@pytest.mark.parametrize(
    ("sweep", "turns"),
    [
        ({"sphere.surface.grade": ["G3", "G10"]}, [314, 314]),
        ({"sphere.radius_mm": [0.1, 0.2]}, [314, 628]),
        ({BALL: {"pitted": {"kind": "smooth", "faults": []}, "G5": {"kind": "graded"}}}, None),
        ({f"{BALL}.waviness": {"few": {3: 0.1}, "many": {3: 0.1, 9: 0.1}}}, [314, 314]),
    ],
)
def test_sweeps_reach_into_the_surface_of_the_ball(sweep: Any, turns: list[int] | None) -> None:
    scene = small_ball(kind="graded", grade="G20")
    if turns is None:
        with pytest.raises(SceneError, match=r"sphere\.surface\[?.*grade"):
            scene.with_(sweep=sweep)
        return
    assert [run.scene.track.turn_nodes for run in scene.with_(sweep=sweep).runs()] == turns


def test_bare_keys_stand_for_the_surface_of_the_plate() -> None:
    law = {"kind": "gaussian", "roughness_ra_um": 0.1, "correlation_length_um": 10, "seed": 1}
    scene = small_ball(**law).with_(surface={**law, "spacing_um": 2, "width_um": 32})
    changed = scene.with_(roughness_ra_um=0.2)
    assert (changed.surface.roughness_ra_um, changed.sphere.surface.roughness_ra_um) == (0.2, 0.1)


def test_check_states_turns_and_judges_the_slope_of_faults() -> None:
    deep = {"kind": "pit", "at_mm": [0, 0], "size_um": 10, "depth_um": 10}
    scene = small_ball("rolling.distance_mm=0.9", kind="smooth", faults=[deep], waviness={2: 50})
    rows = {finding.key: finding for finding in checked(scene)}
    assert rows["turns"].value.startswith("1.433 of 314 nodes (319 nm off the circumference)")
    assert rows["turns"].value.endswith("a rolling.distance_mm of 1.256 closes")
    assert "the steepest fault has a slope of 4" in (rows["fault_slope"].warning or "")
    assert rows["slope"].warning  # 2 x 50 / 100 / sqrt(2)


def test_a_smooth_ball_is_a_scene_without_its_surface_in_words_only() -> None:
    scene = small_ball(kind="smooth")
    assert scene.is_smooth
    assert "the sphere: smooth, once round in 0.628 mm, 1 turns rolled" in surface_words(scene)
    graded = small_ball(kind="graded", grade="G10", waviness={3: 0.1})
    assert "of grade G10, 0.25 µm from spherical form" in surface_words(graded)
    assert "waves of order 3 (0.1 µm)" in surface_words(graded)
