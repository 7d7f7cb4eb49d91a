"""Sound power that a force radiates through an infinite plate and through a ball."""

import numpy as np
from numpy.typing import ArrayLike

from acoustics.arrays import Array, refuse_masked
from acoustics.bands import AUDIBLE_HZ, third_octave_mean_square
from acoustics.radiation import AIR_KG_M3, SOUND_M_S, Ball, ThinPlate, legendre
from acoustics.spectrum import audible_lines

_NODES = 300  # of the quadrature over directions; 600 change no band by 1e-3 dB
# The power per force is interpolated between these frequencies [Hz] ...
_GRID = np.geomspace(AUDIBLE_HZ[0], AUDIBLE_HZ[1], 300)
# ... and frequencies at these relative distances from coincidence.
_NEAR = np.geomspace(1e-4, 0.3, 100)


def plate_power_per_force(frequency_hz: ArrayLike, plate: ThinPlate, sides: int = 1) -> Array:
    """Return the power that a plate radiates to one side, per mean square of the force.

    It is the integral over all directions of the plate's waves with air loading and losses, so it
    holds below, at and above the critical frequency, and never exceeds the power fed to the plate.
    Below, it tends to rho / (2 pi c m''^2). Above, the plate radiates the fed power less its loss,
    so the power depends on the loss factor.

    Parameters
    ----------
    frequency_hz : array (n,), Hz. Frequencies above 0.
    plate : ThinPlate. Plate.
    sides : int. Sides with air, 1 or 2. Default 1.

    Returns
    -------
    array (n,), W/N^2

    References
    ----------
    L. Cremer, M. Heckl, B. A. T. Petersson, Structure-Borne Sound, 3rd ed. (2005), chapter 7.

    Examples
    --------
    >>> from acoustics.radiation import ThinPlate
    >>> from acoustics.sound_power import plate_power_per_force
    >>> steel_1_mm = ThinPlate(7.85, 18.9)
    >>> round(10 * float(np.log10(plate_power_per_force([500.0], steel_1_mm)[0] / 1e-12)), 1)
    69.5
    """
    refuse_masked("frequency_hz", frequency_hz)
    f = np.asarray(frequency_hz, dtype=float)[:, None]
    m = plate.mass_per_area_kg_m2
    squared = (f / plate.critical_hz) ** 2
    air = sides * AIR_KG_M3 * SOUND_M_S / (2 * np.pi * f * m)  # over the plate's mass impedance
    # With the cosine u of the angle to the axis as variable, the peak of a free bending wave lies
    # at u_c with this half width; nodes of a hyperbolic sine resolve it.
    peak = np.sqrt(np.maximum(1 - plate.critical_hz / f, 0.0))
    own_loss = plate.loss_factor_at(f)
    loss = own_loss + air / np.maximum(peak, np.sqrt(air))
    width = loss / np.maximum(4 * np.sqrt(squared) * peak, np.sqrt(loss))
    low = np.arcsinh(-peak / width)
    high = np.arcsinh((1 - peak) / width)
    nodes, weights = legendre(_NODES)
    t = low + (high - low) * (nodes + 1) / 2
    u = np.clip(peak + width * np.sinh(t), 1e-12, 1.0)
    mass = 1 - squared * (1 - u**2) ** 2 * (1 + 1j * own_loss)
    velocity = 1 / np.square(np.abs(1j * mass + air / u))  # times 1 / (w m'')^2
    integral = np.sum(weights * width * np.cosh(t) * velocity, axis=1) * (high - low)[:, 0] / 2
    return np.asarray(AIR_KG_M3 / (2 * np.pi * SOUND_M_S * m**2) * integral)


def ball_power_per_force(frequency_hz: ArrayLike, ball: Ball, plane: bool = True) -> Array:
    """Return the power that an oscillating ball radiates, per mean square of the force.

    Parameters
    ----------
    frequency_hz : array (n,), Hz. Frequencies above 0.
    ball : Ball. Ball.
    plane : bool. If true, the ball touches a rigid plane, whose image changes the power by -20,
        -6.2 and +2.4 dB at 1, 5 and 20 kHz for 5 mm. Default true.

    Returns
    -------
    array (n,), W/N^2
    """
    refuse_masked("frequency_hz", frequency_hz)
    w = 2 * np.pi * np.asarray(frequency_hz, dtype=float)
    ka = w * ball.radius_m / SOUND_M_S
    area = 4 / 3 * np.pi * ball.radius_m**2
    free = area * AIR_KG_M3 * SOUND_M_S / (ball.mass_kg * w) ** 2 * ka**4 / (4 + ka**4)
    if not plane:
        return np.asarray(free)
    nodes, weights = legendre(64)
    u = (nodes + 1) / 2
    image = np.square(u * np.sin(ka[..., None] * u)) @ weights * 3  # mean of 6 cos^2 sin^2(ka cos)
    return np.asarray(free * image)


def band_power(force_n: ArrayLike, sample_rate_hz: float, source: ThinPlate | Ball) -> Array:
    """Return the sound power of plate or ball in each third octave.

    Parameters
    ----------
    force_n : array (n,), N. Fluctuation of the force, a closed or faded record.
    sample_rate_hz : float, Hz. Sample rate.
    source : ThinPlate or Ball. Body that radiates, a plate to one side.

    Returns
    -------
    array (31,), W
    """
    refuse_masked("force_n", force_n)
    frequency, mean_square = audible_lines(np.asarray(force_n, dtype=float), sample_rate_hz)
    if isinstance(source, Ball):
        power = ball_power_per_force(frequency, source)
    else:
        near = source.critical_hz * np.concatenate((1 - _NEAR, 1 + _NEAR))
        grid = np.sort(np.concatenate((_GRID, near)))
        table = plate_power_per_force(grid, source)
        power = np.exp(np.interp(np.log(frequency), np.log(grid), np.log(table)))
    return third_octave_mean_square(frequency, mean_square * power)
