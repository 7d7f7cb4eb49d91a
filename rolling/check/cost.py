"""Cost of a run before it is run: window, time of a step, memory and disk."""

import math
import os
from collections.abc import Sequence

from acoustics.numbers import clock
from rolling.contact import closed_forms
from rolling.dynamics import drop
from rolling.in_si.physics_of_scene import bodies_of, smooth_contact_of
from rolling.in_si.scene_surface import scene_surface
from rolling.scene import grid_error
from rolling.scene.scene import Scene
from rolling.surface import refined

# A rough surface overlaps the sphere by this many rms roughnesses more than a smooth surface. The
# value is fitted to solved contacts at Ra 0.01 to 5 um and 1 to 100 N, where it lay between 0.2
# (elastic, light) and 2.4 (plastic, heavy).
RISE = 1.5
# The time of a step grows with this power of the sub-cells along the side of a cell: 2 x 2 took 2.2
# to 3 times as long, 4 x 4 ten times.
SUBCELL_POWER = 1.6
# Longer steps start from less similar pressures. Steps of 2 nodes took 1.1 to 1.4 times as long as
# steps of one, and steps of 4 nodes 1.3 to 2 times (six scenes, Ra 0.1 to 1 um, 2 to 60 N).
STEP_POWER = 1 / 3
LONGEST_STEP = 4.0  # [nodes], up to which this was measured
# A step with its release at tolerance 1e-4 takes c (n/100)^k milliseconds on an overlap of n by n
# nodes, of which the window leaves out up to a quarter. c and k follow the fits of
# tests/benchmarks/step_cost.py, from 40 to 1,000 nodes, with an allowance of 10 to 30 % for
# machines that are not idle. Elastic and yielding plates share a law at sharp edges.
STEP_LAWS = {"smooth": (0.65, 1.45), "sharp": (0.8, 2.3), "blended": (1.2, 2.25)}
# On a smoother surface [m] pressures move with the sphere, and a solve hardly iterates.
SMOOTH = 1e-9
# Share of the positions of a pass with memory that are marched again, as run-in of its pieces.
RUN_IN_SHARE = 0.25

SAMPLE_RATE = 48_000  # [Hz], acoustics.wav.SAMPLE_RATE_HZ, which is slow to import
# Seconds per node and binary logarithm of the nodes (1 to 20 million nodes). Every worker makes a
# random surface and prepares its edges or its 2 x 2 sub-cells; its statistics are taken once.
MAKING = 5.5e-9
EDGES = 2e-9
SUBCELL_HEIGHTS = 9e-9
STATISTICS = 5.5e-9
MOMENTS = 1e-7  # of heights with skewness and kurtosis: 0.3e-7, and 2.5e-7 if there are none such
# Bytes of the program.
ALONE = 300e6
PARENT = 110e6  # beside workers
WORKER = 230e6
# Bytes per node of a rough surface and of the window, and per node and sub-cell.
NODE = 16.0
NODE_SUBCELL = 16.0
NODE_MOMENTS = 84.0  # while heights with skewness and kurtosis are made
WINDOW = 20.0
WINDOW_SUBCELL = 700.0
ESTIMATE = 5.0  # nodes of the windows of an error estimate over those of the window
# Bytes of a record while its sound is made, and as long as runs are compared.
STEP = 650.0
SAMPLE = 280.0
TIME_STEP = 300.0  # of a motion
EVENT = 300.0  # recovery event
STEP_COMPARED = 60.0
SAMPLE_COMPARED = 16.0
EVENTS_PER_NODE = 0.6  # approximate recovery events of a node that the contact passes over
TIME_STEPS = 40.0  # of a motion in a period of the resonance
# Bytes on disk: of a run, with 5 s of listen.wav, and per step, sample and event of it.
RUN_FILES = 1.7e6
STEP_FILE = 110.0
SAMPLE_FILE = 20.0
CHANNEL_FILE = 12  # of each sample of a channel, in result.h5 and as a WAV
EVENT_FILE = 41.0


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
    """Estimate the reach [m] along the track of the overlap with a surface of rms height rq [m].

    It is sqrt(2 R (a^2/R + 1.5 rq)) with the radius R of the sphere and the Hertz radius a.
    """
    radius = smooth_contact_of(scene).equivalent_radius_m
    approach = closed_forms.hertz_approach(scene.load, radius, scene.contact_modulus)
    if math.isfinite(scene.hardness):
        # In rigid-plastic sinking the area of overlap times the hardness equals the load.
        radius = math.sqrt(scene.radius * scene.radius_across)
        approach = max(approach, scene.load / (2 * math.pi * radius * scene.hardness))
    return math.sqrt(2 * scene.radius * (approach + RISE * rq))


def overlap_width(scene: Scene, rq: float) -> float:
    """Estimate the reach [m] across the track of the overlap with rms heights rq [m]."""
    return overlap_radius(scene, rq) * math.sqrt(scene.radius_across / scene.radius)


def window_nodes(scene: Scene, rq: float) -> float:
    """Estimate the nodes along the side of a square of the area of the overlap, at both ends.

    The window is up to 15 % narrower (see `RollingContact.overlap`).
    """
    side = math.sqrt(overlap_radius(scene, rq) * overlap_width(scene, rq))
    return 2 * side / scene.spacing + max(1.0, scene.step_nodes)


def subcells(scene: Scene) -> int:
    """Estimate the sub-cells along the side of a cell; a height file is read."""
    if scene.numerics.subcells != "auto" or not scene.height_paths:
        return grid_error.law_subcells(scene)
    if not grid_error.has_blended_edges(scene):
        return 1
    step = refined.median_step(scene_surface(scene).heights)
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


def step_ms(scene: Scene) -> float:
    """Estimate the time of a step of a scene [ms] on one core; a height file is read."""
    rq = roughness(scene)[0]
    longer = math.pow(min(max(scene.step_nodes, 1.0), LONGEST_STEP), STEP_POWER)
    own_ms = expected_step_ms(window_nodes(scene, rq), subcells(scene), step_law(scene, rq))
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


def bounce_hz(scene: Scene) -> float:
    """Return the natural frequency [Hz] of the free ball on its contact, sqrt(2 E* a / m) / 2 pi.

    The mass belongs to a free ball, and the stiffness 2 E* a to the smooth elastic contact with the
    Hertz radius a, whether the plate yields or not.
    """
    return math.sqrt(smooth_contact_of(scene).stiffness_n_m / scene.mass) / (2 * math.pi)


def shortest_period(scene: Scene) -> float:
    """Return the length or width [m] of the surface, whichever is less."""
    return min(scene.track.n_along, scene.track.n_across) * scene.spacing


def fall_seconds(scene: Scene) -> tuple[int, float]:
    """Estimate number and time [s] of the marches for the impacts of a drop; none without one."""
    if scene.rolling.drop_mm is None:
        return 0, 0.0
    period = shortest_period(scene)
    loads = [load for sign in (-1, 1) for load in drop.loads(bodies_of(scene), sign)]
    held = [load for load in loads if 2 * max(smooth_contact_of(scene).semi_axes_m(load)) <= period]
    # Another load would roll out elsewhere.
    heavier = [scene.with_({"rolling.load_n": x, "rolling.resistance": None}) for x in held]
    return len(held), scene.track.solved_steps * sum(map(step_ms, heavier)) * 1e-3


def surface_seconds(scene: Scene) -> tuple[float, float]:
    """Estimate the times [s] for a random surface in each worker, and then beside the workers."""
    if not scene.laws:
        return 0.0, 0.0
    making = MAKING
    edges = 0.0
    if _has_moments(scene):
        making += MOMENTS
    if grid_error.has_blended_edges(scene):
        side = subcells(scene)
        edges = EDGES if side == 1 else SUBCELL_HEIGHTS * (side / 2) ** 2
    nodes = surface_nodes(scene)
    counted = nodes * math.log2(nodes)
    return counted * (making + edges), counted * (making + STATISTICS)


def _has_moments(scene: Scene) -> bool:
    """Tell whether random heights of plate or sphere are not Gaussian."""
    return not all(law.is_gaussian for law in scene.laws)


def surface_nodes(scene: Scene) -> int:
    """Return the nodes of the surface and of a turn of a sphere that has a surface."""
    track = scene.track
    return (track.n_along + track.turn_nodes) * track.n_across


# ---- memory and disk


def memory(scenes: Sequence[Scene], workers: int) -> dict[str, float]:
    """Estimate the memory [bytes] that runs take in workers, by its largest parts.

    Each worker holds the program, a surface and a window; the sound of one run is made at a time,
    and a part of each record stays until all runs are compared. Numbers of nodes and steps decide,
    and a height file is judged by its header.
    """
    compared = [
        STEP_COMPARED * scene.track.steps + SAMPLE_COMPARED * _samples(scene) for scene in scenes
    ]
    return {
        "surface": workers * max(_surface_memory(scene) for scene in scenes),
        "window": workers * max(_window_memory(scene) for scene in scenes),
        "record": max(_record(scene) for scene in scenes) + sum(compared) - max(compared),
        "program": ALONE if workers == 1 else PARENT + WORKER * workers,
    }


def _surface_memory(scene: Scene) -> float:
    """Estimate the bytes of the heights of a scene, and four times those of its passes."""
    side = grid_error.law_subcells(scene)
    per_node = NODE + NODE_SUBCELL * side**2
    if _has_moments(scene):
        per_node += NODE_MOMENTS
    heights = 0.0 if scene.is_smooth else per_node * surface_nodes(scene)
    return heights + 4 * _passes(scene)


def _window_memory(scene: Scene) -> float:
    """Estimate the bytes of a window, and of those of an error estimate."""
    track = scene.track
    rq = 0.0
    if not scene.height_paths:
        rq, _ = grid_error.law_roughness(scene)
    nodes = min(window_nodes(scene, rq), 2.0 * max(track.n_along, track.n_across)) ** 2
    size = (WINDOW + WINDOW_SUBCELL * grid_error.law_subcells(scene) ** 2) * nodes
    if scene.numerics.error_estimate or getattr(scene.surface, "instrument", None) is not None:
        size *= ESTIMATE
    return size


def disk(scenes: Sequence[Scene]) -> float:
    """Estimate the size [bytes] of the files of runs."""
    size = 0.0
    for scene in scenes:
        size += RUN_FILES + STEP_FILE * scene.track.steps + SAMPLE_FILE * _samples(scene)
        size += EVENT_FILE * _events(scene) + _passes(scene)
        size += CHANNEL_FILE * len(scene.sound.channels or ()) * _samples(scene)
    return size


def _passes(scene: Scene) -> float:
    """Return the bytes of the passes and the sunk surface of a plate with memory."""
    track = scene.track
    if not scene.is_permanent:
        return 0.0
    return 8.0 * (3 * scene.passes * track.solved_steps + track.n_along * track.n_across)


def _record(scene: Scene) -> float:
    """Estimate the memory [bytes] while the sound of a run is made."""
    samples = _samples(scene)
    motion = scene.motion
    duration = scene.duration
    if not motion.is_constant(duration):  # the power is oversampled
        samples += samples * 0.25 * motion.fastest(duration) / scene.step / SAMPLE_RATE
    time_steps = 0.0
    if scene.dynamics is not None:
        time_steps = duration * motion_rate(scene)
    steps = STEP * scene.track.steps + TIME_STEP * time_steps
    return steps + SAMPLE * samples + EVENT * _events(scene)


def motion_rate(scene: Scene) -> float:
    """Estimate the time steps of a motion per second."""
    rate = max(TIME_STEPS * bounce_hz(scene), scene.motion.fastest(scene.duration) / scene.step)
    if scene.rolling.drop_mm is not None:
        rate = max(rate, drop.IMPACT_STEPS / drop.impact_s(bodies_of(scene)))
    return rate


def _samples(scene: Scene) -> float:
    return scene.duration * SAMPLE_RATE


def _events(scene: Scene) -> float:
    """Estimate the number of recovery events of a run, 0 where none are recorded."""
    if not scene.recovery.events:
        return 0.0
    across = 2 * overlap_width(scene, 0.0) / scene.spacing
    across = min(across, scene.track.n_along, scene.track.n_across)
    return EVENTS_PER_NODE * across * scene.track.solved_steps * scene.step_nodes
