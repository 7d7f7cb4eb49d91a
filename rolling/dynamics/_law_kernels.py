"""Compiled evaluation of a force law: contact force, stiffness and energy at a place and approach.

At a place the slope g = da/ds of the approach a over s = F^(2/3) is a broken line over `breaks`,
constant beyond the last. The energy is then a polynomial of sigma = F^(1/3) between two breaks.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from rolling._typing import Array
from rolling.contact._compiled import njit


class LawTable(NamedTuple):
    """Force law at equally spaced positions, as the kernels read it.

    Row i of `values` has the approach at lift-off and the slopes g at the breaks; `slopes` has
    their derivatives along the track. A closed track repeats its first row at the end.
    """

    start: float
    spacing: float
    closed: bool
    breaks: Array
    values: Array
    slopes: Array


@njit(cache=True)
def law_at(x, table, law):
    """Set `law` to approach at lift-off and slopes g at a position, by cubics of Hermite."""
    rows = table.values.shape[0]
    t = (x - table.start) / table.spacing
    if table.closed:
        t -= (rows - 1) * (t // (rows - 1))
    i = min(max(int(t), 0), rows - 2)
    t -= i
    h11 = t * t * (t - 1.0) * table.spacing
    h10 = t * (t - 1.0) * (t - 1.0) * table.spacing
    h01 = t * t * (3.0 - 2.0 * t)
    for j in range(law.shape[0]):
        a, b = table.values[i, j], table.values[i + 1, j]
        law[j] = a + h01 * (b - a) + h10 * table.slopes[i, j] + h11 * table.slopes[i + 1, j]


@njit(cache=True)
def law_change(x, table, change):
    """Set `change` to the derivatives along the track of the numbers that `law_at` gives."""
    rows = table.values.shape[0]
    t = (x - table.start) / table.spacing
    if table.closed:
        t -= (rows - 1) * (t // (rows - 1))
    i = min(max(int(t), 0), rows - 2)
    t -= i
    h01 = 6.0 * t * (1.0 - t) / table.spacing
    h10 = (3.0 * t - 1.0) * (t - 1.0)
    h11 = t * (3.0 * t - 2.0)
    for j in range(change.shape[0]):
        rise = table.values[i + 1, j] - table.values[i, j]
        change[j] = h01 * rise + h10 * table.slopes[i, j] + h11 * table.slopes[i + 1, j]


@njit(cache=True)
def root_of_force(approach, law, breaks):
    """Return sigma = F^(1/3) at an approach [m]; it is zero where the surfaces are apart."""
    left = approach - law[0]
    if left <= 0.0:
        return 0.0
    last = breaks.shape[0] - 1
    for p in range(last):
        g, length = law[1 + p], breaks[p + 1] - breaks[p]
        bend = (law[2 + p] - g) / length
        whole = length * (g + 0.5 * bend * length)
        if left < whole:
            return sqrt(breaks[p] + 2.0 * left / (g + sqrt(max(g * g + 2.0 * bend * left, 0.0))))
        left -= whole
    return sqrt(breaks[last] + left / law[1 + last])


@njit(cache=True)
def between(low, high, law, breaks):
    """Return energy [J] and approach [m] from sigma `low` up to `high`.

    Both are sums of positive terms times differences of sigma, so their quotient, the mean force,
    keeps its digits for the closest neighbours.
    """
    energy = 0.0
    approach = 0.0
    last = breaks.shape[0] - 1
    a = low
    for p in range(last + 1):
        if p < last and a * a >= breaks[p + 1]:
            continue
        end = p == last or high * high <= breaks[p + 1]
        b = high if end else sqrt(breaks[p + 1])
        bend = (law[2 + p] - law[1 + p]) / (breaks[p + 1] - breaks[p]) if p < last else 0.0
        g = law[1 + p] - bend * breaks[p]
        a2, b2 = a * a, b * b
        both = a2 * a2 + b2 * b2
        fourth = both + a * b * (a2 + a * b + b2)  # (b^5 - a^5) / (b - a)
        sixth = both * (a2 + b2) + a * b * (both + a2 * b2)  # (b^7 - a^7) / (b - a)
        energy += (b - a) * (0.4 * g * fourth + bend * sixth / 3.5)
        approach += (b - a) * (a + b) * (g + 0.5 * bend * (a2 + b2))
        if end:
            break
        a = b
    return energy, approach


@njit(cache=True)
def slope_at(sigma, law, breaks):
    """Return g = da/ds where the force is sigma^3."""
    s = sigma * sigma
    last = breaks.shape[0] - 1
    for p in range(last):
        if s < breaks[p + 1]:
            share = (s - breaks[p]) / (breaks[p + 1] - breaks[p])
            return law[1 + p] + share * (law[2 + p] - law[1 + p])
    return law[1 + last]


@njit(cache=True)
def evaluate(position, approach, table, values):
    """Set the columns of `values` to F [N], dF/dd [N/m], U [J] and dU/dx [N] at (x, d)."""
    law = table.values[0].copy()
    change = law.copy()
    for i in range(position.shape[0]):
        law_at(position[i], table, law)
        law_change(position[i], table, change)
        sigma = root_of_force(approach[i], law, table.breaks)
        force = sigma**3
        values[i, 0] = force
        values[i, 1] = 1.5 * sigma / slope_at(sigma, law, table.breaks)
        values[i, 2] = between(0.0, sigma, law, table.breaks)[0]
        # By parts: dU/dx = integral of F dg/dx over s, less F times da/dx at this force.
        work, rise = between(0.0, sigma, change, table.breaks)
        values[i, 3] = work - force * (change[0] + rise)
