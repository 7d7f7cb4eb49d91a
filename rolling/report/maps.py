"""Pressure maps of runs for the page: one picture per run that the page cuts up, with times."""

import base64
import io
import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.colors import to_rgba
from numpy.typing import NDArray
from PIL import Image

from acoustics.arrays import Array
from acoustics.numbers import si
from rolling.contact.track import Motion
from rolling.figures.contact_figures import BELOW_YIELD, YIELDED
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.marches.observers import PressureMap
from rolling.results.run_result import Run

COLOUR_MAP = "magma"  # a perceptually uniform map, black without pressure
FAINTEST = 0.25  # of the colour map, for the lowest pressure: less looks as black as no pressure
REACHED = 0.5  # share of the hardness that pressures reach at least where the colours end at it
LENS_SHARE = 0.04  # of the round lens that the contact fills at least,
LENS_CELLS = 8  # unless so few cells are across it
AT_REST = 2.0  # ratio of force and load up to which a map under the load is shown for a fall
SHADES = 255  # shades of pressure; entry 0 of the palette means no pressure
Pixels = NDArray[np.uint8]
Tile = tuple[int, int, int, int]  # left, top, width and height of a map in its picture [pixels]


class Box(NamedTuple):
    """Left and top of a map from the sphere's centre, across upwards, and side of a cell [um]."""

    left: float
    top: float
    cell: float


# ---- pictures of many maps


def palette(ends_at_hardness: bool = False) -> Pixels:
    """Return colours (1 + SHADES, 3): no pressure first, then from the minimum to the maximum.

    Where they end at the hardness, the last colour is that of nodes that have yielded, which no
    lower pressure is like.
    """
    if not ends_at_hardness:
        shades = matplotlib.colormaps[COLOUR_MAP](np.linspace(FAINTEST, 1, SHADES))
    else:
        shades = matplotlib.colormaps[COLOUR_MAP](np.linspace(FAINTEST, BELOW_YIELD, SHADES))
        shades[-1] = to_rgba(YIELDED)
    return np.vstack([np.zeros(3), np.round(255 * shades[:, :3])]).astype(np.uint8)


def shades(pressure: NDArray[Any], maximum: float) -> Pixels:
    """Return the palette entries of pressures [Pa], linear up to the maximum; 0: no pressure."""
    share = np.clip(np.asarray(pressure, dtype=float) / maximum, 0, 1)
    return np.where(share > 0, 1 + np.round((SHADES - 1) * share), 0).astype(np.uint8)


def upright(pixels: Pixels) -> Pixels:
    """Return a map (along, across) as a picture, in which the track's width goes upwards."""
    return pixels.swapaxes(0, 1)[::-1]


def packed(parts: Sequence[Pixels], colours: Pixels, opacity: bytes | int) -> dict[str, Any]:
    """Arrange pictures (rows, columns) in one PNG that is about square, with their `tiles`."""
    tile_height, tile_width = np.max([part.shape for part in parts], axis=0).tolist()
    columns = max(1, round(math.sqrt(len(parts) * tile_height / tile_width)))
    rows = math.ceil(len(parts) / columns)
    pixels = np.zeros((rows * tile_height, columns * tile_width), np.uint8)
    tiles = list[Tile]()
    for index, part in enumerate(parts):
        row, column = divmod(index, columns)
        top = row * tile_height
        left = column * tile_width
        height, width = part.shape
        pixels[top : top + height, left : left + width] = part
        tiles.append((left, top, width, height))
    return {"png": png(pixels, colours, opacity), "tiles": tiles}


def png(pixels: Pixels, colours: Pixels | None = None, opacity: bytes | int | None = None) -> str:
    """Return a picture as a PNG in a data URI, with a palette and its opacity or empty entry."""
    image = Image.fromarray(pixels)
    if colours is not None:
        image.putpalette(colours.tobytes())
    options = {} if opacity is None else {"transparency": opacity}
    content = io.BytesIO()
    image.save(content, format="png", optimize=True, **options)
    return uri("image/png", content.getvalue())


def uri(kind: str, content: bytes) -> str:
    """Return a file as a data URI."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


# ---- maps of runs


def map_scale(runs: Sequence[Run]) -> dict[str, Any] | None:
    """Return the scales of length and colour that the maps of all runs share; None without maps.

    The keys are half_um (half the side of the square shown), max_gpa (pressure of the last colour),
    hardness (whether that is the hardness), colours below it and `yielded` (of CSS). Colours end at
    the hardness only where pressures come near it; otherwise all of them would be dark.
    """
    mapped = [run for run in runs if run.result.maps]
    if not mapped:
        return None
    maxima = []
    reaches_um = []
    for run in mapped:
        reaches_um.append(1e6 * max(smooth_contact_of(run.scene).semi_axes_m()))
        for shown in sounding_maps(run):
            maxima.append(float(shown.pressure.max()))
            box = _box(shown, run)
            along, across = shown.pressure.shape
            reaches_um += [
                -box.left,
                box.left + along * box.cell,
                box.top,
                across * box.cell - box.top,
            ]
    last_colour = max(maxima)
    hardness = max(run.scene.hardness for run in mapped)
    ends_at_hardness = bool(np.isfinite(hardness)) and last_colour >= REACHED * hardness
    if ends_at_hardness:
        last_colour = hardness
    return {
        "half_um": 1.05 * max(reaches_um),
        "max_gpa": 1e-9 * last_colour,
        "hardness": ends_at_hardness,
        "colours": [css(colour) for colour in palette(ends_at_hardness)[1:-1:2]],
        "yielded": YIELDED,
    }


def css(colour: NDArray[Any]) -> str:
    """Write a colour for a style sheet."""
    red, green, blue = (int(part) for part in colour)
    return f"rgb({red},{green},{blue})"


def run_maps(run: Run, max_gpa: float, ends_at_hardness: bool) -> dict[str, Any] | None:
    """Return the maps of a run with their times [s], places [um] and numbers; None without maps.

    A map is shown from `begins` on, in the `order` of its index. Where `instead` has a sentence, it
    is shown instead: the contact at that time was not computed. A box holds left and top of a map
    from the sphere's centre, across upwards, and the side of a cell [um]. `lens` holds the middle
    from the sphere's centre and the width of a round part that shows the contact [um]. `readings`
    are texts.
    """
    if not run.result.maps:
        return None
    result = run.result
    maps = sounding_maps(run)
    pictures = [upright(shades(shown.pressure, max_gpa * 1e9)) for shown in maps]
    positions = np.array([shown.position for shown in maps])
    begins, order = showing(
        positions * result.step,
        lap=result.solved_steps * result.step,
        rolled=result.steps * result.step,
        closes=run.scene.track.closed,
        motion=run.scene.motion,
    )
    boxes = [_box(shown, run) for shown in maps]
    sheet = packed(pictures, palette(ends_at_hardness), 0)
    sheet["boxes"] = [rounded_box(*box) for box in boxes]
    places_mm = [float(f"{shown.distance * 1e3:.6g}") for shown in maps]
    return {
        "sheets": [sheet],
        "lens": [lens(shown.pressure, box) for shown, box in zip(maps, boxes, strict=True)],
        "begins": np.round(begins, 7).tolist(),
        "order": order.tolist(),
        "instead": _instead(run, begins),
        "hertz_um": [1e6 * axis for axis in smooth_contact_of(run.scene).semi_axes_m()],
        "position_mm": places_mm,
        "readings": {
            "number": [f"map {k + 1} of {len(maps)}" for k in range(len(maps))],
            "position": [f"{place:.4g} mm" for place in places_mm],
            "load": [f"{run.scene.load:g} N"] * len(maps),
            "pressure": _read(1e-9 * result.series["max_pressure"][positions], "GPa"),
            "area": _read(1e12 * result.series["contact_area"][positions], "µm²"),
            "plastic": _read(1e12 * result.series["plastic_area"][positions], "µm²"),
        },
    }


def _read(values: Array, unit: str) -> list[str]:
    """Write values with their unit; - for one that does not exist."""
    return [f"{value:.4g} {unit}" if np.isfinite(value) else "-" for value in values]


def lens(pressure: NDArray[Any], box: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return middle x and y and width [um] of a round part of a map that shows its contact.

    It is the whole map, unless the contact is a thin line or a few points of it. Then it becomes
    smaller about the highest pressure. Widths have steps of the root of 2, so that the scale
    changes rarely from map to map.
    """
    left, top, cell = box
    loaded = np.argwhere(pressure > 0)
    if not len(loaded):
        loaded = np.array([[0, 0], np.array(pressure.shape) - 1])
    low = loaded.min(axis=0)
    high = loaded.max(axis=0)
    rows, columns = high - low + 1
    diagonal = float(np.hypot(rows, columns))
    middle = np.mean([low, high], axis=0)
    width = _stepped(max(diagonal, LENS_CELLS) * cell)
    peak = np.unravel_index(np.argmax(pressure), pressure.shape)
    while width / 2**0.5 >= LENS_CELLS * cell:
        from_middle = loaded - middle
        inside = np.hypot(from_middle[:, 0], from_middle[:, 1]) <= width / cell / 2
        if inside.sum() * cell**2 >= LENS_SHARE * np.pi / 4 * width**2:
            break
        width = width / 2**0.5
        middle = np.array(peak)
    x = left + (middle[0] + 0.5) * cell
    y = top - (pressure.shape[1] - middle[1] - 0.5) * cell
    return round(float(x), 4), round(float(y), 4), round(width, 4)


def _stepped(width: float) -> float:
    """Return the next larger power of the root of 2."""
    half_octaves = math.ceil(2 * math.log2(width))
    return math.pow(2.0, half_octaves / 2)


def _instead(run: Run, begins: Array) -> list[str | None]:
    """Return a sentence for each time in which the ball does not press with about its load.

    Maps belong to the load. The ball flies for most of the time until the next map, or its fall
    ends with a force that the maps do not know.
    """
    if run.vibration_sound is None:
        return [None] * len(begins)
    motion = run.vibration_sound.motion
    load = run.vibration_sound.load
    is_steady = run.scene.keeps_its_load
    ends = np.append(begins[1:], run.sound.duration)
    sentences = list[str | None]()
    for begin, end in zip(begins, ends, strict=True):
        first = round(begin / motion.time_step_s)
        last = max(first + 1, round(end / motion.time_step_s))
        # A settled motion repeats.
        force = motion.force_n[np.arange(first, last) % len(motion.force_n)]
        is_at_rest = force.min() > load / AT_REST and force.max() < AT_REST * load
        if np.mean(force == 0) > 0.5:
            sentences.append("the ball flies: nothing touches")
        elif not is_steady and not is_at_rest:
            sentences.append(
                f"the ball bounces with up to {si(float(force.max()), 'N')}; the contact is"
                f" computed under the load of {si(load, 'N')} alone"
            )
        else:
            sentences.append(None)
    return sentences


def middle_map(run: Run) -> dict[str, Any] | None:
    """Draw the map in the middle of the record as `png`, with the contact `at` its middle [%]."""
    shown = sounding_maps(run)
    if not shown:
        return None
    pressure = shown[len(shown) // 2].pressure
    margin = round(0.2 * max(pressure.shape))
    pixels = np.pad(shades(pressure, float(pressure.max()) or 1.0), margin)
    return {"png": png(upright(pixels), palette()), "at": 50}


def sounding_maps(run: Run) -> list[PressureMap]:
    """Return the maps in the part of the track that the record covers."""
    maps: Mapping[int, PressureMap] = run.result.maps
    return [maps[position] for position in sorted(maps) if position <= run.result.steps]


def _box(shown: PressureMap, run: Run) -> Box:
    """Return the place of a map from the sphere's centre."""
    middle = (run.scene.track.n_across - 1) / 2 * run.scene.spacing
    top = shown.across + shown.pressure.shape[1] * shown.cell - middle
    return Box(
        left=(shown.along - shown.distance) * 1e6,
        top=top * 1e6,
        cell=shown.cell * 1e6,
    )


def rounded_box(left: float, top: float, cell: float) -> Box:
    """Round a box [um] to a ten thousandth."""
    return Box(round(left, 4), round(top, 4), round(cell, 6))


def showing(
    distances: Array, lap: float, rolled: float, closes: bool, motion: Motion
) -> tuple[Array, NDArray[np.int64]]:
    """Return the rising times [s] from which each map is the nearest to the sphere, and its index.

    Parameters
    ----------
    distances : array (maps,), m. Distance rolled from the start to each map, increasing, less than
        a lap.
    lap : float, m. Distance after which the positions repeat.
    rolled : float, m. Whole distance, several laps or a part of one.
    closes : bool. Whether the end of a lap meets its beginning; several laps always do.
    motion : Motion. Distance against time.
    """
    laps = math.ceil(rolled / lap * (1 - 1e-9))
    places = (distances + lap * np.arange(laps)[:, None]).ravel()
    maps = np.tile(np.arange(len(distances)), laps)
    if (closes or laps > 1) and laps * lap <= rolled * (1 + 1e-9):
        # The last lap ends at the first map.
        places = np.append(places, laps * lap + distances[0])
        maps = np.append(maps, 0)
    borders = np.append(0.0, (places[1:] + places[:-1]) / 2)
    inside = borders < rolled
    return np.asarray(motion.time(borders[inside]), dtype=float), maps[inside]
