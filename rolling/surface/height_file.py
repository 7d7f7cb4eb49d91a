"""Heights from files: as they are stored, and centred in metres."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rolling._typing import Array
from rolling.scene.height_files import UNITS, HeightFormatError, numbers
from rolling.surface.heights import SurfaceError

LARGEST_RA = 1e-3  # [m]; anything rougher is a file in other units
# [m]; of larger heights double precision keeps no roughness, and their sum may overflow
HIGHEST = 1e6


def read(path: Path, unit: str = "m", n_across: int | None = None) -> Array:
    """Read heights from a file in metres, shape (along, across), and take the mean off.

    Parameters
    ----------
    path : Path
        File of heights.
    unit : str
        Key of UNITS, the unit of the numbers in the file. Default "m".
    n_across : int or None
        Nodes across that a profile of one line is laid over. Default None: it stays one line.

    Raises
    ------
    SurfaceError
        The file has faults that `stored` or `usable` names.
    """
    return usable(stored(path), path, unit, n_across)


def stored(path: Path) -> Array:
    """Read the numbers of a height file in double precision, a profile of one line as one column.

    Raises
    ------
    SurfaceError
        The file holds no array of real numbers, or heights are not finite (the first is named).
    """
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # such heights are refused below
            heights = numbers(path).astype(np.float64)
    except HeightFormatError as error:
        raise SurfaceError(error.of(path)) from error
    if not heights.size:
        raise SurfaceError(f"{path}: holds no heights")
    bad = np.argwhere(~np.isfinite(heights))
    if len(bad):
        i, j = bad[0]
        raise SurfaceError(
            f"{path}: {len(bad)} of {heights.size} heights are not numbers, the first at"
            f" ({i}, {j}); fill them in first"
        )
    return heights


def usable(heights: Array, path: Path, unit: str = "m", n_across: int | None = None) -> Array:
    """Return stored heights in metres about their mean, a profile laid across.

    Parameters
    ----------
    heights : (rows, columns) array
        Numbers of the file at `path`.
    path, unit, n_across : Path, str, int or None
        As for `read`.

    Raises
    ------
    SurfaceError
        A height is above 1000 km, or Ra above 1 mm.
    """
    largest = float(np.abs(heights).max())
    if largest * UNITS[unit] > HIGHEST:
        raise SurfaceError(
            f"{path}: got a height of {largest:.4g} {unit}, allowed: up to"
            f" {HIGHEST / UNITS[unit]:g} {unit}"
        )
    heights = (heights - heights.mean()) * UNITS[unit]
    ra = np.abs(heights).mean()
    if ra > LARGEST_RA:
        raise SurfaceError(
            f"{path}: Ra would be {ra:.4g} m, more than {LARGEST_RA:g} m; set surface.height_unit,"
            f" {unit} here, to the unit of the file ({', '.join(UNITS)})"
        )
    return heights if n_across is None else np.repeat(heights, n_across, axis=1)
