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
    """Ring on the mean stiffness of its balls.

    Displacements x and y are radial and z is axial; the cosine and the sine part of each bending
    mode follow, and turns about x and y if the ring is free to tilt.

    The contacts lose energy, and the ring itself does not. At each resonance the loss factor is
    that of the contacts times their share of the stiffness, which is 1 for a rigid ring: the
    viscous matrix is S^T K S with the stiffness K of the contacts, and S is made of the modes. A
    film of oil adds its time times the angular frequency of the resonance to the loss factor.

    masses : array (m,), kg. Of each displacement; of turns in kg m2.
    stiffness_n_m : array (m, m), N/m. Of the contacts.
    springs_n_m : array (m,), N/m. Of the ring itself against each displacement.
    loss_factor : float. Of the contacts.
    film_time_s : float, s. Viscosity of films of oil over the stiffness of the contacts.
    """

    __repr__ = short_repr

    masses: Array
    stiffness_n_m: Array
    springs_n_m: Array
    loss_factor: float
    film_time_s: float = 0.0

    @property
    def mass_kg(self) -> float:
        """Mass of the ring [kg]."""
        return float(self.masses[0])

    @cached_property
    def _modes(self) -> tuple[Array, Array]:
        """Squares of the angular frequencies (m,), and modes (m, m) over roots of the masses."""
        scale = 1 / np.sqrt(self.masses)
        whole = self.stiffness_n_m + np.diag(self.springs_n_m)
        squares, modes = np.linalg.eigh(np.outer(scale, scale) * whole)
        held = squares > _SOFT * squares[-1]
        return np.where(held, squares, 0.0), modes

    @property
    def resonances_hz(self) -> Array:
        """Resonances [Hz], (m,) ascending; zero in a direction in which nothing holds the ring."""
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
    def decays_s(self) -> Array:
        """Times [s] in which free vibrations at the resonances fall to 1/e, (m,).

        They are infinite without losses, and zero in a direction in which nothing holds the ring.
        """
        squares, modes = self._modes
        scale = 1 / np.sqrt(self.masses)
        viscous = np.outer(scale, scale) * self.damping_n_s_m
        rates = np.einsum("xk,xy,yk->k", modes, viscous, modes) / 2
        decays = np.full(len(rates), np.inf)
        lossy = rates > 0
        decays[lossy] = 1 / rates[lossy]
        return np.where(squares > 0, decays, 0.0)

    @property
    def slowest_decay_s(self) -> float:
        """Longest time [s] in which a free vibration falls to 1/e; infinite without losses."""
        return float(np.max(self.decays_s))

    @property
    def damping_n_s_m(self) -> Array:
        """Viscous matrix [N s/m], (m, m)."""
        return np.asarray(self.spread.T @ self.stiffness_n_m @ self.spread)

    @property
    def spread(self) -> Array:
        """Matrix S [s^(1/2)], (m, m): the viscous matrix is S^T K S."""
        squares, modes = self._modes
        factors = np.zeros_like(squares)
        held = squares > 0
        factors[held] = np.sqrt(self.loss_factor * squares[held] ** (-1 / 2) + self.film_time_s)
        root = np.sqrt(self.masses)
        return np.asarray((modes * factors) @ modes.T * np.outer(1 / root, root))

    def dynamic_stiffness(self, frequency_hz: Array) -> Complexes:
        """Return force over displacement [N/m] at frequencies, (n, m, m)."""
        omega = 2 * pi * np.asarray(frequency_hz, dtype=float)[:, None, None]
        inertia = omega**2 * np.diag(self.masses)
        whole = self.stiffness_n_m + np.diag(self.springs_n_m)
        return np.asarray(whole - inertia + 1j * omega * self.damping_n_s_m)

    def mobility(self, frequency_hz: Array) -> Complexes:
        """Return velocity over force [m/s/N] at frequencies above zero, (n, m, m)."""
        omega = 2 * pi * np.asarray(frequency_hz, dtype=float)[:, None, None]
        return np.asarray(1j * omega * np.linalg.inv(self.dynamic_stiffness(frequency_hz)))


def linear_ring(bearing: BearingModel) -> LinearRing:
    """Return the linear ring of a bearing, with the mean stiffness over places of the cage."""
    whole = np.mean([state.stiffness for state in bearing.balances()], axis=0)
    stiffness = whole[np.ix_(bearing.columns, bearing.columns)]
    return LinearRing(
        masses=bearing.masses,
        stiffness_n_m=(stiffness + stiffness.T) / 2,
        springs_n_m=bearing.springs,
        loss_factor=bearing.contact_loss_factor,
        film_time_s=bearing.film_time_s,
    )


def gyration_squared(radius_m: float, width_m: float) -> float:
    """Return the square of the radius of gyration [m2] of a thin ring about a diameter."""
    return radius_m**2 / 2 + width_m**2 / 12


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
    tilting = (geometry.pitch_radius_m * sin(contact_angle)) ** 2
    tilting /= gyration_squared(radius_m, width_m)
    return 20 * log10(1 + tilting / along)
