"""Doubts about measured heights, files of heights that are written, and heights of numpy arrays.

A scene knows files. An array is written to a folder of this process under the digest of its bytes,
where the workers read it, and a saved run has a copy.
"""

import atexit
import hashlib
import importlib
import io
import shutil
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from acoustics.arrays import Array, positive, with_nan
from acoustics.numbers import rounded
from acoustics.traps import ignoring_underflow
from rolling.contact.track import MIN_NODES
from rolling.in_si.in_metres import in_metres
from rolling.scene import height_files, height_grid
from rolling.scene.height_format import UNITS, HeightFormatError
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.surface import markers
from rolling.terminal import whole_files

# Median slope between neighbours above which x and y are in another unit than the heights, because
# no instrument measures a surface of which half is steeper than 60 degrees.
STEEP = 2.0
# A unit is proposed that brings the median slope between these.
FLAT = 1e-4
USUAL = 0.5
WRITTEN = (".npy", ".csv", ".xyz", ".x3p", ".sdf")


def read(
    path: Path, channel: str | None = None, unit: str = "m", xy_unit: str | None = None
) -> height_grid.Measured:
    """Read the heights of a file of any format.

    Parameters
    ----------
    path : Path
        File of an instrument, of triples x, y, z, of an array of numpy, or of rows of text.
    channel : str, optional
        Name of a channel of an instrument's file, by default the first with heights.
    unit : str
        Unit of UNITS of the heights in files that name none: arrays, rows of text and triples.
    xy_unit : str, optional
        Unit of x and y in a file of triples. Default: that of the heights.

    Returns
    -------
    measured : Measured
        Heights [m], shape (along, across), NaN at unmeasured points, and their spacing,
        None for arrays and rows of text.

    Raises
    ------
    HeightFormatError
        The file is missing, damaged or too large, holds no such heights, or needs a package that
        is not installed.
    """
    if height_files.is_instrument(path):
        return height_grid.read(path, channel, unit, xy_unit)
    if channel is not None:
        raise HeightFormatError(f"a {path.suffix.lower()} file has no channels")
    with np.errstate(over="ignore", invalid="ignore"):  # such heights are refused later
        heights = height_files.numbers(path).astype(np.float64) * UNITS[unit]
    heights[~np.isfinite(heights)] = np.nan
    return height_grid.Measured(heights, None)


def doubts(
    path: Path,
    measured: height_grid.Measured,
    xy_key: str = "surface.xy_unit",
    height_key: str = "surface.height_unit",
) -> list[str]:
    """Return a sentence for each doubt about the columns and the units of a file of text.

    The keys are those which set the unit of x and y, and of the heights.
    """
    sentences = height_files.doubts(path)
    steepest = steepness(measured)
    if not height_files.takes_units(path) or steepest <= STEEP:
        return sentences
    key = height_key
    whose = "heights"
    size = UNITS[measured.unit]
    likely = [name for name, of in UNITS.items() if FLAT <= steepest * of / size <= USUAL]
    if measured.xy_unit and not measured.names_xy_unit:
        key = xy_key
        whose = "x and y"
        size = UNITS[measured.xy_unit]
        likely = [name for name, of in UNITS.items() if FLAT <= steepest * size / of <= USUAL]
    advice = f"{key} {' or '.join(likely)}" if likely else key
    return [
        *sentences,
        f"half of the neighbouring heights are steeper than {rounded(steepest, 2)}, with"
        f" {whose} in {measured.xy_unit if key == xy_key else measured.unit}: set {advice} if"
        f" {whose} are in that unit",
    ]


def steepness(measured: height_grid.Measured) -> float:
    """Return the median slope between neighbours along the steeper axis; 0 without a spacing."""
    slopes = []
    for axis, step in enumerate(measured.spacing_m or ()):
        differences = np.abs(np.diff(measured.numbers, axis=axis))
        if not np.isnan(differences).all():
            slopes.append(float(np.nanmedian(differences)) * UNITS[measured.unit] / step)
    return max(slopes, default=0.0)


def write(path: Path, heights_m: Array, spacing_m: tuple[float, float]) -> None:
    """Write heights to a file, whose ending determines the format; see WRITTEN.

    Parameters
    ----------
    path : Path
        File to write, completely or not at all.
    heights_m : (rows, columns) array, m
        Heights along and across; NaN at unmeasured points.
    spacing_m : (float, float), m
        Node spacings along and across; a .npy or .csv file does not hold them.

    Raises
    ------
    HeightFormatError
        The ending is of no such format, or its package is not installed.
    OSError
        The file cannot be written.
    """
    ending = path.suffix.lower()
    stream = io.BytesIO()
    heights = np.ascontiguousarray(with_nan(heights_m), dtype=np.float64)
    along, across = spacing_m
    try:
        if ending == ".npy":
            np.save(stream, heights)
        elif ending == ".csv":
            np.savetxt(stream, heights, "%.17g", ",")
        elif ending == ".xyz":
            row, column = np.nonzero(np.isfinite(heights))
            points = np.column_stack([column * across, row * along, heights[row, column]])
            np.savetxt(stream, points, "%.17g")
        elif ending in WRITTEN:  # a package writes each format of ISO 25178-7
            package = importlib.import_module(f"{ending[1:]}io")
            package.write(stream, heights, x_scale=across, y_scale=along)
        else:
            got = f"the ending {path.suffix}" if ending else "no ending"
            raise HeightFormatError(f"got {got}, allowed: {', '.join(WRITTEN)}")
    except ModuleNotFoundError as error:
        raise HeightFormatError(height_grid.missing(ending, error)) from error
    whole_files.write_bytes(path, stream.getvalue())


# ---- heights of arrays


COPY = "heights.npy"  # name of the copy in the folder of a run


@ignoring_underflow
def HeightArray(heights: Any, *, spacing_um: float, **keys: Any) -> HeightFile:
    """Make a surface of an array of heights, for `Scene(surface=...)` and `simulate(heights=...)`.

    Parameters
    ----------
    heights : (m, n) array_like, m
        Real heights along and across the track, one period of at least 8 x 8 nodes; or a profile of
        shape (m,), (m, 1) or (1, m) with the key `width_um`.
    spacing_um : float, um
        Node spacing along and across.
    **keys
        Other keys of `HeightFile`, such as `periodic="blend"` for a measurement,
        `unmeasured="fill"` where NaN marks unmeasured points, and `height_unit`.

    Returns
    -------
    surface : HeightFile
        Its file lasts as long as this process.

    Raises
    ------
    ValueError
        The heights have another shape, or are not real, not finite or too large.
    SceneError
        A key is unknown or does not fit.

    Examples
    --------
    >>> import numpy as np
    >>> import rolling
    >>> z = 1e-7 * np.random.default_rng(1).standard_normal((64, 32))
    >>> rolling.HeightArray(z, spacing_um=2).spacing_um
    2.0
    """
    allowed = f"allowed: real numbers, (along, across), at least {MIN_NODES} each way, or a profile"
    try:
        values = with_nan(heights)
    except ValueError as error:  # rows of several lengths
        raise ValueError(f"heights: got rows of several lengths, {allowed}") from error
    if values.dtype.kind not in "fiu" or values.ndim not in (1, 2):
        raise ValueError(f"heights: got {values.ndim}-D {values.dtype}, {allowed}")
    is_profile = values.ndim == 1 or 1 in values.shape
    if max(values.shape) < MIN_NODES or (min(values.shape) < MIN_NODES and not is_profile):
        raise ValueError(f"heights: got an array of shape {values.shape}, {allowed}")
    positive("spacing_um", spacing_um, 1e15)
    surface = HeightFile(path=COPY, spacing_um=float(spacing_um), **keys)
    unit = surface.height_unit or "m"
    checked = values
    if surface.outliers is not None:  # the preparation replaces marks of unmeasured points
        checked = markers.without(values, markers.suspected(np.atleast_2d(values), unit))
    in_metres(checked, unit, "heights", has_gaps=surface.unmeasured == "fill")
    stream = io.BytesIO()
    np.save(stream, values)
    content = stream.getvalue()
    path = _folder() / f"{hashlib.sha256(content).hexdigest()[:32]}.npy"
    if not path.exists():
        whole_files.write_bytes(path, content)
    return surface.model_copy(update={"path": str(path)})


@cache
def _folder() -> Path:
    """Make the folder of the arrays of this process, which its end removes."""
    folder = Path(tempfile.mkdtemp(prefix="rolling-heights-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def with_copy(scene: Scene, folder: Path) -> Scene:
    """Copy the array of a scene into a folder; return the scene with the copy in its place."""
    path = scene.height_path
    has_folder = _folder.cache_info().currsize > 0
    if path is None or not has_folder or path.parent != _folder():
        return scene
    whole_files.write_bytes(folder / COPY, path.read_bytes())
    data = scene.to_dict()
    return Scene.from_dict({**data, "surface": {**data["surface"], "path": COPY}}, folder)
