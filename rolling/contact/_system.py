"""Named tuples of the contact solve: the system of a descent, its direction and steps.

They stay inside compiled code. Numba unpickles the class of each named tuple that crosses the
boundary, which takes 1 us or more; plain tuples cross as fast as arguments, and each array takes
0.1 us. A System therefore crosses as a plain tuple of few arrays (`Packed`, `unpack`).
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rolling._typing import Array
from rolling.contact.compiling import njit

Indices = NDArray[np.uint32]
Singles = NDArray[np.float32]

BORDER = 3  # open nodes around the candidates: one that moves, and the reach of a 5 x 5 stencil


class Limits(NamedTuple):
    """Bound of each pressure and sum of all pressures, constant in a descent.

    Parameters
    ----------
    hardness : float, Pa
        Maximum pressure of a node.
    total : float, Pa
        Sum of the pressures that carries the load.
    """

    hardness: float
    total: float


class Sets(NamedTuple):
    """Candidates that may move.

    Parameters
    ----------
    active : (n,) array of int
        Indices of candidates, first the free nodes, then the nodes that go to a bound.
    free : int
        Number of free candidates.
    bound : int
        Number of candidates that go to a bound.
    """

    active: Indices
    free: int
    bound: int


class Nodes(NamedTuple):
    """Candidates of a descent, as flat arrays of equal length.

    The last two are empty where no node is compliant by itself.

    Parameters
    ----------
    p : (n,) array, Pa
        Pressure.
    g : (n,) array, m
        Gap before the approach is subtracted.
    compliance : (n,) array, m/Pa
        Closing of a node's gap by its own pressure in addition to the deflection.
    softening : (n,) array
        Square root of the share of a node's stiffness that its compliance leaves; the residual sets
        it.
    """

    p: Array
    g: Array
    compliance: Array
    softening: Array


class Transform(NamedTuple):
    """Array of the transforms: the direction goes in, its deflection comes out.

    Parameters
    ----------
    image : flat array, m
        Pressure times `unit` before the convolution, deflection after it.
    node : (n,) array of int
        Index of each candidate in `image`.
    unit : float, m/Pa
        Deflection per pressure and coefficient.
    """

    image: NDArray[np.floating]
    node: Indices
    unit: float


class Stencil(NamedTuple):
    """Preconditioner, a short stencil of the inverse half-space, with its grid.

    Parameters
    ----------
    values : (3, 3) array, Pa/m
        Stencil.
    grid : flat array, m
        Residual on the block of the candidates with a border of one open node.
    node : (n,) array of int
        Index of each candidate in `grid`.
    row_length : int
        Nodes in a row of `grid`.
    stiffness : float, Pa/m
        Pressure on a single node that opens its gap by a metre.
    """

    values: Array
    grid: Array
    node: Indices
    row_length: int
    stiffness: float


class Model(NamedTuple):
    """Model problem with its grid (see _model_kernels).

    The grid is the block of the candidates with a border of BORDER open nodes.

    Parameters
    ----------
    values : (6,) array
        Stencil of the inverse half-space over its centre: centre, side, corner, second side, beside
        it, second corner.
    change, gap, low, high : (rows, columns) arrays, Pa
        Changes of pressure: that of the model, the one that opens the gap, and the bounds.
    moved : (rows, columns) array, Pa
        Moves of the gaps in a sweep.
    sums : (3, rows, columns) array, Pa
        Sums of moves along the columns of the stencil.
    softening : (rows, columns) array
        Share of a node's stiffness that its compliance leaves; empty where no node is compliant.
    node : (n,) array of int
        Index of each candidate in the grid.
    strips : (strips, 2) array of int
        Strips of the nodes near candidates (see list_strips).
    stiffness : float, Pa/m
        Centre of the stencil.
    lift : float, m/Pa
        Violation that counts for a missing sum of pressures.
    """

    values: Singles
    change: Singles
    gap: Singles
    low: Singles
    high: Singles
    moved: Singles
    sums: Singles
    softening: Singles
    node: Indices
    strips: NDArray[np.uint64]
    stiffness: float
    lift: float


class FarField(NamedTuple):
    """Far field of the model problem on a coarse grid (see _far_field).

    All grids are flat, with rows of `row_length`, of which the second half is padding.

    Parameters
    ----------
    tile : int
        Nodes from a coarse node to the next.
    row_length : int
        Entries in a row of the grids.
    own, common : float
        Gap of a node by a unit of its own pressure, and by a unit of pressure all over, as the
        stencil has them.
    table : flat array
        Coefficients by distance, with rows of the same length.
    loads, known : flat arrays, Pa
        Changes of pressure, and the changes whose far field the gaps have already.
    stiffness : flat array
        Answer of the free nodes to a common gap.
    field : flat array, Pa
        Far field, over the stiffness of the model.
    residual, direction, image : flat arrays, Pa
        Vectors of the conjugate gradients.
    """

    tile: int
    row_length: int
    own: float
    common: float
    table: Singles
    loads: Singles
    known: Singles
    stiffness: Singles
    field: Singles
    residual: Singles
    direction: Singles
    image: Singles


class Influence(NamedTuple):
    """Deflection coefficients between the candidates.

    Parameters
    ----------
    coefficients : flat array
        Coefficients by distance along and across, both from negative to positive; empty where
        nodes are not put on a bound without a convolution.
    node : (n,) array of int
        Index of each candidate in an array with rows of the same length.
    """

    coefficients: Singles
    node: Indices


class Work(NamedTuple):
    """Vectors that the passes overwrite, with one entry per candidate.

    Parameters
    ----------
    trial : (n,) array, Pa
        Preconditioned residual, then trial pressure.
    d : (n,) array, Pa
        Direction.
    r, r_before : (n,) arrays, m
        Residuals of this and of the previous iteration.
    active : (n,) array of int
        Indices of candidates (see Sets).
    """

    trial: Array
    d: Array
    r: Array
    r_before: Array
    active: Indices


class Edges(NamedTuple):
    """The edges within the cells of candidates; arrays are empty where edges are sharp.

    Parameters
    ----------
    edge : half of the range of gaps over the cell, m.
    between_nodes : undeformed gap as it runs within cells less the gap of the nodes, m.
    field : flat array, m. Grid as that of the stencil, for the gap as it runs within cells; it is
        not a number off the candidates.
    levelled : float, m. Half range that elastic pressures level.
    share : float. Share of the remaining half range that edges take.
    """

    edge: Array
    between_nodes: Array
    field: Array
    levelled: float
    share: float


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
    """The arrays and numbers of a System, few enough to cross to compiled code fast.

    Parameters
    ----------
    vectors : (6 or 10, n) array
        Vectors of the candidates: pressure, gap, trial, direction and both residuals; where edges
        are blended also compliance, softening, edge and the gap between nodes.
    indices : (4, n) array
        Indices of the candidates: active ones, in the array of the transforms, in the grid, by
        distance.
    image : flat array
        Array of the transforms.
    grids : (1 or 2, cells) array
        Residual, and the gap as it runs within cells where edges are blended.
    model : (8 or 9, rows, columns) array
        Grids of the Model in its order, sums after moves, and softening where edges are blended.
    strips : (strips, 2) array
        Those of the Model.
    coarse : (7, cells) array
        Grids of the FarField.
    stencil, model_stencil, table, coefficients : arrays
        Those of Stencil, Model, FarField and Influence.
    numbers : tuple
        Hardness, total, deflection and stiffness of a cell, levelled range, stiffness and lift of
        the Model, own and common gap of the FarField, share of the edges.
    lengths : tuple
        Tile and row length of the FarField.
    """

    vectors: Array
    indices: Indices
    image: NDArray[np.floating]
    grids: Array
    model: Singles
    strips: NDArray[np.uint64]
    coarse: Singles
    stencil: Array
    model_stencil: Singles
    table: Singles
    coefficients: Singles
    numbers: tuple[float, ...]
    lengths: tuple[int, int]


@njit(cache=True)
def unpack(packed):
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
            model[5:8],
            model[7 + blended][: model.shape[1] if blended else 0],
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


class Direction(NamedTuple):
    """Numbers that belong to a direction d.

    Parameters
    ----------
    slope : float, Pa m
        Slope of the energy along d; it is not negative where no direction descends.
    longest : float
        Maximum step length within the bounds, at least 1.
    zr : float, Pa m
        Product z.r, 0 where the next direction forgets this direction.
    length : float
        Share of the preconditioned residual in the direction, from the step lengths so far.
    """

    slope: float
    longest: float
    zr: float
    length: float


class Step(NamedTuple):
    """State after a step.

    Parameters
    ----------
    approach : float, m
        Approach of sphere and plate.
    worst : float, m
        Maximum violation of the contact conditions.
    free, bound : int
        Numbers of candidates that may move freely and that go to a bound.
    restarts, plain_steps : int
        1 if the next direction is a restart or a plain gradient, otherwise 0.
    load : float, Pa
        Sum of the pressures after the last step by the model; 0 where there was none.
    """

    approach: float
    worst: float
    free: int
    bound: int
    restarts: int
    plain_steps: int
    load: float
