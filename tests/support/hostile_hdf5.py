"""HDF5 files as a stranger makes them, who knows the digest of this program."""

from __future__ import annotations

import hashlib
import io
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

LINE = b"\nrolling-contact-noise result.h5, SHA-256 of all bytes before this line: "
Spoil = Callable[[h5py.File], object]


def seal(path: Path, content: bytes) -> None:
    """Write bytes with the digest that belongs to them."""
    path.write_bytes(content + LINE + hashlib.sha256(content).hexdigest().encode() + b"\n")


def spoil(path: Path, change: Spoil) -> None:
    """Change a file as a program that knows the digest would."""
    content = path.read_bytes()
    path.write_bytes(content[: content.rindex(LINE)])
    with h5py.File(path, "r+") as file:
        change(file)
    seal(path, path.read_bytes())


def put(name: str, values: np.ndarray) -> Spoil:
    """Put an array in the place of another, or beside all."""

    def change(file: h5py.File) -> None:
        if name in file:
            del file[name]
        file[name] = values

    return change


def stored_outside(name: str, outside: Path) -> Spoil:
    """Let an array take its values from another file."""

    def change(file: h5py.File) -> None:
        shape, dtype = file[name].shape, file[name].dtype
        size = file[name].nbytes
        del file[name]
        file.create_dataset(name, shape, dtype, external=[(str(outside), 0, size)])

    return change


def virtual(name: str, outside: Path) -> Spoil:
    """Let an array take its values from an array of another file."""

    def change(file: h5py.File) -> None:
        shape, dtype = file[name].shape, file[name].dtype
        del file[name]
        layout = h5py.VirtualLayout(shape, dtype)
        layout[...] = h5py.VirtualSource(str(outside), name, shape, dtype)
        file.create_virtual_dataset(name, layout)

    return change


def linked_outside(name: str, outside: Path) -> Spoil:
    """Put a link to another file in place of an array."""

    def change(file: h5py.File) -> None:
        del file[name]
        file[name] = h5py.ExternalLink(str(outside), name)

    return change


def inflated(name: str, size: int) -> Spoil:
    """Store a chunk that unpacks to so many bytes, more than it says."""

    def change(file: h5py.File) -> None:
        shape, dtype = file[name].shape, file[name].dtype
        del file[name]
        data = file.create_dataset(name, shape, dtype, chunks=shape, compression=1)
        data.id.write_direct_chunk((0,) * len(shape), zlib.compress(bytes(size), 1))

    return change


def unwritten(name: str, shape: tuple[int, ...] | None = None) -> Spoil:
    """Declare an array of which no chunk is written."""

    def change(file: h5py.File) -> None:
        wanted, dtype = shape or file[name].shape, file[name].dtype
        del file[name]
        chunks = tuple(min(count, 1000) for count in wanted)
        file.create_dataset(name, wanted, dtype, chunks=chunks)

    return change


def with_long_text(content: bytes, length: int, place: str = "/") -> bytes:
    """Let a text attribute of a file state another length than that of its bytes.

    A text is stored as its length, the place of a heap with texts, and a number in this heap.
    """
    with h5py.File(io.BytesIO(content), "r+") as file:
        file[place].attrs["title"] = "x" * 4321
        file.flush()
        changed = bytearray(file.id.get_file_image())
    at = changed.find(struct.pack("<I", 4321))
    while at >= 0:
        heap, number = struct.unpack_from("<QI", changed, at + 4)
        if changed[heap : heap + 4] == b"GCOL" and 0 < number < 100:
            changed[at : at + 4] = struct.pack("<I", length)
            return bytes(changed)
        at = changed.find(struct.pack("<I", 4321), at + 1)
    raise AssertionError("the text is not found in the file")


def instrument_file(path: Path, heights: np.ndarray, outside: Path | None = None) -> None:
    """Write heights [m] with spacings of 3 um and 2 um as an interferometer of Zygo does (.datx).

    With another file, the heights are its bytes.
    """
    text = h5py.string_dtype("ascii")
    row = np.dtype([("category", text), ("key", text), ("value", text)])
    converter = np.dtype([("category", text), ("unit", text), ("values", h5py.vlen_dtype("f8"))])
    rows = [
        ("Root", "Measurement", "{1}"),
        ("{1}", "Surface", "{2}"),
        ("{2}", "Path", "/Data/Surface/{9}"),
    ]
    converters = {
        "X Converter": ("LateralCat", "Pixels", 3e-6),
        "Y Converter": ("LateralCat", "Pixels", 2e-6),
        "Z Converter": ("HeightCat", "NanoMeters", 1.0),
    }
    with h5py.File(path, "w") as file:
        file.create_dataset("MetaData", data=np.array(rows, dtype=row))
        if outside is None:
            surface = file.create_dataset("Data/Surface/{9}", data=heights * 1e9)
        else:
            external = [(str(outside), 0, heights.nbytes)]
            surface = file.create_dataset(
                "Data/Surface/{9}", heights.shape, "f8", external=external
            )
        surface.attrs["Unit"] = np.array(["NanoMeters"], dtype=text)
        for name, (category, unit, step) in converters.items():
            value = np.empty(1, converter)
            value[0] = (category, unit, np.array([0.0, step, 0.0, 0.0]))
            surface.attrs.create(name, value, dtype=converter)
