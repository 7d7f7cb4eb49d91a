"""Shares of a further load that each node of a contact would bear, along a track.

They are the linear response of a contact to its surface, however nonlinear the contact is. The
energy of a contact has its minimum over the pressures, and its derivative by the load is the
approach. So a small change of the gaps changes the approach by the mean of this change, weighted by
the shares, and higher nodes lower the approach.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.state import RollingContact, Window

LOAD_RATIO = 1.03  # of the higher and the lower load to that of the contact


@dataclass(frozen=True, eq=False)
class LoadShares:
    """Shares of a further load at one position, which add up to 1.

    window : Window. The nodes.
    shares : (rows, columns) array. The share of each node.
    """

    window: Window
    shares: NDArray[np.float32]


def load_shares(contact: RollingContact, half_space: HalfSpace, last: int) -> list[LoadShares]:
    """March a track at two loads, and return the shares at the positions 0 to `last`.

    Raises
    ------
    ContactError : a contact has no solution.
    """
    lower = march(replace(contact, load=contact.load / LOAD_RATIO), 0, last, half_space)
    higher = march(replace(contact, load=contact.load * LOAD_RATIO), 0, last, half_space)
    along_track = []
    for below, above in zip(lower, higher, strict=True):
        window = below.loaded.joined(above.loaded)
        further = above.window.moved(above.pressure, window)
        further -= below.window.moved(below.pressure, window)
        shares = (further / further.sum()).astype(np.float32)
        along_track.append(LoadShares(window=window, shares=shares))
    return along_track


def approach_of_part(part: Array, along_track: Sequence[LoadShares]) -> Array:
    """Return the approach that follows from a part of the heights, to first order.

    Parameters
    ----------
    part : (nodes along, nodes across) array, m
        Part of the heights of the contact, on its nodes.
    along_track : sequence of LoadShares
        Shares of a further load at each position.

    Returns
    -------
    approach : (positions,) array, m
    """
    along, across = part.shape
    approach = np.empty(len(along_track))
    for position, at in enumerate(along_track):
        window = at.window
        rows = np.arange(window.row, window.row + window.rows) % along
        columns = np.arange(window.column, window.column + window.columns) % across
        approach[position] = -np.vdot(part[rows[:, None], columns], at.shares)
    return approach
