"""The form that a measurement is described without, decided from its heights."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.surface.form import round_form, thinned
from rolling.surface.parameters import about_mean, without_plane

LARGE_REST = 0.5  # of what a form leaves, from which on a higher polynomial is named
LEAST_FORM = 0.05  # of the variance that a plane leaves, from which on a form is removed
# Terms beyond the plane that each form has, of a map and of a profile.
_TERMS = {"sphere": 1, "cylinder": 2, "quadratic": 3}
_TERMS_OF_PROFILE = {"quadratic": 1, "cylinder": 1}
# Each term of a form takes so many times the variance that a term of second order takes by chance.
# As a criterion of information it is the penalty on each term, in units of that variance; that of
# Schwarz is the logarithm of the number of independent heights, 7 to 12 here. It is larger, because
# few higher orders tell the chance of a lay. Between forms that of Akaike counts, as some form is
# there. tests/benchmarks/form_study.py counts what is chosen.
BEYOND_CHANCE = 20.0
AMONG_FORMS = 2.0
_HIGHEST_ORDER = 8  # of the polynomials that show what chance makes
_LEAST_NODES = 12  # of a side, below which no form is told from waves
_MOST_NODES = 5_000  # of the means of blocks that are looked at
# Waves that fit into a field, and the least number of them that is no form.
_WAVES = np.arange(0.5, 3.01, 0.05)
_MOST_WAVES = 0.95
_TERMS_OF_WAVES = 5  # cosine and sine along both axes, and the wavelength


class ChosenForm(NamedTuple):
    """Form to remove, a value of the key `surface.level`, and the reason."""

    level: str
    reason: str


class _Field(NamedTuple):
    """Means of blocks of heights, on which the forms are compared.

    grid : (m, n) array, m. As they are; NaN where unmeasured.
    steps : (2,) sequence of float, m. Spacings of the blocks.
    known : (2,) tuple of (count,) arrays. Indices of the measured ones.
    axes : list of (count,) arrays. Their places along each axis, from -1 to 1; a profile has one.
    z : (count,) array. Their heights less their plane, whose mean square is 1.
    size : float, m. Root of that mean square in metres.
    """

    grid: Array
    steps: Sequence[float]
    known: tuple[NDArray[np.int64], ...]
    axes: list[Array]
    z: Array
    size: float

    @property
    def plane(self) -> list[Array]:
        """The terms of a plane."""
        return [np.ones_like(self.z), *self.axes]


def chosen_form(heights: Array, steps: Sequence[float] = (1.0, 1.0)) -> ChosenForm:
    """Choose the F-operation for heights [m] (along, across), NaN where unmeasured.

    Sphere, cylinder and polynomial of second order are compared with the plane by a criterion of
    information: the variance that is left, in units of what a term of second order takes by chance,
    and a penalty on each term. Chance is told by the higher orders, whose terms fall with the order
    as those of random waves do. Waves up to the length of the field are no form.

    Parameters
    ----------
    heights : (along, across) array, m
    steps : (2,) sequence of float, m
        Spacings along and across.
    """
    sides = [count for count in heights.shape if count > 1]
    if min(sides, default=1) < _LEAST_NODES:
        return ChosenForm("plane", "too few nodes tell a form from waves")
    field = _field(heights, steps)
    if field is None:
        return ChosenForm("plane", "the scan has no more than a plane")
    terms = _TERMS_OF_PROFILE if len(sides) == 1 else _TERMS
    rests = {name: _rest(field, name) for name in terms}
    left = {name: float(np.mean(rest**2)) for name, rest in rests.items()}
    nearest = min(left, key=lambda name: left[name])
    share = f"{rounded(100 * (1 - left[nearest]), 2)} % of the variance"
    if 1 - left[nearest] < LEAST_FORM:
        return ChosenForm("plane", f"second order would take {share} that a plane leaves")
    chance = _chance(field, rests[nearest])
    best = min(terms, key=lambda name: left[name] + AMONG_FORMS * chance * terms[name])
    score = left[best] + BEYOND_CHANCE * chance * terms[best]
    if score > 1:
        reason = f"second order would take {share}, and so do random waves, as higher orders show"
        return ChosenForm("plane", reason)
    waves, left_by_waves = _nearest_waves(field)
    if waves >= _MOST_WAVES and left_by_waves + BEYOND_CHANCE * chance * _TERMS_OF_WAVES < score:
        reason = (
            f"second order would take {share}, but waves of which {waves:.2g} fit in are nearer"
        )
        return ChosenForm("plane", reason)
    return ChosenForm(best, _reason(best, left) + _hint(field, rests[best]))


def _field(heights: Array, steps: Sequence[float]) -> _Field | None:
    """Return the means of blocks of heights; None where nothing but a plane is there."""
    few = thinned(heights, _MOST_NODES)
    grid = about_mean(few.heights)
    known = np.nonzero(~np.isnan(grid))
    z = without_plane(grid)[known]
    size = float(np.sqrt(np.mean(z**2)))
    if not size > 0:
        return None
    places = (few.along, few.across)
    axes = [
        place[index] / max(float(np.abs(place).max()), 0.5)
        for place, index in zip(places, known, strict=True)
        if len(place) > 1
    ]
    block = [
        float(place[1] - place[0]) * step if len(place) > 1 else step
        for place, step in zip(places, steps, strict=True)
    ]
    return _Field(grid=grid, steps=block, known=known, axes=axes, z=z / size, size=size)


def _rest(field: _Field, name: str) -> Array:
    """Return what a form with its tilt leaves of the heights of a field."""
    if name == "quadratic":
        return _without(field.z, _terms(field.axes, 2))
    form = round_form(field.grid, field.steps, name)
    return _without((field.grid - form.heights)[field.known] / field.size, field.plane)


def _without(z: Array, terms: list[Array]) -> Array:
    """Return heights less the terms of least squares."""
    table = np.stack(terms, axis=1)
    return np.asarray(z - table @ np.linalg.lstsq(table, z)[0])


def _terms(axes: list[Array], order: int) -> list[Array]:
    """Return polynomials of the places up to an order, sorted by it."""
    lines = [np.polynomial.legendre.legvander(axis, order).T for axis in axes]
    if len(lines) == 1:
        return [*lines[0]]
    x, y = lines
    return [x[i] * y[total - i] for total in range(order + 1) for i in range(total + 1)]


def _chance(field: _Field, rest: Array) -> float:
    """Return the share of the variance that a term of second order takes by chance.

    It follows from the largest term of each order from 3 on, because a lay has its waves in few of
    them, of what a form leaves. Terms of random waves fall as a power of the order, which is fitted
    on a map. A profile has one term an order, too few for a power, so that the mean counts.
    """
    basis = np.linalg.qr(np.stack(_terms(field.axes, _HIGHEST_ORDER), axis=1))[0]
    shares = (basis.T @ rest) ** 2 / len(rest)
    is_profile = len(field.axes) == 1
    orders = np.arange(3, _HIGHEST_ORDER + 1)
    firsts = orders if is_profile else orders * (orders + 1) // 2
    counts = np.ones_like(orders) if is_profile else orders + 1
    largest = np.array(
        [shares[first : first + count].max() for first, count in zip(firsts, counts, strict=True)]
    )
    mean = float(np.mean(largest[:3]))
    if is_profile or not mean > 0:
        return mean
    logs = np.log(np.maximum(largest, 1e-12 * mean))
    _, level = np.polyfit(np.log(orders / 2), logs, 1, w=np.sqrt(counts))
    return max(mean, math.exp(level))


def _nearest_waves(field: _Field) -> tuple[float, float]:
    """Return how many waves in the field are nearest to its heights, and the share they leave.

    The waves lie along the axes of the second order, with one wavelength in both.
    """
    axes = field.axes
    if len(axes) == 2:
        x, y = axes
        factors = np.linalg.lstsq(np.stack(_terms(axes, 2), axis=1), field.z)[0]
        turned = np.linalg.eigh([[3 * factors[3 + 2], factors[4]], [factors[4], 3 * factors[3]]])[1]
        axes = [turned[0, i] * x + turned[1, i] * y for i in (0, 1)]
        axes = [axis / np.abs(axis).max() for axis in axes]
    left = []
    for waves in _WAVES:
        terms = field.plane
        for axis in axes:
            terms += [np.cos(np.pi * waves * axis), np.sin(np.pi * waves * axis)]
        left.append(float(np.mean(_without(field.z, terms) ** 2)))
    nearest = int(np.argmin(left))
    return float(_WAVES[nearest]), left[nearest]


def _hint(field: _Field, rest: Array) -> str:
    """Name a polynomial that takes most of what a form leaves; waves of the field look like it."""
    higher = float(np.mean(_without(rest, _terms(field.axes, 4)) ** 2))
    share = 1 - higher / (float(np.mean(rest**2)) or 1.0)
    if share < LARGE_REST:
        return ""
    return (
        f"; the fourth order would take {rounded(100 * share, 2)} % of the rest: set surface.level"
        " polynomial-4 if that is form and no waviness"
    )


def _reason(best: str, left: dict[str, float]) -> str:
    """Say why a form is removed, and what the others would leave."""
    words = {"quadratic": "second order", "cylinder": "a cylinder", "sphere": "a sphere"}
    share = f"{words[best]} takes {rounded(100 * (1 - left[best]), 4)} % of the variance"
    others = [
        f"{words[name]} {rounded(100 * (1 - left[name]), 4)} %" for name in left if name != best
    ]
    return f"{share} that a plane leaves, {', '.join(others)}, and is longer than the field"
