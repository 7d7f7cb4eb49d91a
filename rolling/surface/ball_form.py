"""Surface of a ball: waves around its circumference, and its sum with that of a plate."""

from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array
from rolling.contact.track import Track

FORM_ORDERS = range(2, 16)  # waves around that make up a grade's deviation from spherical form
WAVE_NODES = 4  # minimum number of nodes of a wave
_FORM_SEED = 2  # part of the seed of a ball, so that its phases are not those of its roughness


@dataclass(frozen=True, kw_only=True)
class BallForm:
    """Deviation of a ball from a circle along the track.

    Attributes
    ----------
    deviation_m : float, m
        Peak-to-valley height of random waves, whose amplitudes fall with the order. 0: none.
    seed : int
        Seed of the phases of these waves.
    waves_m : tuple of (int, float), m
        Order and amplitude of further waves.
    """

    deviation_m: float = 0.0
    seed: int = 0
    waves_m: tuple[tuple[int, float], ...] = ()


def form_heights(form: BallForm, nodes: int) -> Array:
    """Return the heights [m] of the waves around a circumference of some nodes."""
    angle = _angle(nodes)
    line = np.zeros(nodes)
    if form.deviation_m > 0:
        random = np.random.default_rng((form.seed, _FORM_SEED))
        phases = random.uniform(0, 2 * np.pi, len(FORM_ORDERS))
        for order, phase in zip(FORM_ORDERS, phases, strict=True):
            if order * WAVE_NODES <= nodes:
                line += np.cos(order * angle + phase) / order
        line *= form.deviation_m / np.ptp(line)
    for order, amplitude_m in form.waves_m:
        line += amplitude_m * np.cos(order * angle)
    return line


def without_first_order(heights: Array) -> Array:
    """Return heights (around, across) [m] of a turn without its wave of order 1.

    This wave moves the centre only.
    """
    angle = _angle(len(heights))
    for wave in (np.cos(angle), np.sin(angle)):
        heights = heights - np.outer(wave, 2 / len(wave) * (wave @ heights.mean(axis=1)))
    return np.asarray(heights)


def _angle(nodes: int) -> Array:
    """Return the angles of the nodes of a turn [rad]."""
    return np.asarray(2 * np.pi / nodes * np.arange(nodes), dtype=np.float64)


def rolled_together(plate: Array, ball: Array, track: Track, start: float) -> Array:
    """Return the sum of the heights of plate and sphere [m] along a track that starts at `start`.

    Beside a track that does not close, half a width of the surface goes on as it would; then its
    end fades into its beginning, so that the sum is periodic.
    """
    nodes = track.n_along
    across = track.n_across
    if nodes % len(plate) == 0 and nodes % len(ball) == 0:
        total = plate
        if len(plate) != nodes:
            total = np.tile(plate, (nodes // len(plate), 1))
        for first in range(0, nodes, len(ball)):
            total[first : first + len(ball)] += ball
        return total
    parts = [part for part in (plate, ball) if len(part) != nodes]
    first = int(np.floor(start / track.spacing)) - across // 2
    places = first + np.arange(nodes)
    total = np.sum([part[places % len(part)] for part in parts], axis=0)
    before = np.sum([part[(places[-across:] - nodes) % len(part)] for part in parts], axis=0)
    turn = np.pi / 2 * (np.arange(across)[:, None] + 0.5) / across
    total[-across:] = np.cos(turn) * total[-across:] + np.sin(turn) * before
    total = np.roll(total, first, axis=0)
    if len(plate) == nodes:
        return total + plate
    return total
