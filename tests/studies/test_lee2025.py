"""The study of the article runs, continues, and keeps to the article's cases and method."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hard_cases.dense import dense_contact

from acoustics.bands import BAND_NAMES
from acoustics.radiation import I_REF_W_M2
from rolling import cli
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.state import Window
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.kinds.reading import read_scene
from rolling.results.stored_numbers import read_stored
from rolling.scene import library
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian
from rolling.studies import lee2025 as reproduce
from rolling.studies.lee2025_cases import band_columns

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
READINGS = ROOT / "scenarios" / "lee2025"
TWINS = {"elastic-gaussian": "as-stated", "elastic-exponential": "hardness-3y-exponential"}
TEXT = """\
# A small reading.
name: small
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3HARDNESS}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 4, width_um: 256, seed: 1}
rolling: {load_n: 5, speed_m_s: 0.1, duration_s: 0.004}
sweep: {surface.roughness_ra_um: [0.05, 0.1], rolling.load_n: [5, 10]}
"""


def settings_of(scene: Scene) -> tuple[float, float, int]:
    assert isinstance(scene.surface, Gaussian)
    return scene.surface.roughness_ra_um, scene.load, scene.surface.seed


def runs_of(reading: str, quick: bool = False) -> dict[tuple[float, float, int], Scene]:
    """Return the scenes of a reading by roughness, load and surface."""
    runs = {}
    for file in (READINGS / reading).glob("*.yaml"):
        overrides = reproduce.quick_overrides(read_scene(file)) if quick else ()
        runs |= {settings_of(run): run for _, run in read_scene(file, overrides).runs()}
    return runs


def test_readings_are_the_articles_cases() -> None:
    """Readings have four roughnesses, five loads, one to three surfaces, and are rigid as stated.

    Twins differ from their scenes in hardness and tolerance only.
    """
    for reading in ("as-stated", "hardness-3y-exponential", "hardness-3y-gaussian"):
        runs = runs_of(reading)
        cases = {(ra, load) for ra, load, _ in runs}
        assert cases == {(ra, load) for ra in (0.01, 0.1, 1, 5) for load in (5, 10, 20, 50, 100)}
        assert {(run.sphere.radius_mm, run.sphere.youngs_modulus_gpa) for run in runs.values()} == {
            (5, None)
        }
    for twin, reading in TWINS.items():
        runs = runs_of(reading)
        for settings, scene in runs_of(twin).items():
            ours = scene.to_dict()
            theirs = runs[settings].to_dict()
            assert theirs["plate"].pop("hardness_gpa") and "hardness_gpa" not in ours["plate"]
            for data in (ours, theirs):
                del data["name"], data["numerics"]["tolerance"]
            assert ours == theirs
    quick = runs_of("as-stated", quick=True)
    assert {(load, seed) for _, load, seed in quick} == {(5, 1), (20, 1), (100, 1)}


def test_a_study_is_solved_once_and_judged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for reading, hardness in (("plastic", ", hardness_gpa: 2.1"), ("elastic", "")):
        file = tmp_path / "scenes" / "lee2025" / reading / "all.yaml"
        file.parent.mkdir(parents=True)
        file.write_text(TEXT.replace("HARDNESS", hardness))
    monkeypatch.setattr(library, "folder", lambda: tmp_path / "scenes")
    out = tmp_path / "out"
    command = ["reproduce", "lee2025", "--out", str(out), "--workers", "1"]
    assert cli.main([*command, "--readings", "plastic"]) == 0
    results = {path: path.stat().st_mtime_ns for path in out.rglob("result.h5")}
    assert len(results) == 4
    assert cli.main(command) == 0
    assert "8 cases" in capsys.readouterr().err
    assert all(path.stat().st_mtime_ns == then for path, then in results.items())

    cases = pd.read_csv(out / "cases.csv")
    plastic = cases[cases["reading"] == "plastic"]
    assert len(cases) == 8 and (plastic["plastic_ratio"] > 0).all()
    # The third octaves add up to the fluctuation within hearing (Parseval) at 1 m; 1e-2 is the
    # share outside of the bands.
    bands = (10 ** (cases[band_columns(BAND_NAMES)] / 10)).sum(axis=1)
    energies = [read_stored(path.parent).numbers.energy for path in out.rglob("numbers.json")]
    watts = sorted(energy.release_power_audible_rms_w for energy in energies)
    assert sorted(np.sqrt(bands) * 4 * math.pi * I_REF_W_M2) == pytest.approx(watts, rel=1e-2)
    verdicts = pd.read_csv(out / "statements.csv").set_index("key")["verdict"]
    assert verdicts["plastic-area-load"] == "holds"
    assert verdicts["yielding-deflection"] == "holds"
    assert verdicts["maximum-load"].tolist() == ["not run", "not run"]  # needs 100 N
    assert "|plastic-area-load|" in (out / "tables.md").read_text()
    figures = {path.stem for path in (out / "figures").glob("plastic-*.png")}
    assert figures == {
        "plastic-fig1_surfaces",
        "plastic-fig5_contact_pressure",
        "plastic-fig6_deflection",
        "plastic-fig7_plastic_ratio",
        "plastic-fig8_spectra",
        "plastic-fig9_maximum_level",
    }


def test_wrong_readings_and_foreign_folders_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    command = ["reproduce", "lee2025", "--out", str(out)]
    assert cli.main([*command, "--readings", "as-statet"]) == 2
    assert "nearest: as-stated" in capsys.readouterr().err and not out.exists()
    out.mkdir()
    (out / "letter.txt").write_text("mine")
    assert cli.main(command) == 2
    assert "no study of this program" in capsys.readouterr().err
    assert [path.name for path in out.iterdir()] == ["letter.txt"]


@pytest.mark.parametrize(
    ("reading", "roughness"), [("as-stated", 0.01), ("hardness-3y-exponential", 0.1)]
)
def test_the_articles_own_method_agrees(reading: str, roughness: float) -> None:
    """Influence matrix and active set give pressures within 1e-6 of the maximum.

    Edges are sharp, as in the article (Fig. 3). At 1 N the dense matrix is small.
    """
    scene = runs_of(reading, quick=True)[roughness, 5.0, 1]
    contact = replace(rolling_contact(scene), load=1.0, blended=False, tolerance=1e-9)
    (state,) = march(contact, 0, 0, HalfSpace(contact.spacing, contact.contact_modulus))
    loaded = state.loaded
    block = Window(loaded.row - 2, loaded.column - 2, loaded.rows + 4, loaded.columns + 4)
    bodies = contact.spacing, contact.contact_modulus, contact.hardness
    pressure, approach = dense_contact(contact.gap(0, block), contact.load, *bodies)
    difference = np.abs(state.window.moved(state.pressure, block) - pressure).max()
    assert difference < 1e-6 * pressure.max()
    assert state.approach == pytest.approx(approach, rel=1e-7)
