"""Distance over time, at constant speed or at speeds joined by straight lines."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from acoustics.arrays import Array

ROUNDING = 1e-9  # relative; a smaller excess over the last distance reached counts as rounding


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
        times, speeds = np.array(self.times), np.array(self.speeds)
        if times.ndim != 1 or times.shape != speeds.shape or not times.size:
            raise ValueError("a motion needs as many speeds as times, at least one of each")
        if times[0] != 0 or not np.all(np.diff(times) > 0):
            raise ValueError("the times of a motion must increase strictly from 0")
        if not np.all(np.isfinite(speeds)) or np.any(speeds < 0) or not np.any(speeds > 0):
            raise ValueError(
                "the speeds of a motion must be finite, not negative, and not all zero"
            )

    @classmethod
    def of(cls, speed: float | Sequence[Sequence[float]]) -> Motion:
        """Make the motion at a constant speed [m/s], or from pairs of time [s] and speed [m/s]."""
        if isinstance(speed, int | float):
            return cls((0.0,), (float(speed),))
        return cls(tuple(float(t) for t, _ in speed), tuple(float(v) for _, v in speed))

    @classmethod
    def rolling_out(cls, speed: float, deceleration: float) -> Motion:
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

    def time_below(self, speed: float, duration: float) -> float:
        """Return the time [s] during which the sphere is slower than a speed [m/s].

        The time counts from the start to `duration` [s].

        A sphere at rest makes no sound that could be missed, so rests do not count.
        """
        knots = self._knots_until(duration)
        speeds = self.speed(knots)
        begin, end = speeds[:-1], speeds[1:]
        change = np.abs(end - begin)
        part = np.clip(speed - np.minimum(begin, end), 0.0, change)
        share = np.divide(part, change, out=np.where(begin < speed, 1.0, 0.0), where=change > 0)
        return float(np.sum(np.diff(knots) * share * (np.maximum(begin, end) > 0)))

    def _knots_until(self, duration: float) -> Array:
        """Return the times [s] between which the speed is linear.

        The last time is `duration`.
        """
        return np.array([*(t for t in self.times if t < duration), duration])

    def _speeds_until(self, duration: float) -> Array:
        """Return the speeds [m/s] at these times, including their minimum and maximum."""
        return self.speed(self._knots_until(duration))

    @property
    def final_distance(self) -> float:
        """Maximum distance [m] that the sphere reaches, infinite unless the last speed is zero."""
        return np.inf if self.speeds[-1] > 0 else float(self._knots[2][-1])

    @property
    def rest_time(self) -> float:
        """Time [s] from which the sphere rests, infinite unless the last speed is zero."""
        return np.inf if self.speeds[-1] > 0 else self.times[-1]

    @cached_property
    def _knots(self) -> tuple[Array, Array, Array, Array]:
        """Time, speed, distance and acceleration at the start of each stretch."""
        times, speeds = np.array(self.times), np.array(self.speeds)
        lasting = np.diff(times)
        distances = np.append(0.0, np.cumsum(lasting * (speeds[:-1] + speeds[1:]) / 2))
        return times, speeds, distances, np.append(np.diff(speeds) / lasting, 0.0)

    def speed(self, t: ArrayLike) -> Array:
        """Return the speed [m/s] at the times t >= 0 [s]."""
        return np.interp(_from_zero(t, "time"), self.times, self.speeds)

    def distance(self, t: ArrayLike) -> Array:
        """Return the distance rolled [m] up to the times t >= 0 [s]."""
        t = _from_zero(t, "time")
        times, speeds, distances, accelerations = self._knots
        k = np.searchsorted(times, t, side="right") - 1
        tau = t - times[k]
        return distances[k] + tau * (speeds[k] + accelerations[k] * tau / 2)

    def time(self, distance: ArrayLike) -> Array:
        """Return the time [s] at which each distance >= 0 [m] is first reached.

        Raises
        ------
        ValueError
            The sphere comes to rest before a distance.
        """
        d = _from_zero(distance, "distance")
        times, speeds, distances, accelerations = self._knots
        if speeds[-1] == 0:
            end = distances[-1]
            if np.any(d > end * (1 + ROUNDING)):
                raise ValueError(
                    f"the sphere comes to rest after {end:.6g} m and never reaches {np.max(d):.6g}"
                    " m"
                )
            d = np.minimum(d, end)
        # A stretch owns its end but not its start, so a distance at which the sphere rests belongs
        # to its arrival.
        k = np.maximum(np.searchsorted(distances, d, side="left") - 1, 0)
        ahead = d - distances[k]
        root = np.sqrt(np.maximum(speeds[k] ** 2 + 2 * accelerations[k] * ahead, 0.0))
        # This form of the root of the quadratic does not cancel when braking, and holds without
        # acceleration. Both terms vanish only where the remaining distance is zero in rounding.
        both = speeds[k] + root
        tau = np.divide(2 * ahead, both, out=np.zeros_like(both), where=both > 0)
        lasting = np.append(np.diff(times), np.inf)
        reached: Array = times[k] + np.minimum(tau, lasting[k])
        return reached

    def duration(self, distance: float) -> float:
        """Return the time [s] to roll a distance [m]; raise ValueError as `time` does."""
        return float(self.time(distance))


def _from_zero(values: ArrayLike, quantity: str) -> Array:
    array = np.asarray(values, dtype=float)
    if np.any(array < 0):
        raise ValueError(f"a {quantity} before the start: {np.min(array):.6g}")
    return array
