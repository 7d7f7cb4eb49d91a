"""Rolling contact as a given problem, its windows, and its solved state at one position."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite, pi
from typing import Any, NamedTuple

import numpy as np

from acoustics.arrays import Array, finite, positive, real_array, truth
from acoustics.traps import ignoring_underflow
from rolling.contact import _window_kernels, units
from rolling.contact.half_space import MAX_SIZE

# Share of the minimum deflection by a load that counts; the slope of the deflection within a cell
# takes less than the rest. Near a load deflections are less than 1/r: between sub-cells by 36 to
# 66 % beside it and by 1 % up to 5 cells away, and on the far side of a cell with a blended edge by
# half a spacing over r. The load counts as so much farther away.
SURE = 0.99
NEAR_CELLS = 6.0
# Distance of a place from the beginning of the track, in node spacings and in steps. Double
# precision then tells places apart that differ by 2e-7 of either.
MAX_DISTANCE = 1e9


class Window(NamedTuple):
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
    def around(cls, windows: Sequence[Window | None]) -> Window:
        """Return the minimum window that covers all given windows; None stands for no window."""
        around, *others = [window for window in windows if window is not None]
        for window in others:
            around = around.joined(window)
        return around

    def joined(self, other: Window | None) -> Window:
        """Return the minimum window that covers this and another one; None is no window."""
        if other is None:
            return self
        row = min(self.row, other.row)
        column = min(self.column, other.column)
        end = max(self.row + self.rows, other.row + other.rows)
        right = max(self.column + self.columns, other.column + other.columns)
        return Window(row, column, end - row, right - column)

    def covers(self, other: Window) -> bool:
        """Tell whether all nodes of another window lie in this window."""
        return (
            self.row <= other.row
            and self.column <= other.column
            and self.row + self.rows >= other.row + other.rows
            and self.column + self.columns >= other.column + other.columns
        )

    def shifted(self, nodes: int) -> Window:
        """Return the window so many nodes farther along."""
        return self._replace(row=self.row + nodes)

    def whole(self, subcells: int) -> Window:
        """Widen the window to whole cells of so many nodes along and across."""
        if subcells == 1:
            return self
        row = self.row // subcells * subcells
        column = self.column // subcells * subcells
        rows = -(-(self.row + self.rows - row) // subcells) * subcells
        columns = -(-(self.column + self.columns - column) // subcells) * subcells
        return Window(row, column, rows, columns)

    def room(self, subcells: int) -> Window:
        """Return the window of a solve: this one and a border of open nodes, in whole cells."""
        border = Window(self.row - 1, self.column - 1, self.rows + 2, self.columns + 2)
        return border.whole(subcells)

    def cells(self, subcells: int) -> Window:
        """Return the cells of a window of whole cells."""
        return Window(*(number // subcells for number in self))

    def moved(self, values: Array, target: Window, continued: bool = False) -> Array:
        """Copy values (rows, columns) into the target window, with zeros off this window.

        Where they are `continued`, the nearest ones are there instead.
        """
        out = np.empty((target.rows, target.columns))
        self.move(values, target, out, continued)
        return out

    def move(self, values: Array, target: Window, out: Array, continued: bool = False) -> None:
        """Copy values into an array of the target window, as `moved` does."""
        row = self.row - target.row
        column = self.column - target.column
        _window_kernels.copy_block(values, out, row, column, continued)


class Maxima(NamedTuple):
    """Maximum heights [m] of a surface: of each cell, of STRETCH nodes, of each row, and of all."""

    tops: Array
    stretches: Array
    rows: Array
    highest: float


_surfaces: list[tuple[Array, float, dict[Hashable, Any]]] = []  # the last two with their values


def kept(heights: Array, name: Hashable, make: Callable[[], Any]) -> Any:
    """Return a value of heights, which is kept because all pieces of a track share them.

    Heights that were overwritten are other heights.
    """
    along, across = (np.sqrt(np.arange(1.0, n + 1)) for n in heights.shape)
    number = float(along @ heights @ across)  # which depends on the places of the heights
    known = next((held for z, own, held in _surfaces if z is heights and own == number), None)
    if known is None:
        known = {}
        _surfaces[:] = [*_surfaces[-1:], (heights, number, known)]
    if name not in known:
        known[name] = make()
    return known[name]


def maxima_of(heights: Array, rising: bool) -> Maxima:
    """Return the maximum heights of a surface, whose cells rise above their nodes by the slope.

    They do not unless `rising`.
    """
    tops = heights
    if rising and heights.any():
        tops = np.empty_like(heights)
        _window_kernels.cell_tops(heights, tops)
    first = np.arange(0, tops.shape[1], _window_kernels.STRETCH)
    stretches = np.maximum.reduceat(tops, first, axis=1)
    rows = stretches.max(axis=1)
    return Maxima(tops, stretches, rows, float(rows.max()))


@dataclass(frozen=True)
class Geometry:
    """Sphere over a plate as the march asks for it at each position, without checks.

    Parameters
    ----------
    heights : (along, across) array, m
        Surface of the plate.
    maxima : tuple
        Fields of `Maxima` of the surface.
    spacing, radius, radius_across : float, m
        Node spacing, and radii of the sphere.
    start, step, off_centre, mid_width : float, m
        Place of position 0, distance of two positions, distance from the first node of a cell to
        its centre, and place across.
    blended : bool
        Whether edges are blended.
    pi_modulus : float, Pa
        pi E*, over which the load gives the minimum deflection.
    near2 : float, m2
        Squared distance that the load counts as farther away.
    """

    heights: Array
    maxima: tuple[Array, Array, Array, float]
    spacing: float
    radius: float
    radius_across: float
    start: float
    step: float
    off_centre: float
    mid_width: float
    blended: bool
    pi_modulus: float
    near2: float

    def sphere(self, k: int) -> tuple[float, float, float, float, float]:
        """Return the spacing, and radii and place of the sphere at position k, for kernels."""
        x = self.start + k * self.step + self.off_centre
        return self.spacing, self.radius, self.radius_across, x, self.mid_width

    def overlap(self, k: int, approach: float, load: float, spread: float) -> Window | None:
        """Find the window of `RollingContact.overlap` for a load [N]."""
        least = SURE * load / self.pi_modulus, spread * spread + self.near2
        ends = _window_kernels.overlap(self.maxima, self.sphere(k), approach, least, self.blended)
        return Window(*ends) if ends[2] else None

    def gap(self, k: int, window: Window, out: Array) -> None:
        """Set an array to the undeformed gap on a window at position k [m]."""
        row = window.row
        column = window.column
        _window_kernels.undeformed_gap(self.heights, self.sphere(k), row, column, out)


@ignoring_underflow
@dataclass(frozen=True)
class RollingContact:
    """Sphere, the plate it rolls over, and the accuracy of the march.

    Parameters
    ----------
    heights : (along, across) array, m
        Surface of the plate, periodic along and across. Its rms slope is 10 at most, and its rms
        height less than the radii.
    spacing : float, m
        Node spacing.
    radius : float, m
        Radius of the sphere along the track.
    contact_modulus : float, Pa
        Contact modulus E* of both bodies.
    hardness : float, Pa
        Maximum pressure, infinite for a purely elastic plate.
    load : float, N
        Normal load.
    step : float, m
        Distance between two positions.
    start : float, m
        Place of position 0 along the track, at most 1e9 spacings and steps away.
    tolerance : float
        Maximum KKT residual of a solve, at most 1.
    single : bool
        If true, iterate on deflections in single precision. Default: true.
    blended : bool
        If true, nodes at the edge of yielding patches bear the share of their cell in contact.
        Default: true, as in scenes.
    subcells : int
        Nodes along the side of a cell of the transforms; nodes are sub-cells where it is more than
        1. Cells begin at node 0, and their centre is a place of the track. Default: 1.
    slopes : bool
        If true, the surface continues between the nodes; otherwise each cell is flat. Default:
        true.
    loads : (positions,) array, N, or None
        Load at each position of a lap, its end included, instead of the same load at all: two or
        more. Default: None.
    radius_across : float, m, or None
        Radius of the sphere across the track. Default: the radius along it.

    Examples
    --------
    >>> import numpy as np, rolling
    >>> rolling.RollingContact(
    ...     heights=np.zeros((128, 128)), spacing=4e-6, radius=5e-3, contact_modulus=230e9,
    ...     hardness=2.1e9, load=5.0, step=4e-6, start=0.0, tolerance=1e-5,
    ... )
    RollingContact(128 x 128 nodes of 4e-06 m, sphere of 0.005 m under 5 N, E* 2.3e+11 Pa, ...)
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
    blended: bool = True
    subcells: int = 1
    slopes: bool = True
    loads: Array | None = None
    radius_across: float | None = None

    def __repr__(self) -> str:
        along, across = self.heights.shape
        return (
            f"RollingContact({along} x {across} nodes of {self.spacing:g} m, sphere of"
            f" {self.radius:g} m under {self.load:g} N, E* {self.contact_modulus:g} Pa, hardness"
            f" {self.hardness:g} Pa)"
        )

    def __post_init__(self) -> None:
        heights = np.require(real_array("heights", self.heights, 2), requirements=["C", "W"])
        object.__setattr__(self, "heights", heights)
        for name in ("spacing", "radius", "step", "contact_modulus", "load"):
            positive(name, getattr(self, name), MAX_SIZE)
        positive("hardness", self.hardness, infinite=True)
        positive("tolerance", self.tolerance, 1.0)
        if self.radius_across is not None:
            positive("radius_across", self.radius_across, MAX_SIZE)
        finite("start", self.start, self.farthest_m)
        for name in ("single", "blended", "slopes"):
            truth(name, getattr(self, name))
        if type(self.subcells) is not int or not 1 <= self.subcells <= min(heights.shape):
            allowed = f"a whole number from 1 to {min(heights.shape)}, the nodes of the surface"
            raise ValueError(f"subcells: got {self.subcells!r}, allowed: {allowed}")
        if self.loads is not None:
            loads = real_array("loads", self.loads, 1)
            if len(loads) < 2:
                allowed = "the loads of two positions or more; `load` is the same at all"
                raise ValueError(f"loads: got {len(loads)} number, allowed: {allowed}")
            positive("loads", loads.min())
            object.__setattr__(self, "loads", loads)
        self._refuse_other_units()

    def _refuse_other_units(self) -> None:
        """Raise ValueError for heights that cannot be metres."""
        highest = kept(self.heights, "highest", lambda: np.abs(self.heights).max(keepdims=True))
        units.refuse_high("heights", highest)
        r = self.subcells  # cells may be flat, with steps between them
        cells = self.heights[::r, ::r]
        slope = kept(self.heights, ("slope", r), lambda: units.rms_slope(cells))
        if slope > units.MAX_SLOPE * self.cell_spacing:
            units.refuse_steep("heights", cells, self.cell_spacing)
        rms = kept(self.heights, "rms height", lambda: units.rms_height(self.heights))
        units.refuse_rough("heights", rms, min(self.radii))

    @property
    def farthest_m(self) -> float:
        """Distance [m] of a place from the beginning of the track, up to which places are told."""
        return MAX_DISTANCE * min(self.spacing, self.step)

    @cached_property
    def maxima(self) -> Maxima:
        """Maximum heights of the surface; with blended edges its cells rise above their nodes."""
        z = self.heights
        rising = self.has_blended_edges and self.slopes
        maxima: Maxima = kept(z, ("maxima", rising), lambda: maxima_of(z, rising))
        return maxima

    @property
    def has_blended_edges(self) -> bool:
        """Whether edges are blended; an elastic contact has no patch at the hardness."""
        return self.blended and isfinite(self.hardness)

    @property
    def radii(self) -> tuple[float, float]:
        """Radii of the sphere along and across the track [m]."""
        return self.radius, self.radius if self.radius_across is None else self.radius_across

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

    def overlap(self, k: int, approach: float, spread: float = inf) -> Window | None:
        """Find the window where contact at an approach [m] can be at position k, if any.

        The gap, with the minimum deflection by a load of this spread [m], is below the approach
        there. Contact at a smaller approach, or of a smaller spread, lies inside. With blended
        edges the gap is that of the top of each cell, and there is a border of one node, because
        the edge of a cell needs nodes on both sides.
        """
        return self.geometry.overlap(k, approach, self.load, spread)

    def gap(self, k: int, window: Window) -> Array:
        """Compute the undeformed gap on a window at position k, a (rows, columns) array [m]."""
        gap = np.empty((window.rows, window.columns))
        self.geometry.gap(k, window, gap)
        return gap

    @cached_property
    def geometry(self) -> Geometry:
        """Sphere over the plate, which a change of the load leaves as it is."""
        reaching = self.subcells > 1 or self.has_blended_edges
        near = NEAR_CELLS * self.cell_spacing if reaching else 0.0
        radius, radius_across = self.radii
        highest = self.maxima
        return Geometry(
            heights=self.heights,
            maxima=(highest.tops, highest.stretches, highest.rows, highest.highest),
            spacing=float(self.spacing),
            radius=float(radius),
            radius_across=float(radius_across),
            start=float(self.start),
            step=float(self.step),
            off_centre=self.off_centre,
            mid_width=self.mid_width,
            blended=self.has_blended_edges,
            pi_modulus=pi * self.contact_modulus,
            near2=near**2,
        )


@ignoring_underflow
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
        Cost of the solve. A convolution is a deflection by transforms or by direct sums.
    edge : (rows, columns) array, m, or None
        Half the range of gaps over the cells; None unless edges are blended.
    edge_share : float
        Share of the range of gaps over each cell that its edge takes: 0 where all are sharp.
    sphere_share : float
        Share of the initial pressures that moved with the sphere; the rest stayed with the plate.
    spread : float, m
        Root mean square distance of the load from the centre of the sphere, and a bound for loads
        beside it: see `measures` of `_window_kernels`.

    Examples
    --------
    >>> import numpy as np, rolling
    >>> contact = rolling.RollingContact(
    ...     heights=np.zeros((128, 128)), spacing=4e-6, radius=5e-3, contact_modulus=230e9,
    ...     hardness=np.inf, load=5.0, step=4e-6, start=0.0, tolerance=1e-5,
    ... )
    >>> (state,) = rolling.march(contact, 0, 0, rolling.HalfSpace(4e-6, 230e9))
    >>> print(f"{state.approach * 1e9:.0f} nm, {state.stored_energy * 1e9:.0f} nJ")
    376 nm, 752 nJ
    """

    def __repr__(self) -> str:
        return (
            f"ContactState(position {self.position}: area {self.contact_area:.4g} m2, approach"
            f" {self.approach:.4g} m, maximum pressure {self.max_pressure:.4g} Pa)"
        )

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
    spread: float = inf
