"""Window and time of the steps of a scene, expected before it is run."""

from __future__ import annotations

import math
import os

from rolling.contact import closed_forms
from rolling.scene.scene import Scene
from rolling.scene.sections import Gaussian
from rolling.surface import heights
from rolling.surface.scene_surface import scene_surface

# Overlap of a rough surface beyond that of a smooth one, in rms roughnesses. Fitted to solved
# contacts at Ra 0.01 to 5 um and 1 to 100 N, where it lay between 0.2 (elastic, light) and 2.4
# (plastic, heavy).
RISE = 1.5


def cores() -> int:
    """Return the number of cores that this process may use, the default number of worker processes."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def roughness(scene: Scene) -> tuple[float, float]:
    """Return rms roughness [m] and rms slope of the surface, which need not be made yet.

    The slope is the norm of the gradient over one spacing.

    Raises
    ------
    SceneError
        The height file cannot be used.
    """
    s, spacing = scene.surface, scene.spacing
    if isinstance(s, Gaussian):
        rq = s.roughness_ra_um * 1e-6 * math.sqrt(math.pi / 2)
        decay, exponent = heights.AUTOCORRELATIONS[s.autocorrelation]
        # Mean square of a difference over one spacing: 2 (rq^2 - C(spacing)).
        drops = [
            -math.expm1(-decay * (s.spacing_um / length) ** exponent)
            for length in correlation_lengths(s)
        ]
        return rq, rq * math.sqrt(2 * sum(drops)) / spacing
    if scene.height_path is None:
        return 0.0, 0.0
    statistics = scene_surface(scene).statistics
    return statistics.rq, statistics.rms_slope


def overlap_radius(scene: Scene, rq: float) -> float:
    """Estimate the radius [m] within which the sphere overlaps a surface of rms roughness rq [m].

    It is sqrt(2 R (a^2/R + 1.5 rq)) with the radius R of the sphere and the Hertz radius a.
    """
    approach = closed_forms.hertz_approach(scene.load, scene.radius, scene.contact_modulus)
    if math.isfinite(scene.hardness):
        # Rigid-plastic sinking: the overlap's area times the hardness is the load.
        approach = max(approach, scene.load / (2 * math.pi * scene.radius * scene.hardness))
    return math.sqrt(2 * scene.radius * (approach + RISE * rq))


def window_nodes(scene: Scene, rq: float) -> float:
    """Return the number of nodes along a side of the window, which holds the overlap at both ends
    of a step.
    """
    return 2 * overlap_radius(scene, rq) / scene.spacing + max(1.0, scene.numerics.step_nodes)


def expected_step_ms(window_nodes: float) -> float:
    """Estimate the time of a step [ms] on one core, on a square window of n nodes a side: 1.1
    (n/70)^1.95.

    Measured at tolerance 1e-4, the whole step: 1.1 ms at 70 x 70 nodes, 2.4 ms at 106 x 106, 6.9 ms
    at 180 x 180. Rough surfaces need fewer iterations: at Ra 1 um 9 ms at 230 x 230 (the law says
    11).
    """
    return 1.1 * float((window_nodes / 70) ** 1.95)


def expected_seconds(scene: Scene) -> float:
    """Estimate the time [s] to solve a scene on one core.

    Raises
    ------
    SceneError
        The height file cannot be used.
    """
    return (
        scene.track.solved_steps * expected_step_ms(window_nodes(scene, roughness(scene)[0])) * 1e-3
    )


def correlation_lengths(surface: Gaussian) -> tuple[float, float]:
    """Return the correlation lengths along and across the track [um]."""
    return (
        surface.correlation_length_um,
        surface.correlation_length_across_um or surface.correlation_length_um,
    )
