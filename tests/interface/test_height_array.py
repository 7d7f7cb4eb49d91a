"""Arrays of numpy are heard like files of the same heights, and wrong arrays are named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hard_cases.gaussian_heights import gaussian
from scene_text import PLAIN

import rolling as rc
from rolling.scene import file

Z = gaussian((96, 80), 2e-6, 1e-7, (1e-5, 1e-5), "gaussian", 1)
SHORT = ["rolling.load_n=0.1", "rolling.duration_s=2e-4"]


def test_an_array_is_heard_in_five_lines(tmp_path: Path) -> None:
    """The array, a file of it and the stored run have the same numbers, in one process or two."""
    scene = file.loads(PLAIN, SHORT)
    run = rc.simulate(scene, heights=rc.HeightArray(Z, spacing_um=2), workers=2, progress=False)
    again = rc.simulate(scene, heights=Z, workers=1, progress=False)
    assert run.release_power.tolist() == again.release_power.tolist()
    assert run.scene.check(solve=False) and run.scene.track.n_along == 96
    folder = run.save(tmp_path / "run", report=False)
    assert (folder / "heights.npy").is_file()
    moved = folder.rename(tmp_path / "elsewhere")
    stored = rc.open_run(moved)
    assert stored.scene.surface.path == "heights.npy"  # type: ignore[union-attr]
    assert stored.release_power.tolist() == run.release_power.tolist()
    np.save(tmp_path / "h.npy", Z)
    named = rc.HeightFile(path=str(tmp_path / "h.npy"), spacing_um=2)
    from_file = rc.simulate(scene.with_(surface=named), workers=1, progress=False)
    assert from_file.release_power.tolist() == run.release_power.tolist()


def test_steps_of_the_preparation_are_stored(tmp_path: Path) -> None:
    """The numbers hold the roughness before and after each step, in numbers and in words."""
    gaps = np.where(Z > 2e-7, np.nan, Z)
    measured = rc.HeightArray(gaps, spacing_um=2, unmeasured="fill", periodic="blend")
    scene = file.loads(PLAIN, SHORT).with_(surface=measured)
    folder = rc.simulate(scene, workers=1, progress=False).save(tmp_path / "run", report=False)
    steps = rc.open_run(folder).numbers.surface.preparation
    assert [step.step for step in steps] == ["unmeasured", "f_operator", "periodic"]
    number = np.count_nonzero(np.isnan(gaps))
    assert steps[0].text.startswith(f"{number} filled, ") and " -> " in steps[0].text
    assert steps[0].before["Sq"] == pytest.approx(np.nanstd(gaps), rel=1e-9)
    assert rc.open_run(folder).scene.track.n_along == 96 - 10


@pytest.mark.parametrize(
    ("heights", "words"),
    [
        (Z + 1j, "got 2-D complex128"),
        (Z[None], "got 3-D float64"),
        (Z[:5], r"shape \(5, 80\)"),
        (Z[0, :5], r"shape \(5,\)"),
        (Z[:0], r"shape \(0, 80\)"),
        ([[1, 2], [3]], "rows of several lengths"),
        ("heights.npy", "got 0-D <U11"),
        (None, "got 0-D object"),
        (np.where(Z > 2e-7, np.nan, Z), r"heights: \d+ of 7680 heights are not numbers, the first"),
        (np.ma.masked_greater(Z, 2e-7), r"heights: \d+ of 7680 heights are not numbers"),
        (Z * np.inf, "7680 of 7680 heights are not numbers"),
        (Z * 1e15, "got a height of .* allowed: up to 1000000 m"),
        (Z * 1e6, "Ra would be .* surface.height_unit"),
    ],
)
def test_a_wrong_array_is_named_in_one_sentence(heights: object, words: str) -> None:
    with pytest.raises(ValueError, match=words) as error:
        rc.HeightArray(heights, spacing_um=2)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("spacing", [0, -1, np.nan, np.inf, "2", None, 1e20])
def test_a_wrong_spacing_is_named(spacing: object) -> None:
    with pytest.raises(ValueError, match="spacing_um: got"):
        rc.HeightArray(Z, spacing_um=spacing)  # type: ignore[arg-type]


def test_a_run_that_fails_names_the_marks_and_no_key_that_a_file_lacks() -> None:
    """A pair of points at the end of a digitizer carries the sphere, and the contact is too wide.

    The kind of surface has no surface.width_um for a map, so the message does not name it.
    """
    heights = Z[:48, :48].copy()
    heights[10:12, 20] = heights[10:12, 30] = 32767e-9
    scene = file.loads(PLAIN, SHORT).with_(surface=rc.HeightArray(heights, spacing_um=2))
    with pytest.raises(
        rc.ContactError, match=r"4 of 2304 heights are exactly 3.2767e-05 m"
    ) as error:
        rc.simulate(scene, workers=1, progress=False)
    assert "surface.outliers" in str(error.value) and "width_um" not in str(error.value)
    assert any("3.2767e-05 m" in warning for warning in scene.check(solve=False).warnings)
