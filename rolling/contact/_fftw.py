"""pyfftw without its interface to Dask, which no march uses.

Where Dask is installed, that interface imports all arrays of Dask and pandas: a third of the time
that a process of this program takes to start.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

_UNUSED = "dask.array.fft"


@contextmanager
def _missing(module: str) -> Iterator[None]:
    """Make the import of a module fail as if its package were not installed."""
    if module in sys.modules:  # another package has it already
        yield
        return
    sys.modules[module] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        sys.modules.pop(module, None)


with _missing(_UNUSED):
    import pyfftw

__all__ = ["pyfftw"]
