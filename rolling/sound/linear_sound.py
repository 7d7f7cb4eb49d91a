"""Sound of a vibration that a linear chain estimates: the signal of a run, as its level has it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from acoustics import level, uncertainty, wav
from acoustics.arrays import Array, short_repr
from rolling.contact.track import Motion
from rolling.dynamics.ball_on_plate import BallOnPlate
from rolling.sound.contact_sound import ContactSound
from rolling.sound.radiators import chain_at_lines, linear_pressure
from rolling.sound.receivers import Listener


@dataclass(frozen=True, eq=False)
class LinearVibration:
    """Ball, contact and plate as a linear chain, which the approach along a track moves.

    Attributes
    ----------
    bodies : BallOnPlate
        Ball and plate.
    listener : Listener
        Listener of the vibration.
    stiffness_n_m : float, N/m
        Mean stiffness of the contact.
    motion : Motion
        Distance and speed over time.
    approach : (positions,) array, m
        Approach under the constant load at the ends of the steps: of one lap where it repeats,
        otherwise of the whole record.
    step : float, m
        Length of a step.
    closed : bool
        Whether the steps are whole laps of the track.
    """

    __repr__ = short_repr

    bodies: BallOnPlate
    listener: Listener
    stiffness_n_m: float
    motion: Motion
    approach: Array
    step: float
    closed: bool


def linear_sound(vibration: LinearVibration, release: ContactSound) -> ContactSound | None:
    """Return the sound of a vibration by the linear chain, as long as that of the release.

    None where the approach does not fluctuate within hearing.
    """
    moved = chain_at_lines(
        vibration.bodies,
        vibration.listener,
        vibration.bodies.chain(vibration.stiffness_n_m),
        vibration.motion,
        vibration.approach,
        vibration.step,
        vibration.closed,
    )
    if moved is None:
        return None
    samples = len(release.pressure)
    looped = moved.lines.looped
    laps = max(1, round(release.duration / moved.lines.duration))
    pressure = linear_pressure(vibration.bodies, vibration.listener, moved, samples, laps)
    rate = wav.SAMPLE_RATE_HZ
    levels = level.sound_levels(pressure, rate, release.highest, looped)
    return replace(
        release,
        source="vibration",
        pressure=pressure,
        right=None,
        factor=None,
        closed=looped,
        levels=levels,
        uncertainty=uncertainty.level_uncertainty(pressure, rate, levels, False, laps=laps),
        steady_level=None,
        steady_uncertainty=None,
    )
