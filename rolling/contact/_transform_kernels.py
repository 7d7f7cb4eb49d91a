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
from numpy.typing import NDArray

from acoustics.arrays import Array
from rolling.contact._by_address import address_of, array_at, caller, execute
from rolling.contact.compiling import njit

_DOUBLE = np.empty(0)  # array of double precision
GROUP = 4  # Plans for rows are made for multiples of so many lines.
COLUMN_GAP = 4  # complex numbers between two lines of columns

# Entries of the numbers that describe the transforms of a size to compiled code (see Convolution).
# The key is the padded length, the padded width and 1 in single precision, else 0.
(LENGTH, WIDTH, KIND, USED, SUBCELLS, APPLY, EXECUTE, ROW_PLANS) = range(8)
(FORWARD, BACKWARD) = (8, 10)  # plans of columns, of both halves where they are halved
(BLOCK, PAIRS, LINES, COLUMNS, MEAN, DIFFERENCE, SINES, COSINES, TURNS, HALF) = range(12, 22)
(WEIGHTS, OWN_BLOCK, INFLUENCE, INFLUENCE_SIZE, ENTRIES) = range(22, 27)


@njit(cache=True, fused=True, inner=True)
def join(first, second, line):
    """Set the numbers of a complex line to two rows of nodes side by side."""
    for j in range(first.size):
        line[2 * j] = first[j]
        line[2 * j + 1] = second[j]


@njit(cache=True)
def load(pressure: Array, out: Array) -> None:
    """Set an array (lines, columns, rows side by side) to the pressure, and its rest to 0."""
    rows, columns = pressure.shape
    side = out.shape[2]
    nothing = np.zeros(columns)
    for i in range(out.shape[0]):
        line, row = out[i].reshape(-1), side * i
        line[side * columns :] = 0.0
        first = pressure[row] if row < rows else nothing
        if side == 1:
            for j in range(columns):
                line[j] = first[j]
        else:
            join(first, pressure[row + 1] if row + 1 < rows else nothing, line)


@njit(cache=True)
def read(values: Array, unit: float, out: Array) -> None:
    """Set `out` to values times the unit; they have rows side by side as in `load`."""
    side = values.shape[2]
    for i in range(out.shape[0]):
        line, row = values[i // side].reshape(-1), out[i]
        if side == 1:
            for j in range(row.size):
                row[j] = unit * line[j]
        else:
            part = line[i % 2 :]
            for j in range(row.size):
                row[j] = unit * part[2 * j]


@njit(cache=True)
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
    length, middle = numbers.shape[0], mean.shape[1] - 1
    n = 2 * middle
    for q in range(mean.shape[0]):
        opposite = (length - q) % length
        line = numbers[place_of(q, length, halved)]
        other = numbers[place_of(opposite, length, halved)]
        s, d, sine, cosine = mean[q, 1:middle], difference[q, 1:middle], sines[q], cosines[q]
        multiply_opposites(line[2:n], other[n + 2 : 2 * n], s, d, sine, cosine)
        if opposite != q:
            multiply_opposites(other[2:n], line[n + 2 : 2 * n], s, d, -sine, cosine)
        for k in (0, n):  # columns that are opposite to themselves
            turned, across = difference[q, k // 2] * sine, difference[q, k // 2] * cosine
            here, there = mean[q, k // 2] - turned, mean[q, k // 2] + turned
            a, b, c, d = line[k], line[k + 1], other[k + 1], other[k]
            line[k], line[k + 1] = here * a + across * c, here * b + across * d
            if opposite != q:
                other[k + 1], other[k] = there * c + across * a, there * d + across * b


@njit(cache=True, inner=True)
def place_of(frequency, length, halved):
    """Return the row of a frequency; the even ones come first where columns are halved."""
    return frequency // 2 + frequency % 2 * (length // 2) if halved else frequency


@njit(cache=True, fused=True, inner=True)
def multiply_opposites(line, other, mean, difference, sine, cosine):
    """Multiply frequencies of a line, and the opposite ones, which `other` has from its end on.

    Both lines are real and imaginary parts in turn. i times a conjugate has both parts swapped, so
    that the opposite frequencies are just read backwards.
    """
    one, two, last = np.uint64(1), np.uint64(2), np.uint64(other.size - 1)
    for k in range(np.uint64(mean.size)):
        turned, across = difference[k] * sine, difference[k] * cosine
        here, there = mean[k] - turned, mean[k] + turned
        real, imaginary = two * k, two * k + one
        opposite_imaginary, opposite_real = last - real, last - imaginary
        a, b = line[real], line[imaginary]
        c, d = other[opposite_imaginary], other[opposite_real]
        line[real] = here * a + across * c
        line[imaginary] = here * b + across * d
        other[opposite_imaginary] = there * c + across * a
        other[opposite_real] = there * d + across * b


@njit(cache=True, fused=True, inner=True)
def turn_line(line: Array, turn: complex, out: Array) -> None:
    """Set `out` to a line times a number."""
    for j in range(out.size):
        out[j] = turn * line[j]


@njit(cache=True, fused=True, inner=True)
def turn_difference(line: Array, other: Array, turn: complex) -> None:
    """Replace two lines by their sum and by a multiple of their difference."""
    for j in range(line.size):
        difference = line[j] - other[j]
        line[j] += other[j]
        other[j] = turn * difference


@njit(cache=True, fused=True, inner=True)
def add_turned(line: Array, turn: complex, other: Array) -> None:
    """Add a multiple of another line to a line."""
    for j in range(line.size):
        line[j] += turn * other[j]


@njit(cache=True, fused=True, inner=True)
def turn_apart(line: Array, turn: complex, other: Array) -> None:
    """Replace two lines by the sum and the difference of the first and a multiple of the second."""
    for j in range(line.size):
        turned = turn * other[j]
        other[j] = line[j] - turned
        line[j] += turned


@njit(cache=True)
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


@njit(cache=True)
def combine(lines: Array, rows: int, turns: Array) -> None:
    """Set the first `rows` rows of columns from both their halves: `separate` backwards."""
    half = turns.size
    for i in range(min(rows, half)):
        turn = turns[i].conjugate()
        if half + i < rows:
            turn_apart(lines[i], turn, lines[half + i])
        else:
            add_turned(lines[i], turn, lines[half + i])


# These padded lengths are quick for their size, along columns and across them, by a trial of the
# even products of 2, 3, 5 and 7 up to 650: any length between two of them costs more than the
# longer one, or hardly less.
_LONG = (1024, 1280, 1536, 2048, 2560, 3072, 4096, 5120, 6144, 8192, 10240, 12288, 16384)
ALONG = np.array([16, 20, 32, 40, 64, 80, 128, 144, 256, 288, 320, 512, 640, 800, *_LONG])
ACROSS = np.array(
    [
        *(16, 20, 32, 40, 48, 64, 80, 96, 128, 144, 160, 200, 240, 256, 320, 384, 400, 512, 640),
        *(768, 800),
        *_LONG,
    ]
)

MAX_NODES = _LONG[-1] // 2  # maximum number of nodes across a window


def padded(reach: int, subcells: int, lengths: NDArray[np.int64]) -> int:
    """Return the minimum of quick lengths for nodes up to `reach` spacings apart, in cells.

    The coefficients are even, so a distance of half the length is still correct. The length is 0
    where there is none.
    """
    # The interpolation on sub-cells spreads pressure into a border of one cell on both sides.
    cells = reach if subcells == 1 else -(-reach // subcells) + 2
    for length in lengths:
        if length >= 2 * cells:
            return int(length)
    return 0


_padded = njit(cache=True, inner=True)(padded)


@njit(cache=True, inner=True)
def lines_of(rows, subcells, length):
    """Return the number of lines of cells that hold so many rows, as plans are made for them."""
    # Two rows of cells are a line; on sub-cells the interpolation needs one more on both sides.
    cells = rows // subcells + 2 if subcells > 1 else rows
    return min(-GROUP * (-cells // (2 * GROUP)), length // 2)


@njit(cache=True, inner=True)
def block_of(entry, rows, columns, real):
    """Return the array (lines, columns, rows side by side) of a block of nodes.

    It has further rows, and columns unless nodes are sub-cells; they hold zeros before a
    convolution.
    """
    if entry[SUBCELLS] > 1:
        return array_at(entry[BLOCK], (rows, columns, 1), real)
    lines = min(-(-rows // 2) + GROUP, entry[LENGTH] // 2)
    return array_at(entry[BLOCK], (lines, entry[WIDTH], 2), real)


@njit(cache=True, inner=True)
def find(table, length, width, kind):
    """Return the number of the entry with a key, 0 where there is none."""
    for k in range(1, table.shape[0]):
        here = table[k]
        if here[LENGTH] == length and here[WIDTH] == width and here[KIND] == kind:
            return k
    return 0


@njit(cache=True, inner=True)
def transform(entry, rows, real, both):
    """Convolve the cells of a block of so many rows in the array of the transforms.

    `entry` describes the transforms. `real` and `both` are arrays of their real and complex type.
    """
    length, n, half = entry[LENGTH] // 2, entry[WIDTH], entry[HALF]
    lines = lines_of(rows, entry[SUBCELLS], entry[LENGTH])
    row_plans = array_at(entry[ROW_PLANS], (-(-length // GROUP) + 1, 2), entry)
    row_forward, row_backward = row_plans[-(-lines // GROUP)]
    columns = array_at(entry[LINES], (length, n + COLUMN_GAP), both)
    numbers = array_at(entry[COLUMNS], (length, 2 * (n + COLUMN_GAP)), real)
    execute(entry[EXECUTE], row_forward)
    turns = array_at(entry[TURNS], (half,), both)
    if half:
        separate(columns, lines, turns)
    else:
        columns[lines:] = 0.0
    quarter = length // 2 + 1
    for k in range(2 if half else 1):
        execute(entry[EXECUTE], entry[FORWARD + k])
    multiply(
        numbers,
        array_at(entry[MEAN], (quarter, n // 2 + 1), real),
        array_at(entry[DIFFERENCE], (quarter, n // 2 + 1), real),
        array_at(entry[SINES], (quarter,), real),
        array_at(entry[COSINES], (quarter,), real),
        half > 0,
    )
    for k in range(2 if half else 1):
        execute(entry[EXECUTE], entry[BACKWARD + k])
    if half:
        combine(columns, lines, turns)
    execute(entry[EXECUTE], row_backward)


@njit(cache=True)
def cells_of(node, columns, block, subcells):
    """List the cells that hold the given nodes of a window of `columns` columns.

    Cells count within a block of whole cells: its first row and column in the window, and its
    numbers of rows and columns.
    """
    row, column, across = block[0], block[1], block[3] // subcells
    seen = np.zeros(block[2] // subcells * across, np.uint8)
    listed, count = np.empty(node.size, np.int64), 0
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


@njit(cache=True, inner=True)
def apply_on_subcells(entry, rows, columns, listed, side, real, both):
    """Replace the pressure on a block of sub-cells by its deflection: see `apply_of`.

    An empty list of cells stands for all cells.
    """
    r, length = len(side), entry[LENGTH]
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
        gather(cells, listed, weights, block, own, side, fine)
    else:
        gather_all(cells, weights, fine)
        add_own(own, loaded, block, side, fine)


@once
def apply_of(subcells: int, single: bool) -> Any:
    """Return the kernel for so many sub-cells along the side of a cell that convolves a block.

    It replaces the pressure on a block of so many rows and columns in the array of the transforms
    by its deflection in units of spacing / (pi E*). Further rows and columns are invalid
    afterwards. Where cells are listed, only they are loaded, and only their deflection is valid.
    """
    side = (0,) * subcells
    real, both = np.empty(0, "f4" if single else "f8"), np.empty(0, "c8" if single else "c16")

    def apply(entry, rows, columns, listed):
        transform(entry, rows, real, both)

    def apply_on_parts(entry, rows, columns, listed):
        apply_on_subcells(entry, rows, columns, listed, side, real, both)

    return njit(cache=True)(apply if subcells == 1 else apply_on_parts)


APPLY_TYPES = types.int64[::1], types.int64, types.int64, types.int64[::1]
apply_at = caller(types.none, APPLY_TYPES)


@once
def apply_address(subcells: int, single: bool) -> int:
    """Return the address of the kernel of `apply_of`, which is compiled if need be."""
    return address_of(apply_of(subcells, single), types.none, APPLY_TYPES)


@njit(cache=True)
def deflect(pressure, unit, entry, table, out):
    """Set `out` to the deflection [m] of a window by its pressures.

    The convolution with the transforms of an entry is counted in the table of the half-space.
    """
    rows, columns = pressure.shape
    values = block_of(entry, rows, columns, _DOUBLE)
    load(pressure, values)
    apply_at(entry[APPLY], (entry, rows, columns, np.empty(0, np.int64)))
    read(values, unit, out)
    table[0, 0] += 1
