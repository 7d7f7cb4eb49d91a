"""Files of compiled code in the cache of numba, whose damage is found by a digest."""

# mypy: disable-error-code="no-untyped-call"
from __future__ import annotations

import hashlib
import pickle
import sys
from functools import cache as once
from pathlib import Path
from typing import Any, NamedTuple

from numba.core.caching import IndexDataCacheFile

_DIGEST_BYTES = hashlib.sha256().digest_size


class _Stored(NamedTuple):
    """Compiled code of a kernel, with the sources and the types that it was compiled from."""

    stamp: Any
    key: Any
    code: Any


class CheckedFiles(IndexDataCacheFile):
    """Index and data files of a kernel, each with the digest of its content at its end.

    Numba raises on a file that a power cut left empty or cut off, and code with a flipped byte ends
    the process. Here a file that is damaged or cannot be read counts as absent, so that the kernel
    is compiled anew and the file is replaced. The digest stands in the file itself, because two
    files could not be replaced at one moment.
    """

    def load(self, key: Any) -> Any:
        """Return the compiled code of a key; None where the cache does not hold it."""
        stored = super().load(key)
        # Numba writes the index before the data. If a process is killed in between, the index names
        # a file that holds older code, or code for other types.
        if stored is None or (stored.stamp, stored.key) != (self._source_stamp, key):
            return None
        return stored.code

    def save(self, key: Any, data: Any) -> None:
        """Keep compiled code where the folder lets it."""
        try:
            super().save(key, _Stored(self._source_stamp, key, data))
        except OSError as error:
            _warn_not_kept(self._cache_path, error.strerror or str(error))

    def _load_index(self) -> dict[Any, str]:
        """Read the names of data files by key; none from a file that is damaged or out of date."""
        index = _read(Path(self._index_path))
        if index is None:
            return {}
        version, stamp, names = index
        if (version, stamp) != (self._version, self._source_stamp):
            return {}
        return dict(names)

    def _save_index(self, overloads: dict[Any, str]) -> None:
        """Write the names of data files by key."""
        self._write(self._index_path, (self._version, self._source_stamp, overloads))

    def _load_data(self, name: str) -> Any:
        """Read compiled code; None from a file that is damaged or cannot be read."""
        return _read(Path(self._data_path(name)))

    def _save_data(self, name: str, data: Any) -> None:
        """Write compiled code."""
        self._write(self._data_path(name), data)

    def _write(self, path: str, value: Any) -> None:
        """Write a value and the digest of its bytes into a file."""
        content = self._dump(value)
        with self._open_for_write(path) as stream:
            stream.write(content)
            stream.write(hashlib.sha256(content).digest())


def _read(path: Path) -> Any:
    """Return the value in a file; None without a readable file whose digest is right."""
    try:
        if not path.is_file():
            return None
        whole = path.read_bytes()
    except OSError:
        return None
    content, digest = whole[:-_DIGEST_BYTES], whole[-_DIGEST_BYTES:]
    if hashlib.sha256(content).digest() != digest:
        return None
    try:
        return pickle.loads(content)
    except MemoryError:  # which says nothing about the file
        raise
    except Exception:  # of a whole file that needs packages of another version
        return None


@once
def _warn_not_kept(folder: str, reason: str) -> None:
    """Say that code which was compiled is lost at the end of this process."""
    print(
        f"warning: compiled code cannot be kept in {folder} ({reason}): every start compiles it"
        " anew; delete that folder, or set NUMBA_CACHE_DIR to a folder of your own",
        file=sys.stderr,
    )
