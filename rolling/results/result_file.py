"""The file result.h5: a tree of named arrays with dimensions and units, and a digest at its end.

HDF5 does not look beyond its own end, so its readers do not notice the last line, a SHA-256 of all
bytes before it. A damaged file is refused before the HDF5 library, which damage could crash, opens
it. A digest is no signature: names, types and shapes are compared with the definition and with the
scene before any array is read.
"""

from __future__ import annotations

import hashlib
import io
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import h5netcdf
import h5py
import numpy as np

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
from rolling.scene.height_files import read_regular
from rolling.scene.scene import Scene
from rolling.terminal.files import FolderError

if TYPE_CHECKING:
    import xarray

_SEAL = b"\nrolling-contact-noise result.h5, SHA-256 of all bytes before this line: "
_SEAL_LENGTH = len(_SEAL) + 65  # with the digest and the end of the line
_MIN_COMPRESSED = 10_000  # bytes of an array; the index of the chunks of a smaller one is too large
# The file, and all its arrays together, take at most so many times the disk that is estimated for
# the scene, and so many bytes more.
_MAX_TIMES = 5
_MAX_BESIDE = 100_000_000
_DIMENSIONS = {
    dimension
    for variables in DEFINITION.values()
    for variable in variables.values()
    for dimension in variable.dimensions.split()
}


# ---- write


def write_result(run: SolvedRun) -> bytes:
    """Return the bytes of result.h5, which are equal for equal runs."""
    stream = io.BytesIO()
    with h5netcdf.File(stream, "w") as file:
        for name, group in groups_of(run).items():
            _write_group(file.create_group(name) if name else file, name, group)
    content = stream.getvalue()
    return content + seal(content)


def result_tree(run: SolvedRun) -> xarray.DataTree:
    """Return the content of result.h5 as a tree of named arrays with units."""
    import xarray

    return xarray.open_datatree(io.BytesIO(write_result(run)), engine="h5netcdf").load()


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
    most_bytes = round(_MAX_TIMES * cost.disk([scene]) + _MAX_BESIDE)
    content = sealed_content(path, most_bytes)
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            root_attributes = _attributes(file)
            _refuse_format(path, root_attributes)
            if root_attributes.get("identity") != result.identity:
                raise FolderError(f"{path}: solved for another scene or surface")
            groups = _bounded_groups(file, fixed_lengths(scene, result), most_bytes)
        fill_result(result, groups)
    except FolderError:
        raise
    except Exception as error:  # h5py raises errors of any kind on hostile files
        text = " ".join(str(error).split()) or type(error).__name__
        raise FolderError(f"{path}: not a result of this program ({text})") from error
    return result


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


# ---- read an HDF5 file of somebody else: nothing is allocated that the scene does not allow


def _bounded_groups(
    file: h5py.File, fixed: dict[str, int], most_bytes: int
) -> dict[str, FileGroup]:
    """Return the groups of a file, whose arrays are read after all declarations are judged.

    Raises
    ------
    ValueError : the first fault, with its path.
    """
    nodes = _known_nodes(file)
    _refuse_declarations(nodes, fixed, most_bytes)
    groups = {}
    for group_name, node in nodes.items():
        arrays = {}
        for name, data in node.arrays.items():
            if name in DEFINITION[group_name]:
                arrays[name] = data[()]
        groups[group_name] = FileGroup(arrays, _attributes(node.group))
    return groups


class _Node(NamedTuple):
    """A group of an HDF5 file, and its arrays by name, which are not read yet."""

    group: h5py.Group
    arrays: dict[str, h5py.Dataset]


def _known_nodes(file: h5py.File) -> dict[str, _Node]:
    """Return the root and the groups of a file by name, with their arrays.

    Raises
    ------
    ValueError : a link leads elsewhere, or an array or a group is not in the definition.
    """
    nodes = {"": _Node(file, {})}
    for name in file:
        inner = _linked_object(file, name)
        if isinstance(inner, h5py.Group) and name in DEFINITION:
            nodes[name] = _Node(inner, {})
    for group_name, node in nodes.items():
        for name in node.group:
            if not group_name and name in nodes:
                continue
            inner = _linked_object(node.group, name)
            is_known = name in DEFINITION[group_name] or name in _DIMENSIONS
            if not isinstance(inner, h5py.Dataset) or not is_known:
                path = f"{group_name}/{name}".lstrip("/")
                raise ValueError(f"{path}: neither a known array nor a group of arrays")
            node.arrays[name] = inner
    return nodes


def _linked_object(group: h5py.Group, name: str) -> h5py.Group | h5py.Dataset | None:
    """Return the object that lies in a group itself; None for a link to another place or file."""
    if isinstance(group.get(name, getlink=True), h5py.HardLink):
        return group[name]
    return None


def _refuse_declarations(nodes: dict[str, _Node], fixed: dict[str, int], most_bytes: int) -> None:
    """Refuse types, storages and lengths that definition and scene do not know, and too many bytes.

    `fixed` are lengths of dimensions that the scene fixes. Other dimensions have one length within
    a group.
    """
    total = 0
    for group_name, node in nodes.items():
        lengths = dict(fixed)
        for name, data in node.arrays.items():
            path = f"{group_name}/{name}".lstrip("/")
            definition = DEFINITION[group_name].get(name)
            dtype = definition.dtype if definition else "f4"  # of a dimension without values
            dimensions = definition.dimensions.split() if definition else [name]
            if data.dtype.str[1:] != dtype or not _is_stored_by_this_program(data):
                raise ValueError(f"{path}: got {data.dtype} or another storage, allowed: {dtype}")
            for dimension, length in zip(dimensions, data.shape, strict=True):
                allowed = lengths.setdefault(dimension, length)
                if length != allowed:
                    raise ValueError(f"{path}: got {length} along {dimension}, allowed: {allowed}")
            total += math.prod(data.shape) * data.dtype.itemsize
    if total > most_bytes:
        raise ValueError(f"arrays of {total} bytes, allowed for this scene: {most_bytes}")


def _is_stored_by_this_program(data: h5py.Dataset) -> bool:
    """Return whether an array lies in the file, in chunks no larger than it, by known filters."""
    creation = data.id.get_create_plist()
    filters = {creation.get_filter(k)[0] for k in range(creation.get_nfilters())}
    chunks = data.chunks or data.shape
    return (
        not data.is_virtual
        and not data.external
        and filters <= {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE}
        and (not data.size or bool(np.less_equal(chunks, data.shape).all()))
    )


def _attributes(group: h5py.Group) -> dict[str, Any]:
    """Read the attributes of a group, each a text or a number."""
    attributes = {}
    for name in group.attrs:
        if math.prod(group.attrs.get_id(name).shape) != 1:  # a bomb of texts that share their bytes
            raise ValueError(f"{group.name}: attribute {name}: not one text or number")
        value = group.attrs[name]
        attributes[name] = value if isinstance(value, str) else np.asarray(value).item()
    return attributes
