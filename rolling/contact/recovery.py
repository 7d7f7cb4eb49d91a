"""Deflection histories in the frame of the plate: release, loading and stored energy per step, recovery events, energy ledger.

Depends on march (states) and half_space. A node whose deflection falls by du under pressure p releases p du dA (Lee, Kim & Kim,
Inventions 10(1), 17 (2025), Eq. 8-9); p is the mean over the step, second order in it, or its left end as in the article.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rolling.contact import _recovery_kernels
from rolling.contact.half_space import HalfSpace
from rolling.contact.march import ContactState, Window

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StepEnergy:
    """Energies of the step between two states [J]: `defect` is loading - release - change of the stored energy.

    `node_work` [J] is what each node of `window` released (positive) or took up (negative).
    """

    release: float
    loading: float
    defect: float
    window: Window
    node_work: Array


def step_energy(old: ContactState, new: ContactState, half_space: HalfSpace, left_end: bool = False) -> StepEnergy:
    """Release and loading between two successive positions.

    Every node loaded at either position counts, so both deflections must be known on all of them: the new window reaches over
    the nodes that were loaded; where the old one does not reach over the new ones, its deflection is computed there.
    """
    window, p_old, u_old = new.window, old.pressure, old.deflection
    offset = old.window.row - window.row, old.window.column - window.column
    if not old.window.covers(new.loaded):
        p_old, offset = old.window.moved(old.pressure, window), (0, 0)
        u_old = half_space.deflection(p_old)
    work = np.empty((window.rows, window.columns))
    cell = half_space.spacing**2
    release, loading = _recovery_kernels.node_work(
        p_old, u_old, *offset, new.pressure, new.deflection, left_end, cell, work
    )
    defect = loading - release - (new.stored_energy - old.stored_energy)
    return StepEnergy(float(release), float(loading), float(defect), window, work)


@dataclass
class EventTable:
    """Recovery events of a march: each an unbroken fall of one loaded node's deflection.

    Columns: node (along, across), first and last position, energy [J], peak [J per step].
    """

    shape: tuple[int, int]
    count: int = 0
    node: NDArray[np.int32] = field(default_factory=lambda: np.empty((1024, 2), np.int32))
    first: NDArray[np.int64] = field(default_factory=lambda: np.empty(1024, np.int64))
    last: NDArray[np.int64] = field(default_factory=lambda: np.empty(1024, np.int64))
    energy: Array = field(default_factory=lambda: np.empty(1024))
    peak: Array = field(default_factory=lambda: np.empty(1024))

    def __post_init__(self) -> None:
        self._open = np.full(self.shape, -1, dtype=np.int64)

    def add(self, step: int, work: StepEnergy) -> None:
        """Enter what was released between positions `step` and `step` + 1."""
        while True:
            count = _recovery_kernels.extend_events(
                work.node_work,
                work.window.row,
                work.window.column,
                step,
                self._open,
                self.first,
                self.last,
                self.energy,
                self.peak,
                self.node,
                self.count,
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
        """The filled part, by column name."""
        names = ("node", "first", "last", "energy", "peak")
        return {name: getattr(self, name)[: self.count].copy() for name in names}


def join_events(pieces: Iterable[dict[str, NDArray[Any]]]) -> dict[str, NDArray[Any]]:
    """One table from the tables of pieces of a track, in their order: an event cut by a border between pieces is made whole."""
    copies = [{name: column.copy() for name, column in piece.items()} for piece in pieces]
    tables = [piece for piece in copies if piece["energy"].size]
    if not tables:
        return copies[0] if copies else {}
    kept = [np.ones(table["energy"].size, dtype=bool) for table in tables]
    # Where each event that reaches the last position of its piece began: a long one may run through whole pieces.
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
