"""The march of a scene: its track is cut into pieces, which any number of processes solve.

A piece depends on the scene alone and starts cold. The numbers are therefore the same for any
number of workers, and the solved pieces of a run that stopped are not solved again.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rolling._typing import Array
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import march
from rolling.contact.recovery import EventTable, step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact
from rolling.contact.subcells import cell_means, half_space_of
from rolling.scene.identity import Identity, other_surface
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.simulation import pool
from rolling.surface.contact_of_scene import rolling_contact
from rolling.surface.scene_surface import scene_surface

PIECE_STEPS = (
    # a cold start costs about three steps: 1.5 % of a piece
    200
)
MAPS = 120  # pressure maps of a run: about as many as the eye follows in ten seconds
MAP_CELLS = 96  # maximum cells along a side of a map
STEP_SERIES = ("release_energy", "loading_energy", "energy_defect", "step_time")
STATE_SERIES = (
    "approach",
    "contact_area",
    "plastic_area",
    "max_pressure",
    "max_deflection",
    "stored_energy",
    "residual",
    "iterations",
    "convolutions",
)


@dataclass(frozen=True)
class Snapshot:
    """The pressure [Pa] and deflection [m] at one position, with the plate coordinates [m] of the
    window's first node.
    """

    distance: float
    along: float
    across: float
    pressure: Array
    deflection: Array


@dataclass(frozen=True)
class PressureMap:
    """The pressure [Pa] on the loaded part of the plate at one position, for the eye.

    distance : distance of the sphere along the track [m].
    along, across : plate coordinates of the first cell's corner [m].
    cell : side of a square cell [m] of one node, or of several where the contact is wide.
    pressure : mean pressure of each cell [Pa].
    """

    position: int
    distance: float
    along: float
    across: float
    cell: float
    pressure: NDArray[np.float32]


@dataclass(frozen=True)
class Piece:
    """The series of the steps first ..

    last - 1 and of the states first + 1 .. last; the first piece has state 0 as well.
    """

    first: int
    last: int
    steps: dict[str, Array]
    states: dict[str, Array]
    events: dict[str, NDArray[Any]] | None
    snapshot: Snapshot | None
    maps: list[PressureMap]


def identity_of(scene: Scene) -> Identity:
    """Identify a scene without a sweep: its physics and the heights as their file holds them now.

    Raises
    ------
    SceneError : heights that cannot be read.
    """
    return Identity.of(scene, scene_surface(scene).sha256 if scene.height_path else None)


def surface_fault(scene: Scene, solved: str | None) -> str | None:
    """Return the reason why the surface of a scene has not the digest `solved`, None where it has."""
    if scene.height_path is None:
        return None
    try:
        return other_surface(solved, scene_surface(scene).sha256, scene.height_path)
    except SceneError as error:
        return f"the surface that was solved is gone: {error}"


@lru_cache(maxsize=4)
def _half_space(spacing: float, contact_modulus: float, subcells: int) -> HalfSpace:
    return half_space_of(spacing, contact_modulus, subcells)


def pieces(steps: int) -> list[tuple[int, int]]:
    """Return first and last position of each piece of a track of that many steps."""
    return [(first, min(first + PIECE_STEPS, steps)) for first in range(0, steps, PIECE_STEPS)]


def mapped_positions(steps: int) -> NDArray[np.int64]:
    """Return the positions whose pressure is kept, evenly along a track of that many steps; all of
    a short track.
    """
    return np.unique(np.arange(MAPS) * steps // MAPS)


def pressure_map(state: ContactState, contact: RollingContact) -> PressureMap:
    """Return the pressure map of a state, with as many nodes per cell as keep it small."""
    r = contact.subcells
    spacing, window = contact.cell_spacing, state.window.cells(r)
    loaded = state.loaded.whole(r).cells(r)
    across = max(loaded.rows, loaded.columns)
    nodes = -(-across // MAP_CELLS)
    # Whole cells: the last ones reach over nodes that bear nothing.
    rows, columns = (-(-count // nodes) for count in (loaded.rows, loaded.columns))
    pressure = np.zeros((rows * nodes, columns * nodes))
    pressure[: loaded.rows, : loaded.columns] = window.moved(cell_means(state.pressure, r), loaded)
    means = pressure.reshape(rows, nodes, columns, nodes).mean(axis=(1, 3))
    corner = (loaded.row - 0.5) * spacing, (loaded.column - 0.5) * spacing
    distance = contact.position(state.position)
    return PressureMap(state.position, distance, *corner, nodes * spacing, means.astype(np.float32))


def _snapshot(state: ContactState, contact: RollingContact) -> Snapshot:
    """Return pressure and deflection of a state, means of cells, with the place of its window."""
    window = state.window.cells(contact.subcells)
    row, column = window.row * contact.cell_spacing, window.column * contact.cell_spacing
    pressure, deflection = (
        cell_means(values, contact.subcells) for values in (state.pressure, state.deflection)
    )
    return Snapshot(contact.position(state.position), row, column, pressure, deflection)


def simulate_piece(
    scene: Scene,
    first: int,
    last: int,
    stopped: Callable[[], bool] = lambda: False,
    progress: Callable[[float], object] = lambda steps: None,
    contact: RollingContact | None = None,
    mapped: bool = True,
) -> Piece:
    """March one piece of a scene.

    Parameters
    ----------
    first, last : int. Positions between which the piece lies.
    stopped : returns whether the march has to stop.
    progress : gets the number of solved steps, step by step.
    contact : RollingContact. The same contact made otherwise. Default: made from the scene.
    mapped : bool. Whether pressure maps are kept. Default: true.

    Raises
    ------
    ContactError : as `march` does.
    Interrupted : `stopped` said so.
    """
    contact = contact or rolling_contact(scene)
    half_space = _half_space(contact.spacing, contact.contact_modulus, contact.subcells)
    left_end = scene.recovery is not None and scene.recovery.rule == "left_end"
    table = (
        EventTable(contact.cell_shape)
        if scene.recovery is not None and scene.recovery.events
        else None
    )
    steps = {name: np.empty(last - first) for name in STEP_SERIES}
    states = {name: np.empty(last - first + (first == 0)) for name in STATE_SERIES}
    snapshot = None
    kept_positions = set(mapped_positions(scene.track.solved_steps).tolist()) if mapped else set()
    maps: list[PressureMap] = []
    old: ContactState | None = None
    began = time.perf_counter()
    for state in march(contact, first, last, half_space):
        if stopped():
            raise pool.Interrupted
        k = state.position
        if old is not None:
            energy = step_energy(old, state, half_space, left_end)
            if table is not None:
                table.add(k - 1, energy, contact.subcells)
            now = time.perf_counter()
            values = (energy.release, energy.loading, energy.defect, now - began)
            for name, value in zip(STEP_SERIES, values, strict=True):
                steps[name][k - 1 - first] = value
            began = now
            progress(1)
        if k > first or first == 0:
            for name in STATE_SERIES:
                states[name][k - first - (first > 0)] = getattr(state, name)
            if k in kept_positions:
                maps.append(pressure_map(state, contact))
        if k == last and first == 0:
            snapshot = _snapshot(state, contact)
        old = state
    return Piece(first, last, steps, states, table.columns() if table else None, snapshot, maps)


@dataclass(frozen=True)
class Order:
    """The way in which a run is marched.

    step_cost : progress of a step. mapped : whether pressure maps are kept.
    surface_sha256 : digest of the height file, None for a made surface.
    """

    step_cost: float = 1.0
    mapped: bool = True
    surface_sha256: str | None = None


def _ordered_piece(
    scene: Scene,
    first: int,
    last: int,
    order: Order,
    stopped: Callable[[], bool],
    progress: Callable[[float], object],
) -> Piece:
    """March one piece of a scene on the surface that the order names.

    Raises
    ------
    ContactError : as `march` does, or the heights were replaced or removed: a run has one surface.
    Interrupted : `stopped` said so.
    """
    try:
        z = scene_surface(scene)
        fault = other_surface(order.surface_sha256, z.sha256, scene.height_path)
        if fault:
            raise ContactError(fault)
        contact = rolling_contact(scene, z.heights)
        return simulate_piece(
            scene,
            first,
            last,
            stopped,
            lambda steps: progress(steps * order.step_cost),
            contact,
            order.mapped,
        )
    except SceneError as error:
        raise ContactError(f"the surface that was solved is gone: {error}") from error


def march_pieces(
    scenes: Sequence[Scene],
    todo: Sequence[tuple[int, int, int]],
    workers: int,
    finished: Callable[[int, Piece], None],
    progress: Callable[[float], object] = lambda cost: None,
    orders: Sequence[Order] | None = None,
    begun: Callable[[int], object] = lambda run: None,
) -> pool.Outcome:
    """March pieces of scenes on `workers` processes.

    A scene that fails does not stop the others. The first Ctrl-C or SIGTERM stops all after the
    step at hand.

    Parameters
    ----------
    todo : The pieces: number of the scene, first and last position.
    finished : Gets the number of the scene and each piece as it is done.
    progress : Gets the cost of solved steps, step by step or piece by piece.
    orders : One for each scene.
    begun : Gets the number of a scene as each of its pieces is handed out.
    """
    orders = orders or [Order(surface_sha256=identity_of(scene).heights_sha256) for scene in scenes]
    tasks = [
        pool.Task(
            run,
            _ordered_piece,
            (scenes[run], first, last, orders[run]),
            (last - first) * orders[run].step_cost,
        )
        for run, first, last in todo
    ]
    return pool.work(tasks, workers, finished, progress, begun)


def missing(steps: int, release: Array) -> Iterator[tuple[int, int]]:
    """Yield the pieces of a track whose release is not known yet (NaN)."""
    for first, last in pieces(steps):
        if np.isnan(release[first:last]).any():
            yield first, last
