"""A room to listen in: a record as it sounds with the diffuse sound of a room behind it.

It serves the ear alone. Levels are those of the record itself, in the free field.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from acoustics.arrays import Array, positive, real_array, within
from acoustics.radiation import SOUND_M_S
from acoustics.traps import ignoring_underflow

VOLUME_M3 = 50.0  # a living room
SHORTEST_S = 0.1
LONGEST_S = 10.0
HUMIDITY_PERCENT = 50.0
# Third octaves in which sound dies away; below the first the air takes next to nothing.
_BANDS_HZ = 1000.0 * 2.0 ** (np.arange(13) / 3.0)
_SABINE = 24.0 * math.log(10.0)  # absorption area times c T over the volume
_NEPER_DB = 10.0 / math.log(10.0)  # decibels of a power that falls by e
_KELVIN = 293.15


def air_attenuation_db_m(frequency_hz: ArrayLike, humidity_percent: float) -> Array:
    """Return the attenuation of sound in air of 20 degrees and 1 atm [dB/m].

    Parameters
    ----------
    frequency_hz : array, Hz
        Frequencies.
    humidity_percent : float
        Relative humidity.

    Returns
    -------
    array of the same shape, dB/m

    References
    ----------
    ISO 9613-1:1993, equations 3 to 5, and B.3 for the saturation pressure.
    """
    square = np.square(np.asarray(frequency_hz, dtype=float))
    saturation = 10.0 ** (-6.8346 * (273.16 / _KELVIN) ** 1.261 + 4.6151)
    molar = humidity_percent * saturation
    oxygen_hz = 24.0 + 4.04e4 * molar * (0.02 + molar) / (0.391 + molar)
    nitrogen_hz = 9.0 + 280.0 * molar
    oxygen = 0.01275 * math.exp(-2239.1 / _KELVIN) / (oxygen_hz + square / oxygen_hz)
    nitrogen = 0.1068 * math.exp(-3352.0 / _KELVIN) / (nitrogen_hz + square / nitrogen_hz)
    return np.asarray(8.686 * square * (1.84e-11 + oxygen + nitrogen))


@ignoring_underflow
def in_room(
    pressure_pa: ArrayLike,
    reverberation_s: float,
    distance_m: float = 1.0,
    sample_rate_hz: int = 48000,
    seed: int = 0,
) -> Array:
    """Return a record with the diffuse sound of a room of 50 m3, for listening only.

    The direct sound stays as it is. Behind it comes noise that dies away by 60 dB within the
    reverberation time, and faster at high frequencies, which the air absorbs. It begins after the
    mean time between two reflections. Its energy over that of the direct sound is 16 pi r^2 / A,
    with the distance r of the source and the absorption area A of Sabine's formula. The ears have
    noise of their own, so a record of one channel becomes stereo.

    Parameters
    ----------
    pressure_pa : array (n,) or (n, 2), Pa
        Sound pressure in the free field.
    reverberation_s : float, s
        Reverberation time below 1 kHz, 0.1 to 10. A furnished living room has some 0.5.
    distance_m : float, m
        Distance from the source at which the record was made. Default: 1.
    sample_rate_hz : int, Hz
        Sample rate. Default: 48000.
    seed : int
        Number of the room. Default: 0.

    Returns
    -------
    array (n + tail, 2), Pa
        Sound pressure at both ears.

    Raises
    ------
    ValueError
        If a number is not allowed, or the record no finite series.

    References
    ----------
    H. Kuttruff, Room Acoustics, chapter 5, for the diffuse field; ISO 9613-1 for the air.

    Examples
    --------
    >>> import acoustics
    >>> click = [1.0, 0.0, 0.0]
    >>> pressure = acoustics.in_room(click, reverberation_s=0.5)
    >>> pressure[0].tolist(), round(len(pressure) / 48000, 2)
    ([1.0, 1.0], 0.51)
    """
    from scipy.signal import fftconvolve  # slow to import

    record = real_array("pressure_pa", pressure_pa, None)
    record = real_array("pressure_pa", record, 2 if record.ndim == 2 else 1)
    ears = np.stack((record, record), 1) if record.ndim == 1 else record
    if ears.shape[1] != 2:
        raise ValueError(f"pressure_pa: got {ears.shape[1]} channels, allowed: one or two")
    rate = positive("sample_rate_hz", sample_rate_hz)
    tails = diffuse_response(
        within("reverberation_s", reverberation_s, SHORTEST_S, LONGEST_S),
        positive("distance_m", distance_m),
        rate,
        seed,
    )
    pressure = np.asarray(fftconvolve(ears, tails, axes=0))
    pressure[: len(ears)] += ears
    return pressure


def diffuse_response(
    reverberation_s: float, distance_m: float, sample_rate_hz: float, seed: int
) -> Array:
    """Return the response of the diffuse sound at both ears (n, 2) to a unit of direct sound."""
    random = np.random.default_rng(seed)
    first = round(_reflection_s() * sample_rate_hz)
    time = np.arange(math.ceil(reverberation_s * sample_rate_hz)) / sample_rate_hz
    frequency = np.fft.rfftfreq(len(time), 1.0 / sample_rate_hz)
    place = 3.0 * np.log2(np.maximum(frequency, _BANDS_HZ[0]) / _BANDS_HZ[0])
    place = np.minimum(place, len(_BANDS_HZ) - 1)
    response = np.zeros((first + len(time), 2))
    for number, area in enumerate(absorption_areas_m2(reverberation_s)):
        decay_s = _SABINE * VOLUME_M3 / (SOUND_M_S * area)  # reverberation time of this band
        decay = 3.0 * math.log(10.0) / decay_s
        # Bands overlap so that their powers add up to one.
        share = np.sqrt(np.maximum(1.0 - np.abs(place - number), 0.0))
        energy = 16.0 * math.pi * distance_m**2 / area
        strength = math.sqrt(energy * 2.0 * decay / sample_rate_hz)
        for ear in range(2):
            noise = np.fft.irfft(np.fft.rfft(random.standard_normal(len(time))) * share, len(time))
            response[first:, ear] += strength * np.exp(-decay * time) * noise
    return response


def absorption_areas_m2(reverberation_s: float) -> Array:
    """Return the absorption area of walls and air [m2] in the bands."""
    walls = _SABINE * VOLUME_M3 / (SOUND_M_S * reverberation_s)
    attenuation = air_attenuation_db_m(_BANDS_HZ, HUMIDITY_PERCENT) / _NEPER_DB
    return np.asarray(walls + 4.0 * VOLUME_M3 * attenuation)


def _reflection_s() -> float:
    """Return the mean time between two reflections [s] in a cube."""
    walls = 6.0 * VOLUME_M3 ** (2.0 / 3.0)
    return float(4.0 * VOLUME_M3 / (walls * SOUND_M_S))
