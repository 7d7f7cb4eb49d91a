"""Numbers of a file of heights as metres about their mean, or why they are none."""

from pathlib import Path

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import rounded
from rolling.scene.height_files import numbers
from rolling.scene.height_format import UNITS, HeightFormatError
from rolling.scene.messages import plain_number
from rolling.surface import markers
from rolling.surface.heights import SurfaceError

LARGEST_RA = 1e-3  # [m]; anything rougher is a file in other units
# [m]; of larger heights double precision keeps no roughness, and their sum may overflow
HIGHEST = 1e6


def read_heights(path: Path, unit: str = "m", section: str = "surface") -> Array:
    """Read heights of an array or of text in a unit of UNITS as metres about their mean.

    Raise SurfaceError where the file holds no array of real numbers, and as `in_metres` does.
    """
    try:
        values = numbers(path)
    except HeightFormatError as error:
        raise SurfaceError(error.of(path)) from error
    return in_metres(values, unit, str(path), section=section)


def in_metres(
    values: np.ndarray,
    unit: str,
    name: str,
    has_gaps: bool = False,
    section: str = "surface",
    has_own_unit: bool = False,
) -> Array:
    """Return heights in a unit of UNITS as metres about their mean, NaN at unmeasured points.

    Parameters
    ----------
    values : (m, n) array
        Heights.
    unit : str
        Their unit.
    name : str
        Name of the heights in messages.
    has_gaps : bool
        Whether unmeasured points are allowed.
    section : str
        Section of the scene whose keys a message may name.
    has_own_unit : bool
        Whether the file holds its unit, so that no key can change it.

    Raises
    ------
    SurfaceError
        Some heights are no numbers and gaps are not allowed, some are above 1000 km, or Ra is
        above 1 mm. Values that look like marks of unmeasured points are named.
    """
    try:
        return _in_metres(values, unit, name, has_gaps, section, has_own_unit)
    except SurfaceError as error:
        suspects = markers.suspected(values, unit)
        if not suspects:
            raise
        raise SurfaceError(f"{error}; {markers.sentence(suspects, section)}") from error


def _in_metres(
    values: np.ndarray, unit: str, name: str, has_gaps: bool, section: str, has_own_unit: bool
) -> Array:
    """Return heights as `in_metres` does, and refuse them without a word on marks."""
    with np.errstate(over="ignore", invalid="ignore"):  # such heights are refused below
        heights = values.astype(np.float64)
    if not heights.size:
        raise SurfaceError(f"{name}: holds no heights")
    finite = np.isfinite(heights)
    gaps = heights.size - np.count_nonzero(finite)
    if gaps == heights.size or (gaps and not has_gaps):
        row, column = map(int, np.argwhere(~finite)[0])
        advice = "surface.unmeasured fill fills such points of the plate"
        if section != "surface":
            advice = "a surface of a sphere has no key that fills them, so fill them in the file"
        raise SurfaceError(
            f"{name}: {gaps} of {heights.size} heights are not numbers, the first at"
            f" ({row}, {column}); {advice}"
        )
    if gaps:
        heights[~finite] = np.nan
    largest = float(np.nanmax(np.abs(heights)))
    if largest * UNITS[unit] > HIGHEST:
        most = plain_number(HIGHEST / UNITS[unit])
        raise SurfaceError(
            f"{name}: got a height of {rounded(largest, 4)} {unit}, allowed: up to {most} {unit}"
        )
    mean = np.nanmean if gaps else np.mean
    heights = (heights - mean(heights)) * UNITS[unit]
    ra = float(mean(np.abs(heights)))
    if ra > LARGEST_RA:
        units = ", ".join(UNITS)
        advice = f"set {section}.height_unit, {unit} here, to the unit of the file ({units})"
        if has_own_unit:
            advice = "the file holds its own unit, so some of its points are probably no heights"
        raise SurfaceError(
            f"{name}: Ra would be {rounded(ra, 4)} m, more than {LARGEST_RA:g} m; {advice}"
        )
    return heights
