"""Files that end in a line with the SHA-256 of all bytes before it.

Readers of HDF5 and of zip archives do not notice this line. A damaged file is refused before a
library, which damage could crash, opens it. The digest has no key, so it protects from damage and
not from strangers: names, types and shapes are judged before any value is read.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from rolling.terminal.whole_files import FolderError, read_regular

_SEAL = b"\nrolling-contact-noise result.h5, SHA-256 of all bytes before this line: "
_SEAL_LENGTH = len(_SEAL) + 65  # with the digest and the end of the line


def seal(content: bytes | memoryview) -> bytes:
    """Return the last line of a file."""
    return _SEAL + hashlib.sha256(content).hexdigest().encode() + b"\n"


def sealed_content(path: Path, most_bytes: int) -> bytes:
    """Read the bytes of a file whose digest holds, and that is not larger than allowed.

    Raises
    ------
    FolderError : the file cannot be read, is too large, or has changed since it was written.
    """
    try:
        content = read_regular(path, most_bytes)
    except OSError as error:
        raise FolderError(f"{path}: not readable ({error.strerror or error})") from error
    if content[-_SEAL_LENGTH:] != seal(memoryview(content)[:-_SEAL_LENGTH]):
        raise FolderError(
            f"{path}: damaged, or of version 0.1.0: its SHA-256 does not hold"
            " (delete the file, and the same command solves it again)"
        )
    return content
