"""Memory of a march is used again, and no state of the march holds it."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import make_track, roll, rough, space_of

from rolling.contact.march import march
from rolling.contact.scratch import Scratch


def test_memory_by_name_grows_with_its_use() -> None:
    scratch = Scratch()
    small = scratch.array("gap", (4, 5))
    assert np.shares_memory(small, scratch.array("gap", (5, 4)))
    assert scratch.array("gap", (40, 50)).shape == (40, 50)
    assert scratch.array("places", (7,), np.uint32).dtype == np.uint32


@pytest.mark.parametrize("hardness", [np.inf, 2.1e9])
def test_a_state_that_is_kept_keeps_its_numbers(hardness: float) -> None:
    """Every third state is kept, and of every other one a row, while the march goes on."""
    track = make_track(rough(64, 64, 1e-7), load=0.1, hardness=hardness, tolerance=1e-4)
    expected = roll(track, 0, 20)
    kept = {}
    rows = {}
    for state in march(track, 0, 20, space_of(track)):
        if state.position % 3 == 0:
            kept[state.position] = state
        elif state.position % 2:
            rows[state.position] = state.deflection[3]
    for k, state in kept.items():
        assert np.array_equal(state.pressure, expected[k].pressure)
        assert np.array_equal(state.deflection, expected[k].deflection)
        assert (state.edge is None) == (expected[k].edge is None)
        assert state.edge is None or np.array_equal(state.edge, expected[k].edge)
    for k, row in rows.items():
        assert np.array_equal(row, expected[k].deflection[3])
