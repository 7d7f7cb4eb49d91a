"""Slow motion of a run: contiguous maps of pressure and release around one event, for the eye."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rolling._typing import Array


@dataclass(frozen=True)
class SlowMotion:
    """Maps on a part of the plate that stays in place while the sphere passes over it.

    first, stride : int. Position of the first map, and positions from one map to the next.
    along, across : float, m. Plate coordinates of the corner of the first cell.
    cell : float, m. Side of a square cell.
    pressure : (maps, along, across) array of bytes. Mean pressure of each cell over
        `pressure_unit`.
    pressure_unit : float, Pa.
    release : (maps, along, across) array of 16-bit integers. Energy that each cell has released
        since the map before, over `release_unit`.
    release_unit : float, J.
    """

    first: int
    stride: int
    along: float
    across: float
    cell: float
    pressure: NDArray[np.uint8]
    pressure_unit: float
    release: NDArray[np.uint16]
    release_unit: float

    @property
    def positions(self) -> NDArray[np.int64]:
        """Position of each map."""
        positions: NDArray[np.int64] = self.first + self.stride * np.arange(
            len(self.pressure), dtype=np.int64
        )
        return positions

    @classmethod
    def of(
        cls,
        first: int,
        stride: int,
        corner: tuple[float, float],
        cell: float,
        pressure: Array,
        release: Array,
    ) -> SlowMotion:
        """Make a slow motion from pressures [Pa] and releases [J], each (maps, along, across)."""
        small, pressure_unit = _packed(pressure, np.uint8)
        lit, release_unit = _packed(release, np.uint16)
        return cls(first, stride, *corner, cell, small, pressure_unit, lit, release_unit)

    @classmethod
    def none(cls) -> SlowMotion:
        """Return a slow motion without a map, of a stretch that could not be solved again."""
        empty = np.zeros((0, 0, 0))
        return cls.of(0, 1, (0.0, 0.0), 1.0, empty, empty)


def _packed(values: Array, kind: type[np.unsignedinteger]) -> tuple[NDArray[Any], float]:
    """Return values as whole numbers of a unit, and the unit: the maximum over the last number."""
    most = np.iinfo(kind).max
    unit = float(np.max(values, initial=0.0)) / most or 1.0
    return np.rint(values / unit).astype(kind), unit
