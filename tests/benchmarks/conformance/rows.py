"""Rows and tables of the conformance page, and the functions that its measurements share."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array
from acoustics.radiation import P_REF_PA
from acoustics.wav import SAMPLE_RATE_HZ

ONE_PA_DB = 20.0 * math.log10(1.0 / P_REF_PA)

# Attenuations above this count as infinite: their digits would be rounding, which differs between
# machines. The sine of 1e6 rad is wrong by 1e-10 (-200 dB), which changes a level of -120 dB by
# 1e-3 dB at most.
MAX_DB = 120.0


@dataclass(frozen=True)
class Row:
    """A comparison of a computed value with its design goal.

    Parameters
    ----------
    keys : tuple of str. Cells that name the measurement.
    expected, computed : float. Design goal and value of this package.
    lower, upper : float. Limits on computed - expected. If the design goal is infinite (an
        attenuation), ``lower`` is the minimum required and ``upper`` is infinite.
    """

    keys: tuple[str, ...]
    expected: float
    computed: float
    lower: float
    upper: float

    @property
    def difference(self) -> float:
        """Computed - expected; not a number if the design goal is infinite."""
        return math.nan if math.isinf(self.expected) else self.computed - self.expected

    @property
    def share(self) -> float:
        """Share of the tolerance used, %.

        It is the difference over the limit on its side, or the required over the computed
        attenuation. Above 100 the limit is exceeded. The share is rounded to the digits of the
        page, so rows that differ only by rounding are equal.
        """
        if math.isinf(self.expected):
            share = self.lower / self.computed if self.computed > 0.0 else math.inf
        else:
            share = self.difference / (self.upper if self.difference > 0.0 else self.lower)
        return round(100.0 * share, 1) + 0.0

    @property
    def within(self) -> bool:
        """Whether the computed value is within the limits."""
        return self.share <= 100.0


@dataclass(frozen=True)
class Table:
    """Rows of one kind.

    Parameters
    ----------
    title : str. Heading.
    limits : str. Name of the limits, such as class 1.
    source : str. Clause of the standard.
    text : str. Method of the measurement.
    heads : tuple of str. Column heads of `Row.keys`.
    unit : str. Unit of the values.
    decimals : int. Digits after the decimal point.
    rows : tuple of Row.
    after : str. Conclusion below the table. Default: empty.
    """

    title: str
    limits: str
    source: str
    text: str
    heads: tuple[str, ...]
    unit: str
    decimals: int
    rows: tuple[Row, ...]
    after: str = ""

    @property
    def worst(self) -> Row:
        """The first row with the maximum share of its tolerance."""
        return max(self.rows, key=lambda row: row.share)

    @property
    def outside(self) -> tuple[Row, ...]:
        """The rows outside the limits."""
        return tuple(row for row in self.rows if not row.within)


def tone(
    frequency_hz: float, samples: int, rate_hz: float = SAMPLE_RATE_HZ, phase: float = 0.4
) -> Array:
    """Return a sine of 1 Pa rms (samples,)."""
    sine: Array = math.sqrt(2.0) * np.sin(
        2.0 * np.pi * frequency_hz / rate_hz * np.arange(samples) + phase
    )
    return sine


def suppression_db(left: float) -> float:
    """Return the attenuation that leaves a share of a mean square, dB.

    It is infinite if only rounding is left.
    """
    attenuation = -10.0 * math.log10(left) if left > 0.0 else math.inf
    return attenuation if attenuation <= MAX_DB else math.inf


def known(level: float | None) -> float:
    """Return a level, which must exist.

    Raises
    ------
    ValueError
        If the level is None.
    """
    if level is None:
        raise ValueError("a level that must exist is None")
    return level
