"""Check and run report tilt, seam and resolution of measured heights in numbers."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from checked import Row, checked
from hard_cases import gaussian_heights
from scene_sounds import sound_of_release

from rolling.check import cost
from rolling.in_si import in_metres, scene_surface
from rolling.kinds.reading import schema
from rolling.scene import file
from rolling.scene.laws import AUTOCORRELATIONS
from rolling.scene.scene import Scene
from rolling.surface import heights as surface

SPACING = 2e-6
TEXT = """\
name: measured
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3, hardness_gpa: 2.1}
surface: {kind: file, path: heights.npy, spacing_um: 2}
rolling: {load_n: 0.5, speed_m_s: 0.1}
"""


def gaussian(rows: int, columns: int, nodes: float = 6.0, seed: int = 3) -> np.ndarray:
    return gaussian_heights.gaussian(
        (rows, columns), SPACING, 1e-7, (nodes * SPACING, nodes * SPACING), "gaussian", seed
    )


def tilted_crop() -> np.ndarray:
    """Return a fifth of a surface on a table that rises by 1 um."""
    return gaussian(1000, 120)[:200, :80] + np.linspace(0, 1e-6, 200)[:, None]


def scene(folder: Path, heights: np.ndarray, *overrides: str) -> Scene:
    np.save(folder / "heights.npy", heights)
    return file.loads(TEXT, overrides, folder=folder)


def found(folder: Path, heights: np.ndarray, *overrides: str) -> dict[str, Row]:
    return {finding.key: finding for finding in checked(scene(folder, heights, *overrides))}


# ---- Tilt and seam


def test_check_says_what_was_taken_off_and_what_stays(tmp_path: Path) -> None:
    got = found(tmp_path, tilted_crop())
    assert got["level"].value.startswith("plane removed: ")
    # 1 um over 199 of 200 nodes of 2 um is 2.51 um/mm; the crop has a random slope of its own.
    slope = float(got["level"].value.split(": ")[1].split()[0])
    assert slope == pytest.approx(2.51, rel=0.05)
    assert "Ra " in got["level"].value and " before, " in got["level"].value
    warning = got["seam"].warning
    assert warning is not None
    assert (
        "no period of a surface" in warning
        and "does not loop" in warning
        and "surface.periodic to blend" in warning
    )
    # The contact, 0.0402 mm wide by Hertz (a^3 = 3 W R / (4 E*) gives a = 20.1 um), crosses the
    # seam once on 0.4 mm at 0.1 m/s.
    assert "402 us of the record's 4 ms (10 %)" in warning


def test_a_stretch_that_avoids_the_seam_is_not_warned(tmp_path: Path) -> None:
    advice = "rolling.start_um=100", "rolling.duration_s=0.002"
    got = found(tmp_path, tilted_crop(), *advice)
    assert got["seam"].value.endswith("stands out") and got["seam"].warning is None
    touching = found(tmp_path, tilted_crop(), "rolling.start_um=190", "rolling.duration_s=0.002")
    # From 190 to 390 um: the last 10 um lie within 20.1 um of the seam at 400 um, 10.1 um of 200.
    assert "101 us of the record's 2 ms (5.1 %)" in str(touching["seam"].warning)


def test_periodic_heights_have_no_finding_but_values(tmp_path: Path) -> None:
    heights = gaussian(200, 80)
    got = found(tmp_path, heights)
    assert got["level"].value.startswith("nothing removed, the plane has ")
    assert {
        key: got[key].warning for key in ("level", "seam", "form", "correlation_nodes")
    } == dict.fromkeys(("level", "seam", "form", "correlation_nodes"))
    read = in_metres.read_heights(tmp_path / "heights.npy")
    for mode in ("auto", "none"):
        given = file.loads(TEXT, [f"surface.level={mode}"], folder=tmp_path)
        assert np.array_equal(scene_surface.heights(given), read)


def test_all_numbers_are_of_the_levelled_heights(tmp_path: Path) -> None:
    """Roughness, slope, statistics and march use the same levelled heights.

    No part reads the file again.
    """
    given = scene(tmp_path, tilted_crop())
    heights = scene_surface.heights(given)
    rq, slope = cost.roughness(given)
    assert rq == np.sqrt(np.mean((heights - heights.mean()) ** 2))
    assert slope == surface.statistics(heights, SPACING).rms_slope
    # The tilt alone has an Rq of 1 um / sqrt 12.
    assert rq < 0.5 * cost.roughness(scene(tmp_path, tilted_crop(), "surface.level=none"))[0]


def test_a_file_written_again_is_read_again(tmp_path: Path) -> None:
    before = scene_surface.heights(scene(tmp_path, gaussian(200, 80))).copy()
    assert not np.array_equal(
        scene_surface.heights(scene(tmp_path, gaussian(200, 80, seed=4))), before
    )


def test_none_says_that_a_plane_passes_for_roughness(tmp_path: Path) -> None:
    got = found(tmp_path, tilted_crop(), "surface.level=none")
    assert got["level"].value.startswith("nothing removed, the plane has 2.")
    assert "a plane and a parabola make up 8" in str(
        got["form"].warning
    ) and "surface.level quadratic" in str(got["form"].warning)
    barrel = 1e-6 * np.linspace(-1, 1, 200)[:, None] ** 2 + gaussian(200, 80)
    assert found(tmp_path, barrel)["form"].warning is not None


def test_level_is_a_key_with_three_values(tmp_path: Path) -> None:
    assert found(tmp_path, gaussian(200, 80), "surface.level=plane")["level"].value.startswith(
        "plane removed"
    )
    with pytest.raises(Exception, match=r"surface\.level: got \"plain\", allowed: .*plane"):
        scene(tmp_path, gaussian(200, 80), "surface.level=plain")
    assert "level" in json.dumps(schema("ball"))


def test_levels_over_a_seam_are_those_of_the_closed_record(tmp_path: Path) -> None:
    given = scene(tmp_path, gaussian(200, 80))
    energy = 1e-9 * (1 + 0.3 * np.random.default_rng(0).standard_normal(200))
    plain = sound_of_release(given, energy, given.step, True, 200)
    seamed = sound_of_release(given, energy, given.step, True, 200, has_seam=True)
    assert (plain.loops, seamed.loops, seamed.closed) == (True, False, True)
    assert np.array_equal(plain.pressure, seamed.pressure) and plain.levels == seamed.levels
    assert (plain.ends, seamed.ends) == ("loops", "does not loop, the surface has a seam")


# ---- Resolution


@pytest.mark.parametrize("law", sorted(AUTOCORRELATIONS))
def test_correlation_length_is_that_of_the_law(law: str) -> None:
    """exp(-d (r/L)^k) falls to 1/e at L d^(-1/k).

    About 5,000 correlation areas leave 2 %, and the chord of the interpolation adds to it.
    """
    decay, exponent = AUTOCORRELATIONS[law]
    heights = gaussian_heights.gaussian(
        (1500, 400), SPACING, 1e-7, (8 * SPACING, 5 * SPACING), law, 1
    )
    for axis, length in ((0, 8 * SPACING), (1, 5 * SPACING)):
        got = surface.correlation(heights, SPACING, axis)
        assert got.length == pytest.approx(length * decay ** (-1 / exponent), rel=0.08)
        # A straight line through lags 1 and 2 meets lag 0 below 1 by (1 - exp(-d/L))^2 with an
        # exponential law.
        cusp = (1 - np.exp(-decay * SPACING / length)) ** 2 if exponent == 1 else 0.0
        assert got.noise == pytest.approx(cusp, abs=0.02)


def test_white_noise_and_flat_heights_have_no_correlation_length() -> None:
    white = np.random.default_rng(0).standard_normal((300, 200))
    got = surface.correlation(white, SPACING, 0)
    # From 1 to 0 in a straight line: 1/e at 1 - 1/e of a node. 240 columns times 300 rows: 0.4 %.
    assert got.length == pytest.approx((1 - np.exp(-1)) * SPACING, rel=0.02)
    assert got.noise == pytest.approx(1, abs=0.02)
    flat = surface.correlation(np.zeros((8, 8)), SPACING, 1)
    assert (flat.length, flat.noise) == (np.inf, 0.0)
    lay = surface.correlation(np.ones((20, 1)) * white[:1], SPACING, 0)
    assert (lay.length, lay.noise) == (np.inf, pytest.approx(0, abs=1e-12))


def pits(width: float) -> np.ndarray:
    rows = np.arange(200)[:, None]
    columns = np.arange(80)[None, :]
    rng = np.random.default_rng(0)
    heights = np.zeros((200, 80))
    for _ in range(8):
        r2 = (rows - rng.integers(20, 180)) ** 2 + (columns - rng.integers(20, 60)) ** 2
        heights -= 1e-6 * np.exp(-r2 / width**2)
    return heights


@pytest.mark.parametrize(
    ("fine", "coarse", "says"),
    [
        (gaussian(200, 80, 8), gaussian(200, 80, 3), "nodes per correlation length (5.9"),
        (pits(6.0), pits(2.0), "a finer measurement is needed, with a spacing of at most"),
        (
            gaussian(200, 80, 8),
            1e-7 * np.random.default_rng(0).standard_normal((200, 80)),
            "less than 1 node per correlation length",
        ),
        (
            gaussian(200, 80, 8),
            gaussian(200, 80, 8) + 0.05e-6 * np.random.default_rng(0).standard_normal((200, 80)),
            "% of the variance of the heights changes from each node to the next",
        ),
    ],
    ids=["random", "pits", "white noise", "noise on a fine surface"],
)
def test_files_too_coarse_are_warned(
    tmp_path: Path, fine: np.ndarray, coarse: np.ndarray, says: str
) -> None:
    assert found(tmp_path, fine)["correlation_nodes"].warning is None
    warning = found(tmp_path, coarse)["correlation_nodes"].warning
    assert warning is not None and says in warning
    assert "finer measurement" in warning
