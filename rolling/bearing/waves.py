"""Linear response of a contact: what heights within its length do to its approach.

A closed elastic contact under a constant load follows heights by their mean over the contact,
weighted by the pressure under a flat punch of its outline (reciprocity). For an ellipse with the
semi-axes a along and b across the track, the weighted mean of a wave is its height times

    sin(q) / q,   q = sqrt((k_along a)^2 + (k_across b)^2)

Of waves along the track alone this is the plain mean over the length 2 a. The response holds for
waves of any length that the contact does not bridge.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from rolling.bearing.geometry import RacewayContact
from rolling.contact import closed_forms


class SemiAxes(NamedTuple):
    """Semi-axes of an elliptic contact [m]."""

    along: float
    across: float


def semi_axes(contact: RacewayContact, load_n: float) -> SemiAxes:
    """Return the semi-axes of the smooth contact of a ball with a raceway under a load [N].

    They follow from its stiffness K = 4/3 E* sqrt(R), R of the equivalent sphere, whose contact
    radius is a^2 = R (Q / K)^(2/3).
    """
    radii = contact.radius_along_m, contact.radius_across_m
    equivalent, along, across = closed_forms.hertz_ellipse(*radii)
    approach = hertz_approach(contact, load_n)
    radius = np.sqrt(equivalent * approach)
    return SemiAxes(along=float(along * radius), across=float(across * radius))


def hertz_approach(contact: RacewayContact, load_n: float) -> float:
    """Return the approach [m] of the smooth contact under a load [N]."""
    return float((load_n / contact.stiffness_n_m15) ** (2 / 3))


def hertz_pressure(contact: RacewayContact, load_n: float) -> float:
    """Return the maximum pressure [Pa] of the smooth contact under a load [N]."""
    axes = semi_axes(contact, load_n)
    return 1.5 * load_n / (np.pi * axes.along * axes.across)


def wave_pressure(contact: RacewayContact, heights_m: Array, radius_m: float) -> float:
    """Return the pressure [Pa] that would press the waves around a body flat.

    A wave of amplitude A and wave number k takes E* A k / 2 in full contact (Westergaard; Johnson,
    section 13.2). Beside a smaller maximum Hertz pressure the contact bridges its valleys.
    """
    waves = 2 * np.abs(np.fft.rfft(heights_m))[1:] / len(heights_m)
    wave_number = np.arange(1, len(waves) + 1) / radius_m
    modulus = contact_modulus(contact)
    return float(modulus / 2 * np.sqrt(np.sum((waves * wave_number) ** 2)))


def contact_modulus(contact: RacewayContact) -> float:
    """Return the contact modulus E* [Pa] of ball and raceway, from K = 4/3 E* sqrt(R)."""
    equivalent, _, _ = closed_forms.hertz_ellipse(contact.radius_along_m, contact.radius_across_m)
    return float(3 / 4 * contact.stiffness_n_m15 / np.sqrt(equivalent))


def response(phase: Array) -> Array:
    """Return the response of a contact to a wave over its height, sin(q) / q."""
    return np.asarray(np.sinc(phase / np.pi))


_WAVES_ACROSS = 400  # at which the waves across are summed
_WIDEST = 1e4  # wave number across over that along, and its inverse, between which they lie


def isotropic_response(phase_along: Array, axes: SemiAxes, exponent: float) -> Array:
    """Return the response of a contact to random waves that are as long across as along.

    It is the root mean square over the waves across. Of a profile along the track whose amplitudes
    fall with a power s of the order, the density over both wave numbers falls as (k_along^2 +
    k_across^2)^-(s + 1/2). A contact that is wide for a wave averages it more than one whose crest
    lies across the track.

    Parameters
    ----------
    phase_along : array (n,)
        Wave numbers along the track times the semi-axis along.
    axes : SemiAxes
        Semi-axes of the contact.
    exponent : float
        Power s.
    """
    # Steps of the logarithm of the wave number across over that along.
    across = np.geomspace(1 / _WIDEST, _WIDEST, _WAVES_ACROSS)
    weights = (1 + across**2) ** -(exponent + 0.5) * across
    weights /= weights.sum()
    wider = axes.across / axes.along
    square = np.zeros(len(phase_along))
    for ratio, weight in zip(across, weights, strict=True):
        square += weight * response(phase_along * np.hypot(1, ratio * wider)) ** 2
    return np.asarray(np.sqrt(square))


@lru_cache(maxsize=16)
def _isotropic_share(orders: int, radius_m: float, axes: SemiAxes, exponent: float) -> Array:
    """Return the response to random waves of all orders around a body, (orders,).

    All balls of a bearing have the same one.
    """
    wave_number = np.arange(orders) / radius_m
    return isotropic_response(wave_number * axes.along, axes, exponent)


def approach_of_profile(
    heights_m: Array,
    radius_m: float,
    contact: RacewayContact,
    loads_n: Sequence[float],
    isotropic_exponent: float | None = None,
) -> Array:
    """Return the change of the approach by heights along the track.

    Parameters
    ----------
    heights_m : array (n,), m
        Heights at equally spaced angles of a full turn of a body.
    radius_m : float, m
        Radius of the circle on the body on which the contact runs.
    contact : RacewayContact
        Smooth contact.
    loads_n : sequence of float, N
        Loads.
    isotropic_exponent : float, optional
        Power of the orders by which amplitudes of random waves fall that are as long across as
        along. Default: heights do not vary across the track.

    Returns
    -------
    array (loads, n), m
        Change of the approach under each load, with zero mean; a bump lowers it.
    """
    count = len(heights_m)
    waves = np.fft.rfft(heights_m)
    waves[0] = 0.0
    wave_number = np.arange(len(waves)) / radius_m
    rows = []
    for load in loads_n:
        axes = semi_axes(contact, load)
        if isotropic_exponent is None:
            share = response(wave_number * axes.along)
        else:
            share = _isotropic_share(len(waves), radius_m, axes, isotropic_exponent)
        rows.append(-np.fft.irfft(waves * share, count))
    return np.array(rows)


def approach_of_heights(
    heights_m: Array,
    spacing_m: tuple[float, float],
    contact: RacewayContact,
    loads_n: Sequence[float],
) -> Array:
    """Return the change of the approach on the middle line of periodic heights.

    Parameters
    ----------
    heights_m : array (along, across), m
        Heights of a surface that repeats along and across.
    spacing_m : pair of float, m
        Distance of nodes along and across.
    contact : RacewayContact
        Smooth contact.
    loads_n : sequence of float, N
        Loads.

    Returns
    -------
    array (loads, along), m
        Change of the approach under each load, with zero mean; a bump lowers it.
    """
    count, across = heights_m.shape
    middle = (across - 1) / 2 * spacing_m[1]  # as of a march
    across_wave = 2 * np.pi * np.fft.fftfreq(across, spacing_m[1])
    waves = np.fft.rfft2(heights_m, axes=(1, 0)) * np.exp(1j * across_wave * middle)
    # Both directions across have one response, so their waves are added before.
    half = across // 2 + 1
    folded = waves[:, :half]
    folded[:, 1 : across - half + 1] += waves[:, : half - 1 : -1]
    across_wave = np.abs(across_wave[:half])
    along_wave = 2 * np.pi * np.fft.rfftfreq(count, spacing_m[0])
    rows = []
    for load in loads_n:
        axes = semi_axes(contact, load)
        phase = np.hypot(along_wave[:, None] * axes.along, across_wave * axes.across)
        line = (folded * response(phase)).sum(axis=1) / across
        line[0] = 0.0
        rows.append(-np.fft.irfft(line, count))
    return np.array(rows)
