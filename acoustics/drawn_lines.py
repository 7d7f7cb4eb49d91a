"""Spectra and records, thinned to the points that a plot can show."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from acoustics._typing import Array
from acoustics.bands import AUDIBLE_HZ

PER_OCTAVE = 12  # means per octave drawn for dense spectra
NOTHING_DB = -300.0  # replaces -inf, which matplotlib would drop together with its neighbours
DENSE = 500  # more lines hide one another, so they fade behind their mean
# columns across a plot: more than its dots, so an envelope looks like the curve itself
_COLUMNS = 1500


@dataclass(frozen=True, eq=False)
class Lines:
    """A spectrum from 20 Hz to 20 kHz for a plot; its means and envelope are computed once.

    Parameters
    ----------
    frequency_hz : array (n,), Hz. Rising frequencies of the lines.
    level_db : array (n,), dB. Their levels; -inf is silence.
    """

    frequency_hz: Array
    level_db: Array

    @classmethod
    def audible(cls, frequency_hz: Array, level_db: Array) -> Lines:
        """Keep the lines between 20 Hz and 20 kHz."""
        inside = (frequency_hz >= AUDIBLE_HZ[0]) & (frequency_hz < AUDIBLE_HZ[1])
        return cls(frequency_hz[inside], level_db[inside])

    @property
    def dense(self) -> bool:
        """Whether there are too many lines to distinguish them."""
        return len(self.frequency_hz) > DENSE

    @cached_property
    def mean(self) -> tuple[Array, Array]:
        """Mid frequency and level of the mean power of the lines in each 1/12 octave.

        Parts of the axis without lines are left out.
        """
        return _band_mean(self.frequency_hz, self.level_db)

    @cached_property
    def envelope(self) -> tuple[Array, Array]:
        """The lines, thinned to the minimum and maximum of each column of the plot.

        Columns with a single line are unchanged.
        """
        low, high = np.log(AUDIBLE_HZ)
        column = (np.log(self.frequency_hz) - low) / (high - low)
        return _thinned(self.frequency_hz, np.maximum(self.level_db, NOTHING_DB), column)

    @cached_property
    def extremes(self) -> list[float]:
        """Minimum and maximum level to show, dB; empty for a silent spectrum.

        Single low lines of a dense spectrum do not count.
        """
        shown = np.append(self.mean[1], self.level_db.max()) if self.dense else self.level_db
        shown = shown[shown > NOTHING_DB]
        return [float(shown.min()), float(shown.max())] if len(shown) else []


def is_thinned(time_s: Array) -> bool:
    """Return whether a plot shows fewer values than a record has."""
    return len(time_s) > 2 * _COLUMNS


def power_envelope(time_s: Array, power_w: Array) -> tuple[Array, Array]:
    """Return time and power as they are drawn.

    More than 3,000 values are thinned to the minimum and maximum in each of 1,500 columns.
    """
    if not is_thinned(time_s):
        return time_s, power_w
    return _thinned(time_s, power_w, (time_s - time_s[0]) / (time_s[-1] - time_s[0]))


def _thinned(x: Array, y: Array, share: Array) -> tuple[Array, Array]:
    """Replace the points of each column of a plot by its minimum and maximum y at its first x.

    Columns of one or two points stay. x rises, and `share` (n,), 0 to 1, is the place of each point
    in the width of the plot.
    """
    column = np.minimum(np.floor(share * _COLUMNS), _COLUMNS - 1)
    starts = np.flatnonzero(np.diff(column, prepend=-1.0))
    counts = np.diff(starts, append=len(x))
    crowded = counts > 2
    alone = np.repeat(~crowded, counts)
    at = np.repeat(x[starts[crowded]], 2)
    extremes = np.stack(
        [np.minimum.reduceat(y, starts)[crowded], np.maximum.reduceat(y, starts)[crowded]], 1
    ).ravel()
    merged = np.argsort(np.concatenate([x[alone], at]), kind="stable")
    return np.concatenate([x[alone], at])[merged], np.concatenate([y[alone], extremes])[merged]


def _band_mean(frequency_hz: Array, level_db: Array) -> tuple[Array, Array]:
    """Return mid frequency and level of the mean power of the lines in each 1/12 octave.

    Parts of the axis without lines are left out.
    """
    octaves = math.log2(AUDIBLE_HZ[1] / AUDIBLE_HZ[0])
    edges = AUDIBLE_HZ[0] * 2.0 ** (np.arange(math.ceil(octaves * PER_OCTAVE) + 1) / PER_OCTAVE)
    band = np.searchsorted(edges, frequency_hz, side="right") - 1
    lines = np.bincount(band, minlength=len(edges) - 1)
    power = np.bincount(band, weights=10.0 ** (level_db / 10.0), minlength=len(edges) - 1)
    held = lines > 0
    mid = np.sqrt(edges[:-1] * edges[1:])
    with np.errstate(divide="ignore"):
        level = 10.0 * np.log10(power[held] / lines[held])
    return mid[held], np.maximum(level, NOTHING_DB)
