"""Recovery in the frame of the plate: energies per step, recovery events, their statistics.

A node whose deflection falls by du under pressure p releases p du dA (Lee, Kim & Kim, Inventions
10(1), 17 (2025), Eq. 8-9). p is the mean over the step, which is accurate to second order, or the
value at its left end as in the article.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rolling._typing import Array
from rolling.contact import _state_kernels
from rolling.contact.half_space import HalfSpace
from rolling.contact.state import ContactState, Window
from rolling.contact.subcells import cell_means


@dataclass(frozen=True)
class StepEnergy:
    """Energies of the step between two states.

    Parameters
    ----------
    release, loading : float, J
        Sums of the energies that nodes released and took up.
    defect : float, J
        Loading minus release minus change of the stored energy, zero except for the error of the
        step.
    window : Window
        Nodes of `node_work`.
    node_work : (rows, columns) array, J
        Energy that each node released (positive) or took up (negative).
    """

    release: float
    loading: float
    defect: float
    window: Window
    node_work: Array


def step_energy(
    old: ContactState, new: ContactState, half_space: HalfSpace, left_end: bool = False
) -> StepEnergy:
    """Compute release and loading between two successive positions.

    Each node that is loaded at either position counts, so both deflections must be known on all
    these nodes. The new window covers the nodes that were loaded; where the old window misses newly
    loaded nodes, its deflection is computed there.

    Parameters
    ----------
    old, new : ContactState
        States at successive positions.
    half_space : HalfSpace
        Pressure to deflection.
    left_end : bool
        If true, the pressure is taken at the old position instead of the mean. Default: false.

    Returns
    -------
    StepEnergy
        Energies of the step.
    """
    window, p_old, u_old = new.window, old.pressure, old.deflection
    offset = old.window.row - window.row, old.window.column - window.column
    if not old.window.covers(new.loaded):
        p_old, offset = old.window.moved(old.pressure, window), (0, 0)
        u_old = half_space.deflection(p_old)
    work = np.empty((window.rows, window.columns))
    cell = half_space.spacing**2
    release, loading = _state_kernels.node_work(
        (p_old, u_old), offset, (new.pressure, new.deflection), left_end, cell, work
    )
    defect = loading - release - (new.stored_energy - old.stored_energy)
    return StepEnergy(float(release), float(loading), float(defect), window, work)


@dataclass
class EventTable:
    """Recovery events of a march.

    Each event is an unbroken fall of the deflection of one loaded node.

    Parameters
    ----------
    shape : (int, int)
        Nodes of the surface along and across.
    count : int
        Number of events, which is the number of filled rows in each column.
    node : (n, 2) array
        Node along and across.
    first, last : (n,) arrays
        Positions between which the deflection fell.
    energy : (n,) array, J
        Energy of the event.
    peak : (n,) array, J per step
        Maximum release in a step.
    """

    shape: tuple[int, int]
    count: int = 0
    node: NDArray[np.int32] = field(default_factory=lambda: np.empty((1024, 2), np.int32))
    first: NDArray[np.int64] = field(default_factory=lambda: np.empty(1024, np.int64))
    last: NDArray[np.int64] = field(default_factory=lambda: np.empty(1024, np.int64))
    energy: Array = field(default_factory=lambda: np.empty(1024))
    peak: Array = field(default_factory=lambda: np.empty(1024))

    def __post_init__(self) -> None:
        # One more than the last event of each node; 0 is none, so that the memory of nodes off the
        # track is never touched.
        self._open = np.zeros(self.shape, dtype=np.int64)

    def add(self, step: int, work: StepEnergy, subcells: int = 1) -> None:
        """Add the releases between positions `step` and `step` + 1.

        The release of a node is that of so many sub-cells along and across.
        """
        window, released = work.window.cells(subcells), work.node_work
        if subcells > 1:
            released = cell_means(np.maximum(released, 0.0), subcells) * subcells**2
        origin = window.row, window.column
        while True:
            table = self.node, self.first, self.last, self.energy, self.peak
            count = _state_kernels.extend_events(
                released, origin, step, self._open, table, self.count
            )
            if count >= 0:
                self.count = int(count)
                return
            rows = max(-1 - count, 2 * self.energy.size)
            for name in ("node", "first", "last", "energy", "peak"):
                old = getattr(self, name)
                new = np.empty((rows, *old.shape[1:]), old.dtype)
                new[: self.count] = old[: self.count]
                setattr(self, name, new)

    def columns(self) -> dict[str, NDArray[Any]]:
        """Return copies of the filled part of each column by name."""
        names = ("node", "first", "last", "energy", "peak")
        return {name: getattr(self, name)[: self.count].copy() for name in names}


def join_events(pieces: Iterable[dict[str, NDArray[Any]]]) -> dict[str, NDArray[Any]]:
    """Join the tables of successive pieces of a track.

    An event that the border between pieces cuts is made whole.

    Parameters
    ----------
    pieces : iterable of dict
        Tables as EventTable.columns returns them, in the order of the pieces.

    Returns
    -------
    dict
        Joined columns.
    """
    copies = [{name: column.copy() for name, column in piece.items()} for piece in pieces]
    tables = [piece for piece in copies if piece["energy"].size]
    if not tables:
        return copies[0] if copies else {}
    kept = [np.ones(table["energy"].size, dtype=bool) for table in tables]
    # This holds table and row of each event that reaches the last position of its piece, because a
    # long event may run through whole pieces.
    open_events: dict[tuple[int, ...], tuple[dict[str, NDArray[Any]], int]] = {}
    for table, keep in zip(tables, kept, strict=True):
        border = table["first"].min()
        reaching = open_events
        open_events = {}
        end = table["last"].max()
        for k in np.flatnonzero((table["first"] == border) | (table["last"] == end)):
            owner, row = table, int(k)
            node = tuple(table["node"][k])
            before = reaching.get(node) if table["first"][k] == border else None
            if before is not None and before[0]["last"][before[1]] == border:
                owner, row = before
                owner["last"][row] = table["last"][k]
                owner["energy"][row] += table["energy"][k]
                owner["peak"][row] = max(owner["peak"][row], table["peak"][k])
                keep[k] = False
            if table["last"][k] == end:
                open_events[node] = (owner, row)
    return {
        name: np.concatenate([table[name][keep] for table, keep in zip(tables, kept, strict=True)])
        for name in tables[0]
    }


@dataclass(frozen=True)
class EventStatistics:
    """Statistics of the recovery events on a length of track.

    Parameters
    ----------
    count : int
        Number of events.
    per_metre : float, 1/m
        Events per length of track.
    energy_mean, energy_median, energy_p90 : float, J
        Energy of an event: mean, median and 90th percentile.
    duration_mean : float
        Steps that an event lasts.
    peak : float, J
        Maximum release of a node in a step.
    top_tenth_share : float
        Share of the release by the tenth of the events (rounded up) with the highest energies.
    """

    count: int
    per_metre: float
    energy_mean: float
    energy_median: float
    energy_p90: float
    duration_mean: float
    peak: float
    top_tenth_share: float


def event_statistics(events: Mapping[str, NDArray[Any]], length: float) -> EventStatistics | None:
    """Summarize a table of recovery events; return None when there are no events.

    Parameters
    ----------
    events : mapping of str to (n,) array
        Columns first, last, energy [J] and peak [J per step] (see EventTable).
    length : float, m
        Length of the track on which they were released.

    Returns
    -------
    EventStatistics or None
        Statistics, or None without events.
    """
    energy = events["energy"]
    count = len(energy)
    if count == 0:
        return None
    most = np.sort(energy)[-math.ceil(count / 10) :]
    return EventStatistics(
        count=count,
        per_metre=count / length,
        energy_mean=float(energy.mean()),
        energy_median=float(np.median(energy)),
        energy_p90=float(np.quantile(energy, 0.9)),
        duration_mean=float((events["last"] - events["first"]).mean()),
        peak=float(events["peak"].max()),
        top_tenth_share=float(most.sum() / energy.sum()),
    )
