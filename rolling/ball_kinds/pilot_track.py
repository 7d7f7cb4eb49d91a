"""The pilot of a ball: a short track of its own, whose level is known soon and with a wide ±."""

from __future__ import annotations

import math

from rolling.check import cost
from rolling.kinds.kind import Pilot
from rolling.kinds.needed_marches import March
from rolling.scene.scene import Scene
from rolling.scene.surfaces import HeightFile
from rolling.scene.values_in_si import AUTO_NODES

STEPS = 1000  # of a pilot, or more where these are few lengths of the contact
CONTACT_LENGTHS = 10  # of a pilot, at least
LEAST_RATIO = 5  # of the track over that of its pilot; a shorter one is soon solved itself


def pilot_of(scene: Scene) -> Pilot | None:
    """Return the pilot of a scene without a sweep; None where a short track tells nothing of it.

    Random heights depend on the length of their surface, so the pilot has a surface of its own. A
    file, a single fault, a changing speed and the turn of a ball with a surface have no short track
    that is like the long one.
    """
    track = scene.track
    is_alike = (
        not isinstance(scene.surface, HeightFile)
        and bool(scene.laws)
        and track.closed
        and scene.keeps_its_load
        and scene.motion.is_constant(scene.duration)
        and scene.sphere.surface is None
        and not scene.surface.faults
        and not scene.is_permanent
        and len(scene.plate.contact_ends_mm) < 2
    )
    if not is_alike:
        return None
    contact = 2 * cost.overlap_radius(scene, cost.roughness(scene)[0])
    nodes = max(STEPS * scene.step_nodes, CONTACT_LENGTHS * contact / scene.spacing)
    nodes = AUTO_NODES * math.ceil(nodes / AUTO_NODES)
    if track.n_along < LEAST_RATIO * nodes:
        return None
    short = scene.with_(
        {
            "rolling.duration_s": None,
            "rolling.distance_mm": float(f"{1e3 * nodes * scene.spacing:.12g}"),
            "numerics.error_estimate": False,
            "sound.listen_s": None,
            "sound.loudness": False,
        }
    )
    march = March(short, is_shared=False)
    return Pilot(scene=short, marches=[march], words=f"{short.track.steps:,} steps")
