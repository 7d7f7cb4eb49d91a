"""Compiled product of pressures on few nodes with the coefficients between each two of them.

Where the candidates of a block are few, their product with a stored half of a symmetric matrix is
faster than transforms of the whole block. It is in single precision, as those transforms are.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import numpy as np

from rolling.contact._kinds import INDICES, LINE, NOTHING, NUMBER, SINGLES
from rolling.contact._linked import linked
from rolling.contact.compiling import inlined

# Rows of the matrix whose sums stay in single precision. Longer sums would lose digits: with 2,000
# nodes the error would be 1e-6 of the largest deflection, and it is 2e-7.
ROWS = 64
# Products with n candidates are direct if n^2 is at most so many times the numbers of a transform.
# Collecting the matrix takes as long as five of its products; a descent takes three or four. Where
# both ways take the same time, which is at 10, transforms need less memory.
DIRECT = 8


def is_direct(nodes: int, transformed: int) -> bool:
    """Tell whether a product with so many nodes is faster than a transform of so many numbers."""
    return nodes * nodes <= DIRECT * transformed


@linked(NOTHING(SINGLES, INDICES, SINGLES))
def collect_between(coefficients, place, between):
    """Set the coefficients between all pairs of nodes, by rows up to the node itself.

    `place` leads from a node to the flat coefficients by distance, whose middle is no distance.
    """
    middle = coefficients.size // 2
    first = 0
    for k in range(place.size):
        row = between[first : first + k + 1]
        here = middle + np.int64(place[k])
        for j in range(row.size):
            row[j] = coefficients[here - np.int64(place[j])]
        first += row.size


@inlined(fused=True)
def multiply_row(row, pressure, own, sums):
    """Add a row times the pressure of its node to the sums; return the row times all pressures."""
    total = np.float32(0.0)
    for j in range(row.size):
        total += row[j] * pressure[j]
        sums[j] += row[j] * own
    return total


@linked(NOTHING(SINGLES, LINE, NUMBER, LINE))
def multiply_between(between, d, unit, deflection):
    """Set the deflections of nodes by pressures d on them, which each have a place in both lines.

    `between` is that of `collect_between`, and `unit` the deflection per pressure and coefficient.
    """
    nodes = d.size
    pressure = np.empty(nodes, np.float32)
    for k in range(nodes):
        pressure[k] = unit * d[k]
        deflection[k] = 0.0
    sums = np.empty(nodes, np.float32)
    first = 0
    for begin in range(0, nodes, ROWS):
        end = min(begin + ROWS, nodes)
        sums[:end] = 0.0
        for k in range(begin, end):
            # The node itself is the last one of its row.
            row = between[first : first + k]
            total = multiply_row(row, pressure, pressure[k], sums)
            deflection[k] += total + between[first + k] * pressure[k]
            first += k + 1
        for k in range(end):
            deflection[k] += sums[k]
