"""Identity of this program: its version, the digest of its sources, and its commit."""

from __future__ import annotations

import hashlib
import os
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import acoustics
import rolling

NAME = "rolling-contact-noise"
PACKAGES = (rolling, acoustics)
ASSETS = "report/assets"  # folder of the files that the program reads besides its modules


@dataclass(frozen=True)
class Identity:
    """State of the program that made a result.

    Attributes
    ----------
    version : str
        Version of the program.
    sources : str
        SHA-256 of all modules and page assets, by name and content.
    commit : str or None
        Full name of the commit of the checkout; None outside a checkout.
    dirty : bool or None
        If true, the checkout differs from the commit; None outside a checkout.
    """

    version: str
    sources: str
    commit: str | None
    dirty: bool | None


@cache
def identity() -> Identity:
    """Return the identity of the running program, computed once per process."""
    commit, dirty = _checkout()
    return Identity(rolling.__version__, sources_digest(), commit, dirty)


def sources_digest() -> str:
    """Return the SHA-256 of the files of the program in a fixed order."""
    digest = hashlib.sha256()
    for name, file in _sources():
        content = file.read_bytes()
        digest.update(f"{name}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest()


def _sources() -> Iterator[tuple[str, Path]]:
    for package in PACKAGES:
        folder = Path(str(package.__file__)).parent
        files = [
            *folder.rglob("*.py"),
            *(file for file in (folder / ASSETS).rglob("*") if file.is_file()),
        ]
        names = {f"{folder.name}/{file.relative_to(folder).as_posix()}": file for file in files}
        yield from ((name, names[name]) for name in sorted(names) if "__pycache__" not in name)


def _checkout() -> tuple[str | None, bool | None]:
    root = Path(str(rolling.__file__)).parents[1]
    if not (root / ".git").exists():
        return None, None
    git = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    # The variables of a hook would point git at another repository.
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    try:
        text = subprocess.run(
            git, capture_output=True, text=True, check=True, timeout=10, env=environment
        ).stdout
    except (OSError, subprocess.SubprocessError):
        return None, None
    commit = text.strip()
    return commit.removesuffix("-dirty"), commit.endswith("-dirty")
