"""Scenes report every fault of a value, and have properties in SI, sweeps and tracks."""

import math
import pickle
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_text import PLAIN, SCENES, TEXT, faults

from rolling.scene.file import dump, loads, read_scene, resound
from rolling.scene.messages import SceneError
from rolling.scene.run_names import run_name
from rolling.scene.scene import Scene
from rolling.scene.sections import STEP_NODES
from rolling.scene.surfaces import Gaussian
from rolling.surface import heights as surface

NAME = (
    "1 to 64 letters, digits, dots, dashes or underscores, "
    "a letter or digit first (numbers in quotes)"
)
SECTIONS = (
    "name, description, sphere, plate, surface, rolling, numerics, recovery, dynamics, sound, sweep"
)


# ---- Messages


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("name: trial", "name: a/b", f's.yaml:1: name: got "a/b", allowed: {NAME}'),
        ("name: trial", "name: ../x", f's.yaml:1: name: got "../x", allowed: {NAME}'),
        ("name: trial", "name: 2024", f"s.yaml:1: name: got 2024, allowed: {NAME}"),
        ("name: trial\n", "\n", f"s.yaml:1: name: missing, allowed: {NAME}"),
        (
            "name: trial",
            "name: trial\ndescription: 3",
            "s.yaml:2: description: got 3, allowed: text",
        ),
        (
            "radius_mm: 5",
            "radius_mm: 0",
            "s.yaml:2: sphere.radius_mm: got 0, allowed: a number > 0",
        ),
        (
            "radius_mm: 5",
            'radius_mm: "5"',
            's.yaml:2: sphere.radius_mm: got "5", allowed: a number > 0',
        ),
        (
            "radius_mm: 5",
            "radius_mm: .nan",
            "s.yaml:2: sphere.radius_mm: got .nan, allowed: a number > 0",
        ),
        (
            "radius_mm: 5",
            "radius_mm: 1e300",
            "s.yaml:2: sphere.radius_mm: got 1e+300, allowed: a size from 1e-15 to 1e+15",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: 1e-300",
            "s.yaml:16: rolling.speed_m_s: got 1e-300, allowed: a size from 1e-15 to 1e+15",
        ),
        (
            "radius_mm: 5",
            "radius_mm: [5]",
            "s.yaml:2: sphere.radius_mm: got [5], allowed: a number > 0",
        ),
        (
            "radius_mm: 5",
            "radius_mm: 5, youngs_modulus_gpa: 210",
            "s.yaml:2: sphere.poissons_ratio: missing beside youngs_modulus_gpa; an elastic sphere "
            "needs both, a"
            " rigid sphere neither",
        ),
        (
            "radius_mm: 5",
            "radius_mm: 5, poissons_ratio: 0.3",
            "s.yaml:2: sphere.youngs_modulus_gpa: missing beside poissons_ratio; an elastic sphere "
            "needs both, a"
            " rigid sphere neither",
        ),
        (
            "sphere: {radius_mm: 5}\n",
            "",
            "s.yaml:1: sphere: missing, allowed: a section of keys (radius_mm)",
        ),
        (
            "sphere: {radius_mm: 5}",
            "sphere: 5",
            "s.yaml:2: sphere: got 5, allowed: a section of keys (radius_mm)",
        ),
        (
            "sphere: {radius_mm: 5}",
            "sphere:",
            "s.yaml:2: sphere: missing, allowed: a section of keys (radius_mm)",
        ),
        (
            "ratio: 0.3",
            "ratio: 0.6",
            "s.yaml:5: plate.poissons_ratio: got 0.6, allowed: a number >= 0 and <= 0.5",
        ),
        (
            "ratio: 0.3",
            "ratio: -0.1",
            "s.yaml:5: plate.poissons_ratio: got -0.1, allowed: a number >= 0 and <= 0.5",
        ),
        (
            "hardness_gpa",
            "hardnes_gpa",
            "s.yaml:6: plate.hardnes_gpa: unknown key, nearest: hardness_gpa, allowed: "
            "youngs_modulus_gpa,"
            " poissons_ratio, hardness_gpa, density_kg_m3, thickness_mm, loss_factor",
        ),
        (
            "hardness_gpa",
            "load_n",
            "s.yaml:6: plate.load_n: unknown key, nearest: rolling.load_n, allowed: "
            "youngs_modulus_gpa, poissons_ratio,"
            " hardness_gpa, density_kg_m3, thickness_mm, loss_factor",
        ),
        (
            "hardness_gpa: 2.1",
            "hardness_gpa: .inf",
            "s.yaml:6: plate.hardness_gpa: got .inf, allowed: a number > 0",
        ),
        (
            "kind: gaussian",
            "kind: gausian",
            's.yaml:8: surface.kind: got "gausian", allowed: gaussian, smooth or file, nearest: '
            "gaussian",
        ),
        (
            "kind: gaussian",
            "kind: [smooth]",
            's.yaml:8: surface.kind: got ["smooth"], allowed: gaussian, smooth or file',
        ),
        (
            "  kind: gaussian\n",
            "",
            "s.yaml:7: surface.kind: missing, allowed: gaussian, smooth or file",
        ),
        (
            "kind: gaussian",
            "kind: gaussian\n  autocorrelation: exponental",
            's.yaml:9: surface.autocorrelation: got "exponental", allowed: gaussian, '
            "gaussian_10pct, exponential or"
            " exponential_10pct, nearest: exponential",
        ),
        (
            "ra_um: 0.1",
            "ra_um: 1001",
            "s.yaml:9: surface.roughness_ra_um: got 1001, allowed: a number > 0 and <= 1000",
        ),
        (
            "ra_um: 0.1",
            "ra_um: 0",
            "s.yaml:9: surface.roughness_ra_um: got 0, allowed: a number > 0 and <= 1000",
        ),
        ("seed: 1", "seed: 1.5", "s.yaml:13: surface.seed: got 1.5, allowed: a whole number >= 0"),
        ("seed: 1", "seed: -1", "s.yaml:13: surface.seed: got -1, allowed: a whole number >= 0"),
        (
            "seed: 1",
            "seed: true",
            "s.yaml:13: surface.seed: got true, allowed: a whole number >= 0",
        ),
        (
            "width_um: 64",
            "width_um: 65",
            "s.yaml:12: surface.width_um: got 65, allowed: a whole number of nodes of 2 um, at "
            "least 8; nearest: 64",
        ),
        (
            "width_um: 64",
            "width_um: 4",
            "s.yaml:12: surface.width_um: got 4, allowed: a whole number of nodes of 2 um, at "
            "least 8; nearest: 16",
        ),
        (
            "width_um: 64",
            "width_um: 1e12",
            "s.yaml:12: surface.width_um: got 1000000000000, allowed: less than 1e+09 nodes",
        ),
        (
            "load_n: 20",
            "load_n: true",
            "s.yaml:15: rolling.load_n: got true, allowed: a number > 0",
        ),
        ("load_n: 20", "load_n:", "s.yaml:15: rolling.load_n: missing, allowed: a number > 0"),
        (
            "load_n: 20",
            "load_n: !big 20",
            "s.yaml:15: rolling.load_n: got the tag !big, allowed: plain values",
        ),
        ("load_n: 20", "load_n: [[[1]]]", "s.yaml:15: rolling.load_n[0][0][0]: nested too deeply"),
        (
            "load_n: 20",
            "load: 20\n  load_n: 20",
            "s.yaml:15: rolling.load: unknown key, nearest: load_n, allowed: load_n, speed_m_s, "
            "duration_s, distance_mm, start_um",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: 0",
            "s.yaml:16: rolling.speed_m_s: got 0, allowed: a number > 0, or at least two [time_s, "
            "speed_m_s] pairs",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 1]]",
            "s.yaml:16: rolling.speed_m_s: got [[0, 1]], allowed: a number > 0, or at least two "
            "[time_s, speed_m_s]"
            " pairs",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s:\n  - [0, 1]\n  - [1, true]",
            "s.yaml:18: rolling.speed_m_s[1]: got [1, true], allowed: [time_s, speed_m_s], two "
            "numbers",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 1], 2]",
            "s.yaml:16: rolling.speed_m_s[1]: got 2, allowed: [time_s, speed_m_s], two numbers",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[1, 1], [2, 1]]",
            "s.yaml:16: rolling.speed_m_s[0]: got 1, allowed: 0, the time of the first pair",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 1], [2, 1], [2, 3]]",
            "s.yaml:16: rolling.speed_m_s[2]: got time 2 after 2, allowed: increasing times",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 1], [2, -1]]",
            "s.yaml:16: rolling.speed_m_s[1]: got speed -1, allowed: a number >= 0",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 0], [2, 0]]",
            "s.yaml:16: rolling.speed_m_s: got speeds that are all 0, allowed: at least one > 0",
        ),
        (
            "speed_m_s: 0.1",
            "speed_m_s: [[0, 1e-3], [0.01, 0]]",
            "s.yaml:16: rolling.speed_m_s: the sphere comes to rest after 5 um, the shortest track "
            "is 16 um: give it"
            " more speed",
        ),
        (
            "  duration_s: 0.01\n",
            "",
            "s.yaml:14: rolling.duration_s: missing, allowed: a number > 0, or a"
            " rolling.distance_mm",
        ),
        (
            "duration_s: 0.01",
            "duration_s: 1.0e-4",
            "s.yaml:17: rolling.duration_s: got 0.0001, in which the sphere rolls 10 um; the "
            "shortest track is 8 nodes,"
            " 16 um: at least 0.00016",
        ),
        (
            "duration_s: 0.01",
            "duration_s: 1e9",
            "s.yaml:17: rolling.duration_s: got 1000000000, which is more than 1e+09 nodes or "
            "steps",
        ),
        (
            "step_nodes: 1",
            "step_nodes: 1.6",
            "s.yaml:18: numerics.step_nodes: got 1.6, allowed: a whole number from 1 to 64, or one "
            "over a whole"
            " number down to 1/16; nearest: 2",
        ),
        (
            "step_nodes: 1",
            "step_nodes: 0.3",
            "s.yaml:18: numerics.step_nodes: got 0.3, allowed: a whole number from 1 to 64, or one "
            "over a whole"
            " number down to 1/16; nearest: 0.3333333333333333",
        ),
        (
            "step_nodes: 1",
            "tolerance: 0.5",
            "s.yaml:18: numerics.tolerance: got 0.5, allowed: auto, or a number >= 1e-12 and"
            " <= 0.1",
        ),
        (
            "step_nodes: 1",
            "tolerance: 1e-13",
            "s.yaml:18: numerics.tolerance: got 1e-13, allowed: auto, or a number >= 1e-12 and"
            " <= 0.1",
        ),
        (
            "numerics: {step_nodes: 1}",
            "numeric: {step_nodes: 1}",
            f"s.yaml:18: numeric: unknown key, nearest: numerics, allowed: {SECTIONS}",
        ),
        ("numerics: {step_nodes: 1}", "17: 3", f"s.yaml:18: 17: unknown key, allowed: {SECTIONS}"),
        (
            "numerics: {step_nodes: 1}",
            "recovery: {events: on}",
            's.yaml:18: recovery.events: got "on", allowed: true or false',
        ),
        (
            "numerics: {step_nodes: 1}",
            "recovery: {rule: left}",
            's.yaml:18: recovery.rule: got "left", allowed: mean or left_end, nearest: left_end',
        ),
        (
            "numerics: {step_nodes: 1}",
            "sound: {q: 1.5}",
            "s.yaml:18: sound.q: got 1.5, allowed: a number > 0 and <= 1",
        ),
        (
            "numerics: {step_nodes: 1}",
            "sound: {gain_pa_per_w_m2: 0}",
            "s.yaml:18: sound.gain_pa_per_w_m2: got 0, allowed: a number > 0",
        ),
        (
            "sweep:\n",
            "sweep: [1]\nx:\n",
            "s.yaml:19: sweep: got [1], allowed: lists of numbers by dotted key, as in "
            "rolling.load_n: [5, 20]",
        ),
        (
            "rolling.load_n: [",
            "rolling.lod_n: [",
            "s.yaml:20: sweep.rolling.lod_n: unknown key, nearest: rolling.load_n",
        ),
        (
            "rolling.load_n: [",
            "load_n: [",
            "s.yaml:20: sweep.load_n: unknown key, nearest: rolling.load_n",
        ),
        (
            "rolling.load_n: [",
            "surface.kind: [",
            "s.yaml:20: sweep.surface.kind[0]: got 5, allowed: text",
        ),
        (
            "[5, 20, 100]",
            "[]",
            "s.yaml:20: sweep.rolling.load_n: got [], allowed: a list of numbers, at least one",
        ),
        (
            "[5, 20, 100]",
            "5",
            "s.yaml:20: sweep.rolling.load_n: got 5, allowed: a list of numbers, at least one",
        ),
        (
            "[5, 20, 100]",
            "[5, x]",
            's.yaml:20: sweep.rolling.load_n[1]: got "x", allowed: a number',
        ),
        (
            "[5, 20, 100]",
            "[5, 6, 5.0]",
            "s.yaml:20: sweep.rolling.load_n[2]: got 5.0 twice, allowed: different values",
        ),
        (
            "[5, 20, 100]",
            "\n  - 5\n  - -2",
            "s.yaml:22: sweep.rolling.load_n[1]: got -2, allowed: a number > 0",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "surface.spacing_um: [2, 3]",
            "s.yaml:12: surface.width_um: got 64, allowed: a whole number of nodes of 3 um, at "
            "least 8; nearest: 63"
            " (in the run spacing_um=3,radius_mm=2 of the sweep)",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "surface.seed: [1, 1.5]",
            "s.yaml:20: sweep.surface.seed[1]: got 1.5, allowed: a whole number >= 0",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "numerics.edges: [blended, blunt]",
            's.yaml:20: sweep.numerics.edges[1]: got "blunt", allowed: sharp or blended',
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "plate: [steel, glass]",
            's.yaml:20: sweep.plate: got ["steel", "glass"], allowed: sections by label, as in'
            " plate: {first: {...}, second: {...}}",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "plate:\n    steel: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}\n    glass: 3",
            "s.yaml:22: sweep.plate.glass: got 3, allowed: a section",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "plate:\n    steel: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}\n"
            "    glass: {youngs_modulus_gpa: -70, poissons_ratio: 0.2}",
            "s.yaml:22: sweep.plate.glass.youngs_modulus_gpa: got -70, allowed: a number > 0",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "zip: {rolling.load_n: [5, 20], surface.seed: [1, 2, 3]}",
            "s.yaml:20: sweep.zip: got 2 of rolling.load_n, 3 of surface.seed, allowed: equally"
            " many values of each key",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "zip: {rolling.load_n: [5, 20, 5], surface.seed: [1, 2, 1]}",
            "s.yaml:20: sweep.zip: the same values stand together twice, allowed: different ones",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "rolling.load_n: [5]\n  zip: {rolling.load_n: [6]}",
            "s.yaml:21: sweep.zip.rolling.load_n: is swept beside it, too",
        ),
        (
            "rolling.load_n: [5, 20, 100]",
            "zip: {rolling.load_n: [5, -2], surface.seed: [1, 2]}",
            "s.yaml:20: sweep.zip.rolling.load_n[1]: got -2, allowed: a number > 0",
        ),
        (
            "[5, 20, 100]",
            str(list(range(1, 6001))),
            "s.yaml:19: sweep: got 12000 runs, allowed: at most 10000",
        ),
    ],
)
def test_message(old: str, new: str, message: str) -> None:
    assert old in TEXT
    assert message in faults(TEXT.replace(old, new, 1))


def test_a_missing_duration_is_told_beside_other_faults() -> None:
    got = faults(PLAIN.replace("  duration_s: 0.01\n", "").replace("radius_mm: 5", "radius_mm: -5"))
    assert [fault.split(": ")[1] for fault in got] == ["sphere.radius_mm", "rolling.duration_s"]


def test_keys_of_another_kind_of_surface() -> None:
    assert faults(PLAIN.replace("kind: gaussian", "kind: smooth")) == [
        f"s.yaml:{line}: surface.{key}: unknown key of kind smooth, allowed: kind, spacing_um, "
        f"width_um"
        for line, key in ((9, "roughness_ra_um"), (10, "correlation_length_um"), (13, "seed"))
    ]


def test_errors_pass_between_processes() -> None:
    error = SceneError(["a", "b"])
    assert pickle.loads(pickle.dumps(error)).faults == ["a", "b"]


# ---- Properties


def test_si() -> None:
    scene = loads(
        PLAIN, ["sphere.youngs_modulus_gpa=100", "sphere.poissons_ratio=0.2", "rolling.start_um=-3"]
    )
    assert scene.radius == pytest.approx(5e-3)
    assert 1 / scene.contact_modulus == pytest.approx(
        (1 - 0.3**2) / 210e9 + (1 - 0.2**2) / 100e9, rel=1e-15
    )
    assert scene.hardness == pytest.approx(2.1e9)
    assert (scene.spacing, scene.step, scene.load) == pytest.approx((2e-6, 2e-6, 20))
    assert scene.start == pytest.approx(-3e-6)
    rigid = loads(PLAIN, ["plate.hardness_gpa="])
    assert rigid.contact_modulus == pytest.approx(210e9 / 0.91, rel=1e-15)
    assert rigid.hardness == math.inf


def test_step_of_a_third() -> None:
    assert loads(PLAIN, ["numerics.step_nodes=0.33333"]).numerics.step_nodes == 1 / 3


def test_scenes_are_frozen_and_folders_do_not_count() -> None:
    scene = loads(PLAIN, folder=Path("a"))
    with pytest.raises(ValueError, match="frozen"):
        scene.name = "other"  # type: ignore[misc]
    assert scene == loads(PLAIN, folder=Path("b"))
    assert scene != loads(PLAIN, ["rolling.load_n=21"])


# ---- The sweep


def test_sweep_product() -> None:
    runs = loads(TEXT, folder=Path("here")).runs()
    assert [(run.load, run.sphere.radius_mm) for _, run in runs] == [
        (5, 2),
        (5, 5),
        (20, 2),
        (20, 5),
        (100, 2),
        (100, 5),
    ]
    assert all(not run.sweep and run.folder == Path("here") for _, run in runs)
    assert runs[0][0] == {"rolling.load_n": 5, "sphere.radius_mm": 2}
    assert run_name(runs[0][0]) == "load_n=5,radius_mm=2"


def test_no_sweep_is_one_run() -> None:
    scene = loads(PLAIN)
    assert scene.runs() == [({}, scene)]


def test_any_number_can_be_swept() -> None:
    scene = loads(
        PLAIN,
        ["sweep={surface.seed: [1, 2], numerics.step_nodes: [2, 0.5], plate.hardness_gpa: [1, 2]}"],
    )
    last = scene.runs()[-1][1]
    assert last.surface.seed == 2  # type: ignore[union-attr]
    assert (last.numerics.step_nodes, last.plate.hardness_gpa) == (0.5, 2)
    assert len({run_name(values) for values, _ in scene.runs()}) == 8
    across = loads(PLAIN, ["sweep.surface.correlation_length_um=[5, 20]"])
    assert all(
        "correlation_length_across_um" not in run.to_dict()["surface"] for _, run in across.runs()
    )


def test_run_names() -> None:
    assert run_name({"rolling.load_n": 5.0}) == "load_n=5"
    assert run_name({"surface.roughness_ra_um": 0.01}) == "roughness_ra_um=0.01"
    both = {"plate.youngs_modulus_gpa": 1, "sphere.youngs_modulus_gpa": 2}
    assert run_name(both) == "plate.youngs_modulus_gpa=1,sphere.youngs_modulus_gpa=2"
    assert run_name({}) == ""


# ---- The track


@settings(deadline=None, max_examples=200)
@given(
    st.floats(0.01, 10),
    st.sampled_from(STEP_NODES),
    st.floats(0.001, 10),
    st.floats(0.01, 1.0),
    st.floats(0.1, 10.0),
)
def test_made_tracks_close(
    spacing: float, step_nodes: float, speed: float, duration: float, start: float
) -> None:
    data: dict[str, Any] = loads(PLAIN).to_dict()
    data["surface"] |= {"spacing_um": spacing, "width_um": 16 * spacing}
    data["rolling"] |= {"speed_m_s": speed, "duration_s": duration, "start_um": start}
    data["numerics"] = {"step_nodes": step_nodes}
    try:
        scene = Scene.from_dict(data)
    except SceneError as error:  # the longest and shortest are refused, and nothing else
        assert "shortest track" in str(error) or "more than" in str(error)
        return
    way = scene.track
    assert way.closed
    assert way.lap_steps == way.steps
    assert way.n_across == 16
    assert way.n_along >= 8
    assert way.steps * way.step == pytest.approx(way.n_along * way.spacing, rel=1e-12)
    # Rounded, not cut: never further off than half of the larger of node and step.
    assert abs(way.distance - speed * duration) <= 0.500001 * max(way.step, way.spacing)


def test_the_shortest_track_that_is_named_is_enough() -> None:
    scene = loads(PLAIN, ["rolling.duration_s=0.00016"])
    assert scene.track.n_along == 8
    assert (
        loads(PLAIN, ["rolling.duration_s=0.00016", "numerics.step_nodes=0.25"]).track.steps == 32
    )
    coarse = loads(PLAIN, ["numerics.step_nodes=64", "rolling.duration_s=0.0013"]).track
    assert (coarse.n_along, coarse.steps) == (64, 1)


def test_a_sphere_that_stops_is_not_asked_for_more() -> None:
    # 9.9 nodes until it rests: ten would be nearer, and out of reach.
    scene = loads(PLAIN, ["rolling.speed_m_s=[[0, 0.00396], [0.01, 0]]", "rolling.duration_s=1"])
    assert scene.track.n_along == 9
    assert scene.motion.duration(scene.track.distance) < 0.01


def file_scene(folder: Path, heights: Any, *overrides: str) -> Scene:
    np.save(folder / "heights.npy", heights)
    text = (
        PLAIN[: PLAIN.index("surface:")]
        + "surface: {kind: file, path: heights.npy, spacing_um: 2}\n"
    )
    text += "rolling: {load_n: 20, speed_m_s: 0.1}\n"
    return loads(text, overrides, folder=folder)


@pytest.mark.parametrize(
    ("step_nodes", "lap_steps", "steps", "closed"),
    [
        (1, 100, 100, True),
        (2, 50, 50, True),
        (3, 100, 33, False),
        (0.5, 200, 200, True),
        (8, 25, 12, False),
    ],
)
def test_once_round_a_file(
    tmp_path: Path, step_nodes: float, lap_steps: int, steps: int, closed: bool
) -> None:
    scene = file_scene(tmp_path, np.zeros((100, 16)), f"numerics.step_nodes={step_nodes}")
    way = scene.track
    assert (way.n_along, way.n_across, way.lap_steps, way.steps, way.closed) == (
        100,
        16,
        lap_steps,
        steps,
        closed,
    )
    assert not (lap_steps * step_nodes) % 100


def test_a_file_goes_round_again(tmp_path: Path) -> None:
    scene = file_scene(tmp_path, np.zeros((100, 16), dtype=np.int16), "rolling.duration_s=0.004")
    assert (scene.track.steps, scene.track.closed) == (200, True)
    scene = file_scene(tmp_path, np.zeros((100, 16)), "rolling.duration_s=0.003")
    assert (scene.track.steps, scene.track.closed) == (150, False)
    assert file_scene(tmp_path, np.zeros((100, 16)), "rolling.duration_s=1e-9").track.steps == 1
    assert resound(scene, ["rolling.speed_m_s=0.2"]).rolling.duration_s == pytest.approx(0.0015)


@pytest.mark.parametrize(
    ("heights", "message"),
    [
        (
            np.zeros((9, 9, 9)),
            "got a 3-D array, allowed: one 2-D array of real heights, (along track, across), or a",
        ),
        (
            np.zeros((9, 9), dtype=complex),
            "got 2-D complex128, allowed: one 2-D array of real heights, ",
        ),
        (
            np.zeros((9, 9), dtype=bool),
            "got 2-D bool, allowed: one 2-D array of real heights, ",
        ),
        (np.zeros((9, 7)), "got 9 x 7 nodes, allowed: at least 8 each way"),
    ],
)
def test_files_of_wrong_shape(tmp_path: Path, heights: Any, message: str) -> None:
    with pytest.raises(SceneError) as error:
        _ = file_scene(tmp_path, heights).track
    assert str(error.value).startswith(f"surface.path: heights.npy: {message}")


def test_files_that_are_none(tmp_path: Path) -> None:
    scene = file_scene(tmp_path, np.zeros((9, 9)))
    path = tmp_path / "heights.npy"
    path.write_text("1 2 3\n")
    with pytest.raises(SceneError, match=r"^surface.path: heights.npy: no readable .npy file"):
        _ = scene.track
    with path.open("wb") as stream:
        np.savez(stream, a=np.zeros((9, 9)))
    with pytest.raises(SceneError, match=r"an archive; rename it to \.npz"):
        _ = scene.track
    path.write_bytes(b"")
    with pytest.raises(SceneError, match="no readable"):
        _ = scene.track
    path.unlink()
    with pytest.raises(SceneError) as error:
        _ = scene.track
    assert str(error.value) == f"surface.path: heights.npy: no such file (looked in {tmp_path})"
    path.mkdir()
    with pytest.raises(SceneError, match="is a folder"):
        _ = scene.track


def test_a_file_that_is_never_rounded(tmp_path: Path) -> None:
    scene = file_scene(tmp_path, np.zeros((100, 16)), "rolling.speed_m_s=[[0, 0.1], [0.001, 0]]")
    with pytest.raises(SceneError) as error:
        _ = scene.track
    assert str(error.value) == (
        "rolling.speed_m_s: the sphere comes to rest after 5e-05 m, once round the height file is "
        "0.0002 m: give it"
        " more speed or set rolling.duration_s"
    )


def test_an_absolute_path_stays(tmp_path: Path) -> None:
    scene = file_scene(tmp_path, np.zeros((9, 9)), f"surface.path={tmp_path / 'heights.npy'}")
    assert loads(dump(scene), folder=Path("elsewhere")).height_path == tmp_path / "heights.npy"


# ---- The scenes


def test_the_laws_are_those_of_the_surface_module() -> None:
    annotation = Gaussian.model_fields["autocorrelation"].annotation
    assert set(get_args(annotation)) == set(surface.AUTOCORRELATIONS)


@pytest.mark.parametrize("path", SCENES, ids=lambda p: p.stem)
def test_every_scene_says_what_it_shows_and_has_a_track(path: Path, tmp_path: Path) -> None:
    first, *rest = path.read_text().splitlines()
    assert first.startswith("# ")
    scene = read_scene(path)
    assert scene.name == path.stem
    if scene.height_path:
        # The command in the file's head makes the heights; it is run as it stands.
        command = next(line for line in rest if "python -c" in line).removeprefix("#")
        subprocess.run([sys.executable, *shlex.split(command)[1:]], cwd=tmp_path, check=True)
        scene = Scene.from_dict(scene.to_dict(), tmp_path)
    for _, run in scene.runs():
        assert 400 <= run.track.steps <= (25000 if path.stem == "quickstart" else 5000)
        assert run.track.closed
