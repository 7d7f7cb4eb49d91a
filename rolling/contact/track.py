"""Track of a ball in whole nodes and whole steps, and its speed along it, in SI."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from acoustics.arrays import Array

ROUNDING = 1e-9  # relative; a smaller excess over the last distance reached counts as rounding
MIN_SHARE = 0.01  # share of a record; shorter stretches that are too slow for hearing are ignored


@dataclass(frozen=True)
class Motion:
    """Speed profile, linear between the given times and constant after the last.

    Parameters
    ----------
    times : tuple of float, s
        Times, strictly increasing from 0.
    speeds : tuple of float, m/s
        One speed per time; no speed is negative, and not all are zero.

    Raises
    ------
    ValueError
        Times or speeds violate these conditions.
    """

    times: tuple[float, ...]
    speeds: tuple[float, ...]

    def __post_init__(self) -> None:
        times = np.array(self.times)
        speeds = np.array(self.speeds)
        if times.ndim != 1 or times.shape != speeds.shape or not times.size:
            raise ValueError("a motion needs as many speeds as times, at least one of each")
        if times[0] != 0 or not np.all(np.diff(times) > 0):
            raise ValueError("the times of a motion must increase strictly from 0")
        if not np.all(np.isfinite(speeds)) or np.any(speeds < 0) or not np.any(speeds > 0):
            raise ValueError("the speeds must be finite, not negative, and not all zero")

    @classmethod
    def of(cls, speed: float | Sequence[Sequence[float]]) -> Self:
        """Make the motion at a constant speed [m/s], or from pairs of time [s] and speed [m/s]."""
        if isinstance(speed, int | float):
            return cls((0.0,), (float(speed),))
        return cls(tuple(float(t) for t, _ in speed), tuple(float(v) for _, v in speed))

    @classmethod
    def rolling_out(cls, speed: float, deceleration: float) -> Self:
        """Make the motion from a speed [m/s] to rest at a deceleration [m/s2], 0 for none."""
        if not deceleration > 0:
            return cls((0.0,), (speed,))
        return cls((0.0, speed / deceleration), (speed, 0.0))

    def is_constant(self, duration: float) -> bool:
        """Tell whether the speed stays the same from the start to a time [s]."""
        speeds = self._speeds_until(duration)
        return bool(np.ptp(speeds) <= ROUNDING * speeds.max())

    def slowest(self, duration: float) -> float:
        """Return the minimum speed [m/s] from the start to a time [s]."""
        return float(self._speeds_until(duration).min())

    def fastest(self, duration: float) -> float:
        """Return the maximum speed [m/s] that is reached from the start to a time [s]."""
        return float(self._speeds_until(duration).max())

    def usual_speed(self, duration: float) -> float:
        """Return the speed [m/s] that the sphere reaches for most of the time up to `duration` [s].

        It rolls more slowly for less than `MIN_SHARE` of this time.
        """
        low = 0.0
        high = self.fastest(duration)
        if self.is_constant(duration):
            return high
        for _ in range(60):
            middle = (low + high) / 2
            below = self.time_below(middle, duration) < MIN_SHARE * duration
            low, high = (middle, high) if below else (low, middle)
        return low or high

    def time_below(self, speed: float, duration: float) -> float:
        """Return the time [s] during which the sphere is slower than a speed [m/s].

        The time counts from the start to `duration` [s].

        A sphere at rest makes no sound that could be missed, so rests do not count.
        """
        knots = self._knots_until(duration)
        speeds = self.speed(knots)
        begin = speeds[:-1]
        end = speeds[1:]
        change = np.abs(end - begin)
        part = np.clip(speed - np.minimum(begin, end), 0.0, change)
        share = np.divide(part, change, out=np.where(begin < speed, 1.0, 0.0), where=change > 0)
        moves = np.maximum(begin, end) > 0
        return float(np.sum(np.diff(knots) * share * moves))

    def _knots_until(self, duration: float) -> Array:
        """Return the times [s] between which the speed is linear.

        The last time is `duration`.
        """
        return np.array([t for t in self.times if t < duration] + [duration])

    def _speeds_until(self, duration: float) -> Array:
        """Return the speeds [m/s] at these times, including their minimum and maximum."""
        return self.speed(self._knots_until(duration))

    @property
    def final_distance(self) -> float:
        """Maximum distance [m] that the sphere reaches, infinite unless the last speed is zero."""
        return np.inf if self.speeds[-1] > 0 else float(self._knots.distances[-1])

    @property
    def rest_time(self) -> float:
        """Time [s] from which the sphere rests, infinite unless the last speed is zero."""
        return np.inf if self.speeds[-1] > 0 else self.times[-1]

    @cached_property
    def _knots(self) -> "_Knots":
        """Time, speed, distance and acceleration at the start of each stretch."""
        times = np.array(self.times)
        speeds = np.array(self.speeds)
        lasting = np.diff(times)
        return _Knots(
            times=times,
            speeds=speeds,
            distances=np.append(0.0, np.cumsum(lasting * (speeds[:-1] + speeds[1:]) / 2)),
            accelerations=np.append(np.diff(speeds) / lasting, 0.0),
        )

    def speed(self, t: ArrayLike) -> Array:
        """Return the speed [m/s] at the times t >= 0 [s]."""
        return np.interp(_from_zero(t, "time"), self.times, self.speeds)

    def distance(self, t: ArrayLike) -> Array:
        """Return the distance rolled [m] up to the times t >= 0 [s]."""
        t = _from_zero(t, "time")
        knots = self._knots
        k = np.searchsorted(knots.times, t, side="right") - 1
        tau = t - knots.times[k]
        return knots.distances[k] + tau * (knots.speeds[k] + knots.accelerations[k] * tau / 2)

    def time(self, distance: ArrayLike) -> Array:
        """Return the time [s] at which each distance >= 0 [m] is first reached.

        Raises
        ------
        ValueError
            The sphere comes to rest before a distance.
        """
        d = _from_zero(distance, "distance")
        knots = self._knots
        if knots.speeds[-1] == 0:
            end = knots.distances[-1]
            if np.any(d > end * (1 + ROUNDING)):
                words = f"the sphere comes to rest after {end:.6g} m"
                raise ValueError(f"{words} and never reaches {np.max(d):.6g} m")
            d = np.minimum(d, end)
        # A stretch owns its end but not its start, so a distance at which the sphere rests belongs
        # to its arrival.
        k = np.maximum(np.searchsorted(knots.distances, d, side="left") - 1, 0)
        ahead = d - knots.distances[k]
        speeds = knots.speeds[k]
        root = np.sqrt(np.maximum(speeds**2 + 2 * knots.accelerations[k] * ahead, 0.0))
        # This form of the root of the quadratic does not cancel when braking, and holds without
        # acceleration. Both terms vanish only where the remaining distance is zero in rounding.
        both = speeds + root
        tau = np.divide(2 * ahead, both, out=np.zeros_like(both), where=both > 0)
        lasting = np.append(np.diff(knots.times), np.inf)
        reached: Array = knots.times[k] + np.minimum(tau, lasting[k])
        return reached

    def duration(self, distance: float) -> float:
        """Return the time [s] to roll a distance [m]; raise ValueError as `time` does."""
        return float(self.time(distance))


class _Knots(NamedTuple):
    """Time [s], speed [m/s], distance [m] and acceleration [m/s2] at the start of each stretch."""

    times: Array
    speeds: Array
    distances: Array
    accelerations: Array


def _from_zero(values: ArrayLike, quantity: str) -> Array:
    """Return values as an array; raise ValueError for a negative one."""
    array = np.asarray(values, dtype=float)
    if np.any(array < 0):
        raise ValueError(f"a {quantity} before the start: {np.min(array):.6g}")
    return array


# ---- track in whole nodes


MIN_NODES = 8  # minimum number of nodes along and across
MAX_NODES = 10**9  # maximum of nodes and steps along the track; more is an error of the unit
# Widths of surface that lie behind and ahead of a track that does not close under a sphere with a
# surface: half a width at either end is as it would be on a longer track, and over a width the end
# is faded into the beginning. A contact is narrower than the surface.
MARGIN_WIDTHS = 2


@dataclass(frozen=True)
class Track:
    """Positions of the sphere on its surface.

    Attributes
    ----------
    n_along, n_across : int
        Nodes of the surface, plate and sphere together.
    steps : int
        Number of steps; there is one position more.
    step, spacing : float, m
        Distance between positions, and between nodes.
    closed : bool
        If true, the last position coincides with the first.
    lap_steps : int
        Steps after which the positions repeat.
    plate_nodes : int
        Period of the plate's surface along the track.
    turn_nodes : int
        Nodes of a turn of a sphere that has a surface, 0 for a smooth sphere.
    """

    n_along: int
    n_across: int
    steps: int
    step: float
    spacing: float
    closed: bool
    lap_steps: int
    plate_nodes: int
    turn_nodes: int = 0

    @property
    def solved_steps(self) -> int:
        """Number of steps that differ from each other and have to be solved."""
        return min(self.steps, self.lap_steps)

    @property
    def surface_nodes(self) -> int:
        """Nodes of the surface, and of a turn of a sphere that has a surface."""
        return (self.n_along + self.turn_nodes) * self.n_across

    @property
    def distance(self) -> float:
        """Distance rolled [m]."""
        return self.steps * self.step

    @property
    def turns(self) -> float:
        """Turns of a sphere that has a surface, 0 for a smooth sphere."""
        if not self.turn_nodes:
            return 0.0
        return self.distance / (self.turn_nodes * self.spacing)


@dataclass(frozen=True, kw_only=True)
class Travel:
    """Motion of a ball along its track, from the start to the end of the track or to its rest.

    Attributes
    ----------
    motion : Motion
        Distance and speed over time.
    track : Track
        Positions on the surface.
    """

    motion: Motion
    track: Track

    @property
    def duration_s(self) -> float:
        """Time [s] that the track takes."""
        # A track round a file has at least one step, even for a sphere that rests before.
        return self.motion.duration(min(self.track.distance, self.motion.final_distance))

    @property
    def is_constant(self) -> bool:
        """Whether the speed stays the same all along the track."""
        return self.motion.is_constant(self.duration_s)

    @property
    def fastest_m_s(self) -> float:
        """Maximum speed [m/s] on the track."""
        return self.motion.fastest(self.duration_s)
