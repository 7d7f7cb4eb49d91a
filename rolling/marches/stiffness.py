"""Stiffness of the contact from solved positions, for the vibration that a run leaves out.

A smooth contact is up to three times as stiff as a rough one. Some positions of the track are
solved at a second load, and the approach between both loads has the stiffness in it.
tests/benchmarks/vibration_estimate_study.py compares it with the force laws of runs.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from acoustics.arrays import Array
from rolling.contact import closed_forms
from rolling.contact.march import march
from rolling.contact.solver import ContactError
from rolling.contact.subcells import half_space_of
from rolling.dynamics.force_law import MIN_SLOPE
from rolling.in_si.contact_of_scene import rolling_contact
from rolling.in_si.physics_of_scene import smooth_contact_of
from rolling.in_si.scene_surface import heights
from rolling.marches.result import Result
from rolling.scene.scene import Scene

LOWER = 0.8  # second load over the load of the scene
MIN_POSITIONS = 4  # at the second load
MAX_POSITIONS = 12
STEPS_EACH = 50  # of the track for a position, whose cold start costs some eight steps


def solved_stiffness(scene: Scene, result: Result) -> Array:
    """Return the contact stiffness [N/m] at some positions of a run, at the load of the scene.

    The secant between two loads belongs to their geometric mean, and the stiffness of a Hertz
    contact grows with the cube root of the load. The approach rises by a share of Hertz's at least,
    as in a force law. The stiffness of a smooth contact stands for all where the lower load has no
    solution.
    """
    left = None
    if result.passes is not None:
        left = result.heights_after_passes(heights(scene))
    contact = replace(rolling_contact(scene, left), load=LOWER * scene.load)
    half_space = half_space_of(contact.spacing, contact.contact_modulus, contact.subcells)
    steps = result.solved_steps
    count = max(MIN_POSITIONS, min(MAX_POSITIONS, steps // STEPS_EACH))
    falls = []
    try:
        for place in sorted({k * steps // count for k in range(count)}):
            (state,) = march(contact, place, place, half_space)
            falls.append(result.series["approach"][place] - state.approach)
    except ContactError:
        return np.array([smooth_contact_of(scene).stiffness_n_m])
    radius = smooth_contact_of(scene).equivalent_radius_m
    upper = closed_forms.hertz_approach(scene.load, radius, scene.contact_modulus)
    lower = closed_forms.hertz_approach(contact.load, radius, scene.contact_modulus)
    secants = (1 - LOWER) * scene.load / np.maximum(falls, MIN_SLOPE * (upper - lower))
    return np.asarray(secants * LOWER ** (-1 / 6))
