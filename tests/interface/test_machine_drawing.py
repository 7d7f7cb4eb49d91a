"""The drawing of a machine has the numbers of its scene, and none of them covers another one."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from ball_between_plates import KIND as BETWEEN_PLATES
from bearing_runs import loads_bearing
from matplotlib.font_manager import FontProperties, findfont
from PIL import ImageFont
from report_runs import runs_of

from rolling.kinds.machine import Machine
from rolling.kinds.reading import read_scene
from rolling.kinds.registry import kind_of
from rolling.report import machine_drawing
from rolling.report.machine_drawing import COLUMN, EDGE, LETTER, WIDTH, machine_svg, text_boxes
from rolling.report.report_page import page
from rolling.report.text import asset
from rolling.scene.file import loads

SCENARIOS = Path(__file__).parents[2] / "scenarios"
LIBRARY = sorted(path for path in SCENARIOS.rglob("*.yaml") if path.parent.name != "pictures")
PHONE = 390 - 2 * 16  # pixels across a phone, without its margins
LEAST_LETTER = 11.0  # pixels
HOSTILE = "quoted \"one\" 'two' & </desc><img src=x onerror=alert(1)>" + 60 * "W"
BALL = """\
name: ball
sphere: {radius_mm: 5, density_kg_m3: 7850}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, density_kg_m3: 7850, thickness_mm: 4,
  length_mm: 300, width_mm: 200, loss_factor: 0.01, contact_mm: [100, 80]}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, spacing_um: 2,
  width_um: 128, seed: 1}
rolling: {load_n: 7.5, speed_m_s: 0.25, duration_s: 0.01}
dynamics: {}
sound: {source: vibration, distance_m: 0.7}
"""
BEARING = """\
name: bearing
bearing:
  named: "6204"
  speed_rpm: 1800
  axial_load_n: 70
  radial_load_n: 250
  surfaces:
    outer: {kind: smooth, faults: [{kind: pit, at_mm: [4, 0], size_um: 300, depth_um: 5}]}
    balls: {kind: graded, grade: G10, seed: 1}
"""
# Where the numbers of each drawing stand on the screen, and how high their letters are.
BOXES = """() => [...document.querySelectorAll('svg.machine')].map((svg) => {
  const scale = svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;
  return [...svg.querySelectorAll('text')].map((text) => {
    const { top, bottom, right } = text.getBoundingClientRect();
    return { top, bottom, right, letter: scale * parseFloat(getComputedStyle(text).fontSize) };
  });
})"""


def drawn(*scenes: Any, numbers: Sequence[Any] = ()) -> Machine:
    """Return the drawing of scenes of one kind."""
    machine = kind_of(scenes[0]).machine(scenes, numbers)
    assert machine is not None
    return machine


def said(machine: Machine) -> dict[str, str]:
    """Return the values of a drawing by their words."""
    return {callout.words: callout.value for callout in machine.callouts}


def circles(machine: Machine, role: str) -> list[tuple[float, float, float]]:
    """Return middle and radius of the circles of a role."""
    found = []
    for shape in machine.shapes:
        for x, y, radius in re.findall(r"M(\S+) (\S+?)a(\S+) ", shape.path):
            if shape.role == role:
                found.append((float(x) + float(radius), float(y), float(radius)))
    return found


@pytest.mark.law("drawing: no number of a scene of the library covers another or leaves the page.")
@pytest.mark.parametrize("path", LIBRARY, ids=lambda path: str(path.relative_to(SCENARIOS)))
def test_no_number_covers_another_one(path: Path) -> None:
    machine = drawn(*(scene for _, scene in read_scene(path).runs()))
    boxes = text_boxes(machine)
    assert len(boxes) == len(machine.callouts) > 4
    assert boxes[0].top >= EDGE
    assert all(upper.top + upper.height < lower.top for upper, lower in pairwise(boxes))
    last = boxes[-1]
    assert last.top + last.height <= machine_drawing.drawing_height(machine) - EDGE + 1e-9
    assert all(COLUMN + box.width <= WIDTH for box in boxes)
    assert all(0 <= callout.at[0] <= COLUMN for callout in machine.callouts)


def test_letters_are_no_wider_than_they_are_taken_to_be() -> None:
    """DejaVu Sans is the widest of the fonts that pages usually have."""
    fonts = {}
    for weight in ("normal", "bold"):
        path = findfont(FontProperties(family="DejaVu Sans", weight=weight))
        fonts[weight] = ImageFont.truetype(path, 100)
    for path in LIBRARY:
        for box in text_boxes(drawn(*(scene for _, scene in read_scene(path).runs()))):
            for number, line in enumerate(box.lines):
                is_bold = number < box.values
                font = fonts["bold" if is_bold else "normal"]
                own = font.getlength(line) * LETTER / 100
                estimate = machine_drawing.text_width(line, is_bold)
                assert own <= 1.02 * estimate, line
                assert COLUMN + own <= WIDTH, line


@pytest.mark.parametrize(
    ("key", "value", "shown"),
    [
        ("rolling.load_n", 33.0, "33 N"),
        ("rolling.load_n", "weight", "0.0403 N"),
        ("rolling.speed_m_s", 0.4, "0.4 m/s"),
        ("sphere.radius_mm", 6.5, "R 6.5 mm"),
        ("plate.thickness_mm", 9.0, "9 mm thick"),
        ("plate.length_mm", 310.0, "310 x 200 mm"),
        ("plate.contact_mm", [110, 80], "[110, 80] mm"),
        ("surface.roughness_ra_um", 0.3, "Ra 0.3 µm"),
        ("sound.distance_m", 0.9, "0.9 m"),
        ("sound.listener_mm", [100, 80, 400], "0.4 m"),
    ],
)
def test_a_number_of_a_ball_stands_on_its_drawing(key: str, value: Any, shown: str) -> None:
    scene = loads(BALL)
    assert shown not in said(drawn(scene)).values()
    assert shown in said(drawn(scene.with_({key: value}))).values()


def test_numbers_in_which_runs_differ_are_listed() -> None:
    scene = loads(BALL)
    machine = drawn(*(scene.with_(load_n=load) for load in (5, 20, 100)))
    assert said(machine)["load"] == "5, 20 and 100 N"


def test_a_fall_has_its_height_and_no_load_above_the_ball() -> None:
    fall = loads(BALL).with_({"rolling.drop_mm": 30, "rolling.load_n": "weight"})
    rolls = drawn(loads(BALL))
    falls = drawn(fall)
    assert said(falls)["height of the fall"] == "30 mm"
    assert "height of the fall" not in said(rolls)
    (_, y, radius) = circles(falls, "body")[0]
    (_, y_rolling, radius_rolling) = circles(rolls, "body")[0]
    assert y + radius < y_rolling + radius_rolling - 20  # it hangs above the plate


def test_the_profile_is_the_taller_the_rougher_the_plate_is() -> None:
    heights = []
    for ra_um in (0.01, 0.1, 1.0):
        machine = drawn(loads(BALL).with_({"surface.roughness_ra_um": ra_um}))
        (edge, *_) = [shape.path for shape in machine.shapes if shape.role == "edge"]
        places = [float(y) for y in re.findall(r"[ML]\S+ ([\d.]+)", edge)]
        heights.append(max(places) - min(places))
    assert heights[0] > 0
    assert heights == sorted(heights) and len(set(heights)) == 3


def test_a_run_knows_the_roughness_of_its_file() -> None:
    runs = runs_of("lap")
    machine = drawn(*(run.scene for run in runs), numbers=[run.numbers for run in runs])
    ra_um = 1e6 * runs[0].numbers.surface.ra_m
    assert f"Ra {ra_um:.3g} µm" in said(machine).values()


def test_sensors_stand_on_the_plate_where_the_scene_has_them() -> None:
    channels = [
        {"of": "plate", "quantity": "acceleration", "x_mm": 30, "y_mm": 40, "name": "corner"},
        {"of": "contact", "quantity": "force"},
    ]
    machine = drawn(loads(BALL).with_({"sound.channels": channels}))
    assert said(machine)["acceleration at [30, 40] mm"] == "corner"
    assert sum(shape.role == "sensor" for shape in machine.shapes) == 2


@pytest.mark.law("drawing: a bearing has its balls, in proportion and with the loads of a balance.")
def test_balls_of_a_bearing_are_in_proportion_and_their_shades_balance_the_load() -> None:
    scene = loads_bearing(BEARING)
    machine = drawn(scene)
    rings = circles(machine, "body")
    balls = circles(machine, "load")
    outer = max(radius for _, _, radius in rings)
    middle_x, middle_y, _ = max(rings, key=lambda ring: ring[2])
    assert len(balls) == scene.bearing.balls
    assert balls[0][2] / outer == pytest.approx(7.938 / 47, rel=0.01)
    pitches = [math.dist((x, y), (middle_x, middle_y)) for x, y, _ in balls]
    assert pitches == pytest.approx([outer * 33.5 / 47] * 8, rel=0.01)
    largest_n = next(
        float(callout.value.removesuffix(" N"))
        for callout in machine.callouts
        if "loaded" in callout.words
    )
    shares = [shape.share for shape in machine.shapes if shape.role == "load"]
    downwards = [(y - middle_y) / pitch for (_, y, _), pitch in zip(balls, pitches, strict=True)]
    radial_n = sum(
        largest_n * share * down * math.cos(scene.contact_angle)
        for share, down in zip(shares, downwards, strict=True)
    )
    assert radial_n == pytest.approx(250, rel=0.02)  # three digits of a load and two of a share


def test_a_fault_of_a_raceway_is_on_it_and_one_of_a_ball_in_its_ball() -> None:
    scene = loads_bearing(BEARING)
    machine = drawn(scene)
    ((x, y, _),) = circles(machine, "fault")
    outer = max(radius for _, _, radius in circles(machine, "body"))
    middle_x, middle_y, _ = max(circles(machine, "body"), key=lambda ring: ring[2])
    raceway = outer * scene.geometry.outer.radius_m / (scene.outside_diameter / 2)
    assert math.dist((x, y), (middle_x, middle_y)) == pytest.approx(raceway, abs=0.2)
    angle = math.atan2(x - middle_x, y - middle_y)  # from the middle of the load zone
    assert angle == pytest.approx(4e-3 / scene.geometry.outer.radius_m, abs=0.01)
    assert said(machine)["outer raceway"] == "a pit of 300 µm"


def test_a_bearing_on_a_plate_has_a_listener_and_one_without_has_a_sensor() -> None:
    alone = drawn(loads_bearing(BEARING))
    plate = {"material": "steel-s235", "thickness_mm": 3, "length_mm": 300, "width_mm": 200}
    housed = drawn(loads_bearing(BEARING).with_({"plate": plate}))
    assert said(housed)["listener"] == "1 m"
    assert "300 x 200 x 3 mm" in said(housed).values()
    assert "listener" not in said(alone)
    assert [sum(s.role == "sensor" for s in each.shapes) for each in (alone, housed)] == [1, 0]


@pytest.mark.parametrize(("angle_deg", "place"), [(90, (1, 0)), (-90, (-1, 0)), (0, (0, 1))])
def test_a_sensor_on_a_ring_stands_at_its_angle(angle_deg: float, place: tuple[int, int]) -> None:
    """Angles count from the middle of the load zone, below, to the right."""
    scene = loads_bearing(BEARING).with_({"bearing.sensor_deg": angle_deg})
    machine = drawn(scene)
    middle_x, middle_y, radius = max(circles(machine, "body"), key=lambda ring: ring[2])
    (sensor,) = [shape for shape in machine.shapes if shape.role == "sensor"]
    x, y = (float(number) for number in re.findall(r"[-\d.]+", sensor.path)[:2])  # a corner
    half = 5
    right, down = place
    assert x + half - middle_x == pytest.approx(right * (radius + half), abs=0.5)
    assert y + half - middle_y == pytest.approx(down * (radius + half), abs=0.5)


def test_a_drawn_ball_bears_what_it_does_under_a_ring_that_bends() -> None:
    """The shades and the load are those of the model that moves, not of a ring that stays round."""
    loads = {"bearing.axial_load_n": 0, "bearing.radial_load_n": 1000, "bearing.angle": "moving"}
    largest = {}
    for ring in ("elastic", "rigid"):
        scene = loads_bearing(BEARING).with_({**loads, "bearing.ring": ring})
        (words,) = (words for words in said(drawn(scene)) if words.startswith("most loaded"))
        largest[ring] = said(drawn(scene))[words]
        assert largest[ring] == f"{scene.model.balance().ball_load_n.max():.0f} N"
    assert largest["elastic"] != largest["rigid"]


def test_the_drawing_is_text_for_eyes_and_ears_and_has_the_colours_of_the_page() -> None:
    scene = loads(BALL).with_({"sound.channels": [{"of": "ball", "quantity": "velocity"}]})
    channel = {"of": "plate", "quantity": "velocity", "x_mm": 9, "y_mm": 9, "name": HOSTILE[:60]}
    machine = drawn(scene.with_({"sound.channels": [channel]}))
    svg = machine_svg(machine)
    root = ElementTree.fromstring(svg)
    words = "".join(text.text or "" for text in root.iter("desc"))
    assert (
        root.get("role") == "img" and root.get("aria-labelledby") == "machine-title machine-words"
    )
    assert "load: 7.5 N" in words and "speed: 0.25 m/s" in words
    assert [text for text in root.iter("tspan") if text.text == "7.5\N{NO-BREAK SPACE}N"]
    assert not re.search(r"#[0-9a-f]{3,6}\b|<image|<script|<img|onerror=(?!alert)", svg)
    assert LETTER * PHONE / WIDTH >= LEAST_LETTER
    assert len(svg) < 9000


def test_pages_have_the_drawing_of_the_first_scene_and_a_kind_without_one_has_none() -> None:
    runs = runs_of("lap", "smooth")
    html = page(runs).decode()
    assert html.count('<svg class="machine"') == 1
    assert f"Drawn: {runs[0].scene.name}." in html
    assert "Drawn:" not in page(runs_of("lap")).decode()
    assert BETWEEN_PLATES.machine([None]) is None


@pytest.mark.slow
def test_no_number_covers_another_one_in_a_browser_on_a_phone(opened, tmp_path: Path) -> None:
    drawings = []
    for path in LIBRARY:
        drawings.append(machine_svg(drawn(*(scene for _, scene in read_scene(path).runs()))))
    figures = "".join(f"<figure class=drawing>{svg}</figure>" for svg in drawings)
    head = "<!doctype html><html lang=en><meta charset=utf-8><title>drawings</title>"
    sheet = tmp_path / "drawings.html"
    sheet.write_text(f"{head}<style>{asset('report.css')}</style>{figures}", encoding="utf-8")
    with opened(sheet, viewport={"width": 390, "height": 844}) as shown:
        measured = shown.evaluate(BOXES)
    assert len(measured) == len(LIBRARY)
    for path, boxes in zip(LIBRARY, measured, strict=True):
        assert all(upper["bottom"] <= lower["top"] + 1 for upper, lower in pairwise(boxes)), path
        assert all(box["right"] <= 390 and box["letter"] >= LEAST_LETTER for box in boxes), path
