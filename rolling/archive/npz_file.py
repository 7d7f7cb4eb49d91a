"""Archives of numpy (.npz), whose arrays are judged before a value is read.

An archive of this program has defined arrays. One that states other names, types or shapes is
refused by these statements, and so is one that is packed: a small packed file may become an array
of any size. zip keeps a checksum of each array, so that damage is noticed when the values are read.

An archive of measured series has arrays of any names, of which those of numbers are read. It may be
packed, because the size of each array is judged first.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from math import prod
from typing import IO, Any, NamedTuple

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


# ---- archives with arrays of any names


class NpzArray(NamedTuple):
    """Array of an archive: its name, and its shape; () for one that holds no real numbers."""

    name: str
    shape: tuple[int, ...]


def npz_arrays(content: bytes, most_bytes: int) -> list[NpzArray]:
    """Return the arrays of an archive that anybody may have made, of which no value is read.

    Parameters
    ----------
    content : bytes
        The archive.
    most_bytes : int
        Largest size of an array.

    Raises
    ------
    ValueError
        An array has another size than it says, a larger one than allowed, or the name of another.
    Exception
        The archive is damaged. numpy and zipfile raise errors of any kind then.
    """
    arrays = list[NpzArray]()
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        for member in archive.infolist():
            name = member.filename.removesuffix(_ENDING)
            if name in [other.name for other in arrays]:
                raise ValueError(f"two arrays with the name {name!r}")
            if member.file_size > most_bytes:
                raise ValueError(
                    f"{name}: an array of {member.file_size:,} bytes, allowed: {most_bytes:,}"
                )
            arrays.append(NpzArray(name, _shape_of_numbers(archive, member)))
    return arrays


def _shape_of_numbers(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> tuple[int, ...]:
    """Return the shape of an array of real numbers by its head; () for anything else."""
    if not member.filename.endswith(_ENDING):
        return ()
    with archive.open(member) as stream:
        if np.lib.format.read_magic(stream) != (1, 0):
            return ()
        shape, _, dtype = np.lib.format.read_array_header_1_0(stream, _MAX_HEADER)
        if dtype.kind not in "fiu":
            return ()
        if min(shape, default=0) < 0 or stream.tell() + prod(shape) * dtype.itemsize != (
            member.file_size
        ):
            raise ValueError(f"{member.filename}: has another size than it says")
    return shape


def read_npz_array(content: bytes, name: str) -> NDArray[Any]:
    """Return an array of an archive by its name, which `npz_arrays` has judged."""
    with (
        zipfile.ZipFile(io.BytesIO(content)) as archive,
        archive.open(f"{name}{_ENDING}") as stream,
    ):
        return np.asarray(np.lib.format.read_array(stream, allow_pickle=False))
