"""Rolling contact as a given problem, and its solved state at one position."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rolling._typing import Array
from rolling.contact import _march_kernels
from rolling.contact.window import Window


@dataclass(frozen=True)
class RollingContact:
    """Sphere, the plate it rolls over, and the accuracy of the march.

    Parameters
    ----------
    heights : (along, across) array, m
        Surface of the plate, periodic along and across.
    spacing : float, m
        Node spacing.
    radius : float, m
        Radius of the sphere.
    contact_modulus : float, Pa
        Contact modulus E* of both bodies.
    hardness : float, Pa
        Maximum pressure, infinite for a purely elastic plate.
    load : float, N
        Normal load.
    step : float, m
        Distance between two positions.
    start : float, m
        Place of position 0 along the track.
    tolerance : float
        Maximum KKT residual of a solve.
    single : bool
        If true, iterate on deflections in single precision. Default: true.
    blended : bool
        If true, nodes at the edge of yielding patches bear the share of their cell in contact.
        Default: false.
    loads : (positions,) array, N, or None
        Load at each position of a lap, instead of the same load at all. Default: None.
    """

    heights: Array
    spacing: float
    radius: float
    contact_modulus: float
    hardness: float
    load: float
    step: float
    start: float
    tolerance: float
    single: bool = True
    blended: bool = False
    loads: Array | None = None

    @cached_property
    def row_highest(self) -> Array:
        """Maximum height of each row, an (along,) array [m]."""
        highest: Array = self.heights.max(axis=1)
        return highest

    @cached_property
    def highest(self) -> float:
        """Maximum height [m]."""
        return float(self.row_highest.max())

    @property
    def has_blended_edges(self) -> bool:
        """Tell whether edges are blended.

        An elastic contact has no patch at the hardness whose edge could be blended.
        """
        return self.blended and bool(np.isfinite(self.hardness))

    @property
    def mid_width(self) -> float:
        """Place of the sphere across the track [m]."""
        return float((self.heights.shape[1] - 1) / 2 * self.spacing)

    def loaded_at(self, k: int) -> RollingContact:
        """Return the contact with its load at position k."""
        if self.loads is None:
            return self
        here = copy(self)  # which keeps the maxima of the heights
        lap = len(self.loads) - 1  # the last position of a lap is its first
        object.__setattr__(here, "load", float(self.loads[k if 0 <= k <= lap else k % lap]))
        return here

    def position(self, k: int) -> float:
        """Return the distance [m] of the centre of the sphere along the track at position k."""
        return self.start + k * self.step

    def overlap(self, k: int, approach: float) -> Window | None:
        """Find the window where the undeformed gap is below the approach [m] at position k.

        Contact at this approach or a smaller approach lies inside. Return None without overlap.
        """
        block = _march_kernels.overlap_block(
            self.heights,
            self.row_highest,
            self.highest,
            self.spacing,
            self.radius,
            self.position(k),
            self.mid_width,
            approach,
        )
        return Window.spanning([block]) if block[1] >= block[0] else None

    def gap(self, k: int, window: Window) -> Array:
        """Compute the undeformed gap on a window at position k, a (rows, columns) array [m]."""
        out = np.empty((window.rows, window.columns))
        _march_kernels.undeformed_gap(
            self.heights,
            self.spacing,
            self.radius,
            self.position(k),
            self.mid_width,
            window.row,
            window.column,
            out,
        )
        return out


@dataclass(frozen=True)
class ContactState:
    """Solved contact at one position.

    Parameters
    ----------
    position : int
        Number of the position.
    window : Window
        Nodes of the solve.
    loaded : Window
        Bounding block of the nodes under pressure.
    pressure : (rows, columns) array, Pa
        Contact pressure on the window.
    deflection : (rows, columns) array, m
        Deflection on the window.
    approach : float, m
        Approach of sphere and plate.
    contact_area, plastic_area : float, m2
        Area of the nodes in contact, and area of the nodes at the hardness.
    max_pressure : float, Pa
        Maximum pressure.
    max_deflection : float, m
        Maximum deflection.
    stored_energy : float, J
        Elastic energy.
    residual : float
        KKT residual.
    iterations, convolutions : int
        Cost of the solve.
    edge : (rows, columns) array, m, or None
        Half the range of gaps over partial cells, in which a patch may end; None unless edges are
        blended.
    sphere_share : float
        Share of the initial pressures that moved with the sphere; the rest stayed with the plate.
    """

    position: int
    window: Window
    loaded: Window
    pressure: Array
    deflection: Array
    approach: float
    contact_area: float
    plastic_area: float
    max_pressure: float
    max_deflection: float
    stored_energy: float
    residual: float
    iterations: int
    convolutions: int
    edge: Array | None = None
    sphere_share: float = 0.0
