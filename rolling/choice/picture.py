"""Picture of a choice: what is heard of the candidates by third octave, and their difference."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from acoustics.arrays import Array
from acoustics.bands import MID_HZ
from acoustics.plot_style import COLOURS, band_ticks, curve_style, gridded, level_limits
from rolling.choice.comparison import ChoiceNumbers
from rolling.choice.difference import Difference, level_db
from rolling.choice.words import capital, in_short, mean_bands
from rolling.figures.picture import DPI, WIDTH_IN, Picture, drawable
from rolling.figures.settings import own_settings

HEIGHT_IN = 6.0
FAINT_DB = 30.0  # below the loudest third octave; fainter ones do not decide what is heard
SHOWN_DB = 60.0  # below it; the axes begin with the first third octave that is louder


def draw_spectra(choice: ChoiceNumbers, ax: Axes) -> Axes:
    """Draw what is heard of each candidate by third octave, as means over the specimens."""
    levels = [level_db(mean_bands(contender)) for contender in choice.contenders]
    for number, contender in enumerate(choice.contenders):
        look = curve_style(number, len(choice.contenders))
        ax.plot(MID_HZ, levels[number], label=drawable(contender.label), markersize=3.5, **look)
    ax.set_ylim(*level_limits(level for one in levels for level in one))
    gridded(ax, ylabel="vibration, dB(A)")
    _scale(ax, choice)
    return ax


def draw_difference(choice: ChoiceNumbers, ax: Axes) -> Axes:
    """Draw how much louder each candidate is than the quietest, with ± by third octave.

    Third octaves that are 30 dB below the loudest are left out.
    """
    quietest = choice.contenders[0]
    for number, apart in enumerate(choice.differences, start=1):
        other = choice.contenders[number]
        louder = np.maximum(level_db(mean_bands(quietest)), level_db(mean_bands(other)))
        is_heard = louder > np.nanmax(louder) - FAINT_DB
        _draw_band(ax, apart, is_heard, number, len(choice.contenders))
    ax.axhline(0.0, color="0.3", linewidth=0.8)
    gridded(ax, ylabel=f"louder than {drawable(quietest.label)}, dB", xlabel="third octave, Hz")
    _scale(ax, choice)
    return ax


def _draw_band(ax: Axes, apart: Difference, is_heard: Array, number: int, count: int) -> None:
    """Draw a difference by third octave, and the band of its ±."""
    look: dict[str, Any] = curve_style(number, count)
    shown = np.where(is_heard, apart.band_db, np.nan)
    ax.plot(MID_HZ, shown, markersize=3.5, **look)
    low = shown - apart.band_uncertainty_db
    high = shown + apart.band_uncertainty_db
    ax.fill_between(MID_HZ, low, high, color=look.get("color", COLOURS[1]), alpha=0.2, linewidth=0)


def _scale(ax: Axes, choice: ChoiceNumbers) -> None:
    """Name third octaves along a logarithmic axis, from the first that is not far too faint."""
    levels = np.array([level_db(mean_bands(contender)) for contender in choice.contenders])
    loudest = np.nan_to_num(levels, nan=-np.inf).max(axis=0)
    first = int(np.argmax(loudest > loudest.max() - SHOWN_DB))
    ax.set_xscale("log")
    band_ticks(ax)
    ax.minorticks_off()
    ax.set_xlim(MID_HZ[first] / 1.1, MID_HZ[-1] * 1.1)


@own_settings()
def picture(choice: ChoiceNumbers) -> Picture:
    """Draw spectra and difference above each other."""
    figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), dpi=DPI)
    figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.08)
    FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1, sharex=True)
    draw_spectra(choice, above)
    draw_difference(choice, below)
    above.tick_params(labelbottom=False)
    above.legend(fontsize=8.5, frameon=False)
    title = figure.suptitle(drawable(capital(in_short(choice))), x=0.012, ha="left", fontsize=12)
    left_out = f" ({len(choice.omitted)} left out)" if choice.omitted else ""
    note = (
        f"Means over {choice.pairs} {choice.noun}{left_out} and speeds within 3 %; the band is"
        " ± one standard uncertainty of the pairs"
    )
    above.set_title(note, loc="left", fontsize=8.5, color="0.25")
    for text in (title, above.title):
        text.set_parse_math(False)
    return Picture("choice", figure, None)
