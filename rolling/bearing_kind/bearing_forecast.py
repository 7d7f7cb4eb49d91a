"""Forecast of the processor time of the runs of bearings: marches, motions, files and page.

Steps, cold starts and motions are counted from the plans, as `rolling run` does them: a run moves
its ring once, and once more without its single faults, and has a pilot that moves it for a moment
first. The time of each was measured on runs of 6204 bearings. `tests/benchmarks/forecast_study.py`
compares forecasts with runs of other bearings.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from rolling.bearing._ring_kernels import take_steps
from rolling.bearing.limits import motion_seconds
from rolling.bearing_kind.contact_plan import ContactPlan
from rolling.bearing_kind.first_motion import pilot_of
from rolling.bearing_kind.joined_tracks import points_of_turn
from rolling.check import cost, forecast
from rolling.contact._descent_kernels import descend
from rolling.contact.compiling import is_kept
from rolling.in_si import scene_surface
from rolling.marches.piece import contact_identity, track_pieces
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.scene import Scene

# A step of a rolling body takes less from node to node than `cost.STEP_LAWS` says of rough plates,
# and hardly more for a step of several nodes: 0.6 ms on 66, 1 ms on 88, 2.5 ms on 152 and 4.4 to 7
# ms on 215 nodes (four scenes, lay and no lay, tolerances of 1e-5 to 5e-5).
STEP_LAW = (1.25, 1.9)  # [ms] on 100 by 100 nodes, and power of the nodes along a side
COLD_STEPS = 12  # steps that the cold start of a piece costs beside its own
# Processor seconds beside marches and motions.
LAYING = 0.2  # of the tracks of a run, and the doubts about them
TRACK_POINT = 3e-6  # per point of a track and load
FILES = 0.7  # of a run
FILES_SECOND = 0.1  # for each second of its motion
COMPILATION = {"march": 30.0, "motion": 9.0}  # of kernels that are not kept
PAGE_RUN = 1.3  # of the figures and the page of a run
PAGE_SECOND = 0.1


@dataclass(frozen=True)
class BearingForecast:
    """Counts of what the runs of a bearing compute, and its processor time.

    marches : int. Different marches of contacts; equal ones are marched once for all runs.
    steps : int. Steps of all of them.
    starts : int. Their pieces, each of which begins cold.
    motions : int. Motions of rings, of all runs and their pilots.
    compilations : tuple of str. Parts of the program that have to be compiled: march, motion.
    march_s : float, s. Processor time of the marches, and of making their surfaces once.
    beside_s : float, s. Processor time of all else, which one process does.
    """

    marches: int
    steps: int
    starts: int
    motions: int
    compilations: tuple[str, ...]
    march_s: float
    beside_s: float

    @property
    def core_seconds(self) -> float:
        """Time [s] on all cores times their number, as `forecast.takes` takes it."""
        return self.march_s + cost.cores() * self.beside_s


def forecast_of(runs: Sequence[tuple[BearingScene, ContactPlan]]) -> BearingForecast:
    """Return the forecast of runs, such as those of a sweep, from their scenes and plans."""
    marches = different_marches([plan for _, plan in runs])
    compilations = _compilations(bool(marches))
    beside_s = forecast.START + forecast.WORKER + sum(COMPILATION[part] for part in compilations)
    motions = 0
    for scene, plan in runs:
        of_run = 2 if scene.has_faults else 1
        motions += of_run
        beside_s += of_run * (motion_seconds(scene.model, scene.moved) + _laying_seconds(plan))
        pilot = pilot_of(scene)
        if pilot is not None:
            motions += 1
            beside_s += motion_seconds(scene.model, pilot.scene.moved) + _laying_seconds(plan)
        beside_s += FILES + PAGE_RUN + (FILES_SECOND + PAGE_SECOND) * scene.moved
    return BearingForecast(
        marches=len(marches),
        steps=sum(scene.track.solved_steps for scene in marches.values()),
        starts=sum(map(_starts, marches.values())),
        motions=motions,
        compilations=compilations,
        march_s=marches_seconds(marches.values()),
        beside_s=beside_s,
    )


def different_marches(plans: Sequence[ContactPlan]) -> dict[str, Scene]:
    """Return the marches that the runs of some plans share, by their contact identity."""
    marches: dict[str, Scene] = {}
    for plan in plans:
        for stage in plan.stages:
            for scene in stage:
                marches.setdefault(contact_identity(scene), scene)
    return marches


def marches_seconds(marches: Iterable[Scene]) -> float:
    """Return the processor time [s] of marches; those over one surface make it once a process."""
    seconds = 0.0
    surfaces: dict[object, float] = {}
    for scene in marches:
        steps = scene.track.solved_steps + COLD_STEPS * _starts(scene)
        seconds += steps * step_ms(scene) * 1e-3
        making, _ = cost.surface_seconds(scene)
        surfaces.setdefault(scene_surface.identity(scene), making)
    return seconds + sum(surfaces.values())


def step_ms(scene: Scene) -> float:
    """Return the processor time [ms] of a step of a contact of a bearing."""
    at_100, power = STEP_LAW
    rq, _ = cost.roughness(scene)
    own_ms = at_100 * (cost.window_nodes(scene, rq) / 100) ** power
    return float(own_ms * cost.subcells(scene) ** cost.SUBCELL_POWER)


def _compilations(is_marched: bool) -> tuple[str, ...]:
    """Return what a first run on this machine compiles, by the longest kernel of each part."""
    parts = []
    if is_marched and not is_kept(descend):
        parts.append("march")
    if not is_kept(take_steps):
        parts.append("motion")
    return tuple(parts)


def _starts(scene: Scene) -> int:
    """Return the number of pieces of a march."""
    return len(track_pieces(scene.track.solved_steps))


def _laying_seconds(plan: ContactPlan) -> float:
    """Return the processor time [s] in which the tracks of a run are laid and judged once."""
    points = points_of_turn(plan, "inner") + points_of_turn(plan, "outer")
    points += 2 * plan.geometry.balls * points_of_turn(plan, "balls")
    return LAYING + TRACK_POINT * len(plan.loads_n) * points
