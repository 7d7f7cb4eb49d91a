"""Files of a run folder: written whole or not at all, and the errors that folders and their files raise."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any


class FolderError(Exception):
    """A folder that cannot be written to or read from, and what to do."""


class Stopped(OSError):
    """Work on a run folder that the system stopped, for instance by a full disk, and the way on."""

    def __init__(self, cause: OSError, way_on: str) -> None:
        super().__init__(f"{cause}\n{way_on}")


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file under another name, then give it its own: it is whole or it is not there."""
    partial = path.with_name(f".{path.name}.partial")
    try:
        with partial.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        partial.replace(path)
    except BaseException:  # Ctrl-C, too
        partial.unlink(missing_ok=True)
        raise


def write_json(path: Path, content: Any) -> None:
    write_bytes(path, (json.dumps(content, indent=2, allow_nan=False) + "\n").encode())


class Keeper:
    """Writes results while a run goes on, often, but never for more than a twentieth of the time."""

    def __init__(self) -> None:
        self._next = time.monotonic()

    def due(self) -> bool:
        return time.monotonic() >= self._next

    def wrote(self, seconds: float) -> None:
        self._next = time.monotonic() + max(2.0, 20 * seconds)
