"""The march of a scene: its track is cut into pieces, which any number of processes solve.

A piece depends on the scene alone and begins with a cold start. The numbers are therefore the same
for any number of workers, and a resumed run does not solve its finished pieces again.
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
from rolling.contact.of_scene import rolling_contact
from rolling.contact.recovery import EventTable, step_energy
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact
from rolling.contact.subcells import cell_means, half_space_of
from rolling.scene.identity import Identity, other_surface
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.simulation import pool
from rolling.surface.scene_surface import scene_surface

# Steps of a piece. A cold start costs four to eight steps, which is 2 to 4 % of a piece.
PIECE_STEPS = 200
MAPS = 120  # maximum number of pressure maps of a run: the eye follows about as many in ten seconds
MAP_CELLS = 96  # maximum number of cells along a side of a map
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
    """The pressure and deflection in the window at one position.

    distance : float, m. Distance of the sphere along the track.
    along, across : float, m. Plate coordinates of the window's first node.
    pressure : array, Pa.
    deflection : array, m.
    """

    distance: float
    along: float
    across: float
    pressure: Array
    deflection: Array


@dataclass(frozen=True)
class PressureMap:
    """The pressure on the loaded part of the plate at one position, for the eye.

    position : int. Number of the position.
    distance : float, m. Distance of the sphere along the track.
    along, across : float, m. Plate coordinates of the first cell's corner.
    cell : float, m. Side of a square cell. It spans several nodes where the contact is wide.
    pressure : array, Pa. Mean pressure of each cell.
    """

    position: int
    distance: float
    along: float
    across: float
    cell: float
    pressure: NDArray[np.float32]


@dataclass(frozen=True)
class Piece:
    """The series of the steps `first` to `last - 1` and of the states `first + 1` to `last`.

    The first piece also holds state 0.
    """

    first: int
    last: int
    steps: dict[str, Array]
    states: dict[str, Array]
    events: dict[str, NDArray[Any]] | None
    snapshot: Snapshot | None
    maps: list[PressureMap]


def identity_of(scene: Scene) -> Identity:
    """Identify a scene without a sweep by its physics and the current heights of its file.

    Raises
    ------
    SceneError : the heights cannot be read.
    """
    return Identity.of(scene, scene_surface(scene).sha256 if scene.height_path else None)


def surface_fault(scene: Scene, solved: str | None) -> str | None:
    """Return the reason why the surface of a scene lacks the digest `solved`, or None."""
    if scene.height_path is None:
        return None
    try:
        return other_surface(solved, scene_surface(scene).sha256, scene.height_path)
    except SceneError as error:
        return f"the surface that was solved is gone: {error}"


def refuse_other_surface(scene: Scene, solved: str | None) -> None:
    """Refuse a scene whose surface lacks the digest `solved`; None: it is not compared.

    Raises
    ------
    ContactError : the heights were replaced or removed.
    """
    if solved and (fault := surface_fault(scene, solved)):
        raise ContactError(fault)


@lru_cache(maxsize=4)
def half_space(spacing: float, contact_modulus: float, subcells: int) -> HalfSpace:
    """Return the half-space of a spacing [m], a contact modulus [Pa] and sub-cells, made once."""
    return half_space_of(spacing, contact_modulus, subcells)


def pieces(steps: int) -> list[tuple[int, int]]:
    """Return the first and last position of each piece of a track with `steps` steps."""
    return [(first, min(first + PIECE_STEPS, steps)) for first in range(0, steps, PIECE_STEPS)]


def mapped_positions(steps: int) -> NDArray[np.int64]:
    """Return the positions whose pressure is kept, evenly spaced along a track with `steps` steps.

    All positions of a short track are kept.
    """
    return np.unique(np.arange(MAPS) * steps // MAPS)


def pressure_map(state: ContactState, contact: RollingContact) -> PressureMap:
    """Return the pressure map of a state, with enough nodes per cell to keep the map small."""
    r = contact.subcells
    spacing, window = contact.cell_spacing, state.window.cells(r)
    loaded = state.loaded.whole(r).cells(r)
    across = max(loaded.rows, loaded.columns)
    nodes = -(-across // MAP_CELLS)
    # All cells are whole, so the last row and column reach over unloaded nodes.
    rows, columns = (-(-count // nodes) for count in (loaded.rows, loaded.columns))
    pressure = np.zeros((rows * nodes, columns * nodes))
    pressure[: loaded.rows, : loaded.columns] = window.moved(cell_means(state.pressure, r), loaded)
    means = pressure.reshape(rows, nodes, columns, nodes).mean(axis=(1, 3))
    corner = (loaded.row - 0.5) * spacing, (loaded.column - 0.5) * spacing
    distance = contact.position(state.position)
    return PressureMap(state.position, distance, *corner, nodes * spacing, means.astype(np.float32))


def _snapshot(state: ContactState, contact: RollingContact) -> Snapshot:
    """Return cell means of pressure and deflection of a state with the corner of its window."""
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
    scene : Scene. A scene without a sweep.
    first, last : int. Positions between which the piece lies.
    stopped : callable. It returns whether the march has to stop.
    progress : callable. It receives the number of solved steps, step by step.
    contact : RollingContact. The same contact made otherwise. Default: made from the scene.
    mapped : bool. Whether pressure maps are kept. Default: true.

    Raises
    ------
    ContactError : as in `march`.
    Interrupted : `stopped` returned true.
    """
    contact = contact or rolling_contact(scene)
    elastic = half_space(contact.spacing, contact.contact_modulus, contact.subcells)
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
    for state in march(contact, first, last, elastic):
        if stopped():
            raise pool.Interrupted
        k = state.position
        if old is not None:
            energy = step_energy(old, state, elastic, left_end)
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
    """The settings for the march of a run.

    step_cost : float. Progress of a step.
    mapped : bool. Whether pressure maps are kept.
    surface_sha256 : str. Digest of the height file; None for a surface that is not compared.
    """

    step_cost: float = 1.0
    mapped: bool = True
    surface_sha256: str | None = None

    @classmethod
    def of(cls, identity: Identity | None, step_cost: float, mapped: bool = False) -> Order:
        """Return the settings for a march on the surface that a result was solved on."""
        return cls(step_cost, mapped, identity.heights_sha256 if identity else None)


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
    ContactError : as in `march`, or the heights were replaced or removed. A run has one surface.
    Interrupted : `stopped` returned true.
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
    workers: pool.Workers,
    finished: Callable[[int, Any], Sequence[pool.Task] | None],
    progress: Callable[[float], object] = lambda cost: None,
    orders: Sequence[Order] | None = None,
    begun: Callable[[int], object] = lambda run: None,
    others: Sequence[pool.Task] = (),
) -> pool.Outcome:
    """March pieces of scenes on `workers` processes.

    A scene that fails does not stop the others. The first Ctrl-C or SIGTERM stops all scenes after
    the current step.

    Parameters
    ----------
    scenes : sequence of Scene.
    todo : sequence of tuples. Number of the scene, first and last position of each piece.
    workers : int or Cluster. Number of processes.
    finished : callable. It receives the number of the scene and each piece when the piece is done,
        and returns the tasks that follow from it, or None.
    progress : callable. It receives the cost of solved steps, step by step or piece by piece.
    orders : sequence of Order. One order per scene. Default: an order with the present surface.
    begun : callable. It receives the number of a scene when one of its pieces is handed out.
    others : sequence of Task. Tasks after the pieces, whose results `finished` receives as well.
        Default: none.
    """
    orders = orders or [Order(surface_sha256=identity_of(scene).heights_sha256) for scene in scenes]
    tasks = [*piece_tasks(scenes, todo, orders), *others]
    return pool.work(tasks, workers, finished, progress, begun)


def piece_tasks(
    scenes: Sequence[Scene], todo: Sequence[tuple[int, int, int]], orders: Sequence[Order]
) -> list[pool.Task]:
    """Return the pieces of scenes as tasks; `todo` has scene, first and last position of each."""
    return [
        pool.Task(
            run,
            _ordered_piece,
            (scenes[run], first, last, orders[run]),
            (last - first) * orders[run].step_cost,
        )
        for run, first, last in todo
    ]


def missing(steps: int, release: Array) -> Iterator[tuple[int, int]]:
    """Yield the pieces of a track whose release is not known yet (NaN)."""
    for first, last in pieces(steps):
        if np.isnan(release[first:last]).any():
            yield first, last
