"""Picture of a choice: what is heard of the candidates by third octave, and their difference.

Where what is heard has no third octaves, each specimen is a point above its quantity.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from acoustics.arrays import Array
from acoustics.bands import MID_HZ
from acoustics.plot_style import COLOURS, band_ticks, curve_style, gridded, level_limits
from rolling.choice.choice_numbers import ChoiceNumbers, Contender
from rolling.choice.choice_sentences import capital, in_short
from rolling.choice.difference import Difference
from rolling.choice.heard_specimen import HeardQuantity, levels_of
from rolling.figures.picture import DPI, WIDTH_IN, Picture, drawable, finish
from rolling.figures.picture import picture as captioned_picture
from rolling.figures.settings import own_settings

HEIGHT_IN = 6.0
POINTS_HEIGHT_IN = 4.2
SPREAD = 0.5  # width that the points of all candidates take of the distance between two quantities
FAINT_DB = 30.0  # below the loudest third octave; fainter ones do not decide what is heard
SHOWN_DB = 60.0  # below it; the axes begin with the first third octave that is louder


def draw_spectra(choice: ChoiceNumbers, ax: Axes) -> Axes:
    """Draw what is heard of each candidate by third octave, as means over the specimens."""
    levels = [_band_levels(contender) for contender in choice.contenders]
    for number, contender in enumerate(choice.contenders):
        look = curve_style(number, len(choice.contenders))
        ax.plot(MID_HZ, levels[number], label=drawable(contender.label), markersize=3.5, **look)
    ax.set_ylim(*level_limits(level for bands in levels for level in bands))
    gridded(ax, ylabel="vibration [dB(A)]")
    _scale(ax, choice)
    return ax


def draw_difference(choice: ChoiceNumbers, ax: Axes) -> Axes:
    """Draw how much louder each candidate is than the quietest, with ± by third octave.

    Third octaves that are 30 dB below the loudest are left out.
    """
    quietest = choice.contenders[0]
    for number, difference in enumerate(choice.differences, start=1):
        other = choice.contenders[number]
        louder = np.maximum(_band_levels(quietest), _band_levels(other))
        is_heard = louder > np.nanmax(louder) - FAINT_DB
        _draw_band(ax, difference, other.label, is_heard, number, len(choice.contenders))
    ax.axhline(0.0, color="0.3", linewidth=0.8)
    gridded(ax, ylabel=f"louder than {drawable(quietest.label)} [dB]", xlabel="frequency [Hz]")
    _scale(ax, choice)
    return ax


def _band_levels(contender: Contender) -> Array:
    """Return the mean levels of a contender by third octave, (31,) [dB(A)]."""
    squares = contender.third_octaves
    assert squares is not None  # otherwise points are drawn
    return levels_of(squares)


def _draw_band(
    ax: Axes, difference: Difference, name: str, is_heard: Array, number: int, count: int
) -> None:
    """Draw a difference by third octave, and the band of its ±."""
    look: dict[str, Any] = curve_style(number, count)
    assert difference.band_db is not None and difference.band_uncertainty_db is not None
    shown = np.where(is_heard, difference.band_db, np.nan)
    label = drawable(name)
    ax.plot(MID_HZ, shown, markersize=3.5, label=label, **look)
    low = shown - difference.band_uncertainty_db
    high = shown + difference.band_uncertainty_db
    ax.fill_between(MID_HZ, low, high, color=look.get("color", COLOURS[1]), alpha=0.2, linewidth=0)


def _scale(ax: Axes, choice: ChoiceNumbers) -> None:
    """Name third octaves along a logarithmic axis, from the first that is not far too faint."""
    levels = np.array([_band_levels(contender) for contender in choice.contenders])
    loudest = np.nan_to_num(levels, nan=-np.inf).max(axis=0)
    first = int(np.argmax(loudest > loudest.max() - SHOWN_DB))
    ax.set_xscale("log")
    band_ticks(ax)
    ax.minorticks_off()
    ax.set_xlim(MID_HZ[first] / 1.1, MID_HZ[-1] * 1.1)


def draw(choice: ChoiceNumbers, ax: Axes) -> Axes:
    """Draw how much louder each candidate is by third octave, or a point for each specimen."""
    if choice.contenders[0].third_octaves is not None:
        return draw_difference(choice, ax)
    return draw_points(choice, ax)


def draw_points(choice: ChoiceNumbers, ax: Axes) -> Axes:
    """Draw each specimen as a point by quantity, and the means over specimens as lines.

    Quantities of another unit than the leading one are left out.
    """
    unit = choice.leading.unit
    shown = [quantity for quantity in choice.quantities if quantity.unit == unit]
    count = len(choice.contenders)
    for number, contender in enumerate(choice.contenders):
        look = curve_style(number, count)
        shift = SPREAD * ((number + 0.5) / count - 0.5)
        half = 0.4 * SPREAD / count
        for place, quantity in enumerate(shown):
            values = _points(contender, quantity)
            middle = place + shift
            ax.plot(
                np.full(len(values), middle),
                values,
                linestyle="none",
                marker="o",
                markersize=4,
                alpha=0.6,
                color=look["color"],
                label=drawable(contender.label) if place == 0 else None,
            )
            mean = contender.mean_in(quantity)
            if mean is not None and len(values):
                ax.plot([middle - half, middle + half], [mean, mean], color=look["color"], lw=2)
    if not choice.leading.is_level:
        ax.set_yscale("log")
    ax.set_xticks(range(len(shown)), [quantity.words for quantity in shown])
    ax.set_xlim(-0.5, len(shown) - 0.5)
    kind = "" if choice.leading.is_level else " rms"
    shown_unit = unit.replace("um/", "µm/")
    gridded(ax, ylabel=f"{choice.leading.drawn or choice.leading.words}{kind} [{shown_unit}]")
    return ax


def _points(contender: Contender, quantity: HeardQuantity) -> Array:
    """Return the values of the specimens that are not silent, in the unit of the quantity."""
    if quantity.is_level:
        levels = contender.levels_in(quantity.name)
        return levels[np.isfinite(levels)]
    values = contender.rms_in(quantity.name)
    return values[values > 0]


def pictures(choice: ChoiceNumbers) -> list[Picture]:
    """Return the pictures of the page: difference and levels by third octave, or all specimens."""
    note = f"Means over {_specimens(choice)} and speeds within 3 %"
    quietest = choice.contenders[0].label
    if choice.contenders[0].third_octaves is None:
        note = f"{_specimens(choice)} of each candidate; the lines are their means"
        return [_captioned("specimens", partial(draw_points, choice), "All specimens", note)]
    title = f"How much louder than {quietest}, by third octave"
    spread = f"{note}; the band is ± one standard uncertainty of the pairs"
    return [
        _captioned("difference", partial(draw_difference, choice), title, spread),
        _captioned("third_octaves", partial(draw_spectra, choice), "Third octaves", note),
    ]


def _captioned(name: str, draw: Callable[..., Axes], title: str, note: str) -> Picture:
    """Draw axes as a picture of their own with title and note."""

    def drawn(ax: Axes) -> Axes:
        """Draw, and give the title."""
        return finish(draw(ax=ax), title, [note])

    return captioned_picture(name, drawn)


@own_settings()
def picture(choice: ChoiceNumbers) -> Picture:
    """Draw the picture of a choice with its legend and answer."""
    if choice.contenders[0].third_octaves is None:
        return _picture_of_points(choice)
    figure = _figure(HEIGHT_IN)
    above, below = figure.subplots(2, 1, sharex=True)
    draw_spectra(choice, above)
    draw_difference(choice, below)
    above.tick_params(labelbottom=False)
    above.legend(fontsize=8.5, frameon=False)
    title = figure.suptitle(drawable(capital(in_short(choice))), x=0.012, ha="left", fontsize=12)
    title.set_parse_math(False)
    _note(
        above,
        f"Means over {_specimens(choice)} and speeds within 3 %; the band is ± one standard"
        " uncertainty of the pairs",
    )
    return Picture("choice", figure, None)


def _picture_of_points(choice: ChoiceNumbers) -> Picture:
    """Draw the specimens of each candidate as points."""
    figure = _figure(POINTS_HEIGHT_IN)
    ax = figure.subplots()
    draw_points(choice, ax)
    ax.legend(fontsize=8.5, frameon=False)
    _note(ax, f"{_specimens(choice)} of each candidate; the lines are their means")
    return Picture("choice", figure, None)


def _figure(height_in: float) -> Figure:
    """Return an empty figure."""
    figure = Figure(figsize=(WIDTH_IN, height_in), dpi=DPI)
    figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.08)
    FigureCanvasAgg(figure)
    return figure


def _note(ax: Axes, text: str) -> None:
    """Write a line above axes."""
    ax.set_title(text, loc="left", fontsize=8.5, color="0.25").set_parse_math(False)


def _specimens(choice: ChoiceNumbers) -> str:
    """Say on how many specimens candidates were heard."""
    left_out = f" ({len(choice.omitted)} left out)" if choice.omitted else ""
    return f"{choice.pairs} {choice.noun}{left_out}"
