"""Sweeps of numbers, names, files and whole sections, in combinations and together."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_text import PLAIN

from rolling.scene import sweep
from rolling.scene.file import dump, loads
from rolling.scene.identity import contact_keys, contains, differences, scene_identity
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene, SweepRun
from rolling.scene.sweep import LONGEST_NAME, run_name

SURFACES = """\
sweep:
  surface:
    ground: {kind: gaussian, spacing_um: 2, width_um: 64, roughness_ra_um: 0.4,
             correlation_length_um: 20, seed: 1}
    lapped: {kind: gaussian, spacing_um: 2, width_um: 64, roughness_ra_um: 0.05,
             correlation_length_um: 8, seed: 1}
  surface.seed: [1, 2]
  rolling.speed_m_s: {slow: 0.1, slowing: [[0, 0.2], [1, 0.1]]}
"""


def runs_of(text: str, *overrides: str) -> list[SweepRun]:
    return loads(text, overrides).runs()


def names_of(text: str, *overrides: str) -> list[str]:
    return [run_name(run.values) for run in runs_of(text, *overrides)]


def test_sections_and_numbers() -> None:
    runs = runs_of(PLAIN + SURFACES)
    assert len(runs) == 2 * 2 * 2
    first = runs[0]
    second = runs[1]
    last = runs[-1]
    assert first.values == {
        "surface": "ground",
        "surface.seed": 1,
        "rolling.speed_m_s": "slow",
    }
    assert first.scene.surface.roughness_ra_um == 0.4
    assert second.scene.rolling.speed_m_s == ((0, 0.2), (1, 0.1))
    # A number in a swept section is swept as well, whatever the order of the keys.
    assert (last.scene.surface.roughness_ra_um, last.scene.surface.seed) == (0.05, 2)
    assert not any(run.scene.sweep for run in runs)


def test_swept_files_are_found_from_another_folder(tmp_path: Path) -> None:
    """The paths of a scene that moves keep their text as labels, and so their names of runs."""
    (tmp_path / "heights").mkdir()
    for k, name in enumerate(("a b", "a-b")):
        np.save(tmp_path / "heights" / f"{name}.npy", np.full((64, 64), k))
    surface = "surface={kind: file, path: heights/a b.npy, spacing_um: 2}"
    paths = 'sweep.surface.path=["heights/a b.npy", heights/a-b.npy]'
    scene = loads(PLAIN, [surface, paths], folder=tmp_path)
    data = sweep.with_paths(scene.to_dict(), lambda path: f"../{path}")
    (tmp_path / "out").mkdir()
    moved = Scene.from_dict(data, folder=tmp_path / "out")
    assert [run.values for run in moved.runs()] == [run.values for run in scene.runs()]
    for before, after in zip(scene.runs(), moved.runs(), strict=True):
        assert before.scene.height_path and after.scene.height_path
        assert after.scene.height_path.resolve() == before.scene.height_path.resolve()
    assert scene_identity(moved) == scene_identity(scene) and contains(moved, scene)
    assert differences(scene, moved) == []
    np.save(tmp_path / "heights" / "a-b.npy", np.full((64, 64), 3.0))
    assert differences(scene, moved) == []  # they share the file


def test_a_scene_comes_back_from_its_text() -> None:
    scene = loads(PLAIN + SURFACES)
    again = loads(dump(scene))
    assert again == scene and again.runs() == scene.runs()


def test_words_and_labelled_switches_are_swept() -> None:
    tolerances = [
        run.scene.tolerance for run in runs_of(PLAIN, "sweep.numerics.tolerance=[auto, 1e-3]")
    ]
    assert tolerances[1] == 1e-3 != tolerances[0]
    events = runs_of(PLAIN, "sweep.recovery.events={with: true, without: false}")
    assert [run.scene.recovery.events for run in events] == [True, False]
    with pytest.raises(SceneError, match=r"as in recovery.events: {first: true}"):
        runs_of(PLAIN, "sweep.recovery.events=[true, false]")


def test_a_label_may_stand_for_no_value() -> None:
    scene = loads(PLAIN, ["sweep.plate.hardness_gpa={elastic: null, yielding: 2.1}"])
    assert [run.scene.hardness for run in loads(dump(scene)).runs()] == [np.inf, 2.1e9]


# ---- names of runs


def test_each_run_sounds_by_its_own_dynamics() -> None:
    """A run that may vibrate is heard by its vibration, and stays so when its scene is stored."""
    scene = loads(
        PLAIN + "sweep:\n  dynamics: {held: null, free: {}}\n",
        ["sphere.density_kg_m3=7850", "plate.density_kg_m3=7850"],
    )
    for same in (scene, loads(dump(scene))):
        assert [run.scene.sound.source for run in same.runs()] == ["release", "vibration"]


def test_names_use_the_words_of_the_user() -> None:
    assert names_of(PLAIN + SURFACES)[0] == "surface=ground,seed=1,speed_m_s=slow"
    assert names_of(PLAIN, "sweep.numerics.edges=[blended, sharp]") == [
        "edges=blended",
        "edges=sharp",
    ]
    assert names_of(PLAIN, "sweep.rolling.load_n=[5, 0.5]", "sweep.sphere.radius_mm=[2.0]") == [
        "load_n=5,radius_mm=2",
        "load_n=0.5,radius_mm=2",
    ]
    both = {"plate.youngs_modulus_gpa": 1, "sphere.youngs_modulus_gpa": 2}
    assert run_name(both) == "plate.youngs_modulus_gpa=1,sphere.youngs_modulus_gpa=2"
    assert run_name({}) == ""


NUMBERS = st.one_of(
    st.integers(-(10**300), 10**300),
    st.floats(-1e299, 1e299, allow_nan=False),
    st.sampled_from([2**53, 2**53 + 1, 10**16 + 1, 0.1, 0.1 + 2**-53, 1e-320]),
)
TEXTS = st.text(st.characters(codec="utf-8"), min_size=1, max_size=60)


@settings(max_examples=100, deadline=None)
@given(st.one_of(st.lists(kind, min_size=2, max_size=4, unique=True) for kind in (NUMBERS, TEXTS)))
def test_names_differ_and_depend_on_their_own_values_alone(values: list[float | str]) -> None:
    """A sweep that is extended keeps the folders of its runs; it refuses 5 beside "5"."""
    names = {run_name({"rolling.load_n": value, "surface.seed": 1}) for value in values}
    assert len(names) == len(values)
    for name in names:
        assert 0 < len(name.encode()) <= LONGEST_NAME
        assert not {*name} & {*'/\\:*?"<>|\0'} and name not in (".", "..")


# ---- identities


def test_identity_is_that_of_the_values() -> None:
    scene = loads(PLAIN)
    again = loads(dump(scene)), loads(PLAIN.replace("load_n: 20", "load_n: 20.0"))
    assert {scene_identity(each) for each in again} == {scene_identity(scene)}
    changes = {"distance_m": 2}, {"seed": 2}, {"tolerance": 1e-3}, {"name": "other"}
    others = {scene_identity(scene.with_(change)) for change in changes}
    assert len(others | {scene_identity(scene)}) == 5


def test_differences_name_the_key_and_both_values() -> None:
    scene = loads(PLAIN)
    changed = scene.with_(radius_mm=3, hardness_gpa=None)
    assert differences(scene, changed) == [
        "sphere.radius_mm: got 3, has 5",
        "plate.hardness_gpa: got nothing, has 2.1",
    ]
    smooth = scene.with_(surface={"kind": "smooth", "spacing_um": 2, "width_um": 64})
    assert differences(scene, smooth) == ['surface.kind: got "smooth", has "gaussian"']
    swept = scene.with_(sweep={"rolling.load_n": [5, 20]})
    assert differences(swept, scene) == ["sweep.rolling.load_n: got nothing, has [5, 20]"]
    assert differences(scene, scene) == []


def test_a_sweep_contains_the_sweeps_of_its_values() -> None:
    few = loads(PLAIN, ["sweep.rolling.load_n=[20, 5]"])
    many = loads(PLAIN, ["sweep.rolling.load_n=[5, 6.5, 20]"])
    assert contains(few, many) and contains(few, few) and not contains(many, few)
    assert not contains(few, many.with_(distance_m=2)) and not contains(loads(PLAIN), many)


@pytest.mark.parametrize(
    ("change", "is_contact"),
    [
        ({"load_n": 21}, True),
        ({"seed": 2}, True),
        ({"tolerance": 1e-5}, True),
        ({"start_um": 3}, True),
        ({"rule": "left_end"}, True),
        ({"duration_s": 0.02}, True),
        ({"speed_m_s": 0.2, "duration_s": 0.005}, False),
        ({"distance_m": 2, "sphere.density_kg_m3": 3000, "name": "other"}, False),
        ({"error_estimate": True}, False),
    ],
)
def test_the_march_depends_on_contact_keys_alone(
    change: dict[str, float], is_contact: bool
) -> None:
    scene = loads(PLAIN)
    assert (contact_keys(scene.with_(change)) != contact_keys(scene)) == is_contact


def test_a_height_file_counts_with_its_digest(tmp_path: Path) -> None:
    surface = "surface={kind: file, path: h.npy, spacing_um: 2}"
    keys = []
    for k in (0, 1, 0):
        np.save(tmp_path / "h.npy", np.full((64, 64), k))
        keys.append(contact_keys(loads(PLAIN, [surface], folder=tmp_path)))
    assert keys[0] == keys[2] != keys[1] and "surface.path" not in keys[0]
    (tmp_path / "h.npy").unlink()
    with pytest.raises(SceneError, match=r"surface.path: h.npy: no such file"):
        contact_keys(loads(PLAIN, [surface], folder=tmp_path))
