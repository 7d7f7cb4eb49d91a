"""What assumed surfaces of balls and raceways leave uncertain in the bands of a ring.

Linear theory tells which share of a band each order has. A wave law whose amplitude is assumed
moves its share by the decibels by which the amplitude may be off, and one whose exponent is assumed
by more the farther an order is from that at which the amplitude holds. Whether crests lie across
the track is an assumption, too: a contact that is wide for a wave averages it more if it is as long
across as along. Laws of one kind of body have the same assumption, so their shares add.

Roughness moves the ring by the linear response of its contacts. An assumed Ra or correlation length
counts by the levels of a band at the ends of its range.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.bearing.band_uncertainty import DecibelsOfBands
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_record import DIRECTIONS, RADIAL
from rolling.bearing.wave_motion import BALLS, INNER, WaveMotion
from rolling.bearing.waves import SemiAxes, isotropic_response, response, semi_axes

# Amplitudes of raceways from half to twice the assumed one, all as likely over their logarithm.
LARGEST_OFF = 2.0
# Exponents from 0.8 to 1.2, all as likely. Below, waves shorter than 0.08 mm along the lay would be
# higher than a stylus reads across it. Above, they would be below 1 nm rms on that length, smoother
# than polished steel.
EXPONENT_OFF = 0.2
ORDER = 3  # at which an amplitude holds, because such orders decide the deviation from roundness
# A grade limits the form of balls, which may be anywhere from a third of the limit on.
LEAST_FORM = 1 / 3
# Ra and correlation lengths of a finish, from half to twice the assumed ones, as likely.
ROUGHNESS_OFF = 2.0
AMPLITUDE_DB = 20 * math.log10(LARGEST_OFF) / math.sqrt(3)
EXPONENT = EXPONENT_OFF / math.sqrt(3)
FORM_DB = -20 * math.log10(LEAST_FORM) / math.sqrt(3)  # rms about the limit, the end of the range
_NOTHING = 1e-12
OrderGains = Mapping[str, Mapping[str, Array]]  # by direction and band, (orders,)
_HIGHEST_ACROSS = 8.0  # wave number times correlation length across, beyond which are no waves
_STEP_ACROSS = 0.5  # of the wave number times the semi-axis across or the correlation length


@dataclass(frozen=True)
class AssumedWaves:
    """Random waves around a body, and how far they may be off.

    body : str. inner, outer or balls, all of which have waves of their own.
    amplitudes_m : array (orders,), m. Root-mean-square amplitude by order, from 0 on.
    exponent : float. Power by which amplitudes fall with the order.
    isotropic : bool. Whether they are as long across as along; otherwise crests lie across.
    amplitude_db : float, dB. Standard deviation of the level of all of them.
    exponent_db : array (orders,), dB. Standard deviation of their level by the exponent.
    """

    __repr__ = short_repr

    body: str
    amplitudes_m: Array
    exponent: float
    isotropic: bool
    amplitude_db: float
    exponent_db: Array

    @property
    def is_stated(self) -> bool:
        """Whether nothing of them is assumed, so that they only share the power of a band."""
        return not self.amplitude_db and not self.exponent_db.any()


class RoughnessLaw(NamedTuple):
    """Random heights with a Gaussian autocorrelation.

    rq_m : float, m. Root-mean-square height.
    along_m, across_m : float, m. Correlation lengths along and across the track.
    """

    rq_m: float
    along_m: float
    across_m: float


@dataclass(frozen=True)
class AssumedRoughness:
    """Roughness of a raceway, and how far it may be off.

    body : str. inner or outer.
    law : RoughnessLaw.
    others : dict. The laws at the lower and at the upper end of the range of each assumed value,
        which is RA, LENGTH or LENGTH_ACROSS.
    """

    body: str
    law: RoughnessLaw
    others: Mapping[str, tuple[RoughnessLaw, RoughnessLaw]]


AssumedSurface = AssumedWaves | AssumedRoughness


def exponent_db(orders: int) -> Array:
    """Return the standard deviation of the level of orders from 0 on by an assumed exponent [dB].

    Levels below and above the order at which the amplitude holds move in opposite directions.
    """
    number = np.maximum(np.arange(orders), 1)
    return np.asarray(20 * EXPONENT * np.log10(number / ORDER))


def order_powers(
    waves: AssumedWaves, model: BearingModel, gains: OrderGains
) -> dict[str, dict[str, Array]]:
    """Return the mean square of the ring's velocity by each order of waves [(m/s)^2].

    By direction and band, (orders,), from gains of orders around the body, as of `order_gains`.
    """
    orders = len(waves.amplitudes_m)
    powers: dict[str, dict[str, Array]] = {direction: {} for direction in DIRECTIONS}
    for direction, of_bands in gains.items():
        for band, gain in of_bands.items():
            count = min(orders, len(gain))
            amplitudes = waves.amplitudes_m[:count] * _followed(waves, model, count)
            powers[direction][band] = np.zeros(orders)
            powers[direction][band][:count] = gain[:count] * np.square(amplitudes)
    return powers


def roughness_powers(
    body: str, law: RoughnessLaw, model: BearingModel, gains: OrderGains
) -> dict[str, dict[str, float]]:
    """Return the mean square of the ring's velocity by the roughness of a raceway [(m/s)^2].

    By direction and band. The contacts are closed and follow heights by their linear response.

    Parameters
    ----------
    body : str
        inner or outer.
    law : RoughnessLaw
        Heights.
    model : BearingModel
        Bearing.
    gains : dict, 1/s2
        Gains of orders around the body, as of `order_gains`.
    """
    orders = len(gains[RADIAL][next(iter(gains[RADIAL]))])
    ((axes, radius_m),) = _contacts_of(body, model)
    along = np.arange(orders) / radius_m
    steps = math.ceil(_HIGHEST_ACROSS / _STEP_ACROSS * max(1.0, axes.across / law.across_m))
    across, step = np.linspace(0, _HIGHEST_ACROSS / law.across_m, steps, retstep=True)
    density = np.exp(-((across * law.across_m / 2) ** 2)) * law.across_m / math.sqrt(math.pi)
    line = law.along_m / math.sqrt(math.pi) * np.exp(-((along * law.along_m / 2) ** 2))
    count = int(np.count_nonzero(line > _NOTHING * line[0]))  # of orders that have any height
    followed = response(np.hypot(along[:count, None] * axes.along, across * axes.across)) ** 2
    # Twice the mean square of the approach by each order; no order 0.
    square = np.zeros(orders)
    square[:count] = np.trapezoid(followed * density, dx=step)
    square *= 2 * law.rq_m**2 / radius_m * line
    square[0] = 0.0
    return {
        direction: {band: float(gain @ square) for band, gain in of_bands.items()}
        for direction, of_bands in gains.items()
    }


def order_gains(
    body: str, model: BearingModel, bands_hz: Mapping[str, tuple[float, float]], orders: int
) -> OrderGains:
    """Return the mean square of the ring's velocity over that of amplitudes of each order [1/s2].

    Contacts follow the orders in full, and all balls have waves of their own.

    Parameters
    ----------
    body : str
        inner, outer or balls.
    model : BearingModel
        Bearing.
    bands_hz : dict, Hz
        Edges of the bands by their names.
    orders : int
        Number of orders from 0 on; fewer are returned where the bands end below them.
    """
    motion = WaveMotion(model)
    speeds = model.kinematics
    ring_hz = speeds.inner_hz if body == INNER else speeds.outer_hz
    turn_hz = speeds.ball_spin_hz if body == BALLS else abs(speeds.cage_hz - ring_hz)
    highest_hz = max(high for _, high in bands_hz.values())
    count = min(orders, math.ceil(highest_hz / turn_hz) + 1)
    bodies = model.geometry.balls if body == BALLS else 1
    gains = {direction: {band: np.zeros(count) for band in bands_hz} for direction in DIRECTIONS}
    numbers = range(1, count)
    for order, lines in zip(numbers, motion.of_orders(body, numbers), strict=True):
        for line in lines:
            for band, (low, high) in bands_hz.items():
                if not low <= line.frequency_hz < high:
                    continue
                for direction, velocity in line.velocity.items():
                    gains[direction][band][order] += bodies * velocity**2 / 2
    return gains


def _followed(waves: AssumedWaves, model: BearingModel, count: int) -> Array:
    """Return how much of the waves of orders up to a count the contacts of a body follow."""
    each = []
    for axes, radius_m in _contacts_of(waves.body, model):
        phase = np.arange(count) / radius_m * axes.along
        if waves.isotropic:
            each.append(isotropic_response(phase, axes, waves.exponent))
        else:
            each.append(response(phase))
    return np.asarray(np.mean(each, axis=0))


def _contacts_of(body: str, model: BearingModel) -> list[tuple[SemiAxes, float]]:
    """Return the semi-axes of the contacts of a body, and the radius of the body at each [m]."""
    geometry = model.geometry
    load_n = float(np.mean([balance.ball_load_n.mean() for balance in model.balances()]))
    if body == BALLS:
        both = (geometry.inner, geometry.outer)
        return [(semi_axes(contact, load_n), geometry.ball_radius_m) for contact in both]
    contact = geometry.inner if body == INNER else geometry.outer
    return [(semi_axes(contact, load_n), contact.radius_m)]


def crests_db(waves: AssumedWaves, model: BearingModel) -> Array:
    """Return how much less contacts follow isotropic waves than those with crests across [dB].

    By order, (orders,), negative.
    """
    squares = []
    for axes, radius_m in _contacts_of(waves.body, model):
        phase = np.arange(len(waves.amplitudes_m)) / radius_m * axes.along
        isotropic = isotropic_response(phase, axes, waves.exponent)
        squares.append(np.square(isotropic) / np.maximum(np.square(response(phase)), _NOTHING))
    return np.asarray(10 * np.log10(np.clip(np.mean(squares, axis=0), _NOTHING, 1.0)))


AMPLITUDE = "amplitude"
OF_EXPONENT = "exponent"
CRESTS = "crests"
RA = "ra"
LENGTH = "length"
LENGTH_ACROSS = "length_across"


class _SurfaceInBand(NamedTuple):
    """What a surface makes of a band.

    power : float, (m/s)^2. Its mean square of the ring's velocity.
    weighted_db : dict, dB (m/s)^2. By assumption, the sum over orders of decibels times power.
    ends : dict, (m/s)^2. By assumption, its power at the lower and the upper end of the range.
    """

    power: float
    weighted_db: Mapping[str, float]
    ends: Mapping[str, tuple[float, float]]

    def decibels(self, whole: float) -> dict[str, float]:
        """Return what assumptions leave uncertain in a band whose power is given [dB], signed."""
        if not whole > 0:
            return {}
        levels_db = {name: weighted / whole for name, weighted in self.weighted_db.items()}
        rest = max(whole - self.power, 0.0)
        for name, (low, high) in self.ends.items():
            ratio = max(rest + high, _NOTHING * whole) / max(rest + low, _NOTHING * whole)
            levels_db[name] = 10 * math.log10(ratio) / math.sqrt(12)
        return levels_db


_OfBands = dict[str, dict[str, _SurfaceInBand]]  # by direction and band


def _of_surfaces(
    surfaces: Sequence[AssumedSurface],
    model: BearingModel,
    bands_hz: Mapping[str, tuple[float, float]],
) -> list[_OfBands]:
    """Return what each surface makes of bands, by direction and band."""
    orders: dict[str, int] = {}
    for surface in surfaces:
        orders[surface.body] = max(orders.get(surface.body, 1), _orders_of(surface, model))
    gains = {body: order_gains(body, model, bands_hz, count) for body, count in orders.items()}
    return [
        _of_roughness(surface, model, gains[surface.body])
        if isinstance(surface, AssumedRoughness)
        else _of_waves(surface, model, gains[surface.body])
        for surface in surfaces
    ]


def _orders_of(surface: AssumedSurface, model: BearingModel) -> int:
    """Return how many orders of a surface have heights: a slow ring has millions below a band."""
    if isinstance(surface, AssumedWaves):
        return len(surface.amplitudes_m)
    ((_, radius_m),) = _contacts_of(surface.body, model)
    shortest_m = surface.law.along_m
    for low, high in surface.others.values():
        shortest_m = min(shortest_m, low.along_m, high.along_m)
    return math.ceil(2 * radius_m / shortest_m * math.sqrt(-math.log(_NOTHING))) + 1


def _of_waves(waves: AssumedWaves, model: BearingModel, gains: OrderGains) -> _OfBands:
    """Return what waves make of bands, by direction and band."""
    levels_db: dict[str, Array] = {}
    if not waves.is_stated:
        # Surfaces with and without crests are the ends of the range, one of which is stated.
        levels_db = {
            AMPLITUDE: np.full(len(waves.amplitudes_m), waves.amplitude_db),
            OF_EXPONENT: waves.exponent_db,
            CRESTS: crests_db(waves, model) / math.sqrt(3),
        }
    return {
        direction: {
            band: _SurfaceInBand(
                power=float(power.sum()),
                weighted_db={name: float(level @ power) for name, level in levels_db.items()},
                ends={},
            )
            for band, power in of_bands.items()
        }
        for direction, of_bands in order_powers(waves, model, gains).items()
    }


def _of_roughness(surface: AssumedRoughness, model: BearingModel, gains: OrderGains) -> _OfBands:
    """Return what the roughness of a raceway makes of bands, by direction and band."""
    own = roughness_powers(surface.body, surface.law, model, gains)
    ends = {
        name: [roughness_powers(surface.body, law, model, gains) for law in laws]
        for name, laws in surface.others.items()
    }
    return {
        direction: {
            band: _SurfaceInBand(
                power=power,
                weighted_db={},
                ends={
                    name: (low[direction][band], high[direction][band])
                    for name, (low, high) in ends.items()
                },
            )
            for band, power in of_bands.items()
        }
        for direction, of_bands in own.items()
    }


def surfaces_db(
    surfaces: Sequence[AssumedSurface],
    model: BearingModel,
    velocity_m_s: Mapping[str, Mapping[str, float]],
    bands_hz: Mapping[str, tuple[float, float]],
) -> DecibelsOfBands:
    """Return what assumed surfaces leave uncertain in bands [dB], by direction and band.

    Parameters
    ----------
    surfaces : sequence of AssumedWaves and AssumedRoughness
        Waves around raceways and balls, and roughness of raceways, that are assumed.
    model : BearingModel
        Bearing.
    velocity_m_s : dict, m/s
        Velocity of the ring by direction and band, with all that moves it.
    bands_hz : dict, Hz
        Edges of the bands by their names.
    """
    of_surfaces = _of_surfaces(surfaces, model, bands_hz)
    parts: dict[str, dict[str, float]] = {direction: {} for direction in DIRECTIONS}
    for direction in DIRECTIONS:
        for band in bands_hz:
            own = [bands[direction][band] for bands in of_surfaces]
            whole = max(velocity_m_s[direction][band] ** 2, sum(part.power for part in own))
            by_assumption: dict[tuple[bool, str], float] = {}
            for surface, part in zip(surfaces, own, strict=True):
                for name, decibels in part.decibels(whole).items():
                    key = (surface.body == BALLS, name)
                    by_assumption[key] = by_assumption.get(key, 0.0) + decibels
            parts[direction][band] = math.hypot(*by_assumption.values())
    return parts


def assumptions_db(
    surfaces: Sequence[AssumedSurface],
    model: BearingModel,
    bands_hz: Mapping[str, tuple[float, float]],
) -> dict[tuple[str, str], dict[str, float]]:
    """Return what each assumption about surfaces leaves uncertain in bands radially [dB].

    By body and assumption, AMPLITUDE, OF_EXPONENT and CRESTS of waves and RA, LENGTH and
    LENGTH_ACROSS of roughness, then by band. Nothing but these surfaces moves the ring.
    """
    of_surfaces = [bands[RADIAL] for bands in _of_surfaces(surfaces, model, bands_hz)]
    worth: dict[tuple[str, str], dict[str, float]] = {}
    for band in bands_hz:
        whole = sum(bands[band].power for bands in of_surfaces)
        for surface, bands in zip(surfaces, of_surfaces, strict=True):
            for name, decibels in bands[band].decibels(whole).items():
                worth.setdefault((surface.body, name), dict.fromkeys(bands_hz, 0.0))
                worth[surface.body, name][band] = abs(decibels)
    return worth
