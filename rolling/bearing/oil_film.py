"""Film of oil in the contacts of a bearing: its viscosity and thickness, waves in it, its damping.

Rolling surfaces draw oil between them, which parts them by a film (`film_thickness_m`). The ratio
of the film to the rms roughness of both surfaces, lambda, says whether they touch: below 1 they do,
above 3 they do not. In a film the pressure presses long waves flat, as a dry contact does, and
leaves short ones as they are. The part A_d of a wave A_i that stays makes no force, so a wave acts
by the linear response of the dry contact times 1 - A_d / A_i (`pressed_shares`).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, inf, log10, pi, sqrt

import numpy as np

from acoustics.arrays import Array
from rolling.bearing.geometry import RacewayContact
from rolling.bearing.waves import contact_modulus, hertz_pressure, semi_axes

# ---- constants, each with its source

# B. J. Hamrock, D. Dowson, Trans. ASME F 99 (1977) 264: central film of a flooded elliptic contact.
FILM = 2.69
FILM_SPEED = 0.67
FILM_MATERIAL = 0.53
FILM_LOAD = -0.067
FILM_SHAPE = (0.61, 0.73)
ELLIPTICITY = (1.03, 0.64)
# Waves across which the surfaces roll, without sliding. Coefficients were quoted from memory of
# these texts, which were not at hand; the coordinate of the second is that of its abstract. Balls
# in grooves have contacts between both: wide across the track as lines are, and of finite width.
# C. H. Venner, A. A. Lubrecht, Proc. IMechE J 214 (2000): circular contacts.
CIRCULAR = (0.15, 0.015)
# C. H. Venner, F. Couhier, A. A. Lubrecht, J. A. Greenwood, Tribology Series 32 (1997) 103: lines.
LINE = (0.125, 0.04)
# Ratio of film to rms roughness up to which the march holds, and from which on the film does
# (T. E. Tallian, ASLE Trans. 10 (1967) 418, as usually quoted: 1 and 3).
TOUCHING = 1.0
PARTED = 3.0
# Viscosity of rolling bearings over their stiffness [s]: 0.25e-5 to 2.5e-5 (E. Kraemer, Dynamics of
# Rotors and Foundations, Springer 1993, as usually quoted; the text was not at hand). All values
# are as likely over their logarithm, whose middle is used. They were found on rotors, at
# frequencies well below the resonances of a free ring.
LEAST_TIME_S = 0.25e-5
LARGEST_TIME_S = 2.5e-5
TIME_S = sqrt(LEAST_TIME_S * LARGEST_TIME_S)
WALTHER = 0.7  # mm2/s that ASTM D341 adds to a kinematic viscosity above 2 mm2/s
# Assumed where the viscosity at 100 degrees C is not given: mineral oils of 68 and 30 mm2/s at 40
# degrees, with viscosity indices of 96 and 104, have 8.6 and 5.23 at 100 (examples of the package
# libvisc), which are slopes of 3.65 and 3.73.
USUAL_SLOPE = 3.7
# Assumed where they are not given, as usual for mineral oils, which have 840 to 900 kg/m3, and 15
# to 25 /GPa.
USUAL_DENSITY_KG_M3 = 870.0
USUAL_PRESSURE_VISCOSITY_PER_GPA = 18.0
_KELVIN = 273.15


@dataclass(frozen=True)
class Oil:
    """Oil at the temperature of the contacts.

    viscosity_pa_s : float, Pa s. Dynamic viscosity at ambient pressure.
    pressure_viscosity_per_pa : float, 1/Pa. Growth of its logarithm with the pressure.
    """

    viscosity_pa_s: float
    pressure_viscosity_per_pa: float


def viscosity_slope(viscosity_40_mm2_s: float, viscosity_100_mm2_s: float) -> float:
    """Return the slope of Walther's line through the viscosities at 40 and 100 degrees C."""
    fall = _ordinate(viscosity_40_mm2_s) - _ordinate(viscosity_100_mm2_s)
    return fall / log10((100 + _KELVIN) / (40 + _KELVIN))


def kinematic_viscosity_mm2_s(
    temperature_c: float, viscosity_40_mm2_s: float, slope: float = USUAL_SLOPE
) -> float:
    """Return the kinematic viscosity [mm2/s] at a temperature from that at 40 degrees C.

    log10(log10(v + 0.7)) falls in a line over the logarithm of the absolute temperature (Walther;
    ASTM D341).
    """
    colder = log10((temperature_c + _KELVIN) / (40 + _KELVIN))
    return float(10.0 ** (10.0 ** (_ordinate(viscosity_40_mm2_s) - slope * colder)) - WALTHER)


def _ordinate(viscosity_mm2_s: float) -> float:
    """Return log10(log10(v + 0.7)) of a kinematic viscosity [mm2/s]."""
    return log10(log10(viscosity_mm2_s + WALTHER))


@dataclass(frozen=True)
class FilmContact:
    """Contact of a ball with a raceway through a film of oil.

    contact : RacewayContact. The smooth contact.
    load_n : float, N.
    rolling_speed_m_s : float, m/s. Speed of both surfaces through the contact.
    oil : Oil.
    """

    contact: RacewayContact
    load_n: float
    rolling_speed_m_s: float
    oil: Oil

    @property
    def modulus(self) -> float:
        """Modulus E' [Pa] of 2/E' = (1 - nu_1^2) / E_1 + (1 - nu_2^2) / E_2."""
        return 2 * contact_modulus(self.contact)

    @property
    def speed_number(self) -> float:
        """Number U = eta u / (E' R) with the mean speed of both surfaces."""
        radius = self.contact.radius_along_m
        return self.oil.viscosity_pa_s * self.rolling_speed_m_s / (self.modulus * radius)

    @property
    def thickness_m(self) -> float:
        """Thickness of the film in the middle of the contact [m]."""
        along = self.contact.radius_along_m
        material = self.oil.pressure_viscosity_per_pa * self.modulus
        load = self.load_n / (self.modulus * along**2)
        factor, power = ELLIPTICITY
        ellipticity = factor * (self.contact.radius_across_m / along) ** power
        shape = 1 - FILM_SHAPE[0] * exp(-FILM_SHAPE[1] * ellipticity)
        numbers = self.speed_number**FILM_SPEED * material**FILM_MATERIAL * load**FILM_LOAD
        return float(along * FILM * numbers * shape)

    def remaining_shares(self, waves_m: Array) -> tuple[Array, Array]:
        """Return what a film leaves of waves along the track, A_d / A_i, by both laws.

        Parameters
        ----------
        waves_m : array (n,), m
            Wavelengths, positive or infinite.

        Returns
        -------
        circular, line : arrays (n,)
            Shares by the law of circular contacts and by that of line contacts.
        """
        double = 2 * self.speed_number  # of the sum of both speeds
        radius = self.contact.radius_along_m
        viscosity = self.oil.pressure_viscosity_per_pa * self.modulus * double ** (1 / 4)
        half = semi_axes(self.contact, self.load_n).along
        point = self.load_n / (self.modulus * radius**2) * double ** (-3 / 4)
        # The line has the pressure of the middle of the ellipse over the same width.
        per_length = pi / 2 * half * hertz_pressure(self.contact, self.load_n)
        line = per_length / (self.modulus * radius) * double ** (-1 / 2)
        length = np.asarray(waves_m, dtype=float) / half
        return (
            _left(length * sqrt(point / viscosity), CIRCULAR),
            _left(length * line ** (3 / 4) / sqrt(viscosity), LINE),
        )

    def pressed_shares(self, waves_m: Array) -> tuple[Array, Array]:
        """Return what makes a force of waves along the track, 1 - A_d / A_i, by both laws."""
        circular, line = self.remaining_shares(waves_m)
        return 1 - circular, 1 - line


def _left(coordinate: Array, coefficients: tuple[float, float]) -> Array:
    """Return 1 / (1 + a f + b f^2)."""
    first, second = coefficients
    return np.asarray(1 / (1 + first * coordinate + second * coordinate**2))


def film_weight(ratio: float) -> float:
    """Return the weight of the film beside the march at a ratio of film to rms roughness.

    It is 0 where surfaces touch, 1 where they are parted, and grows in a line between.
    """
    return min(max((ratio - TOUCHING) / (PARTED - TOUCHING), 0.0), 1.0)


@dataclass(frozen=True)
class ContactFilm:
    """Film between the balls and a raceway.

    contact : RacewayContact. The smooth contact.
    rolling_speed_m_s : float, m/s.
    oil : Oil.
    ratio : float. Film over the rms roughness of both surfaces, lambda; infinite on smooth ones.
    thickness_m : float, m. At the mean load of a ball.
    """

    contact: RacewayContact
    rolling_speed_m_s: float
    oil: Oil
    ratio: float
    thickness_m: float

    @property
    def weight(self) -> float:
        """Weight of the film beside the march."""
        return film_weight(self.ratio)

    def at_load(self, load_n: float) -> FilmContact:
        """Return the contact under a load [N]."""
        return FilmContact(self.contact, load_n, self.rolling_speed_m_s, self.oil)


def contact_film(
    contact: RacewayContact, load_n: float, rolling_speed_m_s: float, oil: Oil, roughness_m: float
) -> ContactFilm:
    """Return the film between balls under a mean load [N] and a raceway.

    Parameters
    ----------
    contact : RacewayContact
        Smooth contact.
    load_n : float, N
        Mean load of a ball.
    rolling_speed_m_s : float, m/s
        Speed of both surfaces through the contact.
    oil : Oil
    roughness_m : float, m
        Rms roughness of both surfaces together.
    """
    thickness_m = FilmContact(contact, load_n, rolling_speed_m_s, oil).thickness_m
    ratio = thickness_m / roughness_m if roughness_m > 0 else inf
    return ContactFilm(contact, rolling_speed_m_s, oil, ratio, thickness_m)
