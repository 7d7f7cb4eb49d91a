"""Compiled time steps of the modes of a plate with edges.

A step moves each mode exactly under a constant force F beyond the load. With the elastic energy
Q^2 / 2 and the kinetic energy P^2 / 2 of a mode, the displacement w = sum g Q, and X = Q - g F,

    Q1 = Q0 - e X + b P0,   P1 = c P0 - b X,   w1 - w0 = C F - B

have the compliance C = sum e g^2, and B = sum g (e Q0 - b P0) is lost without a force.
"""

# mypy: disable-error-code="no-untyped-def"
from math import cos, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array
from rolling.contact.compiling import inlined, njit


class StepBodies(NamedTuple):
    """Ball, contact and plate as a time step moves them; the arrays have a value for each mode.

    `counts` has the number of modes by half waves along a plate with edges, each with one more half
    wave across; the modes after them have the same shape everywhere. Other shapes stand in a table
    of stations along the path of the contact.
    """

    step: float  # [s]
    mass: float  # [kg] of the ball
    mobility: float  # [s/kg] of the plate beside its modes
    contact_time: float  # [s] viscosity of the contact over its stiffness
    fall: Array  # e
    turn: Array  # b
    keep: Array  # c
    reach: Array  # g at an antinode [m/J^0.5]
    counts: NDArray[np.int64]
    sides: Array  # [m] length and width
    stations: Array  # shapes at stations on the path, (stations, modes); none: products of sines
    ends: Array  # (2, 2) first and last station [m]


@njit(cache=True)
def set_shapes(point, bodies, shape):
    """Set `shape` to the displacement g of each mode at a point [m]."""
    if bodies.stations.shape[0] > 0:
        set_shapes_on_path(point, bodies, shape)
        return
    around = np.pi * point[1] / bodies.sides[1]
    waves = np.empty(max(1, bodies.counts[0] if bodies.counts.shape[0] else 0))
    waves[0] = sin(around)
    before = 0.0
    for n in range(1, waves.shape[0]):
        waves[n] = 2.0 * cos(around) * waves[n - 1] - before
        before = waves[n - 1]
    i = 0
    for m in range(bodies.counts.shape[0]):
        along = sin(np.pi * (m + 1) * point[0] / bodies.sides[0])
        for n in range(bodies.counts[m]):
            shape[i] = bodies.reach[i] * along * waves[n]
            i += 1
    shape[i:] = bodies.reach[i:]


@njit(cache=True)
def set_shapes_on_path(point, bodies, shape):
    """Set `shape` by a cubic polynomial through four stations, or to the only one."""
    stations = bodies.stations
    count = stations.shape[0]
    if count < 4:
        shape[:] = bodies.reach * stations[0]
        return
    along = bodies.ends[1] - bodies.ends[0]
    passed = (point - bodies.ends[0]) @ along / (along @ along)
    place = min(max(passed, 0.0), 1.0) * (count - 1)
    first = min(max(int(place) - 1, 0), count - 4)
    x = place - first
    w0 = -(x - 1.0) * (x - 2.0) * (x - 3.0) / 6.0
    w1 = x * (x - 2.0) * (x - 3.0) / 2.0
    w2 = -x * (x - 1.0) * (x - 3.0) / 2.0
    w3 = x * (x - 1.0) * (x - 2.0) / 6.0
    for i in range(shape.shape[0]):
        value = w0 * stations[first, i] + w1 * stations[first + 1, i]
        value += w2 * stations[first + 2, i] + w3 * stations[first + 3, i]
        shape[i] = bodies.reach[i] * value


@inlined(fused=True)
def free_modes(shape, bodies, elastic, kinetic):
    """Return displacement, its fall in a step without a force [m], and compliance [m/N]."""
    fall = bodies.fall
    turn = bodies.turn
    start = 0.0
    back = 0.0
    compliance = 0.0
    for i in range(shape.shape[0]):
        start += shape[i] * elastic[i]
        back += shape[i] * (fall[i] * elastic[i] - turn[i] * kinetic[i])
        compliance += fall[i] * shape[i] * shape[i]
    return start, back, compliance


@njit(cache=True, fused=True)
def move_modes(force, shape, bodies, elastic, kinetic):
    """Move the modes by a step under a constant force [N]."""
    fall = bodies.fall
    turn = bodies.turn
    keep = bodies.keep
    for i in range(shape.shape[0]):
        left = elastic[i] - shape[i] * force
        speed = kinetic[i]
        elastic[i] += turn[i] * speed - fall[i] * left
        kinetic[i] = keep[i] * speed - turn[i] * left
