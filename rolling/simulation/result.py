"""The result of a run while it grows: series, snapshot, pressure maps, recovery events, and the identity of the run.

Depends on simulate, whose pieces it collects, and on recovery, which joins their events. `store` writes and reads it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rolling.contact.recovery import join_events
from rolling.scene.identity import Identity
from rolling.scene.track import Track
from rolling.simulation.simulate import STATE_SERIES, STEP_SERIES, Piece, PressureMap, Snapshot

Array = NDArray[np.float64]


@dataclass
class Result:
    """Series of a run: of one lap of the track or less, which is all that is ever solved; NaN where not solved yet.

    steps : steps of the whole run; `solved_steps` of them are different, the rest go round again.
    maps : pressure maps along the track, by position.
    event_pieces : tables of recovery events by the first position of their piece; joined into one once all are there.
    identity : scene and surface that were solved; None in files of version 0.1.0, which do not say it.
    """

    steps: int
    solved_steps: int
    step: float
    start: float
    series: dict[str, Array]
    snapshot: Snapshot | None = None
    maps: dict[int, PressureMap] = field(default_factory=dict)
    event_pieces: dict[int, dict[str, NDArray[Any]]] = field(default_factory=dict)
    identity: Identity | None = None

    @classmethod
    def empty(cls, track: Track, start: float) -> Result:
        solved = track.solved_steps
        series = {name: np.full(solved, np.nan) for name in STEP_SERIES}
        series |= {name: np.full(solved + 1, np.nan) for name in STATE_SERIES}
        return cls(track.steps, solved, track.step, start, series)

    def add(self, piece: Piece) -> None:
        for name, values in piece.steps.items():
            self.series[name][piece.first : piece.last] = values
        for name, values in piece.states.items():
            self.series[name][piece.last + 1 - len(values) : piece.last + 1] = values
        self.snapshot = piece.snapshot or self.snapshot
        self.maps |= {one.position: one for one in piece.maps}
        if piece.events is not None:
            self.event_pieces[piece.first] = piece.events

    @property
    def complete(self) -> bool:
        return not np.isnan(self.series["release_energy"]).any()

    @property
    def done_steps(self) -> int:
        """Length of the unbroken beginning that is solved."""
        gaps = np.flatnonzero(np.isnan(self.series["release_energy"]))
        return int(gaps[0]) if len(gaps) else self.steps

    def whole(self, name: str) -> Array:
        """A series over the whole run, laps repeated."""
        values = self.series[name]
        if name in STEP_SERIES:
            return values[np.arange(self.steps) % self.solved_steps]
        return values[np.append(np.arange(self.steps) % self.solved_steps, (self.steps - 1) % self.solved_steps + 1)]

    def events(self) -> dict[str, NDArray[Any]] | None:
        """The table of recovery events of what is solved; None when none were asked for."""
        if not self.event_pieces:
            return None
        table = join_events([self.event_pieces[first] for first in sorted(self.event_pieces)])
        if self.complete:
            self.event_pieces = {0: table}  # joined once: nothing can be added any more
        return table
