"""Forms of measured heights by least squares: polynomials, spheres and cylinders."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import si

# Forms by the values of the key `surface.level`, and the order of those that are polynomials.
ORDERS = {"quadratic": 2} | {f"polynomial-{order}": order for order in range(3, 9)}
ROUND = ("cylinder", "sphere")
_MOST_NODES = 20_000  # of the block means that a round form is fitted to
_MOST_TRIALS = 60  # of the parameters; roughness alone has no nearest form
_NODES_AT_ONCE = 1_000_000
_CHANGE = 1e-5  # of a parameter in its unit, for the slopes
_LEAST_CAP = 1e-9  # square of the cosine at which a round form ends


class RoundForm(NamedTuple):
    """Sphere or cylinder of least squares.

    heights : (along, across) array, m. Form at all nodes, about its mean.
    curvature : float, 1/m. Inverse of the radius, positive where the middle lies lowest.
    axis_deg : float or None. Direction of the axis of a cylinder, from the track towards positive
        y, from -90 to 90; None of a sphere.
    """

    heights: Array
    curvature: float
    axis_deg: float | None

    @property
    def words(self) -> str:
        """The form in words."""
        name = "sphere" if self.axis_deg is None else "cylinder"
        if self.curvature == 0:
            return f"{name} without curvature"
        side = "hollow" if self.curvature > 0 else "convex"
        text = f"{name}, {side}, radius {si(1 / abs(self.curvature), 'm')}"
        if self.axis_deg is not None:
            text += f", axis at {self.axis_deg:.0f} degrees to the track"
        return text


class Thinned(NamedTuple):
    """Means of blocks of heights, and the places of their middles.

    heights : (m, n) array, m. NaN where a block has no measured node.
    along : (m,) array; across : (n,) array, nodes. About the middle of all heights.
    """

    heights: Array
    along: Array
    across: Array


def thinned(heights: Array, most: int) -> Thinned:
    """Return the means of equal blocks of heights, so that there are at most about so many.

    Means see no lay that a stride would fold onto long waves. NaN is unmeasured.
    """
    block = max(1, math.ceil(math.sqrt(heights.size / most)))
    sizes = [min(block, count) for count in heights.shape]
    counts = [count // size for count, size in zip(heights.shape, sizes, strict=True)]
    kept = heights[: counts[0] * sizes[0], : counts[1] * sizes[1]]
    blocks = kept.reshape(counts[0], sizes[0], counts[1], sizes[1])
    known = (~np.isnan(blocks)).sum(axis=(1, 3))
    sums = np.nansum(blocks, axis=(1, 3))
    means = np.where(known > 0, sums / np.maximum(known, 1), np.nan)
    places = [
        size * np.arange(number) + (size - 1) / 2 - (count - 1) / 2
        for size, number, count in zip(sizes, counts, heights.shape, strict=True)
    ]
    return Thinned(means, places[0], places[1])


def polynomial(heights: Array, order: int) -> Array:
    """Return the least-squares polynomial of heights [m], without its constant.

    Its terms x^i y^j have i + j up to the order. On a grid orthonormal polynomials of each axis
    give it without a system of equations. With unmeasured nodes, NaN, it is that of means of
    blocks.
    """
    if np.isnan(heights).any():
        return _polynomial_past_gaps(heights, order)
    bases = []
    for count in heights.shape:
        places = np.linspace(-1.0, 1.0, count) if count > 1 else np.zeros(1)
        powers = np.polynomial.legendre.legvander(places, min(order, count - 1))
        bases.append(np.linalg.qr(powers)[0])
    along, across = bases
    factors = along.T @ heights @ across
    orders = np.add.outer(np.arange(along.shape[1]), np.arange(across.shape[1]))
    factors[orders > order] = 0.0
    factors[0, 0] = 0.0
    return np.asarray(along @ factors @ across.T)


def _polynomial_past_gaps(heights: Array, order: int) -> Array:
    """Return the polynomial of least squares of heights with unmeasured nodes, at all nodes."""
    few = thinned(heights, _MOST_NODES)
    known = ~np.isnan(few.heights)
    ends = [max((count - 1) / 2, 0.5) for count in heights.shape]
    orders = [(i, total - i) for total in range(order + 1) for i in range(total + 1)]
    along = np.polynomial.legendre.legvander(few.along / ends[0], order)
    across = np.polynomial.legendre.legvander(few.across / ends[1], order)
    terms = np.stack([np.multiply.outer(along[:, i], across[:, j])[known] for i, j in orders], -1)
    factors = np.zeros((order + 1, order + 1))
    factors[tuple(np.transpose(orders))] = np.linalg.lstsq(terms, few.heights[known])[0]
    places = [_centred(count) / end for count, end in zip(heights.shape, ends, strict=True)]
    form = np.polynomial.legendre.leggrid2d(places[0], places[1], factors)
    return np.asarray(form - form.mean())


def round_form(heights: Array, steps: Sequence[float], name: str) -> RoundForm:
    """Fit a sphere or a cylinder of any position to heights, by least squares of the heights.

    Parameters
    ----------
    heights : (along, across) array, m
        Heights about some mean; NaN where unmeasured.
    steps : (2,) sequence of float, m
        Spacings along and across.
    name : str
        "sphere" or "cylinder".

    Returns
    -------
    RoundForm
        The fit also has the tilt of the heights.
    """
    from scipy import optimize

    few = thinned(heights, _MOST_NODES)
    places = np.nonzero(~np.isnan(few.heights))
    x = few.along[places[0]] * steps[0]
    y = few.across[places[1]] * steps[1]
    length = max(float(np.hypot(x, y).max()), min(steps))
    x = x / length
    y = y / length
    z = few.heights[places] / length
    start = _start(x, y, z, name == "cylinder")
    size = float(np.abs(start[:4]).max())
    axis_deg = None if len(start) == 4 else 0.0
    if not size > 0:
        return RoundForm(np.zeros(heights.shape), 0.0, axis_deg)
    units = np.where(np.arange(len(start)) < 4, size, 1.0)  # the turn has none

    def rest(values: Array) -> Array:
        """Return what a form leaves, in units of the size."""
        return np.asarray((_round_heights(units * values, x, y) - z) / size)

    fit = optimize.least_squares(
        rest,
        start / units,
        jac="3-point",
        x_scale="jac",
        xtol=1e-10,
        ftol=1e-10,
        gtol=1e-10,
        max_nfev=_MOST_TRIALS,
    )
    nearest = units * fit.x
    along = _centred(heights.shape[0])[:, None] * steps[0] / length
    across = _centred(heights.shape[1]) * steps[1] / length
    if few.heights.size < heights.size:
        nearest = nearest + _improvement(nearest, units, along, across, heights / length)
    form = length * _round_heights(nearest, along, across)
    if axis_deg is not None:
        axis_deg = (math.degrees(nearest[4]) + 90.0) % 180.0 - 90.0
    return RoundForm(form - form.mean(), float(nearest[3] / length), axis_deg)


def _centred(count: int) -> Array:
    """Return the places of nodes about their middle."""
    return np.arange(count, dtype=np.float64) - (count - 1) / 2


def _start(x: Array, y: Array, z: Array, is_cylinder: bool) -> Array:
    """Return height, slopes and curvature of a sphere, and the turn of a cylinder, nearly.

    They are those of the polynomial of second order. The axis of a cylinder lies along its smaller
    curvature.
    """
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    factors = np.linalg.lstsq(terms, z)[0]
    curvatures, axes = np.linalg.eigh([[2 * factors[3], factors[4]], [factors[4], 2 * factors[5]]])
    if not is_cylinder:
        return np.append(factors[:3], np.mean(curvatures))
    most = int(np.argmax(np.abs(curvatures)))
    straight = axes[:, 1 - most]
    turn = math.atan2(straight[1], straight[0])
    return np.append(factors[:3], [curvatures[most], turn])


def _improvement(nearest: Array, units: Array, along: Array, across: Array, z: Array) -> Array:
    """Return the step of Gauss and Newton over all nodes, after a fit to means of blocks.

    Means of a curved form lie off it by the fourth order of the size of a block.
    """
    count = len(nearest)
    squares = np.zeros((count, count))
    sums = np.zeros(count)
    rows = max(1, _NODES_AT_ONCE // z.shape[1])
    for first in range(0, len(z), rows):
        part = slice(first, first + rows)
        known = ~np.isnan(z[part])
        gap = (z[part] - _round_heights(nearest, along[part], across))[known]
        slopes = []
        for at in range(count):
            change = np.where(np.arange(count) == at, _CHANGE * units, 0.0)
            above = _round_heights(nearest + change, along[part], across)
            below = _round_heights(nearest - change, along[part], across)
            slopes.append((above - below)[known] / (2 * _CHANGE))
        table = np.stack(slopes)
        squares += table @ table.T
        sums += table @ gap
    return np.asarray(units * np.linalg.lstsq(squares, sums)[0])


def _round_heights(form: Array, x: Array, y: Array) -> Array:
    """Return the heights of a form at places: of a sphere, or of a cylinder with a turn.

    A point X at the distance 1/k from the middle of a sphere fulfils k X.X = 2 n.X, with the normal
    n and the curvature k at the origin. Of a cylinder the part of X along its axis d, which is
    square to n, does not count: k (X.X - (X.d)^2) = 2 n.X. Either is an equation of second degree
    for the height. Lengths are in any one unit.
    """
    height, slope_x, slope_y, curvature = form[:4]
    upright = 1 / math.sqrt(1 + slope_x**2 + slope_y**2)
    normal = -slope_x * upright, -slope_y * upright
    radial = x * x + y * y
    square: float | Array = curvature
    middle: float | Array = upright
    if len(form) > 4:
        axis = np.array([math.cos(form[4]), math.sin(form[4]), 0.0])
        axis[2] = slope_x * axis[0] + slope_y * axis[1]
        axis /= np.linalg.norm(axis)
        beside = x * axis[0] + y * axis[1]
        radial = radial - beside**2
        square = curvature * (1 - axis[2] ** 2)
        middle = upright + curvature * axis[2] * beside
    constant = curvature * radial - 2 * (normal[0] * x + normal[1] * y)
    root = np.sqrt(np.maximum(middle**2 - square * constant, _LEAST_CAP))
    return np.asarray(height + constant / (middle + root))


def has_curved_form(level: str) -> bool:
    """Tell whether a value of the key `surface.level` names a form beyond a plane."""
    return level in ORDERS or level in ROUND


def named_form(heights: Array, steps: Sequence[float], name: str) -> tuple[Array, str]:
    """Return a form of heights by the value of the key `surface.level`, and its words."""
    if name in ORDERS:
        order = ORDERS[name]
        words = "second order" if order == 2 else f"polynomial of order {order}"
        return polynomial(heights, order), words
    fit = round_form(heights, steps, name)
    return fit.heights, fit.words
