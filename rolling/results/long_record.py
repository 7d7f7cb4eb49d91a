"""Long records of a run: the solved track, then its random continuation, in motion."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from acoustics import level
from acoustics.numbers import micrometres, rounded, rounded_up
from rolling.contact.track import Motion
from rolling.in_si.physics_of_scene import bodies_of, listener_of, turn_of
from rolling.marches.result import Result, released_energy
from rolling.numbers.ball_numbers import ListeningNumbers
from rolling.scene import values_in_si
from rolling.scene.scene import Scene
from rolling.sound import long_listening
from rolling.sound.contact_sound import FADE_S, ContactSound, contact_sound
from rolling.sound.linear_sound import LinearVibration
from rolling.sound.long_listening import Listening, LongTravel
from rolling.sound.vibration_sound import Vibration
from rolling.terminal import defaults, progress

Speed = float | tuple[float, float]  # [m/s], constant or from start to end

MIN_POSITIONS = 64  # of a solved track; fewer have no spectrum
COARSE_HZ = 10e3  # highest frequency of the steps below which the sound is dull
OFTEN = 0.1  # of a record's duration, in which forces beyond the marched loads are named
LONG_WAVES_HZ = 500.0  # lowest frequency of the solved track above which its long waves are named


class ListeningError(ValueError):
    """Reason why a run has no long listening."""


def reason_against_long_record(scene: Scene, result: Result, sound: ContactSound) -> str:
    """Return the reason why a run has no long record; empty if it has one."""
    steps = result.solved_steps
    if steps < MIN_POSITIONS:
        return f"its solved track has {steps} steps, and a continuation needs {MIN_POSITIONS}"
    if not sound.pressure.any():
        return "its record is silent"
    if sound.source == "vibration":
        return ""
    if not sound.constant_speed:
        fastest = scene.motion.fastest(sound.duration)
        energy, is_closed = released_energy(scene, result)
        sound = contact_sound(
            energy,
            step=result.step,
            motion=motion_at_speed(scene, fastest, sound.duration),
            listener=listener_of(scene),
            tolerance=scene.tolerance,
            closed=is_closed,
            lap_steps=steps,
            has_seam=sound.has_seam,
        )
    if not sound.unlike_noise:
        return ""
    return f"{sound.unlike_noise}: a random continuation would not sound like it"


def motion_at_speed(scene: Scene, speed: Speed, seconds: float) -> Motion:
    """Return the motion of a scene at another speed [m/s].

    A pair of speeds changes evenly from the start to the end of a record.
    """
    speeds: float | tuple[tuple[float, float], ...]
    if isinstance(speed, float | int):
        speeds = speed
    else:
        start, end = speed
        speeds = ((0.0, start), (seconds, end))
    rolling = scene.rolling.model_copy(update={"speed_m_s": speeds})
    return values_in_si.motion_of(scene.sphere, rolling)


def make_long_record(
    scene: Scene,
    result: Result,
    sound: ContactSound,
    vibration: Vibration | LinearVibration | None,
    *,
    seconds: float,
    speed: Speed | None = None,
    seed: int = 0,
) -> Listening:
    """Make a long record of a run that has no reason against it, at its own speed or another.

    A sound of a vibration goes on by its motion, or by the linear chain that estimates it.

    Raises
    ------
    ListeningError : the sphere passes too many positions, or its steps are too long for the speed.
    """
    motion = scene.motion if speed is None else motion_at_speed(scene, speed, seconds)
    _refuse_slow(scene, motion.fastest(seconds))
    positions = float(motion.distance(seconds)) / result.step
    most = defaults.MAX_LISTENED_POSITIONS
    if positions > most:
        raise ListeningError(
            f"speed: the sphere passes {positions:.2g} positions, allowed is up to {most:.2g}, "
            "which take ten minutes"
        )
    travel = LongTravel(motion=motion, seconds=seconds, seed=seed, turn=turn_of(scene))
    with progress.Bar(seconds, "listening") as bar:
        lap = result.solved_steps
        is_closed = scene.track.lap_steps <= lap and not sound.has_seam
        if sound.source == "release" or vibration is None:
            energy, _ = released_energy(scene, result)
            record = long_listening.listen_to_release(
                energy[:lap], result.step, is_closed, listener_of(scene), travel, bar.update
            )
        elif isinstance(vibration, LinearVibration):
            approach = result.series["approach"][:lap]
            record = long_listening.listen_to_chain(
                vibration, approach, is_closed, travel, bar.update
            )
        else:
            record = long_listening.listen_to_vibration(
                bodies_of(scene), listener_of(scene), vibration.law, travel, bar.update
            )
    ends = ends_within(sound, motion, seconds)
    numbers = replace(record.numbers, seed=seed, ends=ends)
    if ends:
        levels = level.sound_levels(record.pressure, record.sample_rate)
        numbers = replace(
            numbers,
            lae_db=level.lae_db(record.pressure, record.sample_rate),
            laf_max_db=levels.laf_max_db,
            las_max_db=levels.las_max_db,
            lz_peak_db=levels.lz_peak_db,
        )
    return replace(record, numbers=replace(numbers, limits=_limits(numbers)))


def ends_within(sound: ContactSound, motion: Motion, seconds: float) -> bool:
    """Tell whether a record of so many seconds is of something that ends.

    The fall of a ball ends, and so does a ball that comes to rest, at the latest in the fade of
    the record. Such a record does not go round.
    """
    return sound.once or motion.rest_time <= seconds + FADE_S


def _refuse_slow(scene: Scene, fastest: float) -> None:
    """Refuse a highest speed [m/s] at which the steps that `auto` chose do not hold hearing."""
    choice = scene.step_choice
    if choice is not None and fastest < choice.lowest:
        raise ListeningError(
            f"speed: got {rounded(fastest, 3)} m/s, and the steps of {micrometres(scene.step)} um"
            f" hold hearing from {rounded_up(choice.lowest)} m/s on; for a slower sphere march"
            " again, at that speed or with numerics.step_nodes 1"
        )


def refuse_long_record(seconds: float, speed: Speed | None, seed: int) -> None:
    """Refuse a length [s], a speed [m/s] and a seed that are not possible.

    Raises
    ------
    ListeningError : the first of them that is not allowed.
    """
    if type(seed) is not int or seed < 0:
        raise ListeningError(f"seed: got {seed!r}, allowed: a whole number >= 0")
    least = defaults.MIN_LISTENED_SECONDS
    most = defaults.MAX_LISTENED_SECONDS
    if not least <= seconds <= most:
        raise ListeningError(
            f"seconds: got {seconds:g}, allowed is {least:g} to {most:g}, for which memory suffices"
        )
    if speed is None:
        return
    speeds = np.asarray(speed, dtype=float)
    is_one_or_two = speeds.shape in ((), (2,))
    if not is_one_or_two or not (speeds.min() >= 0 and 0 < speeds.max() < math.inf):
        got = ":".join(f"{value:g}" for value in speeds.ravel())
        raise ListeningError(f"speed: got {got}, allowed: at least 0 m/s, and not only 0")


def _limits(numbers: ListeningNumbers) -> tuple[str, ...]:
    """List the limits of a long record."""
    lowest_hz = numbers.lowest_frequency_hz or 0.0
    highest_hz = numbers.highest_frequency_hz or math.inf
    solved_mm = numbers.solved_mm or 0.0
    turn_mm = numbers.turn_mm
    outside = numbers.force_outside_share or 0.0
    limits = []
    if highest_hz < COARSE_HZ:
        limits.append(
            f"the steps of the track resolve sound up to {rounded(highest_hz)} Hz at this speed; "
            "the rest is missing"
        )
    if turn_mm is not None and solved_mm < turn_mm:
        limits.append(
            f"the solved track is shorter than a turn of the ball ({rounded(turn_mm, 3)} mm): it "
            "is put in as solved once per turn, and the rest of the turn is random, but for the "
            "waves around the ball"
        )
    if outside > OFTEN:
        limits.append(
            f"the force lies beyond the marched loads for {100 * outside:.0f} % of the time"
        )
    if lowest_hz > LONG_WAVES_HZ:
        limits.append(
            f"waves longer than the solved track sound below {rounded(lowest_hz)} Hz, where the "
            "density is that of the longest solved wave"
        )
    return tuple(limits)
