"""The short version of benchmarks/grid_error.py: what the quickstart's spacing of 2 um leaves, against 1 um."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from rolling import surface

sys.path.insert(0, str(Path(__file__).parent / "benchmarks"))
from grid_error import STEP, levels, refined, release, signal_error_db

STEPS = 120


@pytest.fixture(scope="module")
def heights() -> np.ndarray:
    return surface.gaussian((STEPS, 128), STEP, 1e-7, (10e-6, 10e-6), "gaussian", 1)


def test_refining_keeps_the_nodes(heights: np.ndarray) -> None:
    fine = refined(heights, 3)  # an odd refinement moves the surface by whole fine nodes: every third one is an old one
    assert np.allclose(np.roll(fine, -1, axis=1)[::3, ::3], heights, atol=1e-13 * np.abs(heights).max())


@pytest.mark.parametrize(("hardness", "most_db"), [(np.inf, -20.0), (2.1e9, -8.0)])
def test_level_is_converged_where_the_signal_is_not(heights: np.ndarray, hardness: float, most_db: float) -> None:
    """Elastic -25 dB, capped -13 dB against 0.5 um in the long version; the level moves by 0.02 dB there, here the lap is short."""
    coarse, fine = (release(heights, times, hardness, STEPS) for times in (1, 2))
    assert signal_error_db(coarse, fine) < most_db
    assert levels(coarse).laeq_db == pytest.approx(levels(fine).laeq_db, abs=0.2)
    assert coarse.mean() == pytest.approx(fine.mean(), rel=5e-3)
