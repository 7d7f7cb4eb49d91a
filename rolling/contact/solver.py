"""Contact solve: pressures between 0 and the hardness on a window, under a given load.

It minimizes 1/2 p.Cp + e.p over p subject to 0 <= p <= H and sum(p) dA = W, by conjugate gradients
projected on both bounds, after Polonsky & Keer, Wear 231 (1999). The solver differs from the paper
in four points: a sparse model problem and its far field on a coarse grid precondition and predict
which nodes go to a bound, these nodes are put on it at once, each trial pressure is made feasible
before its single convolution, after which the step along it is exact, and the last step goes into
the final check without a convolution of its own.

The iteration runs in single precision on candidate nodes only. A solution is accepted after a
double-precision check on the full window.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from acoustics.arrays import Array, instance, positive, real_array, short_repr, truth
from acoustics.numbers import rounded
from acoustics.traps import ignoring_underflow
from rolling.contact import _condition_kernels, _position_kernels, units
from rolling.contact import _descent_kernels as kernels
from rolling.contact._far_field import far_field, stencils
from rolling.contact._system import Limits, Sets
from rolling.contact.half_space import MAX_SIZE, OWN_COEFFICIENT, HalfSpace

# Share of the maximum gap that its rounding adds to the violation. Below 32 eps some solves still
# converge, so the limit that is named is four times that.
ROUNDING = 128 * np.finfo(float).eps
# This share of a node's deflection by the hardness on its own cell is the half range of gaps within
# the cell that pressures below the hardness level. At 0.15 to 0.3 scenes that hardly yield keep the
# error of sharp edges (measured on three scenes, by 0.3 dB); at 0 the rims of elastic contact grow
# soft.
LEVELLED = 0.3
_NOTHING = np.empty((0, 0))
# Addresses of compiled code in double and in single precision: see `_position_kernels.solve`.
_addresses = np.zeros((2, 2), np.int64)


class ContactError(RuntimeError):
    """Error of a contact that cannot be solved.

    It tells the limit in numbers, or the methods tried and the residual that they reached.

    Examples
    --------
    >>> import numpy as np, rolling
    >>> steel, flat = rolling.HalfSpace(1e-6, 230e9), np.zeros((8, 8))
    >>> rolling.solve_contact(steel, flat, load=1.0, hardness=2e9)
    Traceback (most recent call last):
    rolling.contact.solver.ContactError: a load of 1 N is more than the surface can carry: ...
    """


class ConvergenceError(ContactError):
    """Error of a solve whose iterations led nowhere."""


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

    Examples
    --------
    A rigid flat of 20 by 20 um is pressed into steel:

    >>> import numpy as np, rolling
    >>> gap = np.full((30, 30), 1e-6)
    >>> gap[5:25, 5:25] = 0.0
    >>> contact = rolling.solve_contact(rolling.HalfSpace(1e-6, 230e9), gap, load=0.1)
    >>> print(f"{contact.contact_area * 1e12:.0f} um2, {contact.load:.3f} N, {contact.spacing:g} m")
    400 um2, 0.100 N, 1e-06 m
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

    @property
    def contact_area(self) -> float:
        """Area of the nodes under pressure [m2]."""
        return float(np.count_nonzero(self.pressure) * self.spacing**2)

    @property
    def area(self) -> float:
        """Area of the nodes under pressure [m2], under its old name."""
        words = "Contact.area is now Contact.contact_area; the old name goes with the next version"
        # The caller stands beyond the wrapper of `ignoring_underflow`.
        warnings.warn(words, DeprecationWarning, stacklevel=3)
        return self.contact_area

    @property
    def load(self) -> float:
        """Normal load [N], the sum of the pressure over the window."""
        return float(self.pressure.sum() * self.spacing**2)

    def __repr__(self) -> str:
        return (
            f"Contact({self.load:.4g} N on {self.contact_area:.4g} m2,"
            f" approach {self.approach:.4g} m, maximum pressure {self.pressure.max():.4g} Pa,"
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


def levelled_range(half_space: HalfSpace, hardness: float) -> float:
    """Return half of the range of gaps over a cell [m] that pressures below the hardness level."""
    return LEVELLED * float(half_space.unit * OWN_COEFFICIENT * hardness)


def foundation(
    gap: Array, load: float, spacing: float, stiffness: float, hardness: float = np.inf
) -> Array:
    """Solve a contact on a Winkler foundation of a stiffness [Pa/m]; return its pressure [Pa].

    A stiffness of 4 E* / (pi a) fits a Hertz contact of radius a.
    """
    total, area = load / spacing**2, gap.size * spacing**2
    if total > hardness * gap.size:
        raise ContactError(
            f"a load of {rounded(load, 6)} N is more than the surface can carry: hardness"
            f" {rounded(hardness, 6)} Pa times {rounded(area, 4)} m2"
            f" is {rounded(hardness * area, 4)} N"
        )
    e = np.ascontiguousarray(gap, dtype=float).ravel()
    limits, free = (
        Limits(float(hardness), float(total)),
        Sets(np.arange(e.size, dtype=np.uint32), e.size, 0),
    )
    pressure = np.empty_like(e)
    slope, _ = _condition_kernels.project(
        np.zeros_like(e), e, 0.0, -stiffness * e, free, limits, pressure
    )
    # Heights may be so large that rounding of the springs loses the load. The lowest nodes then
    # carry it.
    if slope == np.inf:
        pressure[:] = 0.0
        _condition_kernels.settle_load(pressure, e, limits, 0.0)
    return pressure.reshape(gap.shape)


def _cold_start(half_space: HalfSpace, gap: Array, load: float, hardness: float) -> WarmStart:
    """Start from a Winkler foundation that fits a contact of half the window's width."""
    radius = 0.25 * max(gap.shape) * half_space.spacing
    stiffness = 4 * half_space.contact_modulus / (np.pi * radius)
    return WarmStart(foundation(gap, load, half_space.spacing, stiffness, hardness))


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
        Start of the iteration. Default: a Winkler foundation.
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
    gap, load = _plain("gap", gap), positive("load", load, MAX_SIZE)
    hardness = positive("hardness", hardness, infinite=True)
    tolerance = positive("tolerance", tolerance, 1.0)
    single = truth("single", single)
    units.refuse_high("gap", gap)
    units.refuse_steep("gap", gap, half_space.spacing)
    shape = None if shape is None else _plain("shape", shape, gap)
    start = start or _cold_start(half_space, gap, load, hardness)
    pressure, u = _plain("start.pressure", start.pressure, gap), _NOTHING
    if start.deflection is not None:
        u = _plain("start.deflection", start.deflection, gap)
    total, levelled = load / half_space.spacing**2, levelled_range(half_space, hardness)
    fields, (approach, u_max, worst, share, _), counts = complete(
        half_space,
        _position_kernels.solve,
        np.empty((2 if shape is None else 3, gap.size)),
        (gap, gap if shape is None else shape),
        (pressure, u),
        (_NOTHING, _NOTHING, 0, 0),
        (hardness, total, tolerance, levelled),
        (truth("start.close", start.close), single, shape is not None, False),
    )
    p, u, *edge = fields.reshape(-1, *gap.shape)
    solution = p, u, half_space.spacing, approach, u_max, worst / u_max, counts[0]
    return Contact(*solution, edge[0] if edge else None, share)


def _plain(name: str, array: Array, like: Array | None = None) -> Array:
    """Return an array as compiled code takes it, or a copy: in C order, and open to writing.

    Raise ValueError unless it has the shape of the array that it belongs to.
    """
    plain = np.require(real_array(name, array, 2), float, ["C", "W"])
    if like is not None and plain.shape != like.shape:
        raise ValueError(f"{name}: got an array of shape {plain.shape}, allowed: {like.shape}")
    return plain


def complete(
    half_space: HalfSpace, kernel: Callable[..., Any], fields: Array, *given: tuple[Any, ...]
) -> tuple[Any, ...]:
    """Call a compiled solve with its first arguments, and provide what it needs until it ends.

    Returns the fields (see `solve` of `_position_kernels`), or larger ones that hold its window,
    its measures, its counts, and all else it returns. Raises ContactError as `solve_contact` does.
    """
    own = half_space.unit, *stencils(half_space.unit)
    progress = np.zeros(_position_kernels.PROGRESS, np.int64)
    progress[_position_kernels.CONVOLVED] = half_space.count
    while True:
        shared = own, half_space.table, fields, _addresses, progress
        answer, missing, *solved = kernel(*given, *shared)
        if answer == kernels.SOLVED:
            return fields, *solved
        if answer == kernels.FIELDS:
            smaller, fields = fields, np.empty((len(fields), missing[0]))
            fields[:, : smaller.shape[1]] = smaller
        elif answer == kernels.TRANSFORMS:
            half_space.provide(*missing)
        elif answer == kernels.FAR_FIELD:
            rows, columns, tile, _ = missing
            half_space.keep(rows, columns, tile, far_field(rows, columns, tile))
        elif answer == kernels.KERNEL:
            single, addresses = bool(missing[0]), _addresses[missing[0]]
            addresses[:] = _position_kernels.converge_address(single), kernels.step_address(single)
        elif answer == kernels.UNFINISHED:
            pass  # Python hears an interrupt here
        elif answer == kernels.TOO_WIDE:
            rows, columns, most, _ = missing
            raise ContactError(
                f"the contact needs a window of {rows} by {columns} nodes, more than the {most}"
                " there is room for; take a larger spacing"
            )
        elif answer == kernels.NOT_FINITE:
            strange = "the contact solve met numbers that are not finite: check units of load"
            raise ContactError(f"{strange}, modulus and heights")
        else:
            numbers = given[3]
            raise _not_converged(solved[0], solved[1], tolerance=numbers[2])


def _not_converged(
    measures: tuple[float, ...], counts: tuple[int, ...], tolerance: float
) -> ContactError:
    """Make the error of a solve that stopped, with the tolerance that rounding of gaps allows."""
    (_, u_max, worst, _, highest), (iterations, _, restarts, plain_steps, *_) = measures, counts
    limit = ROUNDING * highest / u_max
    rounding = (
        f"; gaps of up to {rounded(highest)} m, rounded in double precision, need a tolerance of at"
        f" least {rounded(limit)} for a deflection of {rounded(u_max)} m"
    )
    return ConvergenceError(
        f"the contact solve stopped after {iterations} iterations at a residual of"
        f" {rounded(worst / u_max)}, {rounded(tolerance)} was asked for (tried: preconditioned"
        f" conjugate gradients, {restarts} restarts, {plain_steps} plain gradient steps)"
        + (rounding if tolerance <= limit else "")
    )
