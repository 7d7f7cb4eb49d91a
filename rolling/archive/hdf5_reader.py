"""Files of HDF5 of this program: what a file states is judged before a value is read.

An HDF5 file may take values from other files, by links, external storage or virtual data sets, and
a small one may state arrays and texts of any size. A file of this program holds known arrays, of
known types and lengths, in the file itself. Their values are unpacked here, so that no chunk
becomes larger than it says, and the library reads no values but those of short texts.
"""

from __future__ import annotations

import io
import itertools
import math
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

import h5py
import numpy as np
from numpy.typing import NDArray

from rolling.archive.definition import (
    LETTER,
    LETTERS,
    ROOT,
    TEXT,
    ArchiveGroup,
    Attribute,
    GroupDefinition,
    Variable,
)
from rolling.terminal import addresses
from rolling.terminal.whole_files import FolderError

SIGNATURE = b"\x89HDF\r\n\x1a\n"
FILTERS = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE}
LIBRARY = 100_000_000  # bytes that the library may take beside the values
_MIN_CHUNK = 512  # bytes of a chunk on average; more chunks would take long
_MAX_TEXTS = 10_000  # of an array of texts
_MAX_TEXT = 1000  # bytes of each of them
_CLASSES: dict[type[Attribute], tuple[int, ...]] = {
    str: (h5py.h5t.STRING,),
    int: (h5py.h5t.INTEGER,),
    float: (h5py.h5t.FLOAT, h5py.h5t.INTEGER),
}
AttributeTypes = Mapping[str, type[Attribute]]


@contextmanager
def reading(content: bytes, most_bytes: int) -> Iterator[JudgedFile]:
    """Open the bytes of a file whose arrays may take so many bytes together.

    Raises
    ------
    ValueError
        The content is no HDF5 file, or breaks a rule when something is read. Errors of the HDF5
        library on hostile files are of this type, too.
    """
    if not content.startswith(SIGNATURE):
        raise ValueError("no HDF5 file")
    try:
        with (
            addresses.at_most(most_bytes + LIBRARY),
            h5py.File(io.BytesIO(content), "r") as file,
        ):
            yield JudgedFile(content=content, file=file, most_bytes=most_bytes)
    except (ValueError, FolderError):
        raise
    except Exception as error:  # h5py raises errors of any kind on hostile files
        text = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(text) from error


class JudgedFile(NamedTuple):
    """An open file of this program, of which nothing is read before it is judged."""

    content: bytes
    file: h5py.File
    most_bytes: int

    def attributes(self, types: AttributeTypes) -> dict[str, Attribute]:
        """Read those attributes of the root that have a type, each a text or a number."""
        return _attributes(self.file, types)

    def groups(
        self, definitions: Mapping[str, GroupDefinition], lengths: Mapping[str, int]
    ) -> dict[str, ArchiveGroup]:
        """Return the groups of the file, whose arrays are read after all of them are judged.

        Parameters
        ----------
        definitions : mapping
            Definition of each group that the file may have, by its name, with that of the root.
        lengths : mapping
            Lengths of dimensions that are known. Others have one length within a group.

        Raises
        ------
        ValueError
            The first error, with its path.
        """
        nodes = _known_nodes(self.file, definitions)
        _refuse_declarations(nodes, definitions, lengths, self.most_bytes)
        groups = {}
        for group_name, node in nodes.items():
            definition = definitions[group_name]
            arrays = {}
            for name, data in node.arrays.items():
                if name in definition.by_name:
                    arrays[name] = self._values(data, definition.by_name[name])
            attributes = _attributes(node.group, definition.attributes)
            groups[group_name] = ArchiveGroup(arrays, attributes)
        return groups

    def _values(self, data: h5py.Dataset, variable: Variable) -> NDArray[Any]:
        """Read the values of an array that is judged."""
        if variable.dtype == TEXT:
            return _texts(data)
        if not data.size:
            values = np.zeros(data.shape, variable.dtype)
        elif data.chunks is not None:
            values = _values_of_chunks(self.content, data)
        elif data.id.get_create_plist().get_layout() == h5py.h5d.COMPACT:
            values = data[()]
        else:
            start = data.id.get_offset()
            if start is None:
                raise ValueError(f"{data.name}: its values are not in the file")
            values = _numbers(self.content[start : start + data.nbytes], data, data.shape)
        if variable.dtype == LETTERS:
            return values[..., 0].astype(str)
        return values.astype(variable.dtype)


class _Node(NamedTuple):
    """A group of a file, and its arrays by name, which are not read yet."""

    group: h5py.Group
    arrays: dict[str, h5py.Dataset]


def _known_nodes(file: h5py.File, definitions: Mapping[str, GroupDefinition]) -> dict[str, _Node]:
    """Return the root and the groups of a file by name, with their arrays.

    Raises
    ------
    ValueError : a link leads elsewhere, or an array or a group is not defined.
    """
    nodes = {ROOT: _Node(file, {})}
    dimensions = {
        dimension
        for definition in definitions.values()
        for variable in definition.variables
        for dimension in _stored_axes(variable)
    }
    for name in file:
        inner = _linked_object(file, name)
        if isinstance(inner, h5py.Group) and name in definitions:
            nodes[name] = _Node(inner, {})
    for group_name, node in nodes.items():
        for name in node.group:
            if not group_name and name in nodes:
                continue
            inner = _linked_object(node.group, name)
            is_known = name in definitions[group_name].by_name or name in dimensions
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


def _refuse_declarations(
    nodes: Mapping[str, _Node],
    definitions: Mapping[str, GroupDefinition],
    lengths: Mapping[str, int],
    most_bytes: int,
) -> None:
    """Refuse types, storages and lengths that are not defined, and too many bytes."""
    total = 0
    for group_name, node in nodes.items():
        variables = definitions[group_name].by_name
        own_lengths = dict(lengths)
        for name, data in node.arrays.items():
            path = f"{group_name}/{name}".lstrip("/")
            # A dimension without values is an array that is never read.
            variable = variables.get(name, Variable(name, name, "1", "f4", "a dimension"))
            if not _is_of_type(data, variable.dtype) or not _is_stored_by_this_program(data):
                raise ValueError(
                    f"{path}: got {data.dtype} or another storage, allowed: {variable.dtype}"
                )
            shape = data.shape
            if variable.dtype == LETTERS:
                if shape[-1:] != (1,):
                    raise ValueError(f"{path}: got texts, allowed: single letters")
                shape = shape[:-1]
            variable.refuse_shape(shape, own_lengths, path)
            total += math.prod(data.shape) * data.dtype.itemsize
    if total > most_bytes:
        raise ValueError(f"arrays of {total} bytes, allowed for this scene: {most_bytes}")


def _stored_axes(variable: Variable) -> tuple[str, ...]:
    """Return the names of the dimensions of an array in a file, where letters have one more."""
    return (*variable.axes, LETTER) if variable.dtype == LETTERS else variable.axes


def _is_of_type(data: h5py.Dataset, dtype: str) -> bool:
    """Return whether an array has a type, in any byte order."""
    if dtype == TEXT:
        kind = data.id.get_type()
        is_text = isinstance(kind, h5py.h5t.TypeStringID) and kind.is_variable_str()
        return is_text and data.size <= _MAX_TEXTS and data.chunks is None
    return bool(data.dtype.str[1:] == dtype)


def _is_stored_by_this_program(data: h5py.Dataset) -> bool:
    """Return whether an array lies in the file, in chunks no larger than it, by known filters."""
    chunks = data.chunks or data.shape
    return (
        not takes_values_from_elsewhere(data)
        and set(filters_of(data)) <= FILTERS
        and (not data.size or bool(np.less_equal(chunks, data.shape).all()))
    )


def takes_values_from_elsewhere(data: h5py.Dataset) -> bool:
    """Return whether the values of an array lie in other files, or in other arrays."""
    return bool(data.is_virtual or data.external)


def filters_of(data: h5py.Dataset) -> list[int]:
    """Return the filters of an array, in the order in which they were used for writing."""
    creation = data.id.get_create_plist()
    return [creation.get_filter(k)[0] for k in range(creation.get_nfilters())]


# ---- values


def _values_of_chunks(content: bytes, data: h5py.Dataset) -> NDArray[Any]:
    """Unpack the values of an array that is stored in chunks.

    Raises
    ------
    ValueError : a chunk is missing, lies outside of the file, or has another size than it says.
    """
    counts = [math.ceil(n / chunk) for n, chunk in zip(data.shape, data.chunks, strict=True)]
    if math.prod(counts) > 1 + data.nbytes / _MIN_CHUNK:
        raise ValueError(f"{data.name}: {math.prod(counts)} chunks are too many for its size")
    filters = filters_of(data)
    values = np.empty(data.shape, data.dtype)
    for place in itertools.product(*map(range, counts)):
        start = tuple(k * chunk for k, chunk in zip(place, data.chunks, strict=True))
        stored = data.id.get_chunk_info_by_coord(start)
        if stored.byte_offset is None:
            raise ValueError(f"{data.name}: its values are not all in the file")
        packed = content[stored.byte_offset : stored.byte_offset + stored.size]
        unpacked = _unpacked(packed, data, filters, stored.filter_mask)
        chunk = _numbers(unpacked, data, data.chunks)
        place_of_chunk = tuple(
            slice(first, first + length) for first, length in zip(start, data.chunks, strict=True)
        )
        inside = values[place_of_chunk]  # the last chunks reach beyond the array
        inside[...] = chunk[tuple(map(slice, inside.shape))]
    return values


def _unpacked(packed: bytes, data: h5py.Dataset, filters: list[int], mask: int) -> bytes:
    """Undo the filters of a chunk, of which the mask names those that were not used."""
    size = math.prod(data.chunks) * data.dtype.itemsize
    for number in reversed(range(len(filters))):
        if mask >> number & 1:
            continue
        if filters[number] == h5py.h5z.FILTER_DEFLATE:
            packed = zlib.decompressobj().decompress(packed, size + 1)
        elif len(packed) == size:
            rows = np.frombuffer(packed, np.uint8).reshape(data.dtype.itemsize, -1)
            packed = rows.T.tobytes()
    return packed


def _numbers(raw: bytes, data: h5py.Dataset, shape: tuple[int, ...]) -> NDArray[Any]:
    """Return bytes of a file as numbers of an array."""
    if len(raw) != math.prod(shape) * data.dtype.itemsize:
        raise ValueError(f"{data.name}: a part of its values has another size than it says")
    return np.frombuffer(raw, data.dtype).reshape(shape)


def _texts(data: h5py.Dataset) -> NDArray[Any]:
    """Read short texts, one by one."""
    texts = np.empty(data.shape, dtype=object)
    for place in np.ndindex(data.shape):
        text = bytes(data[place])
        if len(text) > _MAX_TEXT:
            raise ValueError(f"{data.name}: a text of more than {_MAX_TEXT} bytes")
        texts[place] = text.decode()
    return texts.astype(str)


def _attributes(group: h5py.Group, types: AttributeTypes) -> dict[str, Attribute]:
    """Read those attributes of a group that have a type, each a text or a number."""
    attributes: dict[str, Attribute] = {}
    for name, kind in types.items():
        if name not in group.attrs:
            continue
        stored = group.attrs.get_id(name)
        is_known = stored.get_type().get_class() in _CLASSES[kind]
        if not is_known or math.prod(stored.shape) != 1:  # many texts may share their bytes
            raise ValueError(f"{group.name}: attribute {name}: not one text or number")
        value = group.attrs[name]
        attributes[name] = kind(value if isinstance(value, str) else np.asarray(value).item())
    return attributes
