"""Rows and tables of the conformance page, and what its measurements share. Depends on radiation and wav."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from acoustics.radiation import P_REF_PA
from acoustics.wav import SAMPLE_RATE_HZ

ONE_PA_DB = 20.0 * math.log10(1.0 / P_REF_PA)

# Attenuations above this count as infinite: their digits would be rounding, which differs from machine to machine. The
# sine of 1e6 rad is wrong by 1e-10 (-200 dB), which moves what lies at -120 dB by 1e-3 dB at most.
GREATEST_DB = 120.0


@dataclass(frozen=True)
class Row:
    """One comparison: what was measured, the design goal, what this package computes, and the limits.

    The limits are on computed - expected. Where the design goal is infinite (an attenuation), ``lower`` is the least
    value required and ``upper`` is infinite.
    """

    what: tuple[str, ...]
    expected: float
    computed: float
    lower: float
    upper: float

    @property
    def difference(self) -> float:
        """Computed - expected; not a number where the design goal is infinite."""
        return math.nan if math.isinf(self.expected) else self.computed - self.expected

    @property
    def share(self) -> float:
        """Share of the tolerance used, %: the difference over the limit on its side, or required over computed.

        Above 100 the limit is exceeded. Rounded to what a page shows, so that rows that differ by rounding are equal.
        """
        if math.isinf(self.expected):
            share = self.lower / self.computed if self.computed > 0.0 else math.inf
        else:
            share = self.difference / (self.upper if self.difference > 0.0 else self.lower)
        return round(100.0 * share, 1) + 0.0

    @property
    def within(self) -> bool:
        return self.share <= 100.0


@dataclass(frozen=True)
class Table:
    """Rows of one kind.

    ``limits`` names whose limits they are, ``source`` the clause, ``text`` how it is measured, ``heads`` the columns of
    `Row.what`, ``after`` what follows from the rows.
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
        """The row that uses most of its tolerance, the first of equals."""
        return max(self.rows, key=lambda row: row.share)

    @property
    def outside(self) -> tuple[Row, ...]:
        return tuple(row for row in self.rows if not row.within)


def tone(frequency_hz: float, samples: int, rate_hz: float = SAMPLE_RATE_HZ, phase: float = 0.4) -> np.ndarray:
    """A sine of 1 Pa rms (samples,)."""
    return math.sqrt(2.0) * np.sin(2.0 * np.pi * frequency_hz / rate_hz * np.arange(samples) + phase)


def suppression_db(left: float) -> float:
    """Attenuation, dB, that leaves this share of a mean square; infinite above what rounding leaves."""
    attenuation = -10.0 * math.log10(left) if left > 0.0 else math.inf
    return attenuation if attenuation <= GREATEST_DB else math.inf


def known(level: float | None) -> float:
    """A level that must exist.

    Raises
    ------
    ValueError
        If it does not.
    """
    if level is None:
        raise ValueError("a level that must exist is None")
    return level
