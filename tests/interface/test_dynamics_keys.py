"""Keys of a scene that vibrates: what needs what, in words."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from checked import checked

from rolling.in_si.physics_of_scene import plate_of
from rolling.scene.file import loads, resound
from rolling.scene.identity import contact_keys
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene

TEXT = """\
name: trial
sphere: {radius_mm: 5, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, density_kg_m3: 7850, thickness_mm: 10}
surface:
  {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, spacing_um: 2, width_um: 64,
   seed: 1}
rolling: {load_n: 20, speed_m_s: 0.1, distance_mm: 1}
numerics: {step_nodes: 1}
dynamics: {}
sound: {source: vibration}
"""


def scene(*changes: str) -> Scene:
    return loads(TEXT, changes)


EDGES = ["plate.length_mm=300", "plate.width_mm=400", "plate.loss_factor=0.01"]
BALL = "sound.channels=[{of: ball, quantity: velocity}]"
PLATE = "sound.channels=[{of: plate, quantity: velocity, x_mm: 3, y_mm: 0}]"
PATH = [*EDGES, "plate.contact_path=to-and-fro", "plate.contact_mm=[9, 9]"]


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        (["sound.q=0.5"], "sound.q"),
        (["sound.source=", "sound.q=0.5"], "sound.q"),
        (["sound.gain_pa_per_w_m2=3"], "sound.gain_pa_per_w_m2"),
        (["dynamics=", "plate.thickness_mm="], "sound.source"),
        (["plate.thickness_mm=", "plate.loss_factor=0.1"], "plate.loss_factor"),
        (["sphere.density_kg_m3="], "sphere.density_kg_m3"),
        (["plate.density_kg_m3="], "plate.density_kg_m3"),
        (["dynamics.loads=4"], "dynamics.loads"),
        (["rolling.duration_s=1"], "rolling.distance_mm"),
        (["rolling.distance_mm=1e9"], "rolling.distance_mm"),
        (["rolling.speed_m_s=[[0, 1], [1e-4, 0]]"], "rolling.speed_m_s"),
        # edges of the plate
        (["plate.length_mm=300"], "plate.width_mm"),
        (EDGES[:2], "plate.loss_factor"),
        ([*EDGES[:2], "plate.thickness_mm="], "plate.thickness_mm"),
        ([*EDGES, "plate.contact_mm=[300, 3]"], "plate.contact_mm"),
        ([*EDGES, "plate.contact_mm=[9, -1]"], "plate.contact_mm"),
        ([*EDGES, "plate.contact_mm=[1]"], "plate.contact_mm"),
        ([*EDGES, "plate.contact_mm=[0.3, 3]"], "plate.contact_mm"),  # ten contact radii: 0.688
        ([*EDGES, "plate.length_mm=1"], "plate.length_mm"),
        ([*EDGES, "plate.length_mm=1e5"], "plate.length_mm"),
        (PATH, "plate.contact_end_mm"),
        ([*EDGES, "plate.contact_end_mm=[9, 9]"], "plate.contact_end_mm"),
        ([*PATH, "plate.contact_end_mm=[9, 9]"], "plate.contact_end_mm"),
        (["plate.contact_mm=[9, 9]"], "plate.contact_mm"),
        # channels
        (["dynamics=", "plate.thickness_mm=", "sound.source=", BALL], "sound.channels"),
        (["plate.thickness_mm=", PLATE], "sound.channels[0].of"),
        ([PLATE.replace("x_mm: 3", "x_mm: 301"), *EDGES], "sound.channels[0].x_mm"),
        ([PLATE.replace("y_mm: 0", "y_mm: -1"), *EDGES], "sound.channels[0].y_mm"),
        ([PLATE.replace(", y_mm: 0", "")], "sound.channels[0]"),
        ([PLATE.replace("velocity", "force")], "sound.channels[0].quantity"),
        ([BALL.replace("velocity", "jerk")], "sound.channels[0].quantity"),
        ([BALL.replace("}", ", x_mm: 3, y_mm: 4}")], "sound.channels[0].x_mm"),
        ([BALL.replace("ball", "bowl")], "sound.channels[0].of"),
        ([BALL.replace("]", ", {of: ball, quantity: velocity}]")], "sound.channels[1]"),
        (["sound.channels=[]"], "sound.channels"),
        ([BALL, "rolling.drop_mm=1"], "sound.channels[0].quantity"),
    ],
)
def test_keys_that_do_not_go_together_are_refused(changes: list[str], key: str) -> None:
    with pytest.raises(SceneError) as caught:
        scene(*changes)
    (fault,) = caught.value.mistakes
    assert fault.split(": ")[1] == key


def test_every_key_that_needs_dynamics_is_named() -> None:
    with pytest.raises(SceneError) as caught:
        scene("dynamics=")
    named = [fault.split(": ")[1] for fault in caught.value.mistakes]
    assert named == ["plate.thickness_mm", "sound.source"]


def test_the_resolved_scene_is_read_again() -> None:
    for given in (scene(), scene("sound.source=release"), scene("plate.thickness_mm=")):
        assert Scene.from_dict(given.to_dict()) == given
    assert "q" not in scene().to_dict()["sound"]


def test_every_speed_meets_the_same_surface() -> None:
    tracks = [scene(f"rolling.speed_m_s={speed}").track for speed in (0.03, 0.1, 0.37, 3)]
    assert {track.steps for track in tracks} == {500}
    assert scene("rolling.speed_m_s=[[0, 0.1], [0.01, 0.2]]").track == tracks[0]


@pytest.mark.parametrize(
    "change",
    [
        {"sphere.density_kg_m3": 3200.0},
        {"plate.density_kg_m3": 2700.0},
        {"plate.thickness_mm": 1.0},
        {"plate.loss_factor": 0.1},
        {"dynamics.loads": 5},
        {"rolling.speed_m_s": 1.0},
        {"sound.source": "release"},
        {"sound.source": "release", "plate.thickness_mm": None, "dynamics": None},
    ],
)
def test_the_march_does_not_depend_on_the_vibration(change: dict[str, Any]) -> None:
    assert contact_keys(scene()) == contact_keys(scene().with_(change))


def test_resound_changes_bodies_and_source() -> None:
    changed = resound(
        scene(),
        [
            "rolling.speed_m_s=1",
            "plate.thickness_mm=1",
            "plate.loss_factor=0.01",
            "sphere.density_kg_m3=3200",
            "sound.source=release",
        ],
    )
    assert changed.track == scene().track
    assert changed.sound.source == "release"
    with pytest.raises(SceneError, match=r"dynamics.loads: needs a new run"):
        resound(scene(), ["dynamics.loads=5"])


@pytest.mark.parametrize(
    ("changes", "source"),
    [
        (["sound="], "vibration"),
        (["sound.source="], "vibration"),
        (["sound.source=release"], "release"),
        (["sound=", "dynamics=", "plate.thickness_mm="], "release"),
    ],
)
def test_with_dynamics_the_vibration_is_heard_unless_the_scene_says_otherwise(
    changes: list[str], source: str
) -> None:
    assert scene(*changes).sound.source == source
    assert Scene.from_dict(scene(*changes).to_dict()) == scene(*changes)


def test_the_default_source_follows_dynamics_that_are_added_or_removed_in_python() -> None:
    silent = {"dynamics": None, "plate.thickness_mm": None}
    assert scene().with_(silent).sound.source == "release"
    assert scene().with_(silent).with_(dynamics={}).sound.source == "vibration"
    changes = {"sound.source": "release", "dynamics": {"loads": 5}}
    assert scene().with_(changes).sound.source == "release"


def test_the_march_does_not_depend_on_the_edges() -> None:
    assert contact_keys(scene()) == contact_keys(scene(*EDGES, "plate.contact_loss_factor=0.1"))


def test_the_check_states_modes_and_contact_of_a_plate_with_edges() -> None:
    """1 mm of steel, 0.3 m x 0.4 m, has some 1,100 modes from 42 Hz (closed form) up to 30 kHz."""
    rows = {row.key: row for row in checked(scene(*EDGES, "plate.thickness_mm=1"))}
    assert re.match(r"11\d\d up to 30 kHz from 42.\d Hz", rows["plate_modes"].value)
    assert "the sphere rolls on the spot" in rows["plate_contact"].value
    sag = rows["plate_sag"]
    assert sag.value == "1.23 mm" and "thin-plate theory" in str(sag.warning)
    small = scene(*EDGES, "plate.length_mm=20", "plate.width_mm=30")
    stiff = {row.key: row for row in checked(small)}["plate_modes"]
    assert stiff.value == "none up to 30 kHz" and "a stiff block" in str(stiff.warning)
    assert not {row.key for row in checked(scene())} & {"plate_modes", "plate_contact"}


def test_the_contact_goes_to_and_fro_at_the_speed_of_the_sphere() -> None:
    """The ends are 50 mm apart, and the sphere rolls 0.1 m/s: every second it is back."""
    points = "plate.contact_mm=[10, 10]", "plate.contact_end_mm=[40, 50]"
    path = scene(*EDGES, "plate.contact_path=to-and-fro", *points)
    places = plate_of(path.plate).contact_points(path.motion.distance([0.0, 0.5, 0.75, 1.0, 7.25]))
    expected = [[10, 10], [40, 50], [25, 30], [10, 10], [25, 30]]
    assert places == pytest.approx(1e-3 * np.array(expected))
