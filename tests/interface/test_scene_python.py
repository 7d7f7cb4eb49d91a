"""Scenes built in Python are the same, with the same messages, as scenes from a file."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rolling import Scene
from rolling.check.findings import check_scene
from rolling.scene.file import dump, loads
from rolling.scene.messages import SceneError
from rolling.scene.sections import Plate, Rolling, Sphere
from rolling.scene.surfaces import Gaussian, HeightFile, Smooth


def built(**keys: Any) -> Scene:
    sections: dict[str, Any] = {
        "sphere": Sphere(radius_mm=5),
        "plate": Plate(youngs_modulus_gpa=210, poissons_ratio=0.3, hardness_gpa=2.1),
        "surface": Gaussian(
            spacing_um=2, width_um=256, roughness_ra_um=0.1, correlation_length_um=20, seed=1
        ),
        "rolling": Rolling(load_n=20, speed_m_s=0.1, duration_s=0.01),
    }
    return Scene(**(sections | keys))


def faults(build: Callable[[], object]) -> list[str]:
    with pytest.raises(SceneError) as error:
        build()
    return error.value.mistakes


# ---- building


def test_a_built_scene_is_the_scene_of_its_file() -> None:
    scene = built()
    assert (scene.name, scene.surface.kind) == ("scene", "gaussian")
    assert loads(dump(scene)) == scene == pickle.loads(pickle.dumps(scene))
    assert scene.track.steps == 500


def test_values_of_numpy_and_paths_are_taken() -> None:
    surface = Gaussian(
        spacing_um=np.float64(2),
        width_um=256,
        roughness_ra_um=0.1,
        correlation_length_um=20,
        seed=int(np.int64(3)),
    )
    scene = built(surface=surface, sweep={"rolling.load_n": np.linspace(5, 20, 4)})
    assert scene.sweep == {"rolling.load_n": (5.0, 10.0, 15.0, 20.0)}
    assert HeightFile(path=Path("a") / "b.npy", spacing_um=1).path == str(Path("a") / "b.npy")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Sphere(radius_mm=-1), "sphere.radius_mm: got -1, allowed: greater than 0"),
        (
            lambda: Sphere(radius_mm=1, youngs_modulus_gpa=4),
            "sphere.poissons_ratio: missing beside youngs_modulus_gpa",
        ),
        (
            lambda: Rolling(load=1, load_n=1, speed_m_s=1),  # type: ignore[call-arg]
            "rolling.load: unknown key, nearest: load_n, allowed: load_n, speed_m_s",
        ),
        (
            lambda: Smooth(spacing_um=1, width_um=8.5),
            "surface.width_um: got 8.5, allowed: a whole number of nodes of 1 um, at least 8",
        ),
        (
            lambda: built(rolling=Rolling(load_n=1, speed_m_s=((0, 1), (1, 2)))),
            "rolling.duration_s: missing; give it or a rolling.distance_mm",
        ),
        (
            lambda: built(sweep={"rolling.load_n": [5, -1]}),
            "sweep.rolling.load_n[1]: got -1, allowed: greater than 0",
        ),
    ],
)
def test_messages_are_those_of_a_file(build: Callable[[], object], message: str) -> None:
    (fault,) = faults(build)
    assert fault.startswith(f"scene: {message}")


def test_sections_take_keys_by_name() -> None:
    with pytest.raises(TypeError, match="Sphere takes keys by name only"):
        Sphere(5)  # type: ignore[misc]


# ---- changing


def test_bare_keys_stand_for_dotted_ones() -> None:
    scene = built()
    changed = scene.with_({"plate.poissons_ratio": 0.25}, load_n=50, duration_s=0.02)
    assert (changed.load, changed.plate.poissons_ratio, changed.track.steps) == (50, 0.25, 1000)
    assert (scene.load, scene.track.steps) == (20, 500)


def test_none_removes_an_optional_key() -> None:
    assert built().with_(hardness_gpa=None).hardness == np.inf
    assert faults(lambda: built().with_(load_n=None)) == [
        "scene: rolling.load_n: missing; give it, or sphere.density_kg_m3 for the weight of the"
        " sphere"
    ]


def test_a_set_key_leaves_the_sweep() -> None:
    swept = built().with_(sweep={"rolling.load_n": [5, 20], "surface.seed": [1, 2]})
    assert len(swept.runs()) == 4
    assert swept.with_(load_n=10).sweep == {"surface.seed": (1, 2)}
    assert swept.with_(sweep=None).runs() == built().runs()
    assert swept.with_({"sweep.surface.seed": [7]}).sweep["surface.seed"] == (7,)


def test_sections_and_the_folder_are_kept() -> None:
    scene = Scene.from_dict(built().to_dict(), folder=Path("somewhere"))
    changed = scene.with_(
        surface=HeightFile(path="heights.npy", spacing_um=1), sphere=Sphere(radius_mm=1)
    )
    assert changed.height_path == Path("somewhere/heights.npy")
    assert changed.radius == 1e-3


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"youngs_modulus_gpa": 3}, "youngs_modulus_gpa: stands for sphere.youngs_modulus_gpa or"),
        ({"rolling.lod_n": 3}, "rolling.lod_n: unknown key, nearest: rolling.load_n, allowed: "),
        ({"load_n": 3, "rolling.load_n": 4}, "rolling.load_n: given twice"),
    ],
)
def test_keys_that_cannot_be_set(changes: dict[str, float], message: str) -> None:
    (fault,) = faults(lambda: built().with_(changes))
    assert fault.startswith(f"scene: {message}")


def test_values_nested_in_themselves_are_refused() -> None:
    value: list = [5]
    value.append(value)
    message = "scene: values are nested more than 16 times"
    assert faults(lambda: built().with_(load_n=value)) == [message]
    assert faults(lambda: Scene.from_dict({"rolling": {"load_n": value}})) == [message]
    assert faults(lambda: Sphere(radius_mm=value)) == [message]


def test_a_copy_with_other_numerics_has_a_track_of_its_own() -> None:
    """A copy must not keep the track that its original has stored."""
    scene = built()
    assert scene.track.steps == 500
    coarse = scene.model_copy(
        update={"numerics": scene.numerics.model_copy(update={"step_nodes": 2.0})}
    )
    assert (coarse.track.steps, scene.track.steps) == (250, 500)


# ---- checking


def test_check_is_a_sequence_and_a_table() -> None:
    checked = built().check(solve=False)
    assert checked == check_scene(built(), solve=False)
    assert len(checked) == len(list(checked)) and checked[0].key == "steps"
    assert str(checked).startswith("steps") and all(
        f"warning: {line}" in str(checked) for line in checked.warnings
    )
    page = checked._repr_html_()
    assert (
        page.startswith("<table><tr><td>steps</td>")
        and page.count("<li>") == len(checked.warnings) > 0
    )


def test_check_of_a_sweep_has_a_column_per_run() -> None:
    checked = built().with_(sweep={"rolling.load_n": [5, 20]}).check(solve=False)
    assert [*checked.runs] == ["load_n=5", "load_n=20"]
    assert [name for name, _ in checked.of_all] == [
        "expected time of all",
        "memory of all",
        "disk of all",
    ]
    assert "<td>load_n=20</td>" in checked._repr_html_()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"\ud800": 1}, r"\ud800: unknown key"),
        ({"\ud800": 1, "sweep": True}, r"\ud800: unknown key"),
        ({"name": "\ud800"}, "name: got"),
        ({"sphere": "\ud800"}, "sphere: got"),
        ({"sweep": "\ud800"}, "sweep: got"),
        ({"name": {(1, 2): 3}}, "name: got a value that cannot be written (dict)"),
        ({"recovery": {(1, 2): 3}}, "recovery.(1, 2): "),
        ({"sweep": {(1, 2): [1]}}, "sweep.(1, 2): unknown key"),
        ({"sweep": {None: [1]}}, "sweep.None: unknown key"),
        ({"rolling": {1: 2}}, "rolling"),
    ],
)
def test_odd_values_and_keys_from_python_are_refused_in_words(
    changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(SceneError) as error:
        Scene.from_dict(built().to_dict() | changes)
    assert any(message in fault for fault in error.value.mistakes), error.value.mistakes
    str(error.value).encode("utf-8")
