"""Seeds of a scene: surfaces of the same statistics with other random heights."""

from __future__ import annotations

from typing import Any

from rolling.scene.scene import Scene

SEED_KEYS = ("surface.seed", "sphere.surface.seed")


def seeds_of(scene: Scene) -> dict[str, int]:
    """Return the seeds that a scene has, by their keys."""
    seeds = {}
    for key in SEED_KEYS:
        value: Any = scene
        for name in key.split("."):
            value = getattr(value, name, None)
        if value is not None:
            seeds[key] = int(value)
    return seeds


def with_seed(scene: Scene, seed: int) -> Scene:
    """Return a scene whose surfaces all have a seed; the scene itself if it has none."""
    changes = dict.fromkeys(seeds_of(scene), seed)
    return scene.with_(changes) if changes else scene
