"""Plots of surface, contact and recovery events. Each draws on the axes it is given and returns them. Depends on matplotlib."""

from __future__ import annotations

import math

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap
from numpy.typing import NDArray

from acoustics.plots import COLOURS
from rolling.simulation.simulate import Snapshot

Array = NDArray[np.float64]

SHOWN_M = 0.8e-3  # of a long track, so that single asperities can be seen
_MOST_DOTS = 110_000  # of a map of heights: what a file of 150 kB holds
_SHADES = 24  # of such a map: more make larger files and are hardly told apart


def surface(ax: Axes, bar: Axes, heights: Array, spacing: float) -> Axes:
    """Heights (along, across) [m] as a map in µm: the beginning of the track, colours over all of it."""
    every = map_stride(heights, spacing)
    shown = heights[: shown_nodes(heights, spacing) : every, ::every]
    span = max(float(np.abs(heights).max()) * 1e6, 1e-3)  # not the rounding of a smooth one
    along, across = (np.array([0, nodes]) * every * spacing * 1e6 - spacing / 2 * 1e6 for nodes in shown.shape)
    colours = matplotlib.colormaps["cividis"].resampled(_SHADES)
    return _map(ax, bar, shown * 1e6, (*along, *across), colours, (-span, span), "height [µm]")


def shown_nodes(heights: Array, spacing: float) -> int:
    """Nodes along the track that are shown of a surface."""
    return min(len(heights), max(2, round(SHOWN_M / spacing)))


def map_stride(heights: Array, spacing: float) -> int:
    """Every how many nodes a dot of the map stands for: 1 unless there are too many."""
    return math.ceil(math.sqrt(shown_nodes(heights, spacing) * heights.shape[1] / _MOST_DOTS))


def profile(ax: Axes, along_um: Array, height_um: Array) -> Axes:
    """Heights [µm] along a line."""
    ax.plot(along_um, height_um, color="black", linewidth=0.9)
    ax.axhline(0.0, color="0.5", linewidth=0.6)
    ax.set_xlabel("along the track [µm]")
    ax.set_ylabel("height [µm]")
    ax.grid(True, color="0.85", linewidth=0.5)
    ax.set_axisbelow(True)
    return ax


def contact_map(
    ax: Axes, bar: Axes, snapshot: Snapshot, values: Array, spacing: float, limits: tuple[float, float], label: str
) -> Axes:
    """A map of the window at one position: pressure or deflection in the unit its label names, plate coordinates in µm."""
    low = np.array([snapshot.along, snapshot.across]) - spacing / 2
    high = low + np.array(values.shape) * spacing
    extent = (low[0] * 1e6, high[0] * 1e6, low[1] * 1e6, high[1] * 1e6)
    return _map(ax, bar, values, extent, matplotlib.colormaps["magma"], limits, label)


def shares(ax: Axes, edges: Array, events: Array, release: Array, xlabel: str) -> Axes:
    """Shares (n,) of the events and of their release that fall between edges (n + 1,) of their energy or duration."""
    for values, label, colour, style in (
        (events, "share of the events", COLOURS[0], "-"),
        (release, "share of the release", COLOURS[1], "--"),
    ):
        ax.stairs(100 * values, edges, color=colour, linestyle=style, linewidth=1.5, label=label)
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel(xlabel)
    ax.set_ylabel("share [%]")
    ax.grid(True, color="0.85", linewidth=0.5)
    ax.set_axisbelow(True)
    return ax


def _map(
    ax: Axes,
    bar: Axes,
    values: Array,
    extent: tuple[float, float, float, float],
    colours: Colormap,
    limits: tuple[float, float],
    label: str,
) -> Axes:
    low, high = limits
    image = ax.imshow(values.T, origin="lower", extent=extent, cmap=colours, vmin=low, vmax=high, interpolation="none")
    ax.figure.colorbar(image, cax=bar, label=label)
    ax.set_xlabel("along the track [µm]")
    ax.set_ylabel("across [µm]")
    return ax
