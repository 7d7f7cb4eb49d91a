"""Ball, contact and plate as a linear chain: mass, mobilities, resonance and its damping."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from acoustics.arrays import Array
from rolling.dynamics._mode_kernels import StepBodies
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.modes import Modes, step_bodies


def half_space_mobility(
    frequency_hz: float, young_pa: float, poisson: float, density_kg_m3: float
) -> float:
    """Return the real part of the mobility [s/kg] of an elastic half-space under a point force.

    It is the damping of the ball by waves, C w^2 / (rho_s c_T^3), with C = 0.137 at nu = 0.3. It
    grows with the square of the frequency, so a motion takes its value at the resonance
    (G. F. Miller, H. Pursey, Proc. R. Soc. Lond. A 223 (1954) 521).

    >>> f"{half_space_mobility(14e3, 210e9, 0.3, 7850):.2e} s/kg"
    '4.10e-06 s/kg'
    """
    c_shear = np.sqrt(young_pa / (2 * (1 + poisson)) / density_kg_m3)
    w = 2 * np.pi * frequency_hz
    return float(_half_space_coefficient(poisson) * w**2 / (density_kg_m3 * c_shear**3))


@cache
def _half_space_coefficient(poisson: float) -> float:
    """Return C: compression and shear waves as an integral, the Rayleigh wave as a residue."""
    from scipy.integrate import quad  # slow to import, for motions only
    from scipy.optimize import brentq

    q2 = (1 - 2 * poisson) / (2 - 2 * poisson)  # squared ratio of the wave speeds

    def body(k: float) -> float:
        a, b = np.sqrt(complex(k * k - q2)), np.sqrt(complex(k * k - 1))
        return float((k * a / ((2 * k * k - 1) ** 2 - 4 * k * k * a * b)).imag)

    def rayleigh(k: float) -> float:
        return float((2 * k * k - 1) ** 2 - 4 * k * k * np.sqrt((k * k - q2) * (k * k - 1)))

    waves = quad(body, 0, np.sqrt(q2))[0] + quad(body, np.sqrt(q2), 1)[0]
    k = brentq(rayleigh, 1 + 1e-9, 2, xtol=1e-14)
    slope = (rayleigh(k + 1e-6) - rayleigh(k - 1e-6)) / 2e-6
    surface = np.pi * k * np.sqrt(k * k - q2) / abs(slope)
    return float((abs(waves) + surface) / (2 * np.pi))


def contact_stiffness(law: ForceLaw, load_n: float) -> float:
    """Return the contact stiffness [N/m] at a load: the inverse of the mean compliance."""
    x = np.asarray(law.position_m, dtype=float)
    return float(1 / np.mean(1 / law.stiffness(x, law.approach(x, load_n))))


@dataclass(frozen=True)
class Chain:
    """Ball, contact and plate in a row, for small fluctuations about the load.

    On a plate with edges, resonance, quality and decay belong to an infinite plate with its mean
    mobility.

    >>> chain = Chain(4.11e-3, 1.018e-4, 3.17e7)
    >>> f"{chain.resonance_hz:.0f} Hz, Q = {chain.quality:.1f}"
    '13977 Hz, Q = 27.2'
    """

    mass_kg: float  # M of the ball
    mobility_s_kg: float  # Y of the plate; 0: a rigid plate
    stiffness_n_m: float  # k of the contact at the load
    modes: Modes | None = None  # of a plate with edges
    contact_loss_factor: float = 0.0  # of the contact stiffness, at the resonance

    @property
    def resonance_hz(self) -> float:
        """Frequency f0 of the ball on its contact [Hz]."""
        return float(np.sqrt(self.stiffness_n_m / self.mass_kg) / (2 * np.pi))

    @property
    def quality(self) -> float:
        """Quality factor Q = 1 / (M w0 Y) with the contact's loss, infinite without losses."""
        loss = self.mass_kg * 2 * np.pi * self.resonance_hz * self.mobility_s_kg
        loss += self.contact_loss_factor
        return 1 / loss if loss > 0 else np.inf

    @property
    def decay_s(self) -> float:
        """Time in which a transient falls by the factor e [s], infinite without losses."""
        half = self.mobility_s_kg * self.stiffness_n_m / 2
        half += self.contact_loss_factor * np.pi * self.resonance_hz
        if half == 0:
            return np.inf
        beyond = max(half**2 - self.stiffness_n_m / self.mass_kg, 0.0)  # of an overdamped chain
        # This form of half - sqrt(beyond) does not cancel.
        if beyond > 0:
            return float((half + np.sqrt(beyond)) * self.mass_kg / self.stiffness_n_m)
        return 1 / half

    @property
    def contact_time_s(self) -> float:
        """Viscosity of the contact over its stiffness [s]."""
        return self.contact_loss_factor / (2 * np.pi * self.resonance_hz)

    @property
    def own_decay_s(self) -> float:
        """Decay time [s] with the mobility of the plate at the resonance, between its modes too."""
        own = float(self.mobilities([self.resonance_hz])["plate"].real[0])
        return replace(self, mobility_s_kg=own, modes=None).decay_s

    @property
    def point(self) -> Array:
        """Contact point (1, 2) [m], the first of a path on a plate with edges."""
        return np.zeros((1, 2)) if self.modes is None else self.modes.point

    def steps(self, step_s: float) -> StepBodies:
        """Return the bodies as time steps [s] move them, in tune at the resonance."""
        parts = self.modes, step_s, self.resonance_hz, self.contact_time_s
        return step_bodies(self.mass_kg, self.mobility_s_kg, *parts)

    def mobilities(self, frequency_hz: ArrayLike) -> dict[str, NDArray[np.complex128]]:
        """Return the mobilities [s/kg] of ball, contact and plate at frequencies [Hz] above 0."""
        frequency = np.asarray(frequency_hz, dtype=float)
        iw = 2j * np.pi * frequency
        plate, contact = np.full_like(iw, self.mobility_s_kg), iw / self.stiffness_n_m
        if self.contact_loss_factor > 0:
            contact /= 1 + self.contact_time_s * iw
        if self.modes is not None:
            plate = iw * self.modes.receptance(frequency)
        return {"ball": 1 / (iw * self.mass_kg), "contact": contact, "plate": plate}

    def force(self, frequency_hz: ArrayLike, roughness_m: ArrayLike) -> NDArray[np.complex128]:
        """Return the fluctuation of the contact force [N], phasors of exp(i w t), above 0 Hz.

        The roughness [m] is minus the fluctuation of the approach under the constant load. It
        moves the spring of the contact, and not its damper.
        """
        iw = 2j * np.pi * np.asarray(frequency_hz, dtype=float)
        receptance = sum(self.mobilities(frequency_hz).values()) / iw
        if self.contact_loss_factor > 0:
            receptance *= 1 + self.contact_time_s * iw
        return np.asarray(roughness_m, dtype=complex) / receptance
