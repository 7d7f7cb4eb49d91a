"""Identity of this program: its version, the digest of its sources, and its packages."""

import hashlib
import platform
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

import acoustics
import rolling

SHOWN = 12  # digits of a digest in texts
_PACKAGES = ("numpy", "scipy", "numba")


class Program(NamedTuple):
    """Version, SHA-256 of all modules by name and content, and packages that change numbers."""

    version: str
    sources: str
    packages: str = ""

    def __str__(self) -> str:
        return f"version {self.version}, sources {self.sources[:SHOWN]}, {self.packages}"


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
    packages = [f"python {platform.python_version()}"]
    packages += [f"{name} {metadata.version(name)}" for name in _PACKAGES]
    return Program(rolling.__version__, digest.hexdigest(), ", ".join(packages))
