"""Simply supported rectangular plate in a baffle: its modes, its answer to a force, its sound.

The shapes are products of sines along both edges, so matrix products integrate all modes at once:
the pressure at a listener by Rayleigh's integral, and the sound power over wave numbers.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from acoustics.arrays import Array, refuse_masked
from acoustics.bands import AUDIBLE_HZ
from acoustics.radiation import AIR_KG_M3, SOUND_M_S, ThinPlate, legendre

Complex = NDArray[np.complex128]
Edges = tuple[float, float]
Orders = NDArray[np.int64]
Listener = tuple[float, float, float]
_PANEL_RAD = 60.0  # phase along a panel of the quadrature
MARGIN = 10  # nodes of a panel beyond half its phase; they resolve 1/R at the panel's own distance
POINTS = 6  # frequencies of a table that a polynomial joins
PHASE_RAD = 0.8  # between frequencies of a table; interpolation then errs by 1.3e-3 at most
# Frequencies that share the directions of a sound power: maximum ratio, and phase along an edge.
_RATIO = 0.03
_SHIFT_RAD = 0.6
OWN_RATIO = 0.01  # of modes that share them at their own frequencies; more blurs coincidence
MODES_HZ = 30e3  # highest natural frequency of the modes that move
_BEYOND = 100.0  # times this frequency: modes up to there are summed for their static compliance
SIDES = 2  # of the plate with air
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
    loss_factor : float, or pairs of float. Loss factor of bending waves in the plate, above 0, as
        in ThinPlate. The air takes more.
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
        own = self.loss_factor_at(self.angular_frequency / (2 * np.pi))
        return own + SIDES * _sound_loss(self)

    @property
    def modal_mass_kg(self) -> float:
        """Modal mass of every mode [kg]."""
        return self.mass_per_area_kg_m2 * self.length_m * self.width_m / 4

    @property
    def mode_count(self) -> int:
        """Number of modes up to MODES_HZ."""
        return len(self.angular_frequency)

    @property
    def rigid_modes(self) -> int:
        """Number of rigid-body modes, which come first: only free edges have them."""
        return 0

    def shapes(self, points_m: ArrayLike, modes: slice = slice(None)) -> Array:
        """Return the shape of each mode at points (n, 2) [m], an array (n, modes)."""
        refuse_masked("points_m", points_m)
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
        refuse_masked("frequency_hz", frequency_hz)
        w = 2 * np.pi * frequency_hz[:, None]
        wn = self.angular_frequency[modes]
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
        refuse_masked("frequency_hz", frequency_hz)
        shapes = self.shapes(contact_m)[0]
        if path_m is None:
            x, y = np.ravel(contact_m)
            path_m = math.dist((x, y, 0.0), listener_m)
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
        radiation = self.mode_pressures(listener_m)
        w = 2 * np.pi * frequency_hz
        delay = (radiation.distance_m - path_m) / SOUND_M_S
        factor = AIR_KG_M3 / (2 * np.pi) * np.sign(listener_m[2]) * w**2 * np.exp(-1j * w * delay)
        modal = self.mode_receptance(frequency_hz, modes)
        return np.asarray(factor[:, None] * modal * radiation.at(np.real(frequency_hz), modes))

    def power_per_force(self, frequency_hz: ArrayLike, contact_m: ArrayLike) -> Array:
        """Return the sound power to one side per mean square of the force [W/N2], (n,).

        The powers of modes are added (`power_of_modes`), as a mean over contact points (k, 2) [m].
        """
        refuse_masked("frequency_hz", frequency_hz)
        f = np.atleast_1d(np.asarray(frequency_hz, dtype=float))
        shapes = np.mean(np.square(self.shapes(contact_m)), axis=0)
        power = []
        for part in self._parts(f):
            squares = np.square(np.abs(2 * np.pi * part[:, None] * self.mode_receptance(part)))
            power.append(self._power(squares * shapes, part))
        return np.concatenate(power)

    def mode_pressures(self, listener_m: Listener) -> "ModePressures":
        """Return Rayleigh's integrals of the modes at a listener, over frequency."""
        return _pressures(self, listener_m)

    def _power(self, squares: Array, frequency_hz: NDArray[Any]) -> Array:
        """Return the sound power [W] to one side by mean square modal velocities, (n, modes)."""
        return power_of_modes((self.length_m, self.width_m), self.orders, squares, frequency_hz)

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
        shape_along = np.sin(np.pi * m * along / self.length_m)
        shape_across = np.sin(np.pi * n * across / self.width_m)
        return np.asarray(shape_along * shape_across)

    def _orders(self, above_hz: float, to_hz: float) -> NDArray[np.int64]:
        """Return the orders of the modes above one frequency [Hz] up to another."""
        ratio = np.sqrt(self.bending_stiffness_n_m / self.mass_per_area_kg_m2)
        most = np.sqrt(2 * np.pi * to_hz / ratio) / np.pi * np.array([self.length_m, self.width_m])
        m, n = np.meshgrid(np.arange(1, most[0] + 1), np.arange(1, most[1] + 1), indexing="ij")
        orders = np.column_stack((m.ravel(), n.ravel())).astype(np.int64)
        frequency = self._angular_frequency(orders) / (2 * np.pi)
        within = (frequency > above_hz) & (frequency <= to_hz)
        return np.asarray(orders[within][np.argsort(frequency[within], kind="stable")])


# ---- pressure at a listener


@dataclass(frozen=True, eq=False)
class ModePressures:
    """Rayleigh integrals of modes at one listener, tabulated over frequency.

    The phase exp(i k R) at a middle distance R is taken out, which leaves a slow function.
    """

    step_hz: float
    distance_m: float  # middle distance R
    table: Complex  # (frequencies, modes) [m], from 0 Hz

    def at(self, frequency_hz: Array, modes: slice = slice(None)) -> Complex:
        """Interpolate the integrals [m] without exp(-i k R) at frequencies, (n, modes)."""
        table = self.table[:, modes]
        place = np.clip(frequency_hz / self.step_hz, 0.0, len(self.table) - 1.0)
        first, weights = polynomial_weights(place, len(self.table))
        values = np.empty((len(place), table.shape[1]), dtype=complex)
        for start in np.unique(first):
            lines = first == start
            values[lines] = weights[lines] @ table[start : start + POINTS]
        return values


def polynomial_weights(place: Array, rows: int) -> tuple[NDArray[np.int64], Array]:
    """Return the first of the rows that a polynomial joins at places, and their weights."""
    points = np.arange(POINTS)
    first = np.clip(place.astype(int) - POINTS // 2 + 1, 0, rows - POINTS)
    weights = np.ones((len(place), POINTS))  # of Lagrange's polynomial
    for i in points:
        others = points[points != i]
        weights[:, others] *= ((place - first - i)[:, None]) / (others - i)
    return first, weights


def mode_pressures(edges_m: Edges, orders: Orders, listener_m: Listener) -> ModePressures:
    """Tabulate the integrals of sin sin exp(-i k R) / R over a rectangle, up to hearing's end."""

    def integrals(middle_m: float, frequency_hz: float) -> Complex:
        return _integrals(edges_m, orders, listener_m, middle_m, frequency_hz)

    return tabulated_pressures(edges_m, listener_m, integrals)


def tabulated_pressures(
    edges_m: Edges, listener_m: Listener, integrals: Callable[[float, float], Complex]
) -> ModePressures:
    """Tabulate integrals of modes over frequency.

    `integrals` returns those of all modes [m] for a middle distance [m], whose phase is taken out,
    and a frequency [Hz].
    """
    x, y, z = listener_m
    beside = [max(-place, place - edge, 0.0) for place, edge in zip((x, y), edges_m, strict=True)]
    beyond = [max(place, edge - place) for place, edge in zip((x, y), edges_m, strict=True)]
    nearest = math.hypot(beside[0], beside[1], z)
    farthest = math.hypot(beyond[0], beyond[1], z)
    spread = max(farthest - nearest, 0.02 * min(edges_m))
    step = PHASE_RAD * SOUND_M_S / (np.pi * spread)
    middle = (nearest + farthest) / 2
    frequency = step * np.arange(max(POINTS, int(np.ceil(AUDIBLE_HZ[1] / step)) + 2))
    rows = [integrals(middle, f) for f in frequency]
    return ModePressures(step, middle, np.array(rows))


def _integrals(
    edges_m: Edges, orders: Orders, listener_m: Listener, middle_m: float, frequency_hz: float
) -> Complex:
    """Return the integral [m] of each mode at one frequency, times exp(i k middle)."""
    most = orders.max(axis=0, initial=1)
    waves = [np.pi * order / edge for order, edge in zip(most, edges_m, strict=True)]

    def sines(side: int, nodes: Array) -> Array:
        return np.sin(np.pi / edges_m[side] * np.arange(1, most[side] + 1)[:, None] * nodes)

    products = integrals_of_products(edges_m, waves, sines, listener_m, middle_m, frequency_hz)
    rows = orders.T - 1
    return np.asarray(products[rows[0], rows[1]])


def integrals_of_products(
    edges_m: Edges,
    waves: Sequence[float],
    functions: Callable[[int, Array], Array],
    listener_m: Listener,
    middle_m: float,
    frequency_hz: float,
) -> Complex:
    """Return integrals [m] of products of functions of x and of y, times exp(i k middle).

    `functions` returns the functions of a side (0 or 1) at nodes [m], with up to `waves` [rad/m].
    """
    k = 2 * np.pi * frequency_hz / SOUND_M_S
    z = abs(listener_m[2])
    offsets = []
    shapes = []
    for side, (edge, at) in enumerate(zip(edges_m, listener_m[:2], strict=True)):
        nodes, weights = _panels(edge, at, z, k + waves[side])
        offsets.append(nodes - at)
        shapes.append(weights * functions(side, nodes))
    distance = np.sqrt(np.square(offsets[0])[:, None] + np.square(offsets[1]) + z**2)
    phase = k * (middle_m - distance)
    real = shapes[0] @ (np.cos(phase) / distance) @ shapes[1].T
    imaginary = shapes[0] @ (np.sin(phase) / distance) @ shapes[1].T
    return np.asarray(real + 1j * imaginary)


def _panels(edge: float, at: float, near: float, wave_number: float) -> tuple[Array, Array]:
    """Return nodes and weights [m] of a quadrature in panels that grow away from the listener."""
    reach = near * 2.0 ** np.arange(max(1, np.ceil(np.log2((abs(at) + edge) / near)) + 1))
    inner = np.clip(np.concatenate((at - reach, at + reach)), 0.0, edge)
    ends = np.unique(np.concatenate(([0.0, edge], inner)))
    ends = ends[np.concatenate(([True], np.diff(ends) > 1e-12 * edge))]
    nodes = []
    weights = []
    for left, right in pairwise(ends):
        pieces = int(np.ceil(wave_number * (right - left) / _PANEL_RAD)) or 1
        half = (right - left) / pieces / 2
        u, w = legendre(int(np.ceil(wave_number * half)) + MARGIN)
        middles = left + half * (1 + 2 * np.arange(pieces))
        nodes.append((middles[:, None] + half * u).ravel())
        weights.append(np.tile(half * w, pieces))
    return np.concatenate(nodes), np.concatenate(weights)


@lru_cache(maxsize=32)
def _pressures(plate: RectangularPlate, listener_m: Listener) -> ModePressures:
    """Tabulate the radiation of the modes of a plate at a listener."""
    return mode_pressures((plate.length_m, plate.width_m), plate.orders, listener_m)


# ---- sound power


def power_of_modes(edges_m: Edges, orders: Orders, squares: Array, frequency_hz: Array) -> Array:
    """Return the sound power [W] to one side by mean square modal velocities `squares`, (n, modes).

    Cross terms are left out. On plates of 0.3 x 0.4 m they change third octaves by 0.3 dB at a loss
    factor of 0.01, and by 1.6 dB at 0.1 below coincidence.
    """
    power = np.empty(len(frequency_hz))
    for lines in near_frequencies(edges_m, frequency_hz):
        middle_hz = float(np.mean(frequency_hz[lines]))
        power[lines] = squares[lines] @ _resistances(edges_m, orders, middle_hz)
    return power


def own_resistance(edges_m: Edges, orders: Orders, frequency_hz: Array) -> Array:
    """Return the sound power to one side per mean square velocity [W s2/m2] of each mode.

    Each mode vibrates at a frequency of its own [Hz].
    """
    power = np.empty(len(orders))
    for modes in near_frequencies(None, frequency_hz, OWN_RATIO):
        power[modes] = _resistances(edges_m, orders[modes], float(np.mean(frequency_hz[modes])))
    return power


def near_frequencies(
    edges_m: Edges | None, frequency_hz: Array, ratio: float = _RATIO
) -> Iterator[Orders]:
    """Yield the places of frequencies so near one another that they share directions."""
    width = _SHIFT_RAD * SOUND_M_S / (np.pi * max(edges_m)) if edges_m else np.inf
    near = width / ratio if edges_m else 1e6
    low = np.log(np.clip(frequency_hz / near, 1e-15, 1.0)) / ratio
    number = np.floor(low + np.maximum(frequency_hz - near, 0.0) / width)
    order = np.argsort(number, kind="stable")
    if len(order):
        yield from np.split(order, np.flatnonzero(np.diff(number[order])) + 1)


def _resistances(edges_m: Edges, orders: Orders, frequency_hz: float) -> Array:
    """Return the radiation resistance [W s2/m2] of each mode over a quarter of the half-space."""
    k = 2 * np.pi * frequency_hz / SOUND_M_S
    length_m, width_m = edges_m
    u, weights_u = legendre(int(np.ceil(k * length_m / 2)) + MARGIN)
    v, weights_v = legendre(int(np.ceil(k * width_m / 2)) + MARGIN)
    alpha = np.pi / 4 * (u + 1)
    beta = np.pi / 4 * (v + 1)
    m, rows = np.unique(orders[:, 0], return_inverse=True)
    n, columns = np.unique(orders[:, 1], return_inverse=True)
    along = _squares(m, length_m, k * np.sin(alpha)) * (weights_u * np.cos(alpha))
    across = _squares(n, width_m, k * np.outer(np.cos(alpha), np.sin(beta))) @ weights_v
    share = (along @ across.T)[rows, columns] * np.square(np.pi / 4)
    return np.asarray(AIR_KG_M3 * SOUND_M_S * (k / np.pi) ** 2 * share)


def _squares(order: Orders, edge: float, k: Array) -> Array:
    """Return the squared Fourier transforms [m2] of sines along an edge at wave numbers [rad/m]."""
    phase = k * edge / 2
    k2 = np.square(k)
    waves = np.square(np.sin(phase)), np.square(np.cos(phase))  # of even and odd orders
    squares = np.empty((len(order), *k.shape))
    for row, i in zip(squares, order, strict=True):
        p = i * np.pi / edge
        beyond = p**2 - k2
        close = np.abs(beyond) < 1e-6 * p**2
        row[:] = waves[i % 2] * np.square(2 * p / np.where(close, 1.0, beyond))
        row[close] = (edge / 2) ** 2
    return squares


@lru_cache(maxsize=8)
def _sound_loss(plate: RectangularPlate) -> Array:
    """Return the loss factor of each mode by the sound that it radiates to one side."""
    w = plate.angular_frequency
    edges = plate.length_m, plate.width_m
    resistance = own_resistance(edges, plate.orders, w / (2 * np.pi))
    return np.asarray(resistance / (plate.modal_mass_kg * w))
