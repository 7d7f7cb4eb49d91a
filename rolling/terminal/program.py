"""Identity of this program: its version and the digest of its sources."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path
from typing import NamedTuple

import acoustics
import rolling


class Program(NamedTuple):
    """Version of the program, and SHA-256 of all its modules by name and content."""

    version: str
    sources: str


@cache
def identity() -> Program:
    """Return the identity of the running program, computed once per process."""
    digest = hashlib.sha256()
    for package in (rolling, acoustics):
        folder = Path(str(package.__file__)).parent
        for path in sorted(folder.rglob("*.py")):
            content = path.read_bytes()
            name = path.relative_to(folder.parent).as_posix()
            digest.update(f"{name}\0{len(content)}\0".encode())
            digest.update(content)
    return Program(rolling.__version__, digest.hexdigest())
