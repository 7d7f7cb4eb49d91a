"""Heights in files of all formats, read and written in SI."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np

from acoustics.arrays import Array
from rolling.scene import height_files, height_grid
from rolling.scene.height_files import UNITS, HeightFormatError
from rolling.scene.height_grid import Measured
from rolling.surface.levelling import HIGHEST, LARGEST_RA
from rolling.surface.parameters import without_plane
from rolling.terminal import files
from rolling.terminal.files import FolderError

WRITTEN = ".npy", ".csv", ".xyz", ".x3p", ".sdf"


def read(path: Path, channel: str | None = None, unit: str = "m") -> Measured:
    """Read the heights of a file of any format.

    Parameters
    ----------
    path : Path
        File of an instrument, of triples x, y, z, of an array of numpy, or of rows of text.
    channel : str, optional
        Name of a channel of an instrument's file, by default the first with heights.
    unit : str
        Unit of UNITS of the numbers in files that name none: arrays, rows of text and triples.

    Returns
    -------
    measured : Measured
        Heights [m], shape (along, across), NaN where nothing was measured, and their spacing,
        None for arrays and rows of text.

    Raises
    ------
    HeightFormatError
        The file is missing, damaged or too large, holds no such heights, or needs a package that
        is not installed.
    """
    if height_files.is_instrument(path):
        return height_grid.read(path, channel, unit)
    if channel is not None:
        raise HeightFormatError(f"a {path.suffix.lower()} file has no channels")
    with np.errstate(over="ignore", invalid="ignore"):  # such heights are refused later
        heights = height_files.numbers(path).astype(np.float64) * UNITS[unit]
    heights[~np.isfinite(heights)] = np.nan
    return Measured(heights, None)


def levelled(
    path: Path, spacing_um: float | None, channel: str | None, unit: str
) -> tuple[Array, Array]:
    """Read measured heights [m] less their plane, and their spacings [m] along and across.

    A profile lies along the track. Raise FolderError for heights that cannot be used, and for a
    spacing [um] that is missing or that the file has itself.
    """
    try:
        measured = read(path, channel, unit)
    except HeightFormatError as error:
        raise FolderError(error.of(path)) from error
    if (measured.spacing_m is None) == (spacing_um is None):
        words = "missing; the file holds no" if spacing_um is None else "the file holds its own"
        raise FolderError(f"{path}: --spacing-um: {words} spacing")
    sizes = np.abs(measured.heights[np.isfinite(measured.heights)])
    if not sizes.size or sizes.max() > HIGHEST:
        raise FolderError(f"{path}: holds no heights, or heights above {HIGHEST:g} m")
    heights = without_plane(measured.heights)
    if np.nanmean(np.abs(heights)) > LARGEST_RA:
        raise FolderError(f"{path}: --height-unit: Ra would be more than {LARGEST_RA:g} m")
    steps = np.array(measured.spacing_m or (1e-6 * (spacing_um or 0),) * 2)
    return (heights.T, steps[::-1]) if len(heights) == 1 else (heights, steps)


def write(path: Path, heights_m: Array, spacing_m: tuple[float, float]) -> None:
    """Write heights to a file, whose ending determines the format; see WRITTEN.

    Parameters
    ----------
    path : Path
        File to write, completely or not at all.
    heights_m : (rows, columns) array, m
        Heights along and across; NaN where nothing was measured.
    spacing_m : (float, float), m
        Node spacings along and across; a .npy or .csv file does not hold them.

    Raises
    ------
    HeightFormatError
        The ending is of no such format, its package is not installed, or text has no NaN.
    OSError
        The file cannot be written.
    """
    ending, stream = path.suffix.lower(), io.BytesIO()
    heights = np.ascontiguousarray(heights_m, dtype=np.float64)
    along, across = spacing_m
    try:
        if ending == ".npy":
            np.save(stream, heights)
        elif ending == ".csv":
            if not np.isfinite(heights).all():
                raise HeightFormatError("a .csv file holds no unmeasured points; take .xyz or .x3p")
            np.savetxt(stream, heights, "%.17g", ",")
        elif ending == ".xyz":
            row, column = np.nonzero(np.isfinite(heights))
            points = np.column_stack([column * across, row * along, heights[row, column]])
            np.savetxt(stream, points, "%.17g")
        elif ending == ".x3p":
            import x3pio

            x3pio.write(stream, heights, x_scale=across, y_scale=along)
        elif ending == ".sdf":
            import sdfio

            sdfio.write(stream, heights, x_scale=across, y_scale=along)
        else:
            got = f"the ending {path.suffix}" if ending else "no ending"
            raise HeightFormatError(f"got {got}, allowed: {', '.join(WRITTEN)}")
    except ModuleNotFoundError as error:
        raise HeightFormatError(height_grid.missing(ending, error)) from error
    files.write_bytes(path, stream.getvalue())
