"""A march under a load at each position carries that load, is optimal, and keeps its energy."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.recovery import step_energy
from rolling.contact.state import RollingContact


@pytest.mark.law("Moving load: each state of a march carries the load of its position.")
@pytest.mark.parametrize("hardness", [np.inf, 2.1e9])
def test_each_state_carries_its_load(hardness: float) -> None:
    rng = np.random.default_rng(2)
    contact = RollingContact(
        heights=2e-8 * rng.standard_normal((96, 96)),
        spacing=2e-6,
        radius=5e-3,
        contact_modulus=230e9,
        hardness=hardness,
        load=0.5,
        step=2e-6,
        start=0.0,
        tolerance=1e-5,
        blended=True,
    )
    loads = 0.5 * (1 + 0.4 * np.sin(np.arange(97) * 2 * np.pi / 12))
    loads[-1] = loads[0]
    half_space = HalfSpace(contact.spacing, contact.contact_modulus)
    states = list(march(replace(contact, loads=loads), 90, 102, half_space))
    for state in states:
        load = loads[state.position % 96]
        assert state.pressure.sum() * contact.spacing**2 == pytest.approx(load, rel=1e-9)
        assert state.residual < 1e-4
    assert (states[0].plastic_area > 0) == np.isfinite(hardness)
    largest = max(state.stored_energy for state in states)
    for old, new in pairwise(states):
        step = step_energy(old, new, half_space)
        # The load works on the surface: loading and release differ by the stored energy alone.
        assert step.release + step.loading > 0 and abs(step.defect) < 1e-12 * largest
    # The same load at each position is no other march.
    constant = list(march(replace(contact, loads=np.full(97, 0.5)), 0, 3, half_space))
    plain = list(march(contact, 0, 3, half_space))
    assert [state.approach for state in constant] == [state.approach for state in plain]
