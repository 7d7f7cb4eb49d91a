"""Scenes of bearings: reading, named bearings, the free contact angle, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bearing_runs import loads_bearing
from ruamel.yaml import YAML
from scene_text import BEARINGS, SCENES

import rolling
from rolling import cli
from rolling.bearing_kind.bearing_check import scene_rules
from rolling.bearing_kind.bearing_in_short import conclusion
from rolling.bearing_kind.standard_conditions import departures
from rolling.check.finding import Finding
from rolling.kinds.reading import schema
from rolling.kinds.registry import name_of_file
from rolling.numbers.doubt import Doubt, Severity
from rolling.scene import library
from rolling.scene.bearing_rules import largest_pressure
from rolling.scene.bearing_sources import assumed_keys
from rolling.scene.file import STORED_MARK, dump, read_as
from rolling.scene.identity import differences
from rolling.scene.messages import SceneError

TEXT = """\
name: trial
bearing:
  balls: 8
  ball_diameter_mm: 7.938
  pitch_diameter_mm: 33.5
  contact_angle_deg: 12
  conformity_inner: 0.515
  conformity_outer: 0.525
  speed_rpm: 1800
  axial_load_n: 70
  ring_mass_kg: 0.06
  angle: fixed
"""
SIDES = "length_mm: 1000, width_mm: 700"


def faults(*overrides: str, text: str = TEXT) -> list[str]:
    with pytest.raises(SceneError) as error:
        loads_bearing(text, overrides, "b.yaml")
    return error.value.mistakes


def bearing(*overrides: str) -> rolling.BearingScene:
    scene = loads_bearing(TEXT, overrides, "b.yaml")
    assert isinstance(scene, rolling.BearingScene)  # whose first use gives scenes their check
    return scene


# ---- reading and defaults


def test_a_bearing_bends_and_turns_its_angle_unless_it_says_otherwise() -> None:
    """A plate holds its ring, so the default follows it wherever a plate comes or goes."""
    free = loads_bearing(TEXT.replace("  angle: fixed\n", ""))
    own = free.bearing
    assert (own.ring, own.angle, own.tilt) == ("elastic", "moving", "held")
    plate = {"material": "steel-s235", "length_mm": 300, "width_mm": 200, "thickness_mm": 5}
    seated = free.with_(plate=plate)
    assert seated.bearing.ring == "rigid" and seated.with_(plate=None).bearing.ring == "elastic"
    swept = free.with_({"sweep": {"plate": {"none": None, "housing": plate}}})
    assert [run.bearing.ring for _, run in swept.runs()] == ["elastic", "rigid"]


def test_a_stored_scene_keeps_what_its_version_did() -> None:
    """Versions before 0.11 wrote every default, and knew neither rings that bend nor angles."""
    own = loads_bearing(TEXT)
    old = dump(own).replace("  ring: elastic\n", "").replace("  angle: fixed\n", "")
    assert "  ring:" not in old and "  angle:" not in old
    stored = loads_bearing(f"{STORED_MARK}, format 2, written by version 0.9.0\n{old}")
    assert (stored.bearing.ring, stored.bearing.angle) == ("rigid", "fixed")
    assert loads_bearing(old).bearing.ring == "elastic"
    assert differences(stored, loads_bearing(old)) == [
        'bearing.angle: got "moving", has "fixed"',
        'bearing.ring: got "elastic", has "rigid"',
    ]


@pytest.mark.parametrize("path", BEARINGS, ids=lambda path: path.stem)
def test_scene_is_the_same_after_writing(path: Path) -> None:
    scene = rolling.read_scene(path)
    assert loads_bearing(dump(scene)) == scene
    assert rolling.BearingScene.from_dict(scene.to_dict()) == scene
    root = schema("bearing")
    for data in (YAML(typ="safe").load(path.read_text()), scene.to_dict()):
        assert set(data) <= set(root["properties"])
        assert set(data["bearing"]) <= set(root["$defs"]["Bearing"]["properties"])


def test_a_scene_is_read_by_its_section() -> None:
    assert isinstance(rolling.read_scene(BEARINGS[0]), rolling.BearingScene)
    assert isinstance(rolling.read_scene(SCENES[0]), rolling.Scene)
    with pytest.raises(SceneError, match=r"yaml:\d+: bearing: allowed here: a scene with sphere"):
        read_as(BEARINGS[0], rolling.Scene)
    assert name_of_file("bearing-6204") == "bearing" and name_of_file("quickstart") == "ball"
    assert name_of_file("no-such-file.yaml") == "ball"
    text = faults(text=TEXT.replace("bearing:", "bearings:"))
    assert text[0].startswith("b.yaml:2: bearings: unknown key, nearest: bearing")


def test_a_sweep_has_runs_with_their_values() -> None:
    grades = "sweep.bearing.surfaces.balls.grade=[G5, G100]"
    scene = bearing("bearing.surfaces.balls={kind: graded, grade: G10}", grades)
    runs = scene.runs()
    assert [run.scene.bearing.surfaces.balls.grade for run in runs] == ["G5", "G100"]
    assert [*runs[0].values] == ["bearing.surfaces.balls.grade"]
    text = faults("bearing.surfaces.balls={kind: graded, grade: G10}", grades.replace("5", "7"))
    assert len(text) == 1 and "G7" in text[0] and "nearest: G5" in text[0]


def test_every_key_is_described() -> None:
    root = schema("bearing")
    for section in root["$defs"].values():
        for name, key in section["properties"].items():
            assert key.get("description"), name


# ---- named bearings


NAMED = library.data("bearings")["bearings"]
PRINTED_PITCH_IN = {"6203": 1.122, "6205": 1.537}  # by the Bearing Data Center of Case Western


@pytest.mark.parametrize("name", NAMED)
def test_a_named_bearing_can_be_assembled_and_loaded_to_its_catalogue_rating(name: str) -> None:
    """The static load rating of ISO 76 is that of a pressure of 4.2 GPa."""
    scene = rolling.BearingScene(bearing={"named": name, "speed_rpm": 1800, "axial_load_n": 20})
    made = scene.bearing
    assert made.bore_mm is not None and made.outside_diameter_mm is not None
    middle = (made.bore_mm + made.outside_diameter_mm) / 2
    if name in PRINTED_PITCH_IN:
        assert made.pitch_diameter_mm == pytest.approx(25.4 * PRINTED_PITCH_IN[name], rel=2e-4)
    else:
        assert made.pitch_diameter_mm == pytest.approx(middle, rel=0.01)
    rating = NAMED[name]["static_load_rating_n"][0]
    loaded = scene.with_(axial_load_n=0, radial_load_n=rating)
    pressure = largest_pressure(loaded.bearing, loaded.geometry)
    assert 3.4e9 < pressure < 4.2e9


def test_all_series_are_there_and_their_balls_hold_iso_76_and_can_be_filled_in() -> None:
    """C0 = f0 Z D^2, and the balls of a usual bearing reach around 180 to 198 degrees."""
    wanted = ["608"] + [f"{series}{n:02d}" for series in (60, 62, 63) for n in range(11)]
    assert [*NAMED] == wanted
    for name, entry in NAMED.items():
        value = {key: pair[0] for key, pair in entry.items() if isinstance(pair, list)}
        ball = value["ball_diameter_mm"]
        rating = value["static_factor"] * value["balls"] * ball**2
        assert rating == pytest.approx(value["static_load_rating_n"], rel=0.06), name
        half = math.asin(ball / value["pitch_diameter_mm"])
        assert 180 < math.degrees(2 * (value["balls"] - 1) * half) < 198, name
        ends = [10, 12, 15, 17, *range(20, 55, 5)]
        assert name == "608" or value["bore_mm"] == ends[int(name[2:])]


@pytest.mark.parametrize(
    ("name", "clearance_um"),
    [
        ("6204", 12.5),
        ("6204-2RS", 12.5),
        ("6204ZZ", 12.5),
        ("62042rs1", 12.5),
        ("6204 2Z/C3", 20.5),
        ("6204-2RSH-C3", 20.5),
        ("6205DDUC3", 20.5),
        ("608-ZZC3", 15.5),
        ("6000 C2", 3.5),
        ("6206-C4", 32),
        ("6310/P5 C5", 59),
        ("6310 CN", 14.5),
        ("6204\N{NON-BREAKING HYPHEN}2RS", 12.5),
        ("6204\N{EN DASH}c3", 20.5),
        ("6204-2RS1/C3WT", 20.5),
        ("6204.2RSR.L038.C3", 20.5),
    ],
)
def test_suffixes_are_understood_and_c3_sets_the_clearance(name: str, clearance_um: float) -> None:
    """The middle of the ranges of ISO 5753-1 by the bore."""
    bearing = {"named": name, "speed_rpm": 1800, "axial_load_n": 20}
    scene = rolling.BearingScene(bearing=bearing)
    assert scene.bearing.radial_clearance_um == clearance_um
    assert scene.bearing.named == name
    rows = {row.key: row.value for row in scene.check()}
    assert "ISO 5753-1" in rows["source_radial_clearance_um"]
    other = scene.with_({"bearing.named": "6204-C5"})
    assert other.bearing.radial_clearance_um == 38 and other.bearing.balls == 8
    own = scene.with_({"bearing.radial_clearance_um": 9}).with_({"bearing.named": "6204-C5"})
    assert own.bearing.radial_clearance_um == 9


def test_values_beside_a_name_win_and_another_name_brings_its_own() -> None:
    scene = rolling.BearingScene(bearing={"named": 6204, "speed_rpm": 1800, "axial_load_n": 20})
    assert scene.with_(contact_angle_deg=15).bearing.radial_clearance_um is None
    other = scene.with_(ball_diameter_mm=3.5).with_(named="608")
    assert other.bearing.pitch_diameter_mm == 15 and other.bearing.ball_diameter_mm == 3.5
    both = scene.with_(sweep={"bearing.named": [6204, 608]}).runs()
    assert [run.scene.bearing.pitch_diameter_mm for run in both] == [33.5, 15]
    text = faults("bearing.named=6211")
    assert "allowed: 608, 6000 to 6010" in text[0] and "nearest: 6210" in text[0]


@pytest.mark.parametrize(
    ("name", "nearest", "reason"),
    [
        ("6211", "6210", ""),
        ("6320", "6310", ""),
        ("609", "608", ""),
        ("688", "608", ""),
        ("62O4", "6204", ""),
        ("7204", "6204", ""),
        ("16004", "6004", ""),
        ("63004-2RS", "6004", ""),
        ("62206", "6206", ""),
        ("W6204", "6204", 'the prefix "W" is not understood; '),
        ("NU 304", "6304", 'the prefix "NU" is not understood; '),
        ("6204-2SR", "6204", 'the suffix "2SR" is not understood; '),
        ("6204Q", "6204", 'the suffix "Q" is not understood; '),
        ("6204DDUCM", "6204", 'the suffix "CM" is not understood; '),
        ("6204-C3/C4", "6204", "C3 and C4 are two clearances, and a bearing has one; "),
    ],
)
def test_the_nearest_name_is_the_nearest_size(name: str, nearest: str, reason: str) -> None:
    text = faults(f"bearing.named={name}")[0]
    assert f"C3; {reason}nearest: {nearest}; in place of a name give balls, " in text


@pytest.mark.parametrize("name", ["60", "C3", "2RS", "R8", "ball"])
def test_a_name_without_a_size_has_no_nearest_one(name: str) -> None:
    assert "nearest" not in faults(f"bearing.named={name}")[0]


# ---- geometry


@pytest.mark.parametrize("angle_deg", [0.5, 12.0, 40.0])
def test_angle_and_clearance_follow_from_each_other(angle_deg: float) -> None:
    """cos(angle) = 1 - P_d/(2 (r_i + r_o - D))"""
    scene = bearing(f"bearing.contact_angle_deg={angle_deg}")
    distance = (0.515 + 0.525 - 1) * 7.938e-3
    cosine = 1 - scene.radial_clearance / (2 * distance)
    assert math.acos(cosine) == pytest.approx(math.radians(angle_deg), rel=1e-6)
    clearance = f"bearing.radial_clearance_um={scene.radial_clearance * 1e6!r}"
    other = bearing(clearance, "bearing.contact_angle_deg=")
    assert other.contact_angle == pytest.approx(scene.contact_angle, rel=1e-6)
    assert bearing(clearance, f"bearing.contact_angle_deg={angle_deg}").bearing == (
        scene.with_({"bearing.radial_clearance_um": scene.radial_clearance * 1e6}).bearing
    )


def test_a_contradiction_is_refused_with_the_value_that_fits() -> None:
    (text,) = faults("bearing.radial_clearance_um=20")
    assert "14.42" in text and "13.88" in text
    assert bearing("bearing.radial_clearance_um=13.88").contact_angle > 0


def test_a_negative_clearance_is_a_preload_within_the_static_capacity() -> None:
    moving = ("bearing.contact_angle_deg=", "bearing.angle=moving")
    pressed = bearing(*moving, "bearing.radial_clearance_um=-6")
    assert pressed.contact_angle == 0
    assert pressed.model.balance().ball_load_n.min() > 40
    (text,) = faults(*moving, "bearing.radial_clearance_um=-200")
    least = text.split("allowed: at least ")[1].split(":")[0]
    assert "5.29 GPa without a load" in text
    widest = f"bearing.radial_clearance_um={least}"
    assert bearing(*moving, widest, "bearing.axial_load_n=1")
    assert "got -6" in faults("bearing.contact_angle_deg=", "bearing.radial_clearance_um=-6")[0]


def test_a_purely_radial_load_needs_no_angle() -> None:
    radial = ("bearing.axial_load_n=0", "bearing.radial_load_n=100")
    scene = bearing(*radial, "bearing.contact_angle_deg=0", "bearing.radial_clearance_um=10")
    assert scene.contact_angle == 0 and scene.gap == pytest.approx(5e-6)
    assert bearing(*radial).contact_angle == 0
    assert "above 0" in faults("bearing.contact_angle_deg=0")[0]
    assert "missing" in faults("bearing.contact_angle_deg=")[0]
    assert "missing" in faults("bearing.axial_load_n=0")[0]


# ---- loads


@pytest.mark.parametrize(
    "loads",
    [
        {"axial_load_n": 1e6},
        {"axial_load_n": 0, "radial_load_n": 1e5},
        {"axial_load_n": 1e5, "radial_load_n": 2e5},
    ],
)
@pytest.mark.parametrize("kind", [[], ["bearing.angle=moving"]], ids=["fixed", "moving"])
def test_a_load_beyond_the_static_capacity_is_refused_with_one_that_fits(
    loads: dict[str, float], kind: list[str]
) -> None:
    (text,) = faults(*kind, *(f"bearing.{key}={load}" for key, load in loads.items()))
    fitting = float(text.partition("at most ")[2].partition(" ")[0].strip(":"))
    allowed = fitting / next(load for load in loads.values() if load)
    held = [f"bearing.{key}={0.999 * allowed * load}" for key, load in loads.items()]
    scene = bearing(*kind, *held)
    pressure = largest_pressure(scene.bearing, scene.geometry)
    assert pressure == pytest.approx(4.2e9, rel=2e-3)


def test_an_axial_load_holds_all_balls_or_is_refused() -> None:
    """Beyond F_r tan(angle) = F_a cos(pi/Z) there is no balance in some place of the cage."""
    most = 70 / math.tan(math.radians(12)) * math.cos(math.pi / 8)
    assert bearing(f"bearing.radial_load_n={0.999 * most}").radial_load < most
    (text,) = faults(f"bearing.radial_load_n={1.001 * most}")
    assert f"{most:.4g}"[:3] in text and "bearing.angle moving" in text


MOVING = "bearing.angle=moving"


def test_a_moving_angle_bears_all_loads() -> None:
    """Balls are lifted, and a clearance of zero bears an axial load, at an angle of its own."""
    lifted = bearing(MOVING, "bearing.axial_load_n=150", "bearing.radial_load_n=1000")
    assert min(lifted.model.balance().ball_load_n) == 0
    closed = bearing(MOVING, "bearing.contact_angle_deg=0")
    angle = closed.model.rolling_angle
    assert closed.contact_angle == 0 and angle > 0
    ratio = closed.ball_radius * math.cos(angle) / closed.pitch_radius
    assert closed.kinematics.cage_hz == pytest.approx(15 * (1 - ratio), rel=1e-12)


def test_the_check_of_a_moving_angle_quotes_its_axial_velocities() -> None:
    """The rows of a 6204 at 70 N are those of exact geometry: 36.4 N a ball, 2,172 Hz axial."""
    findings = bearing(MOVING).check()
    rows = {row.key: row.value for row in findings}
    assert rows["contact_angle"] == "12 degrees without load; 13.9 degrees under the loads"
    assert rows["ball_loads"] == "36.4 N each"
    assert rows["ring_resonances"] == "5.96 kHz radial, 2.17 kHz axial"
    assert "contact_angle" not in {doubt.key for doubt in findings.doubts["trial"]}
    radial = ("bearing.axial_load_n=0", "bearing.radial_load_n=100")
    assert (
        "axial"
        in {row.key: row.value for row in bearing(MOVING, *radial).check()}["ring_resonances"]
    )


@pytest.mark.parametrize(
    ("words", "before"),
    [
        (["bearing.ring_mass_kg=1e-9"], "at least "),
        (["bearing.speed_rpm=60000", "bearing.ball_inertia=true"], "below "),
    ],
    ids=["light ring", "fast balls"],
)
def test_a_motion_that_no_steps_follow_is_refused_with_a_value_that_fits(
    words: list[str], before: str
) -> None:
    (text,) = faults(*words)
    fitting = float(text.partition(before)[2].partition(",")[0])
    key = words[0].partition("=")[0]
    assert bearing(f"{key}={fitting}", *words[1:]).bearing.speed_rpm > 0


# ---- refusals


def test_all_faults_stand_in_one_message() -> None:
    text = faults(
        "bearing.balls=14",
        "bearing.bore_mm=26",
        "bearing.outside_diameter_mm=41",
        "bearing.contact_angle_deg=0",
        "bearing.turning=both",
        "bearing.conformity_inner=0.5",
        "bearing.sped_rpm=3",
        "bearing.surfaces.fault_ball=20",
    )
    for words in ("at most 13", "25.56", "41.44", "above 0", "inner", "greater than 0.5"):
        assert any(words in line for line in text), (words, text)
    assert any("nearest: bearing.speed_rpm" in line for line in text)


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("bearing.conformity_outer=0.61", "0.6"),
        ("bearing.balls=2", "3"),
        ("bearing.balls=8.5", "whole number"),
        ("bearing.speed_rpm=.nan", ".nan"),
        ("bearing.speed_rpm=0", "greater than 0"),
        ("bearing.pitch_diameter_mm=9", "above 20.75"),
        ("bearing.surfaces.inner={kind: graded, grade: G5}", "gaussian, smooth, file"),
        ("bearing.surfaces.outer={kind: smooth, waviness: {1: 0.1}}", "from 2 on"),
        ("bearing.surfaces.outer={kind: smooth, waviness: {99999: 0.1}}", "up to 6"),
        ("plate={material: steel-s235}", "missing"),
        (
            f"plate={{material: steel-s235, thickness_mm: 0.1, {SIDES}}}",
            "plate.length_mm: the plate has some",
        ),
        (f"plate={{material: steel-s235, thickness_mm: 1, edges: free, {SIDES}}}", "plate.edges: "),
        ("plate={material: steel-s235, length_mm: 300}", "plate.width_mm: missing"),
        ("sound.duration_s=-1", "greater than 0"),
    ],
)
def test_bad_input_gets_a_clear_message(override: str, words: str) -> None:
    text = faults(override)[0]
    assert text.startswith("--set: ") and words in text


def test_faults_of_a_surface_lie_on_it() -> None:
    pit: dict[str, Any] = {"kind": "pit", "at_mm": [10, 0], "size_um": 80, "depth_um": 3}
    surfaces = {"outer": {"kind": "smooth", "faults": [pit]}}
    scene = bearing().with_({"bearing.surfaces": surfaces})
    assert scene.circumferences["outer"] == pytest.approx(math.pi * 41.2645e-3, rel=1e-5)
    with pytest.raises(SceneError, match=r"surfaces.outer.faults\[0\].at_mm: got \[200, 0\]"):
        surfaces["outer"]["faults"][0]["at_mm"] = [200, 0]
        bearing().with_({"bearing.surfaces": surfaces})


# ---- check

INCHES = """\
name: inches
bearing:
  balls: 9
  ball_diameter_mm: 0.3126
  pitch_diameter_mm: 1.537
  contact_angle_deg: 0
  speed_rpm: 1797
  radial_load_n: 10
"""


def size_doubts(*overrides: str) -> list[str]:
    """Return what the check says about the size of a bearing that is typed in inches."""
    scene = loads_bearing(INCHES, overrides)
    return [doubt.text for doubt in scene_rules(scene) if getattr(doubt, "key", "") == "size"]


def test_sizes_in_inches_are_doubted() -> None:
    (text,) = size_doubts()
    assert "no such bearing is made" in text and "sizes in inches?" in text
    named = {"6204": (8, 0.3125, 1.319), "608": (7, 0.1563, 0.5906), "6305": (7, 0.4528, 1.7126)}
    for balls, ball, pitch in named.values():
        sizes = [f"bearing.balls={balls}", f"bearing.ball_diameter_mm={ball}"]
        assert size_doubts(*sizes, f"bearing.pitch_diameter_mm={pitch}", "bearing.radial_load_n=1")


@pytest.mark.parametrize(
    ("bore", "outside", "balls", "ball", "pitch"),
    [
        (0.5, 1.5, 6, 0.25, 1.0),
        (0.6, 2.0, 6, 0.35, 1.3),
        (1.0, 3.0, 6, 0.5, 2.0),
        (1.0, 3.0, 7, 0.5, 2.0),
        (1.5, 4.0, 8, 0.6, 2.75),
        (3.0, 10.0, 7, 1.588, 6.5),
    ],
)
def test_a_miniature_bearing_is_not_doubted(
    bore: float, outside: float, balls: int, ball: float, pitch: float
) -> None:
    """Bore and outside diameter of bearings in catalogues; their balls are usual proportions."""
    assert not size_doubts(
        f"bearing.bore_mm={bore}",
        f"bearing.outside_diameter_mm={outside}",
        f"bearing.balls={balls}",
        f"bearing.ball_diameter_mm={ball}",
        f"bearing.pitch_diameter_mm={pitch}",
        "bearing.radial_load_n=0.5",
    )


@pytest.mark.parametrize(("across_mm", "is_told"), [(0, False), (0.3, False), (2, True)])
@pytest.mark.parametrize("body", ["inner", "outer", "balls"])
def test_a_pit_beside_the_track_is_told(body: str, across_mm: float, is_told: bool) -> None:
    pit = {"kind": "pit", "at_mm": [2, across_mm], "size_um": 300, "depth_um": 5}
    scene = bearing().with_({"bearing.surfaces": {body: {"kind": "smooth", "faults": [pit]}}})
    told = [doubt for doubt in scene_rules(scene) if getattr(doubt, "key", "") == "fault_beside"]
    assert bool(told) == is_told
    for doubt in told:
        assert f"{body}.faults[0]" in doubt.text and "beside the track" in doubt.text


def test_a_clearance_that_is_not_given_is_assumed() -> None:
    words = ["bearing.contact_angle_deg=null"]
    assert "radial_clearance_um" in assumed_keys(loads_bearing(INCHES, words))
    assert "radial_clearance_um" not in assumed_keys(loads_bearing(INCHES))
    assert "radial_clearance_um" not in assumed_keys(bearing())


def test_the_check_says_what_a_designer_asks_for(capsys: pytest.CaptureFixture[str]) -> None:
    """Numbers of DYNAMICS: Z 8, D 7.938 mm, d_m 33.5 mm, 12 degrees, 30 Hz, 70 N."""
    rows = {row.key: row.value for row in bearing().check()}
    assert rows["cage"] == "11.5 Hz" and rows["BPFO"] == "92.2 Hz" and rows["BPFI"] == "148 Hz"
    assert rows["ball spin"] == "59.9 Hz" and rows["ball_loads"] == "42.1 N each"
    assert "63 to 77 N" not in rows["iso_15242"] or "as the standard asks" in rows["iso_15242"]
    assert cli.main(["check", "bearing-6204"]) == 0
    printed = capsys.readouterr().out
    for words in ("It runs in", "BPFO 92.3 Hz", "835 MPa", "ISO 15242", "Assumed, with how far"):
        assert words in printed
    assert max(map(len, printed.splitlines())) <= 100
    assert cli.main(["check", "-v", "bearing-6204"]) == 0
    assert "5/16 inch" in capsys.readouterr().out


def test_the_check_of_a_load_zone_and_of_an_outer_ring_that_turns() -> None:
    turned = bearing("bearing.turning=outer", "bearing.radial_load_n=100")
    findings = turned.check()
    rows = {row.key: row.value for row in findings}
    least, most = rows["ball_loads"].removesuffix(" N").split(" to ")
    assert float(least) < 70 / 8 / math.sin(math.radians(12)) < float(most)
    assert "outer ring turns" in rows["iso_15242"] and "100 N radial" in rows["iso_15242"]
    assert {doubt.key for doubt in findings.doubts["trial"]} >= {"iso_15242", "smooth"}


def test_a_bad_file_is_refused_by_the_check(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "b.yaml"
    file.write_text(TEXT.replace("balls: 8", "balls: 14"))
    assert cli.main(["check", str(file)]) == 2
    assert "b.yaml:3: bearing.balls: got 14, allowed: at most 13" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["b.yaml"]
    assert cli.main(["schema", "--kind", "bearing"]) == 0
    assert "ball_diameter_mm" in capsys.readouterr().out


def test_nodes_too_far_apart_for_the_contacts_are_refused_with_a_distance_that_fits() -> None:
    """The check refuses what a run would, and names a key of the bearing."""
    surface = "{kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 900, seed: 1}"
    rough = f"bearing.surfaces.inner={surface}"
    with pytest.raises(SceneError, match=r"^--set: numerics\.spacing_um: .* allowed: ") as error:
        bearing(rough, "numerics.spacing_um=300").check()
    allowed = str(error.value).rpartition(" ")[2]
    assert bearing(rough, f"numerics.spacing_um={allowed}").check().refusal is None


def test_an_unknown_option_beside_a_bearing_is_the_only_fault(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit):
        cli.main(["run", "bearing-6204", "sound.listen_s=3"])
    said = capsys.readouterr().err
    assert "got sound.listen_s=3" in said and "bearing:" not in said


def test_a_file_that_holds_no_turn_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "b.yaml"
    surfaces = "  surfaces: {inner: {kind: file, path: turn.npy, spacing_um: 20}}\n"
    file.write_text(TEXT + surfaces)
    assert cli.main(["check", str(file)]) == 2
    assert "bearing.surfaces.inner.path: turn.npy: " in capsys.readouterr().err
    np.save(tmp_path / "turn.npy", np.zeros((100, 1)))
    assert cli.main(["check", str(file)]) == 2
    (line,) = capsys.readouterr().err.splitlines()[-1:]
    allowed = int(line.partition("allowed: ")[2].split()[0])
    assert "got 100 nodes" in line
    np.save(tmp_path / "turn.npy", np.zeros((allowed, 1)))
    assert cli.main(["check", str(file)]) == 0


@pytest.mark.parametrize("path", BEARINGS, ids=lambda path: path.stem)
def test_every_bearing_of_the_library_runs_and_names_its_lines(path: Path) -> None:
    findings = rolling.read_scene(path).check()
    assert findings.refusal is None and findings.seconds < 300
    for rows in findings.runs.values():
        assert {"BPFO", "BPFI", "ball_loads", "ring_bending"} <= {row.key for row in rows}


def _doubts(*overrides: str) -> dict[str, Any]:
    """Return the doubts of the check of a scene by key."""
    found = [found for found in scene_rules(bearing(*overrides)) if isinstance(found, Doubt)]
    return {doubt.key: doubt for doubt in found}


def test_the_check_says_how_a_free_ring_spreads_a_radial_load() -> None:
    """A bending ring takes load off the ball in the middle; a stiff seat follows Stribeck's sum."""
    loads = ("bearing.angle=moving", "bearing.axial_load_n=0", "bearing.radial_load_n=1000")
    closed = (*loads, "bearing.contact_angle_deg=", "bearing.radial_clearance_um=0")
    places = 2 * math.pi * np.arange(8) / 8
    stribeck = 1000 / np.sum(np.maximum(np.cos(places), 0) ** 2.5)
    doubt = _doubts(*closed)["free_ring"]
    assert f" and {stribeck:.0f} N where a stiff seat holds the ring" in doubt.text
    assert "free_ring" not in _doubts(*closed, "bearing.ring=rigid")
    assert "free_ring" not in _doubts("bearing.angle=moving")  # all balls bear alike


def test_what_the_standard_does_not_measure_departs_from_it() -> None:
    """Loads are quoted for deep grooves, and a class is that of a ring that nothing is fixed to."""
    text = bearing("bearing.contact_angle_deg=25")
    assert "a contact angle of 25 degrees" in departures(text)[0]
    assert departures(bearing("bearing.ring_mass_kg=1"))[0].endswith(
        "fixed to the ring that is measured"
    )
    assert not departures(bearing())


def test_a_resonance_without_losses_has_no_velocity() -> None:
    doubts = _doubts("bearing.contact_loss_factor=0")
    assert doubts["lasting_resonance"].severity is Severity.DO_NOT_QUOTE
    assert not any(key.startswith("edge_of") for key in doubts)
    assert "lasting_resonance" not in _doubts()
    oil = "bearing.oil={viscosity_40_mm2_s: 100}"
    assert "lasting_resonance" not in _doubts("bearing.contact_loss_factor=0", oil)
    words = conclusion(bearing("bearing.contact_loss_factor=0").check())
    assert "will be under the verdict do not quote" in words and "at best" not in words


def test_the_check_says_how_long_the_record_is_and_what_makes_it_shorter() -> None:
    rows = {
        row.key: row.value
        for row in scene_rules(bearing("sound={duration_s: 0.3}"))
        if isinstance(row, Finding)
    }
    assert rows["record"].startswith("5 s, ") and "sound.listen_s" in rows["record"]
    short = bearing("sound={duration_s: 0.3, listen_s: 0.2}")
    rows = {row.key: row.value for row in scene_rules(short) if isinstance(row, Finding)}
    assert rows["record"] == "0.3 s" and short.moved == 0.3
