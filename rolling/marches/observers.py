"""Observers of a march: series, recovery events, pressure maps and a film of one stretch.

An observer sees each state and the energies of the step that led to it. Its `arrays` are plain
arrays by name.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array, short_repr
from rolling.archive.definition import Arrays, in_group
from rolling.contact.processor_time import ProcessorTime
from rolling.contact.recovery import EventTable, StepEnergy
from rolling.contact.state import ContactState, RollingContact, Window
from rolling.contact.subcells import cell_means
from rolling.marches.march_variables import (
    EVENT_COLUMNS,
    EVENTS_GROUP,
    FILM_GROUP,
    MAPS_GROUP,
    SNAPSHOT_GROUP,
    STATE_SERIES,
    STEP_SERIES,
)

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
        return cls(
            first=0,
            stride=1,
            along=0.0,
            across=0.0,
            cell=1.0,
            pressure_unit=1.0,
            release_unit=1.0,
            pressure=np.zeros((0, 0, 0), np.uint8),
            release=np.zeros((0, 0, 0), np.uint16),
        )


# ---- series and events


class Series:
    """Observer of the series of steps and states; only the first piece holds position 0."""

    def __init__(self, first: int) -> None:
        self._first = first
        self._steps: list[tuple[float, ...]] = []
        self._states: list[tuple[float, ...]] = []
        self._began = ProcessorTime.now()

    def observe(self, state: ContactState, energy: StepEnergy | None) -> None:
        """Add the energies [J] and the processor time [s] of a step, and the scalars of a state."""
        is_first = state.position == self._first
        if not is_first:
            now = ProcessorTime.now()
            seconds = now.since(self._began).work_s
            self._began = now
            if energy is None:
                self._steps.append((math.nan, math.nan, math.nan, seconds))
            else:
                self._steps.append((energy.release, energy.loading, energy.defect, seconds))
        if not is_first or state.position == 0:
            self._states.append(tuple(getattr(state, name) for name in STATE_SERIES))

    def arrays(self) -> Arrays:
        """Return the series by name in SI units."""
        return _columns(STEP_SERIES, self._steps) | _columns(STATE_SERIES, self._states)


def _columns(names: tuple[str, ...], rows: list[tuple[float, ...]]) -> dict[str, Array]:
    """Return the columns of a table of rows by name."""
    table = np.array(rows, dtype=np.float64).reshape(len(rows), len(names))
    return dict(zip(names, table.T.copy(), strict=True))


class Events:
    """Observer of recovery events."""

    def __init__(self, contact: RollingContact) -> None:
        self._table = EventTable(contact.cell_shape)
        self._subcells = contact.subcells

    def observe(self, state: ContactState, energy: StepEnergy | None) -> None:
        """Add the releases of a step."""
        if energy is not None:
            self._table.add(state.position - 1, energy, self._subcells)

    def arrays(self) -> Arrays:
        """Return the columns of the table of events."""
        return in_group(EVENTS_GROUP, self._table.columns())


# ---- maps and snapshot


class Maps:
    """Observer of the pressure maps of a piece, and of the snapshot at the end of the first."""

    def __init__(self, contact: RollingContact, first: int, last: int, track_steps: int) -> None:
        self._contact = contact
        self._snapshot_at = last if first == 0 else -1
        mapped = np.unique(np.arange(MAPS) * track_steps // MAPS)  # evenly along the track
        self._positions = set(mapped[(mapped > first) | (mapped == 0)].tolist())
        self._maps: list[PressureMap] = []
        self._snapshot: Arrays = {}

    def observe(self, state: ContactState, energy: StepEnergy | None) -> None:
        """Keep the pressure at the mapped positions."""
        if state.position in self._positions:
            self._maps.append(_pressure_map(state, self._contact))
        if state.position == self._snapshot_at:
            self._snapshot = _snapshot(state, self._contact)

    def arrays(self) -> Arrays:
        """Return the maps and the snapshot."""
        return self._snapshot | in_group(MAPS_GROUP, maps_arrays(self._maps))


def maps_arrays(maps: Sequence[PressureMap]) -> Arrays:
    """Return maps [Pa], padded with NaN to a common shape, and their places [m]."""
    rows = np.array([shown.pressure.shape[0] for shown in maps], dtype=np.int64)
    columns = np.array([shown.pressure.shape[1] for shown in maps], dtype=np.int64)
    shape = (len(maps), int(rows.max(initial=0)), int(columns.max(initial=0)))
    padded = np.full(shape, np.nan, dtype=np.float32)
    for k, shown in enumerate(maps):
        padded[k, : rows[k], : columns[k]] = shown.pressure
    return {
        "position": np.array([shown.position for shown in maps], dtype=np.int64),
        "distance": np.array([shown.distance for shown in maps], dtype=np.float64),
        "along": np.array([shown.along for shown in maps], dtype=np.float64),
        "across": np.array([shown.across for shown in maps], dtype=np.float64),
        "cell": np.array([shown.cell for shown in maps], dtype=np.float64),
        "rows": rows,
        "columns": columns,
        "pressure": padded,
    }


def maps_of(arrays: Arrays) -> dict[int, PressureMap]:
    """Return maps by position from their arrays, without their padding."""
    maps = {}
    for k, position in enumerate(arrays["position"].tolist()):
        rows = arrays["rows"][k]
        columns = arrays["columns"][k]
        maps[position] = PressureMap(
            position=position,
            distance=float(arrays["distance"][k]),
            along=float(arrays["along"][k]),
            across=float(arrays["across"][k]),
            cell=float(arrays["cell"][k]),
            pressure=arrays["pressure"][k, :rows, :columns].copy(),
        )
    return maps


def events_of(arrays: Arrays) -> Arrays:
    """Return the table of recovery events from its arrays."""
    table = {name: arrays[name] for name in EVENT_COLUMNS}
    table["first"] = table["first"].astype(np.int64)
    table["last"] = table["last"].astype(np.int64)
    return table


def _pressure_map(state: ContactState, contact: RollingContact) -> PressureMap:
    """Return the pressure map of a state, with enough nodes per cell to keep the map small."""
    r = contact.subcells
    spacing = contact.cell_spacing
    window = state.window.cells(r)
    loaded = state.loaded.whole(r).cells(r)
    nodes = math.ceil(max(loaded.rows, loaded.columns) / MAP_CELLS)
    # All cells are whole, so the last row and column reach over unloaded nodes.
    rows = math.ceil(loaded.rows / nodes)
    columns = math.ceil(loaded.columns / nodes)
    pressure = np.zeros((rows * nodes, columns * nodes))
    pressure[: loaded.rows, : loaded.columns] = window.moved(cell_means(state.pressure, r), loaded)
    means = pressure.reshape(rows, nodes, columns, nodes).mean(axis=(1, 3))
    return PressureMap(
        position=state.position,
        distance=contact.position(state.position),
        along=(loaded.row - 0.5) * spacing,
        across=(loaded.column - 0.5) * spacing,
        cell=nodes * spacing,
        pressure=means.astype(np.float32),
    )


def _snapshot(state: ContactState, contact: RollingContact) -> Arrays:
    """Return place [m], pressure [Pa] and deflection [m] of the cells of a state."""
    window = state.window.cells(contact.subcells)
    spacing = contact.cell_spacing
    distance = contact.position(state.position)
    arrays = {
        "place": np.array([distance, window.row * spacing, window.column * spacing]),
        "pressure": cell_means(state.pressure, contact.subcells),
        "deflection": cell_means(state.deflection, contact.subcells),
    }
    return in_group(SNAPSHOT_GROUP, arrays)


# ---- film


class _Shot(NamedTuple):
    """Cells at a position of a film: pressure [Pa], and release [J] since the shot before."""

    window: Window
    pressure: Array
    release: Array


class Film:
    """Observer of maps of pressure and release at every `stride` positions of a stretch."""

    def __init__(self, contact: RollingContact, first: int, stride: int) -> None:
        self._contact = contact
        self._first = first
        self._stride = stride
        self._states: list[ContactState] = []
        self._energies: list[StepEnergy] = []
        self._shots: list[_Shot] = []

    def observe(self, state: ContactState, energy: StepEnergy | None) -> None:
        """Keep the pressure [Pa] of a position, and the release [J] since the shot before."""
        if energy is not None:
            self._energies.append(energy)
        self._states.append(state)
        if (state.position - self._first) % self._stride == 0:
            self._shots.append(self._shot())
            self._states = [state]
            self._energies = []

    def _shot(self) -> _Shot:
        """Return the shot at the present position."""
        r = self._contact.subcells
        last = self._states[-1]
        window = Window.around([state.loaded.whole(r).cells(r) for state in self._states])
        pressure = last.window.cells(r).moved(cell_means(last.pressure, r), window)
        release = np.zeros_like(pressure)
        for energy in self._energies:
            cells = cell_means(np.maximum(energy.node_work, 0.0), r) * r**2
            release += energy.window.cells(r).moved(cells, window)
        return _Shot(window, pressure, release)

    def arrays(self) -> Arrays:
        """Return the maps on a common part of the plate, with few enough cells."""
        windows = [shot.window for shot in self._shots]
        widest = max(max(window.rows, window.columns) for window in windows)
        nodes = math.ceil(widest / FILM_CELLS)  # along the side of a cell of the film
        border = FILM_MARGIN * nodes
        shown = Window.around(windows)
        whole = Window(
            shown.row - border,
            shown.column - border,
            (math.ceil(shown.rows / nodes) + 2 * FILM_MARGIN) * nodes,
            (math.ceil(shown.columns / nodes) + 2 * FILM_MARGIN) * nodes,
        )
        sums = [_cell_sums(shot.window.moved(shot.pressure, whole), nodes) for shot in self._shots]
        pressure, pressure_unit = _packed(np.array(sums) / nodes**2, np.uint8)
        sums = [_cell_sums(shot.window.moved(shot.release, whole), nodes) for shot in self._shots]
        release, release_unit = _packed(np.array(sums), np.uint16)
        spacing = self._contact.cell_spacing
        along = (whole.row - 0.5) * spacing
        across = (whole.column - 0.5) * spacing
        arrays = {
            "pressure": pressure,
            "release": release,
            "place": np.array([along, across, nodes * spacing, pressure_unit, release_unit]),
        }
        return in_group(FILM_GROUP, arrays)


def _cell_sums(values: Array, nodes: int) -> Array:
    """Return the sums of values over square cells of so many nodes along a side."""
    rows, columns = values.shape
    blocks = values.reshape(rows // nodes, nodes, columns // nodes, nodes)
    return np.asarray(blocks.sum(axis=(1, 3)))


def _packed(values: Array, kind: type[np.unsignedinteger]) -> tuple[NDArray[Any], float]:
    """Return values as whole numbers of a unit, and the unit: the maximum over the last number."""
    most = np.iinfo(kind).max
    unit = float(np.max(values, initial=0.0)) / most or 1.0
    return np.rint(values / unit).astype(kind), unit


Observer = Series | Events | Maps | Film
