"""Archives of numpy (.npz) with defined arrays, which are judged before a value is read.

An archive that states other names, types or shapes is refused by these statements, and so is one
that is packed: a small packed file may become an array of any size. zip keeps a checksum of each
array, so that damage is noticed when the values are read.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from math import prod
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from rolling.archive.definition import TEXT, Arrays, Variable

_ENDING = ".npy"
_MAX_HEADER = 1000  # letters of the description of an array
_MAX_TEXT = 10_000  # letters of a text


def npz_bytes(variables: Mapping[str, Variable], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return the bytes of an archive, which are equal for equal arrays.

    Parameters
    ----------
    variables : mapping
        Definition of each array by its name in the archive.
    arrays : mapping
        All these arrays and no others.

    Raises
    ------
    ValueError
        An array is missing or not defined.
    """
    if arrays.keys() != variables.keys():
        raise ValueError(f"other arrays than defined: {_differing(arrays, variables)}")
    stored = {}
    for name, values in arrays.items():
        dtype = variables[name].dtype
        stored[name] = values if dtype == TEXT else values.astype(dtype)
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, **stored)
    return content.getvalue()


def read_npz(
    content: bytes, variables: Mapping[str, Variable], lengths: Mapping[str, int]
) -> Arrays:
    """Return the arrays of an archive that anybody may have changed.

    Parameters
    ----------
    content : bytes
        The archive. Bytes behind it are not looked at.
    variables : mapping
        Definition of each array by its name in the archive, which has all of them.
    lengths : mapping
        Lengths of dimensions that are known. Others have one length within the archive.

    Raises
    ------
    ValueError
        Names, types, shapes or sizes are not those of the definition.
    Exception
        The archive is damaged. numpy and zipfile raise errors of any kind then.
    """
    own_lengths = dict(lengths)
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = {member.filename.removesuffix(_ENDING): member for member in archive.infolist()}
        if members.keys() != variables.keys() or len(members) != len(archive.infolist()):
            raise ValueError(f"other arrays than defined: {_differing(members, variables)}")
        for name, member in members.items():
            if member.compress_type != zipfile.ZIP_STORED:
                raise ValueError(f"{name}: compressed")
            with archive.open(member) as stream:
                size = member.file_size
                _refuse_declaration(stream, size, name, variables[name], own_lengths)
        arrays = {}
        for name, member in members.items():
            with archive.open(member) as stream:
                arrays[name] = np.lib.format.read_array(stream, allow_pickle=False)
        return arrays


def _refuse_declaration(
    stream: IO[bytes], size: int, name: str, variable: Variable, lengths: dict[str, int]
) -> None:
    """Refuse an array by the head of its file of so many bytes; raise ValueError."""
    if np.lib.format.read_magic(stream) != (1, 0):
        raise ValueError(f"{name}: another version of numpy's format")
    shape, _, dtype = np.lib.format.read_array_header_1_0(stream, _MAX_HEADER)
    is_known = dtype.str[1:] == variable.dtype
    if variable.dtype == TEXT:
        is_known = dtype.kind == "U" and dtype.itemsize <= _MAX_TEXT * np.dtype("U1").itemsize
    if not is_known:
        raise ValueError(f"{name}: got {dtype}, allowed: {variable.dtype}")
    variable.refuse_shape(shape, lengths, name)
    if stream.tell() + prod(shape) * dtype.itemsize != size:
        raise ValueError(f"{name}: has another size than it says")


def _differing(names: Mapping[str, Any], variables: Mapping[str, Variable]) -> str:
    """Return the first names that are missing or not defined."""
    return ", ".join(sorted(names.keys() ^ variables.keys())[:9])
