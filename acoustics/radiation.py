"""From radiated power to intensity and sound pressure at a distance. Depends on numpy only."""

from __future__ import annotations

import numpy as np

P_REF_PA = 20e-6  # reference sound pressure in air
I_REF_W_M2 = 1e-12  # reference intensity
RHO_C = 413.3  # characteristic impedance of air at 20 C, Pa s/m


def intensity(power_w: np.ndarray, distance_m: float, q: float = 1.0) -> np.ndarray:
    """Intensity q W / (4 pi r^2) in W/m^2 at the distance r from a compact source that radiates evenly all round.

    Parameters
    ----------
    power_w
        Release power, any shape, W.
    distance_m
        Distance r, m.
    q
        Share of the release power that is radiated; 1 is the upper bound.
    """
    return q * np.asarray(power_w, dtype=float) / (4.0 * np.pi * distance_m**2)


def sound_pressure(
    intensity_fluctuation: np.ndarray, gain_pa_per_w_m2: float | None = None
) -> tuple[np.ndarray, float]:
    """Sound pressure p = factor * I', linear in the intensity fluctuation and carrying its level.

    Without a gain the factor is sqrt(rho c / rms(I')), so that mean(p^2)/(rho c) = rms(I'): equation (11) of Lee, Kim &
    Kim (2025) on the rms. One factor per record: *between* records the level follows 10 lg of the release, *within* a
    record 20 lg. A given gain holds 20 lg everywhere and superposition, at a level that the gain decides.

    Parameters
    ----------
    intensity_fluctuation
        I' (n,), W/m^2, free of its mean and band-limited.
    gain_pa_per_w_m2
        The factor, Pa per W/m^2, if it is to be fixed.

    Returns
    -------
    pressure_pa, factor_pa_per_w_m2
        p (n,) and the factor used. A silent record gives zeros and the factor 0 (or the gain).

    Raises
    ------
    ValueError
        If the gain is not a positive number.
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
