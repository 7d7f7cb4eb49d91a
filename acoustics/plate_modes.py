"""Modes of thin rectangular plates whose edges are free, simply supported or clamped.

Rayleigh and Ritz: a shape is a sum of products of associated Legendre functions along both sides,
whose order fulfils what the edges demand of a shape, and which are orthonormal. Free edges take
Legendre polynomials themselves. The bending energy then is a matrix, and its eigenvectors are the
shapes. The four symmetries (even or odd along each side) are solved one by one.

The energy of the highest functions is so large that the lowest eigenvalues would drown in its
rounding. So the inverse of the matrix is solved, whose largest eigenvalues are the lowest modes.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array, short_repr
from acoustics.radiation import legendre

Pair = tuple[str, str]
FREE = "free"
SIMPLE = "simply_supported"
CLAMPED = "clamped"
# Power of 1 - x^2 in each function: it makes the shape, and its slope, vanish at clamped edges.
POWERS = {FREE: 0, SIMPLE: 1, CLAMPED: 2}
_HALF_WAVES = math.pi / 2  # functions for a half wave of the shortest bending wave
_MORE = 8  # functions beyond these
_CORNER = 1.0  # sum of squared shares of the highest orders along both sides, at most


@dataclass(frozen=True, eq=False)
class SideFunctions:
    """Functions along a side, x from -1 to 1: even, odd, even and so on, orthonormal.

    Function i is the associated Legendre function of degree i + 2k and order 2k, where k = 0 at
    free ends, 1 at simply supported and 2 at clamped ones. It is (1 - x^2)^k times a polynomial,
    by the recurrence of Gegenbauer's polynomials.
    """

    __repr__ = short_repr

    kind: str
    count: int

    def values(self, x: Array, derivatives: int = 0) -> Array:
        """Return functions and their derivatives, (1 + derivatives, count, points)."""
        power = POWERS[self.kind]
        x = np.asarray(x, dtype=float)
        polynomials = np.zeros((3, self.count, *x.shape))
        start = math.sqrt(_constant_weight(power))
        polynomials[0, 0] = start
        before = 0.0
        for i in range(1, self.count):
            factor = _recurrence(i, power)
            for order in range(derivatives + 1):
                value = x * polynomials[order, i - 1]
                if order > 0:
                    value = value + order * polynomials[order - 1, i - 1]
                if i > 1:
                    value = value - before * polynomials[order, i - 2]
                polynomials[order, i] = value / factor
            before = factor
        if power == 0:
            return polynomials[: derivatives + 1]
        edge = 1 - np.square(x)
        # (1 - x^2)^k and its derivatives
        weight = edge**power
        first = -2 * power * x * edge ** (power - 1)
        second = -2 * power * edge ** (power - 1)
        if power > 1:
            second = second + 4 * power * (power - 1) * np.square(x) * edge ** (power - 2)
        value, slope, curvature = polynomials
        products = [
            weight * value,
            first * value + weight * slope,
            second * value + 2 * first * slope + weight * curvature,
        ]
        return np.array(products[: derivatives + 1])

    def transforms(self, waves: Array) -> Array:
        """Return integrals of the functions with cos (even ones) or sin (odd ones), (count, n).

        `waves` are phases [rad] over half a side.
        """
        most = float(np.max(np.abs(waves), initial=0.0))
        nodes, weights = legendre(math.ceil((self.count + most) / 2) + _MORE)
        functions = self.values(nodes)[0] * weights
        phase = nodes[:, None] * waves
        result = np.empty((self.count, len(waves)))
        result[::2] = functions[::2] @ np.cos(phase)
        result[1::2] = functions[1::2] @ np.sin(phase)
        return result


def _constant_weight(power: int) -> float:
    """Return the square of the constant c for which c (1 - x^2)^k has the norm 1."""
    return math.gamma(2 * power + 1.5) / (math.sqrt(math.pi) * math.gamma(2 * power + 1))


def _recurrence(i: int, power: int) -> float:
    """Return b_i of x p_(i-1) = b_i p_i + b_(i-1) p_(i-2), orthonormal for (1 - x^2)^(2k)."""
    shift = 2 * power
    return math.sqrt(i * (i + 2 * shift) / ((2 * i + 2 * shift) ** 2 - 1))


class _SideEnergies(NamedTuple):
    """Integrals over a side of products of functions and derivatives, (count, count)."""

    curvatures: Array  # f'' f''
    slopes: Array  # f' f'
    value_curvature: Array  # f f''


class Family(NamedTuple):
    """Modes of one symmetry, with the functions that make their shapes."""

    along: NDArray[np.int64]  # functions along the length, (functions,)
    across: NDArray[np.int64]  # functions along the width, (functions,)
    modes: NDArray[np.int64]  # places of these modes among all, (modes,)
    coefficients: Array  # (functions along, functions across, modes)


@dataclass(frozen=True, eq=False)
class PlateModes:
    """Modes of a plate of the area 1 by rising frequency; rigid-body modes come first.

    `numbers` has w a b sqrt(m''/B) of each mode, 0 of a rigid body. The mean square of a shape is
    1/4, as that of a product of sines.
    """

    __repr__ = short_repr

    sides: tuple[SideFunctions, SideFunctions]
    numbers: Array  # (modes,)
    families: tuple[Family, ...]

    @cached_property
    def rigid(self) -> int:
        """Number of rigid-body modes."""
        return int(np.sum(self.numbers == 0))

    def shapes(self, along: Array, across: Array, modes: slice = slice(None)) -> Array:
        """Return the shapes at points, -1 to 1 along both sides, (points, modes)."""
        x = self.sides[0].values(along)[0]
        y = self.sides[1].values(across)[0]
        shapes = np.empty((x.shape[1], len(self.numbers)))
        for family in self.families:
            around = np.einsum("ijm,jp->ipm", family.coefficients, y[family.across], optimize=True)
            shapes[:, family.modes] = np.einsum("ip,ipm->pm", x[family.along], around)
        return shapes[:, modes]


@lru_cache(maxsize=8)
def plate_modes(ratio: float, edges: Pair, poisson: float, highest: float) -> PlateModes:
    """Return the modes of a plate up to a number w a b sqrt(m''/B).

    Parameters
    ----------
    ratio : float. Length over width.
    edges : pair of str. free, simply_supported or clamped: of the two edges at the ends of the
        length, and of the two at the ends of the width.
    poisson : float. Poisson's ratio.
    highest : float. Highest number of a mode.

    References
    ----------
    A. W. Leissa, The free vibration of rectangular plates, J. Sound Vib. 31 (1973) 257.

    Examples
    --------
    >>> from acoustics.plate_modes import plate_modes
    >>> plate_modes(1.0, ("free", "free"), 0.3, 40.0).numbers.round(2).tolist()
    [0.0, 0.0, 0.0, 13.47, 19.6, 24.27, 34.8, 34.8]
    """
    # Sides over the root of the area.
    lengths = (math.sqrt(ratio), 1 / math.sqrt(ratio))
    wave = math.sqrt(highest)  # wave number of the shortest bending wave
    counts = [math.ceil(_HALF_WAVES * wave * length / math.pi) + _MORE for length in lengths]
    sides = (SideFunctions(edges[0], counts[0]), SideFunctions(edges[1], counts[1]))
    energies = [_side_energies(side, length) for side, length in zip(sides, lengths, strict=True)]
    solved = []
    for even_along, even_across in product((0, 1), repeat=2):
        along = np.arange(even_along, counts[0], 2)
        across = np.arange(even_across, counts[1], 2)
        numbers, shapes = _solve(along, across, counts, energies, poisson, highest)
        solved.append((along, across, numbers, shapes))
    all_numbers = np.concatenate([numbers for _, _, numbers, _ in solved])
    order = np.argsort(all_numbers, kind="stable")
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    families = []
    first = 0
    for along, across, numbers, shapes in solved:
        places = rank[first : first + len(numbers)]
        families.append(Family(along, across, places, shapes))
        first += len(numbers)
    return PlateModes(sides=sides, numbers=all_numbers[order], families=tuple(families))


def _side_energies(side: SideFunctions, length: float) -> _SideEnergies:
    """Return the integrals of the functions of a side of a length."""
    nodes, weights = legendre(side.count + 2 * POWERS[side.kind] + 1)
    value, slope, curvature = side.values(nodes, derivatives=2)
    stretch = 2 / length
    return _SideEnergies(
        curvatures=stretch**4 * (curvature * weights) @ curvature.T,
        slopes=stretch**2 * (slope * weights) @ slope.T,
        value_curvature=stretch**2 * (value * weights) @ curvature.T,
    )


def _solve(
    along: NDArray[np.int64],
    across: NDArray[np.int64],
    counts: list[int],
    energies: list[_SideEnergies],
    poisson: float,
    highest: float,
) -> tuple[Array, Array]:
    """Return numbers and coefficients of the modes of one symmetry up to a number."""
    from scipy.linalg import cho_factor, cho_solve, eigh  # slow to import

    i, j = np.meshgrid(along, across, indexing="ij")
    kept = (i / counts[0]) ** 2 + (j / counts[1]) ** 2 <= _CORNER
    i = i[kept]
    j = j[kept]
    rows = np.ix_(i, i)
    columns = np.ix_(j, j)
    x, y = energies
    energy = x.curvatures[rows] * (j[:, None] == j)
    energy += y.curvatures[columns] * (i[:, None] == i)
    mixed = x.value_curvature[rows] * y.value_curvature.T[columns]
    energy += poisson * (mixed + mixed.T)
    energy += 2 * (1 - poisson) * x.slopes[rows] * y.slopes[columns]
    bends = np.any(energy != 0, axis=1)  # the others are rigid-body motions
    scale = np.sqrt(np.diag(energy)[bends])
    scaled = energy[np.ix_(bends, bends)] / scale / scale[:, None]
    inverse = cho_solve(cho_factor(scaled, lower=True), np.eye(len(scale))) / scale / scale[:, None]
    values, vectors = eigh((inverse + inverse.T) / 2, subset_by_value=(highest**-2, np.inf))
    numbers = np.concatenate((np.zeros(int(np.sum(~bends))), 1 / np.sqrt(values[::-1])))
    all_vectors = np.zeros((len(i), len(numbers)))
    all_vectors[np.flatnonzero(~bends), np.arange(int(np.sum(~bends)))] = 1.0
    all_vectors[bends, int(np.sum(~bends)) :] = vectors[:, ::-1]
    coefficients = np.zeros((*kept.shape, len(numbers)))
    coefficients[kept] = all_vectors
    return numbers, coefficients
