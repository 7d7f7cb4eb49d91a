"""Highest summit that a surface may have, and whether a contact surely ends before its edge."""

from __future__ import annotations

import math

from rolling.check import cost
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.scene.scene import Scene

# Heights over their rms, above which no summit of a Gaussian or another law is expected.
GAUSSIAN_SUMMIT = 6.0
OTHER_SUMMIT = 10.0


def is_surely_wide_enough(scene: Scene) -> bool:
    """Tell whether the highest summit that a law may have lies too low beside the contact."""
    if scene.is_smooth:
        return True
    is_gaussian = bool(scene.laws) and all(law.is_gaussian for law in scene.laws)
    summit = GAUSSIAN_SUMMIT if is_gaussian else OTHER_SUMMIT
    highest = hertz_approach(scene) + summit * cost.roughness(scene)[0]
    highest += 1e-6 * max((fault.rises_um for fault in scene.faults), default=0.0)
    along = 2 * math.sqrt(2 * scene.radius * highest)
    across = 2 * math.sqrt(2 * scene.radius_across * highest)
    track = scene.track
    return along <= track.n_along * track.spacing and across <= track.n_across * track.spacing


def hertz_approach(scene: Scene) -> float:
    """Return the approach of the smooth elastic contact [m]."""
    return smooth_contact_of(scene).approach_m()
