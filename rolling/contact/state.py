"""Rolling contact as a given problem, and its solved state at one position."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rolling._typing import Array
from rolling.contact import _march_kernels
from rolling.contact.window import Window


@dataclass(eq=False)
class Maxima:
    """Maximum heights of a surface [m], each found when it is first needed.

    Parameters
    ----------
    heights : (along, across) array, m
        Surface of the plate.
    rising : bool
        If true, each cell rises above its node by half its range; otherwise cells are flat.
    """

    heights: Array
    rising: bool

    @cached_property
    def tops(self) -> Array:
        """Maximum height within the cell of each node, an (along, across) array [m]."""
        if not (self.rising and self.heights.any()):
            return self.heights
        tops = np.empty_like(self.heights)
        _march_kernels.cell_tops(self.heights, tops)
        return tops

    @cached_property
    def stretches(self) -> Array:
        """Maximum height of every STRETCH nodes of a row, an (along, stretches) array [m]."""
        first = np.arange(0, self.tops.shape[1], _march_kernels.STRETCH)
        highest: Array = np.maximum.reduceat(self.tops, first, axis=1)
        return highest

    @cached_property
    def rows(self) -> Array:
        """Maximum height of each row, an (along,) array [m]."""
        highest: Array = self.stretches.max(axis=1)
        return highest

    @cached_property
    def highest(self) -> float:
        """Maximum height [m]."""
        return float(self.rows.max())


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
    subcells : int
        Nodes along the side of a cell of the transforms; nodes are sub-cells where it is more than
        1. Cells begin at node 0, and their centre is a place of the track. Default: 1.
    slopes : bool
        If true, the surface continues between the nodes; otherwise each cell is flat. Default:
        true.
    loads : (positions,) array, N, or None
        Load at each position of a lap, instead of the same load at all. Default: None.
    known : Maxima or None
        Maximum heights of the surface, which further contacts on it share. Default: they are found
        anew.
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
    subcells: int = 1
    slopes: bool = True
    loads: Array | None = None
    known: Maxima | None = None

    @cached_property
    def maxima(self) -> Maxima:
        """Maximum heights of the surface; with blended edges its cells rise above their nodes."""
        known, rising = self.known, self.has_blended_edges and self.slopes
        if known is not None and known.heights is self.heights and known.rising == rising:
            return known
        return Maxima(self.heights, rising)

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

    @property
    def cell_spacing(self) -> float:
        """Side of a cell [m]."""
        return self.spacing * self.subcells

    @property
    def cell_shape(self) -> tuple[int, int]:
        """Numbers of cells of the surface along and across."""
        along, across = self.heights.shape
        return along // self.subcells, across // self.subcells

    @property
    def off_centre(self) -> float:
        """Distance from the first node of a cell to the centre of the cell [m]."""
        return (self.subcells - 1) / 2 * self.spacing

    def overlap(self, k: int, approach: float) -> Window | None:
        """Find the window where the undeformed gap is below the approach [m] at position k.

        Contact at this approach or a smaller approach lies inside. Return None without overlap.

        With blended edges a node may bear part of its cell. The gap then is that of the top of each
        cell, and a border of one node allows for the slope that the sphere adds.
        """
        row, last_row, column, last_column = _march_kernels.overlap_block(
            self.maxima.tops,
            self.maxima.stretches,
            self.maxima.rows,
            self.maxima.highest,
            self.spacing,
            self.radius,
            self.position(k) + self.off_centre,
            self.mid_width,
            approach,
        )
        if last_row < row:
            return None
        window = Window(row, column, last_row - row + 1, last_column - column + 1)
        return window.bordered() if self.has_blended_edges else window

    def gap(self, k: int, window: Window) -> Array:
        """Compute the undeformed gap on a window at position k, a (rows, columns) array [m]."""
        return self._gap(k, window, self.heights)

    def shape(self, k: int, window: Window, gap: Array) -> Array | None:
        """Return the gap as it continues within cells, for blended edges; None for sharp edges.

        Where cells are flat, it is the gap of the sphere alone.
        """
        if not self.has_blended_edges:
            return None
        return gap if self.slopes else self._gap(k, window, np.zeros((1, 1)))

    def _gap(self, k: int, window: Window, heights: Array) -> Array:
        out = np.empty((window.rows, window.columns))
        _march_kernels.undeformed_gap(
            heights,
            self.spacing,
            self.radius,
            self.position(k) + self.off_centre,
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
        Half the range of gaps over the cells; None unless edges are blended.
    edge_share : float
        Share of the range of gaps over each cell that its edge takes: 0 where all are sharp.
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
    edge_share: float = 0.0
    sphere_share: float = 0.0
