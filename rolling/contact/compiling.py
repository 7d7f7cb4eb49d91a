"""The moments when numba compiles a kernel, which happens once on a machine and takes a minute."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event

_KIND = "numba:compile"


class _Listener(event.Listener):
    """A listener that calls a function when a kernel begins to be compiled."""

    def __init__(self, tell: Callable[[], object]) -> None:
        self._tell = tell

    def on_start(self, event: Any) -> None:
        """Call the function."""
        self._tell()

    def on_end(self, event: Any) -> None:
        """Do nothing."""


def tell_always(tell: Callable[[], object]) -> None:
    """Call a function whenever this process begins to compile a kernel."""
    event.register(_KIND, _Listener(tell))  # type: ignore[no-untyped-call]


@contextmanager
def told(tell: Callable[[], object]) -> Iterator[None]:
    """Call a function in this context when a kernel begins to be compiled."""
    listener = _Listener(tell)
    event.register(_KIND, listener)  # type: ignore[no-untyped-call]
    try:
        yield
    finally:
        event.unregister(_KIND, listener)  # type: ignore[no-untyped-call]
