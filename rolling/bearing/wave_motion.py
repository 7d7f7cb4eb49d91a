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
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

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
        return self.of_orders(body, [order])[0]

    def of_orders(self, body: str, orders: Sequence[int]) -> list[list[WaveLine]]:
        """Return the lines at which waves of some orders around a body move the ring, by order.

        Their mobilities are computed together. Lines are those of `of_order`.
        """
        balls = 2.0 if body == BALLS else float(self.model.geometry.balls)
        excited = [self._excited(body, order) for order in orders]
        lines = iter(self._lines([line for of_order in excited for line in of_order], balls))
        by_order = []
        for of_order in excited:
            own = [next(lines) for _ in of_order]
            moving = [line for line in own if line.frequency_hz > 0 and line.directions]
            by_order.append(sorted(moving, key=lambda line: -max(line.velocity.values())))
        return by_order

    def _excited(self, body: str, order: int) -> list[tuple[int, float]]:
        """Return the parts of the forces that an order excites, each with its frequency [Hz].

        A negative frequency is a turn against that of the cage.
        """
        speeds = self.model.kinematics
        if body == BALLS:
            if order % 2:
                return []
            spin_hz = order * speeds.ball_spin_hz
            return [(part, spin_hz + part * speeds.cage_hz) for part in self.parts]
        ring_hz = speeds.inner_hz if body == INNER else speeds.outer_hz
        passing_hz = order * (speeds.cage_hz - ring_hz)
        balls = self.model.geometry.balls
        parts = [part for part in self.parts if (order + part) % balls == 0]
        return [(part, passing_hz + part * speeds.cage_hz) for part in parts]

    def directions_of(self, part: int, frequency_hz: float) -> tuple[str, ...]:
        """Return the directions in which a part of the forces moves the ring at a frequency."""
        (line,) = self._lines([(part, frequency_hz)], self.model.geometry.balls)
        return line.directions

    def _lines(self, excited: Sequence[tuple[int, float]], balls: float) -> list[WaveLine]:
        """Return the lines of parts of the forces of some balls at frequencies [Hz]."""
        hz = np.abs([frequency_hz for _, frequency_hz in excited])
        turns = np.flatnonzero(hz > 0).tolist()  # at rest nothing moves
        velocity = np.zeros((len(excited), len(self.model.columns)))
        if turns:
            forces = np.array([self._force(*excited[place]) for place in turns])
            mobility = self._ring.mobility(hz[turns])
            velocity[turns] = np.abs((mobility @ (balls * forces)[:, :, None])[:, :, 0])
        radial = np.sqrt(np.square(velocity[:, self.model.radial]).sum(axis=1) / 2)
        return [
            WaveLine(
                part=part,
                frequency_hz=float(hz[place]),
                velocity={RADIAL: float(radial[place]), AXIAL: float(velocity[place, 2])},
            )
            for place, (part, _) in enumerate(excited)
        ]

    def _force(self, part: int, frequency_hz: float) -> Complexes:
        """Return a part of the force of a ball; at a negative frequency it is the conjugate one."""
        return np.asarray(self.forces[part] if frequency_hz >= 0 else np.conj(self.forces[part]))

    @cached_property
    def _ring(self) -> LinearRing:
        """Ring on the mean stiffness of its balls."""
        return linear_ring(self.model)
