"""Plots of surface, contact and recovery events on given axes.

Each function draws on `ax` and returns it. Maps take a second pair of axes for the colour bar. If
it is None, the bar takes its room from `ax`.
"""

from __future__ import annotations

import math

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap

from acoustics.plots import COLOURS
from rolling._typing import Array
from rolling.simulation.simulate import Snapshot

SHOWN_M = 0.8e-3  # length of a track that a map shows, so that single asperities can be seen
_MOST_DOTS = 110_000  # points of a map of heights, which fit into a file of 150 kB
_SHADES = 24  # colours of such a map: more shades make larger files and are hardly distinguishable


def surface(ax: Axes, bar: Axes | None, heights: Array, spacing: float) -> Axes:
    """Draw the heights at the beginning of a track as a map in µm.

    Parameters
    ----------
    ax : axes to draw on.
    bar : axes of the colour bar, or None.
    heights : array (along, across), m. The whole track sets the range of the colours.
    spacing : float, m. Distance of the nodes.
    """
    every = map_stride(heights, spacing)
    shown = heights[: shown_nodes(heights, spacing) : every, ::every]
    # the rounding of a smooth surface stays invisible
    span = max(float(np.abs(heights).max()) * 1e6, 1e-3)
    along, across = (
        np.array([0, nodes]) * every * spacing * 1e6 - spacing / 2 * 1e6 for nodes in shown.shape
    )
    colours = matplotlib.colormaps["cividis"].resampled(_SHADES)
    return _map(ax, bar, shown * 1e6, (*along, *across), colours, (-span, span), "height [µm]")


def shown_nodes(heights: Array, spacing: float) -> int:
    """Return the number of nodes along the track that a map shows."""
    return min(len(heights), max(2, round(SHOWN_M / spacing)))


def map_stride(heights: Array, spacing: float) -> int:
    """Return the distance of the nodes that a map shows, in nodes: 1 unless it is too large."""
    return math.ceil(math.sqrt(shown_nodes(heights, spacing) * heights.shape[1] / _MOST_DOTS))


def profile(ax: Axes, along_um: Array, height_um: Array) -> Axes:
    """Draw a profile: heights (n,) [µm] along a line [µm]."""
    ax.plot(along_um, height_um, color="black", linewidth=0.9)
    ax.axhline(0.0, color="0.5", linewidth=0.6)
    ax.set_xlabel("along the track [µm]")
    ax.set_ylabel("height [µm]")
    return _with_grid(ax)


def contact_map(
    ax: Axes,
    bar: Axes | None,
    snapshot: Snapshot,
    values: Array,
    spacing: float,
    limits: tuple[float, float],
    label: str,
) -> Axes:
    """Draw pressure or deflection in the window of a snapshot as a map.

    Parameters
    ----------
    ax : axes to draw on, in plate coordinates [µm].
    bar : axes of the colour bar, or None.
    snapshot : position of the window.
    values : array (along, across). Pressure or deflection, in the unit that the label names.
    spacing : float, m. Distance of the nodes.
    limits : pair of float. Values of the first and the last colour.
    label : str. Quantity and unit, written at the colour bar.
    """
    low = np.array([snapshot.along, snapshot.across]) - spacing / 2
    high = low + np.array(values.shape) * spacing
    extent = (low[0] * 1e6, high[0] * 1e6, low[1] * 1e6, high[1] * 1e6)
    return _map(ax, bar, values, extent, matplotlib.colormaps["magma"], limits, label)


def shares(ax: Axes, edges: Array, events: Array, release: Array, xlabel: str) -> Axes:
    """Draw a distribution of recovery events over their energy or duration.

    Parameters
    ----------
    ax : axes to draw on.
    edges : array (n + 1,). Edges of the bins.
    events, release : arrays (n,). Shares of the events and of the released energy in each bin, 0 to
        1.
    xlabel : str. Quantity and unit of the edges.
    """
    for values, label, colour, style in (
        (events, "share of the events", COLOURS[0], "-"),
        (release, "share of the release", COLOURS[1], "--"),
    ):
        ax.stairs(100 * values, edges, color=colour, linestyle=style, linewidth=1.5, label=label)
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel(xlabel)
    ax.set_ylabel("share [%]")
    return _with_grid(ax)


def _with_grid(ax: Axes) -> Axes:
    """Draw a pale grid below the curves."""
    ax.grid(True, color="0.85", linewidth=0.5)
    ax.set_axisbelow(True)
    return ax


def _map(
    ax: Axes,
    bar: Axes | None,
    values: Array,
    extent: tuple[float, float, float, float],
    colours: Colormap,
    limits: tuple[float, float],
    label: str,
) -> Axes:
    low, high = limits
    image = ax.imshow(
        values.T,
        origin="lower",
        extent=extent,
        cmap=colours,
        vmin=low,
        vmax=high,
        interpolation="none",
    )
    ax.figure.colorbar(image, cax=bar, ax=None if bar else ax, label=label)
    ax.set_xlabel("along the track [µm]")
    ax.set_ylabel("across [µm]")
    return ax
