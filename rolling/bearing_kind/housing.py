"""Sound of a housing plate that a bearing shakes.

The ring that moves is a source of vibration: it has a free velocity, which the motion without a
housing gives, and a mobility. A plate that is fixed to it takes a force that follows from both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acoustics import wav
from acoustics.arrays import Array, short_repr
from acoustics.bands import AUDIBLE_HZ
from acoustics.level import SoundLevels, sound_levels
from acoustics.rectangular_plate import Listener, RectangularPlate
from rolling.bearing.linear_ring import LinearRing
from rolling.dynamics.bodies import modes_of
from rolling.in_si.physics_of_scene import plate_of
from rolling.scene.bearing_scene import BearingScene
from rolling.sound.contact_sound import faded

Mobility = Callable[[Array], NDArray[np.complex128]]
SILENCE_S = 0.25  # [s] that follows a record at least, so that its ringing does not wrap round


@dataclass(frozen=True, eq=False)
class HousingSound:
    """Sound of a housing plate, with the motion behind it, at `acoustics.wav.SAMPLE_RATE_HZ`.

    pressure : (samples,) array, Pa. Sound pressure at the listener.
    force_n : (samples,) array, N. Force of the ring on the plate, normal to it.
    velocity_m_s : (samples,) array, m/s. Velocity of plate and ring together.
    levels : SoundLevels, dB. Levels of the pressure.
    """

    __repr__ = short_repr

    pressure: Array
    force_n: Array
    velocity_m_s: Array
    levels: SoundLevels


def housing_of_scene(
    scene: BearingScene, ring: LinearRing, free_velocity_m_s: Array
) -> HousingSound | None:
    """Return the sound of the housing plate of a scene, None for a scene without one.

    The plate is shaken along the direction of the radial load, x, and heard above `contact_mm`.

    Parameters
    ----------
    scene : BearingScene
    ring : LinearRing
        Ring on the mean stiffness of its balls.
    free_velocity_m_s : array (samples,), m/s
        Velocity of the ring along x, at `acoustics.wav.SAMPLE_RATE_HZ`.
    """
    if scene.plate is None:
        return None
    plate = plate_of(scene.plate).with_edges
    assert plate is not None  # the plate of a housing has edges, a mass and a loss factor
    contact = 1e-3 * np.array(scene.plate.contact_ends_mm["contact_mm"])
    x, y = contact.tolist()

    def mobility(frequency_hz: Array) -> NDArray[np.complex128]:
        """Return the mobility of the ring along x."""
        return ring.mobility(frequency_hz)[:, 0, 0]

    return housing_sound(
        plate=plate,
        contact_m=contact,
        listener_m=(x, y, scene.sound.distance_m),
        ring_mobility=mobility,
        free_velocity_m_s=free_velocity_m_s,
    )


def plate_mobility(
    plate: RectangularPlate, contact_m: Array, frequency_hz: Array
) -> NDArray[np.complex128]:
    """Return the velocity per force [m/(N s)] of a plate with edges at a point (2,) [m]."""
    receptance = modes_of(plate, contact_m[None]).receptance(frequency_hz)
    return np.asarray(2j * np.pi * frequency_hz * receptance)


def housing_sound(
    plate: RectangularPlate,
    contact_m: Array,
    listener_m: Listener,
    ring_mobility: Mobility,
    free_velocity_m_s: Array,
) -> HousingSound:
    """Let a ring shake a plate that is fixed to it, and return the sound of the plate.

    The plate takes the force v / (Y_r + Y_p), where v is the free velocity of the ring, Y_r its
    mobility on its balls and Y_p the mobility of the plate. Both mobilities are linear: the balls
    have to stay in contact.

    Parameters
    ----------
    plate : RectangularPlate
        Plate with edges, in a baffle.
    contact_m : array (2,), m
        Middle of the bearing, from a corner of the plate.
    listener_m : x, y, z, m
        Listener from the same corner.
    ring_mobility : function
        Velocity per force [m/(N s)] of the ring at frequencies [Hz], normal to the plate.
    free_velocity_m_s : array (samples,), m/s
        Velocity of the ring without a plate, at `acoustics.wav.SAMPLE_RATE_HZ`.

    Returns
    -------
    HousingSound

    References
    ----------
    L. Cremer, M. Heckl, B. A. T. Petersson, Structure-Borne Sound, 3rd ed. (2005), chapter 5: a
    source by its free velocity and mobility.
    """
    from scipy.fft import next_fast_len  # slow to import

    rate = wav.SAMPLE_RATE_HZ
    samples = len(free_velocity_m_s)
    free = faded(free_velocity_m_s, samples / rate)
    count = int(next_fast_len(samples + max(samples, round(SILENCE_S * rate)), real=True))
    frequency = np.asarray(np.fft.rfftfreq(count, 1 / rate))
    lines = np.flatnonzero((frequency >= AUDIBLE_HZ[0]) & (frequency < AUDIBLE_HZ[1]))
    heard_hz = frequency[lines]
    of_plate = plate_mobility(plate, contact_m, heard_hz)
    of_ring = ring_mobility(heard_hz)
    force = np.fft.rfft(free, count)[lines] / (of_ring + of_plate)
    transfer = plate.pressure_transfer(heard_hz, contact_m, listener_m)

    def in_time(of_lines: NDArray[Any]) -> Array:
        """Return the record of a spectrum at the audible lines."""
        spectrum = np.zeros(len(frequency), dtype=complex)
        spectrum[lines] = of_lines
        return np.asarray(np.fft.irfft(spectrum, count)[:samples])

    pressure = in_time(force * transfer)
    return HousingSound(
        pressure=pressure,
        force_n=in_time(force),
        velocity_m_s=in_time(force * of_plate),
        levels=sound_levels(pressure, rate),
    )
