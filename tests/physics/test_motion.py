"""Distance and its inverse agree with the exact integral of the speed."""

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from rolling.contact.track import Motion


@st.composite
def motions(draw: st.DrawFn) -> Motion:
    n = draw(st.integers(1, 5))
    times = np.append(0.0, np.cumsum(draw(st.lists(st.floats(1e-3, 2.0), min_size=n, max_size=n))))
    # Speeds of zero are wanted, speeds of 1e-300 are not.
    speeds = draw(
        st.lists(st.one_of(st.just(0.0), st.floats(1e-3, 5.0)), min_size=n + 1, max_size=n + 1)
    )
    assume(any(speeds))
    return Motion(tuple(times.tolist()), tuple(speeds))


def test_constant_speed() -> None:
    motion = Motion.of(0.2)
    assert motion.is_constant(1.0)
    assert motion.distance([0.0, 3.0]) == pytest.approx([0.0, 0.6], rel=1e-15)
    assert motion.speed([0.0, 3.0]) == pytest.approx([0.2, 0.2])
    assert motion.time(0.6) == pytest.approx(3.0, rel=1e-15)
    assert motion.duration(0.6) == pytest.approx(3.0)
    assert motion.final_distance == np.inf


def test_accelerating_ball_by_hand() -> None:
    # 0 to 2 m/s in 4 s: 4 m; then 2 m/s.
    motion = Motion.of([(0, 0), (4, 2)])
    assert not motion.is_constant(1.0)
    assert motion.distance([2, 4, 6]) == pytest.approx([1, 4, 8], rel=1e-15)
    assert motion.time([1, 4, 8]) == pytest.approx([2, 4, 6], rel=1e-15)
    assert motion.speed([1, 5]) == pytest.approx([0.5, 2])
    assert (motion.slowest(5), motion.fastest(5)) == (0, 2)
    assert (motion.slowest(3), motion.fastest(3)) == (0, 1.5)


def test_equal_pairs_are_constant() -> None:
    assert Motion.of([[0, 0.1], [1, 0.1]]).is_constant(2.0)


def test_speeds_after_the_end_do_not_count() -> None:
    """A record of 20 ms at 0.1 m/s does not depend on 100 m/s at 20 s.

    It does not depend on it either when rounding ends the record a little later.
    """
    motion = Motion.of([(0, 0.1), (0.02, 0.1), (20, 100)])
    for duration in (0.02, motion.duration(0.002), 0.02 * (1 + 1e-14)):
        assert motion.is_constant(duration)
        assert motion.fastest(duration) == pytest.approx(0.1, rel=1e-9)
    assert not motion.is_constant(0.021)
    # 99.9 m/s in 19.98 s: 5 mm/s in a millisecond.
    assert motion.fastest(0.021) == pytest.approx(0.105)


@settings(deadline=None, max_examples=100)
@given(motions(), st.floats(1e-3, 8), st.floats(0, 6))
def test_time_below_a_speed_is_that_of_a_fine_count(
    motion: Motion, duration: float, speed: float
) -> None:
    """The count errs by a sample at each of at most 2 crossings in each of 6 stretches."""
    t = (np.arange(20000) + 0.5) * duration / 20000
    v = motion.speed(t)
    below = motion.time_below(speed, duration)
    assert below == pytest.approx(
        np.mean((v < speed) & (v > 0)) * duration, abs=20 * duration / 20000
    )
    assert (
        motion.slowest(duration) <= v.min() + 1e-12 and v.max() <= motion.fastest(duration) + 1e-12
    )


def test_a_rest_is_not_slow() -> None:
    # Nothing sounds at rest: of 3 s only the two seconds of braking and starting count, half of
    # each below 0.5 m/s.
    motion = Motion.of([(0, 1), (1, 0), (2, 0), (3, 1)])
    assert motion.time_below(0.5, 3) == pytest.approx(1.0)
    assert motion.time_below(2.0, 3) == pytest.approx(2.0)


def test_a_rest_in_between_is_reached_when_it_begins() -> None:
    motion = Motion.of([(0, 1), (1, 0), (2, 0), (3, 1)])
    assert motion.distance([1, 1.5, 2]) == pytest.approx([0.5, 0.5, 0.5])
    assert motion.time(0.5) == pytest.approx(1.0)
    assert motion.time(1.0) == pytest.approx(3.0)


def test_a_start_at_rest_is_at_time_zero() -> None:
    assert Motion.of([(0, 0), (1, 0), (2, 1)]).time(0.0) == 0.0


def test_final_stop() -> None:
    motion = Motion.of([(0, 0.1), (0.1, 0)])
    assert motion.final_distance == pytest.approx(0.005)
    assert motion.time(0.005 * (1 + 1e-12)) == pytest.approx(0.1)
    with pytest.raises(
        ValueError, match=r"comes to rest after 0\.005 m and never reaches 0\.0051 m"
    ):
        motion.time([0.001, 0.0051])


@pytest.mark.law("Motion: time is the inverse of distance.")
# its distance squared is no number
@example(Motion((0.0, 1.0, 2.0), (0.0, 0.125, 0.0)), [1.018822925987424e-161])
@settings(deadline=None, max_examples=200)
@given(motions(), st.lists(st.floats(0, 8), min_size=1, max_size=20))
def test_time_undoes_distance(motion: Motion, times: list[float]) -> None:
    t = np.sort(times)
    d = motion.distance(t)
    assert np.all(np.diff(d) >= -1e-14)
    back = motion.time(d)
    assert np.all(np.diff(back) >= -1e-14)
    # The way back always leads to the same distance, and to the same time wherever the sphere
    # moves: the time is as uncertain as the distance's rounding over the speed.
    assert motion.distance(back) == pytest.approx(d, rel=1e-12, abs=1e-13)
    moving = motion.speed(t) > 1e-2
    assert back[moving] == pytest.approx(t[moving], rel=1e-10, abs=1e-10)


@pytest.mark.law("Motion: distance is the integral of the speed.")
@settings(deadline=None, max_examples=100)
@given(motions())
def test_distance_is_the_integral_of_the_speed(motion: Motion) -> None:
    knots = np.array([*motion.times, motion.times[-1] + 1])
    # The trapezoidal rule is exact on each straight stretch.
    v = motion.speed(knots)
    assert motion.distance(knots[-1]) == pytest.approx(
        np.sum(np.diff(knots) * (v[1:] + v[:-1]) / 2), rel=1e-13
    )


@pytest.mark.parametrize(
    ("times", "speeds", "message"),
    [
        ((0.0, 1.0), (1.0,), "as many speeds as times"),
        ((), (), "as many speeds as times"),
        ((0.0, 0.0), (1.0, 1.0), "increase strictly from 0"),
        ((1.0, 2.0), (1.0, 1.0), "increase strictly from 0"),
        ((0.0, 1.0), (1.0, -1.0), "not negative"),
        ((0.0, 1.0), (0.0, 0.0), "not all zero"),
        ((0.0,), (float("nan"),), "finite"),
    ],
)
def test_refusals(times: tuple[float, ...], speeds: tuple[float, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Motion(times, speeds)


def test_nothing_before_the_start() -> None:
    with pytest.raises(ValueError, match="before the start"):
        Motion.of(1.0).distance(-1.0)
    with pytest.raises(ValueError, match="before the start"):
        Motion.of(1.0).time(-1.0)
