"""Processor time of a thread, apart from that in which it compiles kernels or loads compiled ones.

Waiting, for another process that compiles or for a core that is busy, takes no processor time.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple, Self


class ProcessorTime(NamedTuple):
    """Processor time that a thread has taken.

    work_s : float, s. All but compilation.
    compilation_s : float, s. Compilation of kernels, and loading of compiled ones.
    """

    work_s: float
    compilation_s: float

    @classmethod
    def now(cls) -> Self:
        """Return the processor time that this thread has taken so far."""
        compiled_s = _compilation.seconds
        return cls(work_s=time.thread_time() - compiled_s, compilation_s=compiled_s)

    def since(self, before: ProcessorTime) -> ProcessorTime:
        """Return the processor time from an earlier moment of the same thread on."""
        return ProcessorTime(
            work_s=self.work_s - before.work_s,
            compilation_s=self.compilation_s - before.compilation_s,
        )

    def plus(self, other: ProcessorTime) -> ProcessorTime:
        """Return the sum of two processor times."""
        return ProcessorTime(
            work_s=self.work_s + other.work_s,
            compilation_s=self.compilation_s + other.compilation_s,
        )


class _Compilation(threading.local):
    """Compilation of a thread: how deep its kernels compile each other, and its processor time."""

    depth = 0
    seconds = 0.0


_compilation = _Compilation()


@contextmanager
def counted_as_compilation() -> Iterator[None]:
    """Count the processor time of this context as compilation.

    A kernel compiles the kernels that it calls, so the outermost context alone is counted.
    """
    if _compilation.depth:
        yield
        return
    began = time.thread_time()
    _compilation.depth = 1
    try:
        yield
    finally:
        _compilation.depth = 0
        _compilation.seconds += time.thread_time() - began
