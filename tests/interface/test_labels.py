"""The labels of any runs differ, name the difference, can be printed and stay short.

Every key of a scene has its words.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_text import PLAIN

from rolling.kinds.run_folder import RunFolder
from rolling.results import labels
from rolling.results.labels import LONGEST
from rolling.scene import file, models
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.scene import Scene

SCENE = file.loads(PLAIN)


def scene(folder: Path = Path(), **keys: Any) -> Scene:
    """Return the scene of the tests with keys set; `__` stands for a dot, None removes a key."""
    data = SCENE.to_dict()
    for key, value in keys.items():
        section, _, last = key.partition("__")
        if last:
            data.setdefault(section, {})[last] = value
        else:
            data[section] = value
    return Scene.from_dict(data, folder)


@dataclass(frozen=True)
class Case:
    scene: Scene
    folder: Path = Path("runs/a")
    values: dict[str, float | str] = field(default_factory=dict)
    home = RunFolder.home


def of(*cases: Case) -> list[str]:
    return labels.labels(cases)


def test_every_key_of_the_scene_has_words() -> None:
    """Every key of a ball and of a bearing has words, except name, description and sweep."""
    for model in (Scene, BearingScene):
        keys = {*models.keys(model)} - {*models.section_keys(model)}
        assert len(keys) > 25
        assert keys <= set(labels.WORDS)
        words = [word.word or word.unit for key, word in labels.WORDS.items() if key in keys]
        assert len(set(words)) == len(words)


def test_a_pair_of_edges_is_named() -> None:
    """A single run of such a plate has a label, and so have plates whose pairs differ."""
    plate = {**SCENE.to_dict()["plate"], "length_mm": 120, "width_mm": 80, "thickness_mm": 3}
    plate |= {"density_kg_m3": 7800, "loss_factor": 0.01}
    pairs = [{"length": "free", "width": "clamped"}, {"length": "clamped", "width": "free"}]
    ball = {**SCENE.to_dict()["sphere"], "density_kg_m3": 7800}
    cases = []
    for pair in pairs:
        cases.append(Case(scene(sphere=ball, plate={**plate, "edges": pair}, dynamics={})))
    assert of(cases[0])
    first, second = of(*cases)
    assert "length: free" in first and "length: clamped" in second


def test_a_run_and_its_resound_are_told_apart_by_the_speed() -> None:
    """The duration follows from the speed; the folders' names would say nothing."""
    fast = scene(rolling__speed_m_s=0.2, rolling__duration_s=0.005)
    assert of(
        Case(SCENE, Path("o/2026-01-01T00-00-00")), Case(fast, Path("o/2026-01-01T00-00-05"))
    ) == [
        "speed 0.1 m/s",
        "speed 0.2 m/s",
    ]


@pytest.mark.parametrize(
    ("keys", "names"),
    [
        ({"surface__roughness_ra_um": 0.2}, ["Ra 0.1 µm", "Ra 0.2 µm"]),
        (
            {"surface__autocorrelation": "exponential_10pct"},
            ["autocorrelation gaussian", "autocorrelation exponential 10pct"],
        ),
        ({"plate__hardness_gpa": None}, ["hardness 2.1 GPa", "no hardness"]),
        ({"rolling__speed_m_s": [[0, 0.1], [1, 0.3]]}, ["speed 0.1 m/s", "speed 0.1 to 0.3 m/s"]),
        (
            {"surface": {"kind": "smooth", "spacing_um": 2, "width_um": 64}},
            ["surface gaussian", "surface smooth"],
        ),
        ({"sound__loudness": True}, ["without loudness", "with loudness"]),
        ({"rolling__start_um": 10}, ["start 0 µm", "start 10 µm"]),
        ({"name": "other"}, ["trial, load 20 N", "other, load 20 N"]),
    ],
)
def test_labels_name_the_difference(keys, names) -> None:
    for label, words in zip(of(Case(SCENE), Case(scene(**keys))), names, strict=True):
        assert words in label
        assert "load" not in label or "load" in words


def test_differences_that_matter_are_named_even_where_the_load_would_do() -> None:
    assert of(Case(SCENE), Case(scene(rolling__load_n=5, rolling__speed_m_s=0.2))) == [
        "load 20 N, speed 0.1 m/s",
        "load 5 N, speed 0.2 m/s",
    ]


def test_values_that_print_alike_have_all_their_digits() -> None:
    seeds = (10**16, 10**16 + 1)
    assert of(*(Case(scene(surface__seed=seed)) for seed in seeds)) == [
        f"seed {seed}" for seed in seeds
    ]
    assert of(*(Case(scene(rolling__load_n=load)) for load in (5.0, 5.00000001))) == [
        "load 5.0 N",
        "load 5.00000001 N",
    ]
    profiles = [[[0, 0.1], [1, 0.3]], [[0, 0.1], [2, 0.3]]]
    first, second = of(*(Case(scene(rolling__speed_m_s=profile)) for profile in profiles))
    assert "at 1.0 s" in first and "at 2.0 s" in second


def test_height_files_are_told_apart_by_as_much_of_their_place_as_it_takes() -> None:
    surface = {"kind": "file", "path": "z.npy", "spacing_um": 2}
    ground, turned = (
        Case(scene(Path("/data") / name, surface=surface)) for name in ("ground", "turned")
    )
    assert of(ground, turned) == ["heights ground/z.npy", "heights turned/z.npy"]
    # The same file, seen from two folders, is no difference.
    near = scene(Path("/data/ground"), surface=surface | {"path": "../turned/z.npy"})
    assert of(turned, Case(near, Path("runs/b"))) == ["load 20 N (a)", "load 20 N (b)"]


def test_equal_scenes_are_told_apart_by_folder_and_then_by_number() -> None:
    a = Case(SCENE, Path("runs/a"))
    b = Case(SCENE, Path("runs/b"))
    assert of(a, b) == ["load 20 N (a)", "load 20 N (b)"]
    assert of(a, a) == ["load 20 N (1)", "load 20 N (2)"]
    assert of(a, a, b) == ["load 20 N (a) (1)", "load 20 N (a) (2)", "load 20 N (b)"]


def test_a_sweep_is_named_by_its_values_whether_alone_or_together() -> None:
    swept = file.loads(PLAIN + "sweep: {rolling.load_n: [5, 20], surface.seed: [1, 2]}\n")
    runs = [
        Case(single, Path("runs") / str(k), values)
        for k, (values, single) in enumerate(swept.runs())
    ]
    names = [f"load {load} N, seed {seed}" for load in (5, 20) for seed in (1, 2)]
    assert of(*runs) == [of(run)[0] for run in runs] == names
    assert of(Case(SCENE)) == ["load 20 N"]


def test_values_under_labels_are_named_by_them() -> None:
    lapped = scene(surface__roughness_ra_um=0.2)
    cases = [Case(SCENE, values={"surface": "ground"}), Case(lapped, values={"surface": "lapped"})]
    assert of(*cases) == ["surface ground", "surface lapped"]


def test_long_names_are_cut_and_stand_once() -> None:
    names = [f"{'a' * 40}{digit}{'b' * 23}" for digit in "12"]
    names = of(*(Case(scene(name=name, surface__seed=k)) for k, name in enumerate(names)))
    assert len(set(names)) == 2 and max(map(len, names)) <= LONGEST
    assert labels.title("quickstart", "quickstart, load 5 N") == "quickstart, load 5 N"
    assert labels.title("quickstart", "load 5 N") == "quickstart, load 5 N"


def test_ten_swept_keys_stay_short_and_apart() -> None:
    keys = [
        "rolling__load_n",
        "sphere__density_kg_m3",
        "plate__hardness_gpa",
        "sphere__radius_mm",
        "sound__distance_m",
    ]
    cases = [
        Case(
            scene(
                **{key: 10 + (k >> n & 1) for n, key in enumerate(keys)},
                surface__seed=k,
                surface__roughness_ra_um=k + 1,
                plate__youngs_modulus_gpa=100 + (k >> 1 & 1),
            )
        )
        for k in range(32)
    ]
    names = of(*cases)
    assert len(set(names)) == 32 and max(map(len, names)) <= LONGEST


NAMES = st.from_regex(r"\A[A-Za-z0-9][A-Za-z0-9._-]{0,63}\Z")
# As an operating system gives them: any letters but the slash and nought, bytes that are no UTF-8
# as surrogates.
FOLDERS = st.text(
    st.characters(exclude_characters="/\0", exclude_categories=["Cs"]), min_size=1, max_size=80
) | st.binary(min_size=1, max_size=20).map(
    lambda content: (
        content.replace(b"/", b"_").replace(b"\0", b"$").decode("utf-8", "surrogateescape")
    )
)
KEYS = st.fixed_dictionaries(
    {},
    optional={
        "name": NAMES | st.sampled_from(["x" * 60, "x" * 59 + "y"]),
        "rolling__load_n": st.floats(1e-3, 1e3),
        "rolling__speed_m_s": st.sampled_from(
            [0.1, 0.2, [[0, 0.1], [1, 0.3]], [[0, 0.1], [2, 0.3]]]
        ),
        "surface__seed": st.integers(0, 10**20),
        "plate__hardness_gpa": st.none() | st.floats(0.1, 10),
        "sound__distance_m": st.floats(0.1, 10),
        "numerics__edges": st.sampled_from(["sharp", "blended"]),
        "recovery__events": st.booleans(),
    },
)
CASES = st.builds(
    lambda keys, name, swept: Case(
        scene(**keys), Path("runs") / name, {"rolling.load_n": 1.0} if swept else {}
    ),
    KEYS,
    FOLDERS,
    st.booleans(),
)


@settings(max_examples=150, deadline=None)
@given(st.lists(CASES, min_size=1, max_size=6), st.integers(0, 3))
def test_labels_of_any_runs_differ_and_can_be_printed(cases: list[Case], repeated: int) -> None:
    cases += cases[:repeated]
    names = of(*cases)
    assert len(names) == len(set(names)) == len(cases)
    for label in names:
        assert label.isprintable() and label == label.strip() and 0 < len(label) <= LONGEST
        assert not label.startswith("_")  # matplotlib would leave it out of a legend
        label.encode()


@given(st.text())
def test_printable_text_is_what_it_was_but_for_its_escapes(text: str) -> None:
    shown = labels.printable(text)
    assert shown.isprintable() and (shown == text) == text.isprintable()


def test_escapes_name_the_byte() -> None:
    assert labels.printable("a\nb\udcff\u202e") == "a\\nb\\xff\\u202e"


def test_contact_points_are_labelled_by_their_coordinates() -> None:
    plate = SCENE.to_dict()["plate"] | {"density_kg_m3": 7850.0, "thickness_mm": 3.0}
    plate |= {"loss_factor": 0.01, "length_mm": 300.0, "width_mm": 400.0}
    sphere = SCENE.to_dict()["sphere"] | {"density_kg_m3": 7850.0}
    points = [[90.0, 80.0], [90.00001, 80.0]]
    cases = [
        Case(scene(sphere=sphere, dynamics={}, plate=plate | {"contact_mm": point}))
        for point in points
    ]
    assert of(*cases) == ["contact point 90, 80 mm", "contact point 90.00001, 80 mm"]
