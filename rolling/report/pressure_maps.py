"""Pressure maps of a run in a single picture that the page cuts up, with the time of each map."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from rolling._typing import Array
from rolling.scene.motion import Motion
from rolling.simulation.simulate import PressureMap

COLOUR_MAP = "magma"  # a perceptually uniform map, black without pressure
SHADES = 255  # shades of pressure; entry 0 of the palette means no pressure


@dataclass(frozen=True)
class Sheet:
    """Maps side by side in a PNG with a palette; the track runs to the right.

    Parameters
    ----------
    png : bytes. The picture.
    tiles : list. Left, top, width and height of each map in the PNG [pixels]; a pixel is a cell.
    boxes : list. Left and top of each map from the sphere's centre, across upwards, and side of a
        cell [um].
    """

    png: bytes
    tiles: list[tuple[int, int, int, int]]
    boxes: list[tuple[float, float, float]]


def palette() -> NDArray[np.uint8]:
    """Return colours (1 + SHADES, 3): no pressure first, then from the minimum to the maximum."""
    colours = matplotlib.colormaps[COLOUR_MAP](np.linspace(0, 1, SHADES))[:, :3]
    return np.vstack([np.zeros(3), np.round(255 * colours)]).astype(np.uint8)


def shades(pressure: NDArray[np.float32], maximum: float) -> NDArray[np.uint8]:
    """Return the palette entries of pressures [Pa].

    Entry 0 means no pressure. The entries 1 to SHADES are linear up to the maximum.
    """
    share = np.clip(np.asarray(pressure, dtype=float) / maximum, 0, 1)
    return np.where(share > 0, 1 + np.round((SHADES - 1) * share), 0).astype(np.uint8)


def sheet(maps: Sequence[PressureMap], middle: float, maximum: float) -> Sheet:
    """Arrange the maps of a run about the sphere's centre in one picture.

    Parameters
    ----------
    maps : sequence of maps, not empty.
    middle : float, m. Position of the sphere across the plate.
    maximum : float, Pa. Pressure of the last colour.
    """
    width, height = (max(each.pressure.shape[axis] for each in maps) for axis in (0, 1))
    columns = math.ceil(math.sqrt(len(maps) * height / width))
    rows = math.ceil(len(maps) / columns)
    pixels = np.zeros((rows * height, columns * width), dtype=np.uint8)
    tiles, boxes = [], []
    for index, each in enumerate(maps):
        along, across = each.pressure.shape
        top, left = (index // columns) * height, (index % columns) * width
        # Rows of a picture go down, the plate's second axis goes up.
        pixels[top : top + across, left : left + along] = shades(each.pressure, maximum).T[::-1]
        tiles.append((left, top, along, across))
        edges = each.along - each.distance, each.across + across * each.cell - middle
        boxes.append((edges[0] * 1e6, edges[1] * 1e6, each.cell * 1e6))
    return Sheet(_png(pixels), tiles, boxes)


def half_width(sheets: Sequence[Sheet], radii_um: Sequence[float]) -> float:
    """Return half the side [um] of a centred square that holds all maps and circles."""
    reach = list(radii_um)
    for sheet in sheets:
        for (left, top, cell), (_, _, along, across) in zip(sheet.boxes, sheet.tiles, strict=True):
            reach += [-left, left + along * cell, top, across * cell - top]
    return 1.05 * max(reach)


def showing(
    distances: Array, lap: float, rolled: float, closes: bool, motion: Motion
) -> tuple[Array, NDArray[np.int64]]:
    """Return the times from which each map is the nearest to the sphere, with the maps in order.

    Parameters
    ----------
    distances : array (maps,), m. Distance rolled from the start to each map, increasing, less than
        a lap.
    lap : float, m. Distance after which the positions repeat.
    rolled : float, m. Whole distance, several laps or a part of one.
    closes : bool. Whether the end of a lap meets its beginning; several laps always do.
    motion : Motion. Distance against time.

    Returns
    -------
    times : array (n,), s
        Rising times, the first 0.
    order : array (n,) of int
        Index of the map shown from each time on.
    """
    laps = math.ceil(rolled / lap * (1 - 1e-9))
    places = (distances + lap * np.arange(laps)[:, None]).ravel()
    maps = np.tile(np.arange(len(distances)), laps)
    # the lap ends at the first map
    if (closes or laps > 1) and laps * lap <= rolled * (1 + 1e-9):
        places, maps = np.append(places, laps * lap + distances[0]), np.append(maps, 0)
    borders = np.append(0.0, (places[1:] + places[:-1]) / 2)
    inside = borders < rolled
    return np.asarray(motion.time(borders[inside]), dtype=float), maps[inside]


def _png(pixels: NDArray[np.uint8]) -> bytes:
    image = Image.fromarray(pixels)
    image.putpalette(palette().tobytes())
    content = io.BytesIO()
    image.save(content, format="png", optimize=True, transparency=0)
    return content.getvalue()
