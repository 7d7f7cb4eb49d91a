"""Heights of the file of a plate: read, and prepared by the keys of its section."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from acoustics.arrays import Array
from rolling.in_si.in_metres import in_metres
from rolling.scene import height_grid
from rolling.scene.height_files import is_instrument
from rolling.scene.height_format import HeightFormatError
from rolling.scene.surfaces import HeightFile
from rolling.surface import markers
from rolling.surface.heights import SurfaceError
from rolling.surface.levelling import Levelling
from rolling.surface.markers import Marker, Nodes
from rolling.surface.preparation import Effect, PreparationSteps, prepare, scale_limited


def prepared_file(path: Path, surface: HeightFile) -> tuple[Array, Levelling, list[Effect]]:
    """Read the heights of the plate [m], and prepare them by the keys of the surface.

    Returned are one period, the plane of the heights with the seam of the period, and the steps
    that were taken.

    Raises
    ------
    SurfaceError
        The heights cannot be used.
    """
    grid = height_grid.height_grid(path, surface)
    return prepare(read(path, surface), steps_of(surface), grid, _marked(path, surface))


@dataclass(frozen=True, eq=False)
class ScaleLimited:
    """Heights of a plate as prepared, with their own ends.

    heights : (along, across) array, m. A profile is one column.
    steps : (float, float), m. Spacings along and across, those of the file.
    effects : list of Effect. Steps that were taken.
    """

    heights: Array
    steps: tuple[float, float]
    effects: list[Effect]


def scale_limited_file(path: Path, surface: HeightFile) -> ScaleLimited:
    """Read and prepare the heights of the plate on their own nodes, up to their ends.

    Raises
    ------
    SurfaceError
        The heights cannot be used.
    """
    grid = height_grid.height_grid(path, surface)
    marked = _marked(path, surface)
    heights, effects = scale_limited(read(path, surface), steps_of(surface), grid, marked)
    return ScaleLimited(heights=heights, steps=grid.steps, effects=effects)


def _marked(path: Path, surface: HeightFile) -> Nodes | None:
    """Return the nodes that hold marks, where outliers count as unmeasured."""
    return None if surface.outliers is None else suspected(path, surface)[1]


def steps_of(surface: HeightFile) -> PreparationSteps:
    """Return the steps of the preparation that the keys of a surface ask for."""
    s_filter_um = surface.s_filter_um
    l_filter_um = surface.l_filter_um
    return PreparationSteps(
        outliers=surface.outliers,
        fills_unmeasured=surface.unmeasured == "fill",
        s_filter_m=None if s_filter_um is None else s_filter_um * 1e-6,
        l_filter_m=None if l_filter_um is None else l_filter_um * 1e-6,
        l_filter_is_robust=surface.l_filter == "robust",
        form=surface.level,
        closing=surface.made_periodic,
        is_profile=surface.width_um is not None,
    )


def read(path: Path, surface: HeightFile) -> Array:
    """Read the heights of the plate [m], (along, across), about their mean; NaN is unmeasured.

    Where outliers count as unmeasured, marks of unmeasured points do so at once if the heights
    cannot be used with them. Raise SurfaceError for unusable heights, and for unmeasured points
    that may not be filled.
    """
    values, unit = _values(path, surface)
    metres = partial(
        in_metres,
        unit=unit,
        name=str(path),
        has_gaps=surface.unmeasured == "fill",
        has_own_unit=is_instrument(path),
    )
    try:
        return metres(values)
    except SurfaceError:
        suspects = markers.suspected(values, unit)
        if surface.outliers is None or not suspects:
            raise
    return metres(markers.without(values, suspects))


def suspected(path: Path, surface: HeightFile) -> tuple[tuple[Marker, ...], Nodes]:
    """Return the values in the file of a plate that look like marks of unmeasured points.

    The nodes that hold them, (along, across), come with them.
    """
    values, unit = _values(path, surface)
    suspects = markers.suspected(values, unit)
    return suspects, np.isin(values, [suspect.value for suspect in suspects])


def _values(path: Path, surface: HeightFile) -> tuple[Array, str]:
    """Read the numbers of a file, (along, across), and their unit."""
    try:
        read = height_grid.read(path, surface.channel, surface.height_unit, surface.xy_unit)
    except HeightFormatError as error:
        raise SurfaceError(error.of(path)) from error
    values = read.numbers
    return (values.T if height_grid.is_turned(values.shape, surface) else values), read.unit
