"""Errors of a scene's variants fall as theory says, and the study is kept in its folder."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hard_cases.gaussian_heights import gaussian
from scene_text import SMALL

from rolling import cli
from rolling.contact.solver import ContactError
from rolling.scene.scene import Scene
from rolling.studies import accuracy as studies
from rolling.studies import accuracy_variants as variants
from rolling.studies import work_precision
from rolling.studies.accuracy_variants import stretch_of, variant_contact, variants_of
from rolling.surface import refined

pytestmark = pytest.mark.slow
ELASTIC: dict[str, Any] = {
    "plate.hardness_gpa": None,
    "surface.seed": 3,
    "rolling": {"load_n": 1, "speed_m_s": 0.1, "duration_s": 0.002},
    "numerics.tolerance": 1e-4,
}
TEXT = """\
name: small
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 128, seed: 3}
rolling: {load_n: 0.1, speed_m_s: 0.1, duration_s: 0.0012}
numerics: {tolerance: 1e-4}
sweep: {rolling.load_n: [0.1, 0.2]}
"""


def scene_of(**changes: Any) -> Scene:
    rolling = {"load_n": 1, "speed_m_s": 0.1, "duration_s": 0.002}
    return Scene.from_dict(SMALL | {"rolling": rolling}).with_(ELASTIC | changes)


@pytest.fixture(scope="module")
def study() -> xr.Dataset:
    """Return the study of an elastic scene: spacings of 2 and 1 um against 0.5 um."""
    return studies.accuracy(scene_of(), workers=1)


@pytest.fixture(scope="module")
def table(study: xr.Dataset) -> pd.DataFrame:
    return work_precision.table(study)


def row(table: pd.DataFrame, curve: str) -> pd.Series:
    return table[table.curve == curve].iloc[0]


def test_errors_fall_with_the_spacing(table: pd.DataFrame) -> None:
    """The elastic release has order 2, 12 dB for half the spacing; the contact area has order 1."""
    own = row(table, "the scene")
    fine = row(table, "spacing, sharp edges")
    assert fine.spacing_um == own.spacing_um / 2
    assert 9 < own.error_signal_db - fine.error_signal_db < 15
    assert abs(fine.error_contact_area_percent) < 0.6 * abs(own.error_contact_area_percent)


def test_errors_of_the_solve_fall_with_the_tolerance(table: pd.DataFrame) -> None:
    """The order is above 0.7: more than 12 dB in two decades."""
    rows = table[table.curve.isin(["the scene", "tolerance"])].sort_values("tolerance")
    off = rows.solver_error_signal_db.to_list()
    assert rows.tolerance.to_list() == [1e-6, 1e-5, 1e-4, 1e-3, 1e-2]
    assert all(tight < loose for tight, loose in pairwise(off))
    assert all(tight < loose - 12 for tight, loose in zip(off, off[2:], strict=False))


def test_the_reference_has_no_error_and_all_others_have(table: pd.DataFrame) -> None:
    best = row(table, "reference")
    others = table[table.curve != "reference"]
    assert best.error_laeq_db == 0 and best.worst_band_db == 0
    assert (others.error_laeq_db.abs() > 0).all() and (others.worst_band_db > 0).all()
    assert (table.seconds_per_second > 0).all()
    assert (table.convolutions >= table.iterations).all()


def test_steps_too_long_for_hearing_lose_bands_and_are_not_recommended(
    study: xr.Dataset, table: pd.DataFrame
) -> None:
    """Steps of 8 um at 0.1 m/s end at 6.25 kHz."""
    (long,) = (line for _, line in table.iterrows() if line.step_um == 8)
    assert long.worst_band_db == np.inf and np.isnan(long.error_db_16000)
    assert not any("step 8" in line for line in work_precision.advice(study, table))


def recommended(study: xr.Dataset, **errors: list[float]) -> str:
    """Return the recommendation for three grids of 2, 1 and 0.5 um with these errors."""
    curves = ["the scene", "spacing, sharp edges", "reference"]
    frame = work_precision.table(study)
    frame = frame.groupby("curve").first().loc[curves].reset_index().assign(**errors)
    return next(line for line in work_precision.advice(study, frame) if " within " in line)


def test_recommended_is_the_cheapest_variant_within_the_limits(study: xr.Dataset) -> None:
    """The errors of the grid beside the reference are added, because they bound its own error."""
    near = {"error_laeq_db": [0.04, 0.01, 0.0], "worst_band_db": [0.3, 0.1, 0.0]}
    assert "spacing 2 µm" in recommended(study, **near)
    assert "spacing 1 µm" in recommended(study, **near | {"worst_band_db": [0.45, 0.1, 0.0]})
    assert "spacing 1 µm" in recommended(study, **near | {"error_laeq_db": [0.095, 0.01, 0.0]})
    assert "no variant" in recommended(study, **near | {"worst_band_db": [0.6, 0.3, 0.0]})


# ---- variants


def test_variants_cover_both_edges_of_a_yielding_plate_once() -> None:
    hard = scene_of(**{"plate.hardness_gpa": 2.1, "numerics.step_nodes": 3})
    cut, nodes = stretch_of(hard.with_({"rolling.duration_s": 0.02}), 0.0045)
    assert nodes % 12 == 0  # whole numbers of the scene's step and of the longest step
    assert nodes == cut.track.n_along == 216
    variants = variants_of(cut, 8)
    assert len(set(variants)) == len(variants)
    assert {v.edges for v in variants if v.times == 4} == {"sharp", "blended"}
    assert [v.edges for v in variants if v.times == 8] == ["blended"]


def test_height_files_are_refined_by_their_spectrum(tmp_path: Path) -> None:
    """Between the nodes a smooth file continues, and pits of one node have flat cells."""
    smooth = gaussian((120, 64), 2e-6, 1e-7, (10e-6, 10e-6), "gaussian", 1)
    pits = smooth.copy()
    pits[np.random.default_rng(2).random(pits.shape) < 0.02] -= 2e-6
    contacts = {}
    for name, z in (("smooth", smooth), ("pits", pits)):
        np.save(tmp_path / f"{name}.npy", z)
        file = {"kind": "file", "path": f"{name}.npy", "height_unit": "m", "spacing_um": 2}
        scene = Scene.from_dict(scene_of().to_dict() | {"surface": file}, tmp_path)
        own, reference = variants_of(scene, 4)[:2]
        contacts[name] = variant_contact(scene, own), variant_contact(scene, reference)
    own, fine = contacts["pits"]
    flat = np.repeat(np.repeat(own.heights, 4, axis=0), 4, axis=1)
    assert not fine.slopes and np.array_equal(fine.heights, flat)
    assert fine.position(0) - own.position(0) == pytest.approx(1.5 * fine.spacing)
    own, fine = contacts["smooth"]
    assert fine.slopes and len(np.unique(fine.heights[:4, :4])) == 16
    assert fine.position(0) == own.position(0)


@pytest.mark.parametrize("times", [3, 4])
def test_refining_keeps_the_nodes_and_the_line_of_the_sphere(times: int) -> None:
    """A ridge about mid-width stays symmetric where mid-width lies between nodes."""
    across = np.arange(64) - 31.5
    ridge = np.tile(np.cos(2 * np.pi * across / 64), (16, 1))
    fine = refined.refined(ridge, times)
    assert fine.shape == (16 * times, 64 * times)
    assert np.allclose(fine, fine[:, ::-1], atol=1e-14)
    if times % 2:  # an odd refinement moves the surface by whole fine nodes
        assert np.allclose(
            np.roll(fine, -(times // 2), axis=1)[::times, ::times], ridge, atol=1e-13
        )


# ---- the command


@pytest.fixture
def command(tmp_path: Path) -> list[str]:
    (tmp_path / "small.yaml").write_text(TEXT)
    words = ["accuracy", str(tmp_path / "small.yaml"), "--workers", "1", "--finest", "2"]
    return [*words, "--out", str(tmp_path / "out")]


def test_the_same_command_finds_its_study_and_another_scene_is_refused(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(command) == 0
    printed = capsys.readouterr().out
    out = tmp_path / "out"
    names = {"accuracy.nc", "accuracy.csv", "accuracy.png"}
    assert {path.name for path in out.iterdir()} == names
    before = (out / "accuracy.nc").stat().st_mtime_ns
    assert cli.main(command) == 0 and capsys.readouterr().out == printed
    assert (out / "accuracy.nc").stat().st_mtime_ns == before
    for other in (["--set", "rolling.load_n=0.2"], ["--duration", "0.001"]):
        assert cli.main([*command, *other]) == 2
        assert "another scene" in capsys.readouterr().err
    frame = pd.read_csv(out / "accuracy.csv")
    assert len(frame) == xr.load_dataset(out / "accuracy.nc").sizes["variant"]


def test_a_failed_variant_is_named_and_a_failed_scene_ends_the_study(
    command: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    march = variants.march_variant
    failing = {1e-2}

    def marched(scene, variant, *rest):
        if variant.tolerance in failing:
            raise ContactError("the march failed")
        return march(scene, variant, *rest)

    monkeypatch.setattr(variants, "march_variant", marched)
    assert cli.main(command) == 0
    assert "failed: tolerance 1e-2: the march failed" in capsys.readouterr().out
    failing.add(1e-4)
    assert cli.main([*command[:-1], command[-1] + "-2"]) == 1
    assert "the scene" in capsys.readouterr().err


def test_a_silent_scene_is_compared_without_levels(
    command: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    """A smooth sphere on whole-node steps is silent to the last digit."""
    assert (
        cli.main([*command, "--set", "surface={kind: smooth, spacing_um: 2, width_um: 128}"]) == 0
    )
    assert "the reference is silent" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "SCENE"),
        (["none.yaml"], "none.yaml"),
        (["small.yaml", "--finest", "3"], "2, 4, 8"),
        (["small.yaml", "--set", "rolling.load_m=1"], "rolling.load_n"),
        (["small.yaml", "--out", "full"], "no study of accuracy"),
    ],
)
def test_bad_usage_is_refused_before_anything_is_written(
    arguments: list[str],
    words: str,
    command: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "notes.txt").write_text("mine")
    try:
        code = cli.main(["accuracy", *arguments])
    except SystemExit as stopped:
        code = stopped.code
    assert code == 2 and words in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["full", "notes.txt", "small.yaml"]
