"""Sound of a run that goes on beyond its solved track."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from acoustics import level, radiation, resampling, wav
from acoustics.arrays import Array, short_repr
from acoustics.continued_rows import ContinuedRows
from acoustics.spectrum import audible_phasors
from acoustics.traps import ignoring_underflow
from acoustics.uncertainty import kurtosis
from rolling.contact.track import Motion
from rolling.dynamics.ball_on_plate import BallOnPlate
from rolling.dynamics.ball_turn import BallTurn
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.long_motion import LongMotion
from rolling.numbers.ball_numbers import ListeningNumbers
from rolling.sound import contact_sound, vibration_sound
from rolling.sound.linear_sound import LinearVibration
from rolling.sound.radiators import roughness_transfers
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

    def scaled(self, gain_db: float) -> "Listening":
        """Return the record at another level [dB]; its numbers stay those of the one made."""
        if gain_db == 0:
            return self
        factor = 10 ** (gain_db / 20)
        right = None if self.right is None else factor * self.right
        return replace(self, pressure=factor * self.pressure, right=right)


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
    turn : BallTurn or None
        Turn of a ball with a surface, after which the solved track is put in again. None for a
        smooth ball.
    """

    motion: Motion
    seconds: float
    seed: int = 0
    turn: BallTurn | None = None


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
        turn=travel.turn,
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
    signal = release_energy / step
    rows = _continued_rows(signal - signal.mean(), step, closed, travel, is_step_mean=True)
    faded = contact_sound.faded(_in_time(travel, rows, True, advance), travel.seconds)
    intensity = radiation.intensity(faded, listener.distance_m, listener.q)
    audible = resampling.band_limit(intensity, wav.SAMPLE_RATE_HZ)
    pressure, _ = radiation.sound_pressure(audible, listener.gain_pa_per_w_m2)
    return _listening(travel, pressure, rows)


def listen_to_chain(
    vibration: LinearVibration,
    approach: Array,
    closed: bool,
    travel: LongTravel,
    advance: Advance | None = None,
) -> Listening:
    """Let a continued approach move ball, contact and plate as a linear chain, and listen.

    `approach` [m] is that at each solved position of a step. The lines of a long record lie so
    close that each has the transfer at its own frequency.
    """
    form = _form_of(travel, vibration.step * np.arange(len(approach), dtype=np.float64))
    signal = approach - form
    signal -= signal.mean()
    rows = _continued_rows(signal, vibration.step, closed, travel, is_step_mean=False)
    in_time = _in_time(travel, rows, False, advance)
    times = np.arange(len(in_time)) / wav.SAMPLE_RATE_HZ
    in_time += _form_of(travel, np.asarray(travel.motion.distance(times)))
    faded = contact_sound.faded(in_time, travel.seconds)
    samples = len(faded)
    frequency, phasor = audible_phasors(faded, wav.SAMPLE_RATE_HZ)
    chain = vibration.bodies.chain(vibration.stiffness_n_m)
    transfers = roughness_transfers(vibration.bodies, vibration.listener, chain)
    spectrum = np.zeros(samples // 2 + 1, dtype=complex)
    first = round(float(frequency[0]) * samples / wav.SAMPLE_RATE_HZ)
    spectrum[first : first + len(frequency)] = samples * phasor * transfers(frequency)[0]
    return _listening(travel, np.fft.irfft(spectrum, samples), rows)


def _form_of(travel: LongTravel, distance: Array) -> Array:
    """Return the approach [m] that the waves around a ball add at distances [m] of its travel."""
    if travel.turn is None:
        return np.zeros(len(distance))
    return travel.turn.form_at(distance)


class _Rows(NamedTuple):
    """A continued row along the track, its step [m], and how many of its places a step has."""

    rows: ContinuedRows
    step: float
    finer: int

    @property
    def spacing(self) -> float:
        """Distance of its places [m]."""
        return self.step / self.finer


def _continued_rows(
    signal: Array, step: float, closed: bool, travel: LongTravel, is_step_mean: bool
) -> _Rows:
    """Return the continuation of a signal along the track, at places or as means over steps [m]."""
    fastest = travel.motion.fastest(travel.seconds)
    finer = int(np.clip(np.ceil(_FINER * wav.SAMPLE_RATE_HZ * step / fastest), 1, 2 * _FINER))
    ends = max(1, len(signal) // 100)
    if not closed:
        signal = resampling.fade(signal, ends)
    elif is_step_mean:
        signal = resampling.undo_step_mean(signal)
    row = resampling.resample_closed(signal, finer * len(signal))[None]
    turn = None if travel.turn is None else round(travel.turn.length_m / (step / finer))
    return _Rows(ContinuedRows(row, closed, travel.seed, turn), step, finer)


def _listening(travel: LongTravel, pressure: Array, continued: _Rows) -> Listening:
    """Return a long record of one listener with its facts."""
    numbers = _numbers(travel, pressure, continued.step, continued.rows, continued.finer)
    return Listening(pressure=pressure, sample_rate=wav.SAMPLE_RATE_HZ, numbers=numbers)


def _in_time(
    travel: LongTravel, continued: _Rows, is_per_metre: bool, advance: Advance | None
) -> Array:
    """Return a row at the samples: as it passes, or per time [W] from a release per metre."""
    from scipy.interpolate import CubicSpline  # slow to import, for long records only

    rate = wav.SAMPLE_RATE_HZ
    motion = travel.motion
    seconds = travel.seconds
    rows = continued.rows
    spacing = continued.spacing
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
        values = spline(places)
        samples.append(decimator.add(values * motion.speed(times) if is_per_metre else values))
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
        turn_mm=None if travel.turn is None else 1e3 * travel.turn.length_m,
        highest_frequency_hz=fastest / (2 * step),
        lowest_frequency_hz=fastest / solved,
    )
