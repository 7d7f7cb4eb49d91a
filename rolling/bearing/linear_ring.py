"""Ring of a bearing as a linear chain: its mean stiffness, resonances, damping and mobility."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import cos, log10, pi, sin

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array, short_repr
from rolling.bearing.geometry import BearingGeometry
from rolling.bearing.model import BearingModel

_SOFT = 1e-6  # of the largest stiffness: nothing holds the ring in such a direction
Complexes = NDArray[np.complex128]


@dataclass(frozen=True)
class LinearRing:
    """Rigid ring on the mean stiffness of its balls.

    Directions x and y are radial, z is axial. At each resonance the contacts' loss factor is given:
    the viscous matrix has the modes of the stiffness, and the damping loss factor M omega_n each.
    """

    __repr__ = short_repr

    mass_kg: float
    stiffness_n_m: Array  # (3, 3)
    loss_factor: float

    @cached_property
    def _modes(self) -> tuple[Array, Array]:
        """Squares of the angular frequencies (3,), and directions (3, 3) in columns."""
        squares, directions = np.linalg.eigh(self.stiffness_n_m / self.mass_kg)
        held = squares > _SOFT * squares[-1]
        return np.where(held, squares, 0.0), directions

    @property
    def resonances_hz(self) -> Array:
        """Resonances [Hz], (3,) ascending; zero in a direction in which nothing holds the ring."""
        return np.asarray(np.sqrt(self._modes[0]) / (2 * pi))

    @property
    def radial_hz(self) -> float:
        """Resonance [Hz] of a ring that moves along x only, the direction of the radial load."""
        return float(np.sqrt(max(self.stiffness_n_m[0, 0], 0.0) / self.mass_kg)) / (2 * pi)

    @property
    def axial_hz(self) -> float:
        """Resonance [Hz] of a ring that moves along its axis only."""
        return float(np.sqrt(max(self.stiffness_n_m[2, 2], 0.0) / self.mass_kg)) / (2 * pi)

    @property
    def slowest_decay_s(self) -> float:
        """Longest time [s] in which a free vibration falls to 1/e; infinite without losses."""
        held = self._modes[0][self._modes[0] > 0]
        if self.loss_factor <= 0:
            return np.inf
        return float(2 / (self.loss_factor * np.sqrt(held[0])))

    @property
    def damping_n_s_m(self) -> Array:
        """Viscous matrix [N s/m], (3, 3)."""
        squares, directions = self._modes
        return np.asarray(
            self.mass_kg * self.loss_factor * (directions * np.sqrt(squares)) @ directions.T
        )

    @property
    def spread(self) -> Array:
        """Matrix S [s^(1/2)], (3, 3): the viscous matrix is S times the stiffness times S."""
        squares, directions = self._modes
        factors = np.zeros(3)
        held = squares > 0
        factors[held] = np.sqrt(self.loss_factor) * squares[held] ** (-1 / 4)
        return np.asarray((directions * factors) @ directions.T)

    def dynamic_stiffness(self, frequency_hz: Array) -> Complexes:
        """Return force over displacement [N/m] at frequencies, (n, 3, 3)."""
        omega = 2 * pi * np.asarray(frequency_hz, dtype=float)[:, None, None]
        inertia = self.mass_kg * omega**2 * np.eye(3)
        return np.asarray(self.stiffness_n_m - inertia + 1j * omega * self.damping_n_s_m)

    def mobility(self, frequency_hz: Array) -> Complexes:
        """Return velocity over force [m/s/N] at frequencies above zero, (n, 3, 3)."""
        omega = 2 * pi * np.asarray(frequency_hz, dtype=float)[:, None, None]
        return np.asarray(1j * omega * np.linalg.inv(self.dynamic_stiffness(frequency_hz)))


def linear_ring(bearing: BearingModel) -> LinearRing:
    """Return the linear ring of a bearing, with the mean stiffness over places of the cage."""
    stiffness = np.mean([state.stiffness_n_m for state in bearing.balances()], axis=0)
    return LinearRing(
        mass_kg=bearing.ring_mass_kg,
        stiffness_n_m=(stiffness + stiffness.T) / 2,
        loss_factor=bearing.contact_loss_factor,
    )


def free_tilt_db(
    geometry: BearingGeometry, contact_angle: float, radius_m: float, width_m: float
) -> float:
    """Return how many decibels less waves would move a ring along its radius if it could tilt.

    A ring without guidance tilts about the point in which the contact lines of its balls meet, by
    its inertia alone far above its rocking mode. Its ways x along the radius and phi in tilt share
    the displacement w = x cos(alpha) + phi r sin(alpha) that the balls ask of it, r the radius of
    the pitch circle, in proportion to what moves most easily. `contact_angle` [rad] is that under
    the loads, `radius_m` and `width_m` are the mean radius and the width of the ring.
    """
    along = cos(contact_angle) ** 2
    gyration = radius_m**2 / 2 + width_m**2 / 12  # squared, about a diameter
    tilting = (geometry.pitch_radius_m * sin(contact_angle)) ** 2 / gyration
    return 20 * log10(1 + tilting / along)
