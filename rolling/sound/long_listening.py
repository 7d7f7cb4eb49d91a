"""Sound of a run that goes on beyond its solved track."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from acoustics import level, radiation, resampling, wav
from acoustics.arrays import Array, short_repr
from acoustics.continued_rows import ContinuedRows
from acoustics.traps import ignoring_underflow
from acoustics.uncertainty import kurtosis
from rolling.contact.track import Motion
from rolling.dynamics.ball_on_plate import BallOnPlate
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.long_motion import LongMotion
from rolling.numbers.ball_numbers import ListeningNumbers
from rolling.sound import contact_sound, vibration_sound
from rolling.sound.receivers import Listener

_FINER = 4  # points of a release per sample of sound, so that a spline between them is exact
_MAX_POINTS = 2**18  # at once


@ignoring_underflow
@dataclass(frozen=True, eq=False)
class Listening:
    """Long record of a run: the solved track first, then a random continuation of the contact.

    Attributes
    ----------
    pressure : (samples,) array, Pa
        Sound pressure at the first listener.
    sample_rate : int, Hz
        Sample rate.
    numbers : ListeningNumbers
        Facts and levels.
    right : (samples,) array, Pa, or None
        Sound pressure at a second listener.

    Examples
    --------
    >>> import rolling
    >>> words = ["rolling.load_n=1", "rolling.duration_s=0.01", "numerics.error_estimate=false"]
    >>> run = rolling.simulate(rolling.read_scene("quickstart", words), workers=1, progress=False)
    >>> run.listen(2.0, speed=(0.05, 0.1)).pressure.shape
    (96000,)
    """

    __repr__ = short_repr

    pressure: Array
    sample_rate: int
    numbers: ListeningNumbers
    right: Array | None = None

    @property
    def channels(self) -> Array:
        """Record of all channels [Pa], (samples,) or (samples, 2)."""
        if self.right is None:
            return self.pressure
        return np.stack((self.pressure, self.right), 1)


Advance = Callable[[float], object]  # called with the seconds of the record that became known


@dataclass(frozen=True, kw_only=True)
class LongTravel:
    """Travel of a ball that goes on beyond its solved track, at random.

    Attributes
    ----------
    motion : Motion
        Distance and speed over time.
    seconds : float, s
        Length of the record.
    seed : int
        Seed of the random continuation.
    turn_m : float or None, m
        Circumference of a ball with a surface, after which the solved track is put in again. None
        for a smooth ball.
    """

    motion: Motion
    seconds: float
    seed: int = 0
    turn_m: float | None = None


def listen_to_vibration(
    bodies: BallOnPlate,
    listener: Listener,
    law: ForceLaw,
    travel: LongTravel,
    advance: Advance | None = None,
) -> Listening:
    """Let ball and plate move on over a continued force law, and radiate.

    The travel may go beyond the solved track.
    """
    rate = wav.SAMPLE_RATE_HZ
    seconds = travel.seconds
    motion = LongMotion(
        bodies,
        travel.motion,
        law,
        seconds=seconds,
        rate=rate,
        seed=travel.seed,
        turn_m=travel.turn_m,
    )
    decimator = resampling.Decimator(motion.steps_per_sample)
    samples = []
    falls = bodies.falls  # its record begins in silence
    for force in motion.forces():
        samples.append(decimator.add(force if falls else force - bodies.load_n))
        if advance is not None:
            advance(len(force) * motion.step)
    samples.append(decimator.end())
    fade = contact_sound.faded_out if falls else contact_sound.faded
    fluctuation = fade(np.concatenate(samples), seconds)
    _, pressures = vibration_sound.radiated(
        bodies, listener, travel.motion, fluctuation, rate, closed=False, count=2
    )
    numbers = _numbers(travel, pressures[0], law.spacing_m, motion.law.rows)
    numbers = replace(
        numbers,
        impacts=motion.impacts,
        flight_share=motion.free_steps / motion.taken,
        force_outside_share=motion.outside / motion.taken,
        limited_share=motion.law.limited / max(motion.law.continued, 1),
    )
    right = None
    if len(pressures) > 1:
        right = pressures[1]
    return Listening(pressure=pressures[0], sample_rate=rate, numbers=numbers, right=right)


def listen_to_release(
    release_energy: Array,
    step: float,
    closed: bool,
    listener: Listener,
    travel: LongTravel,
    advance: Advance | None = None,
) -> Listening:
    """Turn a continued release along the track into sound at the speed of a travel.

    `release_energy` [J] is the energy of each solved step of `step` [m].
    """
    rate = wav.SAMPLE_RATE_HZ
    seconds = travel.seconds
    fastest = travel.motion.fastest(seconds)
    finer = int(np.clip(np.ceil(_FINER * rate * step / fastest), 1, 2 * _FINER))
    signal = release_energy / step
    signal = signal - signal.mean()
    ends = max(1, len(signal) // 100)
    signal = resampling.undo_step_mean(signal) if closed else resampling.fade(signal, ends)
    row = resampling.resample_closed(signal, finer * len(signal))[None]
    spacing = step / finer
    turn = None if travel.turn_m is None else round(travel.turn_m / spacing)
    rows = ContinuedRows(row, closed, travel.seed, turn)
    faded = contact_sound.faded(_in_time(travel, rows, spacing, advance), seconds)
    intensity = radiation.intensity(faded, listener.distance_m, listener.q)
    audible = resampling.band_limit(intensity, rate)
    pressure, _ = radiation.sound_pressure(audible, listener.gain_pa_per_w_m2)
    numbers = _numbers(travel, pressure, step, rows, finer)
    return Listening(pressure=pressure, sample_rate=rate, numbers=numbers)


def _in_time(
    travel: LongTravel, rows: ContinuedRows, spacing: float, advance: Advance | None
) -> Array:
    """Return the release power [W] at the samples, from a release per metre at a spacing [m]."""
    from scipy.interpolate import CubicSpline  # slow to import, for long records only

    rate = wav.SAMPLE_RATE_HZ
    motion = travel.motion
    seconds = travel.seconds
    factor = contact_sound.oversampling(motion, seconds, spacing)
    decimator = resampling.Decimator(factor)
    samples = []
    count = _MAX_POINTS // factor * factor
    total = round(seconds * rate) * factor
    for begin in range(0, total, count):
        times = np.arange(begin, min(begin + count, total)) / (rate * factor)
        places = np.asarray(motion.distance(times)) / spacing
        first = max(int(places[0]) - 24, 0)
        last = int(places[-1]) + 26
        spline = CubicSpline(np.arange(first, last), rows.between(first, last)[0])
        samples.append(decimator.add(spline(places) * motion.speed(times)))
        if advance is not None:
            advance(len(times) / (rate * factor))
    return np.concatenate([*samples, decimator.end()])


def _numbers(
    travel: LongTravel, pressure: Array, step: float, rows: ContinuedRows, finer: int = 1
) -> ListeningNumbers:
    """Return facts and levels of a record; `rows` are `finer` to a step [m]."""
    motion = travel.motion
    seconds = travel.seconds
    fastest = motion.fastest(seconds)
    rolled = float(motion.distance(seconds))
    solved = rows.solved / finer * step
    solved_s = seconds if solved >= rolled else float(motion.time(solved))
    return ListeningNumbers(
        seconds=seconds,
        laeq_db=level.laeq_db(pressure, wav.SAMPLE_RATE_HZ),
        level_db=level.level_db(float(np.mean(np.square(pressure)))),
        solved_mm=1e3 * min(solved, rolled),
        rolled_mm=1e3 * rolled,
        solved_share=solved_s / seconds,
        kurtosis=kurtosis(pressure) if pressure.any() else None,
        stretches=rows.inserted,
        turn_mm=None if travel.turn_m is None else 1e3 * travel.turn_m,
        highest_frequency_hz=fastest / (2 * step),
        lowest_frequency_hz=fastest / solved,
    )
