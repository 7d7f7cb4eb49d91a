"""Simply supported rectangular plate: its modes, its answer to a force at a point, its sound."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from acoustics import baffled_modes
from acoustics.arrays import Array
from acoustics.baffled_modes import Complex, Listener, ModePressures
from acoustics.radiation import AIR_KG_M3, SOUND_M_S, ThinPlate

MODES_HZ = 30e3  # highest natural frequency of the modes that move
_BEYOND = 100.0  # times this frequency: modes up to there are summed for their static compliance
_SIDES = 2  # of the plate with air
_BLOCK = 2**19  # values of all modes at once


@dataclass(frozen=True, kw_only=True)
class RectangularPlate(ThinPlate):
    """Thin rectangular plate, simply supported at all four edges.

    Mode (m, n) has the shape sin(m pi x / a) sin(n pi y / b), the natural frequency
    w = sqrt(B/m'') ((m pi/a)^2 + (n pi/b)^2), the modal mass m'' a b / 4, and a loss factor. The
    plate lies at z = 0 in an infinite rigid baffle with air on both sides; the force comes from
    z > 0. Modes above MODES_HZ answer below it with their stiffness alone: as waves in a small
    region about the force, they change the pressure in hearing by less than 0.1 dB.

    Parameters
    ----------
    mass_per_area_kg_m2, bending_stiffness_n_m : float, kg/m^2, N m. Mass per area m'', and bending
        stiffness per width B.
    loss_factor : float. Loss factor of bending waves in the plate, above 0. The air takes more.
    length_m, width_m : float, m. Edges a along x and b along y.

    Examples
    --------
    >>> from acoustics.rectangular_plate import RectangularPlate
    >>> plate = RectangularPlate(78.5, 18.9e3, 1e-2, length_m=0.4, width_m=0.3)
    >>> len(plate.angular_frequency), round(float(plate.angular_frequency[0]) / 6.2832)
    (104, 423)
    """

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

    @cached_property
    def loss_factors(self) -> Array:
        """Loss factor of each mode, in the plate and by its sound to both sides, (modes,)."""
        return self.loss_factor + _SIDES * _sound_loss(self)

    @property
    def modal_mass_kg(self) -> float:
        """Modal mass of every mode [kg]."""
        return self.mass_per_area_kg_m2 * self.length_m * self.width_m / 4

    def shapes(self, points_m: ArrayLike, modes: slice = slice(None)) -> Array:
        """Return the shape of each mode at points (n, 2) [m], an array (n, modes)."""
        return self._shapes(self.orders[modes], points_m)

    def residual_compliance_m_n(self, point_m: ArrayLike) -> float:
        """Return the static compliance [m/N] at a point of the modes above MODES_HZ."""
        orders = self._orders(MODES_HZ, _BEYOND * MODES_HZ)
        stiffness = self.modal_mass_kg * np.square(self._angular_frequency(orders))
        near = float(np.sum(np.square(self._shapes(orders, point_m)) / stiffness))
        return near + float(self.mobility_s_kg / (np.pi**2 * _BEYOND * MODES_HZ))

    def mode_receptance(self, frequency_hz: NDArray[Any], modes: slice = slice(None)) -> Complex:
        """Return the modal displacements [m] per modal force [N], (n, modes).

        A complex frequency f - i a/(2 pi) stands for phasors that grow as exp(a t).
        """
        w, wn = 2 * np.pi * frequency_hz[:, None], self.angular_frequency[modes]
        loss = 1j * self.loss_factors[modes] * wn * w
        return np.asarray(1 / (self.modal_mass_kg * (wn**2 - w**2 + loss)))

    # ---- sound

    def pressure_transfer(
        self,
        frequency_hz: ArrayLike,
        contact_m: ArrayLike,
        listener_m: Listener,
        path_m: float | None = None,
    ) -> Complex:
        """Return the sound pressure per force between ball and plate [Pa/N], phasors of exp(i w t).

        It is Rayleigh's integral over the displacement towards the listener, of the modes up to
        MODES_HZ.

        Parameters
        ----------
        frequency_hz : array (n,), Hz. Frequencies, real or complex as in `mode_receptance`.
        contact_m : array (2,), m. Point of the force from a corner of the plate.
        listener_m : x, y, z, m. Listener from the same corner; z > 0 is the ball's side.
        path_m : float, m. Distance whose delay is left out. Default: from contact to listener.

        Returns
        -------
        array (n,), Pa/N

        References
        ----------
        Lord Rayleigh, The Theory of Sound, 2nd ed. (1896), section 278.

        Examples
        --------
        >>> from acoustics.rectangular_plate import RectangularPlate
        >>> plate = RectangularPlate(78.5, 18.9e3, 1e-2, length_m=0.4, width_m=0.3)
        >>> pressure = plate.pressure_transfer([1000.0], [0.17, 0.11], (0.17, 0.11, 1.0))
        >>> round(1e3 * float(abs(pressure[0])), 1)  # mPa per N
        4.8
        """
        shapes = self.shapes(contact_m)[0]
        if path_m is None:
            path_m = math.dist((*np.ravel(contact_m), 0.0), listener_m)
        parts = self._parts(np.atleast_1d(np.asarray(frequency_hz)))
        transfers = (self.mode_transfer(part, listener_m, path_m) for part in parts)
        return np.concatenate([transfer @ shapes for transfer in transfers])

    def mode_transfer(
        self,
        frequency_hz: NDArray[Any],
        listener_m: Listener,
        path_m: float,
        modes: slice = slice(None),
    ) -> Complex:
        """Return the sound pressure per modal force [Pa/N], (n, modes), as `pressure_transfer`."""
        radiation, w = _pressures(self, listener_m), 2 * np.pi * frequency_hz
        delay = (radiation.distance_m - path_m) / SOUND_M_S
        factor = AIR_KG_M3 / (2 * np.pi) * np.sign(listener_m[2]) * w**2 * np.exp(-1j * w * delay)
        modal = self.mode_receptance(frequency_hz, modes)
        return np.asarray(factor[:, None] * modal * radiation.at(np.real(frequency_hz), modes))

    def power_per_force(self, frequency_hz: ArrayLike, contact_m: ArrayLike) -> Array:
        """Return the sound power to one side per mean square of the force [W/N2], (n,).

        The powers of modes are added (`power_of_modes`), as a mean over contact points (k, 2) [m].
        """
        f = np.atleast_1d(np.asarray(frequency_hz, dtype=float))
        shapes = np.mean(np.square(self.shapes(contact_m)), axis=0)
        power = []
        for part in self._parts(f):
            squares = np.square(np.abs(2 * np.pi * part[:, None] * self.mode_receptance(part)))
            edges = self.length_m, self.width_m
            power.append(baffled_modes.power_of_modes(edges, self.orders, squares * shapes, part))
        return np.concatenate(power)

    def _parts(self, frequency: NDArray[Any]) -> list[NDArray[Any]]:
        """Split frequencies into parts that bound the memory of all modes."""
        count = max(1, _BLOCK // max(1, len(self.angular_frequency)))
        return np.split(frequency, range(count, len(frequency), count))

    def _angular_frequency(self, orders: NDArray[np.int64]) -> Array:
        waves = np.pi * orders / (self.length_m, self.width_m)
        ratio = np.sqrt(self.bending_stiffness_n_m / self.mass_per_area_kg_m2)
        return np.asarray(ratio * np.sum(np.square(waves), axis=1))

    def _shapes(self, orders: NDArray[np.int64], points_m: ArrayLike) -> Array:
        along, across = np.atleast_2d(np.asarray(points_m, dtype=float)).T[:, :, None]
        m, n = orders.T
        sines = np.sin(np.pi * m * along / self.length_m), np.sin(np.pi * n * across / self.width_m)
        return np.asarray(sines[0] * sines[1])

    def _orders(self, above_hz: float, to_hz: float) -> NDArray[np.int64]:
        """Return the orders of the modes above one frequency [Hz] up to another."""
        ratio = np.sqrt(self.bending_stiffness_n_m / self.mass_per_area_kg_m2)
        most = np.sqrt(2 * np.pi * to_hz / ratio) / np.pi * np.array([self.length_m, self.width_m])
        m, n = np.meshgrid(np.arange(1, most[0] + 1), np.arange(1, most[1] + 1), indexing="ij")
        orders = np.column_stack((m.ravel(), n.ravel())).astype(np.int64)
        frequency = self._angular_frequency(orders) / (2 * np.pi)
        kept = (frequency > above_hz) & (frequency <= to_hz)
        return np.asarray(orders[kept][np.argsort(frequency[kept], kind="stable")])


@lru_cache(maxsize=8)
def _sound_loss(plate: RectangularPlate) -> Array:
    """Return the loss factor of each mode by the sound that it radiates to one side."""
    w = plate.angular_frequency
    edges = plate.length_m, plate.width_m
    resistance = baffled_modes.own_resistance(edges, plate.orders, w / (2 * np.pi))
    return np.asarray(resistance / (plate.modal_mass_kg * w))


@lru_cache(maxsize=32)
def _pressures(plate: RectangularPlate, listener_m: Listener) -> ModePressures:
    """Tabulate the radiation of the modes of a plate at a listener."""
    return baffled_modes.mode_pressures((plate.length_m, plate.width_m), plate.orders, listener_m)
