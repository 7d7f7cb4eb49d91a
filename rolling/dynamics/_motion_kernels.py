"""Compiled time steps of ball and plate, which keep the energy of the contact exactly.

A step from state 0 to state 1 holds the law of its middle position and takes the mean force
F = (U(d1) - U(d0)) / (d1 - d0), a discrete gradient:

    M (u1 - u0) / h = W - F,   (z1 - z0) / h = (u1 + u0) / 2,   (w1 - w0) / h = Y (F - W)

With d = z - w this is one equation for d1, whose left side rises:

    (d1 - d0) + give F = push,   give = h^2 / (2 M) + h Y,   push = h u0 + give W
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

import numpy as np

from rolling.contact.compiling import njit
from rolling.dynamics._law_kernels import (
    between,
    energy_to,
    law_at,
    root_of_force,
    set_pieces,
    stiffness_at,
)

_ROUNDING = 4e-16  # of the approach; Newton's method ends at smaller steps
_MOST = 60  # iterations; Newton needs three, halving of the bracket ends it in any case


@njit(cache=True)
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


@njit(cache=True)
def pressed(approach, sigma, push, give, table, pieces):
    """Return approach, sigma and mean force of a step that ends in contact, by Newton's method.

    The bracket is safe: the residual is negative at lift-off, and positive where no force acts.
    """
    low, high = pieces[0, 2], approach + push
    force = sigma**3
    new = high
    if sigma > 0.0:
        stiffness = stiffness_at(sigma, table, pieces)
        new = approach + (push - give * force) / (1.0 + 0.5 * give * stiffness)
    for _ in range(_MOST):
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
def advance(state, step, load, mass, mobility, places, table, record):
    """Set the rows of `record` to force, approach, ball velocity and plate displacement.

    Row i is of the middle of step i, where the ball is at place i: the mean force, and the means of
    the states at both ends. `state` is approach [m], velocity [m/s] and plate displacement [m].

    Returns the state at the end, and energies [J]: the change of kinetic energy plus U, the work of
    load and track, the loss to the plate, and the range of U. The work of the track is the change
    of U from one step's law to the next at the same approach.
    """
    approach, velocity, plate = state
    give = step * step / (2.0 * mass) + step * mobility
    law = table.values[0].copy()
    pieces = np.empty((table.breaks.shape[0], 4))
    first, energy, kinetic, lowest, highest = np.nan, np.nan, 0.0, np.inf, -np.inf
    load_work, track_work, loss = 0.0, 0.0, 0.0
    for i in range(places.shape[0]):
        law_at(places[i], table, law)
        set_pieces(law, table, pieces)
        sigma = root_of_force(approach, table, pieces)
        stored = energy_to(sigma, table, pieces)
        if i == 0:
            first = stored
        else:
            track_work += stored - energy
        push = step * velocity + give * load
        new, mean = lifted(approach, stored, push, give, law[0])
        end = 0.0
        if np.isnan(new):
            new, end, mean = pressed(approach, sigma, push, give, table, pieces)
        energy = energy_to(end, table, pieces)
        gain = step * (load - mean) / mass
        sink = step * mobility * (mean - load)
        record[i, 0] = mean
        record[i, 1] = 0.5 * (approach + new)
        record[i, 2] = velocity + 0.5 * gain
        record[i, 3] = plate + 0.5 * sink
        if mass < np.inf:
            kinetic += mass * gain * (velocity + 0.5 * gain)
        load_work += load * (new - approach)
        loss += sink * (mean - load)
        velocity += gain
        plate += sink
        approach = new
        lowest = min(lowest, energy)
        highest = max(highest, energy)
    change = kinetic + (energy - first)
    return (approach, velocity, plate), (change, load_work, track_work, loss, highest - lowest)
