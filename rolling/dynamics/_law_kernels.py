"""Compiled evaluation of a force law: contact force, stiffness and energy at a place and approach.

At a place the slope g = da/ds of the approach a over s = F^(2/3) is a broken line over `breaks`,
constant beyond the last. With sigma = F^(1/3), approach and energy are then polynomials of sigma
on each piece between two breaks. Row p of `pieces` describes the piece from break p up: g = row[0]
+ row[1] s; approach and energy at the break are row[2] and row[3].
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import floor, sqrt
from typing import NamedTuple

import numpy as np

from rolling._typing import Array
from rolling.contact.compiling import njit


class LawTable(NamedTuple):
    """Force law at equally spaced positions, as the kernels read it.

    Row i of `values` has the approach at lift-off and the slopes g at the breaks; `slopes` has
    their derivatives along the track. A closed track repeats its first row at the end. `edges` are
    the square roots of `breaks`.
    """

    start: float
    spacing: float
    closed: bool
    breaks: Array
    edges: Array
    values: Array
    slopes: Array


@njit(cache=True)
def place_in(position, table):
    """Return the interval of the table that holds a position [m], and the share of it passed."""
    intervals = table.values.shape[0] - 1
    t = (position - table.start) / table.spacing
    if table.closed:
        t -= intervals * floor(t / intervals)
    i = min(max(int(t), 0), intervals - 1)
    return i, t - i


@njit(cache=True)
def law_at(position, table, law):
    """Set `law` to approach at lift-off and slopes g at a position, by cubics of Hermite."""
    i, t = place_in(position, table)
    h01 = t * t * (3.0 - 2.0 * t)
    h10 = t * (t - 1.0) * (t - 1.0) * table.spacing
    h11 = t * t * (t - 1.0) * table.spacing
    for j in range(law.shape[0]):
        rise = table.values[i + 1, j] - table.values[i, j]
        bend = h10 * table.slopes[i, j] + h11 * table.slopes[i + 1, j]
        law[j] = table.values[i, j] + h01 * rise + bend


@njit(cache=True)
def laws_at(position, table, laws):
    """Set the rows of `laws` to approach at lift-off and slopes g at positions."""
    for i in range(position.shape[0]):
        law_at(position[i], table, laws[i])


@njit(cache=True)
def law_change(position, table, change):
    """Set `change` to the derivatives along the track of the numbers that `law_at` gives."""
    i, t = place_in(position, table)
    h01 = 6.0 * t * (1.0 - t) / table.spacing
    h10 = (3.0 * t - 1.0) * (t - 1.0)
    h11 = t * (3.0 * t - 2.0)
    for j in range(change.shape[0]):
        rise = table.values[i + 1, j] - table.values[i, j]
        change[j] = h01 * rise + h10 * table.slopes[i, j] + h11 * table.slopes[i + 1, j]


@njit(cache=True)
def set_pieces(law, table, pieces):
    """Set `pieces` to the polynomials of a law at a place."""
    last = pieces.shape[0] - 1
    approach = law[0]
    energy = 0.0
    for p in range(last + 1):
        bend = 0.0
        if p < last:
            bend = (law[2 + p] - law[1 + p]) / (table.breaks[p + 1] - table.breaks[p])
        pieces[p, 0] = law[1 + p] - bend * table.breaks[p]
        pieces[p, 1] = bend
        pieces[p, 2] = approach
        pieces[p, 3] = energy
        if p < last:
            work, rise = on_piece(table.edges[p], table.edges[p + 1], pieces[p])
            approach += rise
            energy += work


@njit(cache=True)
def on_piece(low, high, piece):
    """Return energy [J] and approach [m] from sigma `low` to `high` on one piece.

    Both are `high - low` times sums of like terms, so their quotient, the mean force, keeps its
    digits for the closest neighbours.
    """
    a, b = low * low, high * high
    both = a * a + b * b
    fourth = both + low * high * (a + low * high + b)  # (high^5 - low^5) / (high - low)
    sixth = both * (a + b) + low * high * (both + a * b)  # (high^7 - low^7) / (high - low)
    energy = (high - low) * (0.4 * piece[0] * fourth + piece[1] * sixth / 3.5)
    return energy, (high - low) * (low + high) * (piece[0] + 0.5 * piece[1] * (a + b))


@njit(cache=True)
def piece_of(sigma, table):
    """Return the number of the piece that holds a sigma."""
    p = table.edges.shape[0] - 1
    while p > 0 and sigma < table.edges[p]:
        p -= 1
    return p


@njit(cache=True)
def energy_to(sigma, table, pieces):
    """Return the energy U [J] from lift-off to a sigma."""
    p = piece_of(sigma, table)
    return pieces[p, 3] + on_piece(table.edges[p], sigma, pieces[p])[0]


@njit(cache=True)
def between(low, high, table, pieces):
    """Return energy [J] and approach [m] from sigma `low` to `high`, in any order."""
    p, q = piece_of(low, table), piece_of(high, table)
    if p == q:
        return on_piece(low, high, pieces[p])
    sign = 1.0
    if p > q:
        p, q, low, high, sign = q, p, high, low, -1.0
    energy, approach = on_piece(low, table.edges[p + 1], pieces[p])
    work, rise = on_piece(table.edges[q], high, pieces[q])
    energy += work + pieces[q, 3] - pieces[p + 1, 3]
    approach += rise + pieces[q, 2] - pieces[p + 1, 2]
    return sign * energy, sign * approach


@njit(cache=True)
def root_of_force(approach, table, pieces):
    """Return sigma = F^(1/3) at an approach [m]; it is zero where the surfaces are apart."""
    if approach <= pieces[0, 2]:
        return 0.0
    p = pieces.shape[0] - 1
    while approach < pieces[p, 2]:
        p -= 1
    left = approach - pieces[p, 2]
    g = pieces[p, 0] + pieces[p, 1] * table.breaks[p]
    root = sqrt(max(g * g + 2.0 * pieces[p, 1] * left, 0.0))
    return sqrt(table.breaks[p] + 2.0 * left / (g + root))


@njit(cache=True)
def stiffness_at(sigma, table, pieces):
    """Return dF/dd = 3/2 sigma / g [N/m] where the force is sigma^3."""
    p = piece_of(sigma, table)
    return 1.5 * sigma / (pieces[p, 0] + pieces[p, 1] * sigma * sigma)


@njit(cache=True)
def evaluate(position, approach, table, values):
    """Set the columns of `values` to F [N], dF/dd [N/m], U [J] and dU/dx [N] at (x, d)."""
    law = table.values[0].copy()
    change = law.copy()
    pieces = np.empty((table.breaks.shape[0], 4))
    moved = np.empty((table.breaks.shape[0], 4))
    for i in range(position.shape[0]):
        law_at(position[i], table, law)
        set_pieces(law, table, pieces)
        law_change(position[i], table, change)
        set_pieces(change, table, moved)
        sigma = root_of_force(approach[i], table, pieces)
        values[i, 0] = sigma**3
        values[i, 1] = stiffness_at(sigma, table, pieces)
        values[i, 2] = energy_to(sigma, table, pieces)
        # By parts: dU/dx = integral of F dg/dx over s, less F times da/dx at this force.
        work, rise = between(0.0, sigma, table, moved)
        values[i, 3] = work - values[i, 0] * (change[0] + rise)
