"""Compiled passes over columns in frequency, and over columns whose second half is zero.

A column of nodes is padded to twice its length. The first step of a transform with radix 2,
decimated in frequency, separates even and odd frequencies. Where half of the column is zero, this
step takes no more than a product, and two transforms of half the length remain, each on half of the
memory.
"""

from __future__ import annotations

from rolling._typing import Array
from rolling.contact._compiled import njit


@njit(cache=True)
def multiply(lines: Array, coefficients: Array, halved: bool) -> None:
    """Multiply lines by the coefficients of their frequencies.

    The second half of the frequencies mirrors the first half. Where columns are halved, the even
    frequencies come first (see `separate`).
    """
    rows = lines.shape[0]
    for i in range(rows):
        frequency = i if not halved else 2 * i if 2 * i < rows else 2 * i - rows + 1
        line, row = lines[i], coefficients[min(frequency, rows - frequency)]
        for j in range(row.size):
            line[j] *= row[j]


@njit(cache=True, fused=True)
def turn_line(line: Array, turn: complex, out: Array) -> None:
    """Set `out` to a line times a number."""
    for j in range(out.size):
        out[j] = turn * line[j]


@njit(cache=True, fused=True)
def turn_difference(line: Array, other: Array, turn: complex) -> None:
    """Replace two lines by their sum and by a multiple of their difference."""
    for j in range(line.size):
        difference = line[j] - other[j]
        line[j] += other[j]
        other[j] = turn * difference


@njit(cache=True, fused=True)
def add_turned(line: Array, turn: complex, other: Array) -> None:
    """Add a multiple of another line to a line."""
    for j in range(line.size):
        line[j] += turn * other[j]


@njit(cache=True, fused=True)
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
