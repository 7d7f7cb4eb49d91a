"""What the edges of the bands are worth, where a resonance of the ring stands at one.

The filters of ISO 15242-1 have slopes, and the text was not at hand: edges are ideal here. Where a
resonance stands at an edge, a band changes with the place of its edge, and so it does with slopes.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, pi
from typing import NamedTuple

import numpy as np

from acoustics.arrays import Array
from acoustics.numbers import si
from acoustics.ring_velocity import VELOCITY_BANDS_HZ
from rolling.bearing.linear_ring import LinearRing, linear_ring
from rolling.bearing.ring_record import AXIAL, RADIAL
from rolling.numbers.doubt import Doubt, Severity
from rolling.scene.bearing_scene import BearingScene

MOVED = 0.05  # share by which an edge is moved, about half the width of a slope
LEAST_DB = 1.0  # that is worth a sentence
_STEPS = 2000  # least number of frequencies in a band
_PER_WIDTH = 4  # and in the width of the sharpest resonance at half of its power
_LONGEST_DECAY_S = 0.3  # as of a loss factor of 0.001 at 1 kHz
_DIRECTIONS = {RADIAL: 0, AXIAL: 2}  # axes of the ring


class MovedEdge(NamedTuple):
    """A band that changes with its edge.

    direction, band : str. Of the velocity.
    edge_hz : float, Hz. Edge of the band that matters more.
    resonance_hz : float, Hz. Resonance of the ring in this direction.
    change_db : float, dB. Largest change, without its sign, where the edge moves by a twentieth.
    """

    direction: str
    band: str
    edge_hz: float
    resonance_hz: float
    change_db: float


def moved_edges(ring: LinearRing) -> Iterator[MovedEdge]:
    """Yield bands whose level depends on the place of their edges, for waves of one velocity.

    A ring whose resonances do not decay has no such level.
    """
    if not ring.slowest_decay_s < _LONGEST_DECAY_S:
        return
    for direction, axis in _DIRECTIONS.items():
        resonance_hz = ring.radial_hz if direction == RADIAL else ring.axial_hz
        if not resonance_hz > 0:  # nothing holds the ring in this direction
            continue
        for band, (low, high) in VELOCITY_BANDS_HZ.items():
            own = _level_db(ring, axis, low, high)
            changes = {
                low: abs(_level_db(ring, axis, low * (1 - MOVED), high) - own),
                high: abs(_level_db(ring, axis, low, high * (1 + MOVED)) - own),
            }
            edge_hz = max(changes, key=lambda edge: changes[edge])
            # The width of a flat band changes by less than half a decibel.
            if changes[edge_hz] >= LEAST_DB:
                yield MovedEdge(direction, band, edge_hz, resonance_hz, changes[edge_hz])


def _level_db(ring: LinearRing, axis: int, low: float, high: float) -> float:
    """Return the level of the velocity of a ring in a band, for waves of one velocity."""
    steps = max(_STEPS, ceil(_PER_WIDTH * pi * ring.slowest_decay_s * (high - low)))
    frequency_hz: Array = np.linspace(low, high, steps)
    moved = np.linalg.solve(ring.dynamic_stiffness(frequency_hz), ring.stiffness_n_m)
    power = np.mean(np.square(np.abs(moved[:, axis, axis]))) * (high - low)
    return 10 * float(np.log10(power))


def edge_doubts(scene: BearingScene) -> Iterator[Doubt]:
    """Doubt bands at whose edge a resonance stands."""
    for edge in moved_edges(linear_ring(scene.model)):
        resonance = si(edge.resonance_hz, "Hz")
        at = si(edge.edge_hz, "Hz")
        yield Doubt(
            f"edge_of_{edge.direction}_{edge.band}",
            f"the {edge.direction} resonance at {resonance} makes the {edge.band} band depend on"
            f" its edge at {at}, and edges are ideal here: where ISO 15242 has slopes, the"
            f" {edge.direction} velocity of this band may differ by {edge.change_db:.1f} dB",
            Severity.NOTE,
        )
