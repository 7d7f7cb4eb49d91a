"""Sound of a run: from the energy released along the track to the sound pressure in time.

A quasi-static release belongs to a place. Only this module turns it into power, by the speed. The
solver stops at a tolerance, and each release carries an error in proportion to it. A record whose
fluctuation is no more than this error holds no sound of the surface: it counts as silent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from acoustics import level, radiation, resampling, uncertainty, wav
from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ, NOMINAL_HZ
from acoustics.laps import Lap, crossfaded_lap
from acoustics.numbers import decibels_a, rounded
from acoustics.traps import ignoring_underflow
from rolling.contact.track import Motion
from rolling.numbers.ball_numbers import Source
from rolling.sound.receivers import Listener

if TYPE_CHECKING:
    import pandas as pd

FADE_S = 0.01  # [s], at either end of an open record; at most a tenth of its duration
COVERAGE = 3.0  # standard uncertainties beyond which a record is not Gaussian noise


@ignoring_underflow
@dataclass(frozen=True)
class ContactSound:
    """Sound of one run: the record, its levels and the power behind it.

    Attributes
    ----------
    pressure : (samples,) array, Pa
        Sound pressure at `sample_rate`, the record that is shown, measured and heard.
    factor : float or None, Pa per W/m2
        Factor from the fluctuation of the intensity to the sound pressure; None for a vibration,
        whose pressure has no such factor.
    closed : bool
        If true, levels and bands take the record as closed, because the track closes and the speed
        is constant. Otherwise the record is faded.
    constant_speed : bool
        If true, the speed stays the same for the whole record.
    duration : float, s
        Duration of the record.
    highest : float, Hz
        Nyquist frequency of the steps at the maximum speed of the record. While the sphere rolls
        slower, the march resolves sound up to speed / (2 step) only, and the bands above hold the
        sound of the faster stretches alone.
    levels : SoundLevels, dB
        Levels of the record.
    uncertainty : LevelUncertainty, dB
        Uncertainty of the levels from the length of the record.
    steady_level : float or None, dB re 1e-12 W/m2
        Level of the mean intensity; None when nothing is released.
    steady_uncertainty : float or None, dB
        Uncertainty of the steady level; None when nothing is released.
    time, step_duration : (steps,) arrays, s
        Middle and length of each step.
    power : (steps,) array, W
        Release power at `time`, without the factor q.
    mean_power : float, W
        Mean of the release power over time.
    audible_rms : float, W
        Rms fluctuation of the release power within hearing; 0 where only rounding remains.
    resolved_rms : float, W
        Rms of the solver's error within hearing. A record with no more than that is silent.
    has_seam : bool
        If true, the end of the surface does not lead to its beginning, so a closed record clicks
        where it repeats.
    source : str
        Source of the pressure, release or vibration. Power and its rms belong to the release.
    right : (samples,) array, Pa, or None
        Sound pressure at the second listener, the right channel; None for a single listener.
    once : bool
        If true, the record is one event, which is faded at its end only and heard once.

    Examples
    --------
    >>> import rolling
    >>> scene = rolling.read_scene("quickstart", ["rolling.load_n=1", "rolling.duration_s=0.005"])
    >>> sound = rolling.simulate(scene, workers=1, progress=False).sound
    >>> sound
    ContactSound(0.005 s at 48000 Hz, ... dB(A), loops)
    >>> sound.third_octaves().loc[8000.0].index.to_list()
    ['third_octave_db', 'third_octave_a_db', 'third_octave_uncertainty_db']
    >>> sound.wav_bytes()[:4]
    b'RIFF'
    """

    def __repr__(self) -> str:
        level = decibels_a(self.levels.laeq_db)
        return f"ContactSound({self.duration:g} s at {self.sample_rate} Hz, {level}, {self.ends})"

    pressure: Array
    factor: float | None
    closed: bool
    constant_speed: bool
    duration: float
    highest: float
    levels: level.SoundLevels
    uncertainty: uncertainty.LevelUncertainty
    steady_level: float | None
    steady_uncertainty: float | None
    time: Array
    step_duration: Array
    power: Array
    mean_power: float
    audible_rms: float
    resolved_rms: float
    has_seam: bool = False
    source: Source = "release"
    right: Array | None = None
    once: bool = False

    def scaled(self, gain_db: float) -> ContactSound:
        """Return the sound at another level [dB]."""
        if gain_db == 0:
            return self
        factor = 10 ** (gain_db / 20)
        pressure = factor * self.pressure
        return replace(
            self,
            pressure=pressure,
            right=None if self.right is None else factor * self.right,
            factor=None if self.factor is None else factor * self.factor,
            levels=level.sound_levels(pressure, self.sample_rate, self.highest, self.closed),
        )

    def wav_bytes(self, comment: str = "", title: str = "") -> bytes:
        """Return the record as a 32-bit float WAV in which 1.0 is 1 Pa.

        Parameters
        ----------
        comment, title : str
            Metadata of the file. Default: the meaning of its samples alone.

        Returns
        -------
        content : bytes
            Content of the file.
        """
        comment = "; ".join(filter(None, ("1.0 = 1 Pa", comment)))
        return wav.calibrated(self.channels, comment, title, self.loops)

    def third_octaves(self) -> pd.DataFrame:
        """Tabulate the third octaves by their nominal mid frequency [Hz].

        Returns
        -------
        table : pandas.DataFrame
            Z and A levels, dB re 20 uPa, and their standard uncertainty from the length of the
            record, dB; NaN in a band without sound.
        """
        import pandas as pd  # slow to import, for tables only

        levels = {
            "third_octave_db": self.levels.third_octave_db,
            "third_octave_a_db": self.levels.third_octave_a_db,
            "third_octave_uncertainty_db": self.uncertainty.third_octave_db,
        }
        return pd.DataFrame(levels, dtype=float).set_index(pd.Index(NOMINAL_HZ, name="band_hz"))

    @property
    def channels(self) -> Array:
        """The record, (samples,) or, of two listeners, (samples, 2) [Pa]."""
        if self.right is None:
            return self.pressure
        return np.stack((self.pressure, self.right), 1)

    @property
    def loops(self) -> bool:
        """Tell whether the record repeats without a click."""
        return self.closed and not self.has_seam

    @cached_property
    def lap(self) -> Lap:
        """Part of the record that repeats without a click: all of it if it loops."""
        if self.loops:
            return Lap(0, len(self.pressure))
        ends = fade_length(len(self.pressure), self.duration)
        return crossfaded_lap(self.pressure, ends, self.sample_rate)

    @property
    def fade(self) -> Array:
        """Factor [-] by which the record is faded at each sample, 1 where it is not."""
        samples = len(self.pressure)
        if self.closed:
            return np.ones(samples)
        ends = fade_length(samples, self.duration)
        share = resampling.fade(np.ones(samples), ends)
        if self.once:  # it begins in silence
            share[: samples // 2] = 1.0
        return share

    @property
    def unlike_noise(self) -> str:
        """Reason why noise with the same spectrum cannot stand for the record; empty if it can."""
        if not self.pressure.any():
            return "its record is silent"
        ends = 0 if self.closed else fade_length(len(self.pressure), self.duration)
        whole = self.pressure[ends : len(self.pressure) - ends]
        value = uncertainty.kurtosis(whole)
        spread = uncertainty.kurtosis_uncertainty(whole)
        if abs(value - 3.0) <= COVERAGE * spread:
            return ""
        return (
            f"its record has a kurtosis of {rounded(value, 3)}, and noise of its length and"
            f" spectrum 3 ± {rounded(COVERAGE * spread)}"
        )

    @property
    def ends(self) -> str:
        """End of the record in words."""
        if self.loops:
            return "loops"
        if self.closed:
            return "does not loop, the surface has a seam"
        if self.once:
            return "faded at its end"
        return "faded at both ends"

    @property
    def sample_rate(self) -> int:
        """Sample rate of the record [Hz]."""
        return wav.SAMPLE_RATE_HZ

    @property
    def power_rms(self) -> float:
        """Rms [W] over time of the release power of the steps about its mean, unfiltered."""
        square = np.square(self.power - self.mean_power)
        return float(np.sqrt(np.average(square, weights=self.step_duration)))


def middle_speeds(motion: Motion, steps: int, step: float) -> tuple[Array, Array]:
    """Return time [s] and speed [m/s] at the middle of each step of length `step` [m]."""
    times = np.asarray(motion.time((np.arange(steps) + 0.5) * step), dtype=float)
    return times, np.asarray(motion.speed(times), dtype=float)


def contact_sound(
    release_energy: Array,
    step: float,
    motion: Motion,
    listener: Listener,
    tolerance: float,
    closed: bool,
    lap_steps: int | None = None,
    has_seam: bool = False,
) -> ContactSound:
    """Turn the energy released in each step into the sound at the listener.

    The speed turns the energy into power, and the distance turns the power into intensity. Its
    fluctuation within hearing is the sound, unless the solver's error hides it.

    Parameters
    ----------
    release_energy : (steps,) array, J. Energy of each step.
    step : float, m. Length of a step.
    motion : Motion. Distance and speed over time.
    listener : Listener. Listener of the released power.
    tolerance : float. Tolerance of the solver that the energy was solved with.
    closed : bool. If true, the steps are whole laps of the track.
    lap_steps : int. Steps after which the release repeats. Default: it does not repeat.
    has_seam : bool. If true, the step from the end of the surface to its beginning stands out.
    """
    steps = len(release_energy)
    per_metre = release_energy / step
    duration = motion.duration(steps * step)
    constant = motion.is_constant(duration)
    highest = motion.fastest(duration) / (2 * step)
    looped = closed and constant
    time, speed = middle_speeds(motion, steps, step)
    power = per_metre * speed
    step_duration = np.diff(motion.time(np.arange(steps + 1) * step))
    mean_power = float(per_metre.mean()) * steps * step / duration
    rate = wav.SAMPLE_RATE_HZ
    samples = max(2, round(duration * rate))
    if constant:
        fluctuation = _at_constant_speed(power, duration, closed, samples)
    else:
        fluctuation = _at_changing_speed(motion, per_metre, step, closed, samples)
    audible = resampling.band_limit(_intensity(listener, fluctuation), rate)
    audible_rms = float(np.sqrt(np.mean(np.square(audible))) / _intensity(listener, np.ones(1))[0])
    white_rms = _white_rms(per_metre, step, speed, step_duration)
    resolved_rms = resolved_fluctuation(tolerance) * white_rms
    if audible_rms <= resolved_rms:
        audible = np.zeros_like(audible)
    pressure, factor = radiation.sound_pressure(audible, listener.gain_pa_per_w_m2)
    levels = level.sound_levels(pressure, rate, highest, looped)
    lap = per_metre[:lap_steps]
    own_factor = listener.has_own_factor
    spread = uncertainty.level_uncertainty(pressure, rate, levels, own_factor, steps / len(lap))
    mean_intensity = float(_intensity(listener, np.array([mean_power]))[0])
    return ContactSound(
        pressure=pressure,
        factor=float(factor),
        closed=looped,
        constant_speed=constant,
        duration=duration,
        highest=highest,
        levels=levels,
        uncertainty=spread,
        steady_level=level.level_db(mean_intensity, radiation.I_REF_W_M2),
        steady_uncertainty=uncertainty.steady_uncertainty_db(lap, steps / duration),
        time=time,
        step_duration=step_duration,
        power=power,
        mean_power=mean_power,
        audible_rms=audible_rms,
        resolved_rms=resolved_rms,
        has_seam=has_seam,
    )


def oversampling(motion: Motion, duration: float, step: float) -> int:
    """Return the oversampling of a record of changing speed.

    The record is read from the track at this factor times the sample rate.

    The maximum speed within the duration [s] determines the maximum frequency of the steps of
    length `step` [m].
    """
    return max(1, int(np.ceil(motion.fastest(duration) / step / wav.SAMPLE_RATE_HZ)))


def _white_rms(per_metre: Array, step: float, speed: Array, step_duration: Array) -> float:
    """Return the rms within hearing [W] of an error as large as the mean release.

    The error is white along the track. At a speed v it fills the band up to v / (2 step).
    """
    audible_square = np.minimum(np.square(speed), AUDIBLE_HZ[1] * 2 * step * speed)
    return float(per_metre.mean() * np.sqrt(np.average(audible_square, weights=step_duration)))


def _intensity(listener: Listener, power: Array) -> Array:
    """Return the intensity [W/m2] that a release power [W] makes at the listener."""
    return radiation.intensity(power, listener.distance_m, listener.q)


def _at_constant_speed(power: Array, duration: float, closed: bool, samples: int) -> Array:
    """Return the fluctuation of the release power [W] at the samples of the sound."""
    signal = power if closed else faded(power, duration)
    return resampling.resample_closed(resampling.undo_step_mean(signal), samples)


def _at_changing_speed(
    motion: Motion, per_metre: Array, step: float, closed: bool, samples: int
) -> Array:
    """Return the fluctuation of the release power [W] at the samples of the sound."""
    duration = motion.duration(len(per_metre) * step)
    # The mean is subtracted along the distance, because multiplied by a changing speed it would
    # sound as loud as the roughness.
    signal = per_metre - per_metre.mean() if closed else faded(per_metre, duration)
    signal = resampling.undo_step_mean(signal)
    fine_samples = samples * oversampling(motion, duration, step)
    fine = np.arange(fine_samples) * duration / fine_samples
    in_time = resampling.interpolate_closed(signal, np.asarray(motion.distance(fine)) / step)
    in_time = in_time * np.asarray(motion.speed(fine))
    if closed:  # otherwise it is faded along the distance
        in_time = faded(in_time, duration)
    return resampling.resample_closed(in_time, samples)


def faded(signal: Array, duration: float) -> Array:
    """Return the faded fluctuation of a signal, as loud on average as before the fade.

    Its mean is zero after the fade, so that a band limit moves the ends little.
    """
    share = resampling.fade(np.ones(len(signal)), fade_length(len(signal), duration))
    # The fade leaves nothing of two samples, whatever their mean.
    mean = float(signal @ share) / (share.sum() or 1.0)
    return (signal - mean) * share / (np.sqrt(np.mean(np.square(share))) or 1.0)


def faded_out(signal: Array, duration: float) -> Array:
    """Return a signal that begins in silence, faded at its end."""
    share = resampling.fade(np.ones(len(signal)), fade_length(len(signal), duration))
    share[: len(share) // 2] = 1.0
    return signal * share


def fade_length(samples: int, duration: float) -> int:
    """Return the number of samples of the fade at either end of a record."""
    return max(1, int(samples * min(FADE_S / duration, 0.1)))


# This is the rms error of the release over its mean, in tolerances. Smooth spheres that are solved
# anew at every position had 0.2 to 17 (steps of 1/2, 1/3 and 1/4 node, tolerances 1e-3 to 1e-8),
# rough surfaces of Ra 1e-12 to 1e-7 m had 2 to 12 (tolerances 1e-3 to 1e-8).
SOLVER_ERROR = 20.0
DOUBTFUL_DB = 10.0  # above the solver's error, where levels are off by up to 1.5 dB


def resolved_fluctuation(tolerance: float) -> float:
    """Return the rms fluctuation of the release, over its mean, below which it is error.

    It counts at all frequencies, for a tolerance of the solver. The error is white along the track:
    a band holds its share of the mean square.
    """
    return SOLVER_ERROR * tolerance


def solver_doubt(tolerance: float, audible_rms: float, resolved_rms: float) -> str | None:
    """Return a text that the solver's error hides a record or nearly does; otherwise None.

    The rms values [W] are the fluctuation of the release power within hearing, and the part of it
    that may be the solver's error at a tolerance.
    """
    if not resolved_rms:  # no sound could be hidden
        return None
    error = f"the solver's error of up to {rounded(resolved_rms)} W rms"
    advice = f"lower numerics.tolerance, {rounded(tolerance, 6)} here"
    if audible_rms <= resolved_rms:
        return f"the release fluctuates no more than {error}: the record counts as silent; {advice}"
    above = 20 * math.log10(audible_rms / resolved_rms)
    if above >= DOUBTFUL_DB:
        return None
    return f"the fluctuation within hearing stands {rounded(above)} dB above {error}: {advice}"
