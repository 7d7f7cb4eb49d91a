"""Archives of numpy as a stranger makes them: other arrays, packed ones, and ones that lie."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable

import numpy as np

TERABYTE = 10**11  # numbers of 8 bytes


def rewritten(content: bytes, changes: dict[str, np.ndarray], compressed: bool = False) -> bytes:
    """Return an archive with other arrays."""
    with np.load(io.BytesIO(content)) as stored:
        arrays = {name: stored[name] for name in stored.files} | changes
    stream = io.BytesIO()
    (np.savez_compressed if compressed else np.savez)(stream, **arrays)
    return stream.getvalue()


def bomb(content: bytes, bombed: str, length: int = TERABYTE) -> bytes:
    """Return an archive in which an array declares numbers that it does not have."""
    declared = {"descr": "<f8", "fortran_order": False, "shape": (length,)}
    stream = io.BytesIO()
    with np.load(io.BytesIO(content)) as stored, zipfile.ZipFile(stream, "w") as file:
        for name in stored.files:
            with file.open(f"{name}.npy", "w") as member:
                if name == bombed:
                    np.lib.format.write_array_header_1_0(member, declared)
                else:
                    np.lib.format.write_array(member, stored[name])
    return stream.getvalue()


def twice(content: bytes, name: str) -> bytes:
    """Return an archive that has an array two times."""
    stream = io.BytesIO(content)
    with zipfile.ZipFile(io.BytesIO(content)) as source, zipfile.ZipFile(stream, "a") as file:
        file.writestr(zipfile.ZipInfo(f"{name}.npy"), source.read(f"{name}.npy"))
    return stream.getvalue()


def strange(name: str) -> dict[str, Callable[[bytes], bytes]]:
    """Return changes of an archive that attack an array of f8 of at least two numbers."""
    return {
        "cut off": lambda content: content[:100],
        "another length": lambda content: rewritten(content, {name: np.ones(7)}),
        "another type": lambda content: rewritten(content, {name: np.ones(2, complex)}),
        "objects": lambda content: rewritten(content, {name: np.array([{}, 1], object)}),
        "more arrays": lambda content: rewritten(content, {"more": np.ones(2)}),
        "compressed": lambda content: rewritten(content, {}, compressed=True),
        "a terabyte": lambda content: bomb(content, name),
        "empty": lambda content: bomb(content, name, 0),
    }
