"""Release along the track to sound pressure in time: the bridge from the contact, which knows distance, to acoustics.

Depends on scenario, motion, resolution and acoustics. A quasi-static release belongs to a place; only here does speed make
power of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acoustics import level, radiation, resampling, uncertainty, wav
from acoustics.bands import AUDIBLE_HZ
from rolling.check.resolution import resolved_fluctuation
from rolling.scene.motion import Motion
from rolling.scene.scene import Scene

Array = NDArray[np.float64]

FADE_S = 0.01  # at either end of a record that does not close, or a tenth of it when it is short


@dataclass(frozen=True)
class ContactSound:
    """The sound of one run.

    pressure : sound pressure [Pa] at `sample_rate` [Hz], one record for all that is shown, measured and heard.
    factor : from intensity fluctuation to sound pressure [Pa per W/m2].
    closed : levels and bands take the record as closed: the track closes and the speed stays the same. Otherwise it is faded.
    constant_speed : the speed stays the same for the whole record.
    duration : of the record [s].
    highest : Nyquist frequency [Hz] of the steps at the greatest speed that the record reaches. While the sphere rolls slower, the
        march resolves sound up to speed / (2 step) only, and the bands above hold the sound of the faster stretches alone.
    power : release power [W] at `time` [s], the middle of each step, which lasts `step_duration` [s]; q is not in it.
    audible_rms : rms [W] of the release power's fluctuation within hearing; 0 where there is only rounding.
    resolved_rms : rms [W] within hearing that the solver's error reaches; a record with no more than that is silent.
    uncertainty : of the levels [dB], from the length of the record.
    has_seam : the surface does not lead from its end to its beginning, so a closed record clicks where it goes round.
    steady_level : of the mean intensity [dB re 1e-12 W/m2]; None when nothing is released, as is its `steady_uncertainty`.
    """

    pressure: Array
    factor: float
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

    @property
    def loops(self) -> bool:
        """The record goes round without a click."""
        return self.closed and not self.has_seam

    @property
    def ends(self) -> str:
        """How the record ends, in words."""
        if self.closed:
            return "does not loop, the surface has a seam" if self.has_seam else "loops"
        return "faded at both ends"

    @property
    def sample_rate(self) -> int:
        return wav.SAMPLE_RATE_HZ

    @property
    def power_rms(self) -> float:
        """Rms [W] over time of the release power of the steps about its mean, unfiltered."""
        return float(np.sqrt(np.average(np.square(self.power - self.mean_power), weights=self.step_duration)))


def middle_speeds(scene: Scene, steps: int, step: float) -> tuple[Array, Array]:
    """Time [s] and speed [m/s] at the middle of each step."""
    times = np.asarray(scene.motion.time((np.arange(steps) + 0.5) * step), dtype=float)
    return times, np.asarray(scene.motion.speed(times), dtype=float)


def oversampling(motion: Motion, duration: float, step: float) -> int:
    """Return how many times as dense as the sound samples a record of changing speed is read from the track.

    The greatest speed that is reached within the duration [s] makes the highest frequency of the steps of length `step` [m].
    """
    return max(1, int(np.ceil(motion.fastest(duration) / step / wav.SAMPLE_RATE_HZ)))


def contact_sound(
    scene: Scene,
    release_energy: Array,
    step: float,
    closed: bool,
    lap_steps: int | None = None,
    has_seam: bool = False,
) -> ContactSound:
    """Sound of a run from the energy released in each step.

    Parameters
    ----------
    scene : motion and sound, and the numerics that the energy was solved with.
    release_energy : (steps,) energy of each step [J].
    step : length of a step [m].
    closed : the steps are whole laps of the track.
    lap_steps : steps after which the release repeats; None: it does not.
    has_seam : the step from the end of the surface to its beginning stands out.
    """
    steps = len(release_energy)
    per_metre = release_energy / step
    motion, rate = scene.motion, wav.SAMPLE_RATE_HZ
    duration = motion.duration(steps * step)
    samples = max(2, round(duration * rate))
    times, speeds = middle_speeds(scene, steps, step)
    step_duration = np.diff(motion.time(np.arange(steps + 1) * step))
    constant = motion.is_constant(duration)
    looped = closed and constant
    power = per_metre * speeds
    if constant:
        fluctuation = _at_constant_speed(power, closed, duration, samples)
    else:
        fluctuation = _at_changing_speed(motion, per_metre, step, closed, samples)

    def intensity(power: Array) -> Array:
        return radiation.intensity(power, scene.sound.distance_m, scene.sound.q)

    audible = resampling.band_limit(intensity(fluctuation), rate, *AUDIBLE_HZ)
    audible_rms = float(np.sqrt(np.mean(np.square(audible))) / intensity(np.ones(1))[0])
    resolved_rms = resolved_fluctuation(scene) * _white_error(per_metre.mean(), speeds, step_duration, step)
    if audible_rms <= resolved_rms:
        audible = np.zeros_like(audible)
    pressure, factor = radiation.sound_pressure(audible, scene.sound.gain_pa_per_w_m2)
    highest = motion.fastest(duration) / (2 * step)
    levels = level.sound_levels(pressure, rate, highest, looped)
    own_factor = scene.sound.gain_pa_per_w_m2 is None
    lap = per_metre[:lap_steps]
    mean_power = float(per_metre.mean()) * steps * step / duration
    mean_intensity = float(intensity(np.array([mean_power]))[0])
    return ContactSound(
        pressure=pressure,
        factor=float(factor),
        closed=looped,
        constant_speed=constant,
        duration=duration,
        highest=highest,
        levels=levels,
        uncertainty=uncertainty.level_uncertainty(pressure, rate, levels, own_factor, laps=steps / len(lap)),
        steady_level=level.level_db(mean_intensity, level.I_REF_W_M2),
        steady_uncertainty=uncertainty.steady_uncertainty_db(lap, steps / duration),
        time=times,
        step_duration=step_duration,
        power=power,
        mean_power=mean_power,
        audible_rms=audible_rms,
        resolved_rms=resolved_rms,
        has_seam=has_seam,
    )


def _at_constant_speed(power: Array, closed: bool, duration: float, samples: int) -> Array:
    """Return the release power [W] at the samples of the sound, without its mean if it does not close."""
    if not closed:
        # The fade takes in the fluctuation only.
        power = resampling.fade(power - power.mean(), _fade_length(len(power), duration))
    return resampling.resample_closed(resampling.undo_step_mean(power), samples)


def _at_changing_speed(motion: Motion, per_metre: Array, step: float, closed: bool, samples: int) -> Array:
    """Return the fluctuation of the release power [W] at the samples of the sound."""
    duration = motion.duration(len(per_metre) * step)
    # The mean goes off in distance: multiplied by a changing speed it would sound as loud as the roughness.
    signal = per_metre - per_metre.mean()
    if not closed:
        signal = resampling.fade(signal, _fade_length(len(signal), duration))
    signal = resampling.undo_step_mean(signal)
    fine_samples = samples * oversampling(motion, duration, step)
    fine = np.arange(fine_samples) * duration / fine_samples
    in_time = resampling.interpolate_closed(signal, np.asarray(motion.distance(fine)) / step)
    in_time = resampling.fade(in_time * np.asarray(motion.speed(fine)), _fade_length(fine_samples, duration))
    return resampling.resample_closed(in_time, samples)


def _white_error(per_metre: float, speeds: Array, step_duration: Array, step: float) -> float:
    """Return the rms within hearing [W] of an error as large as the mean release [J/m] that is white along the track.

    At a speed v it fills the band up to v / (2 step).
    """
    heard = np.minimum(np.square(speeds), AUDIBLE_HZ[1] * 2 * step * speeds)
    return float(per_metre * np.sqrt(np.average(heard, weights=step_duration)))


def _fade_length(samples: int, duration: float) -> int:
    return max(1, int(samples * min(FADE_S / duration, 0.1)))
