"""Callers of the room of sound that still hand a scene to the smooth contact."""

from rolling.ball.bodies_of_scene import smooth_contact_of
from rolling.scene.scene import Scene


def semi_axes(scene: Scene) -> tuple[float, float]:
    """Return the semi-axes [m] of the contact along and across the track, at the scene's load."""
    return smooth_contact_of(scene).semi_axes_m()
