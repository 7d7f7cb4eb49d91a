"""Closed forms of smooth elastic contact in SI, independent of the solver.

Source of the Hertz formulas: K. L. Johnson, Contact Mechanics (1985), ch. 3-4.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from acoustics.arrays import positive

# Smallest and largest length, load, modulus and so on in SI: their powers and products stay finite.
MIN_SIZE = 1e-50
MAX_SIZE = 1e50


def _size(name: str, value: float) -> float:
    """Return a size in SI; raise ValueError beyond the sizes that double precision can combine."""
    number = positive(name, value, MAX_SIZE)
    if number < MIN_SIZE:
        raise ValueError(f"{name}: got {number:g}, allowed: at least {MIN_SIZE:g} in SI")
    return number


def contact_modulus(
    youngs_modulus: float,
    poissons_ratio: float,
    other_modulus: float = math.inf,
    other_ratio: float = 0.5,
) -> float:
    """Return the contact modulus of two bodies: 1/E* = (1 - nu1^2) / E1 + (1 - nu2^2) / E2.

    Parameters
    ----------
    youngs_modulus, other_modulus : float, Pa
        Young's modulus of both bodies. Default of the other: infinite, a rigid body.
    poissons_ratio, other_ratio : float
        Poisson's ratio of both bodies, from 0 to 0.5. Default of the other: 0.5, which a rigid
        body does not need.

    Returns
    -------
    float, Pa
        Contact modulus E*.

    Examples
    --------
    >>> from rolling import closed_forms
    >>> f"{closed_forms.contact_modulus(210e9, 0.3) * 1e-9:.1f} GPa"  # a rigid ball on steel
    '230.8 GPa'
    >>> f"{closed_forms.contact_modulus(210e9, 0.3, 70e9, 0.22) * 1e-9:.1f} GPa"  # glass on steel
    '55.8 GPa'
    """
    bodies = (
        ("youngs_modulus", youngs_modulus, "poissons_ratio", poissons_ratio),
        ("other_modulus", other_modulus, "other_ratio", other_ratio),
    )
    compliance = 0.0
    for modulus_name, modulus, ratio_name, ratio in bodies:
        if type(ratio) not in (int, float) or ratio:
            ratio = positive(ratio_name, ratio, 0.5)
        may_be_rigid = modulus_name == "other_modulus"
        stiffness = positive(modulus_name, modulus, infinite=may_be_rigid)
        if stiffness < math.inf:
            compliance += (1 - ratio**2) / _size(modulus_name, stiffness)
    return 1 / compliance


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
    >>> from rolling import closed_forms
    >>> f"{closed_forms.hertz_radius(5.0, 5e-3, 230e9) * 1e6:.2f} um"
    '43.36 um'
    """
    load = _size("load", load)
    radius = _size("radius", radius)
    contact_modulus = _size("contact_modulus", contact_modulus)
    return float((3 * load * radius / (4 * contact_modulus)) ** (1 / 3))


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
    >>> from rolling import closed_forms
    >>> f"{closed_forms.hertz_pressure(5.0, 5e-3, 230e9) * 1e-9:.3f} GPa"
    '1.270 GPa'
    """
    contact_radius = hertz_radius(load, radius, contact_modulus)
    return float(3 * load / (2 * np.pi * contact_radius**2))


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
    >>> from rolling import closed_forms
    >>> f"{closed_forms.hertz_approach(5.0, 5e-3, 230e9) * 1e9:.0f} nm"
    '376 nm'
    """
    return hertz_radius(load, radius, contact_modulus) ** 2 / radius


def hertz_ellipse(radius: float, radius_across: float) -> tuple[float, float, float]:
    """Return the sphere that bears a load like a body of two radii, and the shape of its contact.

    Approach, stiffness and energy of the elliptic contact are those of a sphere of the equivalent
    radius R at any load. With the contact radius a of that sphere the semi-axes are a times the
    two factors, and the maximum pressure is that of the sphere over their product.

    Parameters
    ----------
    radius, radius_across : float, m
        Principal radii of curvature of the body, along the track and across it.

    Returns
    -------
    equivalent : float, m
        Equivalent radius R.
    along, across : float
        Semi-axes of the contact over the contact radius of the equivalent sphere.

    Notes
    -----
    With the ratio k of the semi-axes and Carlson's integrals, R / R across is RD(0, 1, k^2) /
    RD(0, k^2, 1) (Johnson, section 4.2, in which the integrals are K and E).

    Examples
    --------
    >>> from rolling import closed_forms
    >>> equivalent, along, across = closed_forms.hertz_ellipse(0.46, 0.3)
    >>> f"{equivalent:.4f} m, {along:.4f}, {across:.4f}"
    '0.3743 m, 1.1472, 0.8629'
    """
    return _ellipse(_size("radius", radius), _size("radius_across", radius_across))


@lru_cache(maxsize=64)
def _ellipse(radius: float, radius_across: float) -> tuple[float, float, float]:
    """Return the sphere and the factors of `hertz_ellipse` for valid radii."""
    if radius == radius_across:
        return radius, 1.0, 1.0
    from scipy.optimize import brentq  # slow to import, for two radii only
    from scipy.special import elliprd, elliprf

    wanted = math.log(radius / radius_across)

    def error(log_k: float) -> float:
        """Return the error of the logarithm of R / R across at a ratio of the semi-axes."""
        square = math.exp(2 * log_k)
        return math.log(elliprd(0, 1, square) / elliprd(0, square, 1)) - wanted

    log_k = brentq(error, -abs(wanted) - 1, abs(wanted) + 1, xtol=1e-15)
    square = math.exp(2 * log_k)
    along = float(2 / math.pi * elliprf(0, square, 1))
    equivalent = 4 / (3 * math.pi) * radius * float(elliprd(0, square, 1)) / along**3
    return equivalent, along, along * math.exp(log_k)


def hertz_force(energy: float, radius: float, contact_modulus: float) -> float:
    """Return the force of a smooth elastic sphere that stores an energy: U = 2/5 F a^2 / R.

    It is the largest force of an impact with this energy on a rigid base.

    Parameters
    ----------
    energy : float, J
        Elastic energy U of the contact.
    radius, contact_modulus : float, m, Pa
        Radius R of the sphere and contact modulus E*, as for `hertz_radius`.

    Returns
    -------
    float, N
        Normal force F.

    Examples
    --------
    >>> from rolling import closed_forms
    >>> f"{closed_forms.hertz_force(2e-3, 5e-3, 230e9):.0f} N"  # a steel ball from 50 mm
    '567 N'
    """
    energy = _size("energy", energy)
    radius = _size("radius", radius)
    contact_modulus = _size("contact_modulus", contact_modulus)
    return float((2.5 * energy) ** 0.6 * (16 / 9 * radius * contact_modulus**2) ** 0.2)


def hertz_impact_time(mass: float, speed: float, radius: float, contact_modulus: float) -> float:
    """Return the time of an elastic impact on a rigid base: 2.8683 (m^2 / (R E*^2 v))^(1/5).

    Parameters
    ----------
    mass, speed : float, kg, m/s
        Mass m of the sphere, and its speed v before the impact.
    radius, contact_modulus : float, m, Pa
        Radius R of the sphere and contact modulus E*, as for `hertz_radius`.

    Returns
    -------
    float, s
        Time of contact.

    Examples
    --------
    >>> from rolling import closed_forms
    >>> f"{closed_forms.hertz_impact_time(4.11e-3, 1.0, 5e-3, 230e9) * 1e6:.0f} us"
    '26 us'
    """
    mass = _size("mass", mass)
    speed = _size("speed", speed)
    stiffness = _size("radius", radius) * _size("contact_modulus", contact_modulus) ** 2
    return float(2.8683 * (mass**2 / (stiffness * speed)) ** 0.2)


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
    >>> from rolling import closed_forms
    >>> f"{closed_forms.smooth_release_power(5.0, 1.0, 5e-3, 230e9) * 1e3:.3f} mW"
    '8.130 mW'
    """
    contact_radius = hertz_radius(load, radius, contact_modulus)
    return 3 * load * _size("speed", speed) * contact_radius / (16 * radius)


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
    >>> from rolling import closed_forms
    >>> f"{closed_forms.left_end_excess(1e-6, 50e-6):.3f}"
    '0.027'
    """
    return 4 * _size("step", step) / (3 * _size("contact_radius", contact_radius))
