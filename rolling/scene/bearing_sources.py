"""Where the values of a bearing come from, and which of them are assumed."""

from rolling.scene import library
from rolling.scene.bearing_scene import BearingQuantities
from rolling.scene.raceways import BearingBall, Raceway

ASSUMED = "assumed"
USUAL_EXPONENT = 1.0  # of waves around balls and raceways
# Keys whose default is a proportion of usual bearings, or a usual value.
_DEFAULTS = (
    "conformity_inner",
    "conformity_outer",
    "contact_loss_factor",
)
_OF_OIL = (
    "viscosity_100_mm2_s",
    "temperature_c",
    "density_kg_m3",
    "pressure_viscosity_per_gpa",
)
_ESTIMATES = ("bore_mm", "outside_diameter_mm", "width_mm", "ring_mass_kg")


def sources(scene: BearingQuantities) -> dict[str, str]:
    """Return the source of each value that the name of a bearing gave, by key."""
    bearing = scene.bearing
    if bearing.named is None:
        return {}
    table = library.data(library.BEARINGS)
    texts = {}
    for key, pair in (library.bearing_entry(bearing.named) or {}).items():
        if isinstance(pair, list) and getattr(bearing, key, None) == pair[0]:
            texts[key] = str(table["sources"][pair[1]])
    return texts


def static_load_rating_n(scene: BearingQuantities) -> float | None:
    """Return the static load rating [N] of a bearing by name, None for another bearing."""
    named = scene.bearing.named
    entry = None if named is None else library.bearing_entry(named)
    return None if entry is None else float(entry["static_load_rating_n"][0])


def has_assumed_loss_factor(scene: BearingQuantities) -> bool:
    """Tell whether the loss factor of the contacts is assumed."""
    return "contact_loss_factor" in assumed_keys(scene)


def assumed_keys(scene: BearingQuantities) -> list[str]:
    """Return the keys of a bearing whose values are assumed.

    A name gave them without a source, they are defaults, or they are estimated from other values.
    """
    bearing = scene.bearing
    named = sources(scene)
    keys = [key for key, source in named.items() if source.startswith(ASSUMED)]
    fields = type(bearing).model_fields
    for key in _DEFAULTS:
        if key not in named and getattr(bearing, key) == fields[key].default:
            keys.append(key)
    if bearing.contact_angle_deg is None and bearing.radial_clearance_um is None:
        keys.append("radial_clearance_um")  # 0, which a radial load alone allows
    keys += [key for key in _ESTIMATES if getattr(bearing, key) is None]
    if bearing.oil is not None:
        given = bearing.oil.model_fields_set
        keys += [f"oil.{key}" for key in _OF_OIL if key not in given]
    for body in ("balls", "inner", "outer"):
        keys += [f"surfaces.{body}.{key}" for key in assumed_of_surface(scene, body)]
    return keys


def assumed_of_surface(scene: BearingQuantities, body: str) -> list[str]:
    """Return the keys of the surface of balls, inner or outer whose values are assumed.

    They are those that a finish gives without a source, and the usual exponent of waves.
    """
    surface = getattr(scene.bearing.surfaces, body)
    if isinstance(surface, BearingBall) and surface.wave_exponent == USUAL_EXPONENT:
        return ["wave_exponent"]
    if not isinstance(surface, Raceway) or surface.finish is None:
        return []
    pairs = library.entry_of("raceway", surface.finish)
    texts = library.data("finishes")["sources"]
    return [
        key
        for key, (value, source) in pairs.items()
        if getattr(surface, key) == value and texts[source].startswith(ASSUMED)
    ]
