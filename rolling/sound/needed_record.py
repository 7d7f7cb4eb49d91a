"""Rule of a track whose length is `auto`: the shortest record whose levels are known well enough.

The rule takes the spectrum that a linear chain expects, and what the record has to hold whatever
its spectrum is. It knows no scene. tests/benchmarks/length_study.py tells how closely the wanted
uncertainties are met (docs/accuracy.md).
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from acoustics.bands import BAND_NAMES, EDGES_HZ, third_octave_mean_square
from acoustics.uncertainty import ExpectedUncertainty, expected_uncertainty
from acoustics.weighting import a_weighting_db

BAND_RATIO = 10 / 3  # of the wanted uncertainty of a third octave over that of LAeq
LOUD_DB = 10.0  # third octaves so far below the loudest one, A-weighted, count
LINES_IN_BAND = 4  # of the record in each third octave that counts, at least
LINES_IN_RESONANCE = 3.0  # of the record in the bandwidth of the resonance, at least
CARRIES = 0.1  # share of the A-weighted power within a bandwidth of a resonance that carries it


@dataclass(frozen=True)
class ExpectedVibration:
    """What a listener is expected to hear of a vibration.

    Attributes
    ----------
    frequency_hz : (n,) array, Hz
        Frequencies, dense enough for the narrowest resonance.
    density : (n,) array, Pa2/Hz
        One-sided spectral density of the sound pressure, to any factor.
    resonance_hz : float, Hz
        Frequency of the narrowest resonance.
    quality : float
        Its quality factor, infinite without losses.
    uneven_db2_s : float, dB2 s
        Variance that few asperities add to a level, times the length of the record.
    """

    frequency_hz: Array
    density: Array
    resonance_hz: float
    quality: float
    uneven_db2_s: float = 0.0

    def lines(self, seconds: float) -> tuple[Array, Array]:
        """Return frequencies [Hz] and expected mean squares of the lines of a record [s].

        A line has the power of its interval, whether a resonance falls on it or between two.
        """
        first = math.ceil(self.frequency_hz[0] * seconds)
        last = max(first, math.floor(self.frequency_hz[-1] * seconds))
        number = np.arange(first, last + 1)
        edges = (np.arange(first, last + 2) - 0.5) / seconds
        steps = np.diff(self.frequency_hz)
        means = 0.5 * (self.density[1:] + self.density[:-1])
        power_up_to = np.concatenate(([0.0], np.cumsum(means * steps)))
        powers = np.diff(np.interp(edges, self.frequency_hz, power_up_to))
        return number / seconds, powers

    @property
    def is_silent(self) -> bool:
        """Whether nothing is heard, such as what is far below hearing."""
        return not float(self.density.max()) > 0 or len(self.loud_bands) == 0

    @property
    def resonance_share(self) -> float:
        """Share of the A-weighted power within a bandwidth on both sides of the resonance."""
        if not math.isfinite(self.quality):
            return 1.0
        weighted = self.density * 10 ** (a_weighting_db(self.frequency_hz) / 10)
        width = self.resonance_hz / self.quality
        is_near = np.abs(self.frequency_hz - self.resonance_hz) < width
        near = np.trapezoid(np.where(is_near, weighted, 0.0), self.frequency_hz)
        return float(near / np.trapezoid(weighted, self.frequency_hz))

    @property
    def loud_bands(self) -> NDArray[np.int_]:
        """Numbers of the third octaves that count, those near the A-weighted loudest one."""
        frequency, powers = self.lines(1.0 + LINES_IN_BAND / self.frequency_hz[0])
        weighted = powers * 10 ** (a_weighting_db(frequency) / 10)
        bands = third_octave_mean_square(frequency, weighted)
        return np.flatnonzero(bands > bands.max() * 10 ** (-LOUD_DB / 10))


class Need(NamedTuple):
    """Least length [s] of a record, and what needs it in words."""

    seconds: float
    reason: str


def needed_record(expected: ExpectedVibration, within_db: float, most_s: float) -> Need:
    """Return the shortest record whose LAeq and loud third octaves are known within bounds.

    Parameters
    ----------
    expected : ExpectedVibration. What is heard.
    within_db : float, dB. Wanted standard uncertainty of LAeq; that of the third octaves within
        10 dB of the loudest one is BAND_RATIO times it.
    most_s : float, s. Longest record that is allowed.

    Returns
    -------
    need : Need. Its reason names what needs most, or what the longest record leaves uncertain.
    """
    if expected.is_silent:
        return Need(0.0, "nothing is heard")
    bands = expected.loud_bands
    band_db = BAND_RATIO * within_db
    lengths = _lengths(most_s)

    def shortest(is_enough: Callable[[ExpectedUncertainty], bool]) -> float:
        """Return the shortest of the lengths that is enough, or the longest."""
        place = bisect_left(lengths, True, key=lambda s: is_enough(record_uncertainty(expected, s)))
        return lengths[min(place, len(lengths) - 1)]

    needs = [
        Need(
            shortest(lambda levels: levels.laeq_db <= within_db),
            f"LAeq within ± {within_db:g} dB",
        ),
        Need(
            shortest(lambda levels: bool(levels.third_octave_db[bands].max() <= band_db)),
            f"third octaves within ± {band_db:.2g} dB, the lowest at {BAND_NAMES[bands[0]]} Hz",
        ),
        *_floors(expected, bands, most_s),
    ]
    longest = longest_need(needs)
    if longest.seconds < lengths[-1]:
        return longest
    left = record_uncertainty(expected, longest.seconds)
    most_db = left.third_octave_db[bands].max()
    return Need(
        longest.seconds,
        f"{longest.reason}, as far as the longest track of auto allows: ± {left.laeq_db:.1f} dB"
        f" of LAeq and ± {most_db:.1f} dB of third octaves are left",
    )


def longest_need(needs: Sequence[Need]) -> Need:
    """Return the longest of some needs, the first of equal ones."""
    return max(needs, key=lambda need: need.seconds)


def two_digits_up(value: float) -> float:
    """Return a positive number rounded up to two digits, the same on every machine."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.ceil(value / unit * (1 - 1e-9)) * unit:.6g}")


def _floors(expected: ExpectedVibration, bands: NDArray[np.int_], most_s: float) -> list[Need]:
    """Return what a record has to hold for the lines of its lap."""
    lowest = int(bands[0])
    width_hz = float(EDGES_HZ[lowest + 1] - EDGES_HZ[lowest])
    floors = [
        Need(
            two_digits_up(LINES_IN_BAND / width_hz),
            f"{LINES_IN_BAND} lines in the third octave of {BAND_NAMES[lowest]} Hz",
        )
    ]
    # The comb of a resonance that needs a longer record than allowed is a part of the uncertainty.
    seconds = LINES_IN_RESONANCE * expected.quality / expected.resonance_hz
    if seconds < most_s and expected.resonance_share > CARRIES:
        words = f"{LINES_IN_RESONANCE:g} lines in the resonance at {expected.resonance_hz:.0f} Hz"
        floors.append(Need(two_digits_up(seconds), words))
    return floors


def _lengths(most_s: float) -> list[float]:
    """Return the lengths of two digits up to a longest one [s], and that one, in their order."""
    lengths = [
        float(f"{digits}e{exponent}") for exponent in range(-5, 3) for digits in range(10, 100)
    ]
    return [*(length for length in lengths if length < most_s), most_s]


def record_uncertainty(expected: ExpectedVibration, seconds: float) -> ExpectedUncertainty:
    """Return the uncertainty of the levels of a record of some length [s]."""
    frequency, powers = expected.lines(seconds)
    if not powers.sum() > 0:  # no line is heard
        frequency = powers = np.ones(1)
    of_lines = expected_uncertainty(frequency, powers)
    uneven_db = math.sqrt(expected.uneven_db2_s / seconds)
    return ExpectedUncertainty(
        laeq_db=math.hypot(of_lines.laeq_db, uneven_db),
        third_octave_db=np.hypot(of_lines.third_octave_db, uneven_db),
    )
