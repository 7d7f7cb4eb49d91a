"""What assumed waves around balls and raceways leave uncertain in the bands of a ring.

Linear theory tells which share of a band each order has. A wave law whose amplitude is assumed
moves its share by the decibels by which the amplitude may be off, and one whose exponent is assumed
by more the farther an order is from that at which the amplitude holds. Whether crests lie across
the track is an assumption, too: a contact that is wide for a wave averages it more if it is as long
across as along. Laws of one kind of body have the same assumption, so their shares add.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

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
AMPLITUDE_DB = 20 * math.log10(LARGEST_OFF) / math.sqrt(3)
EXPONENT = EXPONENT_OFF / math.sqrt(3)
FORM_DB = -20 * math.log10(LEAST_FORM) / math.sqrt(3)  # rms about the limit, the end of the range
_NOTHING = 1e-12


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
    followed = _followed(waves, model, count)
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
    # Surfaces with and without crests are the ends of the range, one of which is stated.
    crests = [crests_db(waves, model) / math.sqrt(3) for waves in bodies]
    parts: dict[str, dict[str, float]] = {direction: {} for direction in DIRECTIONS}
    for direction in DIRECTIONS:
        for band in bands_hz:
            own = [power[direction][band] for power in powers]
            expected = sum(float(power.sum()) for power in own)
            whole = max(velocity_m_s[direction][band] ** 2, expected)
            parts[direction][band] = _joined_db(bodies, own, crests, whole)
    return parts


AMPLITUDE = "amplitude"
OF_EXPONENT = "exponent"
CRESTS = "crests"


def assumptions_db(
    bodies: Sequence[AssumedWaves],
    model: BearingModel,
    bands_hz: Mapping[str, tuple[float, float]],
) -> dict[tuple[str, str], dict[str, float]]:
    """Return what each assumption about waves leaves uncertain in bands radially [dB].

    By body and AMPLITUDE, OF_EXPONENT or CRESTS, then by band. Nothing but these waves moves the
    ring.
    """
    powers = [order_powers(waves, model, bands_hz)[RADIAL] for waves in bodies]
    worth: dict[tuple[str, str], dict[str, float]] = {}
    for waves, power in zip(bodies, powers, strict=True):
        orders = len(waves.amplitudes_m)
        crest_db = crests_db(waves, model) / math.sqrt(3)
        for name, level_db in (
            (AMPLITUDE, np.full(orders, waves.amplitude_db)),
            (OF_EXPONENT, waves.exponent_db),
            (CRESTS, crest_db),
        ):
            worth[waves.body, name] = {}
            for band in bands_hz:
                whole = sum(float(other[band].sum()) for other in powers)
                own_db = abs(float(level_db @ power[band])) / whole if whole > 0 else 0.0
                worth[waves.body, name][band] = own_db
    return worth


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
