"""Named tuples that compiled passes of the contact solve take: the system of one descent, its
direction and its steps.

They stay inside compiled code. Numba unpickles the class of each named tuple that crosses the
boundary, which takes 1 us or more; plain tuples cross as fast as arguments do (`pack`, `unpack`).
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rolling._typing import Array
from rolling.contact._compiled import njit

Indices = NDArray[np.uint32]


class Limits(NamedTuple):
    """The bound of each pressure and the sum of all, a constant of a descent.

    Parameters
    ----------
    hardness : float, Pa. Largest pressure of a node.
    total : float, Pa. Sum of the pressures that carries the load.
    """

    hardness: float
    total: float


class Sets(NamedTuple):
    """The candidates that may move.

    Parameters
    ----------
    active : (n,) indices of candidates: first the free ones, then those about to be put on a bound.
    free : int. Number of free candidates.
    bound : int. Number of candidates about to be put on a bound.
    """

    active: Indices
    free: int
    bound: int


class Nodes(NamedTuple):
    """The candidates of a descent, flat arrays of equal length; the last two are empty where no
    node is compliant by itself.

    Parameters
    ----------
    p : pressure, Pa.
    g : gap before the approach is taken off, m.
    compliance : closing of a node's gap by its own pressure beside the deflection, m/Pa.
    softening : square root of the share of a node's stiffness that its compliance leaves.
    """

    p: Array
    g: Array
    compliance: Array
    softening: Array


class Transform(NamedTuple):
    """The array of the transforms: the direction goes in, its deflection comes out.

    Parameters
    ----------
    image : flat array, Pa times `unit` before the convolution, m after it.
    node : index of each candidate in `image`.
    unit : float, m/Pa. Deflection per pressure and coefficient.
    """

    image: NDArray[np.floating]
    node: Indices
    unit: float


class Stencil(NamedTuple):
    """The preconditioner, a short stencil of the inverse half-space, and the grid it acts on.

    Parameters
    ----------
    values : (3, 3) stencil, Pa/m.
    grid : flat array, m. Residual on the block of the candidates with a border of one open node.
    node : index of each candidate in `grid`.
    row_length : int. Nodes in a row of `grid`.
    stiffness : float, Pa/m. Pressure on one node alone that opens its gap by a metre.
    """

    values: Array
    grid: Array
    node: Indices
    row_length: int
    stiffness: float


class Work(NamedTuple):
    """Vectors that the passes overwrite, one entry per candidate.

    Parameters
    ----------
    trial : preconditioned residual, then trial pressure, Pa.
    d : direction, Pa.
    r, r_before : residual of this iteration and of the one before, m.
    active : indices of candidates (see Sets).
    """

    trial: Array
    d: Array
    r: Array
    r_before: Array
    active: Indices


class System(NamedTuple):
    """One descent: its candidates and all that stays where it is in memory."""

    nodes: Nodes
    transform: Transform
    stencil: Stencil
    work: Work
    limits: Limits


def pack(system: System) -> tuple[tuple[Any, ...], ...]:
    """Make a System plain tuples, to be handed to compiled code."""
    return tuple(tuple(part) for part in system)


@njit(cache=True)
def unpack(packed):
    """Make the System again from its plain tuples."""
    nodes, transform, stencil, work, limits = packed
    return System(
        Nodes(*nodes), Transform(*transform), Stencil(*stencil), Work(*work), Limits(*limits)
    )


class Direction(NamedTuple):
    """The numbers that belong to a direction d.

    Parameters
    ----------
    slope : float, Pa m. Slope of the energy along d; not negative: no direction descends.
    longest : float. Longest step length within the bounds, at least 1.
    zr : float, Pa m. Product z.r, 0 where the next direction forgets this one.
    length : float. Step length that the unprojected direction had so far, for the next beta.
    """

    slope: float
    longest: float
    zr: float
    length: float


class Step(NamedTuple):
    """The state after a step.

    Parameters
    ----------
    approach : float, m.
    worst : float, m. Maximum violation of the contact conditions.
    free, bound : int. Numbers of candidates that may move freely and that are about to be put on a
        bound.
    restarts, plain_steps : int. Whether the next direction is a restart or a plain gradient, 0 or
        1.
    """

    approach: float
    worst: float
    free: int
    bound: int
    restarts: int
    plain_steps: int
