"""Sound of a plate with edges, and of the sphere on it, at listeners anywhere.

Delays count from the arrival of the sound from the first contact point at the first listener, so
stereo keeps its differences. A moving contact excites each mode by its shape under the contact. The
sphere is heard from the middle of its path, and above the plate only: the baffle hides it below.
"""

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics import resampling, wav
from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ
from acoustics.radiation import SOUND_M_S, axis_transfer
from acoustics.rectangular_plate import Complex, RectangularPlate
from rolling.contact.track import Motion
from rolling.dynamics.ball_on_plate import BallOnPlate, PlateBody
from rolling.dynamics.motion_of_ball import contact_path
from rolling.sound.contact_sound import faded_out
from rolling.sound.receivers import Listener, Place

WRAPPED = 1e-4  # part of the ringing of an open record that is left of it at its beginning
_MIN_S = 0.25  # [s] of an open record with silence, at least twice
_POINTS = 9  # of a path over which powers are averaged
_BLOCK = 2**21  # values of modes in time or frequency at once
_STRETCH_S = 1.0  # [s] of a record on a path, for modes that fade as fast
_PER_WAVE = 12  # stations of a path in the shortest bending wave that is heard
_PER_WIDTH = 4  # frequencies of a table of powers in the width of a mode
_TABLE_SIZES = (2000, 40_000)  # limits of the number of frequencies of such a table


def pressures(
    bodies: BallOnPlate,
    listener: Listener,
    motion: Motion,
    force: Array,
    closed: bool,
    count: int | None = None,
) -> Array:
    """Return the sound pressure [Pa] of a force [N] at first places, (places, samples).

    An open record begins in silence and ends with its duration: the ringing beyond fades out.

    Parameters
    ----------
    bodies : BallOnPlate. Ball, and plate with edges.
    listener : Listener. Listener with places beside the plate.
    motion : Motion. Distance and speed over time, for a contact that moves on the plate.
    force : (samples,) array, N. Force at the rate of the sound.
    closed : bool. If true, the record repeats without a click.
    count : int. Number of the first places. Default: all.
    """
    plate = bodies.plate.with_edges
    assert plate is not None  # asked for plates with edges alone
    n = len(force)
    rate = wav.SAMPLE_RATE_HZ
    growth = 0.0
    if not closed:
        from scipy.fft import next_fast_len  # slow to import

        n = int(next_fast_len(2 * max(n, round(_MIN_S * rate)), real=True))
        # Waves that fall with time by this rate do not wrap round; the record is raised again.
        growth = -math.log(WRAPPED) * rate / n
    times = np.arange(len(force)) / rate
    places = listener.places_m[:count]
    fallen = force * np.exp(-growth * times)
    frequency = np.asarray(np.fft.rfftfreq(n, 1 / rate) - 0.5j * growth / np.pi, dtype=complex)
    lines = np.arange(len(frequency))
    if closed:
        lines = lines[(frequency.real >= AUDIBLE_HZ[0]) & (frequency.real < AUDIBLE_HZ[1])]
    audible = frequency[lines]
    spectrum = np.fft.rfft(fallen, n)[lines]
    reference = _reference_distance(bodies.plate, listener)
    of_ball = [_ball_transfer(bodies, listener, audible, place) for place in places]
    path = contact_path(bodies.plate, motion)
    if path is None:
        points = None
        point = points_on_path(bodies.plate)[0]
        of_plate = [plate.pressure_transfer(audible, point, place, reference) for place in places]
        total = (np.array(of_plate) + np.array(of_ball)) * spectrum
    else:
        points = path(times)
        total = np.array(of_ball) * spectrum
        for modes in _mode_blocks(0, _lasting_modes(plate, fallen), n):
            forces = np.fft.rfft(fallen[:, None] * plate.shapes(points, modes), n, axis=0)[lines]
            for pressure, place in zip(total, places, strict=True):
                transfer = plate.mode_transfer(audible, place, reference, modes)
                pressure += np.einsum("nm,nm->n", transfer, forces)
    records = np.zeros((len(places), len(frequency)), dtype=complex)
    records[:, lines] = total
    in_time = np.fft.irfft(records, n, axis=1)[:, : len(force)] * np.exp(growth * times)
    if closed:
        return np.asarray(in_time)
    if points is not None:
        stations = _stations(bodies.plate, plate, points)
        in_time += _pressure_of_fading_modes(plate, force, places, stations, reference)
    ending = [faded_out(record, len(force) / rate) for record in in_time]
    return np.array([resampling.band_limit(record, rate) for record in ending])


def _lasting_modes(plate: RectangularPlate, force: Array) -> int:
    """Return the number of modes, the lowest, that ring for longer than a stretch of a record."""
    if len(force) <= 2 * _STRETCH_S * wav.SAMPLE_RATE_HZ:
        return len(plate.angular_frequency)
    own = plate.loss_factor_at(plate.angular_frequency / (2 * np.pi))
    decays = plate.angular_frequency * own / 2 * _STRETCH_S
    return int(np.sum(decays < -math.log(WRAPPED)))


def _mode_blocks(first: int, last: int, values: int) -> list[slice]:
    """Split modes into blocks that bound the memory of so many values for each mode."""
    count = max(1, _BLOCK // values)
    return [slice(k, min(k + count, last)) for k in range(first, last, count)]


class _Stations(NamedTuple):
    """Stations on the path of a contact, between which a transfer is linear.

    points : (stations, 2) array, m. Stations from a corner of the plate.
    places : (samples,) array. Place of the contact among the stations at each sample.
    """

    points: Array
    places: Array


def _pressure_of_fading_modes(
    plate: RectangularPlate,
    force: Array,
    listeners: tuple[Place, ...],
    stations: _Stations,
    reference: float,
) -> Array:
    """Return the pressure [Pa] at listeners of the modes that fade within a stretch of a record.

    The force is divided among stations of the path, between which the transfer is linear.
    `reference` [m] is the distance from which delays count.
    """
    rate = wav.SAMPLE_RATE_HZ
    modes = len(plate.angular_frequency)
    hop = round(_STRETCH_S * rate)
    lead = rate // 10
    first_mode = _lasting_modes(plate, force)
    n = 2 * hop + lead
    records = np.zeros((len(listeners), len(force) + 2 * (hop + lead)))
    if first_mode < modes:
        frequency = np.asarray(np.fft.rfftfreq(n, 1 / rate), dtype=float)
        count = len(stations.points)
        transfers = np.zeros((len(listeners), len(frequency), count), dtype=complex)
        for part in _mode_blocks(first_mode, modes, n):
            shapes = plate.shapes(stations.points, part).T
            for transfer, listener in zip(transfers, listeners, strict=True):
                transfer += plate.mode_transfer(frequency, listener, reference, part) @ shapes
        for first in range(0, len(force), hop):
            place = stations.places[first : first + hop]
            near = np.arange(int(place.min()), min(int(place.max()) + 2, count))
            shares = np.maximum(0, 1 - np.abs(place[:, None] - near))
            lines = np.fft.rfft(force[first : first + hop, None] * shares, n, axis=0)
            for record, transfer in zip(records, transfers, strict=True):
                pressure = np.fft.irfft(np.einsum("nk,nk->n", transfer[:, near], lines), n)
                # Sound that comes before that from the first contact point wraps to the end.
                record[first : first + n] += np.roll(pressure, lead)
    return records[:, lead : lead + len(force)]


def _stations(body: PlateBody, plate: RectangularPlate, points: Array) -> _Stations:
    """Return stations on the path of a plate, and the places among them of contact points."""
    begin, end = points_on_path(body)[[0, -1]]
    way = math.dist(begin, end)
    spaces = math.ceil(_PER_WAVE * way / plate.bending_wavelength_m(AUDIBLE_HZ[1]))
    places = spaces * np.linalg.norm(points - begin, axis=1) / way
    return _Stations(
        points=begin + np.linspace(0, 1, spaces + 1)[:, None] * (end - begin),
        places=places,
    )


def transfers(
    bodies: BallOnPlate, listener: Listener, plate: RectangularPlate, frequency: Array
) -> NDArray[np.complex128]:
    """Return the pressure per force [Pa/N] at the first place, (contact points, frequencies).

    `plate` is that of the bodies, whose modes are kept from call to call.
    """
    place = listener.places_m[0]
    reference = _reference_distance(bodies.plate, listener)
    of_ball = _ball_transfer(bodies, listener, frequency, place)
    of_points = [
        plate.pressure_transfer(frequency, point, place, reference) + of_ball
        for point in points_on_path(bodies.plate)
    ]
    return np.asarray(of_points)


def power_per_force(plate: RectangularPlate, points: Array, frequency: Array) -> Array:
    """Return the sound power of a plate per mean square force [W/N2] at ascending frequencies.

    It is the mean over contact points (n, 2) [m]. Between the frequencies of a grid that resolves
    each mode it is interpolated.
    """
    octaves = math.log(AUDIBLE_HZ[1] / AUDIBLE_HZ[0])
    least, most = _TABLE_SIZES
    count = int(np.clip(_PER_WIDTH * octaves / plate.least_loss_factor, least, most))
    if len(frequency) <= count or not plate.mode_count:
        return plate.power_per_force(frequency, points)
    hashable_points = tuple(tuple(point) for point in points.tolist())
    grid, power = _power_table(plate, hashable_points, count)
    return np.asarray(np.exp(np.interp(np.log(frequency), np.log(grid), power)))


@lru_cache(maxsize=8)
def _power_table(
    plate: RectangularPlate, points: tuple[tuple[float, ...], ...], count: int
) -> tuple[Array, Array]:
    """Return frequencies, and the logarithm of the power per force, as a mean over points [m]."""
    grid = np.asarray(np.geomspace(AUDIBLE_HZ[0], AUDIBLE_HZ[1], count))
    power = plate.power_per_force(grid, points)
    return grid, np.asarray(np.log(np.maximum(power, np.finfo(float).tiny)))


def points_on_path(plate: PlateBody) -> Array:
    """Return the contact point, or points of its path at equal distances, (n, 2) [m]."""
    return plate.points_between_ends(_POINTS)


def _reference_distance(plate: PlateBody, listener: Listener) -> float:
    """Return the distance [m] from the first contact point to the first place of a listener."""
    x, y = points_on_path(plate)[0]
    return math.dist((x, y, 0.0), listener.places_m[0])


def _ball_transfer(
    bodies: BallOnPlate, listener: Listener, frequency: NDArray[Any], place: Place
) -> Complex:
    """Return the pressure of the sphere per force [Pa/N] at a place, from the middle of its path.

    A listener does not hear the sphere from below the plate.
    """
    if not listener.hears_ball or place[2] < 0:
        return np.zeros(len(frequency), dtype=complex)
    x, y = points_on_path(bodies.plate)[[0, -1]].mean(axis=0)
    distance = math.dist((x, y, 0.0), place)
    pressure = axis_transfer(frequency, bodies.ball, distance, place[2] / distance)
    further = distance - _reference_distance(bodies.plate, listener)
    return np.asarray(pressure * np.exp(-2j * np.pi * frequency * further / SOUND_M_S))
