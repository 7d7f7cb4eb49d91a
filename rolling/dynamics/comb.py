"""Comb of a looped record: the levels of the lines of a lap at speeds that differ a little.

The force of a lap has lines, and a sharp resonance falls on a line or between two: that of the
sphere on its contact, or a mode of the plate at the frequency that halves the power.
"""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ
from rolling.dynamics.bodies import Chain

BROAD = 4.0  # lines of a looped record in the bandwidth of a broad resonance
NEAR_SPEEDS = 0.03  # relative change of the speed over which the levels of a looped record spread
COMB_MOST_DB = 3.0  # spread from which on a level is the mean over the comb
FEWEST_SPEEDS = 60
MOST_SPEEDS = 1000
_MAX_LINES = 200_000  # lines of all speeds, unless the minimum has more
_LINES_AT_ONCE = 20_000  # for which the gain is asked at once, because each question takes time


class LinesAtSpeed(NamedTuple):
    """Audible lines of a lap at one speed."""

    frequency_hz: Array  # (lines,)
    audible: NDArray[np.bool_]  # (all lines,) which of the lines of a lap they are
    gain: Array  # (lines,) from mean square of a line to A-weighted power


class Comb(NamedTuple):
    """Levels of a looped record over speeds within 3 %, by the linear chain."""

    spread_db: float  # rms difference of LAeq from the level of the mean power
    mean_laeq_db: float | None  # level of the mean power
    band_spread_db: Array  # (31,) as `spread_db`; 0 where a band is silent at one of the speeds


def speeds_of_comb(
    chain: Chain,
    lines: Array,
    line_hz: float,
    loss_factor: float,
    gain: Callable[[Array], Array],
    most_speeds: int = MOST_SPEEDS,
) -> Iterator[LinesAtSpeed] | None:
    """Return the lines at speeds within 3 %; None where the resonance holds several lines.

    `lines` (n,) are mean squares of the lines of a lap, `line_hz` apart at the speed of the scene,
    and `gain` turns them into A-weighted power. `loss_factor` is that of a plate with modes.
    There are 60 speeds, or more for a sharper resonance, up to `most_speeds`.
    """
    order_hz = line_hz * np.arange(1, len(lines) + 1)

    def at_speeds(ratios: Array) -> Iterator[LinesAtSpeed]:
        """Yield the lines at each ratio of speeds."""
        parts = math.ceil(ratios.size * len(lines) / _LINES_AT_ONCE)
        for some in np.array_split(ratios, min(parts, ratios.size)):
            frequencies = np.asarray(some[:, None] * order_hz, dtype=float)
            audible = (frequencies > AUDIBLE_HZ[0]) & (frequencies < AUDIBLE_HZ[1])
            gains = gain(frequencies[audible])
            ends = np.cumsum(audible.sum(axis=1))[:-1]
            for frequency, is_audible, gain_of_lines in zip(
                frequencies, audible, np.split(gains, ends), strict=True
            ):
                yield LinesAtSpeed(
                    frequency_hz=frequency[is_audible], audible=is_audible, gain=gain_of_lines
                )

    quality = chain.quality
    sharpest_hz = chain.resonance_hz
    most = most_speeds
    if chain.modes is not None:
        (own,) = at_speeds(np.ones(1))
        power_up_to = np.cumsum(lines[own.audible] * own.gain)
        if not len(power_up_to) or not power_up_to[-1] > 0:
            return None
        sharpest_hz = float(own.frequency_hz[np.searchsorted(power_up_to, power_up_to[-1] / 2)])
        quality = 1 / (loss_factor or 1.0)
        most = min(most, max(FEWEST_SPEEDS, _MAX_LINES // len(power_up_to)))
    if sharpest_hz / quality > BROAD * line_hz:
        return None
    count = int(np.clip(16 * NEAR_SPEEDS * quality, min(FEWEST_SPEEDS, most), most))
    ratios = np.linspace(1 - NEAR_SPEEDS, 1 + NEAR_SPEEDS, count)
    return at_speeds(ratios)


def spread_db(powers: Array) -> float:
    """Return the rms difference of levels from the level of their mean power [dB].

    It is 0 where a power is missing: a band that holds a single line may lose it.
    """
    if not powers.min() > 0:
        return 0.0
    return float(np.sqrt(np.mean(np.square(10 * np.log10(powers / powers.mean())))))
