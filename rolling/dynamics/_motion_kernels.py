"""Compiled force law, and time steps of ball and plate that keep the energy of the contact exactly.

At a place the slope g = da/ds of the approach a over s = F^(2/3) is a broken line over `breaks`,
constant beyond the last. With sigma = F^(1/3), approach and energy are then polynomials of sigma
on each piece between two breaks. Row p of `pieces` describes the piece from break p up: g = row[0]
+ row[1] s; approach and energy at the break are row[2] and row[3].

A step from state 0 to state 1 holds the law of its middle position and takes the mean force
F = (U(d1) - U(d0)) / (d1 - d0), a discrete gradient:

    M (u1 - u0) / h = W - F,   (z1 - z0) / h = (u1 + u0) / 2,   (w1 - w0) / h = Y (F - W)

Modes of a plate with edges, if there are any, add w1 - w0 = C (F - W) - B (`_mode_kernels`). With
d = z - w this is one equation for d1, whose left side rises:

    (d1 - d0) + give F = push,   give = h^2 / (2 M) + h Y + C,   push = h u0 + give W + B

A viscous force D (d1 - d0) / h of the contact divides give and push by 1 + give D / h.
"""

# mypy: disable-error-code="no-untyped-def"
from math import floor, sqrt
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from rolling.contact.compiling import inlined, njit
from rolling.dynamics._mode_kernels import free_modes, move_modes, set_shapes


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


class State(NamedTuple):
    """State of ball and plate; the plate is counted from its rest under the load."""

    approach: float  # [m]
    velocity: float  # [m/s] of the ball, towards the plate
    plate: float  # [m] displacement at the contact
    modes: Array = np.zeros((2, 0))  # Q and P of each mode [J^0.5], (2, modes)


@inlined()
def law_at(position, table, law):
    """Set `law` to approach at lift-off and slopes g at a position, by cubics of Hermite."""
    intervals = table.values.shape[0] - 1
    t = (position - table.start) / table.spacing
    if table.closed:
        t -= intervals * floor(t / intervals)
    i = min(max(int(t), 0), intervals - 1)
    t -= i
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


@inlined()
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


@inlined()
def on_piece(low, high, piece):
    """Return energy [J] and approach [m] from sigma `low` to `high` on one piece.

    Both are `high - low` times sums of like terms, so their quotient, the mean force, keeps its
    digits for the closest neighbours.
    """
    a = low * low
    b = high * high
    both = a * a + b * b
    fourth = both + low * high * (a + low * high + b)  # (high^5 - low^5) / (high - low)
    sixth = both * (a + b) + low * high * (both + a * b)  # (high^7 - low^7) / (high - low)
    energy = (high - low) * (0.4 * piece[0] * fourth + piece[1] * sixth / 3.5)
    return energy, (high - low) * (low + high) * (piece[0] + 0.5 * piece[1] * (a + b))


@inlined()
def piece_of(sigma, table):
    """Return the number of the piece that holds a sigma."""
    p = table.edges.shape[0] - 1
    while p > 0 and sigma < table.edges[p]:
        p -= 1
    return p


@inlined()
def energy_to(sigma, table, pieces):
    """Return the energy U [J] from lift-off to a sigma."""
    p = piece_of(sigma, table)
    return pieces[p, 3] + on_piece(table.edges[p], sigma, pieces[p])[0]


@njit(cache=True)
def between(low, high, table, pieces):
    """Return energy [J] and approach [m] from sigma `low` to `high`, in any order."""
    p = piece_of(low, table)
    q = piece_of(high, table)
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


@inlined()
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


@inlined()
def stiffness_at(sigma, table, pieces):
    """Return dF/dd = 3/2 sigma / g [N/m] where the force is sigma^3."""
    p = piece_of(sigma, table)
    return 1.5 * sigma / (pieces[p, 0] + pieces[p, 1] * sigma * sigma)


@njit(cache=True)
def evaluate(position, approach, table, values):
    """Set the columns of `values` to F [N] and dF/dd [N/m] at (x, d)."""
    law = table.values[0].copy()
    pieces = np.empty((table.breaks.shape[0], 4))
    for i in range(position.shape[0]):
        law_at(position[i], table, law)
        set_pieces(law, table, pieces)
        sigma = root_of_force(approach[i], table, pieces)
        values[i, 0] = sigma**3
        values[i, 1] = stiffness_at(sigma, table, pieces)


_ROUNDING = 4e-16  # of the approach; Newton's method ends at smaller steps
_MAX_ITERATIONS = 60  # iterations; Newton needs three, halving of the bracket ends it in any case


@inlined()
def lifted(approach, stored, push, give, lift_off):
    """Return approach and mean force of a step that ends in flight, or NaN if it does not.

    `stored` [J] is the energy at the start, which all goes into the step.
    """
    gap = lift_off - approach
    if gap >= 0.0:
        return (approach + push, 0.0) if push <= gap else (np.nan, np.nan)
    if gap - give * stored / gap < push:
        return np.nan, np.nan
    root = sqrt(push * push + 4.0 * give * stored)
    change = 0.5 * (push - root) if push <= 0.0 else -2.0 * give * stored / (push + root)
    return approach + change, -stored / change


@inlined()
def pressed(approach, sigma, push, give, table, pieces):
    """Return approach, sigma and mean force of a step that ends in contact, by Newton's method.

    The bracket is safe: the residual is negative at lift-off, and positive where no force acts.
    """
    low = pieces[0, 2]
    high = approach + push
    force = sigma**3
    new = high
    if sigma > 0.0:
        stiffness = stiffness_at(sigma, table, pieces)
        new = approach + (push - give * force) / (1.0 + 0.5 * give * stiffness)
    for _ in range(_MAX_ITERATIONS):
        if not low <= new <= high:
            new = 0.5 * (low + high)
        end = root_of_force(new, table, pieces)
        work, change = between(sigma, end, table, pieces)
        if sigma == 0.0:
            change = new - approach
        mean = work / change if change != 0.0 else force
        if abs(change) > 1e-6 * (new - pieces[0, 2]):
            steep = (end**3 - mean) / change
        else:
            steep = 0.5 * stiffness_at(end, table, pieces)
        residual = change + give * mean - push
        if residual > 0.0:
            high = new
        else:
            low = new
        correction = residual / (1.0 + give * steep)
        if abs(correction) <= _ROUNDING * (abs(new) + abs(approach)):
            break
        new -= correction
    return approach + change, end, mean


@njit(cache=True)
def advance(state, load, bodies, places, points, table, record):
    """Set the rows of `record` to force, approach, ball velocity and plate displacement, and modes.

    Row i is of the middle of step i, where the ball is at place i and touches a plate with edges at
    point i, or at the only point: the mean force, and the means of the states at both ends.

    The modes become those at the end. Returns the other numbers of the state there, and no array:
    numba hands arrays over by Python code, where an interrupt ends the process.

    Also returns energies [J]: the change of kinetic energy, U and modes, the work of load and
    track, the losses to plate and contact, and the range of U. The work of the track is the change
    of U from one step's law and point to the next.
    """
    approach = state.approach
    velocity = state.velocity
    plate = state.plate
    step = bodies.step
    mass = bodies.mass
    mobility = bodies.mobility
    modes = state.modes
    yielding = step * step / (2.0 * mass) + step * mobility
    back = 0.0
    compliance = 0.0
    drag = 0.0
    law = table.values[0].copy()
    pieces = np.empty((table.breaks.shape[0], 4))
    shape = np.empty(modes.shape[1])
    first = np.nan
    energy = np.nan
    kinetic = 0.0
    lowest = np.inf
    highest = -np.inf
    load_work = 0.0
    track_work = 0.0
    loss = 0.0
    contact_loss = 0.0
    modal = shape.shape[0] > 0
    modal_energy = -0.5 * np.sum(modes * modes)
    for i in range(places.shape[0]):
        law_at(places[i], table, law)
        set_pieces(law, table, pieces)
        if modal:
            if i == 0 or points.shape[0] > 1:
                set_shapes(points[i], bodies, shape)
            displacement, back, compliance = free_modes(shape, bodies, modes[0], modes[1])
            if points.shape[0] > 1:
                approach -= displacement - plate
            plate = displacement
        give = yielding + compliance
        sigma = root_of_force(approach, table, pieces)
        stored = energy_to(sigma, table, pieces)
        if i == 0:
            first = stored
        else:
            track_work += stored - energy
        if bodies.contact_time > 0.0:
            drag = bodies.contact_time / step * stiffness_at(sigma, table, pieces)
        push = step * velocity + give * load + back
        end = 0.0
        free = push
        if drag > 0.0:
            push = push / (1.0 + give * drag)
            give = give / (1.0 + give * drag)
        new, mean = lifted(approach, stored, push, give, law[0])
        if np.isnan(new):
            new, end, mean = pressed(approach, sigma, push, give, table, pieces)
        if drag > 0.0:
            mean += drag * (new - approach)
            if mean < 0.0:  # surfaces that part faster than the contact springs back do not pull
                new = approach + free
                mean = 0.0
                end = root_of_force(new, table, pieces)
        energy = energy_to(end, table, pieces)
        gain = step * (load - mean) / mass
        sink = step * mobility * (mean - load)
        if modal:
            sink += compliance * (mean - load) - back
            move_modes(mean - load, shape, bodies, modes[0], modes[1])
        record[i, 0] = mean
        record[i, 1] = 0.5 * (approach + new)
        record[i, 2] = velocity + 0.5 * gain
        record[i, 3] = plate + 0.5 * sink
        if mass < np.inf:
            kinetic += mass * gain * (velocity + 0.5 * gain)
        load_work += load * (new - approach)
        loss += sink * (mean - load)
        if drag > 0.0:
            contact_loss += mean * (new - approach) - (energy - stored)
        velocity += gain
        plate += sink
        approach = new
        lowest = min(lowest, energy)
        highest = max(highest, energy)
    modal_energy += 0.5 * np.sum(modes * modes)
    change = kinetic + (energy - first) + modal_energy
    loss = loss - modal_energy
    energies = (change, load_work, track_work, loss, contact_loss, highest - lowest)
    return (approach, velocity, plate), energies
