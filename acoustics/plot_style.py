"""The look of curves and axes that all plots share.

The colours by Okabe and Ito (2008) differ for any colour vision. Line styles differ too, for grey
print. More curves than colours go from dark to light in the given order, as do curves whose order
has a meaning.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex

from acoustics._typing import Array
from acoustics.drawn_lines import NOTHING_DB

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
LINE_STYLES: tuple[str | tuple[int, tuple[int, ...]], ...] = (
    "-", "--", "-.", ":", (0, (8, 2)), (0, (4, 1, 1, 1, 1, 1)), (0, (1, 1)),
)  # fmt: skip
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
GREY = "0.6"
# SI prefixes of axes by powers of a thousand
PREFIXES = {-4: "p", -3: "n", -2: "µ", -1: "m", 0: "", 1: "k", 2: "M"}

_SHOWN_DB = 70.0
FEW = 3  # maximum number of curves with distinguishable lines or error bars


def level_limits(levels_db: Iterable[float | None]) -> tuple[float, float]:
    """Return limits of a level axis, at most 70 dB apart.

    The limits are multiples of 5 dB and leave room of at least 2.5 dB. Give all
    curves of several plots together to get a common axis.

    Parameters
    ----------
    levels_db : iterable of float or None, dB. Levels; None and values below -300 do not count.

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


def finish(ax: Axes, ylabel: str) -> Axes:
    """Label the vertical axis and draw a grid behind the curves."""
    ax.set_ylabel(ylabel)
    ax.grid(True, color="0.85", linewidth=0.5)
    ax.set_axisbelow(True)
    return ax


def say_if_silent(ax: Axes, sounds: bool) -> None:
    """Write `no sound` on axes without a level."""
    if not sounds:
        ax.text(
            0.5,
            0.5,
            "no sound",
            transform=ax.transAxes,
            ha="center",
            va="center",
            color="0.4",
            fontsize=14,
        )


def look_of(number: int, count: int, ordered: bool = False) -> dict[str, Any]:
    """Return colour, line style and marker of a curve among `count` curves.

    Colours go from dark to light if the order of the curves has a meaning, or if they are many.
    """
    colour = COLOURS[number % len(COLOURS)]
    if count > len(COLOURS) or (ordered and count >= FEW):
        # Beyond 0.72 the map has a contrast below 2.5 to white paper.
        colour = to_hex(matplotlib.colormaps["plasma"](0.72 * number / (count - 1)))
    return {
        "color": colour,
        "linestyle": _cycled(LINE_STYLES, number),
        "marker": _cycled(MARKERS, number),
    }


def steps(ax: Axes, level_db: Array, edges_hz: Array, few: bool, **look: Any) -> None:
    """Draw bands as steps, or as a line where the steps of many curves would hide one another."""
    if few:
        ax.stairs(level_db, edges_hz, baseline=None, **look)
    else:
        ax.plot(np.sqrt(edges_hz[:-1] * edges_hz[1:]), level_db, **look)


def bars(ax: Axes, x: Array, level_db: Array, uncertainty_db: Array, colour: str) -> None:
    """Draw error bars of the standard uncertainty."""
    ax.errorbar(
        x,
        level_db,
        yerr=uncertainty_db,
        fmt="none",
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
    return f"{value / 1000.0:g}k" if value >= 1000.0 else name


def _cycled(items: Sequence[Any], number: int) -> Any:
    return items[number % len(items)]
