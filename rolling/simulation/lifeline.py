"""Worker processes that end with the process that started them, however it ends."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import threading
from contextlib import suppress
from multiprocessing import connection

_PR_SET_PDEATHSIG = 1  # of prctl(2)
_EXIT_CODE = 1


def end_with_parent() -> None:
    """End this process as soon as the process that started it is gone.

    Call it first in a process of `multiprocessing`. Two means work together. On Linux the kernel
    kills the process, also in the middle of a compiled step, which holds Python's lock so that no
    other thread runs. Everywhere else a thread waits for the parent's end, and acts when the
    compiled step at hand is done.
    """
    parent = multiprocessing.parent_process()
    if parent is None:  # nobody started this process
        return
    _ask_kernel()
    # The kernel's signal comes only from now on: the parent may be gone already. (On Windows the
    # number never changes.)
    if os.getppid() != parent.pid:
        os._exit(_EXIT_CODE)
    threading.Thread(target=_watch, args=(parent.sentinel,), name="lifeline", daemon=True).start()


def _ask_kernel() -> None:
    """Have the kernel kill this process when its parent ends, where the kernel can."""
    if not sys.platform.startswith("linux"):
        return
    with suppress(OSError, AttributeError):  # a C library without it: the thread is left
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, int(signal.SIGKILL), 0, 0, 0)


def _watch(sentinel: int) -> None:
    """Wait until the parent ends, then end this process at once: nothing is left to clean up for
    anybody.
    """
    connection.wait([sentinel])
    os._exit(_EXIT_CODE)
