"""HDF5 files of instruments, which other packages read: they are judged here first.

Such a file may take values from other files, by links, external storage or virtual data sets, and
a small one may state arrays and texts of any size.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from rolling.archive.hdf5_reader import (
    FILTERS,
    LIBRARY,
    SIGNATURE,
    filters_of,
    takes_values_from_elsewhere,
)
from rolling.terminal import addresses
from rolling.terminal.whole_files import open_regular

_FIRST_USER_BLOCK = 512  # bytes before the signature: none, or so many times a power of two
_FILTERS = FILTERS | {h5py.h5z.FILTER_FLETCHER32}
_MAX_OBJECTS = 10_000  # groups, arrays and attributes in a file of an instrument
_COPIES = 4  # of the heights that the reader of an instrument's file may hold at once


def is_hdf5(path: Path) -> bool:
    """Tell whether a regular file is an HDF5 file, at its beginning or behind a user block."""
    with open_regular(path) as file:
        start = 0
        while True:
            file.seek(start)
            signature = file.read(len(SIGNATURE))
            if signature == SIGNATURE:
                return True
            if len(signature) < len(SIGNATURE):
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
    with addresses.at_most(_COPIES * most_bytes + LIBRARY):
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
            if takes_values_from_elsewhere(inner):
                raise ValueError(f"{inner.name}: takes its values from other files")
            if not set(filters_of(inner)) <= _FILTERS:
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
