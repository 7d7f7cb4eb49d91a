"""Sweeps of numbers, names, files and whole sections, in combinations and together."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scene_text import PLAIN

from rolling.scene.file import dump, loads
from rolling.scene.messages import SceneError
from rolling.scene.sweep import run_name
from rolling.simulation import labels
from rolling.simulation.batch import Run, seen_from

SURFACES = """\
sweep:
  surface:
    ground: {kind: gaussian, spacing_um: 2, width_um: 64, roughness_ra_um: 0.4,
             correlation_length_um: 20, seed: 1}
    lapped: {kind: gaussian, spacing_um: 2, width_um: 64, roughness_ra_um: 0.05,
             correlation_length_um: 8, seed: 1}
  surface.seed: [1, 2]
  zip:
    rolling.load_n: [5, 20]
    rolling.speed_m_s: {slow: 0.1, slowing: [[0, 0.2], [1, 0.1]]}
"""


def runs_of(text: str, *overrides: str) -> list[Run]:
    scene = loads(text, overrides)
    singles = scene.runs()
    names = [run_name(values) for values, _ in singles]
    return [
        Run(values, single, Path(name))
        for (values, single), name in zip(singles, names, strict=True)
    ]


def test_sections_numbers_and_values_that_go_together() -> None:
    runs = runs_of(PLAIN + SURFACES)
    assert len(runs) == 2 * 2 * 2
    first, second, last = runs[0], runs[1], runs[-1]
    assert first.values == {
        "surface": "ground",
        "surface.seed": 1,
        "rolling.load_n": 5,
        "rolling.speed_m_s": "slow",
    }
    assert (first.scene.surface.roughness_ra_um, first.scene.load) == (0.4, 5)
    assert second.scene.load == 20 and second.scene.rolling.speed_m_s == ((0, 0.2), (1, 0.1))
    # A number in a swept section is swept as well, whatever the order of the keys.
    assert (last.scene.surface.roughness_ra_um, last.scene.surface.seed) == (0.05, 2)
    assert not any(run.scene.sweep for run in runs)


def test_names_and_labels_use_the_words_of_the_user() -> None:
    runs = runs_of(PLAIN + SURFACES)
    assert str(runs[0].folder) == "surface=ground,seed=1,load_n=5,speed_m_s=slow"
    texts = labels.labels(runs)
    assert len(set(texts)) == 8
    assert "surface ground" in texts[0] and "speed slow" in texts[0]
    assert "Ra" not in texts[0]  # the label says it


def test_names_of_a_choice_and_their_folders() -> None:
    runs = runs_of(PLAIN, "sweep.numerics.edges=[blended, sharp]")
    assert [str(run.folder) for run in runs] == ["edges=blended", "edges=sharp"]
    assert labels.labels(runs) == ["edges blended", "edges sharp"]


def test_swept_files_are_found_from_the_run_folder(tmp_path: Path) -> None:
    (tmp_path / "heights").mkdir()
    for name in ("a b", "a-b"):
        np.save(tmp_path / "heights" / f"{name}.npy", np.zeros((64, 64)))
    surface = "surface={kind: file, path: heights/a b.npy, spacing_um: 2}"
    paths = 'sweep.surface.path=["heights/a b.npy", heights/a-b.npy]'
    scene = loads(PLAIN, [surface, paths], folder=tmp_path)
    names = [run_name(values) for values, _ in scene.runs()]
    assert names[0].startswith("path=heights-a-b.npy-") and names[0] != names[1]
    folder = tmp_path / "outputs" / "run"
    folder.mkdir(parents=True)
    stored = loads(dump(seen_from(folder, scene)), folder=folder)
    assert [values for values, _ in stored.runs()] == [values for values, _ in scene.runs()]
    for (_, before), (_, after) in zip(scene.runs(), stored.runs(), strict=True):
        assert after.height_path.resolve() == before.height_path.resolve()
        assert after.track == before.track


def test_a_scene_comes_back_from_its_text() -> None:
    scene = loads(PLAIN + SURFACES)
    again = loads(dump(scene))
    assert again == scene and again.runs() == scene.runs()


def test_a_section_may_stand_in_the_sweep_alone() -> None:
    without = PLAIN[: PLAIN.index("plate:")] + PLAIN[PLAIN.index("surface:") :]
    plates = (
        "sweep.plate={steel: {youngs_modulus_gpa: 210, poissons_ratio: 0.3},"
        " glass: {youngs_modulus_gpa: 70, poissons_ratio: 0.2}}"
    )
    with pytest.raises(SceneError, match="plate: missing"):
        loads(without)
    moduli = [run.scene.plate.youngs_modulus_gpa for run in runs_of(without, plates)]
    assert moduli == [210, 70]


def test_setting_a_key_takes_it_from_the_values_that_go_together() -> None:
    scene = loads(PLAIN + SURFACES, ["rolling.load_n=7"])
    assert [*scene.sweep["zip"]] == ["rolling.speed_m_s"]
    scene = loads(PLAIN + SURFACES, ["rolling.load_n=7", "rolling.speed_m_s=0.1"])
    assert "zip" not in scene.sweep and len(scene.runs()) == 4
