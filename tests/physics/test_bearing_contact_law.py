"""A contact of a bearing bears Hertz's load at Hertz's approach plus its tracks, and stores it."""

from __future__ import annotations

import numpy as np
import pytest

from rolling.bearing._ring_kernels import MIN_SLOPE, add_track, close_law, contact_at

pytestmark = pytest.mark.kernel

COMPLIANCE = 2e-7  # [m/N^(2/3)]
LOADS = np.array([1.0, 8.0, 64.0])
NODES = np.append(0.0, LOADS ** (2 / 3))
TRACKS = {
    "none": np.zeros(3),
    "a bump that is pressed flat": np.array([-3e-7, -2e-7, -1.5e-7]),
    "a valley": np.full(3, 5e-7),
    "a softening one": np.array([0.0, 2e-7, 3e-7]),
}


def law_of(track: np.ndarray) -> np.ndarray:
    """Return the approach at the nodes."""
    law = np.append(0.0, track)
    close_law(COMPLIANCE, NODES, law)
    return law


@pytest.mark.parametrize("name", TRACKS)
def test_approach_is_hertz_and_track_at_the_loads_of_the_track(name: str) -> None:
    law = law_of(TRACKS[name])
    for load, change in zip(LOADS, TRACKS[name], strict=True):
        approach = COMPLIANCE * load ** (2 / 3) + change
        assert contact_at(approach, COMPLIANCE, NODES, law)[0] == pytest.approx(load, rel=1e-9)
    above = COMPLIANCE * 1000.0 ** (2 / 3) + TRACKS[name][-1]
    assert contact_at(above, COMPLIANCE, NODES, law)[0] == pytest.approx(1000.0, rel=1e-9)
    below = COMPLIANCE * 0.1 ** (2 / 3) + TRACKS[name][0]
    assert contact_at(below, COMPLIANCE, NODES, law)[0] == pytest.approx(0.1, rel=1e-9)
    assert contact_at(TRACKS[name][0] - 1e-9, COMPLIANCE, NODES, law) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("name", TRACKS)
def test_force_and_stiffness_are_derivatives_of_the_energy(name: str) -> None:
    """Differences over 1e-5 of the approach have errors of 1e-6 or less."""
    law = law_of(TRACKS[name])
    for load in (0.3, 3.0, 30.0, 300.0):
        approach = COMPLIANCE * load ** (2 / 3) + TRACKS[name][1]
        step = 1e-5 * approach
        low = contact_at(approach - step, COMPLIANCE, NODES, law)
        force, stiffness, _ = contact_at(approach, COMPLIANCE, NODES, law)
        high = contact_at(approach + step, COMPLIANCE, NODES, law)
        assert (high[2] - low[2]) / (2 * step) == pytest.approx(force, rel=1e-5)
        assert (high[0] - low[0]) / (2 * step) == pytest.approx(stiffness, rel=1e-5)


def test_force_rises_whatever_tracks_add_up_to() -> None:
    """A track that falls faster than Hertz rises is held at a minimum slope."""
    law = law_of(np.array([0.0, -9e-7, -9e-7]))
    least = MIN_SLOPE * COMPLIANCE * (NODES[2] - NODES[1])
    assert law[2] - law[1] == pytest.approx(least, rel=1e-12)
    forces = [
        contact_at(approach, COMPLIANCE, NODES, law)[0] for approach in np.linspace(0, 5e-6, 200)
    ]
    assert np.all(np.diff(forces)[1:] > 0)


def test_a_track_is_smooth_between_its_points_and_closed() -> None:
    """Cubics through 21 points a wave meet it to 2e-3, across the seam too."""
    angle = 2 * np.pi * np.arange(64) / 64
    track = np.stack((np.cos(3 * angle), 2 * np.sin(angle)), axis=1)
    for turns in (-3.004, -0.5, 0.0, 0.123, 0.999, 7.3):
        law = np.zeros(3)
        add_track(turns, 0.5, track, law)
        expected = 0.5 * np.cos(6 * np.pi * turns), np.sin(2 * np.pi * turns)
        np.testing.assert_allclose(law[1:], expected, atol=2e-3)
