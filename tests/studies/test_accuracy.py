"""Errors fall as theory says, and recommended settings keep their limits."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rolling import cli
from rolling.accuracy import errors, variants
from rolling.accuracy.errors import BANDS, ERRORS, Candidate, recommend
from rolling.contact.solver import ContactError
from rolling.folders import own_files, run_record
from rolling.scene import file
from rolling.surface import heights as surface
from rolling.surface import refined
from rolling.verification import hard_report

pytestmark = pytest.mark.slow

SCENE = """\
name: small
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}
surface: {kind: gaussian, roughness_ra_um: 0.1, correlation_length_um: 10, \
spacing_um: 2, width_um: 128, seed: 3}
rolling: {load_n: 1, speed_m_s: 0.1, duration_s: 0.002}
sweep: {rolling.load_n: [1, 2]}
"""
QUICK = ("--workers", "1", "--finest", "2", "--set", "rolling.load_n=0.3")


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("scene") / "small.yaml"
    path.write_text(SCENE)
    return path


@pytest.fixture(scope="module")
def folder(scene: Path) -> Path:
    """Return a study of an elastic scene: spacings of 2 and 1 um against 0.5 um."""
    out = scene.parent / "out"
    assert cli.main(["accuracy", str(scene), "--workers", "1", "--out", str(out)]) == 0
    return out


@pytest.fixture(scope="module")
def found(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "accuracy.json").read_text())


def rows(found: dict[str, Any], **settings: Any) -> list[dict[str, Any]]:
    return [
        row
        for row in found["variants"]
        if all(row[name] == value for name, value in settings.items())
    ]


def test_files(folder: Path, found: dict[str, Any]) -> None:
    for name in ("accuracy.md", "accuracy.png", "accuracy.svg", "scene.yaml", "run.json"):
        assert (folder / name).stat().st_size > 20
    assert {f.stem for f in (folder / "variants").iterdir()} == {
        row["name"] for row in found["variants"]
    }
    record = run_record.read(folder)
    assert record is not None and record.kind == "accuracy" and record.state == "done"
    assert own_files.foreign(folder, record) == []  # --force knows every file
    assert found["run"] == "load 1 N"
    assert found["track"] == {"nodes": 100, "closed": True, "length_m": pytest.approx(2e-4)}


def test_text_has_every_section(folder: Path) -> None:
    text = (folder / "accuracy.md").read_text()
    for title in (
        "Recommendation",
        "The solve alone",
        "own error",
        "Third octaves",
        "Observed orders",
        "raw fluctuation",
    ):
        assert title in text
    assert "nan" not in text and "inf " not in text


def test_errors_are_finite_and_the_references_are_zero(found: dict[str, Any]) -> None:
    for row in found["variants"]:
        assert all(
            row["errors"][name] is not None for name in ERRORS if not name.startswith("plastic")
        )
        if row["highest_hz"] >= 20e3:
            assert all(
                row["errors"][band] is not None
                for band in BANDS
                if rows(found)[0]["third_octave_db"][band]
            )
        assert row["seconds_per_second"] > 0 and row["convolutions"] >= row["iterations"] > 0
    (reference,) = rows(found, name=found["reference"])
    assert not any(reference["errors"].values())
    (solved,) = rows(found, name=found["solver_reference"])
    assert not any(solved["solver_errors"].values())


def test_errors_fall_with_the_spacing(found: dict[str, Any]) -> None:
    """The elastic release has order 2 (1.9 here), and the contact area order 1 (0.95 here)."""
    orders = found["orders"]["spacing, sharp edges"]
    assert orders["signal"] > 1.5 and orders["contact_area_percent"] > 0.8
    own, fine = (
        rows(found, times=t, step_nodes=1, tolerance=1e-4 / t, precision="single", width=1)[0]
        for t in (1, 2)
    )
    assert fine["errors"]["signal"] < 0.5 * own["errors"]["signal"]
    assert abs(fine["errors"]["contact_area_percent"]) < 0.6 * abs(
        own["errors"]["contact_area_percent"]
    )


def test_errors_fall_with_the_tolerance(found: dict[str, Any]) -> None:
    by_tolerance = {
        row["tolerance"]: row["solver_errors"]["signal"]
        for row in rows(found, times=1, step_nodes=1, precision="single", width=1)
    }
    off = [by_tolerance[t] for t in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)]
    assert all(b < a for a, b in pairwise(off))
    assert all(b < 0.25 * a for a, b in zip(off, off[2:], strict=False))  # in two decades
    assert found["orders"]["tolerance"]["signal"] > 0.7


def test_steps_too_long_for_hearing_are_marked_and_not_recommended(
    folder: Path, found: dict[str, Any]
) -> None:
    (long,) = rows(found, step_nodes=4)
    assert long["highest_hz"] == pytest.approx(6250) and long["errors"]["16000"] is None
    assert "| 8* " in (folder / "accuracy.md").read_text()
    assert found["recommendation"]["laeq_only"]["name"] != long["name"]


def test_refining_keeps_the_nodes() -> None:
    heights = surface.gaussian((120, 64), 2e-6, 1e-7, (10e-6, 10e-6), "gaussian", 1)
    fine = refined.refined(
        heights, 3
    )  # an odd refinement moves the surface by whole fine nodes: every third is an old one
    assert np.allclose(
        np.roll(fine, -1, axis=1)[::3, ::3], heights, atol=1e-13 * np.abs(heights).max()
    )


def test_refining_keeps_the_line_of_the_sphere() -> None:
    """A ridge symmetric about mid-width stays symmetric in a refined grid.

    The refinement may be even, with mid-width between nodes.
    """
    across = np.arange(64) - 31.5
    ridge = np.tile(np.cos(2 * np.pi * across / 64), (16, 1))
    fine = refined.refined(ridge, 4)
    assert np.allclose(fine, fine[:, ::-1], atol=1e-14) and fine.shape == (64, 256)


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_extrapolation_finds_the_error_of_the_finest_grid(order: float) -> None:
    value = {times: 7 + 3 * times**-order for times in (1, 2, 4)}
    left = errors.extrapolated({"x": value[1] - value[2]}, {"x": value[2] - value[4]})
    assert left["x"] == pytest.approx(value[4] - 7)


def test_order_is_the_slope() -> None:
    assert errors.observed_order([1, 2, 4], [-0.3, 1.2, 4.8]) == pytest.approx(2)
    assert math.isnan(errors.observed_order([1, 2], [0.1, 0.0]))


def test_recommended_is_the_cheapest_within_the_limits() -> None:
    cheap, levels, good, best = (
        Candidate("cheap", 1, 0.2, 3.0),
        Candidate("levels", 2, 0.09, 2.0),
        Candidate("good", 5, 0.1, 0.5),
        Candidate("best", 9, 0.01, 0.1),
    )
    lost = Candidate("lost", 0.5, 0.01, math.inf)
    advice = recommend([best, good, levels, cheap, lost])
    assert (advice.both, advice.laeq_only, advice.nearest) == (good, levels, best)


def test_nothing_is_recommended_when_nothing_keeps_the_limits() -> None:
    far, near = Candidate("far", 1, 0.5, 3.0), Candidate("near", 9, 0.2, 0.4)
    advice = recommend([far, near])
    assert advice.both is None and advice.laeq_only is None and advice.nearest == near
    assert recommend([]).nearest is None


def test_loosest_tolerance_stays_below_grid_and_limit() -> None:
    off = {1e-2: 0.2, 1e-3: 0.02, 1e-4: 0.002, 1e-5: 0.0002}
    # 1e-3 is 28 dB below the grid's, but above -40 dB
    assert errors.loosest_tolerance(off, grid_error=0.5) == 1e-4
    assert errors.loosest_tolerance(off, grid_error=0.003) == 1e-5
    assert errors.loosest_tolerance(off, grid_error=0.0) is None


def test_the_scene_of_a_yielding_plate_is_tried_with_both_edges(scene: Path) -> None:
    hard = file.read_scene(
        scene, ["rolling.load_n=1", "plate.hardness_gpa=2.1", "numerics.step_nodes=3"]
    )
    what = variants.study_of(hard, 0.045, 8)
    assert what.nodes % 12 == 0  # whole numbers of the scene's step and of the longest one tried
    every = what.variants()
    assert (
        every[0] == what.reference("blended")
        and every[0].times == 8
        and len(set(every)) == len(every)
    )
    assert {v.edges for v in every if v.times == 4} == {"sharp", "blended"}


def test_a_failed_variant_says_why_and_the_others_go_on(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def failing(march: Callable) -> Callable:
        def piece(scene, variant, *rest):
            if variant.tolerance == 1e-2:
                raise ContactError("no luck today")
            return march(scene, variant, *rest)

        return piece

    monkeypatch.setattr(variants, "march_piece", failing(variants.march_piece))
    out = tmp_path / "out"
    assert cli.main(["accuracy", str(scene), *QUICK, "--out", str(out)]) == 0
    assert "failed: no luck today" in capsys.readouterr().out
    found = json.loads((out / "accuracy.json").read_text())
    assert len(found["failures"]) == 1 and len(found["variants"]) > 10


@pytest.mark.parametrize("whole", [1, 3])
def test_interrupted_keeps_what_is_there(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: int
) -> None:
    measure, done = errors.measure, []

    def interrupted(*arguments):
        done.append(measure(*arguments))
        if len(done) == whole:
            os.kill(os.getpid(), signal.SIGINT)
        return done[-1]

    monkeypatch.setattr(errors, "measure", interrupted)
    out = tmp_path / "out"
    assert cli.main(["accuracy", str(scene), *QUICK, "--out", str(out)]) == 130
    kept = json.loads((out / "accuracy.json").read_text())["variants"]
    assert len(kept) == whole == len([*(out / "variants").glob("*.json")])
    assert len([*(out / "variants").glob("*.npz")]) >= whole  # pieces of which the study goes on
    # of the reference alone there is nothing to draw
    assert (out / "accuracy.png").exists() == (whole > 1)
    assert run_record.read(out).state != "done"


def test_a_killed_study_goes_on_with_what_it_lacks(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    command = ["accuracy", str(scene), *QUICK, "--out", str(out)]
    killed = (
        "import os, signal; from rolling import cli; from rolling.accuracy import kept\n"
        "write, count = kept.write_piece, []\n"
        "def counted(*arguments):\n"
        "    write(*arguments); count.append(1)\n"
        "    if len(count) == 5: os.kill(os.getpid(), signal.SIGKILL)\n"
        f"kept.write_piece = counted; cli.main({command})"
    )
    assert subprocess.run([sys.executable, "-c", killed], check=False).returncode == -9
    assert not (out / "accuracy.json").exists()
    before = {path: path.read_bytes() for path in (out / "variants").glob("*.npz")}
    assert len(before) == 5
    next(iter(before)).write_bytes(b"damaged")

    marched: list[variants.Variant] = []
    inner = variants.march_piece

    def count(scene, variant, *rest):
        marched.append(variant)
        return inner(scene, variant, *rest)

    monkeypatch.setattr(variants, "march_piece", count)
    for other in ("rolling.load_n=0.2", "surface.seed=4"):
        assert cli.main([*command, "--set", other]) == 2
        assert other.split("=")[0] in capsys.readouterr().err
    assert cli.main([part if part != "2" else "4" for part in command]) == 2
    assert "--finest" in capsys.readouterr().err and not marched
    assert cli.main(command) == 0
    assert f"of {len(marched) + 4} pieces" in capsys.readouterr().err
    found = json.loads((out / "accuracy.json").read_text())
    assert len(marched) == len(found["variants"]) - 4 and not found["failures"]
    assert {path.suffix for path in (out / "variants").iterdir()} == {".json"}
    assert run_record.read(out).state == "done"
    assert cli.main(command) == 2 and "--force" in capsys.readouterr().err


def test_nothing_is_overwritten(
    scene: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (folder / "accuracy.json").read_bytes()
    assert cli.main(["accuracy", str(scene), *QUICK, "--out", str(folder)]) == 2
    assert "--force" in capsys.readouterr().err
    assert (folder / "accuracy.json").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "SCENE"),
        (["none.yaml"], "none.yaml"),
        (["small.yaml", "--random", "3"], "--random"),
        (["small.yaml", "--hard"], "SCENE cannot go with --hard"),
        (["--hard", "--duration", "1"], "--duration cannot go with --hard"),
        (["small.yaml", "--set", "rolling.load_m=1"], "rolling.load_n"),
    ],
)
def test_bad_usage(
    arguments: list[str],
    words: str,
    scene: Path,
    tmp_path: Path,
    monkeypatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.yaml").write_bytes(scene.read_bytes())
    assert cli.main(["accuracy", *arguments, "--out", "out"]) == 2
    assert words in capsys.readouterr().err
    assert [f.name for f in tmp_path.iterdir()] == ["small.yaml"]


def test_a_silent_scene_is_compared_without_levels(scene: Path, tmp_path: Path, capsys) -> None:
    """A smooth sphere on whole-node steps is silent to the last digit."""
    smooth = ["surface={kind: smooth, spacing_um: 2, width_um: 128}", "rolling.duration_s=0.001"]
    out, settings = tmp_path / "out", [part for key in smooth for part in ("--set", key)]
    assert cli.main(["accuracy", str(scene), *QUICK, *settings, "--out", str(out)]) == 0
    assert "the reference is silent" in capsys.readouterr().out
    assert not (out / "accuracy.png").exists()


def test_refined_by_powers_of_two_only(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        cli.main(["accuracy", "small.yaml", "--finest", "3"])
    assert stopped.value.code == 2 and "2, 4, 8" in capsys.readouterr().err


def test_hard_cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple] = []
    monkeypatch.setattr(hard_report, "main_report", lambda *arguments: asked.append(arguments) or 1)
    assert (
        cli.main(
            [
                "accuracy",
                "--hard",
                "--random",
                "4",
                "--workers",
                "2",
                "--out",
                str(tmp_path),
                "--long",
            ]
        )
        == 1
    )
    assert asked == [(tmp_path, 4, 2, True)]
