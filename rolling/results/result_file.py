"""The file result.h5: a tree of named arrays with dimensions and units, and a digest at its end.

HDF5 does not look beyond its own end, so its readers do not notice the last line, a SHA-256 of all
bytes before it. A damaged file is refused before the HDF5 library, which damage could crash, opens
it. A digest is no signature: names, types and shapes are compared with the scene before any array
is read.
"""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np
from numpy.typing import NDArray

import rolling
from acoustics import wav
from acoustics.bands import MID_HZ
from rolling.check.error_cost import LEVELS
from rolling.marches.observers import (
    EVENT_COLUMNS,
    STATE_SERIES,
    STEP_SERIES,
    PressureMap,
    SlowMotion,
    Snapshot,
)
from rolling.marches.result import (
    MOVING_SERIES,
    ErrorStretches,
    LoadMarches,
    MovingRelease,
    Result,
    StretchMarch,
)
from rolling.scene import file as scene_file
from rolling.scene.scene import Scene
from rolling.terminal.files import FolderError

if TYPE_CHECKING:
    import xarray

    from rolling.results.run_result import Run

FORMAT = 3
_SEAL = b"\nrolling-contact-noise result.h5, SHA-256 of all bytes before this line: "
_SEAL_LENGTH = len(_SEAL) + 65  # with the digest and the end of the line
_LARGEST = 50  # bytes of all arrays per byte of a file, which is little compressed

Arrays = dict[str, NDArray[Any]]
# Dimensions, unit and type of each variable by its path. A step series has an entry for the step
# from each position to the next, a state series one for each position.
TABLE = {
    "step": ("step", "m", "f8"),
    "position": ("position", "m", "f8"),
    "time": ("step", "s", "f8"),
    "position_time": ("position", "s", "f8"),
    "release_energy": ("step", "J", "f8"),
    "loading_energy": ("step", "J", "f8"),
    "energy_defect": ("step", "J", "f8"),
    "speed": ("step", "m/s", "f8"),
    "release_power": ("step", "W", "f8"),
    "loading_power": ("step", "W", "f8"),
    "release_per_metre": ("step", "J/m", "f8"),
    "loading_per_metre": ("step", "J/m", "f8"),
    "approach": ("position", "m", "f8"),
    "contact_area": ("position", "m2", "f8"),
    "plastic_area": ("position", "m2", "f8"),
    "max_pressure": ("position", "Pa", "f8"),
    "max_deflection": ("position", "m", "f8"),
    "stored_energy": ("position", "J", "f8"),
    "residual": ("position", "1", "f8"),
    "iterations": ("position", "1", "f8"),
    "convolutions": ("position", "1", "f8"),
    "snapshot/along": ("along", "m", "f8"),
    "snapshot/across": ("across", "m", "f8"),
    "snapshot/pressure": ("along across", "Pa", "f8"),
    "snapshot/deflection": ("along across", "m", "f8"),
    "pressure_maps/position": ("map", "1", "i8"),
    "pressure_maps/distance": ("map", "m", "f8"),
    "pressure_maps/along": ("map", "m", "f8"),
    "pressure_maps/across": ("map", "m", "f8"),
    "pressure_maps/cell": ("map", "m", "f8"),
    "pressure_maps/rows": ("map", "1", "i8"),
    "pressure_maps/columns": ("map", "1", "i8"),
    "pressure_maps/pressure": ("map row column", "Pa", "f4"),
    "events/node": ("event axis", "1", "i4"),
    "events/first": ("event", "position", "i8"),
    "events/last": ("event", "position", "i8"),
    "events/energy": ("event", "J", "f8"),
    "events/peak": ("event", "J per step", "f8"),
    "error_estimate/first": ("stretch", "position", "i8"),
    "error_estimate/release_energy": ("stretch level stretch_step", "J", "f8"),
    "error_estimate/approach": ("stretch level stretch_place", "m", "f8"),
    "error_estimate/plastic_area": ("stretch level", "m2", "f8"),
    "slow_motion/map_position": ("map_position", "1", "i8"),
    "slow_motion/along": ("along", "m", "f8"),
    "slow_motion/across": ("across", "m", "f8"),
    "slow_motion/pressure": ("map_position along across", "Pa", "u1"),
    "slow_motion/release": ("map_position along across", "J", "u2"),
    "force_law/load": ("load", "N", "f8"),
    "force_law/place": ("place", "m", "f8"),
    "force_law/approach": ("load place", "m", "f8"),
    "force_law/judging_load": ("judging_load", "N", "f8"),
    "force_law/judging_approach": ("judging_load judging_place", "m", "f8"),
    "moving_release/place": ("place", "m", "f8"),
    "moving_release/force": ("place", "N", "f8"),
    "moving_release/approach": ("place", "m", "f8"),
    "moving_release/motion_approach": ("place", "m", "f8"),
    "moving_release/release_energy": ("place_step", "J", "f8"),
    "moving_release/loading_energy": ("place_step", "J", "f8"),
    "moving_release/energy_defect": ("place_step", "J", "f8"),
    "contact_force/force_time": ("force_time", "s", "f8"),
    "contact_force/force": ("force_time", "N", "f8"),
    "contact_force/band": ("band", "Hz", "f8"),
    "contact_force/band_rms": ("band", "N", "f8"),
    "sound/sound_time": ("sound_time", "s", "f8"),
    "sound/pressure": ("sound_time", "Pa", "f8"),
}
_COORDINATES = ("time", "position_time")  # beside the values of the dimensions
_PACKED = ("u1", "u2")  # maps, mostly of unloaded cells


def write_result(run: Run) -> bytes:
    """Return the bytes of result.h5, which are equal for equal runs."""
    nodes = tree(run)
    for node in nodes.subtree:
        for variable in node.to_dataset(inherit=False).variables.values():
            variable.encoding = {"_FillValue": None}
            if variable.dtype.str[1:] in _PACKED:
                variable.encoding |= {"zlib": True, "complevel": 1, "shuffle": True}
    content = bytes(nodes.to_netcdf(engine="h5netcdf"))
    return content + _seal(content)


def tree(run: Run) -> xarray.DataTree:
    """Return the content of result.h5 as a tree of named arrays with units."""
    import xarray  # slow to import, for whole runs only

    arrays, attributes = _content(run)
    groups: dict[str, Any] = {}
    for path, values in arrays.items():
        group, _, name = path.rpartition("/")
        dimensions, unit, kind = TABLE[path]
        variable = xarray.Variable(dimensions.split(), values.astype(kind), {"units": unit})
        groups.setdefault(group, {})[name] = variable
    datasets = {
        f"/{group}": xarray.Dataset(variables, attrs=attributes.get(group, {})).set_coords(
            [name for name in _COORDINATES if name in variables]
        )
        for group, variables in groups.items()
    }
    for path, unit in attributes.pop("units", {}).items():
        group, _, name = path.rpartition("/")
        datasets[f"/{group}"][name].attrs["scale_factor"] = unit
    return xarray.DataTree.from_dict(datasets)


def read_result(path: Path, scene: Scene) -> Result:
    """Read the result of a scene without a sweep.

    Raises
    ------
    FolderError : the file is missing, has changed since it was written, is of another version, or
        holds the result of another scene.
    """
    content = _sealed(path)
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            _refuse_version(path, file)
            if file.attrs["identity"] != (result := Result.empty(scene)).identity:
                raise FolderError(
                    f"{path}: solved for another scene or surface than that of its folder"
                )
            _refuse_shapes(file, result, len(content))
        arrays, attributes = _read(content)
        _fill(result, scene, arrays, attributes)
    except FolderError:
        raise
    except Exception as error:  # h5py and xarray raise errors of any kind on hostile files
        text = " ".join(str(error).split()) or type(error).__name__
        raise FolderError(f"{path}: not a result of this program ({text})") from error
    return result


def read_scene(path: Path) -> Scene:
    """Read the scene that a result.h5 was solved for.

    Raises
    ------
    FolderError : the file is missing, has changed since it was written, or is of another version.
    SceneError : its scene is not valid.
    """
    content = _sealed(path)
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            _refuse_version(path, file)
            text = str(file.attrs["scene"])
    except FolderError:
        raise
    except Exception as error:
        raise FolderError(f"{path}: not a result of this program ({error})") from error
    return scene_file.loads(text, [], str(path), path.parent)


# ---- refusals


def _seal(content: bytes | memoryview) -> bytes:
    """Return the last line of a file."""
    return _SEAL + hashlib.sha256(content).hexdigest().encode() + b"\n"


def _sealed(path: Path) -> bytes:
    """Read the bytes of a file whose digest holds."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FolderError(f"{path}: not readable ({error.strerror})") from error
    if content[-_SEAL_LENGTH:] != _seal(memoryview(content)[:-_SEAL_LENGTH]):
        raise FolderError(
            f"{path}: damaged, or of version 0.1.0: its SHA-256 does not hold (delete the file, and"
            " the same command solves it again)"
        )
    return content


def _refuse_version(path: Path, file: h5py.File) -> None:
    """Refuse a file of another format."""
    if (own := file.attrs.get("format")) != FORMAT:
        program = file.attrs.get("program", "unknown")
        raise FolderError(
            f"{path}: format {own} of version {program}, which reads it; this version reads format"
            f" {FORMAT}"
        )


def _refuse_shapes(file: h5py.File, result: Result, size: int) -> None:
    """Refuse arrays that the table or the scene does not know, or that are too large for a file."""
    steps, solved = result.steps, result.solved_steps
    fixed = {"step": steps, "position": steps + 1, "place": solved + 1, "place_step": solved}
    fixed |= {"axis": 2, "level": len(LEVELS), "band": len(MID_HZ)}
    lengths: dict[tuple[str, str], int] = {("", name): count for name, count in fixed.items()}
    total = 0
    names = {name for dimensions, _, _ in TABLE.values() for name in dimensions.split()}
    for path, data in _datasets(file):
        group, _, name = path.rpartition("/")
        total += data.size * data.dtype.itemsize
        dimensions, _, kind = TABLE.get(path, (name, "", "f4"))
        shown = f"{path}: {data.dtype} of shape {data.shape}"
        if name not in names and path not in TABLE:
            raise FolderError(f"{path}: unknown")
        if data.dtype.kind + str(data.dtype.itemsize) != kind or data.external or data.is_virtual:
            raise FolderError(shown)
        for dimension, length in zip(dimensions.split(), data.shape, strict=True):
            key = ("" if dimension in fixed else group, dimension)
            if lengths.setdefault(key, length) != length:
                raise FolderError(f"{shown}, {dimension} has {lengths[key]}")
    if total > _LARGEST * size:
        raise FolderError(f"arrays of {total} bytes in a file of {size} bytes")


def _datasets(file: h5py.File) -> Iterator[tuple[str, h5py.Dataset]]:
    """Return all arrays of a file, whose groups hold arrays alone and no links elsewhere."""
    for group in (file, *(thing for thing in file.values() if isinstance(thing, h5py.Group))):
        for name in group:
            path = f"{group.name}/{name}".lstrip("/")
            is_hard = isinstance(group.get(name, getlink=True), h5py.HardLink)
            if is_hard and isinstance(group[name], h5py.Dataset):
                yield path, group[name]
            elif not (is_hard and group is file and isinstance(group[name], h5py.Group)):
                raise FolderError(f"{path}: neither an array nor a group of arrays")
