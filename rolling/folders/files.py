"""Writing of whole files, and the errors that folders and their files raise."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any


class FolderError(Exception):
    """Error of a folder that cannot be written or read, with the way out."""


class Stopped(OSError):
    """Error of the system that stopped work on a run folder, with the way on.

    A full disk is such an error.
    """

    def __init__(self, cause: OSError, way_on: str) -> None:
        super().__init__(f"{cause}\n{way_on}")


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file under a temporary name, then rename it.

    The file is therefore either complete or absent.
    """
    partial = path.with_name(f".{path.name}.partial")
    try:
        with partial.open("wb") as stream:
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
