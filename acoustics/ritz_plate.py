"""Rectangular plate with free or clamped edges in a baffle: its answer to a force, its sound.

Its modes come from `acoustics.plate_modes`. The shapes are sums of products of functions along both
sides, so the integral of a shape is the same sum of the integrals of products. The sound power of a
mode needs the mean square of its transform over wave vectors of each length, which is tabulated
once for all frequencies.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from acoustics.arrays import Array, refuse_masked
from acoustics.plate_modes import Pair, PlateModes, plate_modes
from acoustics.radiation import AIR_KG_M3, SOUND_M_S, legendre
from acoustics.rectangular_plate import (
    MARGIN,
    MODES_HZ,
    OWN_RATIO,
    PHASE_RAD,
    POINTS,
    SIDES,
    Complex,
    Listener,
    ModePressures,
    RectangularPlate,
    integrals_of_products,
    near_frequencies,
    polynomial_weights,
    tabulated_pressures,
)

# A free plate hangs on, or lies on, something so soft that its rigid-body motions have this natural
# frequency at most, and critical damping.
SUPPORT_HZ = 2.0
_BELOW_BENDING = 20.0  # of the lowest bending mode over that of the rigid-body motions, at least
_SUPPORT_LOSS = 2.0  # loss factor of critical damping
_MANY = 400  # points of a straight path whose shapes are interpolated
_PER_WAVE = 12  # stations of a path in the shortest bending wave; they leave 1e-3
_POINTS_AT_ONCE = 200
_SMALL_RAD = 6.0  # phase of sound along the diagonal of a plate that is small
_BEYOND_TURN = 5.0  # cube roots of a phase by which a degree may exceed it


@dataclass(frozen=True, kw_only=True)
class RitzPlate(RectangularPlate):
    """Thin rectangular plate with edges that are free, clamped or simply supported.

    Rigid-body modes of a free plate are masses on a soft support of SUPPORT_HZ. Everything else is
    as for `RectangularPlate`, whose closed form is faster for four simply supported edges.

    Parameters
    ----------
    poissons_ratio : float. It shapes the modes of a plate with free edges.
    edges : pair of str. free, simply_supported or clamped: the edges at the ends of the length, and
        those at the ends of the width.

    Examples
    --------
    >>> from acoustics.ritz_plate import RitzPlate
    >>> both_free = ("free", "free")
    >>> sides = {"length_m": 0.4, "width_m": 0.3}
    >>> free = RitzPlate(78.5, 18.9e3, 1e-2, **sides, poissons_ratio=0.3, edges=both_free)
    >>> (free.angular_frequency[2:5] / 6.2832).round().tolist()
    [2.0, 276.0, 329.0]
    """

    poissons_ratio: float
    edges: Pair

    @cached_property
    def modes(self) -> PlateModes:
        """Modes of the plate of its side ratio, edges and Poisson's ratio up to MODES_HZ."""
        ratio = float(f"{self.length_m / self.width_m:.12g}")
        highest = 2 * np.pi * MODES_HZ / self.number_unit
        return plate_modes(ratio, self.edges, self.poissons_ratio, float(f"{highest:.12g}"))

    @property
    def number_unit(self) -> float:
        """Angular frequency [rad/s] of the number 1 of a mode."""
        ratio = np.sqrt(self.bending_stiffness_n_m / self.mass_per_area_kg_m2)
        return float(ratio / (self.length_m * self.width_m))

    @property
    def orders(self) -> NDArray[np.int64]:
        """Refuse half waves, which these shapes do not have."""
        raise AttributeError("modes of free or clamped edges have no numbers of half waves")

    @property
    def rigid_modes(self) -> int:
        """Number of rigid-body modes, which come first."""
        return self.modes.rigid

    @cached_property
    def angular_frequency(self) -> Array:
        """Natural angular frequency of each mode, (modes,) [rad/s]."""
        frequency = self.modes.numbers * self.number_unit
        rigid = self.modes.rigid
        if rigid:
            support = 2 * np.pi * SUPPORT_HZ
            if len(frequency) > rigid:
                support = min(support, frequency[rigid] / _BELOW_BENDING)
            frequency[:rigid] = support
        return np.asarray(frequency)

    @cached_property
    def loss_factors(self) -> Array:
        """Loss factor of each mode, in the plate and by its sound to both sides, (modes,)."""
        w = self.angular_frequency
        resistance = np.empty(len(w))
        for modes in near_frequencies(None, w / (2 * np.pi), OWN_RATIO):
            mean_hz = float(np.mean(w[modes])) / (2 * np.pi)
            resistance[modes] = self.resistances(mean_hz)[modes]
        own = self.loss_factor_at(w / (2 * np.pi))
        loss = own + SIDES * resistance / (self.modal_mass_kg * w)
        loss[: self.modes.rigid] = _SUPPORT_LOSS
        return np.asarray(loss)

    def shapes(self, points_m: ArrayLike, modes: slice = slice(None)) -> Array:
        """Return the shape of each mode at points (n, 2) [m], an array (n, modes).

        Many points of a straight path are interpolated between stations of the path.
        """
        refuse_masked("points_m", points_m)
        points = np.atleast_2d(np.asarray(points_m, dtype=float))
        ends = _straight_path(points)
        if ends is None:
            return self._shapes_at(points)[:, modes]
        begin, end = ends
        way = math.dist(begin, end)
        spaces = POINTS + int(np.ceil(_PER_WAVE * way / self.bending_wavelength_m(MODES_HZ)))
        table = _stations(self, tuple(begin.tolist()), tuple(end.tolist()), spaces)[:, modes]
        place = (points - begin) @ (end - begin) / way**2 * spaces
        first, weights = polynomial_weights(np.clip(place, 0.0, spaces), spaces + 1)
        shapes = np.zeros((len(points), table.shape[1]))
        for k in range(POINTS):
            shapes += weights[:, k, None] * table[first + k]
        return shapes

    def _shapes_at(self, points: Array) -> Array:
        """Return the shapes at points, a block at a time."""
        unit = 2 * points / (self.length_m, self.width_m) - 1
        blocks = np.array_split(unit, max(1, len(unit) // _POINTS_AT_ONCE))
        return np.concatenate([self.modes.shapes(block[:, 0], block[:, 1]) for block in blocks])

    def residual_compliance_m_n(self, point_m: ArrayLike) -> float:
        """Return the static compliance [m/N] of the modes above MODES_HZ, as a mean over points."""
        return float(self.mobility_s_kg / (np.pi**2 * MODES_HZ))

    # ---- sound

    def mode_pressures(self, listener_m: Listener) -> ModePressures:
        """Return Rayleigh's integrals of the modes at a listener, over frequency."""
        return _pressures(self, listener_m)

    def _power(self, squares: Array, frequency_hz: NDArray[Any]) -> Array:
        """Return the sound power [W] to one side by mean square modal velocities, (n, modes)."""
        power = np.empty(len(frequency_hz))
        for lines in near_frequencies((self.length_m, self.width_m), frequency_hz):
            middle_hz = float(np.mean(frequency_hz[lines]))
            power[lines] = squares[lines] @ self.resistances(middle_hz)
        return power

    def resistances(self, frequency_hz: float) -> Array:
        """Return the radiation resistance [W s2/m2] of each mode at a frequency."""
        k = 2 * np.pi * frequency_hz / SOUND_M_S
        diagonal = np.hypot(self.length_m, self.width_m)
        u, weights = legendre(int(np.ceil(k * diagonal / 2)) + MARGIN)
        angle = np.pi / 4 * (u + 1)
        if k * diagonal < _SMALL_RAD:  # the squares rise too steeply for a table
            squares = np.array([self._squares_of_waves(k * sine) for sine in np.sin(angle)])
            share = (np.pi / 4 * weights * np.sin(angle)) @ squares
            return np.asarray(AIR_KG_M3 * SOUND_M_S * (k / np.pi) ** 2 * share)
        step, table = self._wave_squares
        place = np.clip(k * np.sin(angle) / step, 0.0, len(table) - 1.0)
        first, shares = polynomial_weights(place, len(table))
        of_rows = np.zeros(len(table))
        columns = first[:, None] + np.arange(shares.shape[1])
        np.add.at(of_rows, columns, (np.pi / 4 * weights * np.sin(angle))[:, None] * shares)
        return np.asarray(AIR_KG_M3 * SOUND_M_S * (k / np.pi) ** 2 * (of_rows @ table))

    @cached_property
    def _wave_squares(self) -> tuple[float, Array]:
        """Tabulate the squared transform of each mode, as an integral over a quarter turn [m4].

        It is over even lengths of wave vectors, whose step [rad/m] comes first; (lengths, modes).
        """
        edges = (self.length_m, self.width_m)
        diagonal = float(np.hypot(*edges))
        highest = 2 * np.pi * MODES_HZ / SOUND_M_S
        step = PHASE_RAD / diagonal
        rows = int(np.ceil(highest / step)) + MARGIN
        table = np.array([self._squares_of_waves(step * row) for row in range(rows)])
        return step, table

    @cached_property
    def _single_coefficients(self) -> list[NDArray[np.float32]]:
        """Coefficients of each family in single precision, which leaves 1e-7 of a loss factor.

        It takes half of the time of double precision.
        """
        return [family.coefficients.astype(np.float32) for family in self.modes.families]

    def _squares_of_waves(self, k: float) -> Array:
        """Return the squared transform of each mode over waves of a length, (modes,) [m4].

        It is an integral over a quarter turn of the wave vector, whose length is k [rad/m].
        """
        edges = (self.length_m, self.width_m)
        u, weights = legendre(int(np.ceil(k * np.hypot(*edges) / 2)) + MARGIN)
        angle = np.pi / 4 * (u + 1)
        waves = (k * np.cos(angle) * edges[0] / 2, k * np.sin(angle) * edges[1] / 2)
        transforms = [
            side.transforms(wave) for side, wave in zip(self.modes.sides, waves, strict=True)
        ]
        # A function of high degree has nothing of long waves: its transform is a Bessel function
        # beyond its turn.
        phases = [k * edge / 2 for edge in edges]
        most = [phase + _BEYOND_TURN * np.cbrt(phase) + MARGIN for phase in phases]
        squares = np.empty(self.mode_count)
        for family, single in zip(self.modes.families, self._single_coefficients, strict=True):
            within = np.ix_(family.along < most[0], family.across < most[1])
            coefficients = single[within]
            x = transforms[0][family.along[family.along < most[0]]]
            y = transforms[1][family.across[family.across < most[1]]]
            products = (x[:, None] * y).astype(np.float32)
            functions = products.shape[0] * products.shape[1]
            amplitudes = products.reshape(functions, -1).T @ coefficients.reshape(functions, -1)
            squares[family.modes] = np.pi / 4 * weights @ np.square(amplitudes)
        return squares * (edges[0] * edges[1] / 4) ** 2


def _straight_path(points: Array) -> tuple[Array, Array] | None:
    """Return the ends of a straight path of many points (n, 2) [m], None for others."""
    if len(points) < _MANY:
        return None
    away = points - points[0]
    direction = away[int(np.argmax(np.sum(np.square(away), axis=1)))]
    way = float(np.hypot(*direction))
    if way == 0:
        return None
    beside = away[:, 0] * direction[1] - away[:, 1] * direction[0]
    if np.abs(beside).max() > 1e-9 * way**2:
        return None
    passed = away @ direction / way**2
    return points[0] + passed.min() * direction, points[0] + passed.max() * direction


@lru_cache(maxsize=4)
def _stations(
    plate: RitzPlate, begin: tuple[float, ...], end: tuple[float, ...], spaces: int
) -> Array:
    """Return the shapes at stations at equal distances between two points [m]."""
    share = np.linspace(0, 1, spaces + 1)[:, None]
    return plate._shapes_at(np.array(begin) + share * (np.array(end) - np.array(begin)))


@lru_cache(maxsize=32)
def _pressures(plate: RitzPlate, listener_m: Listener) -> ModePressures:
    """Tabulate the radiation of the modes of a plate at a listener."""
    edges = (plate.length_m, plate.width_m)
    modes = plate.modes
    waves = [np.pi * side.count / edge for side, edge in zip(modes.sides, edges, strict=True)]

    def functions(side: int, nodes: Array) -> Array:
        return np.asarray(modes.sides[side].values(2 * nodes / edges[side] - 1)[0])

    def integrals(middle_m: float, frequency_hz: float) -> Complex:
        products = integrals_of_products(
            edges, waves, functions, listener_m, middle_m, frequency_hz
        )
        result = np.empty(plate.mode_count, dtype=complex)
        for family in modes.families:
            own = products[np.ix_(family.along, family.across)].ravel()
            coefficients = family.coefficients.reshape(len(own), -1)
            result[family.modes] = own @ coefficients
        return result

    return tabulated_pressures(edges, listener_m, integrals)
