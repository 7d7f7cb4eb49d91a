"""Conditions of an answer: fields of each kind of scene, and lines, columns and a paragraph."""

from __future__ import annotations

import io
from typing import Any

import pandas as pd
import pytest

import rolling as rc
from rolling.ball_kinds.ball_conditions import preparation_words
from rolling.kinds.registry import kind_of
from rolling.kinds.stated_conditions import conditions_of, with_conditions
from rolling.results.runs_table import csv_bytes


@pytest.fixture
def two() -> dict[str, rc.Scene]:
    """Return two scenes that differ in their load."""
    scene = rc.read_scene("quickstart").with_(load_n=5, sweep={}, duration_s=0.1)
    return {"light": scene, "heavy, or so": scene.with_(load_n=20)}


def test_what_scenes_share_stands_once(two: dict[str, rc.Scene]) -> None:
    conditions = conditions_of(two)
    assert [one.name for one in conditions.own["light"]] == ["load"]
    first, *others = conditions.lines
    assert rc.__version__ in first and "m/s" in first and "load:" not in first
    assert others == ["For light, load: 5 N.", "For heavy, or so, load: 20 N."]
    paragraph = conditions.paragraph(["The second one is louder."])
    assert all(one.words in paragraph for one in conditions.shared)
    assert "20 N" in paragraph and "The second one is louder." in paragraph


def test_a_table_with_conditions_is_read_as_it_was(two: dict[str, rc.Scene]) -> None:
    """Columns at the end break no reader, and each row can be cited alone."""
    table = pd.DataFrame({"candidate": [*two], "vibration_db": [1.5, 2.5]})
    conditions = conditions_of(two)
    content = csv_bytes(with_conditions(table, conditions, [*two]))
    read = pd.read_csv(io.BytesIO(content))
    pd.testing.assert_frame_equal(read[["candidate", "vibration_db"]], table, check_dtype=False)
    assert read["load"].to_list() == ["5 N", "20 N"]
    assert read["program"].nunique() == 1
    empty = with_conditions(table, conditions_of({"gone": None}), ["gone", "gone"])
    assert empty.columns.to_list() == table.columns.to_list()


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("quickstart", ["ball", "plate", "load", "speed", "track", "listener", "surface"]),
        ("marble-dropped", ["ball", "plate", "load", "speed", "track", "listener", "surface"]),
        ("bearing-6204", ["bearing", "geometry", "load", "speed", "oil", "sensor", "balls"]),
    ],
)
def test_each_kind_states_its_conditions(name: str, wanted: list[str]) -> None:
    scene = rc.read_scene(name).runs()[0].scene
    conditions = kind_of(scene).conditions(scene)
    names = [one.name for one in conditions]
    assert names[: len(wanted)] == wanted
    assert all(one.words for one in conditions)
    assert kind_of(scene).method(scene).computed


def test_the_preparation_of_a_scan_is_stated_in_its_order() -> None:
    surface = rc.HeightFile(
        path="scan.csv",
        spacing_um=2,
        outliers=6,
        unmeasured="fill",
        level="quadratic",
        s_filter_um=5,
        l_filter_um=800,
        periodic="blend",
    )
    words = preparation_words(surface, 2.0)
    steps = ["6 robust", "unmeasured", "index 0.005 mm", "second order", "index 0.8 mm", "faded"]
    places = [words.index(step) for step in steps]
    assert places == sorted(places)


@pytest.mark.parametrize(
    ("name", "keys", "wanted"),
    [
        ("scan.txt", {}, "taken as one period"),
        ("scan.txt", {"periodic": "blend"}, "faded"),
        ("scan.xyz", {}, "faded"),
        ("scan.asc", {"spacing_um": 2}, "faded"),
        ("scan.npy", {"spacing_um": 2}, "taken as one period"),
    ],
)
def test_how_a_scan_is_closed_is_what_the_scene_does(
    name: str, keys: dict[str, Any], wanted: str
) -> None:
    """By the ending of its name, whether the file or the scene holds the spacing."""
    words = preparation_words(rc.HeightFile(path=name, **keys), 2.0)
    assert wanted in words and "nodes 2 µm apart" in words
