"""Rolling back over the same track swaps loading and release.

An elastic contact has no memory and no direction.
"""

from __future__ import annotations

import numpy as np
import pytest
from helpers import make_track, roll, rough, step_energies


@pytest.mark.law(
    "Rolling back: over the same track it swaps loading and release of an elastic contact."
)
def test_rolling_back_swaps_loading_and_release() -> None:
    """Mirrored heights put the contact of position k at position -k.

    Each contact is known to the tolerance, 1e-9, and the energies of a step to about the
    tolerance times the stored energy.
    """
    heights = rough(60, 50, 1e-7)
    mirrored = np.roll(heights[::-1], 1, axis=0)
    there, back = (make_track(z, load=1.0, tolerance=1e-9) for z in (heights, mirrored))
    steps = 12
    forth = step_energies(there, roll(there, 3, 3 + steps))
    home = step_energies(back, roll(back, -3 - steps, -3))[::-1]
    largest = max(state.stored_energy for state in roll(there, 3, 3))
    for one, other in zip(forth, home, strict=True):
        assert abs(one.release - other.loading) < 1e-8 * largest
        assert abs(one.loading - other.release) < 1e-8 * largest
    # the swap is not of equals
    assert max(abs(one.release - one.loading) for one in forth) > 1e-3 * largest
