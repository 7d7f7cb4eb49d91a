"""The compiled functions hold on contacts of a few nodes.

They run there uncompiled as well: NUMBA_DISABLE_JIT=1, -m kernel.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers import assert_solved, make_track, releases, roll, rough, step_energies

from rolling.contact import recovery

pytestmark = pytest.mark.kernel

KINDS = {
    "elastic": {},
    "capped": {"hardness": 2.1e9},
    "blended": {"hardness": 2.1e9, "blended": True},
    "everything plastic": {"hardness": 2e8},
}


def small(kind: str, **changes: float):
    """Return a track of 24 nodes with a contact of a few tens of them."""
    return make_track(
        rough(24, 24, 5e-8), **{"load": 0.02, "tolerance": 1e-7} | KINDS[kind] | changes
    )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("step_nodes", [0.5, 1])
def test_small_contacts_hold_the_conditions_and_the_ledger(kind: str, step_nodes: float) -> None:
    """The ledger closes to rounding, 1e-12.

    Steps of half a node start the next solve in another way.
    """
    track = small(kind, step=step_nodes * 2e-6)
    states = roll(track, 0, 3)
    for state in states:
        assert_solved(track, state)
    stored = np.array([state.stored_energy for state in states])
    steps = step_energies(track, states)
    change = np.array([step.loading - step.release for step in steps])
    np.testing.assert_allclose(np.diff(stored), change, rtol=0, atol=1e-12 * stored.max())


@pytest.mark.parametrize("kind", ["elastic", "capped"])
def test_events_of_a_small_contact_add_up(kind: str) -> None:
    track = small(kind)
    states = roll(track, 0, 5)
    table = recovery.EventTable(track.heights.shape)
    for state, step in zip(states, step_energies(track, states), strict=False):
        table.add(state.position, step)
    assert table.columns()["energy"].sum() == pytest.approx(
        releases(track, states).sum(), rel=1e-12
    )


def test_a_small_contact_does_not_depend_on_where_it_came_from() -> None:
    """The last of three positions, marched and solved alone, agrees with a tighter solve."""
    track = small("capped")
    marched = roll(track, 0, 2)[-1]
    alone = roll(track, 2, 2)[0]
    tight = replace(track, tolerance=1e-9)
    finer = roll(tight, 2, 2)[0]
    for state in (marched, alone):
        assert abs(state.approach - finer.approach) < 1e-4 * finer.deflection.max()
        assert state.stored_energy == pytest.approx(finer.stored_energy, rel=1e-4)
