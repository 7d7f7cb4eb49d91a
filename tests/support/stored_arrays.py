"""The arrays and attributes of files of results, which equal runs have in common."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, NamedTuple

import h5netcdf
import numpy as np


class StoredArray(NamedTuple):
    """An array of a file: its dimensions, type, shape, bytes and attributes."""

    dimensions: tuple[str, ...]
    dtype: str
    shape: tuple[int, ...]
    content: bytes
    attributes: dict[str, Any]


class StoredPart(NamedTuple):
    """A group of a file: its arrays and attributes by name."""

    arrays: dict[str, StoredArray]
    attributes: dict[str, Any]


def content_of(path: Path) -> Any:
    """Return the arrays of a file of results, and the bytes of any other file."""
    return stored_arrays(path) if path.suffix == ".h5" else path.read_bytes()


def stored_arrays(content: Path | bytes) -> dict[str, StoredPart]:
    """Return the groups of a file of HDF5, or of its bytes, by name; the root has an empty one."""
    source = io.BytesIO(content) if isinstance(content, bytes) else content
    with h5netcdf.File(source, "r") as file:
        return {name.strip("/"): _part(group) for name, group in _groups(file)}


def _groups(group: h5netcdf.Group) -> list[tuple[str, h5netcdf.Group]]:
    """Return a group and all groups below it with their names."""
    below = [pair for inner in group.groups.values() for pair in _groups(inner)]
    return [(group.name, group), *below]


def _part(group: h5netcdf.Group) -> StoredPart:
    """Return the arrays and attributes of a group."""
    arrays = {}
    for name, variable in group.variables.items():
        values = np.asarray(variable[...])
        arrays[name] = StoredArray(
            dimensions=variable.dimensions,
            dtype=values.dtype.str,
            shape=values.shape,
            content=values.tobytes(),
            attributes={key: str(value) for key, value in variable.attrs.items()},
        )
    return StoredPart(arrays, {key: str(value) for key, value in group.attrs.items()})
