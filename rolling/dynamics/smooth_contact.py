"""Contact of the smooth elastic sphere of a scene, elliptic where its radii differ."""

from rolling.contact import closed_forms
from rolling.scene.scene import Scene


def equivalent_radius(scene: Scene) -> float:
    """Return the radius [m] of the sphere with the stiffness of the contact at any load."""
    return closed_forms.hertz_ellipse(scene.radius, scene.radius_across)[0]


def semi_axes(scene: Scene, load: float | None = None) -> tuple[float, float]:
    """Return the semi-axes [m] of the contact along and across the track, at the scene's load."""
    radius, along, across = closed_forms.hertz_ellipse(scene.radius, scene.radius_across)
    load = scene.load if load is None else load
    contact = closed_forms.hertz_radius(load, radius, scene.contact_modulus)
    return contact * along, contact * across


def maximum_pressure(scene: Scene, load: float | None = None) -> float:
    """Return the maximum pressure [Pa] of the contact, at the scene's load."""
    radius, along, across = closed_forms.hertz_ellipse(scene.radius, scene.radius_across)
    load = scene.load if load is None else load
    return closed_forms.hertz_pressure(load, radius, scene.contact_modulus) / (along * across)
