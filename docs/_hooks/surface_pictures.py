"""Pictures of surfaces: three that are made, and a scan before and after its preparation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
from drawn_pictures import Drawn, new_figure
from matplotlib.axes import Axes

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.in_si import scene_surface
from rolling.scene import height_grid

SHOWN_UM = 200.0  # of a made surface, along and across
SHADES = 48  # of a map of heights, so that its image is small


def made(scenes: Mapping[str, Any]) -> Drawn:
    """Draw made surfaces of equal roughness beside each other, with one scale."""
    figure = new_figure(3.0)
    axes = figure.subplots(1, len(scenes), sharey=True)
    numbers = {}
    parts = {}
    for label, scene in scenes.items():
        surface = scene_surface.scene_surface(scene)
        numbers[f"{label} slope"] = f"{rounded(surface.statistics.rms_slope, 2)}"
        numbers[f"{label} skewness"] = f"{surface.statistics.skewness:.1f}"
        numbers["ra"] = f"{rounded(1e6 * surface.statistics.ra, 2)} µm"
        count = round(SHOWN_UM * 1e-6 / scene.spacing)
        parts[label] = 1e6 * surface.heights[:count, :count]
    limit = max(float(np.quantile(np.abs(part), 0.995)) for part in parts.values())
    for ax, (label, part) in zip(axes, parts.items(), strict=True):
        image = _map(ax, part, SHOWN_UM, SHOWN_UM, limit)
        ax.set_title(label, fontsize="medium")
        ax.set_xlabel("along [µm]")
    axes[0].set_ylabel("across [µm]")
    figure.colorbar(image, ax=axes, label="height [µm]", location="bottom", shrink=0.6)
    return Drawn(figure, numbers)


def scan(scenes: Mapping[str, Any]) -> Drawn:
    """Draw a scan as the instrument measured it, and as it lies under the ball."""
    scene = scenes["scan"]
    raw = height_grid.read(scene.height_path)
    prepared = scene_surface.scene_surface(scene)
    along_um, across_um = (1e6 * np.array(raw.spacing_m) * raw.heights.shape).tolist()
    centred = 1e6 * (raw.heights - np.nanmean(raw.heights))
    figure = new_figure(4.0)
    above, below = figure.subplots(2, 1)
    used = 1e6 * prepared.heights
    size = (1e6 * prepared.spacing * np.array(used.shape)).tolist()
    for ax, heights, sides in ((above, centred, (along_um, across_um)), (below, used, size)):
        limit = float(np.nanquantile(np.abs(heights), 0.995))
        image = _map(ax, heights, *sides, limit)
        figure.colorbar(image, ax=ax, label="height [µm]")
        ax.set_ylabel("across [µm]")
    above.set_title("as measured", fontsize="medium", loc="left")
    below.set_title("under the ball", fontsize="medium", loc="left")
    below.set_xlabel("along the track [µm]")
    numbers = {
        "gaps": f"{int(np.isnan(raw.heights).sum()):,}",
        "points": f"{raw.heights.size:,}",
        "measured ra": f"{rounded(float(np.nanmean(np.abs(centred))), 2)} µm",
        "used ra": f"{rounded(1e6 * prepared.statistics.ra, 2)} µm",
    }
    return Drawn(figure, numbers)


def _map(ax: Axes, heights_um: Array, along_um: float, across_um: float, limit: float) -> Any:
    """Draw heights (along, across) [µm] as a map about their mean."""
    colours = matplotlib.colormaps["cividis"].resampled(SHADES).with_extremes(bad="#bb3355")
    return ax.imshow(
        heights_um.T,
        cmap=colours,
        origin="lower",
        extent=(0.0, along_um, 0.0, across_um),
        interpolation="none",
        aspect="auto" if along_um != across_um else "equal",
        vmin=-limit,
        vmax=limit,
    )
