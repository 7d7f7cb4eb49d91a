"""Values that a process keeps because they are asked for again, up to a sum of bytes."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

Value = TypeVar("Value")


class Kept(Generic[Value]):
    """Values by their keys, of which those that were used last are kept.

    Parameters
    ----------
    most : int
        Bytes of all values that are kept.
    size : function
        It returns the bytes of a value.
    keeps_last : bool
        Whether the last value is kept however large it is. Default: true.
    """

    def __init__(self, most: int, size: Callable[[Value], int], keeps_last: bool = True) -> None:
        self._most = most
        self._size = size
        self._fewest = 1 if keeps_last else 0
        self._values: dict[Hashable, Value] = {}  # the last used one last

    def value(self, key: Hashable, make: Callable[[], Value]) -> Value:
        """Return the value of a key, which is made unless it is kept."""
        value = self._values.pop(key) if key in self._values else make()
        self._values[key] = value
        while len(self._values) > self._fewest and self._bytes() > self._most:
            del self._values[next(iter(self._values))]
        return value

    def _bytes(self) -> int:
        """Return the bytes of all values that are kept."""
        return sum(map(self._size, self._values.values()))
