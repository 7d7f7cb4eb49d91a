"""Address space of this process: its limit (`ulimit -v`), and a narrower one for a while."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rolling.terminal import shortage

STATE_OF_PROCESS = Path("/proc/self/statm")
# Addresses [bytes] of the libraries and of the solver. A process that had loaded them was seen to
# have taken 502 MB, of which Python itself takes some 20 MB.
LIBRARIES = 480e6


def limit() -> float | None:
    """Return the limit of the address space of a process [bytes], None without one."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    bytes_, _ = resource.getrlimit(resource.RLIMIT_AS)
    return None if bytes_ == resource.RLIM_INFINITY else float(bytes_)


def taken() -> float | None:
    """Return the size of the address space of this process [bytes], None where it is unknown."""
    try:
        pages = int(STATE_OF_PROCESS.read_text().split()[0])
        return float(pages * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return None


def refuse_few_for_libraries() -> None:
    """Refuse to load libraries into an address space that cannot hold them.

    Without room for its buffers, a library of linear algebra asks for them again and again, and the
    process neither goes on nor ends.

    Raises
    ------
    MemoryError
        The limit leaves less than the libraries need.
    """
    limited = limit()
    if limited is not None and limited < (taken() or 0.0) + LIBRARIES:
        raise MemoryError(
            f"{shortage.NOT_ENOUGH}: a process may have {limited / 1e6:.0f} MB of addresses"
            f" (`ulimit -v`), and the libraries alone need about {LIBRARIES / 1e6:.0f} MB; allow"
            " more"
        )


# ---- a limit for a while

_narrowed = threading.RLock()  # the limit is of the whole process, so one thread sets it at a time


@contextmanager
def at_most(more_bytes: float) -> Iterator[None]:
    """Let this process take at most so many bytes of addresses more than it has, for a while.

    A library that is asked for more, by a damaged or hostile file, fails within the context in
    place of filling the memory. Linux alone keeps such a limit; elsewhere nothing is done.
    """
    if taken() is None:
        yield
        return
    import resource

    with _narrowed:
        soft, hard = resource.getrlimit(resource.RLIMIT_AS)
        wanted = round((taken() or 0.0) + more_bytes)
        if soft != resource.RLIM_INFINITY:
            wanted = min(wanted, soft)
        if hard != resource.RLIM_INFINITY:
            wanted = min(wanted, hard)
        resource.setrlimit(resource.RLIMIT_AS, (wanted, hard))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
