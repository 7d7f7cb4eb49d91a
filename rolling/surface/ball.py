"""Heights of a sphere's surface, unrolled along the track, and their sum with the plate's.

In pure rolling each place of the sphere meets the place of the plate that it rolled to, so both
surfaces add up to one that does not move: z(x, y) = plate(x, y) + sphere(x mod 2 pi R, y).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from acoustics.arrays import Array
from rolling.scene.scene import Scene
from rolling.scene.surfaces import GRADES, WAVE_NODES, BallHeightFile, BallSurface, GradedBall
from rolling.scene.track import Track
from rolling.surface import heights as surface
from rolling.surface import levelling, made
from rolling.surface.faults import add_faults

FORM_ORDERS = range(2, 16)  # that make up the deviation of a grade from spherical form
# Parts of the seeds of a sphere, so that sphere and plate of equal seeds have other heights.
_ROUGHNESS, _FORM = 1, 2


def ball_heights(scene: Scene, ball: BallSurface) -> tuple[Array, dict[str, Any]]:
    """Make the heights [m] of a sphere's surface, (nodes of a turn, across), and describe them.

    Raises
    ------
    SurfaceError
        The filter leaves nothing, or a file cannot be used.
    """
    track, law = scene.track, ball.law
    shape, spacing = (track.turn_nodes, track.n_across), track.spacing
    if law is not None:
        heights = made.of_law(shape, spacing, law, (law.seed, _ROUGHNESS))
    elif isinstance(ball, BallHeightFile):
        heights = _read(scene, ball)
    else:
        heights = surface.smooth(shape)
    described = made.described("ball_surface_made", heights, spacing, law)
    if ball.has_form:
        heights += _form(ball, track.turn_nodes)[:, None]
    add_faults(heights, ball.faults or (), spacing)
    return heights, described


def _read(scene: Scene, ball: BallHeightFile) -> Array:
    """Read the heights [m] of a turn without its wave of order 1, which moves the centre only."""
    path, across = scene.height_paths["sphere.surface"], scene.track.n_across
    heights = levelling.read_heights(path, ball.height_unit)
    if heights.shape[1] == 1:
        heights = np.repeat(heights, across, axis=1)
    angle = _angle(len(heights))
    for wave in (np.cos(angle), np.sin(angle)):
        heights = heights - np.outer(wave, 2 / len(wave) * (wave @ heights.mean(axis=1)))
    return np.asarray(heights)


def _form(ball: BallSurface, nodes: int) -> Array:
    """Return the heights [m] of the waves around a circumference of some nodes."""
    angle, line = _angle(nodes), np.zeros(nodes)
    if isinstance(ball, GradedBall):
        phases = np.random.default_rng((ball.seed, _FORM)).uniform(0, 2 * np.pi, len(FORM_ORDERS))
        for order, phase in zip(FORM_ORDERS, phases, strict=True):
            if order * WAVE_NODES <= nodes:
                line += np.cos(order * angle + phase) / order
        line *= GRADES[ball.grade].deviation_um * 1e-6 / np.ptp(line)
    for order, amplitude_um in (ball.waviness or {}).items():
        line += amplitude_um * 1e-6 * np.cos(order * angle)
    return line


def _angle(nodes: int) -> Array:
    """Return the angles of the nodes of a turn [rad]."""
    return np.asarray(2 * np.pi / nodes * np.arange(nodes), dtype=np.float64)


def rolled_together(plate: Array, ball: Array, track: Track, start: float) -> Array:
    """Return the sum of the heights of plate and sphere [m] along a track that starts at `start`.

    Beside a track that does not close, half a width of the surface goes on as it would; then its
    end fades into its beginning, so that the sum is periodic.
    """
    nodes, across = track.n_along, track.n_across
    if nodes % len(plate) == 0 and nodes % len(ball) == 0:
        total = plate if len(plate) == nodes else np.tile(plate, (nodes // len(plate), 1))
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
    return total + plate if len(plate) == nodes else total
