"""Compiled deflection of few nodes by direct sums over their pairs, without transforms.

The coefficients between the nodes are a symmetric matrix, of which the lower triangle is stored by
rows; a row is one of this triangle here, not one of nodes. Where the candidates of a block are few,
its products are quicker than transforms of the whole block. They are in single precision, as those
transforms are.
"""

# mypy: disable-error-code="no-untyped-def,no-untyped-call"
from __future__ import annotations

import numpy as np

from rolling.contact._kinds import INDICES, LINE, NOTHING, NUMBER, SINGLES
from rolling.contact._linked import linked
from rolling.contact.compiling import inlined

# After so many rows the sums down the columns are added up in double precision. Each of them grows
# by one addition a row: 2,000 rows in one go give an error of 1e-6 of the maximum deflection, in
# parts 2e-7, and 3e-7 for 2,896 rows, the most that DIRECT_UP_TO and MAX_INFLUENCE allow (pressures
# of one sign at places drawn at random). A sum along a row may stay single: it is `fused`, so the
# processor takes it in several parts.
ROWS_PER_SUM = 64
# Sums over n candidates are direct up to n^2 = 8 times the padded points of their block. With 16 no
# contact of tests/benchmarks/solver_in_turn.py is quicker by more than 2 %, and the triangle takes
# more memory: 2 n^2 bytes, 16 MB at most with 8.
DIRECT_UP_TO = 8


def is_direct(candidates: int, padded_points: int) -> bool:
    """Tell whether so few candidates are deflected by direct sums (see DIRECT_UP_TO)."""
    return candidates * candidates <= DIRECT_UP_TO * padded_points


@linked(NOTHING(SINGLES, INDICES, SINGLES))
def collect_triangle(coefficients, place, triangle):
    """Set the lower triangle of the coefficients between nodes, by rows with their diagonal.

    `place` is the index of each node on a grid with rows as long as those of the flat coefficients
    by distance: their middle is distance 0, so that differences of places lead to all others.
    """
    middle = coefficients.size // 2
    first = 0
    for k in range(place.size):
        row = triangle[first : first + k + 1]
        here = middle + np.int64(place[k])
        for j in range(row.size):
            row[j] = coefficients[here - np.int64(place[j])]
        first += row.size


@inlined(fused=True)
def multiply_row(row, scaled, own, sums):
    """Deflect the node of a row and the nodes before it by each other.

    A coefficient acts both ways: the deflection of the row's node is returned, and those by its
    own pressure are added to the sums.
    """
    total = np.float32(0.0)
    for j in range(row.size):
        total += row[j] * scaled[j]
        sums[j] += row[j] * own
    return total


@linked(NOTHING(SINGLES, LINE, NUMBER, LINE))
def multiply_triangle(triangle, d, unit, deflection):
    """Set the deflection of each node by the pressures d on all of them, in the order of the nodes.

    `unit` is the deflection per pressure and coefficient.
    """
    nodes = d.size
    scaled = np.empty(nodes, np.float32)  # deflection per coefficient [m]
    for k in range(nodes):
        scaled[k] = unit * d[k]
        deflection[k] = 0.0
    sums = np.empty(nodes, np.float32)
    first = 0
    for begin in range(0, nodes, ROWS_PER_SUM):
        end = min(begin + ROWS_PER_SUM, nodes)
        sums[:end] = 0.0
        for k in range(begin, end):
            total = multiply_row(triangle[first : first + k], scaled, scaled[k], sums)
            deflection[k] += total + triangle[first + k] * scaled[k]
            first += k + 1
        for k in range(end):
            deflection[k] += sums[k]
