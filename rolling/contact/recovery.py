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

from acoustics.arrays import Array
from rolling.contact import _window_kernels
from rolling.contact.half_space import HalfSpace
from rolling.contact.state import ContactState, Window
from rolling.contact.subcells import cell_means


@dataclass(frozen=True)
class StepEnergy:
    """Energies of the step between two states [J].

    The defect is loading minus release minus change of the stored energy, zero except for the error
    of the step. `node_work` is the energy that each node of the window released (positive) or took
    up (negative).
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

    Each node that is loaded at either position counts. The new window covers the nodes that were
    loaded; where the old window misses newly loaded nodes, its deflection is computed there. With
    `left_end` the pressure is taken at the old position instead of the mean.
    """
    window = new.window
    p_old = old.pressure
    u_old = old.deflection
    offset = old.window.row - window.row, old.window.column - window.column
    if not old.window.covers(new.loaded):
        p_old = old.window.moved(old.pressure, window)
        offset = (0, 0)
        u_old = half_space.deflect(p_old)
    work = np.empty((window.rows, window.columns))
    cell = half_space.spacing**2
    release, loading = _window_kernels.node_work(
        (p_old, u_old), offset, (new.pressure, new.deflection), left_end, cell, work
    )
    defect = loading - release - (new.stored_energy - old.stored_energy)
    return StepEnergy(float(release), float(loading), float(defect), window, work)


@dataclass
class EventTable:
    """Recovery events of a march: each an unbroken fall of the deflection of one loaded node.

    The columns, of which `count` rows are filled, are the node along and across, the positions
    between which the deflection fell, the energy [J] and the maximum release [J] in a step.
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
        window = work.window.cells(subcells)
        released = work.node_work
        if subcells > 1:
            released = cell_means(np.maximum(released, 0.0), subcells) * subcells**2
        origin = window.row, window.column
        while True:
            table = self.node, self.first, self.last, self.energy, self.peak
            count = _window_kernels.extend_events(
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
    """Join the columns of successive pieces of a track, and the events that their borders cut."""
    tables = list(pieces)
    if not tables:
        return {}
    table = {name: np.concatenate([piece[name] for piece in tables]) for name in tables[0]}
    node = table["node"]
    first = table["first"]
    last = table["last"]
    if not first.size:
        return table
    order = np.lexsort((first, node[:, 1], node[:, 0]))
    same = (node[order[1:]] == node[order[:-1]]).all(axis=1)
    begins = np.append(True, ~(same & (first[order[1:]] == last[order[:-1]])))
    starts = np.flatnonzero(begins)
    for name in ("last", "peak"):
        table[name][order[starts]] = np.maximum.reduceat(table[name][order], starts)
    # Energies are added in the order of the pieces, to the same last digit.
    table["energy"][order[starts]] = np.bincount(np.cumsum(begins) - 1, table["energy"][order])
    rows = np.sort(order[starts])
    return {name: column[rows] for name, column in table.items()}


@dataclass(frozen=True)
class EventStatistics:
    """Statistics of the recovery events on a length of track.

    Energies are mean, median and 90th percentile of an event [J], the peak is the maximum release
    of a node in a step [J], and `top_tenth_share` is the share of the release by the tenth of the
    events (rounded up) with the highest energies. Events last `duration_mean` steps.
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
    """Summarize the columns of recovery events on a length of track [m]; None without events."""
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
