"""The file result.h5: a tree of named arrays with dimensions and units, and a digest at its end.

HDF5 does not look beyond its own end, so its readers do not notice the last line, a SHA-256 of all
bytes before it. A damaged file is refused before the HDF5 library, which damage could crash, opens
it. The digest has no key, so it protects from damage and not from strangers: names, types and
shapes are compared with the definition and with the scene before any array is read.
"""

from __future__ import annotations

import hashlib
import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rolling.check import cost
from rolling.marches.result import Result
from rolling.results.result_arrays import (
    COORDINATES,
    DEFINITION,
    FORMAT,
    FileGroup,
    fill_result,
    fixed_lengths,
    groups_of,
)
from rolling.results.solved_run import SolvedRun
from rolling.scene import hdf5_files
from rolling.scene.hdf5_files import ArrayRule
from rolling.scene.scene import Scene
from rolling.terminal.files import FolderError, read_regular

if TYPE_CHECKING:
    import h5netcdf
    import xarray

_SEAL = b"\nrolling-contact-noise result.h5, SHA-256 of all bytes before this line: "
_SEAL_LENGTH = len(_SEAL) + 65  # with the digest and the end of the line
_MIN_COMPRESSED = 10_000  # bytes of an array; the index of the chunks of a smaller one is too large
# The file, and all its arrays together, take at most so many times the disk that is estimated for
# the scene, and so many bytes more.
_MAX_TIMES = 5
_MAX_BESIDE = 100_000_000
_RULES = {
    group: {
        name: ArrayRule(tuple(variable.dimensions.split()), variable.dtype)
        for name, variable in variables.items()
    }
    for group, variables in DEFINITION.items()
}


# ---- write


def write_result(run: SolvedRun) -> bytes:
    """Return the bytes of result.h5, which are equal for equal runs."""
    stream = io.BytesIO()
    with hdf5_files.new_file(stream) as file:
        for name, group in groups_of(run).items():
            _write_group(file.create_group(name) if name else file, name, group)
    content = stream.getvalue()
    return content + seal(content)


def result_tree(run: SolvedRun) -> xarray.DataTree:
    """Return the content of result.h5 as a tree of named arrays with units."""
    return hdf5_files.tree_of(write_result(run))


def _write_group(place: h5netcdf.Group, name: str, group: FileGroup) -> None:
    """Write the attributes and arrays of a group, each with its unit and its meaning."""
    place.attrs.update(group.attributes)
    for array_name, values in group.arrays.items():
        definition = DEFINITION[name][array_name]
        dimensions = definition.dimensions.split()
        for dimension, length in zip(dimensions, values.shape, strict=True):
            if dimension not in place.dimensions:
                place.dimensions[dimension] = length
        stored = values.astype(definition.dtype)
        storage: dict[str, Any] = {}
        if stored.nbytes >= _MIN_COMPRESSED:
            storage = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
        variable = place.create_variable(
            array_name, tuple(dimensions), stored.dtype, data=stored, **storage
        )
        variable.attrs["units"] = definition.unit
        variable.attrs["long_name"] = definition.long_name
        if array_name in group.scale_factors:
            variable.attrs["scale_factor"] = group.scale_factors[array_name]
        if array_name in dimensions or array_name in COORDINATES:
            continue
        beside = [
            coordinate
            for coordinate in COORDINATES
            if coordinate in group.arrays and DEFINITION[name][coordinate].dimensions in dimensions
        ]
        if beside:
            variable.attrs["coordinates"] = " ".join(beside)


# ---- read


def read_result(path: Path, scene: Scene) -> Result:
    """Read the result of a scene without a sweep.

    Raises
    ------
    FolderError : the file is missing, has changed since it was written, is of another version, or
        holds the result of another scene or surface.
    """
    result = Result.empty(scene)
    most_bytes = largest_size(cost.disk([scene]))
    content = sealed_content(path, most_bytes)
    try:
        with hdf5_files.reading(content, most_bytes) as file:
            root_attributes = file.attributes()
            _refuse_format(path, root_attributes)
            if root_attributes.get("identity") != result.identity:
                raise FolderError(f"{path}: solved for another scene or surface")
            stored = file.groups(_RULES, fixed_lengths(scene, result))
        fill_result(result, {name: FileGroup(*group) for name, group in stored.items()})
    except FolderError:
        raise
    except Exception as error:  # values of a hostile file lead to errors of any kind
        raise no_result(path, "a result", error) from error
    return result


def largest_size(disk: float) -> int:
    """Return the size [bytes] of a file and of its arrays that is read, by the estimated disk."""
    return round(_MAX_TIMES * disk + _MAX_BESIDE)


def no_result(path: Path, expected: str, error: Exception) -> FolderError:
    """Return the refusal of a file that is not what is expected of this program."""
    text = " ".join(str(error).split()) or type(error).__name__
    return FolderError(f"{path}: not {expected} of this program ({text})")


def seal(content: bytes | memoryview) -> bytes:
    """Return the last line of a file."""
    return _SEAL + hashlib.sha256(content).hexdigest().encode() + b"\n"


def sealed_content(path: Path, most_bytes: int) -> bytes:
    """Read the bytes of a file whose digest holds, and that is not larger than allowed."""
    try:
        content = read_regular(path, most_bytes)
    except OSError as error:
        raise FolderError(f"{path}: not readable ({error.strerror or error})") from error
    if content[-_SEAL_LENGTH:] != seal(memoryview(content)[:-_SEAL_LENGTH]):
        raise FolderError(
            f"{path}: damaged, or of version 0.1.0: its SHA-256 does not hold"
            " (delete the file, and the same command solves it again)"
        )
    return content


def _refuse_format(path: Path, attributes: dict[str, Any]) -> None:
    """Refuse a file of another format."""
    own = attributes.get("format", 1)
    if own != FORMAT:
        program = attributes.get("program", "0.1.0")
        raise FolderError(
            f"{path}: format {own}, which version {program} of the program reads;"
            f" this version reads format {FORMAT}"
        )
