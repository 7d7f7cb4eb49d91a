"""Values of a drawing of a bearing: loads, clearance, conformity, grade, Ra and waves.

A number is changed by a tenth, balls to the next grade, a conformity by 0.005.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rolling.choice.drawing import (
    WantedValue,
    Words,
    grade_of,
    orders_of,
    plain,
    tenth_of,
)
from rolling.results.labels import value_at
from rolling.scene.bearing_scene import BearingScene
from rolling.scene.messages import is_number
from rolling.scene.surfaces import GRADES

CONFORMITY_STEP = 0.005
SURFACES = "bearing.surfaces"
BODIES = {"balls": "the balls", "inner": "the inner raceway", "outer": "the outer raceway"}


class _Named(NamedTuple):
    """A key that is changed by a tenth: its name, and what a larger or smaller value is called."""

    name: str
    words: Words


# Keys that are changed by a tenth, in the order of the scene file.
TENTHS = {
    "bearing.radial_clearance_um": _Named(
        "clearance", Words("larger clearance", "smaller clearance")
    ),
    "bearing.speed_rpm": _Named("speed", Words("higher speed", "lower speed")),
    "bearing.axial_load_n": _Named("axial load", Words("larger axial load", "smaller axial load")),
    "bearing.radial_load_n": _Named(
        "radial load", Words("larger radial load", "smaller radial load")
    ),
    "bearing.contact_loss_factor": _Named(
        "loss factor of the contacts",
        Words("larger loss factor of the contacts", "smaller loss factor of the contacts"),
    ),
    **{
        f"{SURFACES}.{body}.roughness_ra_um": _Named(
            f"Ra of {words}", Words(f"larger Ra of {words}", f"smaller Ra of {words}")
        )
        for body, words in BODIES.items()
    },
    **{
        f"{SURFACES}.{ring}.wave_amplitude_um": _Named(
            f"waves of {BODIES[ring]}",
            Words(f"higher waves of {BODIES[ring]}", f"lower waves of {BODIES[ring]}"),
        )
        for ring in ("inner", "outer")
    },
}


def values(scene: BearingScene) -> Iterator[WantedValue]:
    """Yield the values of a drawing that a bearing has."""
    for key, (name, words) in TENTHS.items():
        value = value_at(scene, key)
        if is_number(value) and value > 0:
            yield tenth_of(key, value, words)._replace(name=name)
    for ring in ("inner", "outer"):
        yield _conformity(scene, ring)
    for body, whose in BODIES.items():
        key = f"{SURFACES}.{body}.grade"
        grade = value_at(scene, key)
        if grade is not None:
            words = Words(f"coarser grade of {whose}", f"finer grade of {whose}")
            yield grade_of(key, grade, [*GRADES], words)._replace(name=f"grade of {whose}")
        orders = value_at(scene, f"{SURFACES}.{body}.waviness") or {}
        yield from orders_of(f"{SURFACES}.{body}.waviness", orders, f" of {whose}")


def _conformity(scene: BearingScene, ring: str) -> WantedValue:
    """Return the conformity of a ring, which is allowed from 0.5 to 0.6 only."""
    key = f"bearing.conformity_{ring}"
    value = value_at(scene, key)
    return WantedValue(
        key=key,
        set_key=key,
        name=f"{ring} conformity",
        unit="",
        old=float(value),
        larger=plain(value + CONFORMITY_STEP),
        smaller=plain(value - CONFORMITY_STEP),
        step=f"{CONFORMITY_STEP:g}",
        words=Words(f"wider {ring} groove", f"closer {ring} groove"),
    )
