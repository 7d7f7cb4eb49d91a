"""Picture of a choice between bearings: velocity in the three bands, a point a specimen."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from acoustics.plot_style import curve_style, gridded
from rolling.bearing_run.band_difference import HOUSING, NAMES
from rolling.figures.picture import DPI, WIDTH_IN, Picture, drawable
from rolling.figures.settings import own_settings

if TYPE_CHECKING:
    from rolling.bearing_run.bearing_choice import BearingChoice

HEIGHT_IN = 4.2
SPREAD = 0.5  # width that the points of all bearings take of the distance between two bands


def draw_choice(choice: BearingChoice, ax: Axes) -> Axes:
    """Draw the radial velocity of each bearing by band: specimens as points, means as lines."""
    bands = [band for band in choice.rms if band != HOUSING]
    count = len(choice.labels)
    for number, label in enumerate(choice.labels):
        look = curve_style(number, count)
        shift = SPREAD * ((number + 0.5) / count - 0.5)
        for place, band in enumerate(bands):
            values = choice.rms[band][number]
            moving = values[values > 0]
            middle = place + shift
            ax.plot(
                np.full(len(moving), middle),
                moving,
                linestyle="none",
                marker="o",
                markersize=4,
                alpha=0.6,
                color=look["color"],
                label=drawable(label) if place == 0 else None,
            )
            if len(moving):
                mean = float(np.sqrt(np.mean(np.square(moving))))
                half = 0.4 * SPREAD / count
                ax.plot([middle - half, middle + half], [mean, mean], color=look["color"], lw=2)
    ax.set_yscale("log")
    ax.set_xticks(range(len(bands)), [NAMES[band] for band in bands])
    ax.set_xlim(-0.5, len(bands) - 0.5)
    gridded(ax, ylabel="radial velocity of the ring, um/s rms")
    return ax


@own_settings()
def choice_picture(choice: BearingChoice) -> Picture:
    """Draw the picture of a choice with its legend and answer."""
    figure = Figure(figsize=(WIDTH_IN, HEIGHT_IN), dpi=DPI)
    figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.08)
    FigureCanvasAgg(figure)
    ax = figure.subplots()
    draw_choice(choice, ax)
    ax.legend(fontsize=8.5, frameon=False)
    note = f"{choice.pairs} specimens of each bearing; the lines are their root mean squares"
    ax.set_title(note, loc="left", fontsize=8.5, color="0.25").set_parse_math(False)
    return Picture("choice", figure, None)
