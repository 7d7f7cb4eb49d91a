"""What the scene of a bearing does otherwise than ISO 15242 asks for."""

from acoustics.numbers import rounded
from rolling.bearing import iso_15242
from rolling.scene.bearing_scene import BearingScene

# Of the mass that a ring has by its dimensions. Up to it, a given mass is that of the ring alone.
_FIXED_SHARE = 0.2


def departures(scene: BearingScene) -> list[str]:
    """Return what a scene does otherwise than ISO 15242 asks for, in words; empty for none.

    The standard measures a ring that nothing is fixed to. Its loads are those of deep-groove
    bearings, and one that is described by a large contact angle may be another.
    """
    bearing = scene.bearing
    texts = iso_15242.departures(
        turning=bearing.turning,
        speed_rpm=bearing.speed_rpm,
        axial_load_n=scene.axial_load,
        radial_load_n=scene.radial_load,
        outer_diameter_mm=1e3 * scene.outside_diameter,
    )
    angle_deg = bearing.contact_angle_deg
    if bearing.named is None and angle_deg is not None and angle_deg >= iso_15242.ANGULAR_DEG:
        texts.append(
            f"a contact angle of {rounded(angle_deg, 3)} degrees, where the loads are quoted for"
            " deep-groove bearings"
        )
    own_kg = scene.ring_bending.mass_kg
    fixed_kg = scene.ring_mass - own_kg
    if fixed_kg > _FIXED_SHARE * own_kg:
        texts.append(f"{rounded(fixed_kg, 2)} kg fixed to the ring that is measured")
    return texts
