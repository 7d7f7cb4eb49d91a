"""A track beside the middle of a surface is the middle track of heights that move across."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from ball_scenes import small_ball
from checked import checked
from finished import VIBRATING, marched, same
from hard_cases.gaussian_heights import gaussian
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_text import PLAIN

from rolling.in_si.scene_surface import heights
from rolling.marches.piece import contact_identity
from rolling.scene.file import loads

PIT = "surface.faults=[{kind: pit, at_mm: [0.1, 0.02], size_um: 20, depth_um: 1}]"
KEY = "rolling.across_um"
EXACT_M = 2.0**-36  # a multiple of it has exact sums, in which order ever they are taken


@pytest.mark.slow
@pytest.mark.law("Track across: it is the middle track of heights that are moved across.")
@pytest.mark.parametrize("nodes", [1, -7])
def test_the_series_are_those_of_a_file_that_is_moved(tmp_path: Path, nodes: int) -> None:
    rough = gaussian((240, 80), 2e-6, 5e-8, (1e-5, 1e-5), "gaussian", 3)
    rough = np.round(rough / EXACT_M) * EXACT_M
    np.save(tmp_path / "here.npy", rough)
    np.save(tmp_path / "moved.npy", np.roll(rough, -nodes, axis=1))
    file = f"{{kind: file, path: {tmp_path}/here.npy, spacing_um: 2, level: none}}"
    across = marched(VIBRATING, [f"surface={file}", f"rolling.across_um={2 * nodes}"])
    moved = marched(VIBRATING, [f"surface={file.replace('here', 'moved')}"])
    middle = marched(VIBRATING, [f"surface={file}"])
    for name, values in across.series.items():
        assert name == "step_time" or same(values, moved.series[name])
    assert same(across.sound.pressure, moved.sound.pressure)
    assert across.wavelength_octaves == moved.wavelength_octaves
    assert not same(across.series["approach"], middle.series["approach"])


@settings(deadline=None, max_examples=50)
@given(st.integers(-(10**7), 10**7).map(lambda nm: nm * 1e-3))
def test_heights_and_faults_move_by_whole_nodes_round_the_width(across_um: float) -> None:
    scene = loads(PLAIN, [PIT])
    moved = scene.with_({"rolling.across_um": across_um})
    nodes = round(across_um * 1e-6 / scene.spacing)
    assert np.array_equal(heights(moved), np.roll(heights(scene), -nodes, axis=1))
    assert (contact_identity(moved) == contact_identity(scene)) == (nodes % 32 == 0)


def test_the_surface_of_a_sphere_does_not_move() -> None:
    ball = {"kind": "gaussian", "roughness_ra_um": 0.05, "correlation_length_um": 10, "seed": 1}
    scene = small_ball("rolling.across_um=10", **ball)
    assert np.array_equal(heights(scene), heights(scene.with_({"rolling.across_um": 0})))


def test_a_contact_on_the_edge_of_a_file_is_doubted(tmp_path: Path) -> None:
    """The contact reaches 20.1 um to either side, and the edge lies 80 um from the middle."""
    crop = gaussian((1000, 160), 2e-6, 1e-7, (1.2e-5, 1.2e-5), "gaussian", 3)[:200, :80]
    np.save(tmp_path / "heights.npy", crop)
    file = f"surface={{kind: file, path: {tmp_path}/heights.npy, spacing_um: 2}}"
    base = ["rolling.load_n=0.5", "rolling.duration_s=", file]
    rows = {
        across_um: {row.key: row for row in checked(loads(PLAIN, [*base, f"{KEY}={across_um}"]))}
        for across_um in (0, 58, 62, -62)
    }
    assert "seam_across" not in rows[0]
    assert rows[58]["seam_across"].warning is None
    warnings = [str(rows[across_um]["seam_across"].warning) for across_um in (62, -62)]
    for warning in warnings:
        assert "it lies 18 um from the edge" in warning
        assert "rolling.across_um of at most 59 either way" in warning
