"""The article's method, a dense matrix with an active set, agrees with the FFT path."""

from __future__ import annotations

import numpy as np
import pytest
from hard_cases.dense import dense_contact
from helpers import STEEL, assert_solved, make_track, roll, rough

from rolling.contact import closed_forms
from rolling.contact.state import Window


@pytest.mark.law(
    "Dense method: an influence matrix with an active set gives the same pressure as the FFT path."
)
@pytest.mark.parametrize(
    "hardness", [np.inf, 1.6e9, 0.9e9], ids=["elastic", "capped", "mostly capped"]
)
@pytest.mark.parametrize("shape", [(30, 24), (25, 31)])
def test_fft_path_equals_the_dense_method(shape: tuple[int, int], hardness: float) -> None:
    """Both methods agree within their errors.

    A direct solve is exact to the condition of the matrix (1e-13 here), and the march to its
    tolerance, 1e-9 of the deflection. Pressures are less exact by the stiffness of single
    nodes, about a / spacing = 6: measured 5e-11 to 3e-9 of the peak.
    """
    track = make_track(rough(*shape, 3e-8, seed=3), load=0.1, hardness=hardness, tolerance=1e-9)
    for state in roll(track, 5, 7):
        assert_solved(track, state)  # nothing outside the block that the dense method is given
        w = state.loaded
        block = Window(w.row - 4, w.column - 3, w.rows + 8, w.columns + 6)
        e = track.gap(state.position, block)
        mine = state.window.moved(state.pressure, block)
        pressure, approach = dense_contact(e, track.load, track.spacing, STEEL, hardness)
        peak = pressure.max()
        assert (peak == hardness) == (hardness < np.inf)
        assert np.abs(mine - pressure).max() < 2e-8 * peak
        assert state.approach == pytest.approx(approach, abs=2e-9 * state.deflection.max())
        np.testing.assert_array_equal(mine >= hardness, pressure >= hardness)
        np.testing.assert_array_equal(mine > 0, pressure > 0)


@pytest.mark.law("Dense method: the influence matrix meets Hertz.")
def test_dense_method_meets_hertz() -> None:
    """The reference is 0.2 % below Hertz at a / spacing = 4.3, as measured."""
    spacing = 10e-6
    load = 5.0
    x = (np.arange(15) - 7) * spacing
    _, approach = dense_contact((x[:, None] ** 2 + x**2) / 0.01, load, spacing, STEEL)
    assert approach == pytest.approx(closed_forms.hertz_approach(load, 5e-3, STEEL), rel=0.005)
