"""Compiled passes between sub-cells and cells.

Arrays of cells (pairs of rows, columns, 2) have two rows of cells side by side, and a border of one
cell around the cells that hold sub-cells. A list of cells holds flat indices without that border.
`side` is a tuple with an entry for each sub-cell along the side of a cell: the compiler knows its
length and unrolls the loops, which take half to a quarter of the time.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

import numpy as np

from rolling.contact._compiled import njit


@njit(cache=True)
def cells_of(node, columns, corner, block_columns, subcells, seen, listed):
    """List the cells that hold the given nodes of a window, within a block of whole cells.

    `corner` is the first row and column of the block in the window of `columns` columns, and
    `block_columns` the number of cells in a row of the block; `seen` is a scratch array of a zero
    per cell. Returns the number of cells.
    """
    count = 0
    for a in range(node.size):
        i, j = divmod(node[a], columns)
        cell = (i - corner[0]) // subcells * block_columns + (j - corner[1]) // subcells
        if not seen[cell]:
            seen[cell] = 1
            listed[count] = cell
            count += 1
    return count


@njit(cache=True)
def loaded_cells(fine, side, listed):
    """List the cells with a loaded sub-cell; return their number."""
    r = len(side)
    rows, columns = fine.shape[0] // r, fine.shape[1] // r
    load = np.empty(columns, fine.dtype)
    count = 0
    for i in range(rows):
        load[:] = 0.0
        for a in range(r):
            row = fine[i * r + a]
            for j in range(columns):
                for b in range(r):
                    load[j] += abs(row[j * r + b])
        for j in range(columns):
            listed[count] = i * columns + j  # the next cell overwrites it unless it counts
            count += load[j] > 0.0
    return count


@njit(cache=True)
def spread(fine, listed, weights, side, cells, own):
    """Set the pressures of cells from the sub-cells of listed cells.

    The adjoint of the interpolation spreads them. `own` receives the pressures of the sub-cells, a
    row for each listed cell.
    """
    r = len(side)
    columns = fine.shape[1] // r
    part = np.empty((3, r), fine.dtype)
    share = fine.dtype.type(1.0 / (r * r))
    cells[:] = 0.0
    for c in range(listed.size):
        i, j = divmod(listed[c], columns)
        part[:] = 0.0
        for a in range(r):
            for b in range(r):
                p = fine[i * r + a, j * r + b]
                own[c, a * r + b] = p
                for k in range(3):
                    part[k, b] += weights[a, k] * p * share
        for k in range(3):
            for m in range(3):
                pair, row = (i + k) >> 1, (i + k) & 1
                total = cells[pair, j + m, row]
                for b in range(r):
                    total += weights[b, m] * part[k, b]
                cells[pair, j + m, row] = total


@njit(cache=True)
def gather_all(cells, weights, fine):
    """Interpolate the deflections of cells on all sub-cells."""
    r = weights.shape[0]
    rows, columns = fine.shape[0] // r, fine.shape[1] // r
    line = np.empty(columns + 2, fine.dtype)
    apart = np.empty((rows + 2, columns + 2), fine.dtype)
    for i in range(rows + 2):
        apart[i] = cells[i // 2, : columns + 2, i % 2]
    for i in range(rows):
        above, middle, below = apart[i], apart[i + 1], apart[i + 2]
        for a in range(r):
            w = weights[a]
            for j in range(columns + 2):
                line[j] = w[0] * above[j] + w[1] * middle[j] + w[2] * below[j]
            out = fine[i * r + a]
            for b in range(r):
                w = weights[b]
                for j in range(columns):
                    out[j * r + b] = w[0] * line[j] + w[1] * line[j + 1] + w[2] * line[j + 2]


@njit(cache=True)
def gather(cells, listed, weights, block, own, side, fine):
    """Set the deflections of the sub-cells of listed cells.

    They are interpolated from the deflections of cells, plus those by pressures within the same
    cell.
    """
    r = len(side)
    columns = fine.shape[1] // r
    part = np.empty(3, fine.dtype)
    within = np.empty(r * r, fine.dtype)
    for c in range(listed.size):
        i, j = divmod(listed[c], columns)
        within[:] = 0.0
        for t in range(r * r):
            p = own[c, t]
            for s in range(r * r):
                within[s] += block[t, s] * p  # the block is symmetric
        for a in range(r):
            for m in range(3):
                part[m] = (
                    weights[a, 0] * cells[i >> 1, j + m, i & 1]
                    + weights[a, 1] * cells[(i + 1) >> 1, j + m, (i + 1) & 1]
                    + weights[a, 2] * cells[(i + 2) >> 1, j + m, i & 1]
                )
            for b in range(r):
                fine[i * r + a, j * r + b] = within[a * r + b] + (
                    weights[b, 0] * part[0] + weights[b, 1] * part[1] + weights[b, 2] * part[2]
                )


@njit(cache=True)
def add_own(own, listed, block, side, fine):
    """Add the deflections of the sub-cells of listed cells by pressures within the same cell."""
    r = len(side)
    columns = fine.shape[1] // r
    for c in range(listed.size):
        i, j = divmod(listed[c], columns)
        for a in range(r):
            for b in range(r):
                total = fine[i * r + a, j * r + b]
                for t in range(r * r):
                    total += block[a * r + b, t] * own[c, t]
                fine[i * r + a, j * r + b] = total
