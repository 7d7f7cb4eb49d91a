"""Windows: blocks of nodes on the unrolled plate, where contact is solved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rolling._typing import Array
from rolling.contact import _march_kernels


@dataclass(frozen=True)
class Window:
    """Block of nodes on the unrolled plate.

    Parameters
    ----------
    row, column : int
        First node along and across; it may be negative.
    rows, columns : int
        Number of nodes along and across.
    """

    row: int
    column: int
    rows: int
    columns: int

    @classmethod
    def around(cls, windows: Sequence[Window]) -> Window:
        """Return the minimum window that covers all given windows."""
        row, column = min([w.row for w in windows]), min([w.column for w in windows])
        end = max([w.row + w.rows for w in windows])
        column_end = max([w.column + w.columns for w in windows])
        return cls(row, column, end - row, column_end - column)

    def covers(self, other: Window) -> bool:
        """Tell whether all nodes of another window lie in this window."""
        return (
            self.row <= other.row
            and self.column <= other.column
            and self.row + self.rows >= other.row + other.rows
            and self.column + self.columns >= other.column + other.columns
        )

    def bordered(self) -> Window:
        """Add a node on every side, open in any contact that this window cannot cut off."""
        return Window(self.row - 1, self.column - 1, self.rows + 2, self.columns + 2)

    def whole(self, subcells: int) -> Window:
        """Widen the window to whole cells of so many nodes along and across."""
        row, column = self.row // subcells * subcells, self.column // subcells * subcells
        rows = -(-(self.row + self.rows - row) // subcells) * subcells
        columns = -(-(self.column + self.columns - column) // subcells) * subcells
        return Window(row, column, rows, columns)

    def cells(self, subcells: int) -> Window:
        """Return the cells of a window of whole cells."""
        return Window(
            self.row // subcells,
            self.column // subcells,
            self.rows // subcells,
            self.columns // subcells,
        )

    def moved(self, values: Array, target: Window) -> Array:
        """Copy values (rows, columns) of this window into the target window.

        They are zero where this window does not reach.
        """
        out = np.empty((target.rows, target.columns))
        _march_kernels.copy_block(values, out, self.row - target.row, self.column - target.column)
        return out
