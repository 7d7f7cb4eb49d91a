"""Read every object of an HDF5 file in a separate process.

A damaged file may crash the HDF5 library or keep it busy for ever. The command is
`python -P _hdf5_probe.py FILE`. Its exit code is 0 if the whole file can be read; otherwise the
last line of stderr gives the reason.

`result_file` runs it before it opens a file without a valid digest. It imports nothing of this
program, so it starts at once.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from pathlib import Path

import h5py

SECONDS = 60  # of processor time
# A compressed byte expands to about a thousand bytes at most; chunks never written need no byte.
MOST_BYTES_PER_BYTE = 5000


def limit() -> None:
    """Limit time and memory where the system allows it."""
    with suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
        resource.setrlimit(resource.RLIMIT_AS, (16 << 30, 16 << 30))


def read_all(path: Path) -> None:
    """Read all datasets and attributes.

    Raises
    ------
    ValueError : a dataset is larger than the file can hold.
    Exception : any error of h5py.
    """
    most = MOST_BYTES_PER_BYTE * path.stat().st_size
    with h5py.File(path, "r") as file:

        def visit(name: str, thing: h5py.Group | h5py.Dataset) -> None:
            dict(thing.attrs)
            if isinstance(thing, h5py.Dataset):
                if thing.size is not None and thing.size * thing.dtype.itemsize > most:
                    raise ValueError(
                        f"{name}: {thing.shape} values in a file of {path.stat().st_size} bytes"
                    )
                thing[()]

        dict(file.attrs)
        file.visititems(visit)


if __name__ == "__main__":
    limit()
    try:
        read_all(Path(sys.argv[1]))
    except Exception as error:  # damage raises errors of any kind
        text = " ".join(str(error).split()) or type(error).__name__
        sys.exit(text)
