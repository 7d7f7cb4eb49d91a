"""Memory that stays from solve to solve.

New memory costs a page fault for each 4 kB, which took up to a tenth of the time of a position.
"""

from __future__ import annotations

import sys
from math import prod
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from acoustics.arrays import Array

_LENT = 16  # arrays of states that are remembered: those of the last four positions


class Scratch:
    """Arrays that the solves of a march use again.

    Each march has its own, so that marches in several threads do not meet.
    """

    def __init__(self) -> None:
        self._kept: dict[str, NDArray[Any]] = {}
        self._lent: list[Array] = []

    def array(
        self, name: str, shape: tuple[int, ...], dtype: DTypeLike = np.float64
    ) -> NDArray[Any]:
        """Return an array with any values, which the next one of this name overwrites."""
        size = prod(shape)
        kept = self._kept.get(name)
        if kept is None or kept.size < size:
            kept = np.empty(size + size // 4, dtype)
            self._kept[name] = kept
        return kept[:size].reshape(shape)

    def lend(self, shape: tuple[int, ...]) -> Array:
        """Return an array with any values, which is the caller's as long as anything holds it.

        A state that is dropped gives its arrays back. Views hold the array that they are part of.
        """
        size = prod(shape)
        for k in range(len(self._lent)):
            if _references(self._lent, k) == _UNUSED and size <= self._lent[k].size <= 2 * size:
                return self._lent[k][:size].reshape(shape)
        new = np.empty(size + size // 8)
        self._lent = [*self._lent[1 - _LENT :], new]
        return new[:size].reshape(shape)


def _references(arrays: list[Array], k: int) -> int:
    """Return the number of references to an array of a list, as this version of Python counts."""
    return sys.getrefcount(arrays[k])


_UNUSED = _references([np.empty(0)], 0)  # of an array that nothing else holds
