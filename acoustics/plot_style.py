"""The look of curves and axes that all plots share, and records thinned to what a plot shows.

The colours by Okabe and Ito (2008) differ for any colour vision. Line styles differ too, for grey
print. More curves than colours go from dark to light in the given order, as do curves whose order
has a meaning.
"""

from acoustics import matplotlib_import  # noqa: F401, before matplotlib

# isort: split

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex

from acoustics.arrays import Array
from acoustics.bands import AUDIBLE_HZ, BAND_NAMES, MID_HZ

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
LINE_STYLES: tuple[str | tuple[int, tuple[int, ...]], ...] = (
    "-", "--", "-.", ":", (0, (8, 2)), (0, (4, 1, 1, 1, 1, 1)), (0, (1, 1)),
)  # fmt: skip
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
OCTAVES = slice(2, None, 3)  # of the third octaves, the octaves from 31.5 Hz on
# SI prefixes of axes by powers of a thousand
PREFIXES = {-4: "p", -3: "n", -2: "µ", -1: "m", 0: "", 1: "k", 2: "M"}

_SHOWN_DB = 70.0
_ALL_NAMED_IN = 4.3  # width of axes that takes a name for each third octave, side by side
_WIDEST_IN = 0.4  # width of such a name with its distance to the next
FEW = 3  # maximum number of curves with distinguishable lines or error bars
PER_OCTAVE = 12  # means per octave drawn for dense spectra
NOTHING_DB = -300.0  # replaces -inf, which matplotlib would drop together with its neighbours
DENSE = 500  # more lines hide one another, so they fade behind their mean
# columns across a plot: more than its dots, so an envelope looks like the curve itself
_COLUMNS = 1500


# ---- axes and curves


def level_limits(levels_db: Iterable[float | None]) -> tuple[float, float]:
    """Return limits of a level axis, at most 70 dB apart.

    The limits are multiples of 5 dB and leave room of at least 2.5 dB. Give all
    curves of several plots together to get a common axis.

    Parameters
    ----------
    levels_db : iterable of float or None, dB
        Levels; None and values below -300 do not count.

    Returns
    -------
    pair of float, dB
        Lower and upper limit; 0 to 70 without any level.

    Examples
    --------
    >>> from acoustics import plots
    >>> plots.level_limits([41.0, None, 62.0])
    (35.0, 65.0)
    """
    values = numbers(levels_db)
    values = values[np.isfinite(values) & (values > NOTHING_DB)]
    if not len(values):
        return 0.0, _SHOWN_DB
    top = 5.0 * math.ceil(float(values.max()) / 5.0 + 0.5)
    bottom = 5.0 * math.floor(float(values.min()) / 5.0 - 0.5)
    return max(bottom, top - _SHOWN_DB), top


def gridded(ax: Axes, **labels: str) -> Axes:
    """Label axes and draw a pale grid behind their curves."""
    ax.set(**labels)
    ax.grid(True, color="0.85", linewidth=0.5)
    ax.set_axisbelow(True)
    return ax


def band_ticks(ax: Axes, octaves: bool = False) -> None:
    """Name third octaves along x; octaves where that is asked for, or where they would overlap."""
    width_in = ax.get_window_extent().width / ax.figure.dpi
    named = OCTAVES if octaves or width_in < _ALL_NAMED_IN else slice(None)
    names = [short_name(name) for name in BAND_NAMES[named]]
    if len(names) * _WIDEST_IN > width_in:
        ax.set_xticks(MID_HZ[named], names, rotation=90, fontsize="small")
    else:
        ax.set_xticks(MID_HZ[named], names, rotation=0, fontsize="medium")


def say_if_silent(ax: Axes, sounds: bool) -> None:
    """Write `no sound` on axes without a level."""
    if not sounds:
        ax.text(
            0.5,
            0.5,
            "no sound",
            color="0.4",
            fontsize=14,
            ha="center",
            va="center",
            transform=ax.transAxes,
        )


def curve_style(number: int, count: int, ordered: bool = False) -> dict[str, Any]:
    """Return colour, line style and marker of a curve among `count` curves.

    Colours go from dark to light if the order of the curves has a meaning, or if they are many.
    """
    colour = COLOURS[number % len(COLOURS)]
    if count > len(COLOURS) or (ordered and count >= FEW):
        # Beyond 0.72 the map has a contrast below 2.5 to white paper.
        colour = to_hex(matplotlib.colormaps["plasma"](0.72 * number / (count - 1)))
    return {
        "color": colour,
        "linestyle": LINE_STYLES[number % len(LINE_STYLES)],
        "marker": MARKERS[number % len(MARKERS)],
    }


def error_bars(
    ax: Axes,
    x: Array,
    level_db: Array,
    uncertainty_db: Array,
    colour: str,
    label: str = "_nolegend_",
) -> None:
    """Draw error bars of the standard uncertainty; a label is the name of their curve."""
    ax.errorbar(
        x,
        level_db,
        uncertainty_db,
        fmt="none",
        label=label,
        ecolor=colour,
        elinewidth=0.9,
        capsize=2.5,
        capthick=0.9,
    )


def numbers(levels_db: Iterable[float | None]) -> Array:
    """Return levels as an array, with NaN in place of None."""
    return np.array([np.nan if level is None else level for level in levels_db], dtype=float)


def unit_prefix(largest: float) -> tuple[float, str]:
    """Return the factor and the SI prefix that bring a value to between 1 and 1000."""
    thousands = math.floor(math.log10(largest) / 3.0) if largest > 0.0 else 0
    thousands = min(max(thousands, min(PREFIXES)), max(PREFIXES))
    return 1000.0**thousands, PREFIXES[thousands]


def short_name(name: str) -> str:
    """Write a frequency for a tick label: 1000 is 1k."""
    value = float(name)
    if value >= 1000.0:
        return f"{value / 1000.0:g}k"
    return name


# ---- records as they are drawn


@dataclass(frozen=True, eq=False)
class Lines:
    """A spectrum from 20 Hz to 20 kHz for a plot; its means and envelope are computed once.

    Parameters
    ----------
    frequency_hz : array (n,), Hz
        Rising frequencies of the lines.
    level_db : array (n,), dB
        Their levels; -inf is silence.
    """

    frequency_hz: Array
    level_db: Array

    @classmethod
    def audible(cls, frequency_hz: Array, level_db: Array) -> Self:
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
        octaves = math.log2(AUDIBLE_HZ[1] / AUDIBLE_HZ[0])
        count = math.ceil(octaves * PER_OCTAVE)
        edges = AUDIBLE_HZ[0] * 2.0 ** (np.arange(count + 1) / PER_OCTAVE)
        part = np.searchsorted(edges, self.frequency_hz, side="right") - 1
        lines = np.bincount(part, minlength=count)
        power = np.bincount(part, weights=10.0 ** (self.level_db / 10.0), minlength=count)
        has_lines = lines > 0
        with np.errstate(divide="ignore"):
            level = 10.0 * np.log10(power[has_lines] / lines[has_lines])
        mid_frequency = np.sqrt(edges[:-1] * edges[1:])
        return mid_frequency[has_lines], np.maximum(level, NOTHING_DB)

    @cached_property
    def envelope(self) -> tuple[Array, Array]:
        """The lines, thinned to the minimum and maximum of each column of the plot."""
        low, high = np.log(AUDIBLE_HZ)
        column = (np.log(self.frequency_hz) - low) / (high - low)
        return _thinned(self.frequency_hz, np.maximum(self.level_db, NOTHING_DB), column)

    @cached_property
    def extremes(self) -> list[float]:
        """Minimum and maximum level to show, dB; empty for a silent spectrum.

        Single low lines of a dense spectrum do not count.
        """
        shown = self.level_db
        if self.dense:
            shown = np.append(self.mean[1], self.level_db.max())
        shown = shown[shown > NOTHING_DB]
        if not len(shown):
            return []
        return [float(shown.min()), float(shown.max())]


def envelope(x: Array, y: Array) -> tuple[Array, Array]:
    """Return a curve over rising x, of which 3,000 points at most are drawn.

    More points are thinned to the minimum and maximum in each of 1,500 columns.
    """
    if len(x) <= 2 * _COLUMNS:
        return x, y
    return _thinned(x, y, (x - x[0]) / (x[-1] - x[0]))


def _thinned(x: Array, y: Array, share: Array) -> tuple[Array, Array]:
    """Replace the points of each column of a plot by its minimum and maximum y at its first x.

    x rises, and `share` (n,), 0 to 1, is the place of each point in the width of the plot.
    """
    column = np.minimum(np.floor(share * _COLUMNS), _COLUMNS - 1)
    starts = np.flatnonzero(np.diff(column, prepend=-1.0))
    minima = np.minimum.reduceat(y, starts)
    maxima = np.maximum.reduceat(y, starts)
    return np.repeat(x[starts], 2), np.column_stack((minima, maxima)).ravel()
