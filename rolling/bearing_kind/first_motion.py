"""The pilot of a bearing: a short motion of its ring over rough contacts that are linear."""

from __future__ import annotations

from rolling.bearing_kind.contact_marches import march_of_contact
from rolling.bearing_kind.contact_plan import contact_plan
from rolling.kinds.kind import Pilot
from rolling.scene.bearing_scene import BearingScene

FIRST_S = 0.5  # of the motion of a pilot, or more where the cage turns slowly
CAGE_TURNS = 5  # in it, at least
LEAST_RATIO = 4  # of the motion of a run without marches over that of its pilot


def pilot_of(scene: BearingScene) -> Pilot | None:
    """Return the pilot of a scene without a sweep; None where the run is short itself.

    Faults are marched at one load, which takes a moment, because a contact is not linear over them.
    All else needs no march: rough contacts have their linear response.
    """
    moved_s = max(FIRST_S, CAGE_TURNS / abs(scene.kinematics.cage_hz))
    moved_s = min(float(f"{moved_s:.2g}"), scene.moved)
    faults, rough, rest = contact_plan(scene).stages
    if not rest and scene.moved < LEAST_RATIO * moved_s:
        return None
    short = scene.with_({"sound.duration_s": moved_s, "sound.listen_s": moved_s})
    words = f"{moved_s:g} s of motion"
    if rough:
        words += " over contacts that are linear"
    return Pilot(
        scene=short,
        marches=[march_of_contact(contact) for contact in faults],
        words=words,
        is_of_one_run=True,
    )
