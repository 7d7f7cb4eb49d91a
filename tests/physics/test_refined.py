"""Patches of a surface on finer and coarser cells and on their sub-cells."""

import numpy as np
import pytest
from hard_cases.gaussian_heights import gaussian

from rolling.surface.refined import cells_of_patch, refined, subcell_heights


@pytest.fixture(scope="module")
def heights() -> np.ndarray:
    return gaussian((90, 70), 2e-6, 1e-7, (1e-5, 1e-5), "gaussian", 1)


PATCHES = [(0, 90), (20, 30), (80, 30), (-7, 12)]


def rows_of(whole: np.ndarray, first: int, rows: int, times: int) -> np.ndarray:
    return whole[np.arange(times * first, times * (first + rows)) % len(whole)]


@pytest.mark.parametrize(("first", "rows"), PATCHES)
def test_a_refined_patch_is_a_part_of_the_refined_surface(
    heights: np.ndarray, first: int, rows: int
) -> None:
    patch = cells_of_patch(heights, first, rows, 0.5, 1, True)
    assert patch == pytest.approx(rows_of(refined(heights, 2), first, rows, 2), abs=1e-16)


@pytest.mark.parametrize("smooth", [True, False])
@pytest.mark.parametrize("side", [1.0, 0.5])
@pytest.mark.parametrize(("first", "rows"), PATCHES)
def test_sub_cells_of_a_patch_are_a_part_of_the_surface(
    heights: np.ndarray, first: int, rows: int, side: float, smooth: bool
) -> None:
    cells = heights
    if side < 1:
        cells = refined(heights, 2) if smooth else subcell_heights(heights, 2, False)
    times = round(2 / side)
    expected = rows_of(subcell_heights(cells, 2, smooth), first, rows, times)
    patch = cells_of_patch(heights, first, rows, side, 2, smooth)
    assert patch == pytest.approx(expected, abs=1e-15)


def test_a_patch_of_whole_cells_holds_the_heights_themselves(heights: np.ndarray) -> None:
    for smooth in (True, False):
        patch = cells_of_patch(heights, -7, 12, 1.0, 1, smooth)
        assert np.array_equal(patch, rows_of(heights, -7, 12, 1))


@pytest.mark.parametrize("subcells", [1, 2, 4])
@pytest.mark.parametrize("across", [64, 65])
def test_a_coarsened_patch_keeps_the_line_of_the_sphere(across: int, subcells: int) -> None:
    """A ridge along the track in the middle of the width stays in the middle."""
    y = np.arange(across) - (across - 1) / 2
    ridge = np.tile(np.exp(-((y / 6) ** 2)), (32, 1))
    coarse = cells_of_patch(ridge, 4, 16, 2.0, subcells, True)
    width = across // 2 * subcells
    assert coarse.shape == (8 * subcells, width)
    y = 2 / subcells * (np.arange(width) - (width - 1) / 2)
    assert coarse[3] == pytest.approx(np.exp(-((y / 6) ** 2)), abs=1e-6)


def test_a_coarsened_patch_holds_every_second_row(heights: np.ndarray) -> None:
    whole = cells_of_patch(heights, 0, 90, 2.0, 1, True)
    patch = cells_of_patch(heights, 10, 8, 2.0, 1, True)
    assert patch == pytest.approx(whole[5:9], abs=1e-20)


def test_coarse_flat_cells_hold_the_mean_of_their_parts(heights: np.ndarray) -> None:
    patch = cells_of_patch(heights, 10, 8, 2.0, 2, False)
    assert patch.shape == (8, 70)
    assert patch[2, 4] == patch[3, 5] == pytest.approx(heights[12:14, 4:6].mean())
