"""Memory that stays from solve to solve."""

from __future__ import annotations

from math import prod
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


class Scratch:
    """Arrays that the solves of a march use again, because new memory costs page faults.

    Each march has its own, so that marches in several threads do not meet.
    """

    def __init__(self) -> None:
        self._kept: dict[str, NDArray[Any]] = {}

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
