"""Archives as files of HDF5 and as trees of xarray."""

from __future__ import annotations

import io
import itertools
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import h5py
import numpy as np
from numpy.typing import NDArray

from rolling.archive.definition import (
    LETTER,
    LETTERS,
    Archive,
    ArchiveDefinition,
    ArchiveGroup,
    GroupDefinition,
    Variable,
)

if TYPE_CHECKING:
    import xarray

_MIN_COMPRESSED = 10_000  # bytes of an array; the index of the chunks of a smaller one is too large
_PROPERTIES = f"version=2,h5py={h5py.__version__},hdf5={h5py.version.hdf5_version}"


class StoredDimension(NamedTuple):
    """The number of a dimension in its file, and its length."""

    number: int
    length: int


def hdf5_bytes(definition: ArchiveDefinition, archive: Archive) -> bytes:
    """Return the bytes of an archive; equal archives have equal arrays and attributes in it.

    The file is one of netCDF 4, written by h5py: h5netcdf looks all dimensions up again for each
    array, which took longer than all else that writes a short run.

    Raises
    ------
    KeyError : the archive has a group, an array or an attribute that is not defined.
    """
    stream = io.BytesIO()
    numbers = itertools.count()  # of dimensions, over all groups
    with h5py.File(stream, "w", track_order=True) as file:
        for name, group in archive.items():
            place = file.create_group(name, track_order=True) if name else file
            if not name:
                _set_attributes(place, _marks(definition))
            _write_group(place, definition.groups[name], group, numbers)
        file.attrs["_NCProperties"] = np.bytes_(_PROPERTIES)
    return stream.getvalue()


def to_xarray(definition: ArchiveDefinition, archive: Archive) -> xarray.DataTree:
    """Return an archive as a tree of named arrays with units, as xarray reads it from its file."""
    import xarray  # slow to import

    content = io.BytesIO(hdf5_bytes(definition, archive))
    return xarray.open_datatree(content, engine="h5netcdf").load()


def _marks(definition: ArchiveDefinition) -> dict[str, Any]:
    """Return the attributes of the root by which a file is known."""
    marks: dict[str, Any] = {"format": definition.format}
    if definition.kind:
        marks["kind"] = definition.kind
    return marks


def _set_attributes(place: h5py.Group | h5py.Dataset, values: Mapping[str, Any]) -> None:
    """Set attributes; netCDF has numbers as arrays."""
    for name, value in values.items():
        place.attrs[name] = value if isinstance(value, str) else np.atleast_1d(value)


def _write_group(
    place: h5py.Group, definition: GroupDefinition, group: ArchiveGroup, numbers: Iterator[int]
) -> None:
    """Write the attributes and arrays of a group."""
    attributes = {
        name: definition.attributes[name](value) for name, value in group.attributes.items()
    }
    _set_attributes(place, attributes)
    variables = [definition.by_name[name] for name in group.arrays]
    scales: dict[str, StoredDimension] = {}  # of dimensions, whether an array has their name or not
    written: dict[str, h5py.Dataset] = {}
    for variable in variables:
        stored = _stored(variable, group.arrays[variable.name])
        axes = _axes_of(variable)
        for axis, length in zip(axes, stored.shape, strict=True):
            if axis not in scales:
                scales[axis] = StoredDimension(next(numbers), length)
        written[variable.name] = _write_array(place, variable.name, stored)
        beside = {} if variable.is_coordinate else _auxiliary(definition, variable, axes, group)
        _set_attributes(written[variable.name], _attributes_of(variable, group) | beside)
    for axis, scale in scales.items():
        dataset = written.get(axis)
        name = axis
        if dataset is None:
            dataset = _write_array(place, axis, np.zeros(scale.length, dtype=">f4"))
            name = f"This is a netCDF dimension but not a netCDF variable.{scale.length:10d}"
        dataset.make_scale(name)
        dataset.attrs["_Netcdf4Dimid"] = np.int32(scale.number)
    for variable in variables:
        axes = _axes_of(variable)
        if not axes:
            continue
        dataset = written[variable.name]
        of_axes = [scales[axis].number for axis in axes]
        dataset.attrs["_Netcdf4Coordinates"] = np.array(of_axes, dtype=np.int32)
        if variable.name in scales:
            continue
        dataset.attrs["_Netcdf4Dimid"] = np.int32(of_axes[0])
        for number, axis in enumerate(axes):
            dataset.dims[number].attach_scale(place[axis])


def _axes_of(variable: Variable) -> tuple[str, ...]:
    """Return the dimensions of an array in the file; texts have one more."""
    return (*variable.axes, LETTER) if variable.dtype == LETTERS else tuple(variable.axes)


def _stored(variable: Variable, values: NDArray[Any]) -> NDArray[Any]:
    """Return an array as the file has it."""
    stored = values.astype(variable.dtype)
    return stored[..., np.newaxis] if variable.dtype == LETTERS else stored


def _write_array(place: h5py.Group, name: str, stored: NDArray[Any]) -> h5py.Dataset:
    """Write an array without attributes; a dimension without a length may grow, as in netCDF."""
    storage: dict[str, Any] = {}
    if stored.nbytes >= _MIN_COMPRESSED:
        storage = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
    if 0 in stored.shape:
        storage["maxshape"] = tuple(length or None for length in stored.shape)
    return place.create_dataset(name, data=stored, track_order=True, **storage)


def _attributes_of(variable: Variable, group: ArchiveGroup) -> dict[str, Any]:
    """Return the unit and the meaning of an array, and how readers get its values."""
    attributes: dict[str, Any] = {"units": variable.unit, "long_name": variable.long_name}
    if variable.dtype == LETTERS:
        attributes["_Encoding"] = "utf-8"  # so that readers of netCDF show texts
    if variable.scale_factor:
        attributes["scale_factor"] = group.attributes[variable.scale_factor]
    return attributes


def _auxiliary(
    definition: GroupDefinition, variable: Variable, axes: tuple[str, ...], group: ArchiveGroup
) -> dict[str, str]:
    """Return the attribute that names the coordinates beside an array, if there are any."""
    beside = [
        other.name
        for other in definition.variables
        if other.is_auxiliary and other.name in group.arrays and {*other.axes} <= {*axes}
    ]
    return {"coordinates": " ".join(beside)} if beside else {}
