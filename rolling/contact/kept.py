"""Values that a process keeps because they are asked for again, up to a sum of bytes."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from threading import Lock
from typing import Generic, TypeVar

Value = TypeVar("Value")


class Kept(Generic[Value]):
    """Values by their keys, of which those that were used last are kept.

    Threads may ask for them at the same time.

    Parameters
    ----------
    most : int
        Bytes of all values that are kept.
    size : function
        It returns the bytes of a value.
    fewest : int
        Number of last values that are kept however large they are. Where it is 0, a value of more
        bytes than all may have is not kept, so that it displaces no others.
    """

    def __init__(self, most: int, size: Callable[[Value], int], fewest: int = 1) -> None:
        self._most = most
        self._size = size
        self._fewest = fewest
        self._lock = Lock()
        self._values: dict[Hashable, Value] = {}  # the last used one last

    def value(self, key: Hashable, make: Callable[[], Value]) -> Value:
        """Return the value of a key, which is made unless it is kept."""
        with self._lock:
            if key in self._values:
                self._values[key] = self._values.pop(key)
                return self._values[key]
        # Not under the lock: others need not wait, though two threads may make the same value.
        value = make()
        if self._fewest == 0 and self._size(value) > self._most:
            return value
        with self._lock:
            self._values[key] = value
            while len(self._values) > self._fewest and self._bytes() > self._most:
                del self._values[next(iter(self._values))]
        return value

    def _bytes(self) -> int:
        """Return the bytes of all values that are kept."""
        return sum(map(self._size, self._values.values()))
