"""HDF5 files, which no other module opens: what a file states is judged before a value is read.

An HDF5 file may take values from other files, by links, external storage or virtual data sets, and
a small one may state arrays and texts of any size. A file of this program holds known arrays, of
known types and lengths, in the file itself. Their values are unpacked here, so that no chunk
becomes larger than it says, and the library reads no values but those of short texts.

Files of instruments are read by other packages. They are judged here first.
"""

from __future__ import annotations

import io
import itertools
import math
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import h5netcdf
import h5py
import numpy as np
from numpy.typing import NDArray

from rolling.terminal import addresses
from rolling.terminal.files import FolderError, open_regular

if TYPE_CHECKING:
    import xarray

TEXT = "text"  # type of an array of texts of any length

_PROPERTIES = "_NCProperties"  # attribute with the versions of the packages that wrote a file
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_FIRST_USER_BLOCK = 512  # bytes before the signature: none, or so many times a power of two
_FILTERS = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE}
_FILTERS_OF_INSTRUMENTS = _FILTERS | {h5py.h5z.FILTER_FLETCHER32}
_MIN_CHUNK = 512  # bytes of a chunk on average; more chunks would take long
_MAX_TEXTS = 10_000  # of an array of texts
_MAX_TEXT = 1000  # bytes of each of them
_MAX_OBJECTS = 10_000  # groups, arrays and attributes in a file of an instrument
_LIBRARY = 100_000_000  # bytes that the library may take beside the values
_COPIES = 4  # of the heights that the reader of an instrument's file may hold at once


class ArrayRule(NamedTuple):
    """Type and dimensions that an array of a file must have.

    dimensions : tuple of str. Names of its dimensions.
    dtype : str. Type without byte order, such as f8, or TEXT.
    may_be_single : bool. Whether one value may stand for all, without dimensions.
    """

    dimensions: tuple[str, ...]
    dtype: str
    may_be_single: bool = False


Rules = Mapping[str, Mapping[str, ArrayRule]]  # by group and name; "" is the root
Arrays = dict[str, NDArray[Any]]


class StoredGroup(NamedTuple):
    """Arrays and attributes of a group of a file, by name."""

    arrays: Arrays
    attributes: dict[str, Any]


# ---- write


def new_file(stream: io.BytesIO) -> h5netcdf.File:
    """Begin a file in memory, whose arrays have named dimensions."""
    return h5netcdf.File(stream, "w")


def tree_of(content: bytes) -> xarray.DataTree:
    """Return the arrays of a file that this process has just written."""
    import xarray  # slow to import

    return xarray.open_datatree(io.BytesIO(content), engine="h5netcdf").load()


# ---- read a file of this program that anybody may have changed


@contextmanager
def reading(content: bytes, most_bytes: int) -> Iterator[JudgedFile]:
    """Open the bytes of a file whose arrays may take so many bytes together.

    Raises
    ------
    ValueError
        The content is no HDF5 file, or breaks a rule when something is read. Faults of the HDF5
        library on hostile files are of this type, too.
    """
    if not content.startswith(_SIGNATURE):
        raise ValueError("no HDF5 file")
    try:
        with (
            addresses.at_most(most_bytes + _LIBRARY),
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

    def attributes(self) -> dict[str, Any]:
        """Read the attributes of the file, each a text or a number."""
        return _attributes(self.file)

    def groups(self, rules: Rules, lengths: Mapping[str, int]) -> dict[str, StoredGroup]:
        """Return the groups of the file, whose arrays are read after all of them are judged.

        Parameters
        ----------
        rules : dict
            Type and dimensions of each array that the file may hold, by group and name.
        lengths : dict
            Lengths of dimensions that are known. Others have one length within a group.

        Raises
        ------
        ValueError
            The first fault, with its path.
        """
        nodes = _known_nodes(self.file, rules)
        _refuse_declarations(nodes, rules, lengths, self.most_bytes)
        groups = {}
        for group_name, node in nodes.items():
            arrays = {}
            for name, data in node.arrays.items():
                if name in rules[group_name]:
                    arrays[name] = self._values(data, rules[group_name][name])
            groups[group_name] = StoredGroup(arrays, _attributes(node.group))
        return groups

    def _values(self, data: h5py.Dataset, rule: ArrayRule) -> NDArray[Any]:
        """Read the values of an array that is judged."""
        if rule.dtype == TEXT:
            return _texts(data)
        if not data.size:
            return np.zeros(data.shape, rule.dtype)
        if data.chunks is not None:
            values = _values_of_chunks(self.content, data)
        elif data.id.get_create_plist().get_layout() == h5py.h5d.COMPACT:
            values = data[()]
        else:
            start = data.id.get_offset()
            if start is None:
                raise ValueError(f"{data.name}: its values are not in the file")
            values = _numbers(self.content[start : start + data.nbytes], data, data.shape)
        return values.astype(rule.dtype)


class _Node(NamedTuple):
    """A group of a file, and its arrays by name, which are not read yet."""

    group: h5py.Group
    arrays: dict[str, h5py.Dataset]


def _known_nodes(file: h5py.File, rules: Rules) -> dict[str, _Node]:
    """Return the root and the groups of a file by name, with their arrays.

    Raises
    ------
    ValueError : a link leads elsewhere, or an array or a group is not in the rules.
    """
    nodes = {"": _Node(file, {})}
    dimensions = {
        dimension
        for group in rules.values()
        for rule in group.values()
        for dimension in rule.dimensions
    }
    for name in file:
        inner = _linked_object(file, name)
        if isinstance(inner, h5py.Group) and name in rules:
            nodes[name] = _Node(inner, {})
    for group_name, node in nodes.items():
        for name in node.group:
            if not group_name and name in nodes:
                continue
            inner = _linked_object(node.group, name)
            is_known = name in rules[group_name] or name in dimensions
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
    nodes: dict[str, _Node], rules: Rules, lengths: Mapping[str, int], most_bytes: int
) -> None:
    """Refuse types, storages and lengths that are not in the rules, and too many bytes."""
    total = 0
    for group_name, node in nodes.items():
        own_lengths = dict(lengths)
        for name, data in node.arrays.items():
            path = f"{group_name}/{name}".lstrip("/")
            # A dimension without values is an array that is never read.
            rule = rules[group_name].get(name, ArrayRule((name,), "f4"))
            if not _is_of_type(data, rule.dtype) or not _is_stored_by_this_program(data):
                raise ValueError(
                    f"{path}: got {data.dtype} or another storage, allowed: {rule.dtype}"
                )
            is_single = rule.may_be_single and data.shape == ()
            dimensions = () if is_single else rule.dimensions
            if len(data.shape) != len(dimensions):
                raise ValueError(
                    f"{path}: got {len(data.shape)} dimensions, allowed: {len(dimensions)}"
                )
            for dimension, length in zip(dimensions, data.shape, strict=True):
                allowed = own_lengths.setdefault(dimension, length)
                if length != allowed:
                    raise ValueError(f"{path}: got {length} along {dimension}, allowed: {allowed}")
            total += math.prod(data.shape) * data.dtype.itemsize
    if total > most_bytes:
        raise ValueError(f"arrays of {total} bytes, allowed for this scene: {most_bytes}")


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
        not _takes_values_from_elsewhere(data)
        and set(_filters(data)) <= _FILTERS
        and (not data.size or bool(np.less_equal(chunks, data.shape).all()))
    )


def _takes_values_from_elsewhere(data: h5py.Dataset) -> bool:
    """Return whether the values of an array lie in other files, or in other arrays."""
    return bool(data.is_virtual or data.external)


def _filters(data: h5py.Dataset) -> list[int]:
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
    filters = _filters(data)
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


def _attributes(group: h5py.Group) -> dict[str, Any]:
    """Read the attributes of a group, each a text or a number."""
    attributes = {}
    for name in group.attrs:
        if name == _PROPERTIES:
            continue
        stored = group.attrs.get_id(name)
        kind = stored.get_type().get_class()
        is_simple = kind in (h5py.h5t.STRING, h5py.h5t.INTEGER, h5py.h5t.FLOAT)
        if not is_simple or math.prod(stored.shape) != 1:  # many texts may share their bytes
            raise ValueError(f"{group.name}: attribute {name}: not one text or number")
        value = group.attrs[name]
        attributes[name] = value if isinstance(value, str) else np.asarray(value).item()
    return attributes


# ---- judge a file that another package reads


def is_hdf5(path: Path) -> bool:
    """Tell whether a regular file is an HDF5 file, at its beginning or behind a user block."""
    with open_regular(path) as file:
        start = 0
        while True:
            file.seek(start)
            signature = file.read(len(_SIGNATURE))
            if signature == _SIGNATURE:
                return True
            if len(signature) < len(_SIGNATURE):
                return False
            start = 2 * start or _FIRST_USER_BLOCK


@contextmanager
def judged(path: Path, most_bytes: int) -> Iterator[None]:
    """Let another package read a file within the context, after it is judged if it is HDF5.

    Parameters
    ----------
    path : Path
        Regular file of any format.
    most_bytes : int
        Size that the arrays of the file may have together.

    Raises
    ------
    ValueError
        The file takes values from other files, or its arrays are larger.
    """
    if not is_hdf5(path):
        yield
        return
    with addresses.at_most(_COPIES * most_bytes + _LIBRARY):
        _refuse_strange(path, most_bytes)
        yield


def _refuse_strange(path: Path, most_bytes: int) -> None:
    """Refuse a file that takes values from elsewhere, or states more bytes than are allowed."""
    total = 0
    left = _MAX_OBJECTS
    with h5py.File(path, "r") as file:
        for inner in _objects(file):
            left -= 1 + len(inner.attrs)
            if left < 0:
                raise ValueError(f"holds more than {_MAX_OBJECTS} arrays and attributes")
            if not isinstance(inner, h5py.Dataset):
                continue
            if _takes_values_from_elsewhere(inner):
                raise ValueError(f"{inner.name}: takes its values from other files")
            if not set(_filters(inner)) <= _FILTERS_OF_INSTRUMENTS:
                raise ValueError(f"{inner.name}: is packed by a filter that is not known")
            chunks = inner.chunks or ()
            stated = max(math.prod(inner.shape or ()), math.prod(chunks))
            total += stated * inner.dtype.itemsize
            if total > most_bytes:
                raise ValueError(f"states arrays of {total:,} bytes, allowed: {most_bytes:,}")


def _objects(file: h5py.File) -> Iterator[h5py.Group | h5py.Dataset]:
    """Yield the root of a file and all that lies in it, each once.

    A link within the file leads to an object that is met at its own place.

    Raises
    ------
    ValueError : a link leads to another file.
    """
    waiting = [file["/"]]
    seen = {waiting[0].id}
    while waiting:
        node = waiting.pop()
        yield node
        if not isinstance(node, h5py.Group):
            continue
        for name in node:
            link = node.get(name, getlink=True)
            if isinstance(link, h5py.ExternalLink):
                raise ValueError(f"{node.name}: the link {name!r} leads to another file")
            if not isinstance(link, h5py.HardLink):
                continue
            inner = node[name]
            is_object = isinstance(inner, h5py.Group | h5py.Dataset)
            if is_object and inner.id not in seen:
                seen.add(inner.id)
                waiting.append(inner)
