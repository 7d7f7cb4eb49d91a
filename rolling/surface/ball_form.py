"""Surface of a ball: waves around its circumference, and its sum with that of a plate."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acoustics.arrays import Array
from rolling.contact.track import Track
from rolling.surface.wave_law import WaveLaw

FORM_ORDERS = range(2, 16)  # waves around that make up a grade's deviation from spherical form
WAVE_NODES = 4  # minimum number of nodes of a wave
# Parts of the seed of a ball, so that its form, its further waves and its roughness differ.
_FORM_SEED = 2
_BEYOND_SEED = 3
_NODES = 1024  # of a turn on which the height of a deviation is found


@dataclass(frozen=True, kw_only=True)
class BallForm:
    """Deviation of a ball from a circle along the track.

    Attributes
    ----------
    deviation_m : float, m
        Peak-to-valley height of random waves, whose amplitudes fall with the order. 0: none.
    seed : int
        Seed of the phases of these waves.
    exponent : float or None
        Power by which amplitudes fall beyond the random waves of a deviation, from the amplitude of
        the last of them on. None: they end there.
    waves_m : tuple of (int, float), m
        Order and amplitude of further waves.
    law : WaveLaw or None
        Law of further random waves.
    measured_m : tuple of (int, float, float), m and rad
        Order, amplitude and phase of waves that were measured.
    """

    deviation_m: float = 0.0
    seed: int = 0
    exponent: float | None = None
    waves_m: tuple[tuple[int, float], ...] = ()
    law: WaveLaw | None = None
    measured_m: tuple[tuple[int, float, float], ...] = ()


def form_heights(form: BallForm, nodes: int) -> Array:
    """Return the heights [m] of the waves around a circumference of some nodes."""
    angle = _angle(nodes)
    line = np.zeros(nodes)
    if form.deviation_m > 0:
        line = _unit_deviation(form.seed, nodes)
        scale = form.deviation_m / np.ptp(line)
        line *= scale
        if form.exponent is not None:
            line += _beyond(form.exponent, form.seed, scale).heights(nodes, nodes // WAVE_NODES)
    for order, amplitude_m in form.waves_m:
        line += amplitude_m * np.cos(order * angle)
    if form.law is not None:
        line += form.law.heights(nodes, nodes // WAVE_NODES)
    if form.measured_m:
        line += _measured_heights(form.measured_m, nodes)
    return line


def random_amplitudes(form: BallForm, orders: int) -> Array:
    """Return the root-mean-square amplitudes [m] of the random waves of orders 0 to before a count.

    Waves of known orders are left out.
    """
    number = np.arange(orders)
    squares = np.zeros(orders)
    if form.deviation_m > 0:
        scale = form.deviation_m / np.ptp(_unit_deviation(form.seed, _NODES))
        known = np.isin(number, FORM_ORDERS)
        squares[known] += np.square(scale / number[known])
        if form.exponent is not None:
            squares += np.square(_beyond(form.exponent, form.seed, scale).amplitudes(range(orders)))
    if form.law is not None:
        squares += np.square(form.law.amplitudes(range(orders)))
    return np.asarray(np.sqrt(squares))


def _unit_deviation(seed: int, nodes: int) -> Array:
    """Return the waves of a deviation whose order n has the amplitude 1/n."""
    angle = _angle(nodes)
    line = np.zeros(nodes)
    random = np.random.default_rng((seed, _FORM_SEED))
    phases = random.uniform(0, 2 * np.pi, len(FORM_ORDERS))
    for order, phase in zip(FORM_ORDERS, phases, strict=True):
        if order * WAVE_NODES <= nodes:
            line += np.cos(order * angle + phase) / order
    return line


def _beyond(exponent: float, seed: int, amplitude_m: float) -> WaveLaw:
    """Return the law of the waves beyond a deviation whose order n has the amplitude over n."""
    last = FORM_ORDERS[-1]
    return WaveLaw(
        amplitude_m=amplitude_m * last ** (exponent - 1),
        exponent=exponent,
        seed=(seed, _BEYOND_SEED),
        first=last + 1,
    )


def _measured_heights(waves: Sequence[tuple[int, float, float]], nodes: int) -> Array:
    """Return the heights [m] of measured waves; waves of less than two nodes are left out."""
    spectrum = np.zeros(nodes // 2 + 1, dtype=complex)
    for order, amplitude_m, phase in waves:
        if 2 * order < nodes:
            spectrum[order] += amplitude_m * np.exp(1j * phase) * nodes / 2
    return np.asarray(np.fft.irfft(spectrum, nodes))


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
