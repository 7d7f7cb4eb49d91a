"""A solved contact is a minimum of F = (p.u / 2 + e.p) dA.

Either pressure brackets the change of F on the change of e.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from helpers import gap_and_deflection, make_track, roll, rough


@pytest.mark.law(
    "Optimality: p2.(e2 - e1) dA <= F2 - F1 <= p1.(e2 - e1) dA between any two positions, with F = "
    "sum((p u / 2 + e p) dA)."
)
@pytest.mark.parametrize("hardness", [np.inf, 2.1e9], ids=["elastic", "capped"])
def test_energy_between_positions_is_bracketed(hardness: float) -> None:
    """p2.(e2 - e1) dA <= F2 - F1 <= p1.(e2 - e1) dA holds on a common window.

    p1 is feasible at position 2, and p2 at position 1. The excess of F at a tolerance eps is
    within eps u_max W. At neighbouring positions the bracket is far wider than that.
    """
    track = make_track(rough(96, 80, 3e-7), hardness=hardness, load=5.0, tolerance=1e-7)
    states = [roll(track, k, k)[0] for k in (0, 1, 2, 5, 12, 30)]
    cell = track.spacing**2
    widths = []
    for one, two in combinations(states, 2):
        e1, u1, p1 = gap_and_deflection(track, one)
        e2, u2, p2 = gap_and_deflection(track, two)
        # e at the other position on the nodes of this one; pressures vanish off their own window.
        e2_on_p1 = track.gap(two.position, one.window)
        e1_on_p2 = track.gap(one.position, two.window)
        change = (
            np.vdot(p2, u2) / 2 + np.vdot(e2, p2) - np.vdot(p1, u1) / 2 - np.vdot(e1, p1)
        ) * cell
        lower = np.vdot(p2, e2 - e1_on_p2) * cell
        upper = np.vdot(p1, e2_on_p1 - e1) * cell
        slack = track.tolerance * u1.max() * track.load
        assert lower - slack <= change <= upper + slack
        widths.append((upper - lower) / slack)
    assert min(widths) > 100  # otherwise the slack would decide


@pytest.mark.law("Optimality: a wrong pressure breaks the bracket.")
def test_a_wrong_pressure_breaks_the_bracket() -> None:
    """A smooth contact under a displaced sphere breaks the upper bound."""
    track = make_track(np.zeros((96, 80)), tolerance=1e-7)
    state, following = roll(track, 0, 1)
    e1, u1, p1 = gap_and_deflection(track, state)
    e2 = track.gap(1, state.window)
    p2 = np.roll(following.window.moved(following.pressure, state.window), 3, axis=0)
    u2 = np.roll(following.window.moved(following.deflection, state.window), 3, axis=0)
    change = np.vdot(p2, u2) / 2 + np.vdot(e2, p2) - np.vdot(p1, u1) / 2 - np.vdot(e1, p1)
    assert change > np.vdot(p1, e2 - e1)
