"""Sound pressure at a distance: from a released power, and from a force on a plate and a ball.

The functions of forces take the fluctuation of a force between a ball and the plane below it, and
return the pressure on the axis above the ball. They leave out the delay r/c: a sample of pressure
has the time of the force that made it. The listener is far away, at many ball radii.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import roots_legendre

from acoustics.arrays import Array, finite, positive, real_array, refuse_masked, within
from acoustics.loss_factors import LossFactor, least_loss_factor, loss_factor_at

P_REF_PA = 20e-6  # reference sound pressure in air
I_REF_W_M2 = 1e-12  # reference intensity
RHO_C = 413.3  # characteristic impedance of air at 20 C [Pa s/m]
AIR_KG_M3 = 1.204  # density of air at 20 C
_MAX_FACTOR = 1e300  # of a factor
MIN_DISTANCE_M = 1e-9
MAX_DISTANCE_M = 1e9
SOUND_M_S = 343.2  # speed of sound in air at 20 C
legendre = cache(roots_legendre)  # nodes and weights of a quadrature from -1 to 1


def intensity(power_w: ArrayLike, distance_m: float, q: float = 1.0) -> Array:
    """Return the intensity q W / (4 pi r^2) of a compact omnidirectional source.

    Parameters
    ----------
    power_w : array of any shape, W
        Release power.
    distance_m : float, m
        Distance r.
    q : float
        Share of the release power that is radiated. Default 1, the upper bound.

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
    power = finite("q", q) * real_array("power_w", power_w, None)
    distance_m = within("distance_m", distance_m, MIN_DISTANCE_M, MAX_DISTANCE_M)
    return np.asarray(power / (4.0 * np.pi * distance_m**2))


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
    intensity_fluctuation : array (n,), W/m^2
        I', free of its mean and band-limited.
    gain_pa_per_w_m2 : float or None, Pa per W/m^2
        Fixed factor. Default None.

    Returns
    -------
    pressure_pa : array (n,), Pa
    factor_pa_per_w_m2 : float, Pa per W/m^2
        The factor used. A silent record gives zeros and the factor 0, or the gain.

    Raises
    ------
    ValueError
        If the gain is not a positive number, or the fluctuation no array of finite numbers.

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
    fluctuation = real_array("intensity_fluctuation", intensity_fluctuation, 1)
    if gain_pa_per_w_m2 is not None:
        factor = positive("gain_pa_per_w_m2", gain_pa_per_w_m2, _MAX_FACTOR)
    else:
        rms = float(np.sqrt(np.mean(np.square(fluctuation))))
        factor = float(np.sqrt(RHO_C / rms)) if rms > 0.0 else 0.0
    return factor * fluctuation, factor


@dataclass(frozen=True)
class ThinPlate:
    """Infinite plate in bending, with air above it.

    Parameters
    ----------
    mass_per_area_kg_m2, bending_stiffness_n_m : float, kg/m^2, N m. Mass per area m'', and bending
        stiffness per width B.
    loss_factor : float, or pairs of float. Loss factor of bending waves, or at least two pairs of a
        frequency [Hz] and a loss factor above 0, as in `loss_factor_at`. It decides the power above
        the critical frequency, and no pressure on the axis. Default 0.

    Examples
    --------
    >>> from acoustics.radiation import ThinPlate
    >>> steel_10_mm = ThinPlate(78.5, 18.9e3)
    >>> round(steel_10_mm.critical_hz), round(steel_10_mm.nearest_m, 2)
    (1208, 0.13)
    """

    mass_per_area_kg_m2: float
    bending_stiffness_n_m: float
    loss_factor: LossFactor = 0.0

    def loss_factor_at(self, frequency_hz: ArrayLike) -> Array:
        """Return the loss factor of bending waves at frequencies [Hz], an array of their shape."""
        return loss_factor_at(self.loss_factor, frequency_hz)

    @property
    def least_loss_factor(self) -> float:
        """Smallest loss factor of all frequencies."""
        return least_loss_factor(self.loss_factor)

    @property
    def critical_hz(self) -> float:
        """Critical frequency, at which bending waves are as fast as sound [Hz]."""
        ratio = self.mass_per_area_kg_m2 / self.bending_stiffness_n_m
        return float(SOUND_M_S**2 / (2 * np.pi) * np.sqrt(ratio))

    @property
    def mobility_s_kg(self) -> float:
        """Mobility at a point, 1 / (8 sqrt(B m'')) [s/kg]."""
        return float(1 / (8 * np.sqrt(self.bending_stiffness_n_m * self.mass_per_area_kg_m2)))

    def bending_wavelength_m(self, frequency_hz: float) -> float:
        """Return the length of bending waves [m]."""
        ratio = self.bending_stiffness_n_m / self.mass_per_area_kg_m2
        return float(2 * np.pi * ratio**0.25 / np.sqrt(2 * np.pi * frequency_hz))

    @property
    def nearest_m(self) -> float:
        """Distance sqrt(8 B / m'') / c that a listener on the axis must exceed by far [m]."""
        ratio = self.bending_stiffness_n_m / self.mass_per_area_kg_m2
        return float(np.sqrt(8 * ratio) / SOUND_M_S)

    @property
    def lowest_hz(self) -> float:
        """Frequency rho c / (pi m'') below which air loads the plate, which is left out [Hz]."""
        return float(AIR_KG_M3 * SOUND_M_S / (np.pi * self.mass_per_area_kg_m2))


@dataclass(frozen=True)
class HalfSpaceBody:
    """Elastic half-space with air above it.

    Parameters
    ----------
    density_kg_m3, compression_m_s : float, kg/m^3, m/s. Density rho_s, and speed c_L of compression
        waves.
    """

    density_kg_m3: float
    compression_m_s: float


@dataclass(frozen=True)
class Ball:
    """Rigid ball that touches a rigid plane and moves along the normal.

    Parameters
    ----------
    radius_m, density_kg_m3 : float, m, kg/m^3. Radius a and density rho_s.
    """

    radius_m: float
    density_kg_m3: float

    @property
    def mass_kg(self) -> float:
        """Mass [kg]."""
        return float(4 / 3 * np.pi * self.radius_m**3 * self.density_kg_m3)


Body = ThinPlate | HalfSpaceBody | Ball


def axis_transfer(
    frequency_hz: ArrayLike, source: Body, distance_m: float, cosine: float = 1.0
) -> NDArray[np.complex128]:
    """Return the pressure on the axis, on the ball's side, per force between ball and plane.

    - **Plate**: -rho / (2 pi r m''), without a derivative, so the wave form is that of the force.
      It is exact at all frequencies, above coincidence too, because on the axis the plate answers
      with its mass alone. On the far side the sign is +.
    - **Half-space**: -rho i w / (2 pi r rho_s c_L), above 10 kHz m / r within
      0.5 dB. At 1 m steel is too loud by 13.5, 5.2 and 1.4 dB at 0.1, 1 and 5 kHz.
    - **Ball**: 3 rho i w / (8 pi rho_s c r) as a small ball alone, less the same from its image in
      the plane, later by 2 a/c. The sum grows with w^2. Against multipoles of a touching ball of
      5 mm it is off by +0.1, -0.6 and -1.0 dB at 5, 10 and 20 kHz.

    Pressures of ball and plate add; both are negative while the ball is small.

    Parameters
    ----------
    frequency_hz : array (n,), Hz. Frequencies of exp(i w t), real, or complex for a growing force.
    source : ThinPlate, HalfSpaceBody or Ball. Body that radiates.
    distance_m : float, m. Distance r of the listener from the point of contact.
    cosine : float. Cosine of the angle between a listener off the axis and the axis, for a ball,
        which is a dipole along the axis and its image. Default 1, on the axis.

    Returns
    -------
    array (n,), Pa/N

    Examples
    --------
    >>> from acoustics.radiation import ThinPlate, axis_transfer
    >>> steel_10_mm = ThinPlate(78.5, 18.9e3)
    >>> round(1e3 * float(axis_transfer([1000.0], steel_10_mm, 1.0)[0].real), 2)  # mPa per N
    -2.44
    """
    refuse_masked("frequency_hz", frequency_hz)
    f = np.asarray(frequency_hz)
    if isinstance(source, ThinPlate):
        mass = source.mass_per_area_kg_m2
        return np.full(f.shape, -AIR_KG_M3 / (2 * np.pi * distance_m * mass), dtype=complex)
    derivative = 2j * np.pi * f * AIR_KG_M3 / (np.pi * distance_m * source.density_kg_m3)
    if isinstance(source, HalfSpaceBody):
        return np.asarray(-derivative / (2 * source.compression_m_s))
    ka = 2 * np.pi * f * source.radius_m / SOUND_M_S
    sphere = 2 * np.exp(1j * ka) / (2 + 2j * ka - ka**2)  # over that of a small sphere
    return np.asarray(derivative * 3 / (8 * SOUND_M_S) * sphere * 2j * cosine * np.sin(ka * cosine))


def pressure_on_axis(
    force_n: ArrayLike, sample_rate_hz: float, sources: Sequence[Body], distance_m: float
) -> Array:
    """Return the pressure on the axis above a ball that a fluctuating force moves.

    A plate needs no filter. For the other bodies the lines of the spectrum are multiplied by
    `axis_transfer`; the line at Nyquist is dropped, since its phase is unknown.

    Parameters
    ----------
    force_n : array (n,), N. Fluctuation of the force that presses ball and plane apart, a closed or
        faded record.
    sample_rate_hz : float, Hz. Sample rate.
    sources : sequence of ThinPlate, HalfSpaceBody or Ball. Bodies whose pressures add.
    distance_m : float, m. Distance r of the listener from the point of contact.

    Returns
    -------
    array (n,), Pa

    Examples
    --------
    >>> from acoustics.radiation import ThinPlate, pressure_on_axis
    >>> pressure = pressure_on_axis([1.0, -2.0, 1.0], 48000, [ThinPlate(78.5, 18.9e3)], 1.0)
    >>> [round(1e3 * float(value), 2) for value in pressure]
    [-2.44, 4.88, -2.44]
    """
    refuse_masked("force_n", force_n)
    force = np.asarray(force_n, dtype=float)
    pressure = np.zeros(force.shape)
    n = force.size
    for source in sources:
        if isinstance(source, ThinPlate):
            pressure += axis_transfer(0.0, source, distance_m).real * force
            continue
        frequency = np.fft.rfftfreq(n, 1 / sample_rate_hz)
        lines = np.fft.rfft(force) * axis_transfer(frequency, source, distance_m)
        if n % 2 == 0:
            lines[-1] = 0
        pressure += np.fft.irfft(lines, n)
    return pressure
