"""The contact scales with stiffness and load, and moves with its surface.

The tangential force does no work over a lap.
"""

from __future__ import annotations

import numpy as np
import pytest
from helpers import make_track, releases, roll, rough

HEIGHTS = rough(60, 60, 1e-7)
HARDNESS = {"elastic": np.inf, "capped": 2.1e9}
LOAD = 0.1


@pytest.mark.law("Scaling: E, H and W times c leave the deflection and multiply the release by c.")
@pytest.mark.parametrize("factor", [4.0, 1e-6, 3.7])
@pytest.mark.parametrize("plate", HARDNESS)
def test_modulus_hardness_and_load_times_c(plate: str, factor: float) -> None:
    """Deflections stay and energies follow c; only rounding differs (measured 6e-15).

    Rounding may flip a branch on another machine, so the order of the tolerance, 1e-8, is
    allowed.
    """
    base = make_track(HEIGHTS, load=LOAD, hardness=HARDNESS[plate])
    scaled = make_track(
        HEIGHTS,
        load=LOAD * factor,
        hardness=HARDNESS[plate] * factor,
        contact_modulus=base.contact_modulus * factor,
    )
    one = roll(base, 0, 4)
    other = roll(scaled, 0, 4)
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(
            b.deflection, a.deflection, rtol=0, atol=1e-8 * a.deflection.max()
        )
        assert (a.plastic_area > 0) == (plate == "capped")
    np.testing.assert_allclose(releases(scaled, other), factor * releases(base, one), rtol=1e-7)


@pytest.mark.law("Translation: a surface moved by n nodes moves the release by n steps.")
@pytest.mark.parametrize("nodes", [1, 17, 59])
def test_surface_moved_along_moves_the_signal(nodes: int) -> None:
    """Position k over heights moved by n nodes is position k - n, across the seam too.

    The measured difference is 6e-15.
    """
    track = make_track(HEIGHTS, load=LOAD, hardness=2.1e9)
    moved = make_track(np.roll(HEIGHTS, nodes, axis=0), load=LOAD, hardness=2.1e9)
    signal = releases(track, roll(track, 0, 6))
    np.testing.assert_allclose(releases(moved, roll(moved, nodes, nodes + 6)), signal, rtol=1e-7)


@pytest.mark.law("Mirror: a surface mirrored across the track gives the same release.")
def test_surface_mirrored_across_changes_nothing() -> None:
    """Mirrored heights are the same contact, since the sphere runs at mid-width.

    Mid-width is (n - 1) / 2 nodes. Measured 4e-15.
    """
    track, mirrored = (
        make_track(z, load=LOAD, hardness=2.1e9) for z in (HEIGHTS, HEIGHTS[:, ::-1].copy())
    )
    np.testing.assert_allclose(
        releases(mirrored, roll(mirrored, 0, 4)), releases(track, roll(track, 0, 4)), rtol=1e-7
    )


def tangential(track, states) -> np.ndarray:
    forces = []
    for state in states:
        x = (state.window.row + np.arange(state.window.rows)) * track.spacing - track.position(
            state.position
        )
        forces.append(state.pressure.sum(axis=1) @ x * track.spacing**2 / track.radius)
    return np.array(forces)


@pytest.mark.law("Tangential force: sum(p (x - x_c)) dA / R has zero mean over a closed lap.")
@pytest.mark.parametrize("plate", HARDNESS)
@pytest.mark.parametrize("step_nodes", [12, 3, 1])
def test_tangential_force_has_zero_mean_over_a_lap(plate: str, step_nodes: int) -> None:
    """The integral of the force over a closed lap is zero, with and without yielding.

    The force is the slope of the minimum energy along the track. The remaining mean is the
    error of the sum for the integral, not of the solver. The optimality bracket, summed over a
    lap, bounds it rigorously by step W / (2 R). At steps of a node it measured 1e-4 of the rms
    and 1e-3 of that bound.
    """
    track = make_track(
        HEIGHTS, load=LOAD, hardness=HARDNESS[plate], step=step_nodes * 2e-6, tolerance=1e-6
    )
    force = tangential(track, roll(track, 0, len(HEIGHTS) // step_nodes - 1))
    assert force.std() > 1e-4 * LOAD
    assert abs(force.mean()) <= track.step * LOAD / (2 * track.radius)
    if step_nodes == 1:
        assert abs(force.mean()) < 5e-4 * force.std()
