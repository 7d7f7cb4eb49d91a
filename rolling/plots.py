"""Plots of surface and contact. Each draws on the axes it is given and returns them. Depends on matplotlib."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from rolling.simulate import Snapshot

Array = NDArray[np.float64]

SHOWN_M = 1e-3  # of a long track, so that single asperities can be seen


def surface(ax: Axes, heights: Array, spacing: float, title: str) -> Axes:
    """Heights (along, across) [m] as a map in um, the first millimetre of the track at most, colours over all of it."""
    shown = heights[: max(2, round(SHOWN_M / spacing))]
    z, span = shown.T * 1e6, max(float(np.abs(heights).max()) * 1e6, 1e-9)
    extent = (0.0, shown.shape[0] * spacing * 1e6, 0.0, shown.shape[1] * spacing * 1e6)
    image = ax.imshow(z, origin="lower", extent=extent, cmap="cividis", vmin=-span, vmax=span, interpolation="nearest")
    _finish(ax, image, "height [µm]", title)
    return ax


def contact_map(ax: Axes, snapshot: Snapshot, values: Array, spacing: float, label: str, title: str) -> Axes:
    """A map of the window at one position: pressure or deflection in the unit its label names, plate coordinates in um."""
    low = np.array([snapshot.along, snapshot.across]) - spacing / 2
    high = low + np.array(values.shape) * spacing
    extent = (low[0] * 1e6, high[0] * 1e6, low[1] * 1e6, high[1] * 1e6)
    image = ax.imshow(values.T, origin="lower", extent=extent, cmap="magma", interpolation="nearest")
    _finish(ax, image, label, title)
    return ax


def _finish(ax: Axes, image, label: str, title: str) -> None:
    bar = ax.figure.colorbar(image, ax=ax, shrink=0.8)
    bar.set_label(label)
    ax.set_xlabel("along the track [µm]")
    ax.set_ylabel("across [µm]")
    ax.set_title(title)
