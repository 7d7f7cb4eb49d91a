"""The result of a run while it grows.

It consists of series, snapshot, pressure maps, recovery events and the identity of the run.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rolling._typing import Array
from rolling.contact.recovery import join_events
from rolling.scene.identity import Identity
from rolling.scene.track import Track
from rolling.simulation.load_marches import LoadMarches
from rolling.simulation.moving_load import MovingRelease
from rolling.simulation.simulate import STATE_SERIES, STEP_SERIES, Piece, PressureMap, Snapshot
from rolling.simulation.slow_motion import SlowMotion
from rolling.simulation.stretches import ErrorStretches, March, Trial


@dataclass
class Result:
    """The solved lap of a run; its series are NaN where a step is not solved yet.

    steps : int. Steps of the whole run.
    solved_steps : int. Number of different steps; the other steps repeat them.
    step : float, m. Length of a step.
    start : float, m. First position along the track.
    series : dict. Series of the lap by name, in SI units.
    snapshot : Snapshot. Pressure and deflection at the end of the first piece. Default: None.
    maps : dict. Pressure maps along the track, by position.
    event_pieces : dict. Tables of recovery events by the first position of their piece; a single
        table when the run is complete.
    identity : Identity. Scene and surface that were solved; None in files of version 0.1.0.
    stretches : ErrorStretches. Stretches that were marched for the error estimate. Default: None.
    trial : Trial. Choice of the tolerance; None if the scene gave a number. Default: None.
    slow_motion : SlowMotion. Contiguous maps around the loudest event, for the page. Default: None.
    load_marches : LoadMarches. Marches at other loads, for the force law. Default: None.
    moving : dict. Marches under moving loads, by the vibration that moves them.
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
    stretches: ErrorStretches | None = None
    trial: Trial | None = None
    slow_motion: SlowMotion | None = None
    load_marches: LoadMarches | None = None
    moving: dict[str, MovingRelease] = field(default_factory=dict)

    @classmethod
    def empty(cls, track: Track, start: float) -> Result:
        """Return a result without a solved step.

        Parameters
        ----------
        track : Track. The track of the run.
        start : float, m. First position along the track.
        """
        solved = track.solved_steps
        series = {name: np.full(solved, np.nan) for name in STEP_SERIES}
        series |= {name: np.full(solved + 1, np.nan) for name in STATE_SERIES}
        return cls(track.steps, solved, track.step, start, series)

    def add(self, piece: Piece) -> None:
        """Add a solved piece of the lap."""
        for name, values in piece.steps.items():
            self.series[name][piece.first : piece.last] = values
        for name, values in piece.states.items():
            self.series[name][piece.last + 1 - len(values) : piece.last + 1] = values
        self.snapshot = piece.snapshot or self.snapshot
        self.maps |= {pressure_map.position: pressure_map for pressure_map in piece.maps}
        if piece.events is not None:
            self.event_pieces[piece.first] = piece.events

    def add_march(self, march: March) -> None:
        """Add the march of a stretch, whose length is that of the other stretches."""
        if self.stretches is None:
            self.stretches = ErrorStretches(march.steps)
        self.stretches.add(march)

    @property
    def complete(self) -> bool:
        """Whether all steps are solved."""
        return not np.isnan(self.series["release_energy"]).any()

    @property
    def done_steps(self) -> int:
        """Number of steps from the start to the first unsolved step."""
        gaps = np.flatnonzero(np.isnan(self.series["release_energy"]))
        return int(gaps[0]) if len(gaps) else self.steps

    def whole(self, name: str) -> Array:
        """Return a series of the whole run with repeated laps."""
        values: Array = self.series[name]
        if name in STEP_SERIES:
            shown: Array = values[np.arange(self.steps) % self.solved_steps]
        else:
            last = (self.steps - 1) % self.solved_steps + 1
            shown = values[np.append(np.arange(self.steps) % self.solved_steps, last)]
        return shown

    def events(self) -> dict[str, NDArray[Any]] | None:
        """Return the table of recovery events on the solved steps, or None if not requested."""
        if not self.event_pieces:
            return None
        table = join_events([self.event_pieces[first] for first in sorted(self.event_pieces)])
        if self.complete:
            self.event_pieces = {
                0: table
            }  # a complete run gets no more events, so it is joined only once
        return table
