"""Materials and finishes by name: tables, values beside a name, changes, sweeps, and findings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from checked import checked

from rolling import BearingScene, Scene, SceneError, read_scene
from rolling.kinds.reading import schema
from rolling.kinds.run_folder import RunFolder
from rolling.results.labels import labels
from rolling.scene import library
from rolling.scene.file import dump, loads
from rolling.scene.identity import contact_keys, scene_identity
from rolling.scene.surfaces import Gaussian

MATERIALS = library.data("materials")["materials"]
TEXT = """
name: named
sphere: {radius_mm: 5, material: glass}
plate: {material: steel-100cr6}
surface: {finish: ground, spacing_um: 2, width_um: 256, seed: 1}
rolling: {load_n: 2, speed_m_s: 0.1, duration_s: 0.01}
"""
BENT = {"dynamics": {}, "plate.thickness_mm": 3}


def scene(**changes: Any) -> Scene:
    return loads(TEXT).with_(changes)


@pytest.mark.parametrize("table", ["materials", "finishes"])
def test_every_number_has_a_source_and_every_source_a_number(table: str) -> None:
    entries = [*library.data(table)[table].values(), library.data(table).get("handled", {})]
    entries += [entry["raceway"] for entry in entries if "raceway" in entry]
    pairs = [pair for entry in entries for pair in entry.values() if isinstance(pair, list)]
    assert all(isinstance(value, int | float) for value, _ in pairs)
    assert {source for _, source in pairs} == {*library.data(table)["sources"]}


@pytest.mark.parametrize("name", MATERIALS)
def test_every_material_is_a_plate_and_a_sphere(name: str) -> None:
    built = scene(**{"plate.material": name, "sphere.material": name})
    # of the same body twice, the contact modulus is half of E/(1 - nu^2)
    modulus = built.plate.youngs_modulus_gpa * 1e9 / (1 - built.plate.poissons_ratio**2) / 2
    assert built.contact_modulus == pytest.approx(modulus, rel=1e-12)


def test_another_finish_of_a_raceway_brings_its_own_values_and_stated_ones_stay() -> None:
    surfaces = {"inner": {"kind": "raceway", "finish": "superfinished", "roughness_ra_um": 0.03}}
    bearing = {"named": "6204", "speed_rpm": 1800, "axial_load_n": 70, "surfaces": surfaces}
    scene = BearingScene(bearing=bearing)
    changed = scene.with_({"bearing.surfaces.inner.finish": "ground"}).bearing.surfaces.inner
    assert (changed.wave_amplitude_um, changed.roughness_ra_um) == (0.32, 0.03)
    swept = scene.with_(sweep={"bearing.surfaces.inner.finish": ["superfinished", "honed"]})
    amplitudes = [run.scene.bearing.surfaces.inner.wave_amplitude_um for run in swept.runs()]
    assert amplitudes == [0.23, 0.27]
    with pytest.raises(SceneError, match="allowed: ground, honed, superfinished; nearest: honed"):
        scene.with_({"bearing.surfaces.inner.finish": "honned"})
    with pytest.raises(SceneError, match="allowed: ground, honed, superfinished"):
        scene.with_({"bearing.surfaces.inner.finish": "lapped"})


def test_hardness_is_the_mean_pressure_of_the_indent_or_three_yield_strengths() -> None:
    # 746 HV: 9.80665 MPa * 746 / 0.927 = 7.892 GPa, with three digits
    assert scene().hardness == pytest.approx(7.89e9)
    assert scene(**{"plate.material": "steel-s235"}).hardness == pytest.approx(0.705e9)
    assert scene(**{"plate.yield_strength_gpa": 0.4}).hardness == pytest.approx(1.2e9)
    assert scene(**{"plate.hardness_gpa": None}).hardness == float("inf")


def test_values_beside_a_name_win_and_losses_need_a_thickness() -> None:
    plate = {"material": "brass-cuzn37", "hardness_gpa": 2}
    built = scene(plate=plate)
    assert (built.plate.hardness_gpa, built.plate.youngs_modulus_gpa) == (2.0, 103.0)
    assert built.plate.loss_factor is None
    assert built.with_(BENT).plate.loss_factor == 3.9e-3
    assert built.with_(BENT).with_({"plate.thickness_mm": None}).plate.loss_factor is None
    surface = Gaussian(finish="lapped", roughness_ra_um=0.2, spacing_um=2, width_um=64, seed=1)
    assert (surface.roughness_ra_um, surface.correlation_length_um) == (0.2, 5.8)


@pytest.mark.parametrize(
    ("material", "handled", "intrinsic"),
    [
        ("steel-s235", 3.9e-3, 3.5e-4),
        ("glass", 3.8e-3, 1.1e-3),
        ("oak", 1.1e-2, 9e-3),
        ("pmma", 2.8e-2, 2.8e-2),  # of no class
        ("alumina", 4.9e-3, None),  # without an own value
        ("pom", None, None),
    ],
)
def test_a_plate_takes_the_larger_damping_unless_it_is_intrinsic(
    material: str, handled: float | None, intrinsic: float | None
) -> None:
    plate = scene(**{"plate.material": material, **BENT})
    assert plate.plate.loss_factor == handled
    own = plate.with_({"plate.damping": "intrinsic"})
    assert own.plate.loss_factor == intrinsic
    assert own.with_({"plate.damping": "handled"}).plate.loss_factor == handled
    assert own.with_({"plate.material": "glass"}).plate.loss_factor == 1.1e-3
    given = own.with_({"plate.loss_factor": 0.02})
    assert given.with_({"plate.damping": "handled"}).plate.loss_factor == 0.02
    assert loads(dump(own)) == own


def test_a_damping_without_a_material_is_refused() -> None:
    with pytest.raises(SceneError, match=r"plate\.damping: only goes with material"):
        read_scene("quickstart", ["plate.damping=intrinsic"])


def test_a_changed_name_brings_its_values_and_leaves_those_that_were_given() -> None:
    given = scene(**{"plate.hardness_gpa": 5})
    assert given.with_({"plate.material": "glass"}).plate.hardness_gpa == 5
    assert given.with_({"plate.material": "glass"}).plate.youngs_modulus_gpa == 70
    both = {"plate.hardness_gpa": 6.5, "plate.material": "glass"}  # in any order
    assert scene(**both).plate.hardness_gpa == 6.5
    numbers = read_scene("quickstart", ["sweep=", "plate.material=glass", "surface.finish=honed"])
    assert (numbers.hardness, numbers.surface.roughness_ra_um) == (6e9, 0.28)
    kept = scene().with_({"plate.material": None})
    assert kept.plate.material is None and kept.hardness == scene().hardness


def test_a_stored_scene_keeps_its_values_when_the_tables_change(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    swept = scene(sweep={"plate.material": ["glass", "oak"]})
    run = swept.runs()[0].scene
    stored = dump(run)
    identity = scene_identity(run)
    keys = contact_keys(run)
    of_sweep = scene_identity(swept)
    changed = {name: entry | {"hardness_gpa": [0.5, "x"]} for name, entry in MATERIALS.items()}
    real = library.data
    monkeypatch.setattr(library, "data", lambda table: {**real(table), "materials": changed})
    again = loads(stored)
    assert again == run and again.hardness == 6e9
    assert (scene_identity(again), contact_keys(again)) == (identity, keys)
    assert scene_identity(swept) != of_sweep  # a sweep names materials, so it is another one
    assert loads(TEXT).with_({"plate.material": "glass"}).hardness == 0.5e9


def test_the_march_does_not_depend_on_a_name() -> None:
    renamed = scene().with_({"plate.material": None, "sphere.material": None})
    assert contact_keys(renamed) == contact_keys(scene().with_({"surface.finish": "ground"}))


def test_a_sweep_over_names_has_the_values_and_labels_of_each() -> None:
    runs = scene(sweep={"plate.material": ["glass", "oak"], "surface.finish": ["ground", "lapped"]})
    plates = [run.scene.plate for run in runs.runs()]
    assert [plate.youngs_modulus_gpa for plate in plates] == [70, 70, 3.3, 3.3]

    solved = [RunFolder(**run._asdict(), folder=Path("runs")) for run in runs.runs()]
    assert labels(solved) == [
        f"plate {plate}, finish {finish}"
        for plate in ("glass", "oak")
        for finish in ("ground", "lapped")
    ]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"plate.material": "steel"}, "nearest: steel-100cr6"),
        ({"plate.material": 5}, "plate.material: got 5, allowed: steel-100cr6, "),
        ({"surface.finish": "grounded"}, "allowed: ground, honed, polished, lapped, superfinished"),
        (
            {"surface": {"kind": "smooth", "finish": "ground", "spacing_um": 2, "width_um": 64}},
            "surface.finish: unknown key of kind smooth",
        ),
        ({"plate.yield_strength_gpa": 1, "plate.hardness_gpa": 3}, "not beside hardness_gpa"),
        ({"plate.yield_strength_gpa": 14}, "below a fifteenth of youngs_modulus_gpa, 14"),
        ({"plate.hardness_gpa": "hard"}, 'got "hard", allowed: a finite number, or none'),
        ({"sweep": {"plate.material": ["oak", "oke"]}}, "sweep.plate.material[1]: got"),
    ],
)
def test_a_wrong_name_is_one_message(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as error:
        scene(**changes)
    assert message in error.value.mistakes[0] and len(error.value.mistakes) == 1


def test_editors_accept_a_name_in_place_of_its_values() -> None:
    plate = schema("ball")["$defs"]["Plate"]
    assert plate["anyOf"][0] == {"required": ["material"]}
    assert plate["required"] == []
    gaussian = schema("ball")["$defs"]["Gaussian"]
    assert gaussian["required"] == ["spacing_um", "width_um", "seed"]


def test_the_check_names_materials_and_doubts_what_the_model_does_not_hold_for() -> None:
    found = {finding.key: finding for finding in checked(scene(**{"plate.material": "oak"}))}
    assert "anisotropic" in (found["plate_material"].warning or "")
    assert found["sphere_material"].warning is None
    own = {finding.key: finding for finding in checked(scene(**{"plate.hardness_gpa": 5}))}
    assert own["plate_material"].value == "steel-100cr6, own hardness_gpa 5.0"
    assert "sphere_yields" not in own  # glass bears 6 GPa
    soft = {finding.key: finding for finding in checked(scene())}
    assert "yield at 6 GPa, before the plate" in (soft["sphere_yields"].warning or "")
