"""Comb of a looped record: levels of a sharp resonance that falls on a line or between two."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from acoustics import level
from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ
from acoustics.weighting import a_weighting_db
from rolling.dynamics.bodies import Chain
from rolling.dynamics.force_law import ForceLaw
from rolling.dynamics.of_scene import NEAR_SPEEDS
from rolling.scene.scene import Scene
from rolling.sound.radiators import roughness_gain

BROAD = 4.0  # lines of a looped record in the bandwidth of a broad resonance
_SPEEDS = (60, 1000)  # minimum and maximum number of speeds
_MOST_LINES = 200_000  # lines of all speeds, unless the minimum has more


class Comb(NamedTuple):
    """Levels of a looped record over speeds within 3 %, by the linear chain."""

    spread_db: float  # rms difference of LAeq from the level of the mean power
    mean_laeq_db: float | None  # level of the mean power


def comb(scene: Scene, law: ForceLaw, chain: Chain) -> Comb | None:
    """Return the levels over other speeds; None where a resonance holds several lines.

    The force of a lap has lines, and a sharp resonance falls on a line or between two: that of the
    sphere on its contact, or a mode of the plate at the frequency that halves the power.
    """
    if law.period_m is None:
        return None
    spacing = scene.motion.fastest(scene.duration) / law.period_m
    approach = law.approach(law.position_m, scene.load)
    lines: Array = 2 * np.square(np.abs(np.fft.rfft(approach)[1:] / len(approach)))
    order = np.arange(1, len(lines) + 1)
    gain = roughness_gain(scene, chain)

    def powers(ratio: float) -> tuple[Array, Array, Array]:
        """Return frequencies, mean squares and A-weighted gains of lines at a ratio of speeds."""
        frequency = np.asarray(order * (spacing * ratio), dtype=float)
        audible = (frequency > AUDIBLE_HZ[0]) & (frequency < AUDIBLE_HZ[1])
        frequency = frequency[audible]
        weights: Array = 10 ** (a_weighting_db(frequency) / 10) * gain(frequency)
        return frequency, lines[audible], weights

    quality, middle, most = chain.quality, chain.resonance_hz, _SPEEDS[1]
    if chain.modes is not None:
        frequency, squares, weights = powers(1.0)
        passed = np.cumsum(squares * weights)
        if not len(passed) or not passed[-1] > 0:
            return None
        middle = float(frequency[np.searchsorted(passed, passed[-1] / 2)])
        quality = 1 / (scene.plate.loss_factor or 1.0)
        most = max(_SPEEDS[0], min(most, _MOST_LINES // len(passed)))
    if middle / quality > BROAD * spacing:
        return None
    count = int(np.clip(16 * NEAR_SPEEDS * quality, _SPEEDS[0], most))
    ratios = np.linspace(1 - NEAR_SPEEDS, 1 + NEAR_SPEEDS, count)
    sums = [float(squares @ weights) for _, squares, weights in map(powers, ratios)]
    mean = float(np.mean(sums))
    if not min(sums) > 0:  # no line is heard
        return None
    spread = np.sqrt(np.mean(np.square(10 * np.log10(np.array(sums) / mean))))
    return Comb(float(spread), level.level_db(mean))
