"""Worker processes that do not import the main module again.

Programs therefore need no `__main__` guard.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import spawn
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any

# a spawned process finds the main module by these keys
_MAIN = ("init_main_from_name", "init_main_from_path")
_lock = threading.Lock()


class _Worker(SpawnProcess):
    """A spawned process without the main module of its parent."""

    @staticmethod
    def _Popen(process: Any) -> Any:  # multiprocessing calls it from `start`
        with _main_left_out():
            return SpawnProcess._Popen(process)


class _Context(SpawnContext):
    """The start method that `concurrent.futures` uses."""

    Process = _Worker


def context() -> SpawnContext:
    """Return a context of `multiprocessing` whose processes do not import the main module.

    A spawned process usually runs the main module first, as `__mp_main__`. A script without a guard
    would start its runs again there, and a program from standard input has no file to run. The
    functions handed to these workers therefore have to stand in modules that can be imported.
    """
    return _Context()


def can_start_workers() -> bool:
    """Tell whether worker processes can share locks here; if not, warn that one process works.

    They need semaphores, which Linux keeps in /dev/shm. Some containers and sandboxes have none.
    """
    try:
        context().Lock()
    # Without semaphores in the operating system, multiprocessing.synchronize refuses its import. An
    # interpreter that counts too few of them says NotImplementedError. Without /dev/shm, or with
    # one that is full or sealed, making a lock is an OSError.
    except (ImportError, NotImplementedError, OSError) as error:
        print(
            "warning: no worker processes, because the system has no semaphores for them"
            f" (is /dev/shm there and writable? {error}): all is done in one process",
            file=sys.stderr,
        )
        return False
    return True


@contextmanager
def _main_left_out() -> Iterator[None]:
    """Leave the main module out of the data that prepare spawned processes."""
    with _lock:
        prepared = spawn.get_preparation_data

        def without_main(name: str) -> dict[str, Any]:
            return {key: value for key, value in prepared(name).items() if key not in _MAIN}

        spawn.get_preparation_data = without_main
        try:
            yield
        finally:
            spawn.get_preparation_data = prepared
