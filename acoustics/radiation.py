"""Conversion of radiated power to intensity and sound pressure at a distance."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from acoustics._typing import Array

P_REF_PA = 20e-6  # reference sound pressure in air
I_REF_W_M2 = 1e-12  # reference intensity
RHO_C = 413.3  # characteristic impedance of air at 20 C, Pa s/m


def intensity(power_w: ArrayLike, distance_m: float, q: float = 1.0) -> Array:
    """Return the intensity q W / (4 pi r^2) of a compact omnidirectional source.

    Parameters
    ----------
    power_w : array of any shape, W. Release power.
    distance_m : float, m. Distance r.
    q : float. Share of the release power that is radiated. Default 1, the upper bound.

    Returns
    -------
    array of the same shape, W/m^2

    References
    ----------
    Lee, Kim & Kim, Inventions 2025, 10(1), 17, equation (10).

    Examples
    --------
    >>> from acoustics import intensity
    >>> round(float(intensity(1.0, 1.0)), 5)
    0.07958
    """
    return q * np.asarray(power_w, dtype=float) / (4.0 * np.pi * distance_m**2)


def sound_pressure(
    intensity_fluctuation: ArrayLike, gain_pa_per_w_m2: float | None = None
) -> tuple[Array, float]:
    """Convert the intensity fluctuation to a sound pressure, p = factor * I'.

    Without a gain the factor is sqrt(rho c / rms(I')), so that mean(p^2)/(rho c) = rms(I'). Each
    record has its own factor: *between* records the level follows 10 lg of the release, *within* a
    record 20 lg. With a fixed gain the level follows 20 lg everywhere and superposition holds, but
    the gain then decides the level.

    Parameters
    ----------
    intensity_fluctuation : array (n,), W/m^2. I', free of its mean and band-limited.
    gain_pa_per_w_m2 : float or None, Pa per W/m^2. Fixed factor. Default None.

    Returns
    -------
    pressure_pa : array (n,), Pa
    factor_pa_per_w_m2 : float, Pa per W/m^2
        The factor used. A silent record gives zeros and the factor 0, or the gain.

    Raises
    ------
    ValueError
        If the gain is not a positive number.

    References
    ----------
    Lee, Kim & Kim, Inventions 2025, 10(1), 17, equation (11), applied to the rms.

    Examples
    --------
    >>> from acoustics import sound_pressure
    >>> pressure, factor = sound_pressure([1e-6, -1e-6])
    >>> [round(float(value), 4) for value in pressure]
    [0.0203, -0.0203]
    """
    fluctuation = np.asarray(intensity_fluctuation, dtype=float)
    if gain_pa_per_w_m2 is not None:
        if not 0.0 < gain_pa_per_w_m2 < np.inf:
            raise ValueError(f"gain_pa_per_w_m2 must be a positive number, got {gain_pa_per_w_m2}")
        factor = float(gain_pa_per_w_m2)
    else:
        rms = float(np.sqrt(np.mean(np.square(fluctuation))))
        factor = float(np.sqrt(RHO_C / rms)) if rms > 0.0 else 0.0
    return factor * fluctuation, factor
