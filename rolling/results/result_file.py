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
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from rolling.check import cost
from rolling.marches.result import Result
from rolling.results import result_arrays
from rolling.results.result_arrays import FORMAT, TABLE, Facts, Group
from rolling.scene.height_files import read_regular
from rolling.scene.scene import Scene
from rolling.terminal.files import FolderError

if TYPE_CHECKING:
    import xarray

    from rolling.results.run_result import Run

_SEAL = b"\nrolling-contact-noise result.h5, SHA-256 of all bytes before this line: "
_SEAL_LENGTH = len(_SEAL) + 65  # with the digest and the end of the line
_LARGEST = 200  # bytes of all arrays per byte of a file: maps compress well, series hardly
_MAX_TIMES, _MAX_BESIDE = 3, 100_000_000  # bytes of a file: the estimate for its scene and more
_COORDINATES = ("time", "position_time")  # beside the values of the dimensions


def write_result(run: Run) -> bytes:
    """Return the bytes of result.h5, which are equal for equal runs."""
    import xarray  # slow to import, for whole runs only

    nodes = {}
    for group, (arrays, facts) in result_arrays.groups_of(run).items():
        variables = {}
        for name, values in arrays.items():
            dimensions, unit, kind = TABLE[f"{group}/{name}".lstrip("/")]
            encoding: dict[str, Any] = {"_FillValue": None}
            if values.size and kind != "f8":  # maps and whole numbers
                encoding |= {"zlib": True, "complevel": 1, "shuffle": True}
            attributes = {"units": unit}
            if kind[0] == "u":  # whole numbers of a unit
                attributes["scale_factor"] = facts[f"{name}_unit"]
            stored = values.astype(kind)
            variables[name] = xarray.Variable(dimensions.split(), stored, attributes, encoding)
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
    result = Result.empty(scene)
    content = _sealed(path, scene)
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            _refuse_version(path, file)
            if _facts(file).get("identity") != result.identity:
                raise FolderError(f"{path}: solved for another scene or surface")
            arrays = _arrays(file)
            _refuse_shapes(arrays, result, len(content))
            nodes = {name: node for name, node in file.items() if name not in arrays}
            nodes |= {"": file}
            groups: dict[str, Group] = {name: ({}, _facts(node)) for name, node in nodes.items()}
            for place in arrays.keys() & TABLE.keys():
                group, _, name = place.rpartition("/")
                groups[group][0][name] = arrays[place][()]
        result_arrays.fill(result, groups)
    except FolderError:
        raise
    except Exception as error:  # h5py raises errors of any kind on hostile files
        text = " ".join(str(error).split()) or type(error).__name__
        raise FolderError(f"{path}: not a result of this program ({text})") from error
    return result


def _facts(group: h5py.Group) -> Facts:
    """Read the attributes of a group, each a text or a number."""
    facts = {}
    for name in group.attrs:
        if math.prod(group.attrs.get_id(name).shape) != 1:  # a bomb of texts that share their bytes
            raise ValueError(f"{group.name}: attribute {name}: not one text or number")
        value = group.attrs[name]
        facts[name] = value if isinstance(value, str) else np.asarray(value).item()
    return facts


# ---- refusals


def _seal(content: bytes | memoryview) -> bytes:
    """Return the last line of a file."""
    return _SEAL + hashlib.sha256(content).hexdigest().encode() + b"\n"


def _sealed(path: Path, scene: Scene) -> bytes:
    """Read the bytes of a file whose digest holds, and whose size suits its scene."""
    try:
        content = read_regular(path, round(_MAX_TIMES * cost.disk([scene]) + _MAX_BESIDE))
    except OSError as error:
        raise FolderError(f"{path}: not readable ({error.strerror or error})") from error
    if content[-_SEAL_LENGTH:] != _seal(memoryview(content)[:-_SEAL_LENGTH]):
        words = "damaged, or of version 0.1.0: its SHA-256 does not hold"
        advice = "delete the file, and the same command solves it again"
        raise FolderError(f"{path}: {words} ({advice})")
    return content


def _refuse_version(path: Path, file: h5py.File) -> None:
    """Refuse a file of another format."""
    facts = _facts(file)
    own = facts.get("format", 1)
    if own != FORMAT:
        program = facts.get("program", "0.1.0")
        reader = f"which version {program} of the program reads"
        raise FolderError(f"{path}: format {own}, {reader}; this version reads format {FORMAT}")


def _refuse_shapes(arrays: dict[str, h5py.Dataset], result: Result, size: int) -> None:
    """Refuse arrays that the table or the scene does not know, or that are too large for a file.

    Raises
    ------
    ValueError : the first fault, with its path.
    """
    fixed = result_arrays.fixed_lengths(result)
    lengths = {("", name): length for name, length in fixed.items()}
    total = 0
    for path, data in arrays.items():
        group, _, name = path.rpartition("/")
        dimensions, _, kind = TABLE.get(path, (name, "", "f4"))  # a dimension without values
        if data.dtype.str[1:] != kind or not _is_own(data):
            raise ValueError(f"{path}: got {data.dtype} or another storage, allowed: {kind}")
        for dimension, length in zip(dimensions.split(), data.shape, strict=True):
            key = ("" if dimension in fixed else group, dimension)
            if lengths.setdefault(key, length) != length:
                raise ValueError(f"{path}: got {length} along {dimension}, allowed: {lengths[key]}")
        total += math.prod(data.shape) * data.dtype.itemsize
    if total > _LARGEST * size:
        raise ValueError(f"arrays of {total} bytes in a file of {size} bytes")


def _is_own(data: h5py.Dataset) -> bool:
    """Return whether an array is stored as this program stores it."""
    creation, chunks = data.id.get_create_plist(), data.chunks or data.shape
    filters = [creation.get_filter(k)[0] for k in range(creation.get_nfilters())]
    return (
        not (data.is_virtual or data.external)
        and {*filters} <= {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE}
        and (not data.size or np.less_equal(chunks, data.shape).all())
    )


def _arrays(file: h5py.File) -> dict[str, h5py.Dataset]:
    """Return all arrays of a file by path; its groups hold nothing but arrays of the table.

    Raises
    ------
    ValueError : a link leads elsewhere, or an array or a group is unknown.
    """
    known = {name for dimensions, _, _ in TABLE.values() for name in dimensions.split()}
    groups = {path.rpartition("/")[0] for path in TABLE}
    arrays, nodes = {}, [("", file)]
    for group, node in nodes:  # the list grows
        for name in node:
            path = f"{group}/{name}".lstrip("/")
            linked = isinstance(node.get(name, getlink=True), h5py.HardLink)
            inner = node[name] if linked else None
            if isinstance(inner, h5py.Group) and not group and name in groups:
                nodes.append((name, inner))
            elif isinstance(inner, h5py.Dataset) and (path in TABLE or name in known):
                arrays[path] = inner
            else:
                raise ValueError(f"{path}: neither a known array nor a group of arrays")
    return arrays
