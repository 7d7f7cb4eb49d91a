"""The stretch of a run that is marched again for its slow motion, and its march.

The stretch lies around the loudest event: the place where the release power, averaged over 20 um,
is largest; for runs that are heard by their vibration, where a contact force departs most from the
load. Every state of the stretch is solved again from a cold start under the load of the scene, at a
few percent of the run's cost at most.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from rolling._typing import Array
from rolling.contact.march import march
from rolling.contact.of_scene import rolling_contact
from rolling.contact.recovery import StepEnergy, step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact, Window
from rolling.contact.subcells import cell_means, half_space_of
from rolling.dynamics import of_scene
from rolling.scene.scene import Scene
from rolling.simulation import force_law, pool, simulate
from rolling.simulation.result import Result
from rolling.simulation.slow_motion import SlowMotion

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


@dataclass(frozen=True)
class Event:
    """The place that a slow motion shows.

    position : int. Position of its middle.
    speed : float, m/s. Speed of the sphere there.
    """

    position: int
    speed: float


def stretch(scenes: Sequence[Scene], result: Result) -> Stretch | None:
    """Choose the stretch around the loudest event of a complete result.

    Parameters
    ----------
    scenes : sequence of Scene. The runs that share the result, scenes without a sweep.
    result : Result. Their result, with the force law where they have dynamics.

    Returns
    -------
    stretch : Stretch or None
        None for a smooth surface, which has no events, for a run that is too short, and for runs
        whose loudest events lie at different places.
    """
    if scenes[0].surface.kind == "smooth" or not result.complete:
        return None
    event = event_of(scenes, result)
    if event is None:
        return None
    step = result.step
    wanted = SECONDS * event.speed / step
    stride = max(1, math.ceil(FROM / step - 1e-9))
    stride = max(stride, min(math.floor(TO / step + 1e-9), math.ceil(wanted / MOST - 1e-9)))
    affordable = SHARE * result.solved_steps - COLD_STEPS
    maps = min(MOST, int(min(wanted, affordable) // stride))
    if maps < FEWEST:
        return None
    length = (maps - 1) * stride
    first = min(max(0, event.position - length // 2), result.solved_steps - length)
    return Stretch(first, first + length, stride)


def event_of(scenes: Sequence[Scene], result: Result) -> Event | None:
    """Return the loudest event of the runs that share a result; None without a common one."""
    vibrating = [s for s in scenes if s.dynamics is not None and s.sound.source == "vibration"]
    if vibrating:
        try:
            events = [_largest_departure(scene, result) for scene in vibrating]
        except ContactError:
            return None
        return max(events, key=lambda pair: pair[0])[1]
    if len(scenes) > 1 and not all(s.motion.is_constant(s.duration) for s in scenes):
        return None
    return max((_loudest_release(scene, result) for scene in scenes), key=lambda each: each.speed)


def _largest_departure(scene: Scene, result: Result) -> tuple[float, Event]:
    """Return the largest departure of the contact force over the load in a lap, and its place."""
    loads = force_law.loads_of(scene, result, of_scene.extremes).marched
    motion = of_scene.motion(scene, force_law.force_law(scene, result, loads))
    departure = np.abs(motion.force_n / scene.load - 1.0)
    departure[motion.position_m > result.solved_steps * result.step] = 0.0
    largest = int(np.argmax(departure))
    speed = float(scene.motion.speed(motion.time_s[largest]))
    position = round(float(motion.position_m[largest]) / result.step)
    return float(departure[largest]), Event(position, speed)


def _loudest_release(scene: Scene, result: Result) -> Event:
    """Return the place of the largest release power."""
    energy, step = result.series["release_energy"], result.step
    middle = np.minimum((np.arange(len(energy)) + 0.5) * step, scene.motion.final_distance)
    speed = np.asarray(scene.motion.speed(scene.motion.time(middle)), dtype=float)
    event = loudest(energy * speed, max(1, round(AVERAGED / step)))
    return Event(event, float(speed[event]))


def loudest(power: Array, width: int) -> int:
    """Return the middle of the stretch of so many values with the largest mean."""
    sums = np.cumsum(np.concatenate([[0.0], power]))
    width = min(width, len(power))
    return int(np.argmax(sums[width:] - sums[:-width])) + width // 2


def missing(scenes: Sequence[Scene], result: Result) -> bool:
    """Return whether the runs that share a result can have a slow motion and have none."""
    return result.slow_motion is None and stretch(scenes, result) is not None


def task(
    scenes: Sequence[Scene], result: Result, run: int, step_seconds: float
) -> pool.Task | None:
    """Return the march for the slow motion of a result as a task; None if nothing is missing.

    Parameters
    ----------
    scenes : sequence of Scene. The runs that share the result, scenes without a sweep.
    result : Result. Their result.
    run : int. Number of the first of them.
    step_seconds : float, s. Expected time of a step of the run.
    """
    part = stretch(scenes, result) if result.slow_motion is None else None
    if part is None:
        return None
    arguments = (scenes[0], part, simulate.Order.of(result.identity, step_seconds))
    return pool.Task(run, march_stretch, arguments, (part.last - part.first) * step_seconds)


def march_stretch(
    scene: Scene,
    part: Stretch,
    order: simulate.Order,
    stopped: Callable[[], bool],
    progress: Callable[[float], object],
) -> SlowMotion:
    """March a stretch and keep its maps; without a map where a contact cannot be solved.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    part : Stretch. The stretch.
    order : Order. Progress of a step, and the surface.
    stopped, progress : callable. As in `simulate.simulate_piece`.

    Raises
    ------
    Interrupted : `stopped` returned true.
    """
    if order.surface_sha256 and simulate.surface_fault(scene, order.surface_sha256):
        return SlowMotion.none()
    contact = rolling_contact(scene)
    left_end = scene.recovery.rule == "left_end"
    try:
        shots = _shots(contact, part, left_end, stopped, lambda: progress(order.step_cost))
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
    window = Window.around([state.loaded.whole(subcells).cells(subcells) for state in states])
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
    whole = Window.around([shot.window for shot in shots])
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
