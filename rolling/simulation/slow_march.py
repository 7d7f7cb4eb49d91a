"""The stretch of a run that is marched again for its slow motion, and its march.

The stretch lies around the loudest event: the place where the release power, averaged over 20 um,
is largest. Every state of the stretch is solved again from a cold start, at a few percent of the
run's cost at most.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rolling._typing import Array
from rolling.contact.march import march
from rolling.contact.recovery import StepEnergy, step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact
from rolling.contact.subcells import cell_means, half_space_of
from rolling.contact.window import Window
from rolling.scene.scene import Scene
from rolling.simulation import pool, simulate
from rolling.simulation.result import Result
from rolling.simulation.slow_motion import SlowMotion
from rolling.surface.contact_of_scene import rolling_contact

SECONDS = 3e-3  # [s] of rolling that are shown
SHARE = 0.05  # maximum share of the steps of the run
COLD_STEPS = 3  # cost of a cold start in steps
AVERAGED = 20e-6  # [m] over which the release is averaged to find the event
FROM, TO = 2e-6, 4e-6  # [m] from one map to the next, unless a step is longer
FEWEST, MOST = 30, 150  # maps
CELLS = 64  # maximum number of cells across the contact
MARGIN = 4  # cells around the contacts


@dataclass(frozen=True)
class Stretch:
    """Positions that are marched again.

    first, last : int. First and last position.
    stride : int. Positions from one map to the next.
    """

    first: int
    last: int
    stride: int


def stretch(scene: Scene, result: Result) -> Stretch | None:
    """Choose the stretch around the loudest event of a complete run.

    Returns
    -------
    stretch : Stretch or None
        None for a smooth surface, which has no events, and for a run that is too short.
    """
    if scene.surface.kind == "smooth" or not result.complete:
        return None
    energy, step = result.series["release_energy"], result.step
    middle = np.minimum((np.arange(len(energy)) + 0.5) * step, scene.motion.final_distance)
    speed = np.asarray(scene.motion.speed(scene.motion.time(middle)), dtype=float)
    event = loudest(energy * speed, max(1, round(AVERAGED / step)))
    wanted = SECONDS * speed[event] / step
    stride = max(1, math.ceil(FROM / step - 1e-9))
    stride = max(stride, min(math.floor(TO / step + 1e-9), math.ceil(wanted / MOST - 1e-9)))
    affordable = SHARE * result.solved_steps - COLD_STEPS
    maps = min(MOST, int(min(wanted, affordable) // stride))
    if maps < FEWEST:
        return None
    length = (maps - 1) * stride
    first = min(max(0, event - length // 2), result.solved_steps - length)
    return Stretch(first, first + length, stride)


def loudest(power: Array, width: int) -> int:
    """Return the middle of the stretch of so many values with the largest mean."""
    sums = np.cumsum(np.concatenate([[0.0], power]))
    width = min(width, len(power))
    return int(np.argmax(sums[width:] - sums[:-width])) + width // 2


def missing(scene: Scene, result: Result) -> bool:
    """Return whether a run can have a slow motion and has none."""
    return result.slow_motion is None and stretch(scene, result) is not None


def task(scene: Scene, result: Result, run: int, step_seconds: float) -> pool.Task | None:
    """Return the march for the slow motion of a run as a task; None if nothing is missing.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    result : Result. The result of the run.
    run : int. Number of the run.
    step_seconds : float, s. Expected time of a step of the run.
    """
    part = stretch(scene, result) if result.slow_motion is None else None
    if part is None:
        return None
    sha256 = result.identity.heights_sha256 if result.identity else None
    arguments = (scene, part, step_seconds, sha256)
    return pool.Task(run, march_stretch, arguments, (part.last - part.first) * step_seconds)


def march_stretch(
    scene: Scene,
    part: Stretch,
    step_cost: float,
    surface_sha256: str | None,
    stopped: Callable[[], bool],
    progress: Callable[[float], object],
) -> SlowMotion:
    """March a stretch and keep its maps; without a map where a contact cannot be solved.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    part : Stretch. The stretch.
    step_cost : float. Progress of a step.
    surface_sha256 : str. Digest of the height file; None for a generated surface.
    stopped, progress : callable. As in `simulate.simulate_piece`.

    Raises
    ------
    Interrupted : `stopped` returned true.
    """
    if surface_sha256 and simulate.surface_fault(scene, surface_sha256):
        return SlowMotion.none()
    contact = rolling_contact(scene)
    left_end = scene.recovery.rule == "left_end"
    try:
        shots = _shots(contact, part, left_end, stopped, lambda: progress(step_cost))
    except ContactError:
        return SlowMotion.none()
    return _assembled(contact, part, shots)


@dataclass(frozen=True)
class _Shot:
    """Pressure [Pa] and release [J] of the cells of a window at one position."""

    window: Window
    pressure: Array
    release: Array


def _shots(
    contact: RollingContact,
    part: Stretch,
    left_end: bool,
    stopped: Callable[[], bool],
    progress: Callable[[], object],
) -> list[_Shot]:
    """March the stretch, and keep a shot at every so many positions."""
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    shots: list[_Shot] = []
    works: list[StepEnergy] = []
    states: list[ContactState] = []
    for state in march(contact, part.first, part.last, half_space):
        if stopped():
            raise pool.Interrupted
        if states:
            works.append(step_energy(states[-1], state, half_space, left_end))
            progress()
        states.append(state)
        if (state.position - part.first) % part.stride == 0:
            shots.append(_shot(states, works, contact.subcells))
            states, works = [state], []
    return shots


def _shot(states: list[ContactState], works: list[StepEnergy], subcells: int) -> _Shot:
    """Return the last state, and the releases of all steps up to it."""
    window = Window.around(state.loaded.whole(subcells).cells(subcells) for state in states)
    last = states[-1]
    pressure = last.window.cells(subcells).moved(cell_means(last.pressure, subcells), window)
    release = np.zeros_like(pressure)
    for work in works:
        released = np.maximum(work.node_work, 0.0)
        cells = cell_means(released, subcells) * subcells**2
        release += work.window.cells(subcells).moved(cells, window)
    return _Shot(window, pressure, release)


def _assembled(contact: RollingContact, part: Stretch, shots: list[_Shot]) -> SlowMotion:
    """Put the shots on a common part of the plate, with few enough cells."""
    whole = Window.around(shot.window for shot in shots)
    nodes = -(-max(max(shot.window.rows, shot.window.columns) for shot in shots) // CELLS)
    rows, columns = (-(-count // nodes) for count in (whole.rows, whole.columns))
    border = MARGIN * nodes
    rows, columns = rows + 2 * MARGIN, columns + 2 * MARGIN
    whole = Window(whole.row - border, whole.column - border, rows * nodes, columns * nodes)

    def sums(window: Window, values: Array) -> Array:
        blocks: Array = window.moved(values, whole).reshape(rows, nodes, columns, nodes)
        return np.asarray(blocks.sum(axis=(1, 3)))

    pressure = np.array([sums(shot.window, shot.pressure) for shot in shots]) / nodes**2
    release = np.array([sums(shot.window, shot.release) for shot in shots])
    spacing = contact.cell_spacing
    corner = (whole.row - 0.5) * spacing, (whole.column - 0.5) * spacing
    return SlowMotion.of(part.first, part.stride, corner, nodes * spacing, pressure, release)
