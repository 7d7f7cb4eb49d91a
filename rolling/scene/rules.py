"""The rules that join the sections of a scene, each with the message for a scene that breaks it."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from acoustics.numbers import rounded
from rolling.contact.track import ROUNDING
from rolling.scene import values_in_si
from rolling.scene.messages import mistake, plain_number, quoted
from rolling.scene.sections import (
    WEIGHT,
    Dynamics,
    Numerics,
    Plate,
    Rolling,
    Sound,
    Sphere,
    refuse_free_factors,
)
from rolling.scene.surfaces import (
    BallHeightFile,
    Gaussian,
    HeightFile,
    SelfAffine,
    Smooth,
    refuse_ball,
)

EDGE_RADII = 10  # contact radii from the contact to the nearest edge of the plate, at least
MAX_MODES = 20_000  # of a plate with edges; a second of sound takes them half a minute
MadeSurfaces = Gaussian | SelfAffine | Smooth
ANY_NODES = 1000  # of a track on which a scene is judged whose length auto takes
MAX_COMPUTED_MODES = 3000  # of a plate with free or clamped edges, which take half a minute

# Sections of a scene that are valid so far, by name; one that has mistakes is missing.
Sections = Mapping[str, Any]


def refuse_rolling(rolling: Rolling, sections: Sections) -> None:
    """Refuse a track without a length, a missing load, and a contact too near an edge."""
    _refuse_length(rolling, sections)
    sphere = sections.get("sphere")
    if sphere is None:
        return
    if sphere.density_kg_m3 is None:
        if rolling.load_n == WEIGHT:
            words = "missing; give it, or sphere.density_kg_m3 for the weight of the sphere"
            if "load_n" in rolling.model_fields_set:
                words = "got weight, which needs sphere.density_kg_m3"
            raise mistake(words, at="rolling.load_n", needs=["sphere.density_kg_m3"])
        if rolling.resistance is not None:
            raise mistake(
                "missing; rolling.resistance needs the mass of the sphere",
                at="sphere.density_kg_m3",
            )
    rest = values_in_si.motion_of(sphere, rolling).rest_time
    duration = rolling.stated_duration_s
    if rolling.resistance and duration and duration > rest * (1 + ROUNDING):
        raise mistake(
            f"the sphere comes to rest after {rounded(rest, 6)} s, rolling.duration_s is"
            f" {plain_number(duration)}: give it more speed, or leave out the duration",
            at="rolling.duration_s",
        )
    plate = sections.get("plate")
    if plate is not None and plate.edges_mm is not None:
        _refuse_edges(rolling, sphere, plate)


def _refuse_length(rolling: Rolling, sections: Sections) -> None:
    """Refuse a length of auto, or none, where the levels of no longer track would be known."""
    surface = sections.get("surface")
    key = rolling.length_key
    if key is None or not isinstance(surface, MadeSurfaces):
        return
    reason = _reason_against_auto(rolling, surface, sections)
    if not reason:
        return
    if getattr(rolling, key) is None:
        raise mistake(
            f"missing; give it or a rolling.distance_mm: auto is not for {reason}",
            at="rolling.duration_s",
            needs=["rolling.distance_mm", "rolling.resistance"],
        )
    raise mistake(f"got auto, which is not for {reason}: give a number", at=f"rolling.{key}")


def _reason_against_auto(rolling: Rolling, surface: MadeSurfaces, sections: Sections) -> str:
    """Return for which kind of scene auto has no length; empty where it has one."""
    sphere = sections.get("sphere")
    plate = sections.get("plate")
    of_ball = None if sphere is None else sphere.surface
    if rolling.falls:
        return "a fall"
    if rolling.resistance or isinstance(rolling.speed_m_s, tuple):
        return "a speed that changes"
    if plate is not None and plate.plasticity == "permanent":
        return "a plate that remembers"
    if surface.faults:
        return "a plate with faults, which come once in a lap of any length"
    if isinstance(of_ball, BallHeightFile):
        return "a made surface below a sphere from a file"
    if surface.law is None and (of_ball is None or of_ball.law is None):
        return "surfaces without random heights"
    return ""


def _refuse_edges(rolling: Rolling, sphere: Sphere, plate: Plate) -> None:
    """Refuse a contact too near an edge of the plate, and more modes than can be moved."""
    assert plate.edges_mm is not None  # asked for by the caller
    load = values_in_si.load(sphere, rolling)
    radius = max(sphere.radius_mm, sphere.radius_across_mm or 0.0) * 1e-3
    contact = (3 * load * radius / (4 * values_in_si.contact_modulus(sphere, plate))) ** (1 / 3)
    least = EDGE_RADII * contact * 1e3
    for key, point in plate.contact_ends_mm.items():
        edge = min(min(x, side - x) for x, side in zip(point, plate.edges_mm, strict=True))
        if edge < least:
            if getattr(plate, key) is None:  # the default point, so the plate is too narrow
                key = "length_mm" if plate.edges_mm[0] < plate.edges_mm[1] else "width_mm"
            raise mistake(
                f"the contact is {rounded(edge)} mm from an edge, allowed: at least"
                f" {rounded(least, 3)}, ten contact radii",
                at=f"plate.{key}",
            )
    refuse_modes(plate, at="plate")


def refuse_modes(plate: Plate, at: str) -> None:
    """Refuse a plate with edges, at a key, that has more modes than can be moved."""
    modes = values_in_si.plate_modes(plate)
    if modes > MAX_MODES:
        raise mistake(
            f"the plate has some {rounded(modes)} modes in hearing, allowed: {MAX_MODES}; choose a"
            " smaller or thicker plate, or leave out its edges where a sphere rolls on it",
            at=f"{at}.length_mm",
        )
    if modes > MAX_COMPUTED_MODES and set(plate.edge_pair) != {"simply_supported"}:
        raise mistake(
            f"the plate has some {rounded(modes)} modes in hearing, allowed: {MAX_COMPUTED_MODES}"
            " with free or clamped edges, whose modes are computed one by one; choose a smaller or"
            " thicker plate, or simply_supported edges",
            at=f"{at}.edges",
        )


def refuse_numerics(numerics: Numerics, sections: Sections) -> None:
    """Refuse a surface of the sphere, and a track, that whole nodes and steps do not hold."""
    surface = sections.get("surface")
    sphere = sections.get("sphere")
    rolling = sections.get("rolling")
    if surface is None or sphere is None:
        return
    if sphere.surface is not None:
        if surface.spacing_um is None:
            raise mistake(
                "missing; the surface of the sphere has the same", at="surface.spacing_um"
            )
        refuse_ball(sphere.surface, sphere.radius_mm, surface.spacing_um)
    if rolling is not None and not isinstance(surface, HeightFile):
        if rolling.length_key is not None:  # what else is wrong shows on any length
            any_length = {"duration_s": None, "distance_mm": ANY_NODES * 1e-3 * surface.spacing_um}
            rolling = rolling.model_copy(update=any_length)
        given = numerics.step_nodes
        step_nodes = 1.0 if isinstance(given, str) else given  # auto keeps the track of one node
        values_in_si.track_of(sphere, surface, rolling, step_nodes, Path())


def refuse_memory(numerics: Numerics, sections: Sections) -> None:
    """Refuse passes without memory, and memory of parts of nodes or of a rough sphere."""
    plate = sections.get("plate")
    sphere = sections.get("sphere")
    rolling = sections.get("rolling")
    if plate is None:
        return
    if plate.plasticity != "permanent":
        if rolling is not None and (rolling.passes or 1) > 1:
            raise mistake(
                f"got {rolling.passes}, which needs plate.plasticity: permanent: without memory all"
                " passes are equal",
                at="rolling.passes",
                needs=["plate.plasticity"],
            )
        return
    if sphere is not None and sphere.surface is not None:
        raise mistake(
            'got "permanent", which only goes with a smooth sphere: each turn of a rough sphere'
            " meets other places of the plate",
            at="plate.plasticity",
        )
    permanent = "allowed with plate.plasticity: permanent"
    if numerics.edges != "sharp":
        raise mistake(
            f'got {quoted(numerics.edges)}, {permanent}: "sharp"; nodes sink as a whole',
            at="numerics.edges",
        )
    if numerics.subcells not in (1, "auto"):
        raise mistake(
            f"got {numerics.subcells}, {permanent}: 1; nodes sink as a whole",
            at="numerics.subcells",
        )
    if numerics.error_estimate:
        raise mistake(
            f"got true, {permanent}: false; its grids have no earlier passes",
            at="numerics.error_estimate",
        )


def refuse_dynamics(dynamics: Dynamics | None, sections: Sections) -> None:
    """Refuse keys that need dynamics without it, and dynamics of bodies without a mass."""
    rolling = sections.get("rolling")
    is_dropped = rolling is not None and rolling.falls
    if dynamics is None:
        _refuse_without_dynamics(sections.get("plate"), is_dropped)
        return
    if dynamics.release and is_dropped:
        raise mistake(
            "got true, which a sphere with rolling.drop_mm has not: nothing is released in flight",
            at="dynamics.release",
        )
    for name in ("sphere", "plate"):
        body = sections.get(name)
        if body is not None and body.density_kg_m3 is None:
            raise mistake(
                f"missing; dynamics needs the mass of the {name}", at=f"{name}.density_kg_m3"
            )


def _refuse_without_dynamics(plate: Plate | None, is_dropped: bool) -> None:
    """Refuse keys that need dynamics."""
    if is_dropped:
        raise mistake(
            "only goes with dynamics; `dynamics: {}` takes its defaults",
            at="rolling.drop_mm",
            needs=["dynamics"],
        )
    if plate is not None and plate.thickness_mm is not None:
        raise mistake(
            "only goes with dynamics: without that section the plate does not bend",
            at="plate.thickness_mm",
            needs=["dynamics"],
        )
    if plate is not None and plate.contact_loss_factor is not None:
        raise mistake(
            "only goes with dynamics: without that section nothing vibrates",
            at="plate.contact_loss_factor",
            needs=["dynamics"],
        )


def with_source(sound: Sound, sections: Sections) -> Sound:
    """Return the sound with its source; refuse a source that the scene has not."""
    sphere = sections.get("sphere")
    if sphere is not None and sound.distance_m <= sphere.radius_mm * 1e-3:
        raise mistake(
            f"got {plain_number(sound.distance_m)}, allowed: more than"
            f" {rounded(sphere.radius_mm * 1e-3, 6)}, the sphere's radius in m: the listener"
            " stands outside the sphere",
            at="sound.distance_m",
        )
    if "dynamics" in sections:
        has_dynamics = sections["dynamics"] is not None
        if sound.source is None:
            source = "vibration" if has_dynamics else "release"
            sound = sound.model_copy(update={"source": source})
            refuse_free_factors(sound)
        elif sound.source == "vibration" and not has_dynamics:
            raise mistake(
                'got "vibration", which needs the section dynamics; `dynamics: {}` takes its'
                " defaults",
                at="sound.source",
                needs=["dynamics"],
            )
    rolling = sections.get("rolling")
    if sound.source == "release" and rolling is not None and rolling.falls:
        raise mistake(
            'got "release", which a sphere with rolling.drop_mm has not: nothing is released in'
            " flight",
            at="sound.source",
        )
    return sound


def refuse_listeners(sound: Sound, sections: Sections) -> None:
    """Refuse listeners of a plate without edges, and listeners inside the sphere."""
    sphere = sections.get("sphere")
    plate = sections.get("plate")
    if sound.listener_mm is None or sphere is None or plate is None:
        return
    if plate.edges_mm is None:
        raise mistake(
            "only goes with plate.length_mm and plate.width_mm: an infinite plate is heard on the"
            " axis, at distance_m",
            at="sound.listener_mm",
            needs=["plate.length_mm", "plate.width_mm"],
        )
    ends = list(plate.contact_ends_mm.values())
    x, y = ends[0]
    to_x, to_y = ends[-1]
    square = (to_x - x) ** 2 + (to_y - y) ** 2
    for at in sound.listener_mm:
        along = (at[0] - x) * (to_x - x) + (at[1] - y) * (to_y - y)
        share = min(max(along / square, 0.0), 1.0) if square else 0.0
        nearest = x + share * (to_x - x), y + share * (to_y - y), sphere.radius_mm
        if math.dist(at, nearest) <= sphere.radius_mm:
            raise mistake(
                f"got {quoted(list(at))}, inside the sphere, allowed: more than its radius from the"
                " middle of the sphere",
                at="sound.listener_mm",
            )
