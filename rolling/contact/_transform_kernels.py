"""Compiled passes around complex transforms of real arrays, of cells and of their sub-cells.

Rows of nodes lie side by side in pairs: a row of complex numbers has one row of nodes as its real
part and the next one as its imaginary part. Its transform takes half the time of two real
transforms or less, and columns are half as long. One pass in frequency gives each row of a pair the
product of its own frequencies (Cooley, Lewis & Welch, J. Sound Vib. 12, 1970).

A column is padded to twice its length. The first step of a transform with radix 2, decimated in
frequency, separates even and odd frequencies. Where half of the column is zero, this step takes no
more than a product, and two transforms of half the length remain, each on half of the memory.

Arrays of cells with sub-cells have a border of one cell around the cells that hold sub-cells. A
list of cells holds flat indices without that border. `side` is a tuple with an entry for each
sub-cell along the side of a cell: the compiler knows its length and unrolls the loops, which take
half to a quarter of the time.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

from functools import cache as once
from typing import Any

import numpy as np
from numba import types

from acoustics.arrays import Array
from rolling.contact._by_address import array_at, call
from rolling.contact._kinds import FIELD, FLAG, NOTHING, NUMBER, WHOLE
from rolling.contact._linked import linked
from rolling.contact.compiling import address_of, inlined, njit

# Empty arrays of the types of numbers at an address.
_SINGLE = np.empty(0, np.float32)
_SINGLE_COMPLEX = np.empty(0, np.complex64)
_DOUBLE = np.empty(0)
_DOUBLE_COMPLEX = np.empty(0, np.complex128)
_WHOLE = np.empty(0, np.int64)
_INDEX = np.empty(0, np.uint32)
GROUP = 4  # Plans for rows are made for multiples of so many lines.
COLUMN_GAP = 4  # complex numbers between two lines of columns

# Entries of the numbers that describe the transforms of a size to compiled code (see Convolution):
# padded length and width, sub-cells along the side of a cell, and whether columns are halved (the
# length of a half, or 0);
LENGTH, WIDTH, SUBCELLS, HALF = range(4)
# FFTW's function that executes a plan; plans of rows by the number of lines, 0 until they are asked
# for; plans of columns, of both halves where they are halved;
EXECUTE = 4
ROW_PLANS = 5
FORWARD = 6
BACKWARD = 8
# and places of arrays.
BLOCK, PAIRS, LINES, COLUMNS, MEAN, DIFFERENCE, SINES, COSINES, TURNS = range(10, 19)
WEIGHTS = 19
OWN_BLOCK = 20
ENTRIES = 21


_CUBE = types.Array(NUMBER, 3, "C")  # of lines, columns and rows side by side


def _multiplying(real):
    """Return the signature of `multiply` in a precision."""
    grid, line = types.Array(real, 2, "C"), types.Array(real, 1, "C")
    return NOTHING(grid, grid, grid, line, line, FLAG)


def _turning(both):
    """Return the signature of `separate` and `combine` in a precision."""
    return NOTHING(types.Array(both, 2, "C"), WHOLE, types.Array(both, 1, "C"))


@inlined(fused=True)
def join(first, second, line):
    """Set the numbers of a complex line to two rows of nodes side by side."""
    for j in range(first.size):
        line[2 * j] = first[j]
        line[2 * j + 1] = second[j]


@linked(NOTHING(FIELD, _CUBE))
def load(pressure: Array, out: Array) -> None:
    """Set an array (lines, columns, rows side by side) to the pressure, and its rest to 0."""
    rows, columns = pressure.shape
    side = out.shape[2]
    nothing = np.zeros(columns)
    for i in range(out.shape[0]):
        line = out[i].reshape(-1)
        row = side * i
        line[side * columns :] = 0.0
        first = pressure[row] if row < rows else nothing
        if side == 1:
            for j in range(columns):
                line[j] = first[j]
        else:
            join(first, pressure[row + 1] if row + 1 < rows else nothing, line)


@linked(NOTHING(_CUBE, NUMBER, FIELD))
def read(values: Array, unit: float, out: Array) -> None:
    """Set `out` to values times the unit; they have rows side by side as in `load`."""
    side = values.shape[2]
    for i in range(out.shape[0]):
        line = values[i // side].reshape(-1)
        row = out[i]
        if side == 1:
            for j in range(row.size):
                row[j] = unit * line[j]
        else:
            part = line[i % 2 :]
            for j in range(row.size):
                row[j] = unit * part[2 * j]


@linked(_multiplying(types.float64), _multiplying(types.float32))
def multiply(numbers, mean, difference, sines, cosines, halved):
    """Multiply the frequencies of both rows of each pair by their coefficients.

    A column of pairs has half of the frequencies of a column of nodes. Frequencies q and q + m / 2
    of the nodes are the sum and the difference of the even rows' frequency q and the odd rows', the
    latter turned by a spacing of the nodes. Both multiplied and taken apart again, the frequency of
    a pair becomes a multiple of itself plus a multiple of the conjugate of the opposite frequency.

    Parameters
    ----------
    numbers : (m / 2, 2 n or more) array
        Real and imaginary parts of the frequencies. Where columns are halved, the even frequencies
        come first (see `separate`).
    mean, difference : (m // 4 + 1, n // 2 + 1) arrays
        Half of the sum and half of the difference of the coefficients of frequencies q and
        q + m / 2; they are even along and across.
    sines, cosines : (m // 4 + 1,) arrays
        Turns of the frequencies by a spacing of the nodes.
    halved : bool
        Whether columns are halved.
    """
    length = numbers.shape[0]
    middle = mean.shape[1] - 1
    n = 2 * middle
    for q in range(mean.shape[0]):
        opposite = (length - q) % length
        line = numbers[place_of(q, length, halved)]
        other = numbers[place_of(opposite, length, halved)]
        s = mean[q, 1:middle]
        d = difference[q, 1:middle]
        sine = sines[q]
        cosine = cosines[q]
        multiply_opposites(line[2:n], other[n + 2 : 2 * n], s, d, sine, cosine)
        if opposite != q:
            multiply_opposites(other[2:n], line[n + 2 : 2 * n], s, d, -sine, cosine)
        for k in (0, n):  # columns that are opposite to themselves
            turned = difference[q, k // 2] * sine
            across = difference[q, k // 2] * cosine
            here = mean[q, k // 2] - turned
            there = mean[q, k // 2] + turned
            a = line[k]
            b = line[k + 1]
            c = other[k + 1]
            d = other[k]
            line[k] = here * a + across * c
            line[k + 1] = here * b + across * d
            if opposite != q:
                other[k + 1] = there * c + across * a
                other[k] = there * d + across * b


@inlined()
def place_of(frequency, length, halved):
    """Return the row of a frequency; the even ones come first where columns are halved."""
    return frequency // 2 + frequency % 2 * (length // 2) if halved else frequency


@inlined(fused=True)
def multiply_opposites(line, other, mean, difference, sine, cosine):
    """Multiply frequencies of a line, and the opposite ones, which `other` has from its end on.

    Both lines are real and imaginary parts in turn. i times a conjugate has both parts swapped, so
    that the opposite frequencies are just read backwards.
    """
    one = np.uint64(1)
    two = np.uint64(2)
    last = np.uint64(other.size - 1)
    for k in range(np.uint64(mean.size)):
        turned = difference[k] * sine
        across = difference[k] * cosine
        here = mean[k] - turned
        there = mean[k] + turned
        real = two * k
        imaginary = two * k + one
        opposite_imaginary = last - real
        opposite_real = last - imaginary
        a = line[real]
        b = line[imaginary]
        c = other[opposite_imaginary]
        d = other[opposite_real]
        line[real] = here * a + across * c
        line[imaginary] = here * b + across * d
        other[opposite_imaginary] = there * c + across * a
        other[opposite_real] = there * d + across * b


@inlined(fused=True)
def turn_line(line: Array, turn: complex, out: Array) -> None:
    """Set `out` to a line times a number."""
    for j in range(out.size):
        out[j] = turn * line[j]


@inlined(fused=True)
def turn_difference(line: Array, other: Array, turn: complex) -> None:
    """Replace two lines by their sum and by a multiple of their difference."""
    for j in range(line.size):
        difference = line[j] - other[j]
        line[j] += other[j]
        other[j] = turn * difference


@inlined(fused=True)
def add_turned(line: Array, turn: complex, other: Array) -> None:
    """Add a multiple of another line to a line."""
    for j in range(line.size):
        line[j] += turn * other[j]


@inlined(fused=True)
def turn_apart(line: Array, turn: complex, other: Array) -> None:
    """Replace two lines by the sum and the difference of the first and a multiple of the second."""
    for j in range(line.size):
        turned = turn * other[j]
        other[j] = line[j] - turned
        line[j] += turned


@linked(_turning(types.complex128), _turning(types.complex64))
def separate(lines: Array, rows: int, turns: Array) -> None:
    """Separate the even from the odd frequencies of columns that are zero from `rows` on.

    The even frequencies are those of the upper half of the lines afterwards, the odd ones those of
    the lower half: the first step of a transform with radix 2, decimated in frequency. The rows of
    zeros save most of its work. `turns` are the roots of unity of half a circle.
    """
    half = turns.size
    for i in range(half):
        if half + i < rows:
            turn_difference(lines[i], lines[half + i], turns[i])
        elif i < rows:
            turn_line(lines[i], turns[i], lines[half + i])
        else:
            lines[i] = 0.0
            lines[half + i] = 0.0


@linked(_turning(types.complex128), _turning(types.complex64))
def combine(lines: Array, rows: int, turns: Array) -> None:
    """Set the first `rows` rows of columns from both their halves: `separate` backwards."""
    half = turns.size
    for i in range(min(rows, half)):
        turn = turns[i].conjugate()
        if half + i < rows:
            turn_apart(lines[i], turn, lines[half + i])
        else:
            add_turned(lines[i], turn, lines[half + i])


_PASSES = separate, multiply, combine  # that `transform` calls


@inlined()
def lines_of(rows, subcells, length):
    """Return the number of lines of cells that hold so many rows, as plans are made for them."""
    # Two rows of cells are a line; on sub-cells the interpolation needs one more on both sides.
    cells = rows // subcells + 2 if subcells > 1 else rows
    return min(-GROUP * (-cells // (2 * GROUP)), length // 2)


@inlined()
def block_of(entry, rows, columns, real):
    """Return the array (lines, columns, rows side by side) of a block of nodes.

    It has further rows, and columns unless nodes are sub-cells; they hold zeros before a
    convolution.
    """
    if entry[SUBCELLS] > 1:
        return array_at(entry[BLOCK], (rows, columns, 1), real)
    lines = min(-(-rows // 2) + GROUP, entry[LENGTH] // 2)
    return array_at(entry[BLOCK], (lines, entry[WIDTH], 2), real)


@inlined()
def row_of(entry, columns):
    """Return the columns of the array of a block of so many columns, and its rows side by side."""
    return (columns, 1) if entry[SUBCELLS] > 1 else (entry[WIDTH], 2)


@inlined()
def transform(entry, rows, real, both):
    """Convolve the cells of a block of so many rows in the array of the transforms.

    `entry` describes the transforms. `real` and `both` are arrays of their real and complex type.
    """
    length = entry[LENGTH] // 2
    n = entry[WIDTH]
    half = entry[HALF]
    lines = lines_of(rows, entry[SUBCELLS], entry[LENGTH])
    row_plans = array_at(entry[ROW_PLANS], (-(-length // GROUP) + 1, 2), entry)
    row_forward, row_backward = row_plans[-(-lines // GROUP)]
    columns = array_at(entry[LINES], (length, n + COLUMN_GAP), both)
    numbers = array_at(entry[COLUMNS], (length, 2 * (n + COLUMN_GAP)), real)
    call(entry[EXECUTE], (row_forward,))
    turns = array_at(entry[TURNS], (half,), both)
    if half:
        separate(columns, lines, turns)
    else:
        columns[lines:] = 0.0
    quarter = length // 2 + 1
    for k in range(2 if half else 1):
        call(entry[EXECUTE], (entry[FORWARD + k],))
    multiply(
        numbers,
        array_at(entry[MEAN], (quarter, n // 2 + 1), real),
        array_at(entry[DIFFERENCE], (quarter, n // 2 + 1), real),
        array_at(entry[SINES], (quarter,), real),
        array_at(entry[COSINES], (quarter,), real),
        half > 0,
    )
    for k in range(2 if half else 1):
        call(entry[EXECUTE], (entry[BACKWARD + k],))
    if half:
        combine(columns, lines, turns)
    call(entry[EXECUTE], (row_backward,))


@njit(cache=True)
def cells_of(node, columns, block, subcells):
    """List the cells that hold the given nodes of a window of `columns` columns.

    Cells count within a block of whole cells: its first row and column in the window, and its
    numbers of rows and columns.
    """
    row = block[0]
    column = block[1]
    across = block[3] // subcells
    seen = np.zeros(block[2] // subcells * across, np.uint8)
    listed = np.empty(node.size, np.int64)
    count = 0
    for a in range(node.size):
        i, j = divmod(node[a], columns)
        cell = (i - row) // subcells * across + (j - column) // subcells
        if not seen[cell]:
            seen[cell] = 1
            listed[count] = cell
            count += 1
    return listed[:count]


@njit(cache=True)
def loaded_cells(fine, side, listed):
    """List the cells with a loaded sub-cell; return their number."""
    r = len(side)
    rows = fine.shape[0] // r
    columns = fine.shape[1] // r
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
                pair = (i + k) >> 1
                row = (i + k) & 1
                total = cells[pair, j + m, row]
                for b in range(r):
                    total += weights[b, m] * part[k, b]
                cells[pair, j + m, row] = total


@njit(cache=True)
def interpolate_all(cells, weights, fine):
    """Interpolate the deflections of cells on all sub-cells."""
    r = weights.shape[0]
    rows = fine.shape[0] // r
    columns = fine.shape[1] // r
    line = np.empty(columns + 2, fine.dtype)
    apart = np.empty((rows + 2, columns + 2), fine.dtype)
    for i in range(rows + 2):
        apart[i] = cells[i // 2, : columns + 2, i % 2]
    for i in range(rows):
        above = apart[i]
        middle = apart[i + 1]
        below = apart[i + 2]
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
def interpolate(cells, listed, weights, block, own, side, fine):
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


@inlined()
def transform_on_subcells(entry, rows, columns, listed, side, real, both):
    """Replace the pressure on a block of sub-cells by its deflection: see `transform`.

    An empty list of cells stands for all cells.
    """
    r = len(side)
    length = entry[LENGTH]
    fine = array_at(entry[BLOCK], (rows, columns), real)
    cells = array_at(entry[PAIRS], (lines_of(rows, r, length), entry[WIDTH], 2), real)
    weights = array_at(entry[WEIGHTS], (r, 3), real)
    block = array_at(entry[OWN_BLOCK], (r * r, r * r), real)
    loaded = listed
    if listed.size == 0:
        loaded = np.empty(fine.size // r**2 + 1, np.int64)
        loaded = loaded[: loaded_cells(fine, side, loaded)]
    own = np.empty((loaded.size, r * r), real.dtype)
    spread(fine, loaded, weights, side, cells, own)
    transform(entry, rows, real, both)
    if listed.size:
        interpolate(cells, listed, weights, block, own, side, fine)
    else:
        interpolate_all(cells, weights, fine)
        add_own(own, loaded, block, side, fine)


@once
def window_kernel(subcells: int) -> Any:
    """Return the kernel that deflects a window, for so many sub-cells along the side of a cell.

    It sets `out` to the deflection [m] by the pressure [Pa] on a window, in double precision.
    `entry` describes the transforms, and `unit` is the deflection per pressure and coefficient.
    """
    side = (0,) * subcells

    def deflect_window(pressure, unit, entry, out):
        rows, columns = pressure.shape
        values = block_of(entry, rows, columns, _DOUBLE)
        load(pressure, values)
        transform(entry, rows, _DOUBLE, _DOUBLE_COMPLEX)
        read(values, unit, out)

    def deflect_window_of_subcells(pressure, unit, entry, out):
        rows, columns = pressure.shape
        values = block_of(entry, rows, columns, _DOUBLE)
        load(pressure, values)
        every = np.empty(0, np.int64)
        transform_on_subcells(entry, rows, columns, every, side, _DOUBLE, _DOUBLE_COMPLEX)
        read(values, unit, out)

    compiled = njit(cache=True, calls=(load, *_PASSES, read))
    return compiled(deflect_window if subcells == 1 else deflect_window_of_subcells)


_NODES_SIGNATURE = types.void(*[types.int64] * 3, types.float64, *[types.int64] * 6)


@once
def nodes_kernel(subcells: int, single: bool) -> int:
    """Return the address of the kernel that deflects listed nodes: see `deflect_nodes`.

    It is compiled for so many sub-cells along the side of a cell, and for either precision. Its
    caller `deflect_nodes` knows neither.
    """
    side = (0,) * subcells
    real, both = (_SINGLE, _SINGLE_COMPLEX) if single else (_DOUBLE, _DOUBLE_COMPLEX)

    def deflect_at(
        entry_at, rows, columns, unit, d_at, image_at, node_at, count, cells_at, cell_count
    ):
        entry = array_at(entry_at, (ENTRIES,), _WHOLE)
        values = block_of(entry, rows, columns, real).reshape(-1)
        image = array_at(image_at, (values.size,), _DOUBLE)
        node = array_at(node_at, (count,), _INDEX)
        scatter(array_at(d_at, (count,), _DOUBLE), unit, node, values)
        transform(entry, rows, real, both)
        gather(values, node, image)

    def deflect_subcells_at(
        entry_at, rows, columns, unit, d_at, image_at, node_at, count, cells_at, cell_count
    ):
        entry = array_at(entry_at, (ENTRIES,), _WHOLE)
        values = block_of(entry, rows, columns, real).reshape(-1)
        image = array_at(image_at, (values.size,), _DOUBLE)
        node = array_at(node_at, (count,), _INDEX)
        cells = array_at(cells_at, (cell_count,), _WHOLE)
        scatter(array_at(d_at, (count,), _DOUBLE), unit, node, values)
        transform_on_subcells(entry, rows, columns, cells, side, real, both)
        gather(values, node, image)

    function = deflect_at if subcells == 1 else deflect_subcells_at
    return address_of(function, _NODES_SIGNATURE, calls=_PASSES)


@inlined()
def scatter(d, unit, node, values):
    """Set listed nodes of the array of the transforms to `unit` times d, and the rest to 0."""
    values[:] = 0.0
    for k in range(node.size):
        values[node[k]] = unit * d[k]


@inlined()
def gather(values, node, image):
    """Set listed nodes of the image to those of the array of the transforms."""
    for k in range(node.size):
        image[node[k]] = values[node[k]]


@inlined()
def deflect_nodes(kernel, entry, block, d, unit, image, nodes):
    """Set the image of listed nodes to the deflection that pressures on them cause.

    Parameters
    ----------
    kernel : int
        Address of the kernel (see `nodes_kernel`).
    entry : array
        Numbers that describe the transforms.
    block : tuple
        First row and column, and numbers of rows and columns of the block of nodes.
    d : array
        Pressures of the nodes.
    unit : float
        Deflection per pressure and coefficient.
    image : array
        Deflections, at the places of the nodes in the array of the transforms.
    nodes : arrays
        Places of the nodes, and the cells of the block that hold them where nodes are sub-cells.
    """
    node, cells = nodes
    call(
        kernel,
        (
            np.int64(entry.ctypes.data),
            np.int64(block[2]),
            np.int64(block[3]),
            unit,
            np.int64(d.ctypes.data),
            np.int64(image.ctypes.data),
            np.int64(node.ctypes.data),
            np.int64(node.size),
            np.int64(cells.ctypes.data),
            np.int64(cells.size),
        ),
    )
