"""Safe writing of whole files, and the error of a folder."""

from __future__ import annotations

import json
import os
import secrets
from pathlib import Path
from typing import Any

PARTIAL = ".partial"  # end of the names of files that are being written


class FolderError(Exception):
    """Error of a folder or a file in it, with the way out."""


def write_bytes(path: Path, content: bytes | memoryview) -> None:
    """Write a file under a random name beside it, then rename it.

    The file is therefore either whole or absent, and nobody can prepare a link of that name through
    which the content would reach another file.

    Raises
    ------
    OSError : the file cannot be written; the error names it, and an earlier file is kept.
    """
    partial = path.with_name(f".{path.name}.{secrets.token_hex(8)}{PARTIAL}")
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL
    flags |= getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    try:
        descriptor = os.open(partial, flags, 0o666)
        try:
            with os.fdopen(descriptor, "wb") as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
            partial.replace(path)
        except BaseException:  # includes Ctrl-C
            partial.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


def write_json(path: Path, content: Any) -> None:
    """Write a JSON file, whole or not at all."""
    write_bytes(path, (json.dumps(content, indent=2, allow_nan=False) + "\n").encode())
