"""Long listening to runs: the solved track first, then its random continuation, in motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import decibels_a, rounded
from rolling.marches.result import Result
from rolling.scene.scene import Scene
from rolling.sound.contact_sound import contact_sound
from rolling.sound.long_listening import (
    Listening,
    listen_to_release,
    listen_to_vibration,
    with_speed,
)
from rolling.terminal import defaults

if TYPE_CHECKING:
    from rolling.results.run_result import Run

Speed = float | tuple[float, float]  # [m/s], constant or from start to end

LEAST_POSITIONS = 64  # of a solved track; fewer have no spectrum
COARSE_HZ = 10e3  # highest frequency of the steps below which the sound is dull
OFTEN = 0.1  # of a record's duration, in which forces beyond the marched loads are named
LONG_WAVES_HZ = 500.0  # lowest frequency of the solved track above which its long waves are named


class ListeningError(ValueError):
    """Reason why a run has no long listening."""


def released(scene: Scene, result: Result) -> tuple[Array, bool]:
    """Return the energy [J] released in each step of a run, and whether the steps are closed."""
    closed = result.steps % result.solved_steps == 0 and scene.track.closed
    moving = result.moving if scene.moves_release else None
    energy = result.whole("release_energy")
    if moving is not None and not moving.fault:
        closed = closed and moving.repeats
        energy = moving.steps["release_energy"][np.arange(result.steps) % result.solved_steps]
    return energy, closed


def reason_against(run: Run) -> str:
    """Return the reason why a run has no long record; empty if it has one."""
    steps, sound = run.result.solved_steps, run.sound
    if steps < LEAST_POSITIONS:
        return f"its solved track has {steps} steps, and a continuation needs {LEAST_POSITIONS}"
    if sound.source == "vibration" or not sound.pressure.any():
        return "" if sound.pressure.any() else "its record is silent"
    if not sound.constant_speed:
        steady = with_speed(run.scene, run.scene.motion.fastest(sound.duration), sound.duration)
        energy, closed = released(run.scene, run.result)
        sound = contact_sound(steady, energy, run.result.step, closed, steps, sound.has_seam)
    reason = sound.unlike_noise
    return reason and f"{reason}: a random continuation would not sound like it"


def listen(run: Run, seconds: float, speed: Speed | None = None, seed: int = 0) -> Listening:
    """Make a long record of a run; raise ListeningError where there is none."""
    _refuse(seconds, speed)
    if run.no_long:
        raise ListeningError(run.no_long)
    scene = run.scene if speed is None else with_speed(run.scene, speed, seconds)
    positions = float(scene.motion.distance(seconds)) / run.result.step
    if positions > (most := defaults.MOST_LISTENED_POSITIONS):
        raise ListeningError(
            f"speed: the sphere passes {positions:.2g} positions, allowed is up to {most:.2g},"
            " which take ten minutes"
        )
    if run.vibration is not None and run.sound.source == "vibration":
        listening = listen_to_vibration(scene, run.vibration.law, seconds, seed)
    else:
        lap, track = run.result.solved_steps, run.scene.track
        energy = released(run.scene, run.result)[0][:lap]
        closed = track.lap_steps <= lap and not run.sound.has_seam
        listening = listen_to_release(scene, energy, run.result.step, closed, seconds, seed)
    listening.numbers["seed"] = seed
    listening.numbers["limits"] = limits(listening.numbers)
    return listening


def _refuse(seconds: float, speed: Speed | None) -> None:
    """Refuse a length and a speed that are not possible."""
    least, most = defaults.LEAST_LISTENED_SECONDS, defaults.MOST_LISTENED_SECONDS
    if not least <= seconds <= most:
        raise ListeningError(
            f"seconds: got {seconds:g}, allowed is {least:g} to {most:g}, for which memory suffices"
        )
    speeds = () if speed is None else np.atleast_1d(speed).tolist()
    if speeds and not (all(0 <= v < math.inf for v in speeds) and max(speeds) > 0):
        got = ":".join(f"{v:g}" for v in speeds)
        raise ListeningError(f"speed: got {got}, allowed: at least 0 m/s, and not only 0")


# ---- texts


def sentence(numbers: Mapping[str, Any], run_laeq_db: float | None) -> str:
    """Say length, level, kurtosis, impacts and the solved share of a long record."""
    solved, rolled = (rounded(numbers[f"{name}_mm"], 3) for name in ("solved", "rolled"))
    track = "all solved"
    if numbers["solved_mm"] < numbers["rolled_mm"]:
        share = rounded(100 * numbers["solved_share"])
        track = (
            f"of which the first {solved} mm ({share} % of the time) are solved and the others"
            f" follow their statistics at random (seed {numbers['seed']})"
        )
    text = (
        f"{rounded(numbers['seconds'], 4)} s over {rolled} mm, {track}: LAeq"
        f" {decibels_a(numbers['laeq_db'])} (the run {decibels_a(run_laeq_db)}), kurtosis"
        f" {'-' if numbers['kurtosis'] is None else format(numbers['kurtosis'], '.2f')}"
    )
    if "impacts" in numbers:
        text += f", {rounded(numbers['impacts'] / numbers['seconds'], 3)} impacts per second"
    if numbers["stretches"]:
        text += f", {numbers['stretches']} rare stretches inserted as solved"
    return text


def limits(numbers: Mapping[str, Any]) -> list[str]:
    """List the limits of a long record."""
    texts = []
    if numbers["highest_frequency_hz"] < COARSE_HZ:
        texts.append(
            "the steps of the track resolve sound up to"
            f" {rounded(numbers['highest_frequency_hz'])} Hz at this speed; the rest is missing"
        )
    if (turn := numbers["turn_mm"]) is not None and numbers["solved_mm"] < turn:
        texts.append(
            f"the solved track is shorter than a turn of the ball ({rounded(turn, 3)} mm): it is"
            " put in as solved once per turn, and the rest of the turn is random"
        )
    if numbers.get("force_outside_share", 0.0) > OFTEN:
        texts.append(
            f"the force lies beyond the marched loads for"
            f" {100 * numbers['force_outside_share']:.0f} % of the time"
        )
    if numbers["lowest_frequency_hz"] > LONG_WAVES_HZ:
        texts.append(
            f"waves longer than the solved track sound below"
            f" {rounded(numbers['lowest_frequency_hz'])} Hz, where the density is that of the"
            " longest solved wave"
        )
    return texts
