"""The second lap over a periodic surface equals the first.

Positions past the end read the same heights and keep no memory.
"""

from __future__ import annotations

import numpy as np
import pytest
from helpers import make_track, releases, roll, rough


@pytest.mark.law("Second lap: over a periodic surface it equals the first.")
@pytest.mark.parametrize(("step_nodes", "lap"), [(1, 50), (2, 25), (0.5, 100)])
def test_second_lap_equals_the_first(step_nodes: float, lap: int) -> None:
    """Both laps agree to 1e-5 of the fluctuation at a tolerance of 1e-7 (measured 9e-7)."""
    track = make_track(
        rough(50, 60, 1e-7), load=0.1, hardness=2.1e9, step=step_nodes * 2e-6, tolerance=1e-7
    )
    signal = releases(track, roll(track, 0, 2 * lap))
    assert np.abs(signal[lap:] - signal[:lap]).max() < 1e-5 * signal.std()


@pytest.mark.law("Second lap: a plate that yields keeps no memory of the first.")
def test_capped_track_keeps_no_memory() -> None:
    """The first position of the thousandth lap meets the virgin surface.

    Half of the contact is plastic.
    """
    track = make_track(rough(50, 60, 1e-7), load=0.1, hardness=1.2e9, tolerance=1e-8)
    one = roll(track, 0, 0)[0]
    later = roll(track, 50 * 1000, 50 * 1000)[0]
    assert one.plastic_area > 0.3 * one.contact_area
    assert later.plastic_area == one.plastic_area
    np.testing.assert_allclose(later.pressure, one.pressure, rtol=0, atol=1e-6 * one.max_pressure)
