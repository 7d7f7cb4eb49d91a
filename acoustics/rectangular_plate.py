"""Simply supported rectangular plate: its modes, and its answer to a force at a point."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from acoustics.arrays import Array

MODES_HZ = 30e3  # highest natural frequency of the modes that move
_BEYOND = 100.0  # times this frequency: modes up to there are summed for their static compliance


@dataclass(frozen=True)
class RectangularPlate:
    """Thin rectangular plate, simply supported at all four edges.

    Mode (m, n) has the shape sin(m pi x / a) sin(n pi y / b), the natural frequency
    w = sqrt(B/m'') ((m pi/a)^2 + (n pi/b)^2), the modal mass m'' a b / 4, and a loss factor.

    Parameters
    ----------
    mass_per_area_kg_m2, bending_stiffness_n_m : float, kg/m^2, N m. Mass per area m'', and bending
        stiffness per width B.
    loss_factor : float. Loss factor of all modes, above 0.
    length_m, width_m : float, m. Edges a along x and b along y.

    Examples
    --------
    >>> from acoustics.rectangular_plate import RectangularPlate
    >>> plate = RectangularPlate(78.5, 18.9e3, 1e-2, 0.4, 0.3)
    >>> len(plate.angular_frequency), round(float(plate.angular_frequency[0]) / 6.2832)
    (104, 423)
    """

    mass_per_area_kg_m2: float
    bending_stiffness_n_m: float
    loss_factor: float
    length_m: float
    width_m: float

    @cached_property
    def orders(self) -> NDArray[np.int64]:
        """Half waves along and across of each mode, (modes, 2), by rising frequency."""
        return self._orders(0.0, MODES_HZ)

    @cached_property
    def angular_frequency(self) -> Array:
        """Natural angular frequency of each mode, (modes,) [rad/s]."""
        return self._angular_frequency(self.orders)

    @property
    def modal_mass_kg(self) -> float:
        """Modal mass of every mode [kg]."""
        return self.mass_per_area_kg_m2 * self.length_m * self.width_m / 4

    def shapes(self, points_m: ArrayLike) -> Array:
        """Return the shape of each mode at points (n, 2) [m], an array (n, modes)."""
        return self._shapes(self.orders, points_m)

    def residual_compliance_m_n(self, point_m: ArrayLike) -> float:
        """Return the static compliance [m/N] at a point of the modes above MODES_HZ."""
        orders = self._orders(MODES_HZ, _BEYOND * MODES_HZ)
        stiffness = self.modal_mass_kg * np.square(self._angular_frequency(orders))
        near = float(np.sum(np.square(self._shapes(orders, point_m)) / stiffness))
        mobility = 1 / (8 * np.sqrt(self.bending_stiffness_n_m * self.mass_per_area_kg_m2))
        return near + float(mobility / (np.pi**2 * _BEYOND * MODES_HZ))

    def receptance(
        self, frequency_hz: ArrayLike, force_m: ArrayLike, answer_m: ArrayLike | None = None
    ) -> NDArray[np.complex128]:
        """Return the displacement per force [m/N] of the modes, phasors of exp(i w t).

        The force acts at one point (2,) [m]; the displacement is that of another, by default the
        same. The compliance of the modes above MODES_HZ is left out.
        """
        w = 2 * np.pi * np.atleast_1d(np.asarray(frequency_hz, dtype=float))[:, None]
        wn = self.angular_frequency
        weight = self.shapes(force_m)[0] * self.shapes(force_m if answer_m is None else answer_m)[0]
        modes = self.modal_mass_kg * (wn**2 - w**2 + 1j * self.loss_factor * wn * w)
        return np.asarray((weight / modes).sum(axis=1))

    def _angular_frequency(self, orders: NDArray[np.int64]) -> Array:
        waves = np.pi * orders / (self.length_m, self.width_m)
        ratio = np.sqrt(self.bending_stiffness_n_m / self.mass_per_area_kg_m2)
        return np.asarray(ratio * np.sum(np.square(waves), axis=1))

    def _shapes(self, orders: NDArray[np.int64], points_m: ArrayLike) -> Array:
        along, across = np.atleast_2d(np.asarray(points_m, dtype=float)).T[:, :, None]
        m, n = orders.T
        waves = np.sin(np.pi * m * along / self.length_m) * np.sin(
            np.pi * n * across / self.width_m
        )
        return np.asarray(waves)

    def _orders(self, above_hz: float, to_hz: float) -> NDArray[np.int64]:
        """Return the orders of the modes above one frequency [Hz] up to another."""
        ratio = np.sqrt(self.bending_stiffness_n_m / self.mass_per_area_kg_m2)
        most = np.sqrt(2 * np.pi * to_hz / ratio) / np.pi * np.array([self.length_m, self.width_m])
        m, n = np.meshgrid(np.arange(1, most[0] + 1), np.arange(1, most[1] + 1), indexing="ij")
        orders = np.column_stack((m.ravel(), n.ravel())).astype(np.int64)
        frequency = self._angular_frequency(orders) / (2 * np.pi)
        kept = (frequency > above_hz) & (frequency <= to_hz)
        return np.asarray(orders[kept][np.argsort(frequency[kept], kind="stable")])
