"""The stored energy changes by loading minus release.

This is an identity of reciprocity with the mean rule, at any step, with and without yielding.
"""

from __future__ import annotations

import numpy as np
import pytest
from helpers import STEEL, gap_and_deflection, make_track, roll, rough, step_energies

HARDNESS = {"elastic": np.inf, "capped": 2.1e9}


@pytest.mark.law(
    "Energy ledger: the stored energy changes by loading minus release, at any step, with and "
    "without yield."
)
@pytest.mark.parametrize("step_nodes", [0.5, 1, 3, 40])
@pytest.mark.parametrize("plate", HARDNESS)
def test_ledger_closes_to_rounding(plate: str, step_nodes: float) -> None:
    """The ledger closes at a loose tolerance and at steps longer than the contact.

    The steps are 40 nodes, 80 um, at a = 43 um. Measured 1e-15 to 5e-15.
    """
    heights = rough(150, 120, 1e-7)
    track = make_track(heights, hardness=HARDNESS[plate], step=step_nodes * 2e-6, tolerance=1e-3)
    states = roll(track, 0, 6)
    assert (states[0].plastic_area > 0) == (plate == "capped")
    largest = max(state.stored_energy for state in states)
    assert max(abs(step.defect) for step in step_energies(track, states)) < 1e-12 * largest


@pytest.mark.law("Energy ledger: the stored energy is the sum of p u dA / 2.")
@pytest.mark.parametrize("plate", HARDNESS)
def test_stored_energy_is_half_pressure_times_deflection(plate: str) -> None:
    """An independent convolution gives the stored energy to the rounding of both."""
    track = make_track(rough(90, 90, 1e-7), hardness=HARDNESS[plate], load=1.0, tolerance=1e-5)
    for state in roll(track, 0, 2):
        _, u, p = gap_and_deflection(track, state)
        assert state.stored_energy == pytest.approx(
            0.5 * np.vdot(p, u) * track.spacing**2, rel=1e-12
        )


@pytest.mark.law("Energy ledger: the left-end rule does not close it.")
@pytest.mark.parametrize("plate", HARDNESS)
def test_left_end_rule_does_not_close(plate: str) -> None:
    """The left-end rule leaves 1e-3 of the stored energy at step / a = 1 / 21, at first order."""
    track = make_track(rough(150, 120, 1e-7), hardness=HARDNESS[plate], tolerance=1e-6)
    states = roll(track, 0, 4)
    largest = max(state.stored_energy for state in states)
    defects = [abs(step.defect) for step in step_energies(track, states, left_end=True)]
    assert min(defects) > 1e-4 * largest


@pytest.mark.law("Energy ledger: it closes when contact jumps to another place.")
def test_nothing_released_is_lost_when_contact_jumps() -> None:
    """The release has all energy of a spike that loses contact within a step.

    Two spikes 60 um apart stand on a smooth plate under a light sphere. Contact leaves the left
    spike for the right one. The stored energy p u / 2 of the left one must be in the release:
    the mean of p and 0, times u.
    """
    heights = np.zeros((80, 41))
    heights[[0, 30], 20] = 2e-6
    track = make_track(heights, load=1e-3, step=60e-6, tolerance=1e-6)
    states = roll(track, 0, 1)
    assert [state.contact_area for state in states] == [4e-12, 4e-12]
    assert states[0].loaded.row == 0 and states[1].loaded.row == 30
    step = step_energies(track, states)[0]
    # One square of pressure p deflects its own centre by 4 ln(1 + sqrt 2) spacing p / (pi E*).
    alone = 4 * np.log(1 + np.sqrt(2)) * (1e-3) ** 2 / (2e-6 * np.pi * STEEL) / 2
    far = 1e-3**2 / (60e-6 * np.pi * STEEL) / 2  # what the new load presses on the old node: 1 / r
    assert step.release == pytest.approx(alone - far, rel=1e-5)
    assert step.loading == pytest.approx(alone - far, rel=1e-5)
