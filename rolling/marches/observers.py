"""Observers of a march: series, recovery events, pressure maps and a film of one stretch.

An observer is called with each state and the energies of the step that led to it. Its `arrays` are
plain arrays by name.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array, short_repr
from rolling.contact.recovery import EventTable, StepEnergy
from rolling.contact.state import ContactState, RollingContact, Window
from rolling.contact.subcells import cell_means

STEP_SERIES = ("release_energy", "loading_energy", "energy_defect", "step_time")
MOVING_SERIES = STEP_SERIES[:3]  # of a march under the moving load
STATE_SERIES = (
    *("approach", "contact_area", "plastic_area", "max_pressure", "max_deflection"),
    *("stored_energy", "residual", "iterations", "convolutions"),
)
EVENT_COLUMNS = ("node", "first", "last", "energy", "peak")
PLACES = ("position", "distance", "along", "across", "cell")  # of a pressure map
MAPS = 120  # maximum number of pressure maps of a run: the eye follows about as many in ten seconds
MAP_CELLS = 96  # maximum number of cells along a side of a map
FILM_CELLS = 64  # maximum number of cells across the contact in a film
FILM_MARGIN = 4  # cells around the contacts of a film


@dataclass(frozen=True)
class Snapshot:
    """Pressure [Pa] and deflection [m] in the window at one position.

    distance : float, m. Distance of the sphere along the track.
    along, across : float, m. Plate coordinates of the window's first node.
    """

    __repr__ = short_repr

    distance: float
    along: float
    across: float
    pressure: Array
    deflection: Array


@dataclass(frozen=True)
class PressureMap:
    """Mean pressure of cells [Pa] on the loaded part of the plate at one position, for the eye.

    position : int. Number of the position.
    distance : float, m. Distance of the sphere along the track.
    along, across : float, m. Plate coordinates of the first cell's corner.
    cell : float, m. Side of a square cell. It spans several nodes where the contact is wide.
    """

    __repr__ = short_repr

    position: int
    distance: float
    along: float
    across: float
    cell: float
    pressure: NDArray[np.float32]


@dataclass(frozen=True)
class SlowMotion:
    """Maps on a part of the plate that stays in place while the sphere passes over it.

    first, stride : int. Position of the first map, and positions from one map to the next.
    along, across : float, m. Plate coordinates of the corner of the first cell.
    cell : float, m. Side of a square cell.
    pressure_unit, release_unit : float, Pa and J. Units of the maps.
    pressure : (maps, along, across) array of bytes. Mean pressure of cells.
    release : (maps, along, across) array of 16-bit integers. Energy that each cell has released
        since the map before.
    """

    __repr__ = short_repr

    first: int
    stride: int
    along: float
    across: float
    cell: float
    pressure_unit: float
    release_unit: float
    pressure: NDArray[np.uint8]
    release: NDArray[np.uint16]

    @property
    def positions(self) -> NDArray[np.int64]:
        """Position of each map."""
        maps = np.arange(len(self.pressure), dtype=np.int64)
        return np.asarray(self.first + self.stride * maps)

    @classmethod
    def none(cls) -> SlowMotion:
        """Return a slow motion without a map, of a stretch that could not be solved again."""
        empty = np.zeros((0, 0, 0))
        maps = empty.astype(np.uint8), empty.astype(np.uint16)
        return cls(0, 1, 0.0, 0.0, 1.0, 1.0, 1.0, *maps)


# ---- series and events


class Series:
    """Observer of the series of steps and states; only the first piece holds position 0."""

    def __init__(self, first: int) -> None:
        self._first = first
        self._steps: list[tuple[float, ...]] = []
        self._states: list[tuple[float, ...]] = []
        self._began = time.perf_counter()

    def __call__(self, state: ContactState, energy: StepEnergy | None) -> None:
        """Add the energies [J] and the time [s] of a step, and the scalars of a state."""
        k = state.position
        if k > self._first:
            now = time.perf_counter()
            energies = (energy.release, energy.loading, energy.defect) if energy else (np.nan,) * 3
            self._steps.append((*energies, now - self._began))
            self._began = now
        if k > self._first or k == 0:
            self._states.append(tuple(getattr(state, name) for name in STATE_SERIES))

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the series by name in SI units."""
        return _columns(STEP_SERIES, self._steps) | _columns(STATE_SERIES, self._states)


def _columns(names: tuple[str, ...], rows: list[tuple[float, ...]]) -> dict[str, Array]:
    """Return the columns of a table of rows by name."""
    table = np.array(rows, dtype=np.float64).reshape(len(rows), len(names))
    return dict(zip(names, table.T.copy(), strict=True))


class Events:
    """Observer of recovery events."""

    def __init__(self, contact: RollingContact) -> None:
        self._table, self._subcells = EventTable(contact.cell_shape), contact.subcells

    def __call__(self, state: ContactState, energy: StepEnergy | None) -> None:
        """Add the releases of a step."""
        if energy is not None:
            self._table.add(state.position - 1, energy, self._subcells)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the columns of the table of events, as `event_COLUMN`."""
        return {f"event_{name}": column for name, column in self._table.columns().items()}


# ---- maps and snapshot


class Maps:
    """Observer of the pressure maps of a piece, and of the snapshot at the end of the first."""

    def __init__(self, contact: RollingContact, first: int, last: int, track_steps: int) -> None:
        self._contact = contact
        self._snapshot_at = last if first == 0 else -1
        mapped = np.unique(np.arange(MAPS) * track_steps // MAPS)  # evenly along the track
        self._positions = set(mapped[(mapped > first) | (mapped == 0)].tolist())
        self._maps: list[PressureMap] = []
        self._snapshot: dict[str, NDArray[Any]] = {}

    def __call__(self, state: ContactState, energy: StepEnergy | None) -> None:
        """Keep the pressure at the mapped positions."""
        if state.position in self._positions:
            self._maps.append(_pressure_map(state, self._contact))
        if state.position == self._snapshot_at:
            self._snapshot = _snapshot(state, self._contact)

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return places and pressures of the maps, and the snapshot."""
        places = [[getattr(m, name) for name in PLACES] for m in self._maps]
        pressures = {f"map_{m.position}": m.pressure for m in self._maps}
        table = np.array(places).reshape(-1, len(PLACES))
        return self._snapshot | {"map_places": table} | pressures


def _pressure_map(state: ContactState, contact: RollingContact) -> PressureMap:
    """Return the pressure map of a state, with enough nodes per cell to keep the map small."""
    r = contact.subcells
    spacing, window = contact.cell_spacing, state.window.cells(r)
    loaded = state.loaded.whole(r).cells(r)
    nodes = -(-max(loaded.rows, loaded.columns) // MAP_CELLS)
    # All cells are whole, so the last row and column reach over unloaded nodes.
    rows, columns = (-(-count // nodes) for count in (loaded.rows, loaded.columns))
    pressure = np.zeros((rows * nodes, columns * nodes))
    pressure[: loaded.rows, : loaded.columns] = window.moved(cell_means(state.pressure, r), loaded)
    means = pressure.reshape(rows, nodes, columns, nodes).mean(axis=(1, 3))
    corner = (loaded.row - 0.5) * spacing, (loaded.column - 0.5) * spacing
    distance = contact.position(state.position)
    return PressureMap(state.position, distance, *corner, nodes * spacing, means.astype(np.float32))


def _snapshot(state: ContactState, contact: RollingContact) -> dict[str, NDArray[Any]]:
    """Return place [m], pressure [Pa] and deflection [m] of the cells of a state."""
    window, spacing = state.window.cells(contact.subcells), contact.cell_spacing
    place = contact.position(state.position), window.row * spacing, window.column * spacing
    return {
        "snapshot_place": np.array(place),
        "snapshot_pressure": cell_means(state.pressure, contact.subcells),
        "snapshot_deflection": cell_means(state.deflection, contact.subcells),
    }


# ---- film


class Film:
    """Observer of maps of pressure and release at every `stride` positions of a stretch."""

    def __init__(self, contact: RollingContact, first: int, stride: int) -> None:
        self._contact, self._first, self._stride = contact, first, stride
        self._states: list[ContactState] = []
        self._energies: list[StepEnergy] = []
        self._shots: list[tuple[Window, Array, Array]] = []

    def __call__(self, state: ContactState, energy: StepEnergy | None) -> None:
        """Keep the pressure [Pa] of a position, and the release [J] since the shot before."""
        if energy is not None:
            self._energies.append(energy)
        self._states.append(state)
        if (state.position - self._first) % self._stride == 0:
            self._shots.append(self._shot())
            self._states, self._energies = [state], []

    def _shot(self) -> tuple[Window, Array, Array]:
        """Return a window of cells with pressure [Pa] and release [J] since the last shot."""
        r, last = self._contact.subcells, self._states[-1]
        window = Window.around([state.loaded.whole(r).cells(r) for state in self._states])
        pressure = last.window.cells(r).moved(cell_means(last.pressure, r), window)
        release = np.zeros_like(pressure)
        for energy in self._energies:
            cells = cell_means(np.maximum(energy.node_work, 0.0), r) * r**2
            release += energy.window.cells(r).moved(cells, window)
        return window, pressure, release

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the maps on a common part of the plate, with few enough cells."""
        windows = [window for window, _, _ in self._shots]
        whole = Window.around(windows)
        nodes = -(-max(max(window.rows, window.columns) for window in windows) // FILM_CELLS)
        sides = whole.rows, whole.columns
        rows, columns = (-(-count // nodes) + 2 * FILM_MARGIN for count in sides)
        border = FILM_MARGIN * nodes
        whole = Window(whole.row - border, whole.column - border, rows * nodes, columns * nodes)

        def sums(window: Window, values: Array) -> Array:
            blocks: Array = window.moved(values, whole).reshape(rows, nodes, columns, nodes)
            return np.asarray(blocks.sum(axis=(1, 3)))

        pressure = np.array([sums(window, values) for window, values, _ in self._shots]) / nodes**2
        release = np.array([sums(window, values) for window, _, values in self._shots])
        small, pressure_unit = _packed(pressure, np.uint8)
        lit, release_unit = _packed(release, np.uint16)
        spacing = self._contact.cell_spacing
        place = (whole.row - 0.5) * spacing, (whole.column - 0.5) * spacing, nodes * spacing
        return {
            "film_pressure": small,
            "film_release": lit,
            "film_place": np.array([*place, pressure_unit, release_unit]),
        }


def _packed(values: Array, kind: type[np.unsignedinteger]) -> tuple[NDArray[Any], float]:
    """Return values as whole numbers of a unit, and the unit: the maximum over the last number."""
    most = np.iinfo(kind).max
    unit = float(np.max(values, initial=0.0)) / most or 1.0
    return np.rint(values / unit).astype(kind), unit


Observer = Series | Events | Maps | Film
