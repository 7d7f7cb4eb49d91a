"""Named tuples of the contact solve: the system of a descent, its direction and steps.

They stay inside compiled code. Numba unpickles the class of each named tuple that crosses the
boundary, which takes 1 us or more; plain tuples cross as fast as arguments, and each array takes
0.1 us. A System therefore crosses as a plain tuple of few arrays (`Packed`, `unpack`).
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import types
from numpy.typing import NDArray

from acoustics.arrays import Array
from rolling.contact.compiling import njit

Indices = NDArray[np.uint32]
Singles = NDArray[np.float32]

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
    """Array of the transforms: the direction goes in, its deflection comes out."""

    image: NDArray[np.floating]  # pressure times `unit` before, deflection after [m]
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
    """Deflection coefficients between the candidates."""

    coefficients: Singles  # flat, by distance along and across from negative to positive, or empty
    node: Indices  # (n,) index of each candidate in an array with rows of the same length


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


class Packed(NamedTuple):
    """Arrays and numbers of a System, few enough to cross to compiled code fast."""

    # (6 or 10, n): pressure, gap, trial, direction and both residuals; where edges are blended also
    # compliance, softening, edge and the gap between nodes
    vectors: Array
    indices: Indices  # (4, n): active ones, in the transforms, in the grid, by distance
    image: NDArray[np.floating]  # array of the transforms
    grids: Array  # (1 or 2, cells): residual, and the gap within cells where edges are blended
    model: Singles  # (6 or 7, rows, columns): grids of the Model in its order, softening last
    strips: NDArray[np.uint64]
    coarse: Singles  # (7, cells): grids of the FarField
    stencil: Array
    model_stencil: Singles
    table: Singles
    coefficients: Singles
    # hardness, total, unit, stiffness, levelled range, stiffness and lift of the Model, own and
    # common gap of the FarField, share of the edges
    numbers: tuple[float, ...]
    lengths: tuple[int, int]  # tile and row length of the FarField


def packed_type(real: types.Float) -> types.Tuple:
    """Return the type of a Packed for transforms of a type."""
    single, double, index = types.float32, types.float64, types.uint32
    return types.Tuple(
        [
            double[:, ::1],
            index[:, ::1],
            real[::1],
            double[:, ::1],
            single[:, :, ::1],
            types.uint64[:, ::1],
            single[:, ::1],
            double[:, ::1],
            *[single[::1]] * 3,
            types.UniTuple(double, 10),
            types.UniTuple(types.int64, 2),
        ]
    )


def system_of(packed):
    """Return the System of the fields of a Packed, as a plain tuple."""
    vectors, indices, image, grids, model, strips, coarse = packed[:7]
    stencil, model_stencil, table, coefficients, numbers, (tile, row_length) = packed[7:]
    hardness, total, unit, stiffness, levelled, model_stiffness, lift, own, common, share = numbers
    # The rows that only blended edges have are else empty slices of others.
    blended = vectors.shape[0] > 6
    n = vectors.shape[1] if blended else 0
    first = 6 if blended else 2
    return System(
        Nodes(vectors[0], vectors[1], vectors[first][:n], vectors[first + 1][:n]),
        Transform(image, indices[1], unit),
        Stencil(stencil, grids[0], indices[2], model.shape[2], stiffness),
        Work(vectors[2], vectors[3], vectors[4], vectors[5], indices[0]),
        Limits(hardness, total),
        Edges(
            vectors[first + 2][:n],
            vectors[first + 3][:n],
            grids[grids.shape[0] - 1][: grids.shape[1] if blended else 0],
            levelled,
            share,
        ),
        Model(
            model_stencil,
            model[0],
            model[1],
            model[2],
            model[3],
            model[4],
            model[5],
            model[5 + blended][: model.shape[1] if blended else 0],
            indices[2],
            strips,
            model_stiffness,
            lift,
        ),
        FarField(
            tile,
            row_length,
            own,
            common,
            table,
            coarse[0],
            coarse[1],
            coarse[2],
            coarse[3],
            coarse[4],
            coarse[5],
            coarse[6],
        ),
        Influence(coefficients, indices[3]),
    )


unpack = njit(cache=True, inner=True)(system_of)


class Direction(NamedTuple):
    """Numbers that belong to a direction d."""

    slope: float  # slope of the energy along d [Pa m]; not negative where no direction descends
    longest: float  # maximum step length within the bounds, at least 1
    zr: float  # product z.r [Pa m], 0 where the next direction forgets this direction
    length: float  # share of the preconditioned residual in d, from the step lengths so far


class Step(NamedTuple):
    """State after a step."""

    approach: float  # [m]
    worst: float  # maximum violation of the contact conditions [m]
    free: int  # number of candidates that may move freely
    bound: int  # number of candidates that go to a bound
    restarts: int  # 1 if the next direction is a restart
    plain_steps: int  # 1 if the next direction is a plain gradient
    load: float  # sum of pressures after the last step by the model [Pa]; 0 where there was none
