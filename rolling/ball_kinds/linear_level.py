"""Change of the level of a ball on a plate by its linear response, for a drawing; no march.

The contact averages the heights, asperities that take the load from each other add to the approach
of short waves, and ball, contact and plate are a linear chain. The level itself is rough, and its
change by a value of the drawing is much better.

How good it is was measured on changes that were also marched: 10 % more of a value on three scenes
(`tests/benchmarks/linear_change_study.py`), and larger steps (`tests/benchmarks/choice_study.py`).
ERRORS has the root mean square of the relative errors. Heights act in proportion in the linear
response, and by half as much in marches, because the highest asperities take the load alone.
Correlation lengths and skewness are left out: there the linear response was wrong by more than the
change.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from acoustics.level import level_db
from acoustics.weighting import a_weighting_db
from rolling.ball_kinds.linear_response import linear_response
from rolling.in_si.length_rule import expected_vibration, numbers_of
from rolling.in_si.scene_surface import scene_surface
from rolling.scene import grid_error
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile

USUAL_ERROR = 0.2  # of a change, relative
HEIGHTS_ERROR = 0.5
ERRORS: Mapping[str, float] = MappingProxyType(  # of other values
    {
        "rolling.load_n": 0.4,
        "surface.roughness_ra_um": HEIGHTS_ERROR,
        "surface.rq_um": HEIGHTS_ERROR,
        "surface.rdq": HEIGHTS_ERROR,
        "sphere.surface.roughness_ra_um": HEIGHTS_ERROR,
    }
)
LEAST_DB = 0.1  # error of each change
WITHOUT = (  # keys for which the linear response does not hold
    "surface.correlation_length_um",
    "surface.correlation_length_across_um",
    "sphere.surface.correlation_length_um",
    "surface.rolloff_um",
    "surface.shortest_um",
    "surface.skewness",
    "sphere.surface.skewness",
)


def linear_change_db(base: Scene, changed: Scene) -> float | None:
    """Return how much louder [dB] a changed scene is by its linear response; None without one.

    A ball that falls, a smooth contact and a scan under a ball with a surface of its own have none.
    Both contacts are as wide as the roughness of the base makes them.

    Raises
    ------
    SceneError : a surface cannot be read.
    """
    rq_m = _roughness_m(base)
    if rq_m is None:
        return None
    levels = [level_db(mean_square(scene, rq_m)) for scene in (base, changed)]
    if levels[0] is None or levels[1] is None:
        return None
    return levels[1] - levels[0]


def error_db(key: str, change_db: float) -> float | None:
    """Return the standard uncertainty [dB] of a change by a key; None where it does not hold."""
    if key in WITHOUT:
        return None
    return math.hypot(LEAST_DB, ERRORS.get(key, USUAL_ERROR) * change_db)


def _roughness_m(scene: Scene) -> float | None:
    """Return the rms roughness [m] of a scene; None where it has no linear response."""
    if scene.is_one_event or scene.is_smooth:
        return None
    if isinstance(scene.surface, HeightFile):
        if scene.sphere.surface is not None:
            return None
        return float(np.std(scene_surface(scene).heights))
    return grid_error.law_roughness(scene)[0] if scene.laws else None


def mean_square(scene: Scene, rq_m: float) -> float:
    """Return the A-weighted mean square [Pa2] of a scene, for the axes of a rough contact."""
    response = linear_response(scene, rq_m)
    if isinstance(scene.surface, HeightFile):
        surface = scene_surface(scene)
        return response.mean_square(surface.heights, surface.spacing)
    numbers = numbers_of(scene)._replace(semi_axes_m=response.semi_axes_m)
    expected = expected_vibration(numbers)
    weights = 10 ** (a_weighting_db(expected.frequency_hz) / 10)
    return float(np.trapezoid(expected.density * weights, expected.frequency_hz))
