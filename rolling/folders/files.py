"""Writing of whole files, and the errors that folders and their files raise."""

from __future__ import annotations

import json
import os
import secrets
import time
from collections.abc import Iterator
from contextlib import contextmanager
from errno import (
    EACCES,
    EDQUOT,
    EFBIG,
    EIO,
    EISDIR,
    ELOOP,
    ENAMETOOLONG,
    ENOENT,
    ENOSPC,
    ENOTDIR,
    EPERM,
    EROFS,
)
from pathlib import Path
from typing import Any

_OF_A_FOLDER = (EACCES, EPERM, ENOENT, ENOTDIR, EISDIR, ELOOP, ENAMETOOLONG)
_OF_A_DISK = (ENOSPC, EDQUOT, EROFS, EIO, EFBIG)


class FolderError(Exception):
    """Error of a folder that cannot be written or read, with the way out."""


class Unwritable(OSError):
    """Error of a folder that cannot be written, which its message names with the cause.

    everywhere : bool. Whether the folders beside it cannot be written either.
    """

    def __init__(self, message: str, everywhere: bool) -> None:
        super().__init__(message)
        self.everywhere = everywhere

    def __reduce__(self) -> tuple[type[Unwritable], tuple[str, bool]]:
        return Unwritable, (str(self), self.everywhere)  # as it comes from another process


@contextmanager
def writing(folder: Path) -> Iterator[None]:
    """Turn an error of the system in writing into a folder into one line.

    Raises
    ------
    Unwritable : a file in the folder cannot be written.
    """
    try:
        yield
    except Unwritable:
        raise
    except OSError as error:
        first: OSError = error
        while first.errno is None and isinstance(first.__cause__, OSError):
            first = first.__cause__
        is_inside = first.filename and folder in Path(os.fsdecode(first.filename)).parents
        if not (is_inside or first.filename is None) or (
            first.errno not in (*_OF_A_FOLDER, *_OF_A_DISK)
        ):
            raise
        everywhere = first.errno in _OF_A_DISK or not os.access(folder.parent, os.W_OK)
        raise Unwritable(f"{folder}: cannot be written ({first.strerror})", everywhere) from error


class Stopped(OSError):
    """Error of the system that stopped work on a run folder, with the way on.

    A full disk is such an error.
    """

    def __init__(self, cause: OSError, way_on: str) -> None:
        super().__init__(f"{cause}\n{way_on}")


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file under a random temporary name, then rename it.

    The file is therefore either complete or absent. Nobody can prepare a file or a link of that
    name, through which the content would reach another file.
    """
    partial = path.with_name(f".{path.name}.{secrets.token_hex(8)}.partial")
    new = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0)
    binary = getattr(os, "O_BINARY", 0)
    descriptor = os.open(partial, new | binary, 0o666)
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        partial.replace(path)
    except BaseException:  # includes Ctrl-C
        partial.unlink(missing_ok=True)
        raise


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file, complete or not at all."""
    write_bytes(path, (json.dumps(content, indent=2, allow_nan=False) + "\n").encode())


class Keeper:
    """Clock for writing results while a run goes on.

    Writing happens often, but takes at most a twentieth of the time.
    """

    def __init__(self) -> None:
        self._next = time.monotonic()

    def due(self) -> bool:
        """Tell whether it is time to write."""
        return time.monotonic() >= self._next

    def wrote(self, seconds: float) -> None:
        """Note that writing took `seconds` [s]."""
        self._next = time.monotonic() + max(2.0, 20 * seconds)
