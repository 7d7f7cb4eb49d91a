"""Archives as files of HDF5 and as trees of xarray."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import h5netcdf
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


def hdf5_bytes(definition: ArchiveDefinition, archive: Archive) -> bytes:
    """Return the bytes of an archive; equal archives have equal arrays and attributes in it.

    Raises
    ------
    KeyError : the archive has a group, an array or an attribute that is not defined.
    """
    stream = io.BytesIO()
    with h5netcdf.File(stream, "w") as file:
        for name, group in archive.items():
            place = file.create_group(name) if name else file
            if not name:
                place.attrs.update(_marks(definition))
            _write_group(place, definition.groups[name], group)
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


def _write_group(place: h5netcdf.Group, definition: GroupDefinition, group: ArchiveGroup) -> None:
    """Write the attributes and arrays of a group."""
    for name, value in group.attributes.items():
        place.attrs[name] = definition.attributes[name](value)
    for name, values in group.arrays.items():
        _write_array(place, definition, definition.by_name[name], values, group)


def _write_array(
    place: h5netcdf.Group,
    definition: GroupDefinition,
    variable: Variable,
    values: NDArray[Any],
    group: ArchiveGroup,
) -> None:
    """Write an array of a group with its unit, its meaning and its coordinates."""
    axes = variable.axes
    stored = values.astype(variable.dtype)
    if variable.dtype == LETTERS:
        axes = (*axes, LETTER)
        stored = stored[..., np.newaxis]
    for axis, length in zip(axes, stored.shape, strict=True):
        if axis not in place.dimensions:
            place.dimensions[axis] = length
    storage: dict[str, Any] = {}
    if stored.nbytes >= _MIN_COMPRESSED:
        storage = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
    written = place.create_variable(variable.name, axes, stored.dtype, data=stored, **storage)
    written.attrs["units"] = variable.unit
    written.attrs["long_name"] = variable.long_name
    if variable.dtype == LETTERS:
        written.attrs["_Encoding"] = "utf-8"  # so that readers of netCDF show texts
    if variable.scale_factor:
        written.attrs["scale_factor"] = group.attributes[variable.scale_factor]
    if variable.is_coordinate:
        return
    beside = [
        other.name
        for other in definition.variables
        if other.is_auxiliary and other.name in group.arrays and {*other.axes} <= {*axes}
    ]
    if beside:
        written.attrs["coordinates"] = " ".join(beside)
