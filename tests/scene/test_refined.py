"""Patches of a surface on finer and coarser grids."""

import numpy as np
import pytest

from rolling.surface.heights import gaussian
from rolling.surface.refined import coarsened_patch, refined, refined_patch


@pytest.fixture(scope="module")
def heights() -> np.ndarray:
    return gaussian((90, 70), 2e-6, 1e-7, (1e-5, 1e-5), "gaussian", 1)


@pytest.mark.parametrize(("first", "rows"), [(0, 90), (20, 30), (80, 30), (-7, 12)])
def test_a_refined_patch_is_a_part_of_the_refined_surface(
    heights: np.ndarray, first: int, rows: int
) -> None:
    rows_of_whole = np.arange(2 * first, 2 * (first + rows)) % (2 * len(heights))
    expected = refined(heights, 2)[rows_of_whole]
    assert refined_patch(heights, first, rows) == pytest.approx(expected, abs=1e-16)


@pytest.mark.parametrize("across", [64, 65])
def test_a_coarsened_patch_keeps_the_line_of_the_sphere(across: int) -> None:
    """A ridge along the track in the middle of the width stays in the middle."""
    y = np.arange(across) - (across - 1) / 2
    ridge = np.tile(np.exp(-((y / 6) ** 2)), (32, 1))
    coarse = coarsened_patch(ridge, 4, 16)
    assert coarse.shape == (8, across // 2)
    y = 2 * (np.arange(across // 2) - (across // 2 - 1) / 2)
    assert coarse[3] == pytest.approx(np.exp(-((y / 6) ** 2)), abs=1e-6)


def test_a_coarsened_patch_holds_every_second_row(heights: np.ndarray) -> None:
    whole = coarsened_patch(heights, 0, 90)
    assert coarsened_patch(heights, 10, 8) == pytest.approx(whole[5:9], abs=1e-20)
