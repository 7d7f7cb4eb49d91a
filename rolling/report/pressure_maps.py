"""Pressure maps of a run as one picture to be cut up by a page, and when each is to be seen. Depends on Pillow and simulate."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from rolling.scene.motion import Motion
from rolling.simulation.simulate import PressureMap

Array = NDArray[np.float64]

COLOUR_MAP = "magma"  # perceptually uniform, and black where nothing presses
SHADES = 255  # of pressure; entry 0 of the palette is no pressure at all


@dataclass(frozen=True)
class Sheet:
    """Maps side by side in one PNG with a palette, the track to the right, across upwards.

    tiles : per map left, top, width and height in the PNG [pixels], a pixel being a cell.
    boxes : per map left and top from the sphere's centre [um], across upwards, and the side of a cell [um].
    """

    png: bytes
    tiles: list[tuple[int, int, int, int]]
    boxes: list[tuple[float, float, float]]


def palette() -> NDArray[np.uint8]:
    """Colours (1 + SHADES, 3): of no pressure, then from the least to the greatest."""
    colours = matplotlib.colormaps[COLOUR_MAP](np.linspace(0, 1, SHADES))[:, :3]
    return np.vstack([np.zeros(3), np.round(255 * colours)]).astype(np.uint8)


def shades(pressure: NDArray[np.float32], greatest: float) -> NDArray[np.uint8]:
    """Palette entries of pressures [Pa]: 0 where there is none, else 1 to SHADES, linear up to the greatest."""
    share = np.clip(np.asarray(pressure, dtype=float) / greatest, 0, 1)
    return np.where(share > 0, 1 + np.round((SHADES - 1) * share), 0).astype(np.uint8)


def sheet(maps: Sequence[PressureMap], middle: float, greatest: float) -> Sheet:
    """The maps of a run about the sphere's centre.

    Parameters
    ----------
    maps : at least one.
    middle : where across the plate the sphere runs [m].
    greatest : pressure of the last colour [Pa].
    """
    width, height = (max(one.pressure.shape[axis] for one in maps) for axis in (0, 1))
    columns = math.ceil(math.sqrt(len(maps) * height / width))
    rows = math.ceil(len(maps) / columns)
    pixels = np.zeros((rows * height, columns * width), dtype=np.uint8)
    tiles, boxes = [], []
    for number, one in enumerate(maps):
        along, across = one.pressure.shape
        top, left = (number // columns) * height, (number % columns) * width
        # Rows of a picture go down, the plate's second axis goes up.
        pixels[top : top + across, left : left + along] = shades(one.pressure, greatest).T[::-1]
        tiles.append((left, top, along, across))
        edges = one.along - one.distance, one.across + across * one.cell - middle
        boxes.append((edges[0] * 1e6, edges[1] * 1e6, one.cell * 1e6))
    return Sheet(_png(pixels), tiles, boxes)


def half_width(sheets: Sequence[Sheet], radii_um: Sequence[float]) -> float:
    """Half the side [um] of a square about the sphere's centre that holds all maps and circles of those radii."""
    reach = list(radii_um)
    for one in sheets:
        for (left, top, cell), (_, _, along, across) in zip(one.boxes, one.tiles, strict=True):
            reach += [-left, left + along * cell, top, across * cell - top]
    return 1.05 * max(reach)


def showing(
    distances: Array, lap: float, rolled: float, closes: bool, motion: Motion
) -> tuple[Array, NDArray[np.int64]]:
    """From which time on [s] which map is the nearest to the sphere; in order of time, the first from 0.

    Parameters
    ----------
    distances : (maps,) rolled from the start to each map [m], increasing, less than a lap.
    lap : after which the positions repeat [m].
    rolled : all the way [m], several laps or a part of one.
    closes : the end of a lap is its beginning, as it is whenever there are several.
    """
    laps = math.ceil(rolled / lap * (1 - 1e-9))
    places = (distances + lap * np.arange(laps)[:, None]).ravel()
    maps = np.tile(np.arange(len(distances)), laps)
    if (closes or laps > 1) and laps * lap <= rolled * (1 + 1e-9):  # back at the first map in the end
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
