"""Values of a drawing of a ball on a plate, and scenes whose track and steps no change moves.

A number is changed by a tenth, a ball to the next grade, a skewness by 0.1. The track keeps its
length, so that a change of the speed meets the same surface.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from rolling.ball_kinds.ball_candidates import (
    LOSS_KEY,
    BallCandidate,
    candidate,
    with_steps_shared_by,
)
from rolling.choice.drawing import (
    AS_IT_IS,
    DISTANCE,
    LeftOut,
    WantedValue,
    Words,
    grade_of,
    orders_of,
    plain,
    tenth_of,
)
from rolling.results import labels
from rolling.scene.messages import is_number
from rolling.scene.scene import Scene
from rolling.scene.surfaces import GRADES, HeightFile

SKEWNESS_STEP = 0.1
GRADE = "sphere.surface.grade"
WAVINESS = "sphere.surface.waviness"
SPEED = "rolling.speed_m_s"

# Keys that are changed by a tenth, in the order of the scene file.
TENTHS = {
    "sphere.radius_mm": Words("larger sphere radius", "smaller sphere radius"),
    "sphere.radius_across_mm": Words("larger radius across", "smaller radius across"),
    "sphere.surface.roughness_ra_um": Words("rougher sphere", "smoother sphere"),
    "sphere.surface.correlation_length_um": Words(
        "longer correlation length of the sphere", "shorter correlation length of the sphere"
    ),
    "plate.thickness_mm": Words("thicker plate", "thinner plate"),
    "plate.loss_factor": Words("larger loss factor", "smaller loss factor"),
    LOSS_KEY: Words("larger loss factor of the contact", "smaller loss factor of the contact"),
    "plate.hardness_gpa": Words("harder plate", "softer plate"),
    "plate.yield_strength_gpa": Words("stronger plate", "weaker plate"),
    "surface.roughness_ra_um": Words("larger Ra", "smaller Ra"),
    "surface.rq_um": Words("larger Sq", "smaller Sq"),
    "surface.rdq": Words("larger Sdq", "smaller Sdq"),
    "surface.correlation_length_um": Words(
        "longer correlation length", "shorter correlation length"
    ),
    "surface.correlation_length_across_um": Words(
        "longer correlation length across", "shorter correlation length across"
    ),
    "surface.rolloff_um": Words("longer roll-off", "shorter roll-off"),
    "surface.shortest_um": Words("longer shortest wave", "shorter shortest wave"),
    "rolling.load_n": Words("larger load", "smaller load"),
    SPEED: Words("higher speed", "lower speed"),
    DISTANCE: Words("larger distance of the listener", "smaller distance of the listener"),
}
SKEWNESSES = ("surface.skewness", "sphere.surface.skewness")


def unchanged(scene: Scene) -> BallCandidate:
    """Return the candidate of a scene without a sweep, with a track and steps that no change moves.

    Other steps would pass for another sound.
    """
    own = with_free_steps(scene)
    return with_steps_shared_by(own, [own])


def with_free_steps(scene: Scene) -> BallCandidate:
    """Return the candidate of a scene without a sweep, with a track that no change moves."""
    return candidate(AS_IT_IS, with_kept_track(scene))


def with_kept_track(scene: Scene) -> Scene:
    """Return a scene whose track has a length in place of a duration."""
    rolling = scene.rolling
    is_file = isinstance(scene.surface, HeightFile)
    duration_s = rolling.stated_duration_s
    if rolling.stated_distance_mm is not None or (is_file and duration_s is None):
        return scene
    distance = scene.track.distance
    if is_file and duration_s is not None:
        distance = float(scene.motion.distance(duration_s))
    return scene.with_(
        {"rolling.duration_s": None, "rolling.distance_mm": float(f"{1e3 * distance:.12g}")}
    )


def with_value(base: BallCandidate, key: str, value: Any, label: str) -> BallCandidate:
    """Return a candidate with another value of one key.

    Raises
    ------
    SceneError : the value is not allowed.
    """
    loss_factors = base.loss_factors
    if key == LOSS_KEY:
        loss_factors = (float(value),)
    scene = base.scene.with_({key: value})
    return replace(base, label=label, scene=scene, loss_factors=loss_factors)


def values(scene: Scene) -> Iterator[WantedValue | LeftOut]:
    """Yield the values of a drawing that a scene has."""
    for key, words in TENTHS.items():
        name, _ = labels.named(key)
        value = labels.value_at(scene, key)
        if key == DISTANCE and scene.sound.listener_mm is not None:
            continue  # which places the listener
        if key == SPEED and isinstance(value, tuple):
            yield LeftOut(key, name, "the speed changes along the track")
        elif isinstance(value, tuple):
            yield LeftOut(key, name, "the loss factor changes with the frequency")
        elif key == "rolling.load_n" and not is_number(value):
            yield LeftOut(key, name, "the load is the weight of the sphere")
        elif is_number(value) and value > 0:
            yield tenth_of(key, value, words)
    for key in SKEWNESSES:
        value = labels.value_at(scene, key)
        if is_number(value):
            name, unit = labels.named(key)
            yield WantedValue(
                key=key,
                set_key=key,
                name=name,
                unit=unit,
                old=float(value),
                larger=plain(value + SKEWNESS_STEP),
                smaller=plain(value - SKEWNESS_STEP),
                step=f"{SKEWNESS_STEP:g}",
                words=Words(f"larger {name}", f"smaller {name}"),
            )
    grade = labels.value_at(scene, GRADE)
    if grade is not None:
        yield grade_of(GRADE, grade, [*GRADES], Words("coarser grade", "finer grade"))._replace(
            name="grade"
        )
    yield from orders_of(WAVINESS, labels.value_at(scene, WAVINESS) or {}, "")
