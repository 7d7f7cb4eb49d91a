"""Sound of a run: from the energy released along the track to the sound pressure in time.

A quasi-static release belongs to a place. Only this module turns it into power, by the speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acoustics import level, radiation, resampling, uncertainty, wav
from acoustics.bands import AUDIBLE_HZ
from rolling._typing import Array
from rolling.scene.motion import Motion
from rolling.scene.scene import Scene
from rolling.sound.solver_error import resolved_fluctuation

FADE_S = 0.01  # [s], at either end of an open record; at most a tenth of its duration


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
    """

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
    source: str = "release"

    @property
    def loops(self) -> bool:
        """Tell whether the record repeats without a click."""
        return self.closed and not self.has_seam

    @property
    def not_extendable(self) -> str:
        """Reason why no longer record can stand for this one; empty if one can."""
        if not self.pressure.any():
            return "its record is silent"
        return "" if self.constant_speed else "its speed changes"

    @property
    def ends(self) -> str:
        """End of the record in words."""
        if self.closed:
            return "does not loop, the surface has a seam" if self.has_seam else "loops"
        return "faded at both ends"

    @property
    def sample_rate(self) -> int:
        """Sample rate of the record [Hz]."""
        return wav.SAMPLE_RATE_HZ

    @property
    def power_rms(self) -> float:
        """Rms [W] over time of the release power of the steps about its mean, unfiltered."""
        return float(
            np.sqrt(np.average(np.square(self.power - self.mean_power), weights=self.step_duration))
        )


def middle_speeds(motion: Motion, steps: int, step: float) -> tuple[Array, Array]:
    """Return time [s] and speed [m/s] at the middle of each step of length `step` [m]."""
    times = np.asarray(motion.time((np.arange(steps) + 0.5) * step), dtype=float)
    return times, np.asarray(motion.speed(times), dtype=float)


@dataclass(frozen=True)
class _Release:
    """Energy released along the track, and the motion that turns it into power.

    Attributes
    ----------
    per_metre : (steps,) array, J/m
        Energy released in each step over its length.
    step : float, m
        Length of a step.
    """

    motion: Motion
    per_metre: Array
    step: float

    @property
    def steps(self) -> int:
        """Number of steps."""
        return len(self.per_metre)

    @cached_property
    def duration(self) -> float:
        """Time [s] that the steps take."""
        return self.motion.duration(self.steps * self.step)

    @property
    def samples(self) -> int:
        """Samples of the sound in that time."""
        return max(2, round(self.duration * wav.SAMPLE_RATE_HZ))

    @cached_property
    def constant_speed(self) -> bool:
        """True where the speed stays the same for all steps."""
        return self.motion.is_constant(self.duration)

    @cached_property
    def middle(self) -> tuple[Array, Array]:
        """Time [s] and speed [m/s] at the middle of each step."""
        return middle_speeds(self.motion, self.steps, self.step)

    @cached_property
    def step_duration(self) -> Array:
        """Time [s] that each step takes."""
        return np.diff(self.motion.time(np.arange(self.steps + 1) * self.step))

    @cached_property
    def power(self) -> Array:
        """Release power [W] at the middle of each step."""
        return self.per_metre * self.middle[1]

    @property
    def mean_power(self) -> float:
        """Mean release power [W] over time."""
        return float(self.per_metre.mean()) * self.steps * self.step / self.duration

    @property
    def highest(self) -> float:
        """Nyquist frequency [Hz] of the steps at the maximum speed."""
        return self.motion.fastest(self.duration) / (2 * self.step)

    def fluctuation(self, closed: bool) -> Array:
        """Return the fluctuation of the release power [W] at the samples of the sound."""
        if self.constant_speed:
            return _at_constant_speed(self.power, closed, self.duration, self.samples)
        return _at_changing_speed(self.motion, self.per_metre, self.step, closed, self.samples)

    def white_error(self) -> float:
        """Return the rms within hearing [W] of an error that is white along the track.

        The error is as large as the mean release.

        At a speed v the error fills the band up to v / (2 step).
        """
        speeds = self.middle[1]
        heard = np.minimum(np.square(speeds), AUDIBLE_HZ[1] * 2 * self.step * speeds)
        return float(self.per_metre.mean() * np.sqrt(np.average(heard, weights=self.step_duration)))


def contact_sound(
    scene: Scene,
    release_energy: Array,
    step: float,
    closed: bool,
    lap_steps: int | None = None,
    has_seam: bool = False,
) -> ContactSound:
    """Turn the energy released in each step into the sound at the listener.

    The speed turns the energy into power, and the distance turns the power into intensity. Its
    fluctuation within hearing is the sound, unless the solver's error hides it.

    Parameters
    ----------
    scene : Scene
        Scene with the motion, the sound, and the numerics that the energy was solved with.
    release_energy : (steps,) array, J
        Energy of each step.
    step : float, m
        Length of a step.
    closed : bool
        If true, the steps are whole laps of the track.
    lap_steps : int, optional
        Steps after which the release repeats. Default: it does not repeat.
    has_seam : bool
        If true, the step from the end of the surface to its beginning stands out. Default: false.
    """
    release = _Release(scene.motion, release_energy / step, step)
    looped = closed and release.constant_speed
    audible, audible_rms = _heard(scene, release.fluctuation(closed))
    resolved_rms = resolved_fluctuation(scene) * release.white_error()
    if audible_rms <= resolved_rms:
        audible = np.zeros_like(audible)
    pressure, factor = radiation.sound_pressure(audible, scene.sound.gain_pa_per_w_m2)
    levels = level.sound_levels(pressure, wav.SAMPLE_RATE_HZ, release.highest, looped)
    lap = release.per_metre[:lap_steps]
    mean_intensity = float(_intensity(scene, np.array([release.mean_power]))[0])
    return ContactSound(
        pressure=pressure,
        factor=float(factor),
        closed=looped,
        constant_speed=release.constant_speed,
        duration=release.duration,
        highest=release.highest,
        levels=levels,
        uncertainty=_level_uncertainty(scene, pressure, levels, release.steps / len(lap)),
        steady_level=level.level_db(mean_intensity, level.I_REF_W_M2),
        steady_uncertainty=uncertainty.steady_uncertainty_db(lap, release.steps / release.duration),
        time=release.middle[0],
        step_duration=release.step_duration,
        power=release.power,
        mean_power=release.mean_power,
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


def _heard(scene: Scene, fluctuation: Array) -> tuple[Array, float]:
    """Return the audible intensity [W/m2] at the listener, and its rms as release power [W]."""
    audible = resampling.band_limit(_intensity(scene, fluctuation), wav.SAMPLE_RATE_HZ, *AUDIBLE_HZ)
    of_one_watt = _intensity(scene, np.ones(1))[0]
    return audible, float(np.sqrt(np.mean(np.square(audible))) / of_one_watt)


def _intensity(scene: Scene, power: Array) -> Array:
    """Return the intensity [W/m2] that a release power [W] makes at the listener."""
    return radiation.intensity(power, scene.sound.distance_m, scene.sound.q)


def _level_uncertainty(
    scene: Scene, pressure: Array, levels: level.SoundLevels, laps: float
) -> uncertainty.LevelUncertainty:
    """Estimate the uncertainty of the levels [dB] of a record over several laps."""
    own_factor = scene.sound.gain_pa_per_w_m2 is None
    return uncertainty.level_uncertainty(
        pressure, wav.SAMPLE_RATE_HZ, levels, own_factor, laps=laps
    )


def _at_constant_speed(power: Array, closed: bool, duration: float, samples: int) -> Array:
    """Return the release power [W] at the samples of the sound.

    Its mean is subtracted if the record does not close.
    """
    if not closed:
        power = faded(power, duration)
    return resampling.resample_closed(resampling.undo_step_mean(power), samples)


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
    in_time = resampling.fade(
        in_time * np.asarray(motion.speed(fine)), fade_length(fine_samples, duration)
    )
    return resampling.resample_closed(in_time, samples)


def faded(signal: Array, duration: float) -> Array:
    """Return the faded fluctuation of a signal.

    Its mean is zero after the fade, so that a band limit moves the ends little.
    """
    ends = fade_length(len(signal), duration)
    share = resampling.fade(np.ones(len(signal)), ends)
    # Of two samples nothing is left, whatever their mean.
    mean = float(signal @ share) / (share.sum() or 1.0)
    return resampling.fade(signal - mean, ends)


def fade_length(samples: int, duration: float) -> int:
    """Return the number of samples of the fade at either end of a record."""
    return max(1, int(samples * min(FADE_S / duration, 0.1)))
