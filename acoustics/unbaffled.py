"""Uncertainty of the sound of a free plate that is computed as in a baffle, which it does not have.

The rule was read from free plates with sides of 1:1 and 1.5:1, solved with and without a baffle for
all their modes, and tested on other plates (`tests/benchmarks/unbaffled_bands.py`).
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from acoustics.arrays import Array, positive, refuse_masked
from acoustics.radiation import SOUND_M_S

# Phase of sound over the root of the area, below which the plate is small.
SMALL_RAD = 2.0
NEAR_COINCIDENCE = (0.5, 2.0)  # frequencies over the critical frequency
FAR_ABOVE = 4.0  # times the critical frequency
# Standard uncertainties [dB].
SMALL_DB = 10.0
# The baffle changes two sounds of the same plate alike, but for single modes. Differences of close
# forces changed by 1.6 dB in rms where each level had 7.7 dB.
SHARED_PART = 0.2  # of the uncertainty of both, that their difference keeps
NEAR_COINCIDENCE_DB = 10.0
ELSEWHERE_DB = 6.0
FAR_ABOVE_DB = 2.5


def baffle_uncertainty_db(frequency_hz: ArrayLike, area_m2: float, critical_hz: float) -> Array:
    """Return the standard uncertainty of third octaves of a free plate that has no baffle.

    It is for the pressure at a listener above a plate that is struck at any place. It is the root
    mean square of what the baffle changes, because the sign depends on the place and the listener.

    Parameters
    ----------
    frequency_hz : array of any shape, Hz. Mid frequencies, above 0.
    area_m2 : float, m^2. Area of the plate.
    critical_hz : float, Hz. Critical frequency of the plate.

    Returns
    -------
    array of the same shape, dB

    Raises
    ------
    ValueError
        If the area or the critical frequency is not above 0.

    References
    ----------
    An own solution of the plate without a baffle, checked by panels and by discs with closed forms
    (`tests/benchmarks/unbaffled_panels.py`).

    Examples
    --------
    >>> from acoustics.unbaffled import baffle_uncertainty_db
    >>> baffle_uncertainty_db([250, 2000, 12500], 0.12, 12080.0).tolist()
    [10.0, 6.0, 10.0]
    """
    refuse_masked("frequency_hz", frequency_hz)
    frequency = np.asarray(frequency_hz, dtype=float)
    size = 2 * np.pi * frequency / SOUND_M_S * np.sqrt(positive("area_m2", area_m2))
    over = frequency / positive("critical_hz", critical_hz)
    spread = np.where(over > FAR_ABOVE, FAR_ABOVE_DB, ELSEWHERE_DB)
    is_near = (over >= NEAR_COINCIDENCE[0]) & (over <= NEAR_COINCIDENCE[1])
    spread = np.where(is_near, NEAR_COINCIDENCE_DB, spread)
    # The baffle makes a monopole of what is a dipole in the open, by 6 dB an octave more.
    of_small = SMALL_DB - 20 * np.log10(np.minimum(size, 1.0))
    return np.asarray(np.where(size < SMALL_RAD, of_small, spread))


def baffle_difference_db(first: ArrayLike, second: ArrayLike, of_bands: ArrayLike) -> float:
    """Return the standard uncertainty of the difference of two sounds of a free plate.

    Both come from the same plate, struck at the same place and heard at the same one, so that what
    the missing baffle changes in a band is much the same for both.

    Parameters
    ----------
    first, second : arrays (bands,)
        Weighted mean squares of both sounds by third octave, in any unit.
    of_bands : array (bands,), dB
        Uncertainty of each band, as of `baffle_uncertainty_db`.

    Returns
    -------
    float, dB
        0 where one of them is silent.

    Examples
    --------
    >>> from acoustics.unbaffled import baffle_difference_db
    >>> round(baffle_difference_db([1.0, 2.0], [2.0, 4.0], [6.0, 6.0]), 3)
    1.2
    """
    of_first = np.asarray(first, dtype=float)
    of_second = np.asarray(second, dtype=float)
    if not (of_first.sum() > 0 and of_second.sum() > 0):
        return 0.0
    shares = of_first / of_first.sum()
    others = of_second / of_second.sum()
    bands = np.asarray(of_bands, dtype=float)
    of_both = float((shares + others) / 2 @ bands)
    moved = float(np.abs(shares - others) / 2 @ bands)
    return math.hypot(SHARED_PART * of_both, moved)
