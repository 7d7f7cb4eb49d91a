"""Waves around the bodies of a bearing that move its ring: frequencies and directions.

The theory is linear. A wave of order n and unit height around a raceway changes the approach of
ball j, at the angle theta_j = w_c t + 2 pi j / Z, by cos(n (theta_j - w_r t)). The ball presses the
ring with a force k(theta) d(theta) for a unit of approach, of which F_p is the part exp(i p theta).
The sum over all balls leaves the parts with n + p = q Z, so the ring is moved with the angular
frequency

    n (w_c - w_r) + p w_c   by the force Z F_p

Under an axial load k is constant, F_0 is axial, and F_1 and F_-1 are radial. So n = q Z moves the
ring along its axis, and n = q Z + 1 and q Z - 1 along its radius. A load zone has all p.

A wave of an even order n around one ball meets both raceways alike, so it counts twice, and its
ball passes the load zone once a turn of the cage: n w_b + p w_c by the force 2 F_p. Of an odd order
both sides cancel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acoustics.arrays import Array
from rolling.bearing.linear_ring import Complexes, LinearRing, linear_ring
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_record import AXIAL, RADIAL
from rolling.bearing.static_load import ball_stiffness

INNER = "inner"
OUTER = "outer"
BALLS = "balls"
MOVES = 0.01  # of the velocity of the wave's own heights, from which on it moves the ring
MAX_PART = 8  # of the forces around the bearing that is looked at
_ANGLES = 256  # at which the forces of a ball are computed


@dataclass(frozen=True)
class WaveLine:
    """A frequency at which a wave of a unit height moves the ring.

    part : int. Number p of the part of the forces around the bearing.
    frequency_hz : float, Hz.
    velocity : dict. Amplitude of the velocity of the ring over that of the heights [1/s], by
        direction; radially the root of the mean square over all radial directions.
    """

    part: int
    frequency_hz: float
    velocity: dict[str, float]

    @property
    def directions(self) -> tuple[str, ...]:
        """Directions in which the wave moves the ring."""
        least = MOVES * 2 * math.pi * self.frequency_hz
        return tuple(name for name, velocity in self.velocity.items() if velocity >= least)


@dataclass(frozen=True)
class WaveMotion:
    """Motion of the ring of a bearing by waves around its bodies."""

    model: BearingModel

    @cached_property
    def forces(self) -> Complexes:
        """Parts F_p of the force for a unit of approach [N/m], (p, m), p counted as of an FFT."""
        model = self.model
        angles = 2 * np.pi * np.arange(_ANGLES) / _ANGLES
        ring = np.mean([balance.displacements for balance in model.balances()], axis=0)
        pressed = model.lines(angles).at(ring).of(model.columns)
        stiffness = ball_stiffness(pressed.approach_m, model.geometry.series_stiffness)
        return np.asarray(np.fft.fft(stiffness[:, None] * pressed.lines, axis=0) / _ANGLES)

    @cached_property
    def parts(self) -> list[int]:
        """Numbers of the parts of the forces, the lowest first; those of rounding left out."""
        largest = float(np.abs(self.forces).max())
        numbers = sorted(range(-MAX_PART, MAX_PART + 1), key=lambda part: (abs(part), part))
        return [part for part in numbers if np.abs(self.forces[part]).max() >= MOVES * largest]

    def of_order(self, body: str, order: int) -> list[WaveLine]:
        """Return the lines at which a wave of an order around a body moves the ring, largest first.

        Parameters
        ----------
        body : str
            inner, outer or balls; of the balls one has the wave.
        order : int
            Number of waves around the body.
        """
        lines = []
        for part in self.parts:
            if body == BALLS and order % 2 == 0:
                frequency_hz = order * self.model.kinematics.ball_spin_hz
                frequency_hz += part * self.model.kinematics.cage_hz
                lines.append(self._line(part, frequency_hz, 2.0))
            elif body != BALLS and (order + part) % self.model.geometry.balls == 0:
                speeds = self.model.kinematics
                ring_hz = speeds.inner_hz if body == INNER else speeds.outer_hz
                frequency_hz = order * (speeds.cage_hz - ring_hz) + part * speeds.cage_hz
                lines.append(self._line(part, frequency_hz, self.model.geometry.balls))
        moving = [line for line in lines if line.frequency_hz > 0 and line.directions]
        return sorted(moving, key=lambda line: -max(line.velocity.values()))

    def directions_of(self, part: int, frequency_hz: float) -> tuple[str, ...]:
        """Return the directions in which a part of the forces moves the ring at a frequency."""
        return self._line(part, frequency_hz, self.model.geometry.balls).directions

    def _line(self, part: int, frequency_hz: float, balls: float) -> WaveLine:
        """Return the line of a part of the forces of some balls; at rest nothing moves."""
        # A negative frequency is the positive one with the conjugate force.
        force = self.forces[part] if frequency_hz >= 0 else np.conj(self.forces[part])
        hz = abs(frequency_hz)
        if not hz > 0:
            return WaveLine(part, 0.0, {RADIAL: 0.0, AXIAL: 0.0})
        velocity = np.abs(self._mobility(hz) @ (balls * force))
        radial = float(np.sqrt(np.square(velocity[self.model.radial]).sum() / 2))
        return WaveLine(part, hz, {RADIAL: radial, AXIAL: float(velocity[2])})

    def _mobility(self, frequency_hz: float) -> Complexes:
        """Return velocity over force [m/s/N] at a frequency, (m, m)."""
        frequencies: Array = np.array([frequency_hz])
        return np.asarray(self._ring.mobility(frequencies)[0])

    @cached_property
    def _ring(self) -> LinearRing:
        """Ring on the mean stiffness of its balls."""
        return linear_ring(self.model)
