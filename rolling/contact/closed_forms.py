"""Closed forms of smooth elastic contact in SI, independent of the solver.

Source of the Hertz formulas: K. L. Johnson, Contact Mechanics (1985), ch. 3-4.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import signature
from typing import ParamSpec

import numpy as np

from acoustics.arrays import positive

_Numbers = ParamSpec("_Numbers")


def _of_positive_numbers(formula: Callable[_Numbers, float]) -> Callable[_Numbers, float]:
    """Raise ValueError unless all arguments of a formula are numbers above zero."""
    takes = signature(formula)

    @wraps(formula)
    def checked(*values: _Numbers.args, **named: _Numbers.kwargs) -> float:
        given = takes.bind(*values, **named).arguments.items()
        return formula(**{name: positive(name, value) for name, value in given})  # type: ignore

    return checked


@_of_positive_numbers
def hertz_radius(load: float, radius: float, contact_modulus: float) -> float:
    """Return the contact radius of a smooth elastic sphere: a^3 = 3 W R / (4 E*).

    Parameters
    ----------
    load : float, N
        Normal load W.
    radius : float, m
        Radius R of the sphere.
    contact_modulus : float, Pa
        Contact modulus E* of both bodies.

    Returns
    -------
    float, m
        Contact radius a.

    Examples
    --------
    >>> f"{hertz_radius(5.0, 5e-3, 230e9) * 1e6:.2f} um"
    '43.36 um'
    """
    return float((3 * load * radius / (4 * contact_modulus)) ** (1 / 3))


@_of_positive_numbers
def hertz_pressure(load: float, radius: float, contact_modulus: float) -> float:
    """Return the maximum contact pressure of a smooth elastic sphere: p0 = 3 W / (2 pi a^2).

    Parameters
    ----------
    load, radius, contact_modulus : float, N, m, Pa
        Load W, radius R of the sphere and contact modulus E*, as for `hertz_radius`.

    Returns
    -------
    float, Pa
        Maximum pressure p0.

    Examples
    --------
    >>> f"{hertz_pressure(5.0, 5e-3, 230e9) * 1e-9:.3f} GPa"
    '1.270 GPa'
    """
    return float(3 * load / (2 * np.pi * hertz_radius(load, radius, contact_modulus) ** 2))


@_of_positive_numbers
def hertz_approach(load: float, radius: float, contact_modulus: float) -> float:
    """Return the approach of a smooth elastic sphere: a^2 / R.

    Parameters
    ----------
    load, radius, contact_modulus : float, N, m, Pa
        Load W, radius R of the sphere and contact modulus E*, as for `hertz_radius`.

    Returns
    -------
    float, m
        Approach of sphere and plate.

    Examples
    --------
    >>> f"{hertz_approach(5.0, 5e-3, 230e9) * 1e9:.0f} nm"
    '376 nm'
    """
    return hertz_radius(load, radius, contact_modulus) ** 2 / radius


@_of_positive_numbers
def smooth_release_power(load: float, speed: float, radius: float, contact_modulus: float) -> float:
    """Return the release power of a smooth elastic rolling sphere: 3 W v a / (16 R).

    It is constant in time.

    It is the Hertz pressure over the trailing half of the contact times the rate v x / R at which
    the deflection falls there.

    Parameters
    ----------
    load : float, N
        Normal load W.
    speed : float, m/s
        Rolling speed v.
    radius : float, m
        Radius R of the sphere.
    contact_modulus : float, Pa
        Contact modulus E* of both bodies.

    Returns
    -------
    float, W
        Release power.

    Examples
    --------
    >>> f"{smooth_release_power(5.0, 1.0, 5e-3, 230e9) * 1e3:.3f} mW"
    '8.130 mW'
    """
    return 3 * load * speed * hertz_radius(load, radius, contact_modulus) / (16 * radius)


@_of_positive_numbers
def left_end_excess(step: float, contact_radius: float) -> float:
    """Return the relative excess of the left-end release rule over the mean rule.

    To first order it is 4 step / (3 a).

    It holds on a smooth sphere.

    Parameters
    ----------
    step : float, m
        Distance between two positions.
    contact_radius : float, m
        Hertz radius a.

    Returns
    -------
    float
        Excess over the release of the mean rule.

    Examples
    --------
    >>> f"{left_end_excess(1e-6, 50e-6):.3f}"
    '0.027'
    """
    return 4 * step / (3 * contact_radius)
