"""The files in which numba keeps the compiled code of a kernel, checked before they are loaded.

Numba compares the source file of a kernel with its cache, but not those of the kernels that it
calls, and it trusts what it reads. A record beside the files of each kernel holds a digest of the
sources of all kernels and one of each file. Files that differ from it are deleted, so that numba
compiles the kernel anew: after a change of another source, after a power cut that left a file cut
off, or after a process was killed while it wrote.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache as once
from pathlib import Path
from typing import Any


class KeptFiles:
    """Cache files of one kernel and their record.

    Parameters
    ----------
    function : function
        Function that the kernel is compiled from.
    folder : str
        Folder of the cache.
    """

    def __init__(self, function: Callable[..., Any], folder: str) -> None:
        module = Path(function.__code__.co_filename).stem
        name = f"{module}.{function.__qualname__}".replace("<", "").replace(">", "")
        self.name = f"{name}-{function.__code__.co_firstlineno}"
        self.folder = Path(folder)
        self._record = self.folder / f"{self.name}.sha256"

    @property
    def lock(self) -> Path:
        """File of the lock under which the files are read and written."""
        return self.folder / f"{self.name}.lock"

    def remove_what_differs(self) -> None:
        """Delete the files unless all of them are those of the record.

        Raise OSError where they cannot be deleted.
        """
        present = self._digests()
        if present and present != self._recorded():
            for path in self._paths():
                path.unlink()

    @property
    def are_whole(self) -> bool:
        """Whether there are files, and they are those of the record."""
        present = self._digests()
        return bool(present) and present == self._recorded()

    def record(self) -> None:
        """Record the digests of the files, where the folder lets it."""
        digests = self._digests()
        if digests == self._recorded():
            return
        with suppress(OSError):
            number, temporary = tempfile.mkstemp(dir=self.folder, prefix=f"{self.name}.")
            with os.fdopen(number, "w", encoding="utf-8") as stream:
                json.dump({"sources": digest_of_sources(), "files": digests}, stream)
            Path(temporary).replace(self._record)

    def _paths(self) -> list[Path]:
        """Return the paths of numba's index and code files."""
        names = [entry.name for entry in os.scandir(self.folder)] if self.folder.is_dir() else []
        ours = [name for name in names if name.startswith(f"{self.name}.")]
        return [self.folder / name for name in sorted(ours) if name.endswith((".nbi", ".nbc"))]

    def _digests(self) -> dict[str, str]:
        """Return the digest of each file by its name; that of an unreadable file is its error."""
        digests = {}
        for path in self._paths():
            try:
                digests[path.name] = hashlib.sha256(path.read_bytes()).hexdigest()
            except OSError as error:
                digests[path.name] = str(error)
        return digests

    def _recorded(self) -> dict[str, str] | None:
        """Return the recorded digests; None without a record, or with one of other sources."""
        try:
            record = json.loads(self._record.read_bytes())
            files: dict[str, str] = record["files"]
            return files if record["sources"] == digest_of_sources() else None
        except (OSError, ValueError, KeyError, TypeError):
            return None


@once
def digest_of_sources() -> str:
    """Return the digest of the modules of kernels, which begin with an underscore."""
    digest = hashlib.sha256()
    rooms = Path(__file__).parents[1]
    for room in ("bearing", "contact", "dynamics"):
        for path in sorted(rooms.glob(f"{room}/_*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()


@once
def warn_not_kept(folder: Path, reason: str) -> None:
    """Say that code which was compiled is lost at the end of this process."""
    print(
        f"warning: compiled code cannot be kept in {folder} ({reason}): every start compiles it"
        " anew; delete that folder, or set NUMBA_CACHE_DIR to a folder of your own",
        file=sys.stderr,
    )
