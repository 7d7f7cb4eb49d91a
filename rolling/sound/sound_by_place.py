"""Sound by place: the level of each patch of the track while the ball crosses it.

The pressure at a listener comes late, and the ball rings on its contact behind a rough place, so
neither pressure nor force tells where the sound was made. The push of the surface does: the
approach under the constant load, as it passes in time. Each third octave of it is given the
A-weighted energy that the pressure has there, without phase, so that the energy stays where the
surface pushes. By Parseval the energies add up to the level of the record.

The impacts of a ball that flies thus count where the surface threw it, not where it landed. A
record that is the release is its own source: it has neither delay nor ringing.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acoustics import level, resampling
from acoustics.arrays import Array, short_repr
from acoustics.bands import AUDIBLE_HZ, MID_HZ
from acoustics.radiation import P_REF_PA
from acoustics.spectrum import audible_lines
from acoustics.weighting import a_weighting_db
from rolling.contact.track import Travel
from rolling.sound.contact_sound import ContactSound, fade_length, faded
from rolling.sound.vibration_sound import Vibration

PATCHES = 100  # of a lap, if nothing needs longer patches
HELD = 0.8  # of the energy of a single push, within the length of a patch
KNOWN = 0.25  # of its time with which a patch counts at least; of a fade less is left
_FINE = 4  # times the sample rate, at which energies are summed


@dataclass(frozen=True, eq=False)
class SoundByPlace:
    """A-weighted level of the patches of a track.

    Attributes
    ----------
    position : (patches,) array, m
        Middle of each patch along the surface of the plate.
    level_db : (patches,) array, dB(A)
        Level at the listener while the ball crosses a patch, over all crossings. The mean of
        10^(L/10) over the patches, weighted by `seconds`, is that of LAeq. NaN where the ends of
        the record are faded, or nothing sounds.
    seconds : (patches,) array, s
        Time of the record on each patch. In a fade it counts by the square of the fade.
    first_s : (patches,) array, s
        Time in the record at which the ball first enters each patch.
    left_s : (patches,) array, s
        Time at which it leaves the patch after that.
    length : float, m
        Length of a patch.
    reason : str
        What the length of a patch follows from.
    source : str
        Source of the sound, vibration or release.
    """

    position: Array
    level_db: Array
    seconds: Array
    first_s: Array
    left_s: Array
    length: float
    reason: str
    source: str

    __repr__ = short_repr

    @property
    def laeq_db(self) -> float | None:
        """Level [dB(A)] to which the patches add up; None in silence."""
        known = np.isfinite(self.level_db)
        if not known.any():
            return None
        energy = self.seconds[known] @ 10.0 ** (self.level_db[known] / 10)
        return float(10 * math.log10(energy / self.seconds.sum()))


@dataclass(frozen=True)
class _Patches:
    """Patches of a track: where they begin, their count and length, and their reason."""

    begin: float  # [m]
    count: int
    length: float  # [m]
    period: float  # [m] after which places repeat
    reason: str

    def of(self, place: Array) -> Array:
        """Return the number of the patch of each place [m] along the track."""
        within = (place - self.begin) % self.period
        return np.minimum((within / self.length).astype(np.int64), self.count - 1)


def sound_by_place(
    travel: Travel,
    start: float,
    contact_length: float,
    sound: ContactSound,
    vibration: Vibration | None = None,
) -> SoundByPlace | None:
    """Return the level of each patch of the track of a ball that rolls.

    Parameters
    ----------
    travel : Travel
        Travel of the ball along its track.
    start : float, m
        First position along the surface of the plate.
    contact_length : float, m
        Length of the smooth contact along the track.
    sound : ContactSound
        Record of the run.
    vibration : Vibration, optional
        Vibration of the run, which tells the places if it is the source of the record.

    Returns
    -------
    places : SoundByPlace or None
        None for a record that is silent.
    """
    if not np.any(sound.pressure):
        return None
    if vibration is not None and sound.source == "vibration":
        located = _as_loud_as(_push(vibration, sound.duration), sound)
    else:
        located = level.a_weighted(sound.pressure, sound.sample_rate)
        located = resampling.band_limit(located, sound.sample_rate)
    count = _FINE * len(located)
    square = np.square(resampling.resample_closed(located, count))
    share = np.square(_fade(travel, sound, count))
    time = (np.arange(count) + 0.5) * (sound.duration / count)
    place = start + np.asarray(travel.motion.distance(time), dtype=float)
    patches = _patches(travel, start, contact_length, sound)
    number = patches.of(place)
    step_s = sound.duration / count
    energy = step_s * np.bincount(number, square, patches.count)
    weight = np.asarray(step_s * np.bincount(number, share, patches.count))
    rolled = step_s * np.bincount(number, minlength=patches.count)
    known = (weight > KNOWN * rolled) & (energy > 0)
    level_db = np.full(patches.count, np.nan)
    level_db[known] = 10 * np.log10(energy[known] / weight[known] / P_REF_PA**2)
    entered = np.full(patches.count, np.nan)
    entered[number[::-1]] = time[::-1]
    return SoundByPlace(
        position=np.asarray(patches.begin + (np.arange(patches.count) + 0.5) * patches.length),
        level_db=level_db,
        seconds=weight,
        first_s=entered,
        left_s=_left_s(travel, sound, entered, patches.length),
        length=patches.length,
        reason=patches.reason,
        source=sound.source,
    )


def _left_s(travel: Travel, sound: ContactSound, entered_s: Array, length: float) -> Array:
    """Return the times [s] at which the ball has rolled a length [m] from times, or the end."""
    rolled = np.asarray(travel.motion.distance(np.nan_to_num(entered_s)), dtype=float) + length
    reached = np.minimum(rolled, travel.track.distance * (1 - 1e-9))
    left = np.minimum(np.asarray(travel.motion.time(reached), dtype=float), sound.duration)
    return np.where(np.isfinite(entered_s), left, np.nan)


def _push(vibration: Vibration, duration: float) -> Array:
    """Return the push of the surface at the samples of a record, in any unit."""
    motion = vibration.motion
    law = vibration.law
    first = float(law.position_m[0])
    place = motion.position_m
    if law.period_m:
        place = first + (place - first) % law.period_m
    push = np.asarray(law.approach(place, vibration.load))
    push = push - push.mean()
    if not vibration.closed:
        push = faded(push, duration)
    return resampling.resample_closed(push, len(vibration.force))


def _as_loud_as(push: Array, sound: ContactSound) -> Array:
    """Return a push with the A-weighted energy of a record in each third octave.

    Between the middles of third octaves the square of the gain is linear over the logarithm of the
    frequency. A line counts for both third octaves beside it by the same shares, so the energy of
    all lines is kept.
    """
    frequency, push_square = audible_lines(push, sound.sample_rate)
    _, pressure_square = audible_lines(sound.pressure, sound.sample_rate)
    bands = _Bands(frequency)
    weighted = bands.sums(pressure_square * 10.0 ** (a_weighting_db(frequency) / 10))
    of_push = bands.sums(push_square)
    gain = np.divide(weighted, of_push, out=np.zeros_like(of_push), where=of_push > 0)
    lines = np.fft.rfft(push)
    audible = _audible(len(push), sound.sample_rate)
    loud = np.zeros_like(lines)
    loud[audible] = lines[audible] * np.sqrt(bands.lines(gain))
    return np.asarray(np.fft.irfft(loud, len(push)))


def _audible(samples: int, rate: float) -> NDArray[np.bool_]:
    """Tell which lines of a record are audible, as `audible_lines` does."""
    frequency = np.fft.rfftfreq(samples, 1 / rate)
    return np.asarray((frequency >= AUDIBLE_HZ[0]) & (frequency < AUDIBLE_HZ[1]))


class _Bands:
    """Shares of lines at audible frequencies [Hz] in the third octaves below and above them.

    A line in the middle of a third octave belongs to it alone.
    """

    def __init__(self, frequency: Array) -> None:
        self._count = len(MID_HZ)
        place = np.interp(np.log(frequency), np.log(MID_HZ), np.arange(self._count))
        self._below = np.minimum(place.astype(np.int64), self._count - 2)
        self._above_share = place - self._below

    def sums(self, values: Array) -> Array:
        """Return the sum of values of lines in each third octave."""
        below = np.bincount(self._below, values * (1 - self._above_share), self._count)
        above = np.bincount(self._below + 1, values * self._above_share, self._count)
        return np.asarray(below + above)

    def lines(self, values: Array) -> Array:
        """Return the values of third octaves at the lines, linear between their middles."""
        below = (1 - self._above_share) * values[self._below]
        return np.asarray(below + self._above_share * values[self._below + 1])


def _spread_s(sound: ContactSound) -> float:
    """Return the time [s] that holds most of a single push with the spectrum of a record."""
    samples = len(sound.pressure)
    frequency, square = audible_lines(sound.pressure, sound.sample_rate)
    bands = _Bands(frequency)
    counts = bands.sums(np.ones(len(frequency)))
    weighted = bands.sums(square * 10.0 ** (a_weighting_db(frequency) / 10))
    density = np.divide(weighted, counts, out=np.zeros_like(weighted), where=counts > 0)
    lines = np.zeros(samples // 2 + 1)
    lines[_audible(samples, sound.sample_rate)] = np.sqrt(bands.lines(density))
    fine = np.square(np.fft.irfft(lines, _FINE * samples))
    after = np.cumsum(fine[: len(fine) // 2]) - fine[0] / 2  # as much lies before the push
    steps = int(np.searchsorted(after, HELD * fine.sum() / 2)) + 1
    return 2 * steps / (_FINE * sound.sample_rate)


def _fade(travel: Travel, sound: ContactSound, count: int) -> Array:
    """Return the factor of the fades of a record at a number of times, of mean square 1.

    A release at a changing speed is faded along the distance, all else in time.
    """
    if sound.closed:
        return np.ones(count)
    ends = fade_length(count, sound.duration)
    share = resampling.fade(np.ones(count), ends)
    is_open = not travel.track.closed
    in_distance = sound.source == "release" and not sound.constant_speed and is_open
    if in_distance:
        time = (np.arange(count) + 0.5) * (sound.duration / count)
        rolled = np.asarray(travel.motion.distance(time), dtype=float) / travel.track.distance
        share = np.interp(rolled * count, np.arange(count), share)
    return np.asarray(share / np.sqrt(np.mean(np.square(share))))


def _patches(travel: Travel, start: float, contact_length: float, sound: ContactSound) -> _Patches:
    """Divide a track into patches, as long as the longest of three lengths.

    They are a hundredth of the lap, the length of the contact, within which places sound together,
    and the way that the ball rolls while a single push lasts.
    """
    track = travel.track
    period = track.plate_nodes * track.spacing
    is_lap = track.distance >= period * (1 - 1e-9)
    length = period if is_lap else track.distance
    begin = 0.0 if is_lap else start
    fastest = float(travel.motion.fastest(sound.duration))
    lengths = {
        "a hundredth of the track": length / PATCHES,
        "the length of the contact": contact_length,
        "the way of a single push": fastest * _spread_s(sound),
    }
    reason = max(lengths, key=lambda name: lengths[name])
    count = max(1, int(length / lengths[reason] * (1 + 1e-9)))
    return _Patches(
        begin=begin,
        count=count,
        length=length / count,
        period=period if is_lap else max(period, 2 * length),
        reason=reason,
    )
