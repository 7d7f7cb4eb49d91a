"""Tracks add, and lie on straight lines over s = Q^(2/3) between their loads."""

from __future__ import annotations

import numpy as np
import pytest
from bearings import bearing

from rolling.bearing.tracks import BodyTrack, smooth_tracks, wave_track, with_waves


def test_a_track_is_linear_in_s_between_its_loads_and_constant_beyond() -> None:
    track = BodyTrack(loads_n=np.array([8.0, 64.0]), approach_m=np.array([[1.0, 2.0], [3.0, 8.0]]))
    between = (4.0 + 16.0) / 2  # of s = 4 and 16
    loads = np.array([1.0, 8.0, between**1.5, 64.0, 1000.0])
    expected = [[1.0, 2.0], [1.0, 2.0], [2.0, 5.0], [3.0, 8.0], [3.0, 8.0]]
    np.testing.assert_allclose(track.at_loads(loads), expected, rtol=1e-12)


def test_tracks_add_at_all_loads_of_both() -> None:
    rough = BodyTrack(loads_n=np.array([1.0, 8.0]), approach_m=np.ones((2, 16)) * [[1e-9], [3e-9]])
    waves = wave_track({3: (2e-9, 0.5)})
    both = rough.plus(waves)
    angle = 2 * np.pi * np.arange(both.points) / both.points
    expected = [1e-9, 3e-9] - 2e-9 * np.cos(3 * angle + 0.5)[:, None]
    np.testing.assert_allclose(both.at_loads(np.array([1.0, 8.0])).T, expected, atol=1e-20)


def test_waves_of_a_ball_are_on_both_raceways_and_on_no_other_ball() -> None:
    tracks = with_waves(smooth_tracks(bearing()), balls={2: {4: 1e-9}})
    assert tracks.balls_on_inner[2].approach_m.min() == pytest.approx(-1e-9)
    np.testing.assert_array_equal(
        tracks.balls_on_inner[2].approach_m, tracks.balls_on_outer[2].approach_m
    )
    assert not tracks.balls_on_inner[1].approach_m.any()
    assert not tracks.inner.approach_m.any()


@pytest.mark.parametrize(
    ("loads", "shape", "message"),
    [([2.0, 1.0], (2, 8), "ascending"), ([0.0], (1, 8), "positive"), ([1.0], (2, 8), "a row")],
)
def test_bad_tracks_are_refused(loads: list[float], shape: tuple[int, int], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        BodyTrack(loads_n=np.array(loads), approach_m=np.zeros(shape))
