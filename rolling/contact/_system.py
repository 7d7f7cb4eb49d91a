"""Named tuples of the contact solve: the system of a descent, its direction and steps.

Compiled code makes them from plain arrays and numbers, and Python hands only those over: a named
tuple takes three times as long on the way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array

Indices = NDArray[np.uint32]
Singles = NDArray[np.float32]

OWN_COEFFICIENT = 4 * np.log(1 + np.sqrt(2))  # of a unit square at its own centre
BORDER = 3  # open nodes around the candidates: one that moves, and the reach of a 5 x 5 stencil


class Limits(NamedTuple):
    """Bound of each pressure and sum of all pressures, constant in a descent."""

    hardness: float  # maximum pressure of a node [Pa]
    total: float  # sum of the pressures that carries the load [Pa]


class Sets(NamedTuple):
    """Candidates that may move."""

    active: Indices  # (n,) indices of candidates: free nodes, then nodes that go to a bound
    free: int
    bound: int


class Nodes(NamedTuple):
    """Candidates of a descent, as flat arrays of equal length.

    The last two are empty where no node is compliant by itself.
    """

    p: Array  # pressure [Pa]
    g: Array  # gap before the approach is subtracted [m]
    compliance: Array  # closing of the gap by the node's own pressure beside the deflection [m/Pa]
    softening: Array  # square root of the share of stiffness left; the residual sets it


class Transform(NamedTuple):
    """Image of the direction, the deflection that it causes.

    It has the places of the array of the transforms, of which only those of the candidates count.
    Where sums are direct, it has a place for each candidate, in their order. It is in double
    precision, whatever the transforms are.
    """

    image: Array  # flat, deflection by the direction [m]
    node: Indices  # (n,) index of each candidate in `image`
    unit: float  # deflection per pressure and coefficient [m/Pa]


class Stencil(NamedTuple):
    """Preconditioner, a short stencil of the inverse half-space, with its grid."""

    values: Array  # (3, 3) stencil [Pa/m]
    grid: Array  # flat residual on the block of the candidates with a border of open nodes [m]
    node: Indices  # (n,) index of each candidate in `grid`
    row_length: int  # nodes in a row of `grid`
    stiffness: float  # pressure on a single node that opens its gap by a metre [Pa/m]


class Model(NamedTuple):
    """Model problem (see _model_kernels) on the block of the candidates with BORDER open nodes.

    Changes of pressure and moves of gaps are arrays (rows, columns) [Pa].
    """

    values: Singles  # (6,) stencil of the inverse half-space over its centre, see `inverse_stencil`
    change: Singles  # change of pressure
    gap: Singles  # change of pressure that opens the gap
    low: Singles  # bounds of the change
    high: Singles
    moved: Singles  # moves of the gaps in a sweep, and in the next; zero off the strips
    following: Singles
    softening: Singles  # share of stiffness left by compliance; empty where no node is compliant
    node: Indices  # (n,) index of each candidate in the grid
    strips: NDArray[np.uint64]  # (strips, 2) strips of the nodes near candidates
    stiffness: float  # centre of the stencil [Pa/m]
    lift: float  # violation that counts for a missing sum of pressures [m/Pa]


class FarField(NamedTuple):
    """Far field of the model problem on a coarse grid (see _far_field).

    All grids are flat, with rows of `row_length`, of which the second half is padding.
    """

    tile: int  # nodes from a coarse node to the next
    row_length: int
    own: float  # gap of a node by a unit of its own pressure, as the stencil has it
    common: float  # gap by a unit of pressure all over, as the stencil has it
    table: Singles  # coefficients by distance, with rows of the same length
    loads: Singles  # changes of pressure [Pa]
    known: Singles  # changes whose far field the gaps have already [Pa]
    stiffness: Singles  # answer of the free nodes to a common gap
    field: Singles  # far field over the stiffness of the model [Pa]
    residual: Singles  # vectors of the conjugate gradients [Pa]
    direction: Singles
    image: Singles


class Influence(NamedTuple):
    """Deflection coefficients between the candidates.

    Half a row of `coefficients` is the widest distance of two columns, so a difference of places
    never runs into the next row.
    """

    coefficients: Singles  # flat, by distance along and across from negative to positive, or empty
    node: Indices  # (n,) index of each candidate in an array with rows of the same length
    # (n (n + 1) / 2,) of each node with itself and those before it; empty unless sums are direct
    triangle: Singles


class Work(NamedTuple):
    """Vectors that the passes overwrite, with one entry per candidate."""

    trial: Array  # preconditioned residual, then trial pressure [Pa]
    d: Array  # direction [Pa]
    r: Array  # residual of this and of the previous iteration [m]
    r_before: Array
    active: Indices  # indices of candidates (see Sets)


class Edges(NamedTuple):
    """Edges within the cells of candidates; arrays are empty where edges are sharp."""

    edge: Array  # half of the range of gaps over the cell [m]
    between_nodes: Array  # undeformed gap as it runs within cells less the gap of the nodes [m]
    field: Array  # gap as it runs within cells on the grid of the stencil; NaN off candidates [m]
    levelled: float  # half range that elastic pressures level [m]
    share: float  # share of the remaining half range that edges take


class System(NamedTuple):
    """One descent: its candidates and all arrays that keep their place in memory."""

    nodes: Nodes
    transform: Transform
    stencil: Stencil
    work: Work
    limits: Limits
    edges: Edges
    model: Model
    far: FarField
    influence: Influence


class Solutions(NamedTuple):
    """Solutions of the last two positions on their windows, empty where they do not lead."""

    p: Array  # pressure and deflection of the last position
    u: Array
    p_before: Array  # those of the position before
    u_before: Array
    row: int  # first row and column of their window in that of the last position
    column: int
    block: tuple[int, int, int, int]  # of the candidates: first row and column, rows, columns


class Direction(NamedTuple):
    """Numbers that belong to a direction d."""

    slope: float  # slope of the energy along d [Pa m]; not negative where no direction descends
    longest: float  # maximum step length within the bounds, at least 1
    zr: float  # product z.r [Pa m], 0 where the next direction forgets this direction
    length: float  # share of the preconditioned residual in d, from the step lengths so far


class Rules(NamedTuple):
    """How an iteration steps and finds its direction."""

    nearly_whole: float  # a step longer than this becomes whole, so that nodes arrive on a bound
    snap: float  # nodes so close to the bound that they approach are put on it [Pa]
    allowed: float  # violation that ends the descent [m]
    sweeps: int  # that settle the model; without any the preconditioned residual leads
    edges_move: bool  # whether the edges follow the gaps before the violation is measured
    finishing: bool  # whether the model takes a last step after a converged one


class Step(NamedTuple):
    """State after a step."""

    approach: float  # [m]
    worst: float  # maximum violation of the contact conditions [m]
    bound: int  # number of candidates that go to a bound
    restarts: int  # 1 if the next direction is a restart
    plain_steps: int  # 1 if the next direction is a plain gradient
    load: float  # sum of pressures after the last step by the model [Pa]; 0 where there was none


class Progress(NamedTuple):
    """Progress of a solve over its descents, which each descent continues."""

    iterations: int = 0
    convolutions: int = 0  # deflections by transforms or direct sums
    restarts: int = 0
    plain_steps: int = 0
    edge_moves: int = 0  # iterations after which the edges moved
    descents: int = 0
    stuck: int = 0  # descents in a row that ended without a direction
    load_missed: bool = False  # whether a descent did not restore the load by its free nodes
    carried: bool = False  # whether the pressures are known to carry the load exactly
    exhausted: bool = False  # whether the last descent went as far as its precision allows
