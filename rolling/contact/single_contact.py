"""One contact on a window of nodes under a normal load, for callers outside of a march.

The numbers of a caller are checked here. `solver` solves the contact.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array, instance, positive, real_array, short_repr, truth
from acoustics.traps import ignoring_underflow
from rolling.contact import units
from rolling.contact.half_space import MAX_NODES, MAX_SIZE, HalfSpace
from rolling.contact.solver import (
    ContactError,
    ContactPlate,
    Problem,
    Solution,
    Start,
    foundation,
    levelled_range,
    solve,
)

# A cold solve on a window of so many nodes begins with the contact of cells twice as wide, to this
# tolerance. On 19 surfaces 400 to 1,024 nodes wide it takes 0.2 to 1.1 of the time. Tolerances
# of 1e-2 take longer on 16 of them; 2e-4, or windows from 128 by 128 nodes on, take as long.
CASCADE_NODES = 256 * 256
CASCADE_TOLERANCE = 1e-3
_NOTHING = np.empty((0, 0))


@ignoring_underflow
@dataclass(frozen=True)
class Contact:
    """Solved contact on its window.

    Parameters
    ----------
    pressure : (m, n) array, Pa
        Contact pressure.
    deflection : (m, n) array, m
        Deflection of both bodies.
    spacing : float, m
        Node spacing.
    approach : float, m
        Approach of sphere and plate.
    max_deflection : float, m
        Maximum deflection.
    residual : float
        KKT residual: maximum violation of the contact conditions over the maximum deflection, from
        a recomputed deflection.
    iterations : int
        Number of iterations of the solve.
    edge : (m, n) array, m, or None
        Half the range of gaps over the cell of each node, where edges are blended.
    edge_share : float
        Share of the range of gaps over each cell that its edge takes: 1 where the contact yields in
        full, less where it hardly yields, and 0 where all edges are sharp.
    plastic_area : float, m2
        Area of the nodes at the hardness, 0 for an elastic contact. Where edges are blended, a cell
        that the edge of a yielding patch crosses counts with its share, as in the series
        `plastic_area` of a run.

    Examples
    --------
    A rigid flat of 20 by 20 um is pressed into steel:

    >>> import numpy as np, rolling
    >>> gap = np.full((30, 30), 1e-6)
    >>> gap[5:25, 5:25] = 0.0
    >>> contact = rolling.solve_contact(rolling.HalfSpace(1e-6, 230e9), gap, load=0.1)
    >>> print(f"{contact.contact_area * 1e12:.0f} um2, {contact.load:.3f} N, {contact.spacing:g} m")
    400 um2, 0.100 N, 1e-06 m
    >>> bool(contact.max_pressure == contact.pressure.max()), contact.plastic_area
    (True, 0.0)
    """

    pressure: Array
    deflection: Array
    spacing: float
    approach: float
    max_deflection: float
    residual: float
    iterations: int
    edge: Array | None = None
    edge_share: float = 0.0
    plastic_area: float = 0.0

    @property
    def contact_area(self) -> float:
        """Area of the nodes under pressure [m2]."""
        return float(np.count_nonzero(self.pressure) * self.spacing**2)

    @property
    def max_pressure(self) -> float:
        """Maximum pressure [Pa]; 3 W / (2 pi a^2) for a smooth sphere (Hertz, 1882)."""
        return float(self.pressure.max())

    @property
    def load(self) -> float:
        """Normal load [N], the sum of the pressure over the window."""
        return float(self.pressure.sum() * self.spacing**2)

    def __repr__(self) -> str:
        return (
            f"Contact({self.load:.4g} N on {self.contact_area:.4g} m2,"
            f" approach {self.approach:.4g} m, maximum pressure {self.max_pressure:.4g} Pa,"
            f" residual {self.residual:.1e})"
        )


@ignoring_underflow
@dataclass(frozen=True)
class WarmStart:
    """Pressures to start a solve from, with all known data about them.

    Parameters
    ----------
    pressure : (m, n) array, Pa
        Pressure between 0 and the hardness that carries the load to rounding.
    deflection : (m, n) array, m, or None
        Deflection by `pressure`. Default: it is computed.
    close : bool
        If true, iterate only on nodes in or near contact and check the others after convergence.
        Use it when the start is close to the solution. Default: false.

    Examples
    --------
    >>> import numpy as np, rolling
    >>> x = np.arange(-12, 13) * 2e-6
    >>> steel, gap = rolling.HalfSpace(2e-6, 230e9), (x[:, None] ** 2 + x**2) / 0.01
    >>> cold = rolling.solve_contact(steel, gap, 0.02)
    >>> start = rolling.WarmStart(cold.pressure, cold.deflection, close=True)
    >>> rolling.solve_contact(steel, gap, 0.02, start).iterations <= cold.iterations
    True
    """

    pressure: Array
    deflection: Array | None = None
    close: bool = False
    __repr__ = short_repr


def _cold_start(half_space: HalfSpace, gap: Array, load: float, hardness: float) -> WarmStart:
    """Start from the contact of cells twice as wide on a wide window, else from a foundation.

    This is the cascade of F. A. Bornemann and P. Deuflhard, Numer. Math. 75 (1996): the coarse
    contact costs a fraction of a fine iteration and has all long waves of the pressure. The Winkler
    foundation fits a contact of half the window's width.
    """
    # Beyond MAX_NODES only starts whose pressures lie close together fit the transforms.
    if gap.size >= CASCADE_NODES and min(gap.shape) >= 2 and max(gap.shape) <= MAX_NODES:
        with suppress(ContactError):  # the fine contact says what is wrong in its own numbers
            return _coarse_start(half_space, gap, load, hardness)
    radius = 0.25 * max(gap.shape) * half_space.spacing
    stiffness = 4 * half_space.contact_modulus / (np.pi * radius)
    return WarmStart(foundation(gap, load, half_space.spacing, stiffness, hardness))


def _coarse_start(half_space: HalfSpace, gap: Array, load: float, hardness: float) -> WarmStart:
    """Solve the contact of cells twice as wide, and give each node the pressure of its cell.

    An odd last row or column is left out, and begins open.
    """
    rows = gap.shape[0] // 2
    columns = gap.shape[1] // 2
    cells = gap[: 2 * rows, : 2 * columns].reshape(rows, 2, columns, 2)
    coarse = solve_contact(
        half_space.coarser(),
        cells.mean(axis=(1, 3)),
        load,
        hardness=hardness,
        tolerance=CASCADE_TOLERANCE,
    )
    pressure = np.zeros(gap.shape)
    pressure[: 2 * rows, : 2 * columns] = coarse.pressure.repeat(2, axis=0).repeat(2, axis=1)
    return WarmStart(pressure)


@ignoring_underflow
def solve_contact(
    half_space: HalfSpace,
    gap: Array,
    load: float,
    start: WarmStart | None = None,
    hardness: float = np.inf,
    shape: Array | None = None,
    tolerance: float = 1e-5,
    single: bool = True,
) -> Contact:
    """Solve one contact under a normal load on a window of nodes.

    The window must hold the whole contact, because all nodes outside count as open.

    Parameters
    ----------
    half_space : HalfSpace
        Pressure to deflection.
    gap : (m, n) array, m
        Undeformed gap. Its rms slope is 10 at most, but for steep sides such as those of a punch.
    load : float, N
        Normal load.
    start : WarmStart or None
        Start of the iteration. Default: a Winkler foundation, or on wide windows the contact of
        cells twice as wide, whose iterations are not counted.
    hardness : float, Pa
        Maximum pressure. Default: infinite, purely elastic.
    shape : (m, n) array, m, or None
        Undeformed gap as it continues within cells, for blended edges: a patch at the hardness then
        ends within a cell, where the gap of its own solution says (`cell_ranges`). Default: a cell
        is in contact as a whole or not at all.
    tolerance : float
        Maximum KKT residual: violation of the contact conditions over the maximum deflection.
        Default: 1e-5.
    single : bool
        If true, iterate on deflections in single precision while the tolerance is far above their
        error. A solution is accepted in double precision in any case. Default: true.

    Returns
    -------
    Contact
        Pressure, deflection and approach, with residual and number of iterations.

    Raises
    ------
    ContactError
        The window cannot carry the load, or the solve did not converge; the message has residual,
        iterations and the methods tried.
    ValueError
        The start or the shape has another shape than the gap, a number is not positive, or the gap
        holds no finite numbers in two dimensions or cannot be in metres.
    TypeError
        The half-space or the start is of another type.

    Examples
    --------
    A steel sphere of 5 mm radius under 5 N, against Hertz:

    >>> import numpy as np, rolling
    >>> steel = rolling.HalfSpace(spacing=2e-6, contact_modulus=230e9)
    >>> x = np.arange(-40, 41) * steel.spacing
    >>> contact = rolling.solve_contact(steel, (x[:, None] ** 2 + x**2) / (2 * 5e-3), load=5.0)
    >>> hertz = rolling.closed_forms.hertz_approach(5.0, 5e-3, 230e9)
    >>> bool(abs(contact.approach / hertz - 1) < 1e-3)
    True
    """
    instance("half_space", half_space, HalfSpace)
    instance("start", start, WarmStart, type(None))
    gap = _plain("gap", gap)
    load = positive("load", load, MAX_SIZE)
    hardness = positive("hardness", hardness, infinite=True)
    tolerance = positive("tolerance", tolerance, 1.0)
    single = truth("single", single)
    units.refuse_high("gap", gap)
    units.refuse_steep("gap", gap, half_space.spacing)
    shape = None if shape is None else _plain("shape", shape, gap)
    start = start or _cold_start(half_space, gap, load, hardness)
    close = truth("start.close", start.close)
    blended = shape is not None
    pressure = _plain("start.pressure", start.pressure, gap).copy()
    deflection = _NOTHING
    if start.deflection is not None:
        deflection = _plain("start.deflection", start.deflection, gap)
    problem = Problem(
        plate=ContactPlate(
            half_space, hardness, single, blended, levelled_range(half_space, hardness)
        ),
        gap=gap,
        shape=gap if shape is None else shape,
        total=load / half_space.spacing**2,
        tolerance=tolerance,
    )
    solution = solve(problem, Start(pressure, deflection, close), sharp=not blended)
    return Contact(
        pressure=solution.pressure,
        deflection=solution.deflection,
        spacing=half_space.spacing,
        approach=solution.approach,
        max_deflection=solution.max_deflection,
        residual=solution.worst / solution.max_deflection,
        iterations=solution.iterations,
        edge=solution.edge if blended else None,
        edge_share=solution.edge_share,
        plastic_area=_plastic_nodes(problem.plate, solution) * half_space.spacing**2,
    )


def _plastic_nodes(plate: ContactPlate, solution: Solution) -> float:
    """Return the number of nodes at the hardness, as `shares_of_row` of a march counts them."""
    pressure = solution.pressure
    whole = np.count_nonzero(pressure >= plate.hardness)
    if not whole or not plate.blended:
        return float(whole)
    crossed = (pressure > 0) & (pressure < plate.hardness) & (solution.edge > 0)
    half_range = solution.edge[crossed]
    share = half_range / np.maximum(half_range, 0.5 * half_range + plate.levelled)
    return whole + float(np.sum(share * pressure[crossed]) / plate.hardness)


def _plain(name: str, array: Array, like: Array | None = None) -> Array:
    """Return an array as compiled code takes it, or a copy: in C order, and open to writing.

    Raise ValueError unless it has the shape of the array that it belongs to.
    """
    plain = np.require(real_array(name, array, 2), float, ["C", "W"])
    if like is not None and plain.shape != like.shape:
        raise ValueError(f"{name}: got an array of shape {plain.shape}, allowed: {like.shape}")
    return plain
