"""Passes of the sphere over a plate that remembers: pieces, sinking, and the numbers of each pass.

A closed track is a period of an endless track: ahead of the contact lies the surface that the pass
before left, behind it the surface of this pass. A pass therefore closes as the surface does. Its
pieces begin some contact widths before their first position, because the contact forgets where it
was set down. An open track begins where the sphere is set down in each pass.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array, short_repr
from acoustics.numbers import rounded
from rolling.check import cost
from rolling.contact.memory import sink
from rolling.contact.solver import ContactError
from rolling.contact.state import ContactState, RollingContact
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.marches.piece import Piece
from rolling.scene.scene import Scene

# Widths of the contact after which a march has forgotten its cold start: to 3.3e-6 of the release's
# fluctuation where the Hertz pressure stays below the hardness (113 of 114 random scenes, 6e-5 on a
# plate of Ra 5 nm). In a groove 8 widths leave 1e-6 to 0.1: its pass is one piece.
RUN_IN = 2.0
RUN_IN_GROOVE = 8.0
# The last pass still yields above this share of plastic work in the release.
YIELDING = 1e-3
SERIES = ("release_energy", "plastic_work", "approach")  # the last has an entry per position


def _width_steps(scene: Scene) -> float:
    """Estimate the width of the contact in steps."""
    rq, _ = cost.roughness(scene)
    return 2 * cost.overlap_radius(scene, rq) / scene.step


def _is_groove(scene: Scene) -> bool:
    """Return whether the smooth contact yields, so that the sphere rolls in a groove."""
    return smooth_contact_of(scene).maximum_pressure_pa() > scene.hardness


def run_in(scene: Scene, first: int) -> int:
    """Return the number of positions before the first that a march needs to forget its start."""
    widths = RUN_IN
    if _is_groove(scene):
        widths = RUN_IN_GROOVE
    steps = math.ceil(widths * _width_steps(scene))
    if scene.track.solved_steps == scene.track.lap_steps:  # the track goes on before its first
        return steps
    return min(steps, first)


def pass_pieces(scene: Scene) -> list[tuple[int, int]]:
    """Return the first and last position of each piece of a pass, equal in length."""
    steps = scene.track.solved_steps
    count = 1
    if not _is_groove(scene):
        count = max(1, round(steps * cost.RUN_IN_SHARE / run_in(scene, steps)))
    return list(pairwise([k * steps // count for k in range(count + 1)]))


def unrolled(scene: Scene, heights: Array, steps: int) -> Array:
    """Repeat heights by whole periods until a march of some steps covers no place twice."""
    nodes = (steps + 2 * _width_steps(scene)) * scene.step_nodes
    return np.tile(heights, (math.ceil(nodes / len(heights)), 1))


class Sinking:
    """Memory of a plate in a march: it lowers the heights of its contact at each state.

    It remembers the sinking after the first position, or from the start where both are the same.
    """

    def __init__(self, contact: RollingContact, start: int, first: int, along: int) -> None:
        """Begin with the heights of a contact, whose period is `along` nodes."""
        self._contact = contact
        self._start = start
        self._first = first
        self._along = along
        self._before = contact.heights.copy()
        self._work: list[float] = []

    def lower(self, state: ContactState) -> float:
        """Lower the heights at a state, and return its plastic work [J]."""
        contact = self._contact
        if state.loaded.rows > self._along:
            width = rounded(state.loaded.rows * contact.spacing * 1e6, 4)
            raise ContactError(f"contact is {width} um wide along the track, more than its period")
        work = sink(contact, state)
        if state.position > self._first:
            self._work.append(work)
        elif state.position == self._first != self._start:
            self._before = contact.heights.copy()
        return work

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the plastic work of steps [J], and the depth by which rows have sunk [m]."""
        sunk = self._before - self._contact.heights
        periods = sunk.reshape(-1, self._along, sunk.shape[1])
        depth = periods.sum(axis=0)
        rows = np.flatnonzero(depth.any(axis=1))
        return {"plastic_work": np.array(self._work), "sunk_row": rows, "sunk_depth": depth[rows]}


@dataclass
class Passes:
    """Passes of a run over a plate that remembers; unsolved entries are NaN.

    series : dict. Release energy and plastic work of each step, (passes, steps) J, and approach at
        each position, (passes, steps + 1) m.
    depth : (passes,) array, m. Maximum depth below the virgin surface after each pass.
    sunk : (along, across) array, m. Depth of the nodes after the last finished pass.
    before : (along, across) array, m. Depth before it; None where it is not stored.
    """

    __repr__ = short_repr

    series: dict[str, Array]
    depth: Array
    sunk: Array
    before: Array | None = None
    _parts: dict[int, dict[str, NDArray[Any]]] = field(default_factory=dict, repr=False)

    @classmethod
    def empty(cls, scene: Scene) -> Passes:
        """Return the passes of a scene over a plate that remembers, before the first."""
        track = scene.track
        count = scene.passes
        series = {
            "release_energy": np.full((count, track.solved_steps), np.nan),
            "plastic_work": np.full((count, track.solved_steps), np.nan),
            "approach": np.full((count, track.solved_steps + 1), np.nan),
        }
        return cls(
            series=series,
            depth=np.full(count, np.nan),
            sunk=np.zeros((track.n_along, track.n_across)),
        )

    @property
    def finished(self) -> int:
        """Number of finished passes, and index of the pass that is marched now."""
        return int(np.isfinite(self.depth).sum())

    @property
    def yielding(self) -> float:
        """Plastic work of the last pass over its release."""
        work = self.series["plastic_work"][-1].sum()
        release = self.series["release_energy"][-1].sum()
        return float(work / release)

    def refuse_yielding(self) -> None:
        """Raise ContactError while the last pass yields: a force law needs a run-in plate."""
        if self.yielding > YIELDING:
            count = len(self.depth)
            raise ContactError(
                "a force law needs a plate that has run in, and in pass"
                f" {count} of {count} the plastic work is {rounded(self.yielding)} of the release,"
                f" allowed: {rounded(YIELDING)}; raise rolling.passes, or leave out dynamics"
            )

    def missing(self, scene: Scene) -> list[tuple[int, int]]:
        """Return first and last position of the pieces that the present pass lacks."""
        if self.finished == len(self.depth):
            return []
        return [(first, last) for first, last in pass_pieces(scene) if first not in self._parts]

    def add(self, piece: Piece, arrays: dict[str, NDArray[Any]]) -> None:
        """Add a piece of the present pass; after the last missing piece the plate sinks."""
        number = self.finished
        for name in ("release_energy", "plastic_work"):
            self.series[name][number, piece.first : piece.last] = arrays[name]
        approach = arrays["approach"]
        end = piece.last + 1
        self.series["approach"][number, end - len(approach) : end] = approach
        self._parts[piece.first] = arrays
        if self.missing(piece.scene):
            return
        self.before = self.sunk
        self.sunk = self.sunk.copy()
        for first in sorted(self._parts):
            part = self._parts[first]
            self.sunk[part["sunk_row"]] += part["sunk_depth"]
        self.depth[number] = self.sunk.max()
        self._parts.clear()
