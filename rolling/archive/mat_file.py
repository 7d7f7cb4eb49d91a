"""Files of MATLAB of version 5 that anybody may have made: only their arrays of numbers are read.

A file is a head and a row of elements, each a variable, packed or not. What an element says of
itself is judged before a value is read, and what is packed is unpacked no further than allowed.
scipy then reads the one variable that is asked for, from a file that holds nothing else. Texts,
cells, structures, objects, and complex and sparse numbers are left alone.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import prod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

_HEAD = 128  # bytes of the head of a file
_VERSION_5 = 0x0100
_VERSION_7_3 = 0x0200  # a file of HDF5
_TAG = 8  # bytes before the content of an element
_MATRIX, _PACKED = 14, 15  # types of elements that are variables
_INT8, _INT32, _UINT32 = 1, 5, 6  # types of the parts that describe an array
_SIZES = {1: 1, 2: 1, 3: 2, 4: 2, 5: 4, 6: 4, 7: 4, 9: 8, 12: 8, 13: 8}  # of numbers by their type
_NUMERIC = range(6, 16)  # classes of arrays: double, single, and whole numbers
_COMPLEX = 0x0800  # flag of an array
_DESCRIPTION = 1000  # bytes of an element that hold its description, at most
_MAX_VARIABLES = 1000
_MAX_NAME = 63  # letters


@dataclass(frozen=True)
class MatVariable:
    """Variable of a file.

    name : str. Its name.
    shape : tuple of int. Its shape; () for one that holds no real numbers.
    content : bytes. Its element as it stands in the file, packed or not.
    is_packed : bool. Whether the element is packed.
    size : int, bytes. Size of the element when it is unpacked.
    """

    name: str
    shape: tuple[int, ...]
    content: bytes
    is_packed: bool
    size: int

    @property
    def count(self) -> int:
        """Number of its values; 0 for one that holds no real numbers."""
        return prod(self.shape) if self.shape else 0


def mat_variables(content: bytes, most_bytes: int) -> list[MatVariable]:
    """Return the variables of a file, of which no value is read.

    Parameters
    ----------
    content : bytes
        The file.
    most_bytes : int
        Largest size of a variable when it is unpacked.

    Raises
    ------
    ValueError
        The file is no file of version 5, is damaged, or names a variable twice.
    """
    order = _byte_order(content)
    variables = [_variable(element, order, most_bytes) for element in _elements(content, order)]
    names = [variable.name for variable in variables]
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise ValueError(f"two variables with the name {twice[0]!r}")
    return variables


def read_mat_array(content: bytes, variable: MatVariable) -> NDArray[Any]:
    """Return the values of a variable of a file; raise ValueError for damaged ones."""
    from scipy.io import loadmat  # slow to import

    element = variable.content
    if variable.is_packed:
        element = _unpacked(element, variable.size)
    if len(element) != variable.size:
        raise ValueError(f"{variable.name}: has another size than it says")
    alone = io.BytesIO(content[:_HEAD] + element)
    try:
        values = loadmat(alone, variable_names=[variable.name])[variable.name]
    except Exception as error:  # of any kind, by damaged values
        raise ValueError(f"{variable.name}: damaged") from error
    if values.shape != variable.shape or values.dtype.kind not in "fiu":
        raise ValueError(f"{variable.name}: has other values than it says")
    return np.asarray(values)


# ---- elements


class _Element(NamedTuple):
    """Element of a file: its type, and its bytes, with the tag for one that is not packed."""

    kind: int
    content: bytes


def _byte_order(content: bytes) -> str:
    """Return the order of bytes of a file, < or >, by its head; refuse other versions."""
    mark = content[_HEAD - 2 : _HEAD]
    order = {b"IM": "<", b"MI": ">"}.get(mark)
    if order is None:
        raise ValueError("no file of MATLAB of version 5, whose head is missing")
    (version,) = struct.unpack(f"{order}H", content[_HEAD - 4 : _HEAD - 2])
    if version == _VERSION_7_3:
        raise ValueError("a file of version 7.3, allowed: version 5; save it with the option -v7")
    if version != _VERSION_5:
        raise ValueError(f"a file of version {version:#06x}, allowed: version 5")
    return order


def _elements(content: bytes, order: str) -> Iterator[_Element]:
    """Yield the elements of a file that are variables."""
    place = _HEAD
    count = 0
    while place + _TAG <= len(content):
        kind, size = struct.unpack(f"{order}II", content[place : place + _TAG])
        end = place + _TAG + size
        count += 1
        if kind not in (_MATRIX, _PACKED) or end > len(content) or count > _MAX_VARIABLES:
            raise ValueError("damaged, or not whole")
        first = place + _TAG if kind == _PACKED else place
        yield _Element(kind, content[first:end])
        place = end


def _variable(element: _Element, order: str, most_bytes: int) -> MatVariable:
    """Return the variable of an element by its description; refuse a damaged or too large one."""
    is_packed = element.kind == _PACKED
    begin = element.content[:_DESCRIPTION]
    if is_packed:
        begin = _unpacked(element.content, _DESCRIPTION)
    if len(begin) < _TAG:
        raise ValueError("an element that is damaged")
    kind, content_bytes = struct.unpack(f"{order}II", begin[:_TAG])
    size = _TAG + content_bytes
    if kind != _MATRIX:
        raise ValueError("an element that is no variable")
    if size > most_bytes:
        raise ValueError(f"a variable of {size:,} bytes, allowed: {most_bytes:,}")
    variable = MatVariable(
        name="", shape=(), content=element.content, is_packed=is_packed, size=size
    )
    return _described(variable, begin, order)


def _described(variable: MatVariable, begin: bytes, order: str) -> MatVariable:
    """Return a variable with its name, and with its shape if it holds real numbers alone."""
    parts = _Parts(begin, order)
    flags = parts.read(_UINT32)
    if len(flags) != 8:
        raise ValueError("a variable without a description")
    (word,) = struct.unpack(f"{order}I", flags[:4])
    dimensions = parts.read(_INT32)
    if len(dimensions) % 4:
        raise ValueError("a variable whose description is damaged")
    shape = struct.unpack(f"{order}{len(dimensions) // 4}i", dimensions)
    name = parts.read(_INT8).decode("latin-1")
    if not 0 < len(name) <= _MAX_NAME:
        return variable
    is_real = word & 0xFF in _NUMERIC and not word & _COMPLEX
    if not is_real or len(shape) < 2 or min(shape) < 0:
        return replace(variable, name=name)
    kind, size = parts.tag()
    if kind not in _SIZES or prod(shape) * _SIZES[kind] != size:
        raise ValueError(f"{name}: has another size than it says")
    return replace(variable, name=name, shape=shape)


class _Parts:
    """Parts of the description of a variable, one after the other."""

    def __init__(self, content: bytes, order: str) -> None:
        self._content = content
        self._order = order
        self._place = _TAG

    def tag(self) -> tuple[int, int]:
        """Return type and bytes of the next part; a small one has both in one word."""
        tag = self._content[self._place : self._place + _TAG]
        if len(tag) < _TAG:
            raise ValueError("a variable whose description is not whole")
        kind, size = struct.unpack(f"{self._order}II", tag)
        if kind >> 16:
            return kind & 0xFFFF, kind >> 16
        return kind, size

    def read(self, kind: int) -> bytes:
        """Return the content of the next part, which is of a type, and go on behind it."""
        own, size = self.tag()
        word = self._content[self._place : self._place + 4].ljust(4, b"\0")
        is_small = struct.unpack(f"{self._order}I", word)[0] >> 16 > 0
        first = self._place + (4 if is_small else _TAG)
        content = self._content[first : first + size]
        if own != kind or len(content) != size or (is_small and size > 4):
            raise ValueError("a variable whose description is damaged")
        self._place = self._place + _TAG if is_small else first + -(-size // 8) * 8
        return content


def _unpacked(content: bytes, most: int) -> bytes:
    """Return at most so many bytes of what is packed; refuse what is damaged."""
    try:
        return zlib.decompressobj().decompress(content, most)
    except zlib.error as error:
        raise ValueError("a packed element that is damaged") from error
