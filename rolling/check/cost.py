"""Window and time of the steps of a scene, estimated before it is run."""

from __future__ import annotations

import math
import os

from rolling.contact import closed_forms
from rolling.scene.scene import Scene
from rolling.scene.surfaces import Gaussian
from rolling.surface import heights, refined
from rolling.surface.scene_surface import scene_surface

# A rough surface overlaps the sphere by this many rms roughnesses more than a smooth surface. The
# value is fitted to solved contacts at Ra 0.01 to 5 um and 1 to 100 N, where it lay between 0.2
# (elastic, light) and 2.4 (plastic, heavy).
RISE = 1.5
# The time of a step grows with this power of the sub-cells along the side of a cell: 2 x 2 took 2.2
# to 3 times as long, 4 x 4 ten times.
SUBCELL_POWER = 1.6
# A step with its release at tolerance 1e-4 takes c (n/100)^k milliseconds on a window of n by n
# nodes. c and k follow the fits of tests/benchmarks/step_cost.py, from 40 to 1,000 nodes, with an
# allowance of 10 to 30 % for machines that are not idle. Elastic and yielding plates share a law at
# sharp edges.
STEP_LAWS = {"smooth": (0.65, 1.45), "sharp": (0.8, 2.3), "blended": (1.2, 2.25)}
# On a smoother surface [m] pressures move with the sphere, and a solve hardly iterates.
SMOOTH = 1e-9
# Generated heights are a little more or less steep than their law.
SLOPE_MARGIN = 1.05


def cores() -> int:
    """Return the number of cores that this process may use.

    It is the default number of worker processes.
    """
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def roughness(scene: Scene) -> tuple[float, float]:
    """Estimate rms roughness [m] and rms slope of the surface without making random heights.

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
        # The mean square of a difference over one spacing is 2 (rq^2 - C(spacing)).
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
    """Estimate the radius [m] within which the sphere overlaps a rough surface.

    It is sqrt(2 R (a^2/R + 1.5 rq)) with the radius R of the sphere, the Hertz radius a and the rms
    roughness rq [m] of the surface.
    """
    approach = closed_forms.hertz_approach(scene.load, scene.radius, scene.contact_modulus)
    if math.isfinite(scene.hardness):
        # In rigid-plastic sinking the area of overlap times the hardness equals the load.
        approach = max(approach, scene.load / (2 * math.pi * scene.radius * scene.hardness))
    return math.sqrt(2 * scene.radius * (approach + RISE * rq))


def window_nodes(scene: Scene, rq: float) -> float:
    """Estimate the number of nodes along a side of the window.

    The window holds the overlap at both ends of a step.
    """
    return 2 * overlap_radius(scene, rq) / scene.spacing + max(1.0, scene.numerics.step_nodes)


def subcells(scene: Scene, is_read: bool = True) -> int:
    """Estimate the sub-cells along the side of a cell of a run, without making random heights.

    Parameters
    ----------
    is_read : bool
        If false, a height file is not read, and counts as gentle. Default: true.

    Raises
    ------
    SceneError
        The height file cannot be used.
    """
    chosen = scene.numerics.subcells
    if chosen != "auto":
        return chosen
    if not has_blended_edges(scene) or not (is_read or scene.height_path is None):
        return 1
    if scene.height_path is None:
        slope = SLOPE_MARGIN * roughness(scene)[1]
    else:
        step = refined.median_step(scene_surface(scene).heights)
        slope = refined.rms_slope(step, scene.spacing)
    return refined.auto_subcells(slope, scene.contact_modulus, scene.hardness)


def has_blended_edges(scene: Scene) -> bool:
    """Tell whether the edges of yielding patches are blended."""
    return scene.numerics.edges == "blended" and math.isfinite(scene.hardness)


def step_law(scene: Scene, rq: float) -> str:
    """Return the key of STEP_LAWS of a scene whose surface has an rms roughness of rq [m]."""
    if rq < SMOOTH:
        return "smooth"
    return "blended" if has_blended_edges(scene) else "sharp"


def expected_step_ms(window_nodes: float, subcells: int = 1, law: str = "sharp") -> float:
    """Estimate the time of a step [ms] on one core, by a law of STEP_LAWS.

    It is c (n/100)^k on a square window with n nodes along a side, times r^1.6 with r sub-cells
    along the side of a cell.
    """
    at_100, power = STEP_LAWS[law]
    return float(at_100 * (window_nodes / 100) ** power * subcells**SUBCELL_POWER)


def expected_seconds(scene: Scene) -> float:
    """Estimate the time [s] to solve a scene on one core.

    Raises
    ------
    SceneError
        The height file cannot be used.
    """
    rq = roughness(scene)[0]
    law = step_law(scene, rq)
    step_ms = expected_step_ms(window_nodes(scene, rq), subcells(scene), law)
    return scene.track.solved_steps * step_ms * 1e-3


def correlation_lengths(surface: Gaussian) -> tuple[float, float]:
    """Return the correlation lengths along and across the track [um]."""
    return (
        surface.correlation_length_um,
        surface.correlation_length_across_um or surface.correlation_length_um,
    )
