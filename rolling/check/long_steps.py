"""Steps against the width of the contact: the release that long steps lose, and their refusal.

The release of a step is the mean pressure at its ends times the fall between them. It is
accurate to second order in the step, and wrong as soon as the contacts at both ends have little in
common.
"""

from __future__ import annotations

import math

import numpy as np

from rolling.check.finding import sentence
from rolling.dynamics import of_scene
from rolling.scene.messages import SceneError
from rolling.scene.scene import Scene
from rolling.scene.sections import STEP_NODES
from rolling.scene.sweep import run_name

DOUBTFUL_RADII = 0.25  # step over contact radius, above which a scene gets a warning
MAX_RADII = 4.0  # step over contact radius, above which half of the release is lost

# A smooth elastic sphere, marched at 32 nodes per radius, loses these shares of the release. Rough
# and yielding contacts are wider than the radius and lose the same within 0.02, or less (twelve
# scenes, 5 to 100 N, Ra 0 to 1 um, elastic and down to 0.7 GPa).
_RADII = (0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0)
_LOST = (0.0, 0.0045, 0.0167, 0.0368, 0.0644, 0.1393, 0.2347, 0.3344, 0.4177, 0.5383)
# The error of the level up to the Nyquist frequency of the steps stays below this bound [dB per
# radius], which is read from the ten rough scenes among the twelve.
LEVEL_ERROR_DB = 3.0


def contact_radius(scene: Scene) -> float:
    """Return the larger of the elastic and the fully plastic radius [m] of a smooth contact."""
    elastic = of_scene.hertz_radius(scene)
    return max(elastic, math.sqrt(scene.load / (math.pi * scene.hardness)))


def lost_release(radii: float) -> float:
    """Estimate the share of the mean release that steps of so many contact radii lose."""
    return float(np.interp(radii, _RADII, _LOST))


def refuse_long_steps(scene: Scene) -> None:
    """Raise SceneError for the runs of a scene with steps longer than `MAX_RADII` contact radii."""
    faults = []
    for values, run in scene.runs():
        radius = contact_radius(run)
        if run.step > MAX_RADII * radius:
            fault = f"{scene.place('numerics.step_nodes')}: {_fault(run, radius)}"
            faults.append(
                f"{fault} (in the run {run_name(values)} of the sweep)" if values else fault
            )
    if faults:
        raise SceneError(faults)


def _fault(scene: Scene, radius: float) -> str:
    """Write the length of the steps, the longest that are allowed, and the nearest number."""
    longest = MAX_RADII * radius
    fitting = [nodes for nodes in STEP_NODES if nodes * scene.spacing <= longest]
    advice = sentence("refused", "spacing", longest_um=longest * 1e6)
    if fitting:
        advice = sentence("refused", "nodes", nodes=max(fitting))
    numbers = {"nodes": scene.numerics.step_nodes, "step": scene.step, "longest": longest}
    numbers |= {"radii": scene.step / radius, "radius_um": radius * 1e6, "most": MAX_RADII}
    return sentence("refused", "long_steps", advice=advice, **numbers)
