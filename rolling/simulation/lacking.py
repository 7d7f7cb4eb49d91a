"""Marches that a run lacks beside its own: for its error estimate, and for its force law."""

from __future__ import annotations

from rolling.scene.scene import Scene
from rolling.simulation import error_stretches, force_law, moving_release
from rolling.simulation.result import Result


def lacks_marches(scene: Scene, result: Result) -> bool:
    """Return whether a run lacks steps, stretches of its error estimate, or its force law."""
    return (
        not result.complete
        or bool(error_stretches.missing(scene, result))
        or force_law.is_missing(scene, result)
        or moving_release.is_missing(scene, result)
    )
