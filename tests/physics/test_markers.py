"""Marks of unmeasured or saturated points: suspected on spoiled scans, never on honest ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hard_cases.gaussian_heights import gaussian

from acoustics.arrays import Array
from rolling.check import findings
from rolling.in_si import scene_surface
from rolling.scene import file
from rolling.scene.messages import SceneError
from rolling.surface import markers

N = 128
X, Y = np.mgrid[:N, :N]
SCENE = """\
name: scan
sphere: {radius_mm: 5}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}
surface: {kind: file, path: %s, spacing_um: 2, height_unit: um}
rolling: {load_n: 0.2, speed_m_s: 0.1}
"""


def rough(length: float, seed: int = 1, nodes: int = N) -> Array:
    """Make Gaussian heights of Sq 1 and a correlation length in nodes."""
    z = gaussian((nodes, nodes), 1.0, 1.0, (length, length), "gaussian", seed)
    return np.asarray(z / z.std())


def levels(heights: Array, count: int) -> Array:
    """Digitize heights to a number of levels over their range."""
    return np.asarray(np.round((heights - heights.min()) / np.ptp(heights) * (count - 1)))


def tiled(height: float) -> Array:
    """Repeat a tile with one spike."""
    tile = rough(3.0, nodes=N // 4)
    tile[5, 7] = height
    return np.tile(tile, (4, 4))


DUST = rough(8.0)
DUST[np.random.default_rng(1).random(DUST.shape) < 1e-3] += 30
CONE = np.maximum.reduce(
    [np.maximum(0, 1 - np.hypot(X - i, Y - j) / 9) for i, j in ((20, 30), (90, 64), (64, 110))]
)
FINE = rough(0.5)
COARSE = rough(8.0)
HONEST: dict[str, Array] = {
    "rough": COARSE,
    "white": FINE,
    "plateau honed": np.minimum(COARSE, 0.1),
    "plateau of white noise": np.minimum(FINE, 0.0),
    "floor": np.maximum(FINE, -1.0),
    "step of two levels": np.where(X < 50, 0.0, 1.0) + 0 * Y,
    "rough step": np.where(X < 50, 0.0, 10.0) + COARSE,
    "three levels": (X // 16 % 3) * 1.0,
    "grooves of one depth": np.where(X % 40 < 2, -20.0, COARSE),
    "dimples of one depth": np.where((X % 32 < 8) & (Y % 32 < 8), -20.0, COARSE),
    "pillars on a smooth plate": np.where((X % 20 < 4) & (Y % 20 < 4), 2.0, 0.0),
    "smooth": np.zeros((N, N)),
    "cones on a smooth plate": CONE,
    "pits in a smooth plate": -CONE,
    "sine": np.sin(2 * np.pi * X / 32) * np.sin(2 * np.pi * Y / 32),
    "tiles with a spike": tiled(40.0),
    "crop of such tiles": tiled(40.0)[:120, 3:110],
    "ridges with a high one": np.tile(np.where(np.arange(N) == 50, 40.0, COARSE[0]), (N, 1)),
    "tilted": COARSE + X,
    "dust": DUST,
    "digitized dust": np.round(DUST, 1),
    "counts with gaps": np.where(np.random.default_rng(2).random((N, N)) < 0.1, np.nan, X // 9),
    "profile": COARSE[:, :1],
    "digitized profile": np.round(10 * COARSE[:1]),
} | {
    f"{count} levels of length {length}": levels(rough(length), count)
    for count in (2, 3, 4, 5, 8, 16, 64, 256, 4096, 65536)
    for length in (0.5, 3.0, 30.0)
}


@pytest.mark.parametrize("name", HONEST)
def test_no_honest_surface_is_suspected(name: str) -> None:
    assert markers.suspected(HONEST[name]) == ()


def spoiled(value: float, heights: Array = COARSE, share: float = 2e-3) -> Array:
    """Write a value into some nodes at random."""
    return np.where(np.random.default_rng(3).random(heights.shape) < share, value, heights)


BLOCK = np.zeros((N, N), bool)
BLOCK[50:60, 40:50] = True
UM = np.round(COARSE, 3)
SPOILED: dict[str, tuple[Array, set[float]]] = {
    "largest of 16 bits": (spoiled(32767), {32767}),
    "least of 16 bits": (spoiled(-32768), {-32768}),
    "largest without a sign": (spoiled(65535, 1000 + levels(COARSE, 900)), {65535}),
    "largest in metres": (spoiled(32767e-9, 1e-7 * COARSE), {32767e-9}),
    "saturated at both ends": (
        np.clip(np.round(14000 * COARSE), -32768, 32767), {32767, -32768}
    ),
    "-9999": (spoiled(-9999), {-9999}),
    "1e37": (spoiled(1e37), {1e37}),
    "of Surfer": (spoiled(1.70141e38), {1.70141e38}),
    "largest number of all": (spoiled(np.finfo(float).max), {np.finfo(float).max}),
    "one point": (np.where((X == 9) & (Y == 9), 1e37, COARSE), {1e37}),
    "zeros on an offset": (spoiled(0.0, UM + 12.3), {0.0}),
    "zeros on a tilt": (spoiled(0.0, UM + 20 + 0.5 * X), {0.0}),
    "zeros in a tilt": (spoiled(0.0, UM + 0.5 * X - 0.2 * Y), {0.0}),
    "block of zeros": (np.where(BLOCK, 0.0, UM + 12.3), {0.0}),
    "rows of zeros": (np.where(X > 120, 0.0, UM + 12.3), {0.0}),
    "round field": (np.where(np.hypot(X - 64, Y - 64) < 63, UM + 12.3, 0.0), {0.0}),
    "a third of zeros": (spoiled(0.0, UM + 12.3, 0.33), {0.0}),
    "zeros among 8 bits": (spoiled(0.0, np.round(128 + 10 * COARSE)), {0.0}),
    "no usual number": (spoiled(-47.0), {-47.0}),
    "three marks": (
        spoiled(0.0, spoiled(32767, np.where(BLOCK, -9999, UM + 40.0), 4e-3)), {0, 32767, -9999}
    ),
    "smooth": (spoiled(32767, np.zeros((N, N))), {32767}),
    "white": (spoiled(0.0, np.round(FINE, 3) + 40), {0.0}),
    "profile": (spoiled(-9999, COARSE[:1], 0.03), {-9999}),
}  # fmt: skip


@pytest.mark.parametrize("name", SPOILED)
@pytest.mark.filterwarnings("error")
def test_each_mark_is_suspected_by_its_value(name: str) -> None:
    heights, marks = SPOILED[name]
    suspects = markers.suspected(heights)
    assert marks <= {suspect.value for suspect in suspects}
    for suspect in suspects:
        assert suspect.count == np.count_nonzero(heights == suspect.value)


@pytest.mark.parametrize("mark", [32767.0, -9999.0, 1e37, 0.0])
@pytest.mark.parametrize("is_block", [False, True])
def test_the_way_out_leaves_the_heights_of_the_measured_points(
    tmp_path: Path, mark: float, is_block: bool
) -> None:
    """`check` and a refusal name the mark; outliers and fill restore the scan where it was.

    The heights of measured points differ by their mean only; filled ones lie within their range.
    """
    scan = np.round(0.1 * COARSE + 5.0, 4)
    marked = BLOCK if is_block else np.random.default_rng(3).random((N, N)) < 2e-3
    np.savetxt(tmp_path / "h.csv", np.where(marked, mark, scan), delimiter=",")
    scene = file.loads(SCENE % "h.csv", folder=tmp_path)
    try:
        text = "".join(scene_surface.scene_surface(scene).suspicions)
    except SceneError as error:
        text = str(error)
    assert f"exactly {mark:.10g} um" in text and "surface.outliers" in text
    mended = scene.with_(outliers=6, unmeasured="fill")
    surface = scene_surface.scene_surface(mended)
    assert surface.suspicions == ()
    offset = surface.heights - 1e-6 * scan
    assert np.ptp(offset[~marked]) < 1e-18
    filled = surface.heights[marked] - offset[~marked].mean()
    assert 1e-6 * scan.min() <= filled.min() and filled.max() <= 1e-6 * scan.max()


@pytest.mark.parametrize("mark", [32767.0, 1e37, np.nan])
def test_marks_of_a_sphere_are_named_without_a_key_of_the_plate(
    tmp_path: Path, mark: float
) -> None:
    """A turn of a sphere has no key that fills points, in a warning and in a refusal."""
    turn = 0.01 * np.random.default_rng(1).standard_normal(628)
    turn[[10, 200, 400]] = mark
    np.savetxt(tmp_path / "turn.csv", turn)
    text = """\
name: scan
sphere: {radius_mm: 0.2, surface: {kind: file, path: turn.csv, spacing_um: 2, height_unit: nm}}
plate: {youngs_modulus_gpa: 210, poissons_ratio: 0.3}
surface: {kind: smooth, spacing_um: 2, width_um: 64}
rolling: {load_n: 0.001, speed_m_s: 0.1, duration_s: 0.001}
"""
    try:
        words = str(findings.check_scene(file.loads(text, folder=tmp_path), solve=False).warnings)
    except SceneError as error:
        words = str(error)
    assert "in the file" in words and "unmeasured fill" not in words
    assert np.isnan(mark) or f"3 of 628 heights are exactly {mark:.10g} nm" in words
