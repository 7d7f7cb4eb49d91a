"""Run folders: files written whole or not at all, folders never overwritten unasked."""

from __future__ import annotations

import json
import os
import shutil
import time
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

FINISHED = "finished"


class FolderError(Exception):
    """A folder that cannot be written to or read from, and what to do."""


def new_folder(base: Path, out: Path | None, force: bool) -> Path:
    """A folder for a new run: `out`, or one named after the time below `base`. Nothing is overwritten without `force`.

    Raises
    ------
    FolderError : `out` holds something and may not, or holds something that is no run.
    """
    if out is None:
        stamp = datetime.now(UTC).strftime("%Y-%m-%dT%H-%M-%S")
        for k in range(1, 1000):
            folder = base / (stamp if k == 1 else f"{stamp}-{k}")
            with suppress(FileExistsError):
                folder.mkdir(parents=True)
                return folder
        raise FolderError(f"{base}: no free folder name")
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        if not out.is_dir() or not (out / "scene.yaml").is_file():
            raise FolderError(f"{out}: holds something that is not a run of this program; take another --out")
        if not force:
            raise FolderError(f"{out}: holds a run already; take another --out, or --force to replace it")
        shutil.rmtree(out)
    out.mkdir(parents=True, exist_ok=True)
    return out


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
