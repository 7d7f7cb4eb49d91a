"""Stretches of a run that are marched again, for the estimate of its errors.

Each stretch is marched from a cold start over the positions of the run: on the run's grid at a
tight tolerance, at half the spacing and the tight tolerance, and at twice the spacing. Places,
rounds and numbers depend on the scene alone, so they are equal for any number of workers.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rolling._typing import Array
from rolling.check import cost, error_cost
from rolling.check.error_cost import LEVELS, Layout
from rolling.contact.of_scene import rolling_contact
from rolling.contact.solver import ContactError
from rolling.contact.state import RollingContact
from rolling.scene.scene import Scene
from rolling.simulation import pool, simulate
from rolling.simulation.result import Result
from rolling.simulation.stretches import ErrorStretches, March
from rolling.sound import error_estimate
from rolling.sound.error_estimate import BandPowers, StretchSignals
from rolling.sound.vibration_sound import roughness_gain
from rolling.surface.refined import cells_of_patch
from rolling.surface.scene_surface import heights

# ---- the stretches to march


def layout_of(scene: Scene, stretches: ErrorStretches | None) -> Layout | None:
    """Return the layout of the stretches, or None where the track is too short.

    Stretches that are marched already keep their length, because another speed would choose another
    length.
    """
    steps = stretches.steps if stretches else error_cost.stretch_steps(scene)
    return error_cost.layout(scene, steps) if steps else None


def missing(scene: Scene, result: Result) -> list[tuple[int, str]]:
    """Return first position and level of the marches that the estimate of a run needs next.

    The first round has four stretches. Each round doubles them, until the standard errors suffice
    or the share of the run's cost is spent.
    """
    if not scene.numerics.error_estimate or not result.complete or scene.surface.kind == "smooth":
        return []
    stretches = result.stretches
    layout = layout_of(scene, stretches)
    if layout is None or (stretches and (stretches.fault or lacks_approach(scene, stretches))):
        return []
    known = stretches.marches if stretches else {}
    firsts = _rounds(scene, result, layout)
    return [(first, level) for first in firsts for level in LEVELS if (first, level) not in known]


def _rounds(scene: Scene, result: Result, layout: Layout) -> tuple[int, ...]:
    """Return the first positions of the stretches that a run needs, as far as it can tell now."""
    count, stretches = error_cost.FIRST_STRETCHES, result.stretches
    while count < len(layout.firsts):
        firsts = layout.firsts[:count]
        if stretches is None or not all(stretches.complete(first) for first in firsts):
            return firsts
        if suffices(powers_of(scene, result, firsts)):
            return firsts
        count *= 2
    return layout.firsts


def suffices(powers: BandPowers) -> bool:
    """Return whether all standard errors are as small as wanted."""
    return error_estimate.worst_uncertainty_db(powers) <= error_estimate.WANTED_DB


def lacks_approach(scene: Scene, stretches: ErrorStretches) -> bool:
    """Return whether stretches keep no approach, which the estimate of a vibration needs."""
    vibrates = scene.sound.source == "vibration"
    return vibrates and any(not march.approach.size for march in stretches.marches.values())


def marched(scene: Scene, result: Result) -> tuple[int, ...]:
    """Return the first positions of a run's stretches in their order, as far as complete.

    A run takes no more of them than it needs itself, so that its numbers do not depend on the runs
    that it shares them with.
    """
    stretches = result.stretches
    layout = layout_of(scene, stretches) if stretches else None
    if stretches is None or layout is None or stretches.fault:
        return ()
    if lacks_approach(scene, stretches):
        return ()
    firsts = _rounds(scene, result, layout)
    gaps = [k for k, first in enumerate(firsts) if not stretches.complete(first)]
    return firsts[: gaps[0]] if gaps else firsts


def powers_of(scene: Scene, result: Result, firsts: tuple[int, ...]) -> BandPowers:
    """Compute the band powers of complete stretches of a run at the speeds of the scene."""
    stretches = result.stretches
    assert stretches is not None
    vibrates = scene.sound.source == "vibration"
    own = result.series["approach" if vibrates else "release_energy"]

    def of_level(level: str) -> Array:
        marches = [stretches.marches[first, level] for first in firsts]
        if vibrates:
            return np.array([march.approach[:-1] for march in marches])
        return np.array([march.release for march in marches])

    signals = StretchSignals(
        own=np.array([own[first : first + stretches.steps] for first in firsts]),
        tight=of_level("tight"),
        fine=of_level("fine"),
        coarse=of_level("coarse"),
        step=result.step,
        speeds=np.array([_speeds(scene, result, first) for first in firsts]),
        tolerance_ratio=error_cost.tight_tolerance(scene) / scene.tolerance,
        gain=roughness_gain(scene) if vibrates else None,
    )
    return error_estimate.band_powers(signals)


def plastic_areas(result: Result, firsts: tuple[int, ...], level: str) -> Array:
    """Return the mean area at the hardness of each stretch on a level [m2]."""
    assert result.stretches is not None
    return np.array([result.stretches.marches[first, level].plastic_area for first in firsts])


def _speeds(scene: Scene, result: Result, first: int) -> Array:
    """Return the mean speed at each pass over a stretch [m/s], 0 where the run ends before."""
    assert result.stretches is not None
    length = result.stretches.steps * result.step
    laps = math.ceil(result.steps / result.solved_steps)
    begin = (first + np.arange(laps) * result.solved_steps) * result.step
    whole = begin + length <= result.steps * result.step * (1 + 1e-12)
    reached = scene.motion.final_distance
    begins, ends = np.minimum(begin, reached), np.minimum(begin + length, reached)
    times = np.asarray(scene.motion.time(ends) - scene.motion.time(begins))
    rolled = whole & (times > 0)
    speeds: Array = np.divide(ends - begins, times, out=np.zeros(laps), where=rolled)
    return speeds


# ---- marching


def tasks(
    scenes: Sequence[Scene], result: Result, run: int, step_seconds: float
) -> list[pool.Task]:
    """Return the marches that the estimates of runs need next, as tasks of one run.

    Parameters
    ----------
    scenes : sequence of Scene. The scenes of all runs that share the result.
    result : Result. The shared result.
    run : int. Number of the run that the tasks belong to.
    step_seconds : float, s. Expected time of a step of the run.
    """
    needed = {each: scene for scene in scenes for each in missing(scene, result)}
    made = []
    for (first, level), scene in needed.items():
        layout = layout_of(scene, result.stretches)
        assert layout is not None
        step_cost = step_seconds * error_cost.level_cost(scene, level)
        order = simulate.Order.of(result.identity, step_cost)
        arguments = (scene, grid_of(scene, level), first, layout.steps, order)
        made.append(pool.Task(run, march_grid, arguments, layout.steps * step_cost))
    return made


# Side of a cell on each level, in cells of the run.
SIDES = {"tight": 1.0, "fine": 0.5, "coarse": 2.0}


@dataclass(frozen=True)
class Grid:
    """Grid and tolerance on which a stretch is marched.

    name : str. Name of the level.
    side : float. Side of a cell in cells of the run: 1/2, 1 or 2.
    tolerance : float. Tolerance of the march.
    """

    name: str
    side: float
    tolerance: float


def grid_of(scene: Scene, level: str) -> Grid:
    """Return the grid of a level of the error estimate."""
    own = level == "coarse"
    return Grid(level, SIDES[level], scene.tolerance if own else error_cost.tight_tolerance(scene))


def contact_of(scene: Scene, level: str, first: int, steps: int) -> RollingContact:
    """Return the contact of a stretch on a level of the error estimate, as `contact_on`."""
    return contact_on(scene, grid_of(scene, level), first, steps)


def contact_on(scene: Scene, grid: Grid, first: int, steps: int) -> RollingContact:
    """Return the contact of a stretch on a grid, on the patch of surface around it.

    Position 0 of the contact is the first position of the stretch. All grids have the run's number
    of sub-cells per cell.
    """
    whole, surface = rolling_contact(scene), heights(scene)
    # Twice the radius of overlap holds the highest peaks, and a few nodes hold the run-in.
    spacing, side = whole.cell_spacing, grid.side
    margin = math.ceil(
        (2 * cost.overlap_radius(scene, cost.roughness(scene)[0]) + 8 * whole.step) / spacing
    )
    place = whole.position(first)
    row = math.floor(place / spacing) - margin
    rows = math.ceil(steps * whole.step / spacing) + 2 * margin
    if rows >= len(surface):
        row, rows = 0, len(surface)
    rows += rows % 2
    # Flat cells begin where the cells of the run begin, and places count from a centre.
    off_centre = 0.0 if whole.slopes else (side - 1) / 2 * spacing
    return replace(
        whole,
        heights=cells_of_patch(surface, row, rows, side, whole.subcells, whole.slopes),
        spacing=whole.spacing * side,
        start=place - row * spacing - off_centre,
        tolerance=grid.tolerance,
    )


def march_grid(
    scene: Scene,
    grid: Grid,
    first: int,
    steps: int,
    order: simulate.Order,
    stopped: Callable[[], bool],
    progress: Callable[[float], object],
) -> March:
    """March a stretch on a grid; a contact that cannot be solved is a fault of the march.

    Parameters
    ----------
    scene : Scene. A scene without a sweep.
    grid : Grid. Grid and tolerance.
    first, steps : int. First position and number of steps.
    order : Order. Progress of a step, and the surface.
    stopped, progress : callable. As in `simulate.simulate_piece`.

    Raises
    ------
    ContactError : the heights were replaced or removed.
    Interrupted : `stopped` returned true.
    """
    simulate.refuse_other_surface(scene, order.surface_sha256)
    try:
        piece = simulate.simulate_piece(
            _without_events(scene),
            0,
            steps,
            stopped,
            lambda count: progress(count * order.step_cost),
            contact_on(scene, grid, first, steps),
            mapped=False,
        )
    except ContactError as error:
        fault = f"{grid.name}: {error}"
        return March(first, grid.name, np.full(steps, np.nan), math.nan, 0.0, fault)
    return March(
        first,
        grid.name,
        piece.steps["release_energy"],
        float(piece.states["plastic_area"][-steps:].mean()),
        float(piece.steps["step_time"].sum()),
        approach=np.empty(0) if scene.dynamics is None else piece.states["approach"],
    )


def _without_events(scene: Scene) -> Scene:
    """Return a scene that collects no recovery events."""
    recovery = scene.recovery.model_copy(update={"events": False})
    return scene.model_copy(update={"recovery": recovery})
