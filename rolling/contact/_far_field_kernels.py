"""Compiled far field of the model problem: the part of the half-space that its stencil leaves out.

The stencil stands for a half-space that forgets loads some ten nodes away. The rest of Love's
coefficients is smooth, so loads on a coarse grid give it, with bilinear weights between coarse
nodes (multilevel summation, Brandt & Lubrecht, J. Comput. Phys. 90, 1990). Free nodes answer to the
far field of a change, and their answers have a far field themselves: a linear system on the coarse
grid, which conjugate gradients solve.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np

from rolling.contact._compiled import njit
from rolling.contact._system import BORDER

# Conjugate gradients on the coarse grid end when the square of the preconditioned residual has
# fallen to this share. Where they ended at 0.1, or after 8 iterations, elastic contacts 300 and 500
# nodes wide took 20 convolutions instead of 3.
ENOUGH = 1e-3
ITERATIONS = 100


@njit(cache=True, fused=True)
def add_line(factor, line, out):
    """Add a multiple of a line to another line."""
    for k in range(out.size):
        out[k] += factor * line[k]


@njit(cache=True, fused=True)
def add_four_lines(factors, line, out):
    """Add multiples of the four lines that begin at the fourth, third, second and first number."""
    a, b, c, d = factors
    one, two, three = np.uint64(1), np.uint64(2), np.uint64(3)
    for k in range(np.uint64(out.size)):
        out[k] += (a * line[k + three] + b * line[k + two]) + (c * line[k + one] + d * line[k])


@njit(cache=True, fused=True)
def share_line(share, line, here, below):
    """Add a line to two lines, a share of it to the one below."""
    for k in range(line.size):
        part = share * line[k]
        here[k] += line[k] - part
        below[k] += part


@njit(cache=True, fused=True)
def share_sum(shares, line):
    """Return the sum of a line without its shares, and that of its shares."""
    whole, part = np.float32(0.0), np.float32(0.0)
    for k in range(line.size):
        whole += line[k]
        part += shares[k] * line[k]
    return whole - part, part


@njit(cache=True)
def shares_of(tile):
    """Return the share of the next coarse node at each node of a tile."""
    return (np.arange(tile) / tile).astype(np.float32)


@njit(cache=True, fused=True)
def add_lines(first, line, second, other, out):
    """Add multiples of two lines to a third line."""
    for k in range(out.size):
        out[k] += first * line[k] + second * other[k]


@njit(cache=True)
def restrict(values, tile, row_length, out):
    """Sum values of the nodes (rows, columns) on the coarse grid, with bilinear weights.

    `out` is the flat coarse grid with rows of `row_length`.
    """
    rows, row = values.shape
    here, below, shares = np.zeros(row, np.float32), np.zeros(row, np.float32), shares_of(tile)
    out[:] = 0.0
    for i in range((rows - 1) // tile + 2):
        for k in range(max(i * tile, BORDER), min((i + 1) * tile, rows - BORDER)):
            share_line(shares[k - i * tile], values[k], here, below)
        here[:BORDER] = here[row - BORDER :] = 0.0
        coarse = out[i * row_length :]
        for j in range((row - 1) // tile + 1):
            rest, part = share_sum(shares, here[j * tile : (j + 1) * tile])
            coarse[j] += rest
            coarse[j + 1] += part
        here, below = below, here
        below[:] = 0.0


@njit(cache=True)
def prolong(field, factor, tile, row_length, out):
    """Add a multiple of the bilinear interpolation of a flat coarse grid to the nodes."""
    rows, row = out.shape
    here, below, shares = np.zeros(row, np.float32), np.zeros(row, np.float32), shares_of(tile)
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


@njit(cache=True)
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


@njit(cache=True, fused=True)
def mark_free(strips, change, gap, low, high, softening, out):
    """Set `out` to 1 at nodes that the model leaves between their bounds, else to 0.

    Where nodes are compliant, it is the share of their stiffness instead of 1. `out` is 0 off the
    strips before and after.
    """
    for i in range(strips.shape[0]):
        for k in range(strips[i, 0], strips[i, 1]):
            closing, share = change[k] - gap[k], np.float32(1.0)
            if softening.size:
                closing, share = closing * softening[k], softening[k]
            out[k] = share if low[k] < closing < high[k] else np.float32(0.0)


@njit(cache=True)
def mean_of(weights, values):
    """Return the weighted mean of values on the coarse grid."""
    total, sum_of_weights = 0.0, 0.0
    for k in range(weights.size):
        total += weights[k] * values[k]
        sum_of_weights += weights[k]
    return total / sum_of_weights


@njit(cache=True)
def answer(far):
    """Set the far field to that of the loads and of the answer of all free nodes [Pa].

    `far.stiffness` holds the numbers of free nodes before and their stiffness after. The approach
    answers as well, so that the sum of all loads stays.
    """
    loads, known, stiffness, field = far.loads, far.known, far.stiffness, far.field
    residual, direction, image, table = far.residual, far.direction, far.image, far.table
    free = 0.0
    for k in range(loads.size):
        loads[k] -= known[k]
        # Nodes close a common gap together: the more of them are free, the less each has to bear.
        share = stiffness[k] / far.tile**2
        free += stiffness[k]
        stiffness[k] /= far.own + share * (far.common - far.own)
    field_of(loads, table, field)
    if not free > 0.0:
        field[:] = 0.0
        return
    answers = loads  # from here on
    answers[:] = 0.0
    direction[:] = 0.0
    residual[:] = field
    before, first = 0.0, 0.0
    for _ in range(ITERATIONS):
        mean = mean_of(stiffness, residual)
        square = 0.0
        for k in range(residual.size):
            square += stiffness[k] * (residual[k] - mean) ** 2
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
