"""Running-in: level, release, plastic work and depth of each pass, and all passes for the ear."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from acoustics import resampling, wav
from acoustics.arrays import Array
from acoustics.numbers import decibels_a
from rolling.sound.contact_sound import FADE_S
from rolling.sound.radiators import vibration_estimate

if TYPE_CHECKING:
    from rolling.results.run_result import Run

PASS_S, PAUSE_S = 1.5, 0.25  # [s] of a pass for the ear, and of the silence after it
MOST_HEARD = 12  # passes in the WAV; of more, it holds passes in a geometric sequence


def pass_numbers(run: Run) -> list[dict[str, Any]]:
    """Return levels, release power, plastic work and maximum depth of each pass.

    The level of the vibration is an estimate from the approach, for scenes without dynamics.
    """
    scene, result, passes = run.scene, run.result, run.result.passes
    numbers = list[dict[str, Any]]()
    assert passes is not None  # asked for by the caller
    places = np.append(np.arange(result.steps) % result.solved_steps, -1)
    places[-1] = places[-2] + 1
    for k, sound in enumerate(run.pass_sounds):
        vibration = None
        if scene.dynamics is None:
            approach = passes.series["approach"][k, places]
            vibration, _ = vibration_estimate(scene, approach, result.step, sound.closed)
        numbers.append(
            {
                "laeq_db": sound.levels.laeq_db,
                "level_db": sound.levels.level_db,
                "vibration_estimate_laeq_db": vibration,
                "release_power_mean_w": sound.mean_power,
                "plastic_work_j": float(passes.series["plastic_work"][k].sum()),
                "depth_um": float(passes.depth[k]) * 1e6,
            }
        )
    return numbers


def passes_wav(run: Run, bits: Literal[16, 24] = 24) -> tuple[bytes, str]:
    """Return a WAV of the passes of a run in sequence, and a description of its content."""
    count, rate = len(run.pass_sounds), wav.SAMPLE_RATE_HZ
    chosen = np.unique(np.geomspace(1, count, MOST_HEARD).round().astype(int))
    chosen = np.arange(1, count + 1) if count <= MOST_HEARD else chosen
    pause, parts, words = np.zeros(round(PAUSE_S * rate)), list[Array](), list[str]()
    for number in chosen:
        sound = run.pass_sounds[number - 1]
        lap = np.resize(sound.lap.samples(sound.pressure), round(PASS_S * rate))
        parts += [resampling.fade(lap, round(FADE_S * rate)), pause]
        words.append(f"{number} ({decibels_a(sound.levels.laeq_db)})")
    record = np.concatenate(parts)
    gain = wav.listening_gain(record)
    content = f"{PASS_S:g} s of each pass at one gain, with its LAeq: {', '.join(words)}"
    comment = f"{gain:.6g} full scale per Pa; {content}"
    return wav.listening(record, gain, comment, f"{run.scene.name}, {run.label}", bits), content
