"""Worker processes that end with the process that started them, even after a kill."""

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
    """End this process as soon as the process that started it has ended.

    Call it first in a process of `multiprocessing`. Two mechanisms work together. On Linux the
    kernel kills the process, even in the middle of a compiled step, which holds Python's lock so
    that no other thread runs. On other systems a thread waits for the parent's end and acts after
    the current compiled step.
    """
    parent = multiprocessing.parent_process()
    if parent is None:  # this process has no parent in `multiprocessing`
        return
    _ask_kernel()
    # The kernel signals only later ends, and the parent may have ended already. (On Windows the
    # number never changes.)
    if os.getppid() != parent.pid:
        os._exit(_EXIT_CODE)
    threading.Thread(target=_watch, args=(parent.sentinel,), name="lifeline", daemon=True).start()


def _ask_kernel() -> None:
    """Ask the kernel to kill this process when its parent ends, where the kernel can."""
    if not sys.platform.startswith("linux"):
        return
    with suppress(OSError, AttributeError):  # the C library lacks prctl: the thread remains
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, int(signal.SIGKILL), 0, 0, 0)


def _watch(sentinel: int) -> None:
    """Wait until the parent ends, then end this process at once without any clean-up."""
    connection.wait([sentinel])
    os._exit(_EXIT_CODE)
