"""Result of a run while its pieces come in: series, maps, events, and marches beside the track."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Container
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from acoustics.arrays import Array, short_repr
from acoustics.numbers import rounded
from rolling.archive.definition import of_group
from rolling.contact.recovery import join_events
from rolling.dynamics.motion import BodyMotion
from rolling.marches.effort import ARRAY, PARTS_OF_MARCHES, Effort, PieceEffort
from rolling.marches.march_variables import (
    EVENTS_GROUP,
    FAILURE,
    FILM_GROUP,
    MAPS_GROUP,
    MOVING_SERIES,
    SNAPSHOT_GROUP,
    STATE_SERIES,
    STEP_SERIES,
)
from rolling.marches.observers import PressureMap, SlowMotion, Snapshot, events_of, maps_of
from rolling.marches.passes import Passes
from rolling.marches.piece import Piece, contact_identity, track_pieces
from rolling.scene.identity import digest
from rolling.scene.scene import Scene
from rolling.scene.sections import VIBRATING_PLATE

LawKey = tuple[str, tuple[float, ...]]  # vibration and loads [N] of a law


def vibration_key(scene: Scene) -> str:
    """Return a digest that is equal for scenes of equal contact whose force is equal."""
    data = scene.model_dump(mode="json")
    plate = scene.plate
    rolling = data["rolling"]
    parts: list[Any] = [
        rolling["speed_m_s"],
        scene.track.steps,
        (scene.sphere.density_kg_m3, plate.density_kg_m3, plate.thickness_mm),
        data["dynamics"],
    ]
    # Keys that a scene leaves out add nothing, so that digests of older runs stay.
    if plate.edges_mm is not None or plate.contact_loss_factor:
        parts.append([data["plate"][name] for name in VIBRATING_PLATE])
    free_motion = {
        key: rolling[key] for key in ("resistance", "drop_mm") if rolling[key] is not None
    }
    if free_motion:
        parts.append(free_motion)
    return digest(parts)


class MotionOverLaw(NamedTuple):
    """Motion over a force law, with the vibration and the loads of the law."""

    key: LawKey
    motion: BodyMotion


@dataclass
class LoadMarches:
    """Marches of a track at other loads than the scene's, for its force law.

    steps : int. Number of different steps of the track.
    approach : dict. Approach by load [N], (steps + 1,) m; NaN where it is not solved yet.
    judging : dict. Approach by load [N] on the stretch that judges the force law, (n + 1,) m.
    failures : dict. Reason by load [N] where a contact cannot be solved.
    """

    __repr__ = short_repr

    steps: int
    approach: dict[float, Array] = field(default_factory=dict)
    judging: dict[float, Array] = field(default_factory=dict)
    failures: dict[float, str] = field(default_factory=dict)
    _failed_pieces: dict[float, dict[int, str]] = field(default_factory=lambda: defaultdict(dict))

    @property
    def failure(self) -> str:
        """Reason why the track could not be marched at a load; empty if it could."""
        if not self.failures:
            return ""
        load = min(self.failures)
        return f"{rounded(load, 4)} N: {self.failures[load]}"

    def missing(self, load: float) -> list[tuple[int, int]]:
        """Return first and last position of the pieces that a load [N] lacks."""
        if load in self.failures:
            return []
        approach = self.approach.get(load, np.full(self.steps + 1, np.nan))
        return _missing_pieces(approach[1:], self._failed_pieces[load])

    def add(self, piece: Piece, arrays: dict[str, NDArray[Any]]) -> None:
        """Add a piece; a load with a failed piece is dropped when its other pieces are there.

        The reason is that of the first failed piece, so it does not depend on their order.
        """
        load = piece.load
        failure = arrays.get(FAILURE.name)
        if piece.kind == "judge":
            if failure is None:
                self.judging[load] = arrays["approach"]
            else:
                self.failures[load] = str(failure)
            return
        if failure is None:
            whole = self.approach.setdefault(load, np.full(self.steps + 1, np.nan))
            _fill_states(whole, piece, arrays["approach"])
        else:
            self._failed_pieces[load][piece.first] = str(failure)
        failed = self._failed_pieces[load]
        if failed and not self.missing(load):
            self.failures[load] = failed[min(failed)]
            self.approach.pop(load, None)


@dataclass
class MovingRelease:
    """March of a lap under the moving load; its series are NaN where it is not solved yet.

    key : str. Digest of the vibration that moves the load, as `vibration_key`.
    force : (steps + 1,) array, N. Contact force at each position.
    motion_approach : (steps + 1,) array, m. Approach of the motion at each position.
    approach : (steps + 1,) array, m. Approach of the march.
    steps : dict. Series of the steps, (steps,) J.
    failure : str. Reason why there is no such march; empty if there is one.
    """

    __repr__ = short_repr

    key: str
    force: Array
    motion_approach: Array
    approach: Array = field(default_factory=lambda: np.empty(0))
    steps: dict[str, Array] = field(default_factory=dict)
    failure: str = ""
    _failed_pieces: dict[int, str] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        if not self.steps:
            self.approach = np.full(len(self.force), np.nan)
            self.steps = {name: np.full(len(self.force) - 1, np.nan) for name in MOVING_SERIES}

    @classmethod
    def impossible(cls, key: str, steps: int, failure: str) -> MovingRelease:
        """Return a march without numbers for a track that cannot have one."""
        unknown = np.full(steps + 1, np.nan)
        return cls(key, unknown, unknown, failure=failure)

    @property
    def repeats(self) -> bool:
        """Whether the load ends as it began, so that a lap of the release repeats."""
        return bool(self.force[0] == self.force[-1])

    @property
    def law_error(self) -> float:
        """Maximum difference between the approaches of march and motion [m]."""
        return float(np.abs(self.approach - self.motion_approach).max())

    def missing(self) -> list[tuple[int, int]]:
        """Return first and last position of the pieces that the march lacks."""
        if self.failure:
            return []
        return _missing_pieces(self.steps["release_energy"], self._failed_pieces)

    def add(self, piece: Piece, arrays: dict[str, NDArray[Any]]) -> None:
        """Add a piece; when all are there, the march has the reason of the first that failed."""
        if FAILURE.name in arrays:
            self._failed_pieces[piece.first] = str(arrays[FAILURE.name])
        else:
            for name in MOVING_SERIES:
                self.steps[name][piece.first : piece.last] = arrays[name]
            _fill_states(self.approach, piece, arrays["approach"])
        if self._failed_pieces and not self.missing():
            self.failure = self._failed_pieces[min(self._failed_pieces)]


@dataclass(frozen=True)
class StretchMarch:
    """March of a stretch on a level of accuracy.

    release : (steps,) array, J. Release per step; NaN if the march failed.
    approach : (steps + 1,) array, m. Approach at each position; NaN if the march failed.
    plastic_area : float, m2. Mean area at the hardness.
    failure : str. Reason of a failure; empty if there is none.
    """

    __repr__ = short_repr

    release: Array
    approach: Array
    plastic_area: float
    failure: str = ""

    @classmethod
    def none(cls, steps: int, failure: str = "") -> StretchMarch:
        """Return the march of a stretch that was not marched, or that failed."""
        return cls(
            release=np.full(steps, np.nan),
            approach=np.full(steps + 1, np.nan),
            plastic_area=math.nan,
            failure=failure,
        )


@dataclass
class ErrorStretches:
    """Marches of the stretches of a run for its error estimate.

    steps : int. Number of steps of a stretch.
    marches : dict. Marches by first position and level.
    """

    __repr__ = short_repr

    steps: int
    marches: dict[tuple[int, str], StretchMarch] = field(default_factory=dict)

    @property
    def failure(self) -> str:
        """The reason of the first failure along the track; empty if there is none."""
        failures = {key: march.failure for key, march in self.marches.items() if march.failure}
        if not failures:
            return ""
        return failures[min(failures)]

    def add(self, piece: Piece, arrays: dict[str, NDArray[Any]]) -> None:
        """Add the march of a stretch on a level."""
        if FAILURE.name in arrays:
            march = StretchMarch.none(self.steps, f"{piece.level}: {arrays[FAILURE.name]}")
        else:
            march = StretchMarch(
                release=arrays["release_energy"],
                approach=arrays["approach"],
                plastic_area=float(arrays["plastic_area"][-self.steps :].mean()),
            )
        self.marches[piece.first, piece.level] = march


@dataclass
class Result:
    """Solved lap of a run; its series are NaN where a step is not solved yet.

    identity : str. Contact identity of the scene that is solved.
    steps : int. Steps of the whole run.
    solved_steps : int. Number of different steps; the other steps repeat them.
    step : float, m. Length of a step.
    start : float, m. First position along the track.
    series : dict. Series of the lap by name, in SI units.
    snapshot : Snapshot. Pressure and deflection at the end of the first piece. Default: None.
    maps : dict. Pressure maps along the track, by position.
    event_pieces : dict. Tables of recovery events by the first position of their piece; a single
        table when the run is complete.
    stretches : ErrorStretches. Stretches that were marched for the error estimate. Default: None.
    slow_motion : SlowMotion. Contiguous maps around the loudest event, for the page. Default: None.
    load_marches : LoadMarches. Marches at other loads, for the force law. Default: None.
    moving : MovingRelease. March under the moving load. Default: None.
    passes : Passes. Passes over a plate that remembers; the series are of the last. Default: None.
    extremes : dict. Minimum and maximum of the contact force [N] by vibration and loads of the law,
        kept because each takes a motion. They are not stored.
    motion : MotionOverLaw. The last motion, which is not stored. Default: None.
    effort : Effort. Processor times of the marches, which are not stored.
    """

    __repr__ = short_repr

    identity: str
    steps: int
    solved_steps: int
    step: float
    start: float
    series: dict[str, Array]
    snapshot: Snapshot | None = None
    maps: dict[int, PressureMap] = field(default_factory=dict)
    event_pieces: dict[int, dict[str, NDArray[Any]]] = field(default_factory=dict)
    stretches: ErrorStretches | None = None
    slow_motion: SlowMotion | None = None
    load_marches: LoadMarches | None = None
    moving: MovingRelease | None = None
    passes: Passes | None = None
    extremes: dict[LawKey, tuple[float, float]] = field(default_factory=dict)
    motion: MotionOverLaw | None = None
    effort: Effort = field(default_factory=Effort)

    @classmethod
    def empty(cls, scene: Scene) -> Result:
        """Return the result of a scene without a sweep, without a solved step."""
        track = scene.track
        steps = track.solved_steps
        # Views of a single NaN take no memory in a sweep of many runs before their first piece.
        series = {name: np.broadcast_to(np.nan, steps) for name in STEP_SERIES}
        series |= {name: np.broadcast_to(np.nan, steps + 1) for name in STATE_SERIES}
        passes = None
        if scene.is_permanent:
            passes = Passes.empty(scene)
        return cls(
            identity=contact_identity(scene),
            steps=track.steps,
            solved_steps=steps,
            step=track.step,
            start=scene.start,
            series=series,
            passes=passes,
        )

    def add(self, piece: Piece, arrays: dict[str, NDArray[Any]]) -> None:
        """Add the arrays of a piece, as `march_piece` returns them."""
        if ARRAY in arrays:
            piece_effort = PieceEffort(*arrays[ARRAY].tolist())
            self.effort.add_piece(PARTS_OF_MARCHES[piece.kind], piece_effort)
        if piece.kind == "track":
            self._add_track(piece, arrays)
        elif piece.kind == "pass":
            assert self.passes is not None  # `empty` made them
            self.passes.add(piece, arrays)
            if piece.number + 1 == len(self.passes.depth):
                self._add_track(piece, arrays)
        elif piece.kind in ("load", "judge"):
            if self.load_marches is None:
                self.load_marches = LoadMarches(self.solved_steps)
            self.load_marches.add(piece, arrays)
        elif piece.kind == "moving":
            assert self.moving is not None  # `next_pieces` made it with its forces
            self.moving.add(piece, arrays)
        elif piece.kind == "error":
            steps = piece.last - piece.first
            if self.stretches is None or self.stretches.steps != steps:
                self.stretches = ErrorStretches(steps)
            self.stretches.add(piece, arrays)
        elif FAILURE.name in arrays:
            self.slow_motion = SlowMotion.none()
        else:
            self.slow_motion = _slow_motion(piece, arrays)

    def _add_track(self, piece: Piece, arrays: dict[str, NDArray[Any]]) -> None:
        """Add a piece of the track, or of the last pass, with its maps and events."""
        if not self.series["approach"].flags.writeable:
            self.series = {name: values.copy() for name, values in self.series.items()}
        for name in STEP_SERIES:
            self.series[name][piece.first : piece.last] = arrays[name]
        for name in STATE_SERIES:
            _fill_states(self.series[name], piece, arrays[name])
        snapshot = of_group(SNAPSHOT_GROUP, arrays)
        if snapshot:
            distance, along, across = snapshot["place"].tolist()
            self.snapshot = Snapshot(
                distance=distance,
                along=along,
                across=across,
                pressure=snapshot["pressure"],
                deflection=snapshot["deflection"],
            )
        self.maps |= maps_of(of_group(MAPS_GROUP, arrays))
        events = of_group(EVENTS_GROUP, arrays)
        if events:
            self.event_pieces[piece.first] = events_of(events)

    @property
    def sunk(self) -> Array | None:
        """Depth of the nodes below the virgin plate [m] after the passes; None for no passes."""
        return None if self.passes is None else self.passes.sunk

    def heights_after_passes(self, heights: Array) -> Array:
        """Return the heights [m] of a plate as its passes leave them."""
        return heights if self.sunk is None else heights - self.sunk

    def missing(self) -> list[tuple[int, int]]:
        """Return first and last position of the pieces of the track that are not solved yet."""
        return _missing_pieces(self.series["release_energy"], ())

    @property
    def is_complete(self) -> bool:
        """Whether all steps of the track are solved."""
        return not self.missing()

    def whole_series(self, name: str) -> Array:
        """Return a series of the whole run with repeated laps."""
        values: Array = self.series[name]
        places = np.arange(self.steps) % self.solved_steps
        if name in STATE_SERIES:
            places = np.append(places, (self.steps - 1) % self.solved_steps + 1)
        return np.asarray(values[places])

    def events(self) -> dict[str, NDArray[Any]] | None:
        """Return the table of recovery events on the solved steps, or None if not requested."""
        if not self.event_pieces:
            return None
        table = join_events([self.event_pieces[first] for first in sorted(self.event_pieces)])
        if self.is_complete:  # it is joined only once
            self.event_pieces = {0: table}
        return table


def _missing_pieces(values: Array, failed: Container[int]) -> list[tuple[int, int]]:
    """Return first and last position of the pieces of unknown steps, but for those that failed."""
    is_unknown = np.isnan(values)
    return [
        (first, last)
        for first, last in track_pieces(len(values))
        if first not in failed and is_unknown[first:last].any()
    ]


def _slow_motion(piece: Piece, arrays: dict[str, NDArray[Any]]) -> SlowMotion:
    """Return the slow motion of the arrays of a film."""
    film = of_group(FILM_GROUP, arrays)
    along, across, cell, pressure_unit, release_unit = film["place"].tolist()
    return SlowMotion(
        first=piece.first,
        stride=piece.stride,
        along=along,
        across=across,
        cell=cell,
        pressure_unit=pressure_unit,
        release_unit=release_unit,
        pressure=film["pressure"],
        release=film["release"],
    )


def _fill_states(whole: Array, piece: Piece, values: Array) -> None:
    """Fill in the states of a piece up to its last position."""
    whole[piece.last + 1 - len(values) : piece.last + 1] = values


def released_energy(scene: Scene, result: Result) -> tuple[Array, bool]:
    """Return the energy [J] released in each step of a run, and whether the steps are closed.

    The energy is that under the moving load where the scene asks for it and the march has it.
    """
    is_closed = scene.track.closed and result.steps % result.solved_steps == 0
    moving = result.moving
    if not scene.moves_release or moving is None or moving.failure:
        return result.whole_series("release_energy"), is_closed
    lap = moving.steps["release_energy"]
    energy = lap[np.arange(result.steps) % result.solved_steps]
    return energy, is_closed and moving.repeats
