"""Inverse half-space as a short stencil, and the far field that this stencil leaves out.

The stencil stands for a half-space that forgets loads some ten nodes away. The rest of Love's
coefficients is smooth, so loads on a coarse grid give it, with bilinear weights between coarse
nodes (multilevel summation, Brandt & Lubrecht, J. Comput. Phys. 90, 1990). Free nodes answer to the
far field of a change, and their answers have a far field themselves: a linear system on the coarse
grid, which conjugate gradients solve.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from rolling.contact._kinds import FAR_FIELD, GRID, NOTHING, SINGLE, SINGLES, WHOLE
from rolling.contact._linked import linked
from rolling.contact._system import BORDER
from rolling.contact._window_kernels import copy_line
from rolling.contact.compiling import inlined
from rolling.contact.half_space import by_signed_distance, love

# Waves up to this many nodes long count in the fit of the stencil. Contacts are some ten to a
# hundred nodes wide.
LONGEST_WAVE = 40
# Nodes from a coarse node of the far field to the next, at least. The far field is smooth over
# that length.
SHORTEST_TILE = 8
# Beyond so many nodes the half-space of the stencil is forgotten (1e-15 of its centre).
FORGOTTEN = 64


@lru_cache(maxsize=1)
def inverse_stencil() -> Array:
    """Fit a 5 x 5 stencil to the inverse of Love's coefficients, by least squares over waves.

    The waves are up to LONGEST_WAVE nodes long, for unit spacing and pi E* = 1.

    Returns
    -------
    (6,) array
        Centre, side, corner, second side, beside it, second corner.
    """
    distance = np.minimum(np.arange(256), 256 - np.arange(256))
    spectrum = np.fft.rfft2(love(distance, distance)).real
    along = 2 * np.pi * np.fft.fftfreq(256)[:, None]
    across = 2 * np.pi * np.fft.rfftfreq(256)[None, :]
    waves = np.hypot(along, across) >= 2 * np.pi / LONGEST_WAVE

    def ring(a: int, b: int) -> Array:
        """Return the transform of a unit on the nodes (a, b) of all eight octants."""
        nodes = {(x * m, y * n) for m, n in ((a, b), (b, a)) for x in (-1, 1) for y in (-1, 1)}
        # Sorted, because the order of a sum has an effect on its last digits.
        total: Array = np.sum([np.cos(m * along + n * across) for m, n in sorted(nodes)], axis=0)
        return total

    pairs = [(0, 0), (1, 0), (1, 1), (2, 0), (2, 1), (2, 2)]
    columns = np.stack([(ring(a, b) * spectrum)[waves] for a, b in pairs], axis=1)
    weights: Array = np.linalg.lstsq(columns, np.ones(len(columns)), rcond=None)[0]
    return weights


@lru_cache(maxsize=1)
def half_space_of_stencil() -> Array:
    """Return the coefficients by distance that the stencil inverts, along and across.

    They are those of a large periodic grid, for unit spacing and pi E* = 1.

    Returns
    -------
    (FORGOTTEN, FORGOTTEN) array
        Coefficients; the sum over all nodes of the plane is `1 / sum(stencil)`.
    """
    nodes = 4 * FORGOTTEN
    wrapped = np.zeros((nodes, nodes))
    at = np.arange(-2, 3)
    wrapped[at[:, None], at] = square_stencil()
    coefficients: Array = np.fft.irfft2(1.0 / np.fft.rfft2(wrapped).real)[:FORGOTTEN, :FORGOTTEN]
    return coefficients


def square_stencil() -> Array:
    """Return the stencil of the inverse as a (5, 5) array."""
    centre, side, corner, second, beside, far = inverse_stencil()
    quarter = np.array([[centre, side, second], [side, corner, beside], [second, beside, far]])
    at = np.abs(np.arange(-2, 3))
    square: Array = quarter[at[:, None], at]
    return square


@inlined()
def coarse_grid(rows: int, columns: int) -> tuple[int, int, int]:
    """Choose the coarse grid of the far field for a grid of the model.

    The tile grows with the root of the grid, so that sums over all pairs of coarse nodes take no
    longer than a few passes over the nodes.

    Parameters
    ----------
    rows, columns : int
        Nodes of the model along and across.

    Returns
    -------
    rows, columns : int
        Coarse nodes along and across.
    tile : int
        Nodes from a coarse node to the next.
    """
    tile = max(SHORTEST_TILE, round(max(rows, columns) ** 0.5))
    return (rows - 1) // tile + 2, (columns - 1) // tile + 2, tile


@lru_cache(maxsize=64)
def far_field(rows: int, columns: int, tile: int) -> NDArray[np.float32]:
    """Return the coefficients of the far field by distance on a coarse grid.

    They are Love's coefficients less those that the stencil inverts, for unit spacing and
    pi E* = 1.

    Parameters
    ----------
    rows, columns : int
        Coarse nodes along and across.
    tile : int
        Nodes from a coarse node to the next.

    Returns
    -------
    flat array
        Rows of 2 columns - 1 coefficients, from negative to positive distances along and across,
        and as many zeros as columns at the end.
    """
    along = np.arange(float(rows)) * tile
    across = np.arange(float(columns)) * tile
    coefficients = love(along, across)
    near = half_space_of_stencil()[::tile, ::tile][:rows, :columns]
    coefficients[: near.shape[0], : near.shape[1]] -= near
    table = by_signed_distance(coefficients).ravel()
    return np.append(table, np.zeros(columns)).astype(np.float32)


class Stencils(NamedTuple):
    """Stencils of the inverse half-space in the units of a half-space.

    Parameters
    ----------
    preconditioner : (3, 3) array, Pa/m
        Stencil of the preconditioner: the centre of the inverse.
    model : (6,) array
        Stencil of the model problem over its centre.
    stiffness : float, Pa/m
        Centre of the stencil of the model problem.
    own, common : float
        Gap of a node by a unit of its own pressure, and by a unit of pressure all over, that the
        stencil of the model problem stands for.
    """

    preconditioner: Array
    model: NDArray[np.float32]
    stiffness: float
    own: float
    common: float


@lru_cache(maxsize=8)
def stencils(unit: float) -> Stencils:
    """Return the stencils for a half-space with a deflection of `unit` [m/Pa] per coefficient."""
    distance = np.minimum(np.arange(256), 256 - np.arange(256))
    inverse = np.fft.irfft2(1.0 / np.fft.rfft2(love(distance, distance)).real)
    centre = np.ascontiguousarray(np.roll(inverse, (1, 1), axis=(0, 1))[:3, :3])
    model = inverse_stencil()
    return Stencils(
        centre / unit,
        (model / model[0]).astype(np.float32),
        float(model[0] / unit),
        float(half_space_of_stencil()[0, 0]),
        float(1.0 / square_stencil().sum()),
    )


# Conjugate gradients on the coarse grid end when the square of the preconditioned residual has
# fallen to this share. Where they ended at 0.1, or after 8 iterations, elastic contacts 300 and 500
# nodes wide took 20 convolutions instead of 3.
ENOUGH = 1e-3
ITERATIONS = 100


@inlined(fused=True)
def add_line(factor, line, out):
    """Add a multiple of a line to another line."""
    for k in range(out.size):
        out[k] += factor * line[k]


@inlined(fused=True)
def add_four_lines(factors, line, out):
    """Add multiples of the four lines that begin at the fourth, third, second and first number."""
    a, b, c, d = factors
    one = np.uint64(1)
    two = np.uint64(2)
    three = np.uint64(3)
    for k in range(np.uint64(out.size)):
        out[k] += (a * line[k + three] + b * line[k + two]) + (c * line[k + one] + d * line[k])


@inlined(fused=True)
def share_line(share, line, here, below):
    """Add a line to two lines, a share of it to the one below."""
    for k in range(line.size):
        part = share * line[k]
        here[k] += line[k] - part
        below[k] += part


@inlined(fused=True)
def share_sum(shares, line):
    """Return the sum of a line without its shares, and that of its shares."""
    whole = np.float32(0.0)
    part = np.float32(0.0)
    for k in range(line.size):
        whole += line[k]
        part += shares[k] * line[k]
    return whole - part, part


@inlined()
def shares_of(tile):
    """Return the share of the next coarse node at each node of a tile."""
    shares = np.empty(tile, np.float32)
    for k in range(tile):
        shares[k] = k / tile
    return shares


@inlined(fused=True)
def add_lines(first, line, second, other, out):
    """Add multiples of two lines to a third line."""
    for k in range(out.size):
        out[k] += first * line[k] + second * other[k]


@linked(NOTHING(GRID, WHOLE, WHOLE, SINGLES))
def restrict(values, tile, row_length, out):
    """Sum values of the nodes (rows, columns) on the coarse grid, with bilinear weights.

    `out` is the flat coarse grid with rows of `row_length`.
    """
    rows, row = values.shape
    here = np.zeros(row, np.float32)
    below = np.zeros(row, np.float32)
    shares = shares_of(tile)
    out[:] = 0.0
    for i in range((rows - 1) // tile + 2):
        for k in range(max(i * tile, BORDER), min((i + 1) * tile, rows - BORDER)):
            share_line(shares[k - i * tile], values[k], here, below)
        here[:BORDER] = 0.0
        here[row - BORDER :] = 0.0
        coarse = out[i * row_length :]
        for j in range((row - 1) // tile + 1):
            rest, part = share_sum(shares, here[j * tile : (j + 1) * tile])
            coarse[j] += rest
            coarse[j + 1] += part
        here, below = below, here
        below[:] = 0.0


@linked(NOTHING(SINGLES, SINGLE, WHOLE, WHOLE, GRID))
def prolong(field, factor, tile, row_length, out):
    """Add a multiple of the bilinear interpolation of a flat coarse grid to the nodes."""
    rows, row = out.shape
    here = np.zeros(row, np.float32)
    below = np.zeros(row, np.float32)
    shares = shares_of(tile)
    for i in range((rows - 1) // tile + 2):
        coarse = field[i * row_length :]
        for j in range((row - 1) // tile + 1):
            line = below[j * tile : (j + 1) * tile]
            for k in range(line.size):
                line[k] = coarse[j] + shares[k] * (coarse[j + 1] - coarse[j])
        for k in range(max((i - 1) * tile, BORDER), min(i * tile, rows - BORDER)):
            share = shares[k - (i - 1) * tile]
            add_lines(factor * (np.float32(1.0) - share), here, factor * share, below, out[k])
        here, below = below, here


@linked(NOTHING(SINGLES, SINGLES, SINGLES))
def field_of(loads, table, out):
    """Set `out` to the far field of loads, both flat on the coarse grid.

    Rows of the grid are as long as rows of the table, so that all nodes follow from a load in a
    single line. Their second halves are padding.
    """
    middle = table.size - loads.size - 1  # also the last coarse node; only padding follows it
    out[:] = 0.0
    # Four loads at a time take half as many accesses to memory as one after the other.
    first = (middle + 1) % 4
    for k in range(first):
        add_line(loads[k], table[middle - k :], out)
    for k in range(first, middle, 4):
        four = loads[k], loads[k + 1], loads[k + 2], loads[k + 3]
        if four != (0.0, 0.0, 0.0, 0.0):
            add_four_lines(four, table[middle - k - 3 :], out)


@inlined(fused=True)
def mark_free(strips, change, gap, low, high, softening, out):
    """Set `out` to 1 at nodes that the model leaves between their bounds, else to 0.

    Where nodes are compliant, it is the share of their stiffness instead of 1. `out` is 0 off the
    strips before and after.
    """
    for i in range(strips.shape[0]):
        for k in range(strips[i, 0], strips[i, 1]):
            closing = change[k] - gap[k]
            share = np.float32(1.0)
            if softening.size:
                closing = closing * softening[k]
                share = softening[k]
            out[k] = share if low[k] < closing < high[k] else np.float32(0.0)


@inlined()
def mean_of(weights, values):
    """Return the weighted mean of values on the coarse grid."""
    total = 0.0
    sum_of_weights = 0.0
    for k in range(weights.size):
        total += weights[k] * values[k]
        sum_of_weights += weights[k]
    return total / sum_of_weights


@linked(NOTHING(FAR_FIELD), calls=(field_of,))
def answer(far):
    """Set the far field to that of the loads and of the answer of all free nodes [Pa].

    `far.stiffness` holds the numbers of free nodes before and their stiffness after. The approach
    answers as well, so that the sum of all loads stays.
    """
    loads = far.loads
    known = far.known
    stiffness = far.stiffness
    field = far.field
    residual = far.residual
    direction = far.direction
    image = far.image
    table = far.table
    free = 0.0
    for k in range(loads.size):
        loads[k] -= known[k]
        # Nodes close a common gap together: the more of them are free, the less each has to bear.
        share = stiffness[k] / (far.tile * far.tile)
        free += stiffness[k]
        stiffness[k] /= far.own + share * (far.common - far.own)
    field_of(loads, table, field)
    if not free > 0.0:
        field[:] = 0.0
        return
    answers = loads  # from here on
    answers[:] = 0.0
    direction[:] = 0.0
    copy_line(field, residual)
    before = 0.0
    first = 0.0
    for _ in range(ITERATIONS):
        mean = mean_of(stiffness, residual)
        square = 0.0
        for k in range(residual.size):
            apart = residual[k] - mean
            square += stiffness[k] * (apart * apart)
        first = max(first, square)
        if not square > ENOUGH * first:
            break
        factor = square / before if before > 0.0 else 0.0
        before = square
        for k in range(residual.size):
            direction[k] = factor * direction[k] - stiffness[k] * (residual[k] - mean)
        field_of(direction, table, image)
        curvature = 0.0
        for k in range(residual.size):
            if stiffness[k] > 0.0:
                image[k] += direction[k] / stiffness[k]
                curvature += direction[k] * image[k]
        if not curvature > 0.0:
            break
        length = square / curvature
        for k in range(residual.size):
            answers[k] += length * direction[k]
            residual[k] += length * image[k]
    mean = mean_of(stiffness, residual)
    for k in range(field.size):
        if stiffness[k] > 0.0:
            field[k] = -answers[k] / stiffness[k]
        else:  # no node is free here; the residual is the field of all loads and answers
            field[k] = residual[k] - mean
