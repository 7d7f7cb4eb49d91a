"""What assumed waves around balls and raceways leave uncertain in the bands of a ring.

Linear theory tells which share of a band each order has. A wave law whose amplitude is assumed
moves its share by the decibels by which the amplitude may be off, and one whose exponent is assumed
by more the farther an order is from that at which the amplitude holds. Crests that lie across the
track are an assumption, too: of waves that are as long across as along, the contact averages more,
the wider it is for them. Laws of one kind of body have the same assumption, so their shares add.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array, short_repr
from rolling.bearing.band_uncertainty import DecibelsOfBands
from rolling.bearing.model import BearingModel
from rolling.bearing.ring_record import DIRECTIONS
from rolling.bearing.wave_motion import BALLS, INNER, WaveMotion
from rolling.bearing.waves import SemiAxes, response, semi_axes

# Amplitudes of raceways from half to twice the assumed one, all as likely over their logarithm.
LARGEST_OFF = 2.0
# Exponents from 0.8 to 1.2, all as likely. Below, waves shorter than 0.08 mm along the lay would be
# higher than a stylus reads across it. Above, they would be below 1 nm rms on that length, smoother
# than polished steel.
EXPONENT_OFF = 0.2
ORDER = 3  # at which an amplitude holds, because such orders decide the deviation from roundness
# A grade limits the form of balls, which may be anywhere from a third of the limit on.
LEAST_FORM = 1 / 3
AMPLITUDE_DB = 20 * math.log10(LARGEST_OFF) / math.sqrt(3)
EXPONENT = EXPONENT_OFF / math.sqrt(3)
_DECADES = math.log10(LEAST_FORM)
_ORDERS = 60  # at which contacts are looked at, equally spaced over their logarithm
_WAVES_ACROSS = 400
_NOTHING = 1e-12
FORM_DB = 20 * abs(_DECADES) / math.sqrt(3)  # rms about the limit, which is the end of the range


@dataclass(frozen=True)
class AssumedWaves:
    """Random waves around a body, and how far they may be off.

    body : str. inner, outer or balls, all of which have waves of their own.
    amplitudes_m : array (orders,), m. Root-mean-square amplitude by order, from 0 on.
    exponent : float. Power by which amplitudes fall with the order.
    amplitude_db : float, dB. Standard deviation of the level of all of them.
    exponent_db : array (orders,), dB. Standard deviation of their level by the exponent.
    """

    __repr__ = short_repr

    body: str
    amplitudes_m: Array
    exponent: float
    amplitude_db: float
    exponent_db: Array


def exponent_db(orders: int) -> Array:
    """Return the standard deviation of the level of orders from 0 on by an assumed exponent [dB].

    Levels below and above the order at which the amplitude holds move in opposite directions.
    """
    number = np.maximum(np.arange(orders), 1)
    return np.asarray(20 * EXPONENT * np.log10(number / ORDER))


def order_powers(
    waves: AssumedWaves, model: BearingModel, bands_hz: Mapping[str, tuple[float, float]]
) -> dict[str, dict[str, Array]]:
    """Return the mean square of the ring's velocity by each order of waves [(m/s)^2].

    By direction and band, (orders,).
    """
    motion = WaveMotion(model)
    speeds = model.kinematics
    ring_hz = speeds.inner_hz if waves.body == INNER else speeds.outer_hz
    turn_hz = speeds.ball_spin_hz if waves.body == BALLS else abs(speeds.cage_hz - ring_hz)
    highest_hz = max(high for _, high in bands_hz.values())
    count = min(len(waves.amplitudes_m), math.ceil(highest_hz / turn_hz) + 1)
    followed = _followed(waves.body, model, count)
    bodies = model.geometry.balls if waves.body == BALLS else 1
    powers = {
        direction: {band: np.zeros(len(waves.amplitudes_m)) for band in bands_hz}
        for direction in DIRECTIONS
    }
    for order in np.flatnonzero(waves.amplitudes_m[:count]):
        square = bodies * (waves.amplitudes_m[order] * followed[order]) ** 2 / 2
        for line in motion.of_order(waves.body, int(order)):
            for band, (low, high) in bands_hz.items():
                if not low <= line.frequency_hz < high:
                    continue
                for direction, velocity in line.velocity.items():
                    powers[direction][band][order] += square * velocity**2
    return powers


def _followed(body: str, model: BearingModel, count: int) -> Array:
    """Return how much of the waves of orders up to a count the contacts of a body follow."""
    orders = np.arange(count)
    each = [
        response(orders / radius_m * axes.along) for axes, radius_m in _contacts_of(body, model)
    ]
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
    """Return how much less the contacts would follow waves without crests across the track [dB].

    Such waves have the same profile along the track, and are as long across as along: of a
    power-law profile of exponent s, the density over both wave numbers falls as (k_along^2 +
    k_across^2)^-(s + 1/2). By order, (orders,), negative.
    """
    last = len(waves.amplitudes_m) - 1
    orders = np.geomspace(1, last, _ORDERS)
    # Waves across over the wave along, by steps of equal weight of the density across.
    across = np.geomspace(1e-4, 1e4, _WAVES_ACROSS)
    density = (1 + across**2) ** -(waves.exponent + 0.5) * across  # for each step of the logarithm
    squares = []
    for axes, radius_m in _contacts_of(waves.body, model):
        along = orders / radius_m
        phase = np.hypot(along * axes.along, across[:, None] * along * axes.across)
        mean = (density[:, None] * response(phase) ** 2).sum(axis=0) / density.sum()
        squares.append(mean / np.maximum(response(along * axes.along) ** 2, _NOTHING))
    decibels = 10 * np.log10(np.minimum(np.mean(squares, axis=0), 1.0))
    number = np.maximum(np.arange(last + 1), 1)
    return np.asarray(np.interp(np.log(number), np.log(orders), decibels))


def surfaces_db(
    bodies: Sequence[AssumedWaves],
    model: BearingModel,
    velocity_m_s: Mapping[str, Mapping[str, float]],
    bands_hz: Mapping[str, tuple[float, float]],
) -> DecibelsOfBands:
    """Return what assumed waves leave uncertain in bands [dB], by direction and band.

    Parameters
    ----------
    bodies : sequence of AssumedWaves
        Waves around raceways and balls that are assumed.
    model : BearingModel
        Bearing.
    velocity_m_s : dict, m/s
        Velocity of the ring by direction and band, with all that moves it.
    bands_hz : dict, Hz
        Edges of the bands by their names.
    """
    powers = [order_powers(waves, model, bands_hz) for waves in bodies]
    # Their sense is known: a part is the rms about the stated value, the end of the range.
    crests = [crests_db(waves, model) / math.sqrt(3) for waves in bodies]
    parts: dict[str, dict[str, float]] = {direction: {} for direction in DIRECTIONS}
    for direction in DIRECTIONS:
        for band in bands_hz:
            own = [power[direction][band] for power in powers]
            expected = sum(float(power.sum()) for power in own)
            whole = max(velocity_m_s[direction][band] ** 2, expected)
            parts[direction][band] = _joined_db(bodies, own, crests, whole)
    return parts


def _joined_db(
    bodies: Sequence[AssumedWaves],
    powers: Sequence[Array],
    crests: Sequence[Array],
    whole: float,
) -> float:
    """Return the decibels of a band, whose power is given, by the orders of all bodies."""
    if not whole > 0:
        return 0.0
    by_assumption: dict[tuple[bool, str], float] = {}
    for waves, power, crest_db in zip(bodies, powers, crests, strict=True):
        is_ball = waves.body == BALLS
        for name, decibels in (
            ("amplitude", waves.amplitude_db * float(power.sum())),
            ("exponent", float(waves.exponent_db @ power)),
            ("crests", float(crest_db @ power)),
        ):
            key = (is_ball, name)
            by_assumption[key] = by_assumption.get(key, 0.0) + decibels / whole
    return math.hypot(*by_assumption.values())
