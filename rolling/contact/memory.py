"""Permanent indentation: nodes at the hardness that overlap the sphere lower the plate for good.

At a solved position with the gap h = e + u - approach, a node at the hardness H sinks by
w = max(0, -h). Heights lose w and the undeformed gap e gains it, so that the same pressures and
deflections fulfil the contact conditions of the new surface. A node of area dA does the plastic
work H w dA.
"""

from __future__ import annotations

import numpy as np

from acoustics.arrays import Array
from rolling.contact.state import ContactState, RollingContact


def plastic_overlap(contact: RollingContact, state: ContactState) -> Array:
    """Return the plastic overlap [m] of each loaded node of a state, 0 below the hardness."""
    loaded = state.loaded
    window = state.window
    block = np.s_[
        loaded.row - window.row : loaded.row - window.row + loaded.rows,
        loaded.column - window.column : loaded.column - window.column + loaded.columns,
    ]
    gap = contact.gap(state.position, loaded) + state.deflection[block] - state.approach
    return np.where(state.pressure[block] < contact.hardness, 0.0, np.maximum(-gap, 0.0))


def sink(contact: RollingContact, state: ContactState) -> float:
    """Lower the heights of a contact by the plastic overlap; return the plastic work [J].

    The stored maxima of the heights are not lowered; they bound the overlap all the same.
    """
    if state.max_pressure < contact.hardness:
        return 0.0
    depth = plastic_overlap(contact, state)
    loaded = state.loaded
    along, across = contact.heights.shape
    rows = (loaded.row + np.arange(loaded.rows)) % along
    columns = (loaded.column + np.arange(loaded.columns)) % across
    contact.heights[np.ix_(rows, columns)] -= depth
    return float(contact.hardness * contact.spacing**2 * depth.sum())
