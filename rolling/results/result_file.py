"""The file result.h5: a tree of named arrays with dimensions and units, and a digest at its end.

HDF5 does not look beyond its own end, so its readers do not notice the last line, a SHA-256 of all
bytes before it. A damaged file is refused before the HDF5 library, which damage could crash, opens
it. A digest is no signature: names, types and shapes are compared with the scene before any array
is read.
"""

from __future__ import annotations

import hashlib
import io
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from rolling.marches.result import Result
from rolling.results.result_arrays import FORMAT, TABLE, Group, fill, fixed_lengths, groups_of
from rolling.scene.scene import Scene
from rolling.terminal.files import FolderError

if TYPE_CHECKING:
    import xarray

    from rolling.results.run_result import Run

_SEAL = b"\nrolling-contact-noise result.h5, SHA-256 of all bytes before this line: "
_SEAL_LENGTH = len(_SEAL) + 65  # with the digest and the end of the line
_LARGEST = 200  # bytes of all arrays per byte of a file: maps compress well, series hardly
_COORDINATES = ("time", "position_time")  # beside the values of the dimensions


def write_result(run: Run) -> bytes:
    """Return the bytes of result.h5, which are equal for equal runs."""
    import xarray  # slow to import, for whole runs only

    nodes = {}
    for group, (arrays, facts) in groups_of(run).items():
        variables = {}
        for name, values in arrays.items():
            dimensions, unit, kind = TABLE[f"{group}/{name}".lstrip("/")]
            encoding: dict[str, Any] = {"_FillValue": None}
            if values.size and kind != "f8":  # maps and whole numbers
                encoding |= {"zlib": True, "complevel": 1, "shuffle": True}
            attributes = {"units": unit}
            if kind[0] == "u":  # whole numbers of a unit
                attributes["scale_factor"] = facts[f"{name}_unit"]
            variables[name] = xarray.Variable(
                dimensions.split(), values.astype(kind), attributes, encoding
            )
        beside = [name for name in _COORDINATES if name in variables]
        nodes[f"/{group}"] = xarray.Dataset(variables, attrs=facts).set_coords(beside)
    content = bytes(xarray.DataTree.from_dict(nodes).to_netcdf(engine="h5netcdf"))
    return content + _seal(content)


def tree(run: Run) -> xarray.DataTree:
    """Return the content of result.h5 as a tree of named arrays with units."""
    import xarray

    return xarray.open_datatree(io.BytesIO(write_result(run)), engine="h5netcdf").load()


def read_result(path: Path, scene: Scene) -> Result:
    """Read the result of a scene without a sweep.

    Raises
    ------
    FolderError : the file is missing, has changed since it was written, is of another version, or
        holds the result of another scene or surface.
    """
    import xarray

    content, result = _sealed(path), Result.empty(scene)
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            _refuse_version(path, file)
            if file.attrs["identity"] != result.identity:
                raise FolderError(f"{path}: solved for another scene or surface")
            _refuse_shapes(file, result, len(content))
        source = io.BytesIO(content)
        with xarray.open_datatree(source, engine="h5netcdf", decode_cf=False) as nodes:
            groups: dict[str, Group] = {}
            for node in nodes.subtree:
                data = node.to_dataset(inherit=False)
                arrays = {str(name): values.values for name, values in data.variables.items()}
                facts = {name: _plain(value) for name, value in data.attrs.items()}
                groups[node.path.strip("/")] = arrays, facts
        fill(result, groups)
    except FolderError:
        raise
    except Exception as error:  # h5py and xarray raise errors of any kind on hostile files
        text = " ".join(str(error).split()) or type(error).__name__
        raise FolderError(f"{path}: not a result of this program ({text})") from error
    return result


def _plain(value: Any) -> Any:
    """Return an attribute as a plain text or number."""
    return value if isinstance(value, str) else np.asarray(value).item()


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
    own = _plain(file.attrs.get("format", 1))
    if own != FORMAT:
        program = file.attrs.get("program", "0.1.0")
        raise FolderError(
            f"{path}: format {own}, which version {program} of the program reads; this version"
            f" reads format {FORMAT}"
        )


def _refuse_shapes(file: h5py.File, result: Result, size: int) -> None:
    """Refuse arrays that the table or the scene does not know, or that are too large for a file.

    Raises
    ------
    ValueError : the first fault, with its path.
    """
    fixed = fixed_lengths(result)
    names = {name for dimensions, _, _ in TABLE.values() for name in dimensions.split()}
    lengths = {("", name): length for name, length in fixed.items()}
    total = 0
    for path, data in _datasets(file):
        group, _, name = path.rpartition("/")
        if path not in TABLE and name not in names:
            raise ValueError(f"{path}: unknown")
        dimensions, _, kind = TABLE.get(path, (name, "", "f4"))  # a dimension without values
        if data.dtype.str[1:] != kind or data.is_virtual or data.external:
            raise ValueError(f"{path}: got {data.dtype} or another file, allowed: {kind}")
        for dimension, length in zip(dimensions.split(), data.shape, strict=True):
            key = ("" if dimension in fixed else group, dimension)
            if lengths.setdefault(key, length) != length:
                raise ValueError(f"{path}: got {length} along {dimension}, allowed: {lengths[key]}")
        total += math.prod(data.shape) * data.dtype.itemsize
    if total > _LARGEST * size:
        raise ValueError(f"arrays of {total} bytes in a file of {size} bytes")


def _datasets(file: h5py.File) -> Iterator[tuple[str, h5py.Dataset]]:
    """Return all arrays of a file, whose groups hold nothing but arrays, and no links elsewhere."""
    groups = [file]
    for group in groups:  # which grows
        for name in group:
            path = f"{group.name}/{name}".lstrip("/")
            linked = isinstance(group.get(name, getlink=True), h5py.HardLink)
            node = group[name] if linked else None
            if isinstance(node, h5py.Group) and group is file and "/" not in path:
                groups.append(node)
            elif isinstance(node, h5py.Dataset):
                yield path, node
            else:
                raise ValueError(f"{path}: neither an array nor a group of arrays")
