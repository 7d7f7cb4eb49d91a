"""Slow motions of runs for the page: pictures that the page cuts up, with times and powers."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from rolling.contact import closed_forms
from rolling.report import pressure_maps
from rolling.report.film_motion import FilmMotion, motion_between
from rolling.simulation.run_result import RunResult
from rolling.simulation.slow_motion import SlowMotion
from rolling.surface.scene_surface import scene_surface

GLOW = (0, 225, 255)  # colour of cells that release energy
BRIGHTEST = 0.999  # share of the releases that are less than fully lit
DIMMED, VEIL = 0.7, 225  # brightness of pressures, and their opacity above the surface, of 255
SPREAD = 4.0  # standard deviations of the heights from grey to black and to white


@dataclass(frozen=True)
class Sheet:
    """Parts of maps side by side in a PNG.

    png : bytes. The picture.
    tiles : list. Left, top, width and height of each part in the PNG [pixels]; a pixel is a cell.
    places : list. Left and top of each part in its map [cells], the second axis downwards.
    """

    png: bytes
    tiles: list[tuple[int, int, int, int]]
    places: list[tuple[int, int]]


@dataclass(frozen=True)
class Film:
    """The slow motion of a run as the page shows it.

    ground : bytes. PNG of the surface, white is high.
    pressure, release : Sheet. Maps of pressure, and of the energy released since the map before.
    size : (int, int). Cells of a map along and across.
    most_cells : int. Maximum number of cells that bear pressure in a map.
    cell_um, hertz_um : float, um. Side of a cell; contact radius of the smooth elastic contact.
    centres : list of (float, float), cells. Centre of the sphere in each map.
    times : list of float, s. Time of each map in the record.
    power_uw : list of float, uW. Mean release power since the map before; zero for the first map.
    motion : FilmMotion or None. Motion of the ball meanwhile; None without dynamics.
    """

    ground: bytes
    pressure: Sheet
    release: Sheet
    size: tuple[int, int]
    most_cells: int
    cell_um: float
    hertz_um: float
    centres: list[tuple[float, float]]
    times: list[float]
    power_uw: list[float]
    motion: FilmMotion | None


def film_of(run: RunResult, max_gpa: float) -> Film | None:
    """Make the film of a run, or return None for a run without a slow motion.

    Parameters
    ----------
    run : RunResult.
    max_gpa : float, GPa. Pressure of the last colour.
    """
    slow = run.result.slow_motion
    if slow is None or not slow.pressure.size:
        return None
    positions = slow.positions
    times = run.position_time[positions]
    energy = np.concatenate([[0.0], np.cumsum(run.result.series["release_energy"])])[positions]
    power = np.concatenate([[0.0], np.diff(energy) / np.diff(times)])
    pressures = slow.pressure * slow.pressure_unit
    radius = closed_forms.hertz_radius(run.scene.load, run.scene.radius, run.scene.contact_modulus)
    return Film(
        ground=_ground(run, slow),
        pressure=_sheet(pressure_maps.shades(pressures, max_gpa * 1e9), _pressure_palette()),
        release=_sheet(glow(slow.release), _glow_palette()),
        size=(slow.pressure.shape[1], slow.pressure.shape[2]),
        most_cells=int(np.count_nonzero(slow.pressure, axis=(1, 2)).max()),
        cell_um=slow.cell * 1e6,
        hertz_um=radius * 1e6,
        centres=_centres(run, slow),
        times=np.round(times, 8).tolist(),
        power_uw=[float(f"{value:.4g}") for value in power * 1e6],
        motion=motion_between(run, float(times[0]), float(times[-1])),
    )


def glow(release: NDArray[np.uint16]) -> NDArray[np.uint8]:
    """Return the opacity of cells that release energy, linear up to nearly the maximum."""
    lit = release[release > 0]
    most = float(np.quantile(lit, BRIGHTEST)) if lit.size else 1.0
    return np.asarray(np.rint(255 * np.minimum(release / most, 1.0)), dtype=np.uint8)


def _centres(run: RunResult, slow: SlowMotion) -> list[tuple[float, float]]:
    """Return the centre of the sphere in each map [cells]."""
    along = run.result.start + slow.positions * run.result.step
    middle = (run.scene.track.n_across - 1) / 2 * run.scene.spacing
    down = slow.pressure.shape[2] - (middle - slow.across) / slow.cell
    return [(round(float(x), 3), round(down, 3)) for x in (along - slow.along) / slow.cell]


def _ground(run: RunResult, slow: SlowMotion) -> bytes:
    """Draw the heights of the part of the plate that the slow motion shows."""
    heights, spacing = scene_surface(run.scene).heights, run.scene.spacing
    nodes = round(slow.cell / spacing)  # along the side of a cell
    places = [
        (round(corner / spacing + 0.5) + np.arange(count * nodes)) % period
        for corner, count, period in zip(
            (slow.along, slow.across), slow.pressure.shape[1:], heights.shape, strict=True
        )
    ]
    part = np.asarray(heights[np.ix_(*places)])
    spread = SPREAD * float(part.std()) or 1.0
    share = np.clip(0.5 + 0.5 * (part - part.mean()) / spread, 0.0, 1.0)
    return _saved(Image.fromarray(np.rint(255 * share).astype(np.uint8).T[::-1]))


def _sheet(maps: NDArray[np.uint8], palette: tuple[NDArray[np.uint8], bytes]) -> Sheet:
    """Cut each map to its part that is not empty, and arrange the parts in a picture."""
    parts, places = [], []
    for each in maps:
        turned = each.T[::-1]  # rows of a picture go down, the plate's second axis goes up
        rows, columns = (np.flatnonzero(turned.any(axis=axis)) for axis in (1, 0))
        top, left = (int(rows[0]), int(columns[0])) if rows.size else (0, 0)
        part = turned[top : int(rows[-1]) + 1, left : int(columns[-1]) + 1] if rows.size else None
        parts.append(np.zeros((1, 1), np.uint8) if part is None else part)
        places.append((left, top))
    height, width = (max(part.shape[axis] for part in parts) for axis in (0, 1))
    abreast = max(1, round(np.sqrt(len(parts) * height / width)))
    pixels = np.zeros((-(-len(parts) // abreast) * height, abreast * width), np.uint8)
    tiles = []
    for index, part in enumerate(parts):
        top, left = (index // abreast) * height, (index % abreast) * width
        pixels[top : top + part.shape[0], left : left + part.shape[1]] = part
        tiles.append((left, top, part.shape[1], part.shape[0]))
    image = Image.fromarray(pixels)
    image.putpalette(palette[0].tobytes())
    return Sheet(_saved(image, palette[1]), tiles, places)


def _pressure_palette() -> tuple[NDArray[np.uint8], bytes]:
    """Return the colours of pressure and their opacity; none without pressure."""
    colours = np.rint(DIMMED * pressure_maps.palette()).astype(np.uint8)
    return colours, bytes([0]) + bytes([VEIL]) * pressure_maps.SHADES


def _glow_palette() -> tuple[NDArray[np.uint8], bytes]:
    """Return the colour of release at all opacities."""
    return np.tile(np.array(GLOW, np.uint8), (256, 1)), bytes(range(256))


def _saved(image: Image.Image, opacity: bytes | None = None) -> bytes:
    content = io.BytesIO()
    image.save(
        content, format="png", optimize=True, **({"transparency": opacity} if opacity else {})
    )
    return content.getvalue()
