"""The warm start saves iterations and leaves no trace beyond the tolerance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers import assert_solved, make_track, releases, roll, rough


@pytest.mark.law("Warm equals cold: the warm start leaves no trace beyond the tolerance.")
@pytest.mark.parametrize("hardness", [np.inf, 2.1e9], ids=["elastic", "capped"])
@pytest.mark.parametrize("step_nodes", [0.5, 1, 5])
def test_warm_equals_cold(hardness: float, step_nodes: float) -> None:
    """The minimum is unique, so deflections agree to a few tolerances of 1e-7.

    The condition is on gaps within the contact, and the rest of u follows the pressures.
    Measured below 0.9 tolerances.
    """
    track = make_track(
        rough(60, 60, 2e-7), load=0.5, hardness=hardness, step=step_nodes * 2e-6, tolerance=1e-7
    )
    warm = roll(track, 0, 8)
    for state in warm[1::3]:
        cold = roll(track, state.position, state.position)[0]
        shared = cold.window.moved(cold.deflection, state.loaded)
        mine = state.window.moved(state.deflection, state.loaded)
        assert np.abs(mine - shared).max() < 3 * track.tolerance * mine.max()
        assert state.approach == pytest.approx(cold.approach, abs=track.tolerance * mine.max())
        assert_solved(track, state)
        assert_solved(track, cold)


def test_warm_start_saves_iterations() -> None:
    """At a tolerance of 1e-4 and steps of a node, 7.3 iterations measured against 10.5 cold."""
    track = make_track(rough(100, 100, 1e-7), load=2.0, tolerance=1e-4)
    warm = np.mean([state.iterations for state in roll(track, 0, 10)[1:]])
    cold = np.mean([roll(track, k, k)[0].iterations for k in range(1, 11)])
    assert warm < 0.9 * cold


@pytest.mark.law("Warm equals cold: a track that is solved in pieces has the release of the whole.")
@pytest.mark.parametrize("first", [1, 7, 20])
def test_pieces_agree_with_the_whole(first: int) -> None:
    """A march begun anywhere gives the same signal (5e-9 to 2e-8 measured at 1e-8)."""
    track = make_track(rough(60, 60, 2e-7), load=0.5, hardness=2.1e9)
    whole = releases(track, roll(track, 0, 26))
    piece = releases(track, roll(track, first, 26))
    assert np.abs(piece - whole[first:]).max() < 1e-6 * whole.std()


@pytest.mark.law("Tolerance: the error of the release falls with it.")
def test_release_error_falls_with_the_tolerance() -> None:
    """Two decades of tolerance are at least a decade of error, four at least three.

    The measured errors are 0.005, 1.1e-4 and 7.6e-7. A solve ends with a step that no convolution
    follows, which leaves less than a coarse tolerance asks for: at 1e-3 the error was 0.022 without
    it, at 1e-5 1.7e-4. So the rate of 1.5 decades per two is asked of four decades.
    """
    signals = {}
    for tolerance in (1e-10, 1e-7, 1e-5, 1e-3):
        track = make_track(rough(60, 60, 2e-7), load=0.5, tolerance=tolerance)
        signals[tolerance] = releases(track, roll(track, 0, 16))
    exact = signals.pop(1e-10)
    rms = {
        tolerance: np.sqrt(np.mean((signal - exact) ** 2)) / exact.std()
        for tolerance, signal in signals.items()
    }
    assert rms[1e-3] < 0.01
    assert rms[1e-5] < min(3e-4, rms[1e-3] / 10)
    assert rms[1e-7] < min(rms[1e-5] / 10, rms[1e-3] / 30**2)


def test_a_march_twice_is_the_same_to_the_bit() -> None:
    track = make_track(rough(60, 60, 2e-7), load=0.5, hardness=2.1e9, tolerance=1e-4)
    one = roll(track, 0, 5)
    other = roll(replace(track), 0, 5)
    assert all(np.array_equal(a.pressure, b.pressure) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize(("roughness", "most"), [(0.0, 1.5), (3e-9, 6.0), (1e-8, 5.8)])
def test_smooth_plates_take_few_convolutions(roughness: float, most: float) -> None:
    """Perfectly smooth plates start from pressures that move along, others by extrapolation.

    Measured 1.0, 5.3 and 5.0; starts that move along take 1.0, 6.8 and 6.4.
    """
    heights = rough(100, 100, roughness) if roughness else np.zeros((100, 100))
    states = roll(make_track(heights, load=2.0, tolerance=1e-4), 0, 14)[3:]
    counts = [state.convolutions for state in states]
    assert np.mean(counts) <= most, counts
