"""Release along the track to sound pressure in time: the bridge from the contact, which knows distance, to acoustics.

Depends on scenario, motion and acoustics. A quasi-static release belongs to a place; only here does speed make power of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from acoustics import level, radiation, resampling, uncertainty, wav
from acoustics.bands import AUDIBLE_HZ
from rolling.scenario import Scene

Array = NDArray[np.float64]

FADE_S = 0.01  # at either end of a record that does not close, or a tenth of it when it is short


@dataclass(frozen=True)
class ContactSound:
    """The sound of one run.

    pressure : sound pressure [Pa] at `sample_rate` [Hz], one record for all that is shown, measured and heard.
    factor : from intensity fluctuation to sound pressure [Pa per W/m2].
    closed : levels and bands read the record as closed on itself. Otherwise it is faded.
    duration : of the record [s].
    highest : frequency up to which the march resolves sound [Hz], step Nyquist at the greatest speed.
    power : release power [W] at `time` [s], the middle of each step; q is not in it.
    uncertainty : of the levels [dB], from the length of the record.
    has_seam : the surface does not lead from its end to its beginning, so a closed record clicks where it goes round.
    steady_level : of the mean intensity [dB re 1e-12 W/m2]; None when nothing is released, as is its `steady_uncertainty`.
    """

    pressure: Array
    factor: float
    closed: bool
    duration: float
    highest: float
    levels: level.SoundLevels
    uncertainty: uncertainty.LevelUncertainty
    steady_level: float | None
    steady_uncertainty: float | None
    time: Array
    power: Array
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


def middle_speeds(scene: Scene, steps: int, step: float) -> tuple[Array, Array]:
    """Time [s] and speed [m/s] at the middle of each step."""
    times = np.asarray(scene.motion.time((np.arange(steps) + 0.5) * step), dtype=float)
    return times, np.asarray(scene.motion.speed(times), dtype=float)


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
    power = per_metre * speeds
    looped = closed and motion.is_constant

    if motion.is_constant:
        signal = power
        if not closed:
            # Without its mean, so that the fade fades the fluctuation only.
            signal = resampling.fade(power - power.mean(), _fade_length(steps, duration))
        fluctuation = resampling.resample_closed(resampling.undo_step_mean(signal), samples)
    else:
        # The mean goes off in distance: multiplied by a changing speed it would sound as loud as the roughness.
        signal = per_metre - per_metre.mean()
        # Pieces of a smooth track differ by rounding, which single precision makes 1e-13 of.
        if np.ptp(per_metre) <= 1e-11 * abs(per_metre.mean()):
            signal = np.zeros(steps)
        if not closed:
            signal = resampling.fade(signal, _fade_length(steps, duration))
        signal = resampling.undo_step_mean(signal)
        # Dense enough in time for what the greatest speed makes of the shortest wave on the track.
        oversampling = max(1, int(np.ceil(motion.fastest / step / rate)))
        fine = np.arange(samples * oversampling) * duration / (samples * oversampling)
        index = np.asarray(motion.distance(fine)) / step
        in_time = resampling.interpolate_closed(signal, index) * np.asarray(motion.speed(fine))
        in_time = resampling.fade(in_time, _fade_length(len(in_time), duration))
        fluctuation = resampling.resample_closed(in_time, samples)

    intensity = radiation.intensity(fluctuation, scene.sound.distance_m, scene.sound.q)
    audible = resampling.band_limit(intensity, rate, *AUDIBLE_HZ)
    pressure, factor = radiation.sound_pressure(audible, scene.sound.gain_pa_per_w_m2)
    highest = motion.fastest / (2 * step)
    levels = level.sound_levels(pressure, rate, highest, looped)
    own_factor = scene.sound.gain_pa_per_w_m2 is None
    lap = per_metre[:lap_steps]
    mean_power = float(per_metre.mean()) * steps * step / duration
    mean_intensity = float(radiation.intensity(np.array([mean_power]), scene.sound.distance_m, scene.sound.q)[0])
    return ContactSound(
        pressure=pressure,
        factor=float(factor),
        closed=looped,
        duration=duration,
        highest=highest,
        levels=levels,
        uncertainty=uncertainty.level_uncertainty(pressure, rate, levels, own_factor, laps=steps / len(lap)),
        steady_level=level.level_db(mean_intensity, level.I_REF_W_M2),
        steady_uncertainty=uncertainty.steady_uncertainty_db(lap, steps / duration),
        time=times,
        power=power,
        has_seam=has_seam,
    )


def _fade_length(samples: int, duration: float) -> int:
    return max(1, int(samples * min(FADE_S / duration, 0.1)))
