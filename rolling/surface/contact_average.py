"""Heights that a contact averages along its track: their spectrum, from the law of a surface."""

import math

import numpy as np

from acoustics.arrays import Array
from rolling.surface import made
from rolling.surface.height_law import HeightSpectrum

ACROSS = 160  # waves across the track over which a density is summed
# Beyond the waves that fit into the contact, asperities that take the load from each other leave an
# approach with a power of TAIL (q a)^-5 times the whole, for wave number q and semi-axis a of the
# contact. On five solved tracks (Hertz radius 1.5 to 4 correlation lengths, roughness 0.03 to 0.4
# of the Hertz deflection) octaves from q a = 4 to 64 lie within 5 dB of it.
TAIL = 35.0
TAIL_FROM = 4.0  # q a
LEAST_PHASE = 1e-2  # below which a contact follows a wave; above, the difference keeps 9 digits


def rough_axes(
    semi_axes_m: tuple[float, float], radii_m: tuple[float, float], rq_m: float
) -> tuple[float, float]:
    """Return the semi-axes [m] of the contact of a rough surface, along and across.

    The highest asperities carry where smooth surfaces would be an rms height apart. `semi_axes_m`
    are those of the smooth contact, and `radii_m` those of the sphere.
    """
    length, width = (
        math.sqrt(axis**2 + radius * rq_m)
        for axis, radius in zip(semi_axes_m, radii_m, strict=True)
    )
    return length, width


def averaged_density(
    law: HeightSpectrum, along: Array, semi_axes_m: tuple[float, float], spacing_m: float
) -> Array:
    """Return the two-sided spectral density [m3] of the heights that a contact averages.

    The weight is the pressure of an elliptic contact. `along` (n,) are wave numbers along the
    track [rad/m].
    """
    widest = math.pi / spacing_m
    across = np.concatenate(([0.0], np.geomspace(1e-4 * widest, widest, ACROSS)))
    length, width = semi_axes_m
    q = np.hypot(length * along[:, None], width * across)
    pressure = pressure_average(q)
    sides = [made.plane_density(law, along[:, None], side) for side in (across, -across)]
    density: Array = np.trapezoid((sides[0] + sides[1]) * pressure**2, across, axis=1)
    return density


def pressure_average(phase: Array) -> Array:
    """Return the mean of a wave over an elliptic contact with its pressure, over its height.

    The phase is the root of the sum of squares of wave number times semi-axis, along and across.
    """
    whole = np.maximum(phase, LEAST_PHASE)
    mean = 3 * (np.sin(whole) - whole * np.cos(whole)) / whole**3
    return np.asarray(np.where(phase < LEAST_PHASE, 1.0, mean))


def averaged_noise_db(
    heights: Array, spacing_m: float, noise_m: float, semi_axes_m: tuple[float, float]
) -> float:
    """Return what noise adds to the mean square of the heights that a contact averages [dB].

    A level follows these heights wave by wave, so it gets as much in the mean over its waves, and
    more where waves are short.

    Parameters
    ----------
    heights : (along, across) array, m
        One period, with the noise; lines across that are all equal are a profile.
    spacing_m : float, m
    noise_m : float, m
        Rms of white noise in the heights.
    semi_axes_m : (float, float), m
        Semi-axes of the contact, along and across.

    Returns
    -------
    float
        Infinite where the noise is all that the contact averages.
    """
    is_profile = bool(np.all(heights == heights[:, :1]))
    z = heights[:, :1] if is_profile else heights
    lines = np.square(np.abs(np.fft.fft2(z - z.mean()))) / z.size**2
    waves = [2 * np.pi * np.fft.fftfreq(count, spacing_m) for count in z.shape]
    phase = np.hypot(semi_axes_m[0] * waves[0][:, None], semi_axes_m[1] * waves[1])
    passing = np.square(pressure_average(phase))
    whole = float(np.sum(lines * passing))
    noise = noise_m**2 * float(np.mean(passing))
    if whole <= noise:
        return math.inf if noise > 0 else 0.0
    return -10 * math.log10(1 - noise / whole)


def asperity_density(waves: Array, length_m: float) -> Array:
    """Return the density [m] over wave numbers [rad/m] of what asperities add to an approach.

    It is over the mean square of the whole approach. `length_m` is the semi-axis of the contact
    along the track.
    """
    tail = TAIL * (waves * length_m) ** -5.0 * length_m
    return np.where(waves * length_m > TAIL_FROM, tail, 0.0)
