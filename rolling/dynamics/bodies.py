"""Ball, contact and plate as a linear chain, and the modes of a plate with edges.

The chain has masses, mobilities, and a resonance with its damping.

A mode of a plate with edges has half its loss factor as damping ratio. The rigid-body modes of a
free plate are modes of a low frequency, which the soft support decides. Modes
above 30 kHz are a tail of a few modes, each for a band of natural frequencies. Their damping ratio
gives them the mean mobility of an infinite plate, and together they have the static compliance of
the modes that they replace.

A damped mode of a wide band also answers below its band, where the modes of the plate are counted
already. Under rolling this changes next to nothing, because little of the force lies near 30 kHz.
An impact of 20 to 40 us has its energy there, so a fall gets narrow bands.
"""

import math
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from acoustics.arrays import Array, short_repr
from acoustics.rectangular_plate import MODES_HZ, RectangularPlate
from acoustics.ritz_plate import RitzPlate
from rolling.dynamics._mode_kernels import StepBodies
from rolling.dynamics.force_law import ForceLaw

# Ratios of the upper to the lower edge of each band of the tail. The damping ratio of a band dw
# about w is dw / (pi w). Both tails end near 340 kHz; the last band stands for all beyond it, too.
ROLLING_TAIL = np.full(6, 1.5)
# Bands from 3 % on, each 7 % wider than the one before on a logarithmic scale. Impacts on plates
# with all modes up to 400 kHz chose them: docs/dynamics.md.
FALLING_TAIL = np.exp(0.03 * 1.07 ** np.arange(28))
_FASTEST = 1.5  # highest phase of a mode in half a step
_DIRECT = 300_000  # responses of modes that are summed without a table
_BLOCK = 1_000_000  # responses of modes that are held at once
_HIGHEST_HZ = 2e6  # of the table
_PER_WAVE = 16  # stations of a path in the shortest bending wave


# ---- modes of a plate with edges


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of a plate with edges, and its tail, as they move the contact; (modes,) arrays."""

    __repr__ = short_repr

    angular_frequency: Array  # [rad/s]
    damping_ratio: Array
    reach: Array  # g = 1 / (w sqrt(mass)) [m/J^0.5]
    weight: Array  # mean square of the shape at the contact points
    counts: NDArray[np.int64]  # modes of the plate by half waves along, ordered by half waves
    sides: Array  # (2,) [m]
    point: Array  # (1, 2) contact point, the first of a path [m]
    stations: Array = field(default_factory=lambda: np.zeros((0, 0)))  # shapes along the path
    ends: Array = field(default_factory=lambda: np.zeros((2, 2)))  # of the stations [m]
    rigid: int = 0  # modes of a rigid body, which come first

    def receptance(self, frequency_hz: Array) -> NDArray[np.complex128]:
        """Return the mean displacement per force [m/N] at the contact points."""
        if frequency_hz.size * len(self.weight) < _DIRECT:
            return self._sum(frequency_hz)
        lowest, highest = np.exp(self._table.x[[0, -1]])
        return np.asarray(self._table(np.log(np.clip(frequency_hz, lowest, highest))))

    def decay_s(self, angular_frequency: float) -> float:
        """Return the time [s] in which a mode of a frequency [rad/s] falls by the factor e."""
        return float(1 / (self.damping_ratio.min() * angular_frequency))

    @property
    def bending(self) -> slice:
        """Modes in which the plate bends."""
        return slice(self.rigid, None)

    def lowest_angular_frequency(self, mass_kg: float) -> float:
        """Return the lowest angular frequency [rad/s] of the plate with a mass on the contact."""
        loaded = float((mass_kg * self.compliance_m_n) ** -0.5)
        return min(float(self.angular_frequency[self.bending].min()), loaded)

    @property
    def compliance_m_n(self) -> float:
        """Static compliance [m/N] of bending at the contact points."""
        return float(np.sum((self.weight * np.square(self.reach))[self.bending]))

    def responses(self, frequency_hz: Array) -> NDArray[np.complex128]:
        """Return displacement over static displacement of each mode, (frequencies, modes)."""
        ratio = 2 * np.pi * frequency_hz[:, None] / self.angular_frequency
        return np.asarray(1 / (1 - np.square(ratio) + 2j * self.damping_ratio * ratio))

    def steady_state(self, frequency_hz: Array, force_n: NDArray[np.complex128]) -> Array:
        """Return Q and P over g [N] at the time 0 under phasors of a force [N], (2, modes)."""
        result = np.zeros((2, len(self.weight)))
        frequencies = self._blocks(frequency_hz)
        forces = self._blocks(force_n)
        for frequency, force in zip(frequencies, forces, strict=True):
            responses = self.responses(frequency)
            result[0] += (force @ responses).real
            result[1] += ((2j * np.pi * frequency * force) @ responses).real
        return result / np.stack((np.ones_like(self.weight), self.angular_frequency))

    def _sum(self, frequency_hz: Array) -> NDArray[np.complex128]:
        """Sum the receptances of the modes, a block of frequencies at a time."""
        compliance = self.weight * np.square(self.reach)
        return np.concatenate([self.responses(f) @ compliance for f in self._blocks(frequency_hz)])

    def _blocks(self, lines: NDArray[Any]) -> list[NDArray[Any]]:
        """Split values over frequency into blocks that bound the memory of all modes."""
        block = max(1, _BLOCK // len(self.weight))
        return np.split(lines, range(block, len(lines), block))

    @cached_property
    def _table(self) -> Any:
        """Tabulate the receptance over the logarithm of frequencies that resolve each resonance."""
        from scipy.interpolate import CubicSpline  # slow to import, for motions only

        own = np.log(self.angular_frequency / (2 * np.pi))
        near = np.sinh(np.linspace(-8, 8, 49)) * self.damping_ratio[:, None]
        least = own.min() - 5
        most = np.log(_HIGHEST_HZ)
        between = np.linspace(least, most, int(150 * (most - least)))
        grid = np.sort(np.concatenate(((own[:, None] + near).ravel(), between)))
        grid = grid[(grid >= least) & (grid <= most)]
        bins = np.floor(grid / (self.damping_ratio.min() / 8))
        grid = grid[np.diff(bins, prepend=-np.inf) > 0]
        return CubicSpline(grid, self._sum(np.exp(grid)))


def modes_of(plate: RectangularPlate, points_m: Array, tail: Array = ROLLING_TAIL) -> Modes:
    """Return the modes of a plate, weighted by their shapes at contact points (n, 2) [m].

    `tail` has the ratios of the edges of its bands above MODES_HZ. The points are one, or lie on a
    straight path at equal distances from its first to its last.
    """
    order = np.arange(plate.mode_count)
    counts = np.zeros(0, np.int64)
    stations = np.zeros((0, 0))
    rigid = 0
    if isinstance(plate, RitzPlate):
        stations = _shapes_on_path(plate, points_m, len(tail))
        rigid = plate.rigid_modes
    else:
        order = np.lexsort(plate.orders.T[::-1])
        counts = np.bincount(plate.orders[:, 0])[1:]
    frequency = plate.angular_frequency[order]
    beyond = np.mean([plate.residual_compliance_m_n(point) for point in points_m])
    starts = 2 * np.pi * MODES_HZ * np.concatenate(([1.0], np.cumprod(tail[:-1])))
    share = np.diff(-1 / starts, append=0.0) * starts[0]  # the last band has no end
    weight = np.mean(np.square(plate.shapes(points_m)), axis=0)[order]
    own_reach = 1 / (frequency * np.sqrt(plate.modal_mass_kg))
    tail_damping = (tail**0.5 - tail**-0.5) / np.pi
    return Modes(
        angular_frequency=np.append(frequency, starts * np.sqrt(tail)),
        damping_ratio=np.append(plate.loss_factors[order] / 2, tail_damping),
        reach=np.append(own_reach, np.sqrt(beyond * share)),
        weight=np.append(weight, np.ones(len(tail))),
        counts=counts,
        sides=np.array([plate.length_m, plate.width_m]),
        point=points_m[:1],
        stations=stations,
        ends=points_m[[0, -1]],
        rigid=rigid,
    )


def _shapes_on_path(plate: RitzPlate, points_m: Array, tail: int) -> Array:
    """Return the shapes at stations on a straight path, 1 for the modes of a tail."""
    begin, end = points_m[[0, -1]]
    count = 1
    way = math.dist(begin, end)
    if way > 0:
        count = 4 + int(np.ceil(_PER_WAVE * way / plate.bending_wavelength_m(MODES_HZ)))
    shapes = plate.shapes(begin + np.linspace(0, 1, count)[:, None] * (end - begin))
    return np.concatenate((shapes, np.ones((count, tail))), axis=1)


def _sinc(x: Array) -> Array:
    """Return sin(x) / x."""
    return np.asarray(np.sinc(x / np.pi))


# ---- chain


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
        a = np.sqrt(complex(k * k - q2))
        b = np.sqrt(complex(k * k - 1))
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
        if self.modes is None:
            return np.zeros((1, 2))
        return self.modes.point

    def steps(self, step_s: float) -> StepBodies:
        """Return the bodies as time steps [s] move them, exact for a force at the resonance.

        Modes faster than the steps ring as fast as these allow. A step holds the force, and takes
        S = 2/h tan(w h/2) for the frequency w of the ball. Other masses of ball and modes undo both
        at the resonance, the ball's (x / tan x)^2 with x = w h/2. Without them 40 steps in a period
        lower the resonance by 0.2 %.
        """
        modes = self.modes
        mass = self.mass_kg
        x0 = np.pi * self.resonance_hz * step_s
        if x0 >= 1:  # the steps do not resolve the resonance, and nothing is corrected
            x0 = 0.0
        if x0 > 0:
            mass = float(mass * (x0 / np.tan(x0)) ** 2)
        if modes is None:
            return StepBodies(
                step=step_s,
                mass=mass,
                mobility=self.mobility_s_kg,
                contact_time=self.contact_time_s,
                fall=np.zeros(0),
                turn=np.zeros(0),
                keep=np.zeros(0),
                reach=np.zeros(0),
                counts=np.zeros(0, np.int64),
                sides=np.ones(2),
                stations=np.zeros((0, 0)),
                ends=np.zeros((2, 2)),
            )
        w = np.minimum(modes.angular_frequency, 2 * _FASTEST / step_s)
        zeta = modes.damping_ratio
        zeta = np.where(np.abs(zeta - 1) < 1e-8, 1 + 1e-8, zeta)  # critical damping has one root
        root = w * np.sqrt(np.square(zeta) - 1 + 0j)
        fast = -zeta * w - root
        slow = np.exp(np.square(w) / fast * step_s)
        fast = np.exp(fast * step_s)
        turn = np.ascontiguousarray((w * (slow - fast) / (2 * root)).real)
        mean = (slow + fast).real / 2
        x = w * step_s / 2
        gain = _sinc(x - x0) * _sinc(x + x0) / np.square(_sinc(x) * np.cos(x0))
        return StepBodies(
            step=step_s,
            mass=mass,
            mobility=0.0,
            contact_time=self.contact_time_s,
            fall=1 - mean - zeta * turn,
            turn=turn,
            keep=mean - zeta * turn,
            reach=modes.reach * np.sqrt(gain),
            counts=modes.counts,
            sides=modes.sides,
            stations=np.ascontiguousarray(modes.stations),
            ends=np.ascontiguousarray(modes.ends),
        )

    def mobilities(self, frequency_hz: ArrayLike) -> dict[str, NDArray[np.complex128]]:
        """Return the mobilities [s/kg] of ball, contact and plate at frequencies [Hz] above 0."""
        frequency = np.asarray(frequency_hz, dtype=float)
        iw = 2j * np.pi * frequency
        plate = np.full_like(iw, self.mobility_s_kg)
        contact = iw / self.stiffness_n_m
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
