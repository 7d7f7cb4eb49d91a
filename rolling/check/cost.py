"""Time of a run before it is run: roughness, window, and the time of a step on one core."""

import math
import os
from dataclasses import replace

from acoustics.numbers import clock
from rolling.contact import estimated_contact
from rolling.dynamics import drop
from rolling.in_si.physics_of_scene import bodies_of, smooth_contact_of
from rolling.in_si.scene_surface import scene_surface
from rolling.scene import grid_error
from rolling.scene.scene import Scene
from rolling.surface import refined

# The time of a step grows with this power of the sub-cells along the side of a cell: 2 x 2 took 2.2
# to 3 times as long, 4 x 4 ten times.
SUBCELL_POWER = 1.6
# Longer steps start from less similar pressures. Steps of 2 nodes took 1.1 to 1.4 times as long as
# steps of one, and steps of 4 nodes 1.3 to 2 times (six scenes, Ra 0.1 to 1 um, 2 to 60 N).
STEP_POWER = 1 / 3
LONGEST_STEP = 4.0  # [nodes], up to which this was measured
# A step with its release at tolerance 1e-4 takes c (n/100)^k milliseconds on an overlap of n by n
# nodes, of which the window leaves out up to a quarter. c and k follow the times and widths that
# tests/benchmarks/step_cost.py measures, from 40 to 1,000 nodes, with an allowance of 10 to 30 %
# for machines that are not idle. Elastic and yielding plates share a law at sharp edges.
STEP_LAWS = {"smooth": (0.65, 1.45), "sharp": (0.8, 2.3), "blended": (1.2, 2.25)}
# On a smoother surface [m] pressures move with the sphere, and a solve hardly iterates.
SMOOTH = 1e-9
# Share of the positions of a pass with memory that are marched again, as run-in of its pieces.
RUN_IN_SHARE = 0.25

# Seconds per node and binary logarithm of the nodes (1 to 20 million nodes). Every worker makes a
# random surface and prepares its edges or its 2 x 2 sub-cells; its statistics are taken once.
MAKING = 5.5e-9
EDGES = 2e-9
SUBCELL_HEIGHTS = 9e-9
STATISTICS = 5.5e-9
MOMENTS = 1e-7  # of heights with skewness and kurtosis: 0.3e-7, and 2.5e-7 if there are none such


def cores() -> int:
    """Return the number of cores that this process may use, the default number of workers."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def computing(core_seconds: float) -> str:
    """Write the time that a computation of one core [s] takes on all cores."""
    count = cores()
    noun = "core" if count == 1 else "cores"
    return f"about {clock(core_seconds / count)} on {count} {noun}"


# ---- window and time


def roughness(scene: Scene) -> tuple[float, float]:
    """Estimate rms roughness [m] and rms slope [-] without making random heights.

    The slope is the norm of the gradient over one spacing. A height file is read, or SceneError
    is raised.
    """
    if scene.height_paths:
        statistics = scene_surface(scene).statistics
        return statistics.rq, statistics.rms_slope
    return grid_error.law_roughness(scene)


def overlap_radius(scene: Scene, rq: float) -> float:
    """Estimate the reach [m] along the track of the overlap with a surface of rms height rq [m]."""
    return estimated_contact.overlap_along_m(smooth_contact_of(scene), scene.hardness, rq)


def overlap_width(scene: Scene, rq: float) -> float:
    """Estimate the reach [m] across the track of the overlap with rms heights rq [m]."""
    return estimated_contact.overlap_across_m(smooth_contact_of(scene), scene.hardness, rq)


def window_nodes(scene: Scene, rq: float, load_n: float | None = None) -> float:
    """Estimate the nodes along the side of a square of the area of the overlap, at both ends.

    The load [N] is by default that of the scene.
    """
    contact = smooth_contact_of(scene)
    if load_n is not None:
        contact = replace(contact, load_n=load_n)
    return estimated_contact.window_nodes(
        contact, scene.hardness, rq, scene.spacing, scene.step_nodes
    )


def subcells(scene: Scene) -> int:
    """Estimate the sub-cells along the side of a cell; a height file is read."""
    if scene.numerics.subcells != "auto" or not scene.height_paths:
        return grid_error.law_subcells(scene)
    if not grid_error.has_blended_edges(scene):
        return 1
    step = scene_surface(scene).median_step
    slope = refined.rms_slope(step, scene.spacing)
    return refined.auto_subcells(slope, scene.contact_modulus, scene.hardness)


def step_law(scene: Scene, rq: float) -> str:
    """Return the key of STEP_LAWS of a scene whose surface has an rms roughness of rq [m]."""
    if rq < SMOOTH:
        return "smooth"
    return "blended" if grid_error.has_blended_edges(scene) else "sharp"


def expected_step_ms(window_nodes: float, subcells: int = 1, law: str = "sharp") -> float:
    """Estimate the time of a step [ms] on one core, by a law of STEP_LAWS."""
    at_100, power = STEP_LAWS[law]
    return float(at_100 * (window_nodes / 100) ** power * subcells**SUBCELL_POWER)


def step_ms(scene: Scene, load_n: float | None = None) -> float:
    """Estimate the time of a step of a scene [ms] on one core; a height file is read.

    The load [N] is by default that of the scene.
    """
    rq = roughness(scene)[0]
    longer = math.pow(min(max(scene.step_nodes, 1.0), LONGEST_STEP), STEP_POWER)
    nodes = window_nodes(scene, rq, load_n)
    own_ms = expected_step_ms(nodes, subcells(scene), step_law(scene, rq))
    return own_ms * longer


def lap_seconds(scene: Scene) -> float:
    """Estimate the time [s] to march a track once on one core; a height file is read."""
    return scene.track.solved_steps * step_ms(scene) * 1e-3


def expected_seconds(scene: Scene) -> float:
    """Estimate the time [s] to march all passes of a scene on one core; a height file is read."""
    seconds = lap_seconds(scene)
    if scene.is_permanent:
        seconds *= scene.passes * (1 + RUN_IN_SHARE)
    return seconds


def shortest_period(scene: Scene) -> float:
    """Return the length or width [m] of the surface, whichever is less."""
    return min(scene.track.n_along, scene.track.n_across) * scene.spacing


def fall_seconds(scene: Scene) -> tuple[int, float]:
    """Estimate number and time [s] of the marches for the impacts of a drop; none without one."""
    if scene.keeps_its_load:
        return 0, 0.0
    period = shortest_period(scene)
    bodies = bodies_of(scene)
    loads = [load for sign in (-1, 1) for load in drop.loads(bodies, sign)]
    held = [load for load in loads if 2 * max(bodies.contact.semi_axes_m(load)) <= period]
    all_ms = sum(step_ms(scene, load) for load in held)
    return len(held), scene.track.solved_steps * all_ms * 1e-3


def surface_seconds(scene: Scene) -> tuple[float, float]:
    """Estimate the times [s] for a random surface in each worker, and then beside the workers."""
    if not scene.laws:
        return 0.0, 0.0
    making = MAKING
    edges = 0.0
    if scene.has_moments:
        making += MOMENTS
    if grid_error.has_blended_edges(scene):
        side = subcells(scene)
        edges = EDGES if side == 1 else SUBCELL_HEIGHTS * (side / 2) ** 2
    nodes = scene.track.surface_nodes
    counted = nodes * math.log2(nodes)
    return counted * (making + edges), counted * (making + STATISTICS)
