"""Heights with a spacing: files of profilometers and microscopes, and the grid a file becomes.

The packages of the extra `surfaces` read the formats, each imported when a file asks for it. A row
of heights is a line along x, and the rows follow y, as in a matrix of text. Unmeasured points
are NaN. The track needs the nodes before the heights are prepared: as read, resampled and
made periodic. They follow from the shape and the spacing of the file and from the keys of the
surface.
"""

import io
import math
import warnings
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from acoustics.arrays import Array, short_repr
from acoustics.numbers import rounded
from rolling.contact.track import MAX_NODES, MIN_NODES, Track
from rolling.scene import height_files
from rolling.scene.height_files import EXPORT, MAY_BE_TEXT, is_array, is_instrument, is_text
from rolling.scene.height_format import MAX_BYTES, UNITS, HeightFormatError
from rolling.scene.messages import first_line, mistake, plain_number, quoted, shortened
from rolling.scene.surfaces import HeightFile, refuse_width
from rolling.scene.text_heights import text_heights
from rolling.surface.period_grid import SAME, HeightGrid, Pair, is_other
from rolling.terminal.whole_files import open_regular

_INSTALL = 'pip install "rolling-contact-noise[surfaces]"'
_REASON = 120  # letters of an error of a reader
_SPACINGS = 1e-12, 1.0  # [m]

# Heights [m] (y, x) with their spacings [m] along y and x, made when a channel is asked for.
_Channels = dict[str, Callable[[], tuple[Any, Sequence[float]]]]


@dataclass(frozen=True, eq=False)
class Measured:
    """Heights as an instrument measured them.

    Attributes
    ----------
    numbers : (rows, columns) array
        Heights in their unit, (along, across), NaN at unmeasured points.
    spacing_m : tuple of float, or None
        Spacings [m] along and across; None: the file has none.
    unit : str
        Unit of UNITS of the numbers.
    names_unit : bool
        Whether the file or its format names that unit.
    xy_unit : str
        Unit of UNITS of the places in a text; empty for other files.
    names_xy_unit : bool
        Whether the file or its format names that unit.
    channels : tuple of str
        Names of the channels with heights.
    taken : str
        What of a text was taken for what; empty for other files.
    """

    __repr__ = short_repr

    numbers: Array
    spacing_m: tuple[float, float] | None
    unit: str = "m"
    names_unit: bool = True
    xy_unit: str = ""
    names_xy_unit: bool = True
    channels: tuple[str, ...] = ()
    taken: str = ""

    @property
    def heights(self) -> Array:
        """Heights [m]."""
        if self.unit == "m":
            return self.numbers
        heights = np.multiply(self.numbers, UNITS[self.unit])
        heights.flags.writeable = False
        return heights


def read(
    path: Path, channel: str | None = None, unit: str | None = None, xy_unit: str | None = None
) -> Measured:
    """Read the heights of a file of any format; the last files are kept.

    Parameters
    ----------
    path : Path
        File of an instrument, an array of numpy, or a text.
    channel : str, optional
        Name of a channel of an instrument's file, by default the first with heights.
    unit : str, optional
        Unit of UNITS of the heights in arrays and texts. Default: the unit that a text names,
        and m where it names none.
    xy_unit : str, optional
        Unit of the places in a text. Default: the unit that it names, and that of the heights
        where it names none.

    Raises
    ------
    HeightFormatError
        The file is missing, damaged, too large or without heights on a regular grid, has no such
        channel, or its reader is not installed.
    """
    height_files.refuse_missing(path)
    status = path.stat()
    stamp = status.st_mtime_ns, status.st_size, status.st_ino
    return _read(path, channel, unit, xy_unit, stamp)


def missing(ending: str, error: ModuleNotFoundError) -> str:
    """Name the package that files with an ending need, and the command that installs it."""
    return f"a {ending} file needs the package {error.name}: {_INSTALL}"


@lru_cache(maxsize=2)
def _read(
    path: Path, channel: str | None, unit: str | None, xy_unit: str | None, stamp: tuple[int, ...]
) -> Measured:
    """Read a file that was last written at a stamp."""
    if not is_instrument(path):
        if channel is not None:
            raise HeightFormatError(f"a {path.suffix.lower()} file has no channels")
        return _text(path, unit, xy_unit) if is_text(path) else _array(path, unit or "m")
    ending = path.suffix.lower()
    if ending in MAY_BE_TEXT and _is_text(path):
        return _text(path, unit, xy_unit)
    try:
        _refuse_large(path, stamp[1])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of readers about the contents of the file
            with _judged(path):
                channels = _channels_of_package(path, ending)
                heights, spacing = _chosen(channels, channel)
    except HeightFormatError:
        raise
    except ModuleNotFoundError as error:
        raise HeightFormatError(missing(ending, error)) from error
    except Exception as error:  # readers raise whatever the bytes of a damaged file lead to
        reason = f"no readable {ending} file ({_reason(error)}); {EXPORT}"
        raise HeightFormatError(reason) from error
    values = np.array(np.ma.filled(np.ma.asarray(heights, dtype=float), np.nan), dtype=np.float64)
    if values.ndim != 2 or not values.size:
        raise HeightFormatError("holds no heights")
    values[~np.isfinite(values)] = np.nan
    along, across = (float(f"{step:.12g}") for step in spacing)  # units leave noise
    _refuse_spacing(along, across)
    values.flags.writeable = False
    return Measured(values, (along, across), channels=tuple(channels))


def _refuse_spacing(along: float, across: float, advice: str = "") -> None:
    """Refuse spacings [m] that no surface is measured with."""
    if all(_SPACINGS[0] <= step <= _SPACINGS[1] for step in (along, across)):
        return
    got = f"got a spacing of {along:g} m along and {across:g} m across"
    limits = f"{_SPACINGS[0]:g} to {_SPACINGS[1]:g} m"
    raise HeightFormatError(f"{got}, allowed: {limits}{advice}")


def _array(path: Path, unit: str) -> Measured:
    """Read an array of numpy, which holds neither spacing nor unit."""
    values = height_files.numbers(path)
    with np.errstate(over="ignore", invalid="ignore"):  # such heights are refused later
        numbers = np.array(values, dtype=np.float64)
    numbers[~np.isfinite(numbers)] = np.nan
    numbers.flags.writeable = False
    return Measured(numbers, None, unit=unit, names_unit=False)


def _text(path: Path, unit: str | None, xy_unit: str | None) -> Measured:
    """Read a text with the units and the spacing that it names; given units win."""
    text = text_heights(path)
    own_unit = unit or text.unit or "m"
    spacing = None
    of_places = xy_unit or text.steps_unit or own_unit
    if text.steps is not None:
        along, across = (float(f"{step * UNITS[of_places]:.12g}") for step in text.steps)
        advice = f"; the key xy_unit says the unit of x and y, here {of_places}"
        _refuse_spacing(along, across, advice)
        spacing = along, across
    return Measured(
        numbers=text.numbers,
        spacing_m=spacing,
        unit=own_unit,
        names_unit=text.unit is not None,
        xy_unit=of_places if spacing is not None else "",
        names_xy_unit=text.steps_unit is not None,
        taken=text.taken,
    )


def _is_text(path: Path) -> bool:
    """Tell whether a file begins with letters, as an export of an instrument does."""
    with io.BufferedReader(open_regular(path)) as file:
        begin = file.read(4096)
    return not any(byte < 9 or 13 < byte < 26 for byte in begin)


def _judged(path: Path) -> AbstractContextManager[None]:
    """Judge a file that may be HDF5, in whatever format, before a package reads it."""
    from rolling.scene import hdf5_files  # slow to import

    return hdf5_files.judged(path, MAX_BYTES)


def _channels_of_package(path: Path, ending: str) -> _Channels:
    """Return the channels of heights of a file that a package reads."""
    if ending == ".x3p":
        return _x3p(path)
    if ending == ".sdf":
        return _sdf(path)
    return _topography(path)


def _reason(error: Exception) -> str:
    """Return the beginning of the message of a reader, which may quote any byte of a file."""
    return "".join(filter(str.isprintable, first_line(error)))[:_REASON]


def _refuse_large(path: Path, size: int) -> None:
    """Refuse files that are too large, packed or not."""
    if zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as archive:
            size = max(size, sum(member.file_size for member in archive.infolist()))
    _refuse_bytes(size)


def _refuse_bytes(size: int) -> None:
    """Refuse heights of more bytes than MAX_BYTES."""
    if size > MAX_BYTES:
        raise HeightFormatError(f"holds {size:,} bytes of heights, allowed: {MAX_BYTES:,}")


def _chosen(channels: _Channels, wanted: str | None) -> tuple[Any, Sequence[float]]:
    """Read the wanted channel, or the first."""
    if not channels:
        raise HeightFormatError("holds no channel of heights")
    channel = next(iter(channels)) if wanted is None else wanted
    if channel not in channels:
        names = ", ".join(map(quoted, list(channels)[:20]))
        raise HeightFormatError(f"got the channel {quoted(wanted)}, allowed: {names}")
    return channels[channel]()


# ---- formats: each gives its channels


def _x3p(path: Path) -> _Channels:
    """Return the layers of a file of ISO 25178-72."""
    import x3pio

    summary = x3pio.info(path)
    _refuse_bytes(8 * math.prod(summary.shape) * summary.layer_count)
    file = x3pio.read(path)
    if not getattr(file, "is_regular_grid", False):
        raise HeightFormatError("the points lie on no regular grid")
    across = file.header.x.increment
    along = across if isinstance(file, x3pio.Profile) else file.header.y.increment
    steps = [along, across]
    return {
        f"layer {k}": lambda layer=layer: (np.atleast_2d(layer.z), steps)  # type: ignore[misc]
        for k, layer in enumerate(file.layers, 1)
    }


def _sdf(path: Path) -> _Channels:
    """Return the heights of a file of ISO 25178-71."""
    import sdfio

    file = sdfio.read(path)
    across = file.header.x_scale
    along = across if file.is_profile else file.header.y_scale
    return {"heights": lambda: (file.data, [along, across])}


def _topography(path: Path) -> _Channels:
    """Return the channels of heights of a file that SurfaceTopography reads by its ending."""
    from acoustics import matplotlib_import

    matplotlib_import.ensure()  # because SurfaceTopography imports matplotlib
    with warnings.catch_warnings():
        # It says at import that it works without MPI.
        warnings.filterwarnings("ignore", "Could not import mpi4py", ImportWarning)
        from SurfaceTopography.IO import readers

    ending = path.suffix.lower().removeprefix(".")
    reasons = []
    for kind in readers:
        # A text without sizes has a reader under many endings; it would ask for the sizes.
        if ending not in kind.file_extensions() or kind.format() == "asc":
            continue
        try:
            file = kind(str(path))
        except Exception as error:
            reasons.append(_reason(error))
            continue
        heights = (channel for channel in file.channels if channel.is_height_channel)
        return {channel.channel_id: partial(_of_channel, channel) for channel in heights}
    raise HeightFormatError(f"no readable .{ending} file ({'; '.join(reasons)}); {EXPORT}")


def _of_channel(channel: Any) -> tuple[Any, list[float]]:
    """Return heights [m] (y, x) and spacings [m] of a channel, which holds them as (x, y)."""
    from SurfaceTopography.Support.UnitConversion import get_unit_conversion_factor

    _refuse_bytes(8 * math.prod(channel.nb_grid_pts or (0,)))
    if channel.physical_sizes is None or channel.unit is None:
        raise HeightFormatError(f"the channel {quoted(channel.name)} has no sizes in a unit")
    topography = channel.topography()
    if not topography.is_uniform:
        raise HeightFormatError("the points lie on no regular grid")
    factor = get_unit_conversion_factor(topography.unit, "m")
    heights = np.ma.atleast_2d(np.ma.asarray(topography.heights()).T) * factor
    steps = [factor * step for step in np.ravel(topography.pixel_size)]
    return heights, [steps[-1], steps[0]]


# ---- grid of a file


DEFAULT_OVERLAP = 0.1  # of each side
MAX_OVERLAP = 0.5  # of each side
_MOST = 2e9  # nodes of a side, above all limits, so that counts stay whole numbers


def is_turned(shape: Pair, surface: HeightFile) -> bool:
    """Tell whether columns of a file lie along the track; a profile of one row always does."""
    if 1 in shape:
        return shape[0] == 1
    return surface.along == "x"


def height_grid(path: Path, surface: HeightFile) -> HeightGrid:
    """Derive the nodes of the period of a height file from its shape, its spacing and the keys.

    Raise a mistake where the file has no heights or does not go with the keys of the surface.
    """
    with mistakes_at(path, surface.path, "surface.path"):
        shape, own_steps = _shape_and_steps(path, surface)
    if is_turned(shape, surface):
        shape = shape[1], shape[0]
        own_steps = own_steps and (own_steps[1], own_steps[0])
    if surface.spacing_um is not None:
        spacing = surface.spacing_um * 1e-6
    else:
        if own_steps is None:
            raise mistake("missing; the file names no spacing", at="surface.spacing_um")
        spacing = min(own_steps)
    steps = own_steps or (spacing, spacing)
    is_profile = shape[1] == 1
    _refuse_profile(surface, shape[1])
    if surface.width_um is not None:
        refuse_width(surface.width_um, spacing * 1e6)
        shape = shape[0], round(surface.width_um * 1e-6 / spacing)
        steps = steps[0], spacing
    sides = [shape[0] * steps[0]]
    if not is_profile:
        sides.append(shape[1] * steps[1])
    _refuse_filters(surface, 1e6 * min(sides))
    resampled = _resampled(shape, steps, spacing, surface)
    along = _period(resampled[0], spacing, surface)
    across = NodesOfSide(resampled[1], overlap=0)
    if not is_profile:
        across = _period(resampled[1], spacing, surface)
    nodes = along.nodes, across.nodes
    if not MIN_NODES <= min(nodes) <= max(nodes) < MAX_NODES:
        raise mistake(
            f"{surface.path}: got {nodes[0]} x {nodes[1]} nodes, allowed: at least {MIN_NODES} each"
            f" way and less than {rounded(MAX_NODES)}",
            at="surface.path",
        )
    return HeightGrid(
        steps=steps,
        spacing=spacing,
        resampled=resampled,
        overlap=(along.overlap, across.overlap),
        nodes=nodes,
    )


def _refuse_profile(surface: HeightFile, lines: int) -> None:
    """Refuse a profile of one line without a width, and other files with one."""
    if lines == 1 and surface.width_um is None:
        raise mistake(
            f"missing; {surface.path} is a profile of one line, which is laid across the track over"
            " that width",
            at="surface.width_um",
        )
    if lines > 1 and surface.width_um is not None:
        raise mistake(
            f"only goes with a profile of one line, but {surface.path} has {lines} lines side by"
            " side",
            at="surface.width_um",
        )


def _resampled(
    shape: Pair, steps: tuple[float, float], spacing: float, surface: HeightFile
) -> Pair:
    """Return the nodes of a file at the spacing of the period; refuse more than are read."""
    if not is_other(steps, spacing):
        return shape
    counts = []
    for count, step in zip(shape, steps, strict=True):
        if surface.made_periodic == "none":  # a period keeps its length, to half a node
            counts.append(round(min(count * step / spacing, _MOST)))
        else:
            counts.append(int(min((count - 1) * step / spacing, _MOST) + SAME) + 1)
    along, across = counts
    if (along, across) != shape and 8 * along * across > MAX_BYTES:
        raise mistake(
            f"got {rounded(spacing * 1e6, 4)}, which makes {along} x {across} nodes of"
            f" {surface.path}, allowed: less than {rounded(MAX_BYTES / 8)} nodes",
            at="surface.spacing_um",
        )
    return along, across


class NodesOfSide(NamedTuple):
    """Nodes of a side of the period, and those that are blended into its beginning."""

    nodes: int
    overlap: int


def _period(count: int, spacing: float, surface: HeightFile) -> NodesOfSide:
    """Return the nodes of a side that becomes periodic."""
    if surface.made_periodic == "blend":
        overlap = _overlap(surface, count, spacing)
        return NodesOfSide(count - overlap, overlap)
    if surface.made_periodic == "mirror":
        return NodesOfSide(2 * count - 2, overlap=0)
    return NodesOfSide(count, overlap=0)


def _shape_and_steps(path: Path, surface: HeightFile) -> tuple[Pair, tuple[float, float] | None]:
    """Read the shape of a file, and the spacings [m] of a file that has its own."""
    if is_array(path):
        return height_files.nodes(path), None
    measured = read(path, surface.channel, surface.height_unit, surface.xy_unit)
    rows, columns = measured.heights.shape
    return (rows, columns), measured.spacing_m


def _overlap(surface: HeightFile, count: int, spacing: float) -> int:
    """Return the nodes of an overlap, by default a tenth of a side; refuse more than half."""
    if surface.overlap_um is None:
        return round(DEFAULT_OVERLAP * count)
    overlap = round(min(surface.overlap_um * 1e-6 / spacing, _MOST))
    most = int(MAX_OVERLAP * count)
    if not 1 <= overlap <= most:
        raise mistake(
            f"got {plain_number(surface.overlap_um)}, allowed: {rounded(spacing * 1e6, 4)} to"
            f" {rounded(most * spacing * 1e6, 4)}, half of a side",
            at="surface.overlap_um",
        )
    return overlap


def _refuse_filters(surface: HeightFile, side_um: float) -> None:
    """Refuse cut-offs above the shorter side of the file [um]."""
    for key in ("s_filter_um", "l_filter_um"):
        cutoff = getattr(surface, key)
        if cutoff is not None and cutoff > side_um * (1 + SAME):
            raise mistake(
                f"got {plain_number(cutoff)}, allowed: up to {rounded(side_um, 4)}, the shorter"
                f" side of {surface.path}",
                at=f"surface.{key}",
            )


def refuse_turn(path: Path, name: str, track: Track) -> None:
    """Raise a mistake for a height file that holds no turn of the sphere over the width.

    `name` is the path as the scene has it.
    """
    with mistakes_at(path, name, "sphere.surface.path"):
        rows, columns = height_files.nodes(path)
    if rows != track.turn_nodes or columns not in (1, track.n_across):
        radius = rounded(rows * track.spacing * 1e3 / (2 * math.pi), 8)
        raise mistake(
            f"{name}: got {rows} x {columns} nodes, allowed: {track.turn_nodes} nodes around the"
            f" sphere x 1 or {track.n_across} across; {rows} nodes are a turn of sphere.radius_mm"
            f" {radius}",
            at="sphere.surface.path",
        )


@contextmanager
def mistakes_at(path: Path, name: str, at: str) -> Iterator[None]:
    """Raise a mistake at a key where a file holds no heights; `name` is its path in the scene."""
    try:
        yield
    except HeightFormatError as error:
        missing = isinstance(error.__cause__, FileNotFoundError)
        place = f" (looked in {path.parent.absolute()})" if missing else ""
        raise mistake(f"{error.of(shortened(name))}{place}", at=at) from error
