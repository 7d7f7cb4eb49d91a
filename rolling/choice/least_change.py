"""Least change of a roughness that lowers a level: a convex problem with a closed form.

Third octaves of waves are lowered by x_b decibels. By the linear response the level falls by

    -10 n lg(sum of s_b 10^(-x_b / 10)),    s_b = r_b / n,    n = sum of r_b,

with the response r_b of each band. This has the derivatives r_b at x = 0, is exact for a sound that
is linear in the waves (n = 1), and follows the n-th power of the roughness where all bands are
lowered alike. The sum of the squares of x_b is minimized under a fall of D: both the sum and the
set of allowed x are convex. At the minimum x_b exp(c x_b) = m s_b with c = ln(10) / 10, so x_b is
given by Lambert's function, and m is the root of the fall.
"""

import math

import numpy as np
from scipy.optimize import brentq
from scipy.special import lambertw

from acoustics.arrays import Array

_C = math.log(10.0) / 10.0
_MOST_DB = 1000.0  # of a fall for which a root is sought


def least_change(response: Array, fall_db: float) -> Array:
    """Return by how much each band is lowered for a fall of the level, (bands,) [dB].

    Parameters
    ----------
    response : (bands,) array, dB/dB
        Fall of the level where a band is a decibel lower, at least 0; one is above 0.
    fall_db : float, dB
        Wanted fall, above 0.
    """
    shares = response / response.sum()
    wanted = fall_db / float(response.sum())

    def lowered(log_multiplier: float) -> Array:
        """Return the decibels at a logarithm of the multiplier."""
        argument = _C * np.exp(log_multiplier) * shares
        return np.asarray(np.real(lambertw(argument))) / _C

    def excess(log_multiplier: float) -> float:
        """Return how far the fall lies above the wanted one [dB]."""
        return fall_of(response, lowered(log_multiplier)) / float(response.sum()) - wanted

    lowest = -40.0
    highest = 40.0 + _C * min(wanted, _MOST_DB)
    if excess(highest) < 0 or excess(lowest) > 0:
        raise ValueError(f"fall_db: got {fall_db:g}, allowed: a fall within the range of the root")
    return lowered(float(brentq(excess, lowest, highest, xtol=1e-12)))


def fall_of(response: Array, lowered_db: Array) -> float:
    """Return the fall of the level by the linear response [dB], of bands that are lowered [dB]."""
    total = float(response.sum())
    left = float(response @ np.power(10.0, -lowered_db / 10.0)) / total
    return -10.0 * total * math.log10(left)
